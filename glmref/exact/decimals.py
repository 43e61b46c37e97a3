"""Numbers rounded to decimals."""

from __future__ import annotations

from decimal import Context, Decimal
from fractions import Fraction
from typing import Any

from .number import Exact

__all__ = ["rounded_decimal"]


def rounded_decimal(x: Any, digits: int) -> Decimal:
    """Round a real number to significant digits, ties to even.

    Parameters
    ----------
    x : Exact or Ball or int or Fraction
        What is rational is rounded as it is, anything else from its ball.
    digits : int
        Significant digits.

    >>> rounded_decimal(Fraction(2, 3), 5)
    Decimal('0.66667')
    """
    value = x.as_fraction() if isinstance(x, Exact) else x
    if isinstance(value, int | Fraction):
        return Context(prec=digits).divide(Decimal(value.numerator), Decimal(value.denominator))
    return Decimal(x.ball().decimal_text(digits))
