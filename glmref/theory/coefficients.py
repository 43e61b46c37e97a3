"""Coefficients of series: numbers of any kind, or tuples of them, and what is done with them.

The ints 0 and 1 stand for numbers that are certain, and cost nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from ..exact import Exact, Scalar, sum_of_products
from ..exact.linalg import Vector

#: An int, a Fraction, a Scalar, or a tuple of them.
Coefficient = Any

_WHOLE = (int, Fraction)


def is_zero(value: Any) -> bool | None:
    """Decide whether a coefficient is zero: ``None`` where a ball contains zero."""
    if isinstance(value, tuple):
        answers = [is_zero(x) for x in value]
        return False if False in answers else (None if None in answers else True)
    return value == 0 if type(value) in _WHOLE else value.is_zero()


def plus(a: Coefficient, b: Coefficient) -> Coefficient:
    """Sum; an exact zero costs nothing."""
    if isinstance(a, tuple):
        return tuple([plus(x, y) for x, y in zip(a, b, strict=True)])
    if type(a) is int and a == 0:
        return b
    return a if type(b) is int and b == 0 else a + b


def times(factor: Any, a: Coefficient) -> Coefficient:
    """Return the product of a number and a coefficient; factors 0 and 1 cost nothing."""
    if isinstance(a, tuple):
        return tuple([times(factor, x) for x in a])
    if type(factor) in _WHOLE and (factor == 0 or factor == 1):
        return a if factor == 1 else 0
    if type(a) in _WHOLE and (a == 0 or a == 1):
        return factor if a == 1 else 0
    return factor * a


def combination(terms: Sequence[tuple[Scalar, Coefficient]]) -> Coefficient:
    """Return the sum of ``factor * coefficient`` over the terms.

    Vectors are combined entry by entry; the int 0 costs nothing.
    """
    if terms and isinstance(terms[0][1], tuple):
        factors = [factor for factor, _ in terms]
        columns = zip(*[x for _, x in terms], strict=True)
        return tuple([combination(list(zip(factors, x, strict=True))) for x in columns])
    pairs = [(x, y) for x, y in terms if type(y) is not int or y != 0]
    return sum_of_products(pairs) if pairs else 0


def tidy(vector: Sequence[Any]) -> tuple[Any, ...]:
    """Replace exact zeros by the int 0, which costs nothing from then on."""
    return tuple([0 if is_zero(x) is True else x for x in vector])


def scalars(vector: Sequence[Any]) -> Vector:
    """Return the entries as numbers of the exact field or balls."""
    return tuple([Exact(x) if isinstance(x, int | Fraction) else x for x in vector])


def first_nonzero(residual: Sequence[Any]) -> Scalar:
    """Return the residual of a tree as one number: the first entry that is certainly not zero.

    Where there is none, the first that may be different from zero.
    """
    chosen = next((x for x in residual if is_zero(x) is False), None)
    if chosen is None:
        chosen = next((x for x in residual if is_zero(x) is not True), 0)
    return scalars([chosen])[0]


def difference(x: Sequence[Any], y: Sequence[Any]) -> Vector:
    """Return x - y."""
    return scalars([plus(a, times(-1, b)) for a, b in zip(x, y, strict=True)])
