"""Numbers rounded to decimals."""

from __future__ import annotations

from decimal import ROUND_HALF_EVEN, Context, Decimal
from fractions import Fraction
from typing import Any

from .number import Exact


def rounded_decimal(x: Any, digits: int, rounding: str = ROUND_HALF_EVEN) -> Decimal:
    """Round a real number to significant digits.

    Parameters
    ----------
    x : Exact or Ball or int or Fraction
        What is rational is rounded as it is, anything else from its ball.
    digits : int
        Significant digits.
    rounding : str
        A mode of :mod:`decimal` for what is rational, by default ties to even.

    >>> rounded_decimal(Fraction(2, 3), 5)
    Decimal('0.66667')
    """
    value = x.as_fraction() if isinstance(x, Exact) else x
    if isinstance(value, int | Fraction):
        context = Context(prec=digits, rounding=rounding)
        return context.divide(Decimal(value.numerator), Decimal(value.denominator))
    return Decimal(x.ball().decimal_text(digits))
