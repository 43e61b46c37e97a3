"""Error constants: residuals one order beyond as one number, and what no conjugation removes."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import sqrt
from typing import Any

from ..errors import UsageError
from ..exact import Scalar
from ..method.component import ROOTED
from .coefficients import plus, scalars, times
from .order import OrderResult
from .trees import Tree, pruned, trees


def error_norm(residuals: Mapping[Tree, Scalar]) -> float:
    """Return euclidean norm of ``residual / sigma`` over the trees of order p + 1.

    The local error is ``h^(p+1)`` times the sum of ``residual / sigma`` times the elementary
    differential, so this is the usual principal error norm (Hairer, Norsett, Wanner (1993), II.1).

    Parameters
    ----------
    residuals : Mapping[Tree, Scalar]
        Of an :class:`.order.OrderResult`, or of :func:`conjugate_error`.
    """
    sizes = [x.magnitude() / t.symmetry for t, x in residuals.items()]
    return sqrt(sum(x * x for x in sizes))  # a square that is beyond doubles is infinite


def conjugate_error(result: OrderResult) -> dict[Tree, Scalar]:
    """Return the residuals at order p + 1 for the principal parts of order p that make them least.

    Least squares of ``residual / sigma``. A conjugation cannot remove what is left.

    Raises
    ------
    UsageError
        When the result holds no residuals, or stands for several eigenvectors.
    """
    if not result.residuals or result.multiplicity != 1:
        raise UsageError("error constants up to conjugation need residuals and a simple eigenvalue")
    level = list(result.residuals)
    palette = result.eta.palette if result.eta is not None else ROOTED
    order = level[0].order
    smaller = trees(order - 1, palette) if order > 1 else ()
    if order == 2:  # at the single nodes a common shift in time changes nothing
        smaller = tuple(s for s in smaller if s.colour != next(iter(palette)))
    place = {s: j for j, s in enumerate(smaller)}
    rows = [commutator_row(t, place) for t in level]
    gram = [[Fraction(0)] * len(smaller) for _ in smaller]
    right: list[Any] = [0] * len(smaller)
    for t, row in zip(level, rows, strict=True):
        weight = Fraction(1, t.symmetry**2)
        for i, x in row.items():
            right[i] = plus(right[i], times(-x * weight, result.residuals[t]))
            for j, y in row.items():
                gram[i][j] += x * y * weight
    best = _solve_rational(gram, right)
    moved = {}
    for t, row in zip(level, rows, strict=True):
        total: Any = result.residuals[t]
        for j, x in row.items():
            total = plus(total, times(x, best[j]))
        (moved[t],) = scalars([total])
    return moved


def commutator_row(t: Tree, place: Mapping[Tree, int]) -> dict[int, int]:
    """Return how principal parts one order lower enter the condition of the tree t.

    A change delta of the principal parts at the trees of ``place`` adds ``delta(s)`` to the
    condition of [s] and takes ``ways * delta(s)`` from that of t for each way to cut a leaf off t
    that leaves s.
    """
    row: dict[int, int] = {}
    for kept, count in pruned(t).items():
        if kept in place:
            row[place[kept]] = -count
    if len(t.children) == 1 and t.children[0] in place:
        at = place[t.children[0]]
        row[at] = row.get(at, 0) + 1
    return row


def _solve_rational(matrix: list[list[Fraction]], right: list[Any]) -> list[Any]:
    """Solve a positive definite rational system whose right side may be of any number type."""
    size = len(matrix)
    a, b = [list(row) for row in matrix], list(right)
    for i in range(size):
        lead = 1 / a[i][i]
        for k in range(i + 1, size):
            factor = a[k][i] * lead
            if factor:
                a[k] = [x - factor * y if y else x for x, y in zip(a[k], a[i], strict=True)]
                b[k] = plus(b[k], times(-factor, b[i]))
    for i in reversed(range(size)):
        total = b[i]
        for j in range(i + 1, size):
            total = plus(total, times(-a[i][j], b[j]))
        b[i] = times(1 / a[i][i], total)
    return b
