"""Entries of tableaux as they come, written as text: numbers of Python, numpy, mpmath, sympy."""

from __future__ import annotations

import re
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from typing import Any

from ..errors import DataError
from ..exact import Ball, Exact, Scalar
from ..exact.expression import MAX_BITS, MAX_DEPTH, MAX_LENGTH, writable
from ..system.arguments import shown
from .strict_json import Double

_DECIMAL = re.compile(
    r"(?:\d+\.\d*|\.\d+|\d+(?=[eE]))(?:[eE][-+]?\d{1,3}(?!\d))?", re.ASCII
)  # of an entry whose length is known to be bounded
#: Powers of numbers of sympy that are written as products.
_POWER = 20
#: Of a Decimal, which would be written out.
_MOST_EXPONENT = 1000


def rational_text(text: str) -> str:
    """Write the decimals of an expression as the fractions that they are."""
    number = text.strip()
    if _DECIMAL.fullmatch(number.lstrip("-")) and not number.startswith("--"):
        return str(Fraction(number))
    return _DECIMAL.sub(lambda m: f"({Fraction(m[0])})", text)


def rounded_text(text: str, digits: int) -> str:
    """Write the decimals of an expression with at most two digits more than are known."""
    places = digits + 2

    def rounded(match: re.Match[str]) -> str:
        value = f"{round(Fraction(match[0]) * 10**places):0{places + 1}d}"
        return f"{value[:-places]}.{value[-places:]}"

    return _DECIMAL.sub(rounded, text)


def listed_out(value: Any) -> Any:
    """Return an array of numpy, or a matrix of sympy or mpmath, as lists; else the value itself."""
    return value.tolist() if hasattr(value, "tolist") else value


def _of_sympy(x: Any, depth: int = 0) -> str | None:
    """Return a number of sympy as an expression.

    ``None`` where it is none in real radicals, or long.
    """
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


def entry(x: Any, where: str, digits: int | None) -> str | Scalar:
    """Return an entry in the grammar of :mod:`glmref.exact.expression`.

    A float stands for the decimal as which it is printed. Without ``digits`` decimals are written
    as fractions; with them they stay decimals, known to that many digits after the point.

    Raises
    ------
    DataError
        For what is no number, naming the place.
    """
    if isinstance(x, Exact | Ball):
        return x
    text = x if isinstance(x, str) else _text(x)
    if text is None:
        # an expression of sympy is not written: its terms may be shared, and be without end
        said = "" if getattr(x, "args", ()) else f"{shown(x, str)!r} "
        raise DataError(
            f"`{where}` is {said}of type {type(x).__name__}; write a number, a "
            f'fraction as "1/3", or an expression as "(3-sqrt(3))/6"'
        )
    if len(text) > MAX_LENGTH:
        raise DataError(f"`{where}` has {len(text)} characters and at most {MAX_LENGTH} are read")
    return rational_text(text) if digits is None else rounded_text(text, digits)


def _text(x: Any) -> str | None:
    """Return the text of a number, ``None`` where it is no number or too long."""
    module = type(x).__module__.partition(".")[0]
    if isinstance(x, bool) or type(x).__name__ in ("bool_", "bool"):
        return None
    if isinstance(x, int | Fraction) or (module == "numpy" and hasattr(x, "__index__")):
        value = x if isinstance(x, int | Fraction) else int(x)
        return str(value) if writable(value) else None
    if isinstance(x, Double):
        return _decimal(x.text.replace("_", ""))
    binary = getattr(x, "_mpf_", None)  # of mpmath and sympy: (sign, mantissa, exponent, bits)
    if binary is not None:
        _, man, power, _ = binary
        sound = not (not man and power) and abs(power) <= MAX_BITS and writable(int(man))
        return _decimal(str(x)) if sound else None
    if module == "sympy" and hasattr(x, "is_Rational"):
        return _of_sympy(x)
    if isinstance(x, Decimal | float) or (module == "numpy" and hasattr(x, "as_integer_ratio")):
        return _decimal(str(x))
    return None


def _decimal(text: str) -> str | None:
    """Return a decimal without its exponent, ``None`` for another text or one too long."""
    try:
        value = Decimal(text) if len(text) <= MAX_LENGTH else None
    except InvalidOperation:
        return None
    if value is None or not value.is_finite() or abs(value.adjusted()) >= _MOST_EXPONENT:
        return None
    return format(value, "f")
