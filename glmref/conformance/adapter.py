"""What the suite asks of an integrator, how an adapter is found, and what its answers must be.

An adapter is any object with ``methods`` and ``step`` or ``solve``; see :class:`Adapter`. The
smallest one that passes::

    class Adapter:
        methods = ("rk4",)

        def step(self, method, problem, t, y, h):
            f = problem.f
            k1 = f(t, y)
            k2 = f(t + h / 2, y + h / 2 * k1)
            k3 = f(t + h / 2, y + h / 2 * k2)
            k4 = f(t + h, y + h * k3)
            return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import TYPE_CHECKING, Any, Protocol

from ..claims import GlmrefError, UsageError

if TYPE_CHECKING:
    import numpy as np

    from ..problems import Problem

__all__ = ["SHIPPED", "Adapter", "AdapterError", "NotOffered", "Subject", "load_adapter"]

#: Adapters that come with the package; each imports its library when it is asked for.
SHIPPED: Mapping[str, str] = {
    "reference": "glmref.conformance.adapters.reference:Adapter",
    "compiled": "glmref.conformance.adapters.compiled:Adapter",
    "scipy": "glmref.conformance.adapters.scipy_steps:Adapter",
    "diffrax": "glmref.conformance.adapters.diffrax_steps:Adapter",
    "heyoka": "glmref.conformance.adapters.heyoka_taylor:Adapter",
    "rebound": "glmref.conformance.adapters.rebound_leapfrog:Adapter",
    "nodepy": "glmref.conformance.adapters.nodepy_explicit:Adapter",
}

OPERATIONS = ("step", "stages", "start", "finish", "solve")
#: Claims that an integrator outside the catalogue may make; ``values`` says how many it carries.
CLAIMS = ("order", "symmetric", "symplectic", "values")


class AdapterError(GlmrefError):
    """An adapter's answer that cannot be used: it raised, or the shape or a number is wrong."""


class NotOffered(GlmrefError):
    """What the adapter says it cannot do (``NotImplementedError``): not judged."""


