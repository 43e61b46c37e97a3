"""What an integrator reads off a tableau besides its blocks: u, abscissae, order of the stages.

Everything is computed from exact coefficients in ball arithmetic of several hundred bits, so that a
reference run at any precision and a compiled kernel start from the same numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from ..errors import ExactnessError
from ..exact import Scalar, ball, exact, linalg
from ..exact.linalg import Matrix, Vector
from ..method import GLM

__all__ = [
    "StageBlock",
    "abscissae",
    "as_balls",
    "dependency_blocks",
    "lagrange_weights",
    "preconsistency",
    "stage_blocks",
]


@dataclass(frozen=True)
class StageBlock:
    """Stages that are computed together.

    Attributes
    ----------
        stages: stage numbers from 0, in order.
        implicit: whether an equation has to be solved for them.
    """

    stages: tuple[int, ...]
    implicit: bool


def as_balls(matrix: Matrix) -> Matrix:
    """Enclose every entry; exact zeros stay exact, so that patterns survive."""
    return tuple(tuple(exact(0) if x.is_zero() is True else ball(x) for x in row) for row in matrix)


def dependency_blocks(size: int, needs: Callable[[int, int], bool]) -> tuple[StageBlock, ...]:
    """Order ``size`` unknowns so that each needs only earlier ones; cycles become one block.

    Args:
        size: number of unknowns.
        needs: ``needs(i, j)`` says whether unknown i is computed from unknown j.

    Returns
    -------
        The strongly connected components in a topological order; among those possible the one
        that follows the numbering.
    """
    reach = [{j for j in range(size) if needs(i, j)} for i in range(size)]
    for k in range(size):
        for i in range(size):
            if k in reach[i]:
                reach[i] |= reach[k]
    waiting = list(range(size))
    blocks: list[StageBlock] = []
    while waiting:
        for i in waiting:
            together = [j for j in waiting if j == i or (j in reach[i] and i in reach[j])]
            if all(j in together or j not in waiting for j in reach[i]):
                blocks.append(StageBlock(tuple(together), i in reach[i]))
                waiting = [j for j in waiting if j not in together]
                break
    return tuple(blocks)


def stage_blocks(A: Matrix) -> tuple[StageBlock, ...]:
    """Order the stages of a GLM: explicit ones, diagonally implicit ones, coupled blocks.

    Args:
        A: (s, s); the pattern of its exact zeros decides.
    """
    return dependency_blocks(len(A), lambda i, j: A[i][j].is_zero() is not True)


def _column(values: Sequence[Scalar | int]) -> Matrix:
    return tuple((exact(x) if isinstance(x, int) else x,) for x in values)


def preconsistency(U: Matrix, V: Matrix) -> Vector | None:
    """Return u with ``V u = u`` and ``U u = 1``, enclosed, or ``None`` where there is none.

    Args:
        U: (s, r), V: (r, r).

    ``(I - V + p U_1) u = p`` has the solution u for every p; p only has to avoid the left
    eigenvector's complement, so a few are tried.
    """
    r = len(V)
    one_minus_V = linalg.sub(linalg.identity(r), as_balls(V))
    first = as_balls((U[0],))
    for p in ([1] * r, *([int(j == k) for j in range(r)] for k in range(r))):
        try:
            matrix = linalg.add(one_minus_V, linalg.matmul(_column(p), first))
            u = tuple(row[0] for row in linalg.solve(matrix, _column(p)))
        except (ExactnessError, ZeroDivisionError):
            continue
        defects = [linalg.dot(row, u) - 1 for row in as_balls(U)]
        defects += [linalg.dot(row, u) for row in one_minus_V]
        return u if all(x.is_zero() is not False for x in defects) else None
    return None


def abscissae(A: Matrix, U: Matrix, B: Matrix, V: Matrix) -> Vector:
    """Return c = A 1 + U v, where the first value stands at the time of its step (v_1 = 0).

    Args:
        A: (s, s), U: (s, r), B: (r, s), V: (r, r).

    v solves the consistency condition ``B 1 + V v = u + v``. A method that is not consistent (a
    deliberately broken one) has no such v; it gets c = A 1.
    """
    row_sums = tuple(sum(row[1:], row[0]) for row in as_balls(A))
    u = preconsistency(U, V)
    if u is None or u[0].is_zero() is not False:
        return row_sums
    r = len(V)
    shift = tuple(tuple(x if j == 0 else exact(0) for j in range(r)) for x in u)
    matrix = linalg.add(linalg.sub(linalg.identity(r), as_balls(V)), shift)
    right = tuple((sum(row[1:], row[0]) - x,) for row, x in zip(as_balls(B), u, strict=True))
    try:
        v = tuple(row[0] for row in linalg.solve(matrix, right))
    except (ExactnessError, ZeroDivisionError):
        return row_sums
    if v[0].is_zero() is False:
        return row_sums
    products = (linalg.dot(row, v) for row in as_balls(U))
    return tuple(a + b for a, b in zip(row_sums, products, strict=True))


def method_abscissae(method: GLM) -> Vector:
    """Abscissae of a GLM, see :func:`abscissae`."""
    return abscissae(method.A, method.U, method.B, method.V)


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
