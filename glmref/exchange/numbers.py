"""Coefficients as text: decimals of a chosen length, rounding residuals, exact expressions."""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction

from ..exact import Exact, Scalar, rounded_decimal
from ..method.rounding import CLOSE, as_double
from ..system.arguments import whole

#: Digits that a published decimal of the catalogue and a ball of working precision still have.
MOST_DIGITS = 150


def check_digits(digits: int | None) -> None:
    """Refuse a number of digits that no coefficient is written with.

    Raises
    ------
    UsageError
        When it is not a whole number from 1 to :data:`MOST_DIGITS`.
    """
    if digits is not None:
        whole("digits", digits, 1, MOST_DIGITS)


def is_zero(x: Scalar) -> bool:
    """Return whether a coefficient is zero, or as close to it as counts as zero."""
    return x.is_zero() is True or x.magnitude() < CLOSE


def decimal_of(x: Scalar, digits: int) -> str:
    """Round to so many significant digits; a whole number stays one.

    The decimal is such as ``-0.25``, or has an exponent, as ``1.5e-12``.
    """
    if is_zero(x):
        return "0"
    fraction = x.as_fraction() if isinstance(x, Exact) else None
    if fraction is not None and fraction.denominator == 1 and len(str(abs(fraction))) <= digits:
        return str(fraction)
    value = rounded_decimal(x, digits)
    if not -6 <= value.adjusted() <= 20:
        return f"{value:e}"
    return f"{value:f}"


def rounded(x: Scalar, digits: int | None) -> str:
    """Return a real coefficient of a source file with so many significant digits.

    ``None`` stands for the shortest decimal of the nearest double.
    """
    if is_zero(x):
        return "0.0"
    text = repr(as_double(x)) if digits is None else decimal_of(x, digits)
    return text if "." in text or "e" in text else f"{text}.0"


def lost(x: Scalar, text: str) -> float:
    """Return the rounding residual: coefficient minus the double a compiler makes of its text."""
    return 0.0 if is_zero(x) else float(x - Fraction(as_double(text)))


def worst(numbers: Iterable[Scalar], digits: int | None) -> float:
    """Return the largest difference between a coefficient and the double that is written for it."""
    return max((abs(lost(x, rounded(x, digits))) for x in numbers), default=0.0)
