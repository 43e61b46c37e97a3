"""What every method does for its owner: one line of text, a tableau in a notebook, a file."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

from ..errors import DataError
from ..exact import Exact, Scalar, exact
from ..system.shown import Shown, above

__all__ = ["Array", "Own", "as_list", "of_float"]


class Array(Protocol):
    """An array of numpy, or of whoever gives nested lists by ``tolist``."""

    def tolist(self) -> Any:
        """Nested lists of Python numbers."""
        ...


def as_list(values: Any) -> Any:
    """Return the nested list that an array stands for; anything else as it is."""
    return values.tolist() if hasattr(values, "tolist") else values


def of_float(value: float | complex, where: str) -> Scalar:
    """Read a floating point number as the shortest decimal that stands for it: 0.1 is 1/10.

    Raises
    ------
    DataError
        Where it is not finite.
    """
    if isinstance(value, complex):
        return of_float(value.real, where) + Exact(-1).sqrt() * of_float(value.imag, where)
    if value - value != 0:
        raise DataError(f"{where} must be finite, got {value!r}")
    return exact(Fraction(repr(value)))


class Own(Shown):
    """Base of the methods."""

    __slots__ = ()
    name: str
    #: Attributes that say how large it is, in the order of the line.
    SIZES: Sequence[str] = ()

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

        Returns
        -------
        Path
            The file.

        Raises
        ------
        UsageError
            Where the file cannot be written.
        """
        return above("exchange.export", "save")(self, path, digits=digits)
