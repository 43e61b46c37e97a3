"""What the step forms need of a tableau: enclosed entries, and weights of interpolation."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import lcm, prod

from ..exact import ball, exact
from ..exact.linalg import Matrix


def as_balls(matrix: Matrix) -> Matrix:
    """Enclose every entry; exact zeros stay exact, so that patterns survive."""
    return tuple(tuple(exact(0) if x.is_zero() is True else ball(x) for x in row) for row in matrix)


def lagrange_weights(nodes: Sequence[Fraction], at: Fraction) -> tuple[Fraction, ...]:
    """Return weights that carry a polynomial from values at distinct ``nodes`` to ``at``."""
    # whole numbers, reduced once at the end: dozens of binary fractions have long denominators
    scale = lcm(at.denominator, *(x.denominator for x in nodes))
    whole = [x.numerator * (scale // x.denominator) for x in (*nodes, at)]
    *places, place = whole
    return tuple(
        Fraction(
            prod(place - y for j, y in enumerate(places) if j != i),
            prod(x - y for j, y in enumerate(places) if j != i),
        )
        for i, x in enumerate(places)
    )
