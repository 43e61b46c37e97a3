"""Entries of tableaux as they come: Python, numpy, mpmath and sympy numbers, and text."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from itertools import islice
from math import isfinite
from typing import Any

from ..catalogue.keys import MAX_SIZE
from ..errors import DataError
from ..exact import Ball, Exact, Scalar
from ..exact.expression import MAX_BITS, MAX_DEPTH, MAX_LENGTH, parse, writable
from ..exact.linalg import Matrix, Vector
from ..system.arguments import listed, shown

_DECIMAL = re.compile(
    r"(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d{1,3}(?!\d))?", re.ASCII
)  # of an entry whose length is known to be bounded
#: Powers of numbers of sympy that are written as products.
_POWER = 20
#: Of a Decimal, which would be written out.
_MOST_EXPONENT = 1000
#: A double with a larger power of 2 below it is taken for a rounded number in a hint.
_DYADIC = 2**12


class Double(float):
    """A number with a point from JSON or TOML, which remembers how it was written."""

    text: str

    def __new__(cls, text: str) -> Double:
        """Read the text as Python does."""
        self = super().__new__(cls, text)
        self.text = text
        return self


def rational_text(text: str) -> str:
    """Write the decimals of an expression as the fractions that they are."""
    return _DECIMAL.sub(lambda m: f"({Fraction(m[0])})", text)


def _plain(value: Any) -> Any:
    """An array of numpy, or a matrix of sympy or mpmath, as lists; anything else as it is."""
    return value.tolist() if hasattr(value, "tolist") else value


def _of_sympy(x: Any, depth: int = 0) -> str | None:
    """A number of sympy as an expression; ``None`` where it is none in real radicals, or long."""
    text = None
    if depth > MAX_DEPTH:
        return None
    if x.is_Rational:
        text = f"({x})" if writable(Fraction(int(x.p), int(x.q))) else None
    elif x.is_Add or x.is_Mul:
        terms: list[str] = []
        for y in x.args:  # not beyond the first that is too long: terms may be shared
            term = _of_sympy(y, depth + 1)
            if term is None:
                return None
            terms.append(term)
        text = f"({('+' if x.is_Add else '*').join(terms)})"
    elif x.is_Pow and x.exp.is_Rational and abs(x.exp.p) <= _POWER:
        base = _of_sympy(x.base, depth + 1)
        if base is None or (x.exp.q > 1 and not x.base.is_nonnegative):
            return None
        root = base if x.exp.q == 1 else f"root({base}, {x.exp.q})"
        power = "*".join([root] * abs(x.exp.p))
        text = f"(1/({power}))" if x.exp.p < 0 else f"({power})"
    return text if text is not None and len(text) <= MAX_LENGTH else None


@dataclass
class Reader:
    """Reads entries, and remembers what has to be said of them."""

    #: Digits after the point to which decimals and floats are known; ``None`` where they are the
    #: numbers that they write.
    digits: int | None = None
    floats: int = 0  #: How many entries were binary numbers taken as they are.
    #: Of those that are near a short fraction, ``(place, number, fraction)``.
    hints: list[tuple[str, str, str]] = field(default_factory=list)

    def matrix(self, rows: Any, name: str) -> Matrix:
        """A square matrix."""
        rows = _plain(rows)
        if isinstance(rows, (int, float, str, Fraction)):
            rows = [[rows]]
        found = tuple(
            tuple(self.number(x, f"{name}[{i + 1}][{j + 1}]") for j, x in enumerate(row))
            for i, row in enumerate(self._rows(rows, name))
        )
        for i, row in enumerate(found):
            if len(row) != len(found):
                raise DataError(
                    f"`{name}` must be square, {len(found)} by {len(found)}: the length of row "
                    f"{i + 1} is {len(row)}"
                )
        return found

    def table(self, rows: Any, name: str, s: int) -> Matrix:
        """s rows of one length."""
        found = tuple(
            tuple(self.number(x, f"{name}[{i + 1}][{j + 1}]") for j, x in enumerate(row))
            for i, row in enumerate(self._rows(rows, name))
        )
        if len(found) != s or len({len(row) for row in found}) != 1 or not found[0]:
            raise DataError(f"`{name}` must have {s} rows of one length, a row for each stage")
        return found

    def vector(self, entries: Any, name: str, s: int) -> Vector:
        """A vector of s entries; a matrix with one row or one column stands for one."""
        entries = _plain(entries)
        if isinstance(entries, (int, float, str, Fraction)):
            entries = [entries]
        entries = [_plain(x) for x in self._list(entries, name)]
        rows = [list(x) for x in entries if isinstance(x, (list, tuple))]
        if rows and len(rows) == len(entries) and (len(rows) == 1 or {len(x) for x in rows} == {1}):
            entries = [x for row in rows for x in row]
        found = tuple(self.number(x, f"{name}[{i + 1}]") for i, x in enumerate(entries))
        if len(found) != s:
            raise DataError(
                f"`{name}` must have {s} entries, as `A` has {s} rows, got {len(found)}"
            )
        return found

    def _rows(self, rows: Any, name: str) -> list[list[Any]]:
        found = [
            self._list(row, f"{name}[{i + 1}]") for i, row in enumerate(self._list(rows, name))
        ]
        if not found:
            raise DataError(f"`{name}` is empty; give a row for each stage")
        return found

    @staticmethod
    def _list(value: Any, name: str) -> list[Any]:
        value = _plain(value)
        found = list(islice(listed(name, value, error=DataError), MAX_SIZE + 1))
        if len(found) > MAX_SIZE:
            raise DataError(f"`{name}` has more than {MAX_SIZE} entries")
        return found

    def number(self, x: Any, where: str) -> Scalar:
        """One entry."""
        module = type(x).__module__.partition(".")[0]
        binary = getattr(x, "_mpf_", None)  # of mpmath and sympy: (sign, mantissa, exponent, bits)
        if module == "numpy" and hasattr(x, "item"):
            x = x.item()
        if isinstance(x, (Exact, Ball)):
            return x
        if isinstance(x, (int, Fraction)) and not isinstance(x, bool):
            return Exact(x) if writable(x) else self._refuse(x, where)
        if isinstance(x, str):
            return self._text(x, where)
        if isinstance(x, Decimal):
            short = x.is_finite() and abs(x.adjusted()) < _MOST_EXPONENT
            return self._text(format(x, "f"), where) if short else self._refuse(x, where)
        if isinstance(x, float):
            return self._float(x, where)
        if binary is not None:
            sign, man, power, _ = binary
            if (not man and power) or abs(power) > MAX_BITS or not writable(int(man)):
                return self._refuse(x, where)
            return self._binary(Fraction(int(man)) * Fraction(2) ** power * (-1) ** sign, x, where)
        if module == "sympy" and hasattr(x, "is_Rational"):
            text = _of_sympy(x)
            return self._refuse(x, where) if text is None else self._text(text, where)
        ratio = hasattr(x, "as_integer_ratio") and not isinstance(x, bool)  # as a long double
        if ratio and isfinite(x):
            return self._binary(Fraction(*map(int, x.as_integer_ratio())), x, where)
        return self._refuse(x, where)

    @staticmethod
    def _refuse(x: Any, where: str) -> Scalar:
        # an expression of sympy is not written: its terms may be shared, and be without end
        text = "" if getattr(x, "args", ()) else f"{shown(x, str)!r} "
        raise DataError(
            f"`{where}` is {text}of type {type(x).__name__}; write a number, a "
            f'fraction as "1/3", or an expression as "(3-sqrt(3))/6"'
        )

    def _text(self, text: str, where: str) -> Scalar:
        if len(text) > MAX_LENGTH:
            raise DataError(
                f"`{where}` has {len(text)} characters and at most {MAX_LENGTH} are read"
            )
        try:
            if self.digits is None:
                return parse(rational_text(text))
            return parse(
                _DECIMAL.sub(lambda m: self._rounded(Fraction(m[0])), text), digits=self.digits
            )
        except DataError as error:
            raise DataError(f"`{where}`: {error}") from None

    def _rounded(self, x: Fraction) -> str:
        places = (self.digits or 0) + 2  # Python 3.11 does not format fractions
        text = f"{round(x * 10**places):0{places + 1}d}"
        return f"{text[:-places]}.{text[-places:]}"

    def _float(self, x: float, where: str) -> Scalar:
        if not isfinite(x):
            return self._refuse(x, where)
        if self.digits is not None:
            text = x.text.replace("_", "") if isinstance(x, Double) else repr(float(x))
            if len(text) > MAX_LENGTH or not _DECIMAL.fullmatch(text.lstrip("+-")):
                return self._refuse(x, where)
            return Ball.decimal(text, self.digits)
        return self._binary(Fraction(x), x, where)

    def _binary(self, value: Fraction, x: Any, where: str) -> Scalar:
        if not writable(value):
            return self._refuse(x, where)
        if self.digits is not None:
            return Ball.decimal(str(value), self.digits)
        self.floats += 1
        if value.denominator > _DYADIC:
            near = value.limit_denominator(10_000)
            close = abs(near - value) <= abs(value) / 10**14
            self.hints.append((where, str(x), str(near) if close else ""))
        return Exact(value)

    def remark(self) -> str:
        """What has to be said of the numbers, or ``""``."""
        if not self.floats:
            return ""
        plural = "number is" if self.floats == 1 else "numbers are"
        said = f"{self.floats} floating-point {plural} taken as the binary fraction that it is"
        if self.floats > 1:
            said = said.replace("fraction that it is", "fractions that they are")
        where = next((x for x in self.hints if x[2]), None)
        if where is not None:
            return f'{said}: `{where[0]}` is not {where[2]}; write "{where[2]}", or give `digits`'
        return f"{said}; give `digits` if they are rounded" if self.hints else said
