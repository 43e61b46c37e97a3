"""Python functions that users give: called on copies, and what they return is looked at.

A right-hand side may compute in place, return the same array every time, return 32-bit numbers,
raise, or return what is no state. A :class:`UserFunction` keeps the arguments of the caller, gives
every caller numbers of its own, and turns what cannot be used into one sentence.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ..errors import UsageError
from ..system.arguments import shown

_SHOWN = 4  # components of a state that a message shows


class FunctionFailed(UsageError):
    """A function given by the user raised, or returned what is not of its type and shape."""


class NoValue(FunctionFailed, ValueError):
    """A function given by the user raised an arithmetic or value error: it has no value there."""


def _place(arguments: tuple[Any, ...]) -> str:
    """Return where a function was called, for a message."""
    *times, last = arguments
    shown = ", ".join(_digits(x) for x in np.asarray(last).ravel()[:_SHOWN])
    dots = ", ..." if np.size(last) > _SHOWN else ""
    time = f"t = {_digits(times[0])}, " if times else ""
    return f"{time}({shown}{dots})"


def _digits(x: Any) -> str:
    """Return six digits of a number, real or complex, in doubles or of an mpmath context."""
    return f"{complex(x) if np.iscomplexobj(x) else float(x):.6g}"


def _sentence(error: BaseException) -> str:
    """Return the type and message of an exception in one line of moderate length."""
    text = shown(error, str, 200)
    name = type(error).__name__
    return f"{name}: {text}" if text else name


def raised(name: str, error: BaseException, arguments: tuple[Any, ...] = ()) -> FunctionFailed:
    """Return what stands for an exception that a user's function raised.

    That is :class:`NoValue` for an arithmetic or value error.
    """
    at = f" at {_place(arguments)}" if arguments else ""
    kind = NoValue if isinstance(error, ArithmeticError | ValueError) else FunctionFailed
    return kind(f"`{name}` raised {_sentence(error)}{at}")


def _kind(found: Any) -> str:
    """Return what a result is, for a message: the shape of an array, else the type."""
    if found is None:
        return "None"
    if hasattr(found, "__next__"):
        return "an iterator, which can be read only once"
    if isinstance(found, str | bytes | dict | set | frozenset):
        return f"a {type(found).__name__}"
    if hasattr(found, "__await__"):
        return "a coroutine"
    try:
        return str(np.shape(found))
    except Exception:
        return "rows of different lengths"


@dataclass(frozen=True, eq=False)
class UserFunction:
    """A Python function of a problem, protected in both directions."""

    function: Callable[..., Any]  #: As the user gave it.
    name: str  #: What the problem calls it: ``"f"``, ``"dp"``, ``"jacobian"``...
    size: int  #: Length of the state it is called with.
    shape: tuple[int, ...]  #: Shape of its result for one state.
    #: The mpmath context it is evaluated in, ``None`` in double precision.
    context: Any = field(default=None, repr=False)

    @property
    def __name__(self) -> str:  # type: ignore[override]
        """Name of the user's function."""
        return str(getattr(self.function, "__name__", self.function))

    def __call__(self, *arguments: Any) -> Any:
        """Return value at a state (size,), or at states in columns (size, m), one after the other.

        Raises
        ------
        NoValue
            When the function raises an arithmetic or value error.
        FunctionFailed
            When it raises anything else, or returns what is not real numbers (complex ones for a
            complex state) of :attr:`shape`.
        """
        *times, last = arguments
        state = np.array(last)
        if state.ndim == 2:
            columns = [self(*times, column) for column in state.T]
            return np.stack(columns, axis=-1) if columns else np.zeros((*self.shape, 0))
        if state.dtype.kind not in "fcO":
            state = state.astype(float)
        return self._numbers(self.raw(*times, state), state)

    def examined(self, *arguments: Any) -> tuple[Any, set[np.dtype[Any]]]:
        """Return the value at one state, and the types of numbers the function returned.

        Whole numbers in a list are meant as they are; an array of them has lost its fractions.
        """
        *times, last = arguments
        state = np.array(last)
        found = self.raw(*times, state.copy())
        value = self._numbers(found, state)
        if isinstance(found, list | tuple):
            kinds = {np.dtype(x.dtype) for x in found if isinstance(x, np.generic | np.ndarray)}
            kinds = {k for k in kinds if k.kind not in "iub"}
        else:
            kinds = {found.dtype if hasattr(found, "dtype") else np.asarray(found).dtype}
        return value, {k for k in kinds if isinstance(k, np.dtype)}

    def listed(self, *arguments: Any) -> list[float]:
        """Return the value as a list of Python numbers, the fastest input of plain Python."""
        return self(*arguments).tolist()

    def raw(self, *arguments: Any) -> Any:
        """Return what the function itself returns for these very arguments."""
        try:
            return self.function(*arguments)
        except FunctionFailed:  # of a function that this one calls
            raise
        # the last two would end a run, or what steps it, as if it were done
        except (Exception, SystemExit, GeneratorExit) as error:
            if self.context is not None and isinstance(error, TypeError | AttributeError):
                raise UsageError(
                    f"{self.__name__} works in double precision only ({error}); give it as "
                    f"expressions for extended precision"
                ) from None
            raise raised(self.name, error, arguments) from error

    def _numbers(self, found: Any, state: np.ndarray) -> Any:
        kind = state.dtype
        try:
            array = np.array(found, dtype=object if kind.kind == "O" else None)
        except ValueError:
            array = np.empty(0, dtype=object)
        except Exception as error:  # of a class of the user that numpy asks for an array
            raise raised(self.name, error) from error
        if array.shape != self.shape or isinstance(found, str | bytes):
            raise FunctionFailed(
                f"`{self.name}` must return shape {self.shape}, got {_kind(found)}"
            )
        if isinstance(found, np.ma.MaskedArray) and found.mask.any():  # the array has lost its mask
            raise FunctionFailed(f"`{self.name}` must return numbers, got masked entries")
        letter = array.dtype.kind
        if kind.kind == "O":
            array = self._converted(array)
            letter = "c" if any(hasattr(x, "_mpc_") for x in array.ravel()) else "O"
            if letter == "O" or any(hasattr(x, "_mpc_") for x in state.ravel()):
                return array if self.shape else array[()]
        elif letter == "c" and kind.kind == "c":
            return array if self.shape else array[()]
        if letter == "c":
            raise FunctionFailed(
                f"`{self.name}` must return real numbers for a real state, got complex ones"
            )
        if letter not in "fiubO":
            raise FunctionFailed(f"`{self.name}` must return numbers, got {array.dtype}")
        try:
            if letter == "O":  # entry by entry: numpy takes None for NaN
                entries = [float(x) for x in array.ravel()]
                array = np.array(entries).reshape(self.shape)
            result = array.astype(complex if kind.kind == "c" else float, copy=False)
        except (TypeError, ValueError, OverflowError):
            raise FunctionFailed(
                f"`{self.name}` must return real numbers, got {_entry(array)}"
            ) from None
        except Exception as error:  # of a class of the user
            raise raised(self.name, error) from error
        return result if self.shape else result[()]

    def _converted(self, array: np.ndarray) -> np.ndarray:
        """Return entries as numbers of the context: text and what else it would take are none."""
        convert = getattr(self.context, "convert", None)
        if convert is None:  # what is recorded or expanded is no number
            return array
        out = np.empty(array.shape, dtype=object)
        for place, x in np.ndenumerate(array):
            try:
                if isinstance(x, str | bytes):
                    raise TypeError
                out[place] = convert(x)
            except Exception:
                raise FunctionFailed(
                    f"`{self.name}` must return numbers, got an entry {type(x).__name__}"
                ) from None
        return out

    def in_context(self, context: Any) -> UserFunction:
        """Return the same function for states of numbers of an mpmath context."""
        return replace(self, context=context)


def _entry(array: np.ndarray) -> str:
    """Return the first entry of an array of objects that is no number, for a message."""
    for x in array.ravel():
        try:
            float(x)
        except Exception:
            return f"an entry {shown(x)}"
    return "other objects"


def plain(function: Any) -> Any:
    """Return a function as the user gave it."""
    return function.function if isinstance(function, UserFunction) else function
