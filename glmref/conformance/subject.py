"""An adapter with its attributes and its answers checked, so that the checks can rely on them."""

from __future__ import annotations

import inspect
import traceback
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import GlmrefError, UsageError
from ..system.arguments import one_of

if TYPE_CHECKING:
    import numpy as np

OPERATIONS = ("step", "stages", "start", "finish", "solve")
#: Claims that an integrator outside the catalogue may make; ``values`` says how many it carries.
CLAIMS = ("order", "symmetric", "symplectic", "abscissae", "values")
_HIGHEST_ORDER = 30
#: Folder of this package.
_PACKAGE = Path(__file__).parents[1]


class AdapterError(GlmrefError):
    """An adapter's answer that cannot be used: it raised, or the shape or a number is wrong."""


class NotOffered(GlmrefError):
    """What the adapter says it cannot do (``NotImplementedError``): not judged."""


class Subject:
    """An adapter with its answers checked, called ``name`` in messages.

    It has ``methods`` (name -> claims, which are empty for a method of the catalogue), the
    operations it ``offers``, and the only ``problems`` it can do, or ``None``.

    Raises
    ------
    UsageError
        For an object that is no adapter.
    """

    def __init__(self, adapter: Any, name: str = "the adapter") -> None:
        self.adapter, self.name = adapter, name
        try:
            self._read_attributes()
        except BaseException:
            self.close()  # a program that was started for it does not run on
            raise

    def _read_attributes(self) -> None:
        adapter, name = self.adapter, self.name
        self.offers = frozenset(x for x in OPERATIONS if callable(getattr(adapter, x, None)))
        if not self.offers & {"step", "solve"}:
            raise UsageError(f"{name} must have a method `step` or `solve`; it has neither")
        self.methods = _methods(adapter, name)
        self.epsilon = self._number("epsilon", 2.0**-53)
        self._tolerance = getattr(adapter, "tolerance", 1e-14)
        for key in self.methods:
            self.tolerance(key)
        self.starts = one_of("starts", getattr(adapter, "starts", "file"), ("file", "own"))
        self.problems = _problems(getattr(adapter, "problems", None), name)

    @property
    def takes_start(self) -> bool:
        """Whether ``solve`` can be given starting values."""
        try:
            known = inspect.signature(self.adapter.solve).parameters.values()
        except (AttributeError, TypeError, ValueError):  # written in C, for example
            return True
        return any(x.name == "start" or x.kind is x.VAR_KEYWORD for x in known)

    def _number(self, key: str, default: float) -> float:
        return _small(getattr(self.adapter, key, default), key, self.name)

    def tolerance(self, method: str) -> float:
        """Return relative error with which the adapter solves the stage equations of a method."""
        value = self._tolerance
        if isinstance(value, Mapping):
            value = value.get(method, 1e-14)
        return _small(value, "tolerance", self.name)

    def unit(self, method: str) -> float:
        """Return the relative error of an operation: rounding, and residuals of stage equations."""
        return self.epsilon + self.tolerance(method)

    def close(self) -> None:
        """End what the adapter has running."""
        close = getattr(self.adapter, "close", None)
        if callable(close):
            close()

    def step(self, method: str, problem: Any, t: float, values: np.ndarray, h: float) -> np.ndarray:
        """Take one step; values (r, d) in and out."""
        answer = self.call("step", method, problem, t, _given(values).copy(), h)
        return _array(answer, values.shape, "step")

    def leaves_input(
        self, method: str, problem: Any, t: float, values: np.ndarray, h: float
    ) -> bool:
        """Take a step and return whether the values it was given are what they were."""
        given = _given(values).copy()
        self.call("step", method, problem, t, given, h)
        return bool((given == _given(values)).all())

    def steps(
        self, method: str, problem: Any, t: float, values: np.ndarray, h: float, count: int
    ) -> Iterator[tuple[float, np.ndarray]]:
        """Yield time and values (r, d) at the start and after each of so many steps."""
        yield t, values
        for n in range(count):
            values = self.step(method, problem, t + n * h, values, h)
            yield t + (n + 1) * h, values

    def stages(
        self, method: str, problem: Any, t: float, values: np.ndarray, h: float,
        shape: tuple[tuple[int, int], ...],
    ) -> list[np.ndarray]:  # fmt: skip
        """Return stage values: one array, or for a pair the two of Q and P."""
        answer = self.call("stages", method, problem, t, _given(values).copy(), h)
        if len(shape) == 1:
            return [_array(answer, shape[0], "stages")]
        try:
            parts = tuple(answer)
        except TypeError:
            parts = ()
        if len(parts) != 2:
            raise AdapterError("stages of a pair must be two arrays, (Q, P)")
        return [_array(x, y, "stages") for x, y in zip(parts, shape, strict=True)]

    def start(self, method: str, problem: Any, h: float, shape: tuple[int, int]) -> np.ndarray:
        """Return starting values (r, d)."""
        return _array(self.call("start", method, problem, h), shape, "start")

    def finish(
        self, method: str, problem: Any, t: float, values: np.ndarray, h: float
    ) -> np.ndarray:
        """Return the solution (d,) that belongs to the values (r, d)."""
        answer = self.call("finish", method, problem, t, _given(values).copy(), h)
        return _array(answer, (values.shape[1],), "finish")

    def solve(
        self, method: str, problem: Any, h: float, steps: int, start: np.ndarray | None = None
    ) -> np.ndarray:
        """Return the solution at every step, (steps + 1, d), or the end alone, (1, d)."""
        keywords = {} if start is None else {"start": start.copy()}
        answer = self.call("solve", method, problem, h, steps, **keywords)
        d = problem.dimension
        found = _array(answer, None, "solve")
        if found.shape == (d,):
            return found[None, :]
        if found.ndim != 2 or found.shape[1] != d or len(found) not in (1, steps + 1):
            raise AdapterError(
                f"solve must return shape (steps + 1, d) = ({steps + 1}, {d}) or (d,), "
                f"got {found.shape}"
            )
        return found

    def call(self, operation: str, *arguments: Any, **keywords: Any) -> Any:
        """Call the adapter; what it raises becomes one sentence that says where."""
        function: Callable[..., Any] = getattr(self.adapter, operation)
        try:
            return function(*arguments, **keywords)
        except NotImplementedError as error:
            raise NotOffered(str(error) or f"the adapter does not offer {operation} here") from None
        except GlmrefError as error:
            raise AdapterError(f"{operation}: {error}") from None
        except (Exception, SystemExit) as error:
            raise AdapterError(f"{operation} raised {said(error)}{_place(error)}") from error


