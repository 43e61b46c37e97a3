"""Linear systems with any number of rows: all solutions, or the row that contradicts the others.

Over exact numbers every decision is made. Over balls a pivot is an entry that excludes zero; rows
in which no such entry is left are not used, and whoever asks checks the residual of the point
found, which encloses the solution if there is one.

Public names::

    solve_affine(rows, right) -> Affine(point, directions, failed, undecided)
    independent_rows(rows, enough) -> list[int]
    verdict_of(residual) -> Residual(holds, residual, entry)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..exact import Ball, Exact, Scalar
from ..exact.linalg import Matrix, Vector

__all__ = ["Affine", "Residual", "independent_rows", "solve_affine", "verdict_of"]

_ZERO, _ONE = Exact(0), Exact(1)


@dataclass(frozen=True, eq=False)
class Affine:
    """Solutions ``point + sum t_k directions[k]`` of a linear system.

    Attributes
    ----------
        point: (n,), the solution with every free unknown zero.
        directions: basis of the homogeneous solutions.
        failed: index of the row (from 0) that contradicts those before it, or ``None``.
        undecided: whether balls around zero were left out of the decision.
    """

    point: Vector
    directions: tuple[Vector, ...]
    failed: int | None = None
    undecided: bool = False


@dataclass(frozen=True)
class Residual:
    """What a residual matrix says: all zero, some entry not zero, or open.

    Attributes
    ----------
        holds: ``True``, ``False``, or ``None`` where only balls around zero keep it open.
        residual: upper bound of the largest entry, 0.0 when all are zero.
        entry: (row, column) of the largest entry that is not zero, or ``None``.
    """

    holds: bool | None
    residual: float = 0.0
    entry: tuple[int, int] | None = None


def verdict_of(residual: Matrix) -> Residual:
    """Judge a residual matrix: see :class:`Residual`."""
    nonzero: tuple[float, tuple[int, int]] | None = None
    open_size = -1.0
    for i, row in enumerate(residual):
        for j, x in enumerate(row):
            zero = x.is_zero()
            if zero is True:
                continue
            size = x.magnitude()
            if zero is None:
                open_size = max(open_size, size)
            elif nonzero is None or size > nonzero[0]:
                nonzero = (size, (i, j))
    if nonzero is not None:
        return Residual(False, *nonzero)
    if open_size >= 0:
        return Residual(None, open_size)
    return Residual(True)


def _pivot(row: Sequence[Scalar], used: set[int]) -> int | None:
    """Column to solve for: of exact entries the first, of balls the one furthest from zero."""
    best: tuple[float, int] | None = None
    for j, x in enumerate(row):
        if j in used or x.is_zero() is not False:
            continue
        size = x.lower_magnitude() if isinstance(x, Ball) else float("inf")
        if best is None or size > best[0]:
            best = (size, j)
    return None if best is None else best[1]


def solve_affine(rows: Matrix, right: Vector) -> Affine:
    """Solve ``rows x = right``, row by row; rows that follow from earlier ones cost little.

    Args:
        rows: (m, n). right: (m,).
    """
    n = len(rows[0])
    solved: dict[
        int, list[Scalar]
    ] = {}  # column -> row with 1 there and 0 in the other solved ones
    undecided = False
    failed: int | None = None
    for index, (row, value) in enumerate(zip(rows, right, strict=True)):
        current: list[Scalar] = [*row, value]
        for column, known in solved.items():
            factor = current[column]
            if factor.is_zero() is not True:
                current = _subtract(current, factor, known)
                current[column] = _ZERO
        at = _pivot(current[:n], set(solved))
        if at is None:
            open_entries = any(x.is_zero() is None for x in current[:n])
            undecided = undecided or open_entries or current[n].is_zero() is None
            if failed is None and not open_entries and current[n].is_zero() is False:
                failed = index
            continue
        lead = current[at]
        current = [x if x.is_zero() is True else x / lead for x in current]
        current[at] = _ONE
        for column, known in solved.items():
            factor = known[at]
            if factor.is_zero() is not True:
                solved[column] = _subtract(known, factor, current)
                solved[column][at] = _ZERO
        solved[at] = current
    return Affine(*_read_off(solved, n), failed, undecided)


def independent_rows(rows: Matrix, enough: int | None = None) -> list[int]:
    """Numbers of rows that are independent of those before them, at most ``enough`` of them.

    Over balls a row counts only if its independence is certain.
    """
    solved: dict[int, list[Scalar]] = {}
    chosen: list[int] = []
    for index, row in enumerate(rows):
        if enough is not None and len(chosen) == enough:
            break
        current = list(row)
        for column, known in solved.items():
            factor = current[column]
            if factor.is_zero() is not True:
                current = _subtract(current, factor, known)
                current[column] = _ZERO
        at = _pivot(current, set(solved))
        if at is None:
            continue
        lead = current[at]
        solved[at] = [x if x.is_zero() is True else x / lead for x in current]
        chosen.append(index)
    return chosen


def _subtract(row: list[Scalar], factor: Scalar, other: list[Scalar]) -> list[Scalar]:
    return [x if y.is_zero() is True else x - factor * y for x, y in zip(row, other, strict=True)]


def _read_off(solved: dict[int, list[Scalar]], n: int) -> tuple[Vector, tuple[Vector, ...]]:
    point = tuple(solved[j][n] if j in solved else _ZERO for j in range(n))
    directions: list[Vector] = []
    for free in (j for j in range(n) if j not in solved):
        direction: list[Scalar] = [_ZERO] * n
        direction[free] = _ONE
        for column, row in solved.items():
            direction[column] = -row[free]
        directions.append(tuple(direction))
    return point, tuple(directions)
