"""What every method does for its owner: one line of text, a tableau in a notebook, a file."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, ClassVar, Protocol

from ..errors import DataError
from ..exact import Exact, Scalar, exact
from ..system.arguments import shown
from ..system.shown import Shown, above


class Array(Protocol):
    """An array of numpy, or of any library that gives nested lists by ``tolist``."""

    def tolist(self) -> Any:
        """Return nested lists of Python numbers."""
        ...


def as_list(values: Any) -> Any:
    """Return the nested list that an array stands for; anything else as it is."""
    return values.tolist() if hasattr(values, "tolist") else values


def of_float(value: float | complex, where: str) -> Scalar:
    """Read a floating point number as the shortest decimal that stands for it: 0.1 is 1/10.

    One that is a small fraction, rounded, is taken as it is too, and a warning says so: conditions
    of order hold to rounding only then.

    Raises
    ------
    DataError
        Where it is not finite.
    """
    if isinstance(value, complex):
        return of_float(value.real, where) + Exact(-1).sqrt() * of_float(value.imag, where)
    if value - value != 0:
        raise DataError(f"{where} must be finite, got {shown(value)}")
    given = Fraction(repr(float(value)))
    near = given.limit_denominator(_SMALL)
    if given != near and float(near) == value:
        warnings.warn(
            f"{where} is taken as the decimal {float(value)!r}, with which conditions of order "
            f"hold to rounding only; where {near} is meant, give the string '{near}'",
            stacklevel=_depth(),
        )
    return exact(given)


_SMALL = 10_000  # denominators of fractions that a rounded number may stand for


def _depth() -> int:
    """Return how many calls up the first one is that is no code of this package, for a warning."""
    package = __name__.partition(".")[0]
    depth, frame = 1, sys._getframe(1)
    while frame.f_back is not None and frame.f_globals["__name__"].partition(".")[0] == package:
        depth, frame = depth + 1, frame.f_back
    return depth


class Own(Shown):
    """Base of the methods."""

    __slots__ = ()
    name: str
    #: Attributes that say how large it is, in the order of the line.
    SIZES: ClassVar[Sequence[str]] = ()

    def __repr__(self) -> str:
        sizes = ", ".join(f"{x} = {getattr(self, x)}" for x in self.SIZES)
        return f"<{type(self).__name__} {self.name or '(unnamed)'}: {sizes}>"

    def save(self, path: str | Path, *, digits: int | None = None) -> Path:
        """Write the method as a file that every command reads.

        Parameters
        ----------
        path : str or Path
            Such as ``"mine.json"``; its stem becomes the name of a method that has none.
        digits : int, optional
            Digits after the point, instead of exact expressions.

        Raises
        ------
        UsageError
            Where the file cannot be written.
        """
        return above("exchange.export", "save")(self, path, digits=digits)