class Adapter(Protocol):
    """An integrator under test. Only ``methods`` and one of ``step`` and ``solve`` are required.

    Everywhere ``method`` is a name out of ``methods`` and ``problem`` a
    :class:`glmref.Problem`: ``problem.f(t, y)`` is the right-hand side, shape (d,) in and out,
    ``problem.jacobian(t, y)`` its derivative, ``problem.y0`` and ``problem.t_span[0]`` where
    ``solve`` and ``start`` begin. Where ``problem.separable``, y = (q, p) with ``problem.dq(p)``
    and ``problem.dp(q)`` the two halves of f, and d is even.

    ``y`` is the array of the values carried, in the basis of the method's data file: (r, d), or
    (d,) for a method that carries one value. It must not be changed.

    Attributes
    ----------
        methods: names of ``glmref list`` (or paths of method files) this integrator claims to be;
            or a mapping ``name -> {"order": p, "symmetric": True, "symplectic": True}`` for one the
            catalogue lacks: then only these claims, if made, are measured.
        epsilon: unit round-off of the arithmetic; 2**-53 by default.
        tolerance: relative error with which stage equations are solved, or a mapping from methods
            to it; 1e-14 by default.
        problems: names of the only problems it can do; all by default.
        starts: ``"file"`` (the default) when ``solve`` starts as the method's data say, ``"own"``
            when it makes its own starting values, so that only the end of a run can be judged.
    """

    methods: Sequence[str] | Mapping[str, Mapping[str, object]]

    def step(self, method: str, problem: Problem, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Return the values after one step of size h, which may be negative."""
        ...

    def solve(self, method: str, problem: Problem, h: float, steps: int) -> np.ndarray:
        """Start at ``problem.y0``, take steps, finish each: shape (steps + 1, d) or (d,), the end.

        A method whose data give no starting method gets ``start``, the values (r, d), as a keyword.
        """
        ...

    def stages(
        self, method: str, problem: Problem, t: float, y: np.ndarray, h: float
    ) -> np.ndarray:
        """Optional: return the stage values (s, d) of a step; of a pair (Q, P), two arrays."""
        ...

    def start(self, method: str, problem: Problem, h: float) -> np.ndarray:
        """Optional: return the starting values (r, d) from ``problem.y0``."""
        ...

    def finish(
        self, method: str, problem: Problem, t: float, y: np.ndarray, h: float
    ) -> np.ndarray:
        """Optional: return the solution (d,) that belongs to the values."""
        ...


def load_adapter(text: str) -> Any:
    """Find the adapter a user names.

    Args:
        text: ``package.module:Name`` (a class is called without arguments), the name of a shipped
            adapter, or ``cmd:program argument ...``.

    Raises
    ------
        UsageError: one sentence on what is wrong and what to do.
    """
    text = SHIPPED.get(text, text)
    if text.startswith("cmd:"):
        from .pipe import PipeAdapter

        return PipeAdapter(text.removeprefix("cmd:"))
    place, colon, name = text.partition(":")
    if not colon or not place or not name:
        raise UsageError(
            f"the adapter must be written package.module:Name, cmd:program, or one of "
            f"{', '.join(SHIPPED)}; got {text!r}"
        )
    if os.getcwd() not in sys.path:
        sys.path.insert(0, os.getcwd())  # plain pytest leaves it out
    try:
        value: Any = import_module(place)
    except Exception as error:
        raise UsageError(
            f"the adapter's module {place!r} cannot be imported ({_said(error)})"
        ) from None
    for part in name.split("."):
        if not hasattr(value, part):
            raise UsageError(f"the module {place!r} has no {name!r}; the adapter must be there")
        value = getattr(value, part)
    if isinstance(value, type) or (callable(value) and not hasattr(value, "methods")):
        try:
            value = value()
        except Exception as error:
            raise UsageError(
                f"the adapter {text!r} cannot be made without arguments ({_said(error)})"
            ) from None
    return value


def _said(error: BaseException) -> str:
    return f"{type(error).__name__}: {error}" if str(error) else type(error).__name__


class Subject:
    """An adapter with its answers checked.

    Args:
        adapter: an object as :class:`Adapter` says.
        name: what messages call it.

    Attributes
    ----------
        methods: name -> claims; claims are empty for a method of the catalogue.
        offers: the operations the adapter has.

    Raises
    ------
        UsageError: for an object that is no adapter.
    """

    def __init__(self, adapter: Any, name: str = "the adapter") -> None:
        self.adapter, self.name = adapter, name
        self.offers = frozenset(x for x in OPERATIONS if callable(getattr(adapter, x, None)))
        if not self.offers & {"step", "solve"}:
            raise UsageError(f"{name} must have a method `step` or `solve`; it has neither")
        self.methods = _methods(adapter, name)
        self.epsilon = self._number("epsilon", 2.0**-53)
        self._tolerance = getattr(adapter, "tolerance", 1e-14)
        for key in self.methods:
            self.tolerance(key)
        self.starts = getattr(adapter, "starts", "file")
        if self.starts not in ("file", "own"):
            raise UsageError(f"`starts` of {name} must be 'file' or 'own', got {self.starts!r}")
        problems = getattr(adapter, "problems", None)
        self.problems = None if problems is None else tuple(problems)

    def _number(self, key: str, default: float) -> float:
        return _small(getattr(self.adapter, key, default), key, self.name)

    def tolerance(self, method: str) -> float:
        """Relative error with which the adapter solves the stage equations of a method."""
        value = self._tolerance
        if isinstance(value, Mapping):
            value = value.get(method, 1e-14)
        return _small(value, "tolerance", self.name)

    def unit(self, method: str) -> float:
        """Relative error of one operation: rounding, and what is left of the stage equations."""
        return self.epsilon + self.tolerance(method)

    def close(self) -> None:
        """End what the adapter has running."""
        close = getattr(self.adapter, "close", None)
        if callable(close):
            close()

    def step(self, method: str, problem: Any, t: float, values: np.ndarray, h: float) -> np.ndarray:
        """Take one step; values (r, d) in and out."""
        given = values[0] if len(values) == 1 else values
        answer = self._call("step", method, problem, t, given.copy(), h)
        return _array(answer, values.shape, "step")

    def stages(
        self, method: str, problem: Any, t: float, values: np.ndarray, h: float,
        shape: tuple[tuple[int, int], ...],
    ) -> list[np.ndarray]:  # fmt: skip
        """Stage values: one array, or for a pair the two of Q and P."""
        given = values[0] if len(values) == 1 else values
        answer = self._call("stages", method, problem, t, given.copy(), h)
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
        """Starting values (r, d)."""
        return _array(self._call("start", method, problem, h), shape, "start")

    def finish(
        self, method: str, problem: Any, t: float, values: np.ndarray, h: float
    ) -> np.ndarray:
        """Solution (d,) that belongs to the values (r, d)."""
        given = values[0] if len(values) == 1 else values
        answer = self._call("finish", method, problem, t, given.copy(), h)
        return _array(answer, (values.shape[1],), "finish")

    def solve(
        self, method: str, problem: Any, h: float, steps: int, start: np.ndarray | None = None
    ) -> np.ndarray:
        """Solution at every step, (steps + 1, d), or the end alone, (1, d)."""
        import numpy as np

        keywords = {} if start is None else {"start": start.copy()}
        answer = self._call("solve", method, problem, h, steps, **keywords)
        d = problem.dimension
        found = _array(answer, None, "solve")
        if found.shape == (d,):
            return found[None, :]
        if found.ndim != 2 or found.shape[1] != d or len(found) not in (1, steps + 1):
            raise AdapterError(
                f"solve must return shape (steps + 1, d) = ({steps + 1}, {d}) or (d,), "
                f"got {found.shape}"
            )
        return np.asarray(found)

    def _call(self, operation: str, *arguments: Any, **keywords: Any) -> Any:
        function: Callable[..., Any] = getattr(self.adapter, operation)
        try:
            return function(*arguments, **keywords)
        except NotImplementedError as error:
            raise NotOffered(str(error) or f"the adapter does not offer {operation} here") from None
        except GlmrefError as error:
            raise AdapterError(f"{operation}: {error}") from None
        except Exception as error:
            raise AdapterError(f"{operation} raised {_said(error)}") from error


def _small(value: Any, key: str, name: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 0.1:
        raise UsageError(f"`{key}` of {name} must be a small number, got {value!r}")
    return float(value)


def _array(answer: Any, shape: tuple[int, ...] | None, operation: str) -> np.ndarray:
    """Check an answer's shape and numbers."""
    import numpy as np

    try:
        found = np.array(answer, dtype=float)
    except (TypeError, ValueError):
        raise AdapterError(
            f"{operation} must return an array of real numbers, got {type(answer).__name__}"
        ) from None
    if shape is not None:
        if found.shape == shape[1:] and shape[0] == 1:
            found = found[None, :]
        if found.shape != shape:
            raise AdapterError(f"{operation} must return shape {shape}, got {found.shape}")
    if not all(math.isfinite(x) for x in found.ravel()):
        raise AdapterError(f"{operation} returned a number that is not finite")
    return found


def _methods(adapter: Any, name: str) -> dict[str, dict[str, Any]]:
    """Read ``methods``: catalogue names, paths, or name -> claims."""
    from ..catalogue import path_of

    given = getattr(adapter, "methods", None)
    if isinstance(given, str):
        given = (given,)
    if given is None or not isinstance(given, Mapping | Sequence) or not given:
        raise UsageError(f"`methods` of {name} must be the names of what it implements")
    methods: dict[str, dict[str, Any]] = {}
    for key in given:
        claims = given[key] if isinstance(given, Mapping) else None
        if not claims:
            path_of(key)
            methods[str(key)] = {}
            continue
        unknown = sorted(set(claims) - set(CLAIMS))
        if unknown:
            raise UsageError(
                f"{name} claims {unknown[0]!r} of {key}; known are {', '.join(CLAIMS)}"
            )
        methods[str(key)] = dict(claims)
    return methods
