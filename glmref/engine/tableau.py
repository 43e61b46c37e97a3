"""What the step forms need of a tableau: enclosed entries, and weights of interpolation."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from ..exact import ball, exact
from ..exact.linalg import Matrix

__all__ = ["as_balls", "lagrange_weights"]


def as_balls(matrix: Matrix) -> Matrix:
    """Enclose every entry; exact zeros stay exact, so that patterns survive."""
    return tuple(tuple(exact(0) if x.is_zero() is True else ball(x) for x in row) for row in matrix)


def lagrange_weights(nodes: Sequence[Fraction], at: Fraction) -> tuple[Fraction, ...]:
    """Weights that carry a polynomial from its values at distinct ``nodes`` to the point ``at``."""
    weights = []
    for i, x in enumerate(nodes):
        weight = Fraction(1)
        for j, y in enumerate(nodes):
            if j != i:
                weight *= (at - y) / (x - y)
        weights.append(weight)
    return tuple(weights)