def said(error: BaseException) -> str:
    """Name and message of an exception."""
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


def _place(error: BaseException) -> str:
    """Return where it was raised: the innermost line not of this package or a library."""
    frames = traceback.extract_tb(error.__traceback__)[1:]
    own = [x for x in frames if not _is_foreign(Path(x.filename))]
    if not own:
        return ""
    return f" (line {own[-1].lineno} of {own[-1].filename.rpartition('/')[2]})"


def _is_foreign(file: Path) -> bool:
    """Return whether a file belongs to this package or to an installed library.

    The folders count and not the words in a path: a clone may have any name.
    """
    return file.is_relative_to(_PACKAGE) or not {"site-packages", "dist-packages"}.isdisjoint(
        file.parts
    )


def _given(values: np.ndarray) -> np.ndarray:
    """Return values as an adapter is given them: one value is a vector."""
    return values[0] if len(values) == 1 else values


# --- answers ------------------------------------------------------------------------------------


def _array(answer: Any, shape: tuple[int, ...] | None, operation: str) -> np.ndarray:
    """Check an answer's shape and numbers."""
    import numpy as np

    try:
        if answer is None:
            raise TypeError
        found = np.asarray(answer)
        # a complex number would lose its imaginary part without a word, a text become a number
        if found.dtype.kind in "cSU":
            raise TypeError
        found = np.array(found, dtype=float)
    except (TypeError, ValueError):
        kind = "None" if answer is None else type(answer).__name__
        if isinstance(answer, np.ndarray):
            kind += f" of {answer.dtype}"
        raise AdapterError(
            f"{operation} must return an array of real numbers, got {kind}"
        ) from None
    if shape is not None:
        if found.shape == shape[1:] and shape[0] == 1:
            found = found[None, :]
        if found.shape != shape:
            raise AdapterError(f"{operation} must return shape {shape}, got {found.shape}")
    if not np.isfinite(found).all():
        raise AdapterError(f"{operation} returned a number that is not finite")
    return found


# --- attributes ---------------------------------------------------------------------------------


def _small(value: Any, key: str, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 0.1:
        raise UsageError(f"`{key}` of {name} must be a small number, got {value!r}")
    return float(value)


def _problems(given: Any, name: str) -> tuple[str, ...] | None:
    """Read ``problems``: names of the problems of the vectors."""
    from .vector_problems import problems

    if given is None:
        return None
    wanted = (given,) if isinstance(given, str) else given
    known = problems()
    if not isinstance(wanted, Iterable):
        raise UsageError(f"`problems` of {name} must be a list of names, got {given!r}")
    wanted = tuple(wanted)
    unknown = [x for x in wanted if not isinstance(x, str) or x not in known]
    if unknown or not wanted:
        raise UsageError(f"`problems` of {name} must name some of {', '.join(known)}, got {given}")
    return wanted


def _methods(adapter: Any, name: str) -> dict[str, dict[str, Any]]:
    """Read ``methods``: catalogue names, paths, or name -> claims."""
    from ..catalogue.lookup import path_of

    given = getattr(adapter, "methods", None)
    if isinstance(given, str):
        given = (given,)
    if given is None or not isinstance(given, Mapping | Sequence) or not given:
        raise UsageError(
            f"`methods` of {name} must be the names of what it implements, got {given!r}"
        )
    methods: dict[str, dict[str, Any]] = {}
    for key in given:
        claims = given[key] if isinstance(given, Mapping) else None
        if not claims:
            path_of(str(key))
        methods[str(key)] = _claims(claims, str(key), name) if claims else {}
    return methods


def _claims(claims: Any, method: str, name: str) -> dict[str, Any]:
    """Check what an integrator outside the catalogue claims of itself."""
    if not isinstance(claims, Mapping):
        raise UsageError(
            f"the claims {name} makes of {method} must be a mapping such as "
            f"{{'order': 4}}, got {claims!r}"
        )
    for claim, value in claims.items():
        if claim not in CLAIMS:
            raise UsageError(f"{name} claims {claim!r} of {method}; known are {', '.join(CLAIMS)}")
        if claim in ("symmetric", "symplectic"):
            right, kind = isinstance(value, bool), "True or False"
        elif claim == "abscissae":
            right, kind = _are_numbers(value), "a list of numbers"
        else:
            right = type(value) is int and 1 <= value <= _HIGHEST_ORDER
            kind = f"a whole number from 1 to {_HIGHEST_ORDER}"
        if not right:
            raise UsageError(f"{name} claims {claim} {value!r} of {method}; it must be {kind}")
    return dict(claims)


def _are_numbers(value: Any) -> bool:
    """Return whether a value is a list of finite numbers, and not empty."""
    return (
        isinstance(value, Sequence)
        and len(value) > 0
        and all(type(x) in (int, float) and abs(x) < float("inf") for x in value)
    )
