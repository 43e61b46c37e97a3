"""Numbers of the vector files: exact decimals in, decimals of a given length out."""

from __future__ import annotations

from decimal import Context
from fractions import Fraction
from typing import Any

from ..exact import Ball, Exact, rounded_decimal


def fraction_of(x: Any) -> Fraction:
    """Return the exact value of an mpmath number, or of anything a Fraction takes."""
    if isinstance(x, int | str | Fraction | float):
        return Fraction(x)
    sign, mantissa, exponent, _ = x._mpf_
    value = Fraction(int(mantissa)) * Fraction(2) ** int(exponent)
    return -value if sign else value


def decimal_text(x: Any, digits: int) -> str:
    """Round to significant digits, ties to even, and write as a plain decimal or with an exponent.

    >>> decimal_text(Fraction(2, 3), 5), decimal_text(Fraction(1, 8), 5), decimal_text(0, 5)
    ('0.66667', '0.125', '0')
    >>> decimal_text(Fraction(-1, 3 * 10**8), 4)
    '-3.333e-9'
    """
    number = x if isinstance(x, Exact | Ball) else fraction_of(x)
    value = rounded_decimal(number, digits).normalize(Context(prec=digits))
    if -6 <= value.adjusted() < digits or not value:
        return f"{value:f}"
    return f"{value:e}".replace("e+", "e")


def exact_decimal(x: Fraction) -> str:
    """Write a fraction whose decimal ends, such as a dyadic one, in full."""
    places = 0
    while (x * 10**places).denominator != 1:
        places += 1
    text = decimal_text(x, max(1, len(str(abs((x * 10**places).numerator)))))
    assert Fraction(text) == x
    return text


def decimals(array: Any, digits: int) -> list[Any]:
    """Write an array of any depth."""
    return [
        decimals(x, digits) if hasattr(x, "__len__") else decimal_text(x, digits) for x in array
    ]


def upper_text(x: Any, digits: int = 2) -> str:
    """Return a decimal of so many digits that is not below a positive number.

    It may be a few units above the smallest one: what is rounded down first is raised by a unit of
    its leading digit. The bounds of the vector files are written by this rule.
    """
    value = fraction_of(x)
    if value == 0:
        return "0"
    text = decimal_text(value, digits)
    while Fraction(text) < value:
        first = Fraction(text)
        step = Fraction(decimal_text(first, 1)) / 10**digits
        text = decimal_text(first + step, digits)
        if Fraction(text) == first:
            text = decimal_text(first + 10 * step, digits)
    return text
