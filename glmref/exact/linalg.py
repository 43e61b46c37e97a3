"""Matrices over exact numbers: product, solve, nullspace, inverse, with no tolerance.

A matrix is a tuple of rows, each a tuple of :class:`~glmref.exact.Exact` or
:class:`~glmref.exact.Ball`. Over balls the same code encloses; where a decision (a pivot, a rank)
cannot be made because a ball contains zero, :class:`~glmref.errors.ExactnessError` says so.
:func:`solve_affine` takes systems with any number of rows. Over balls a pivot is an entry that
excludes zero; rows in which no such entry is left are not used, and the caller checks the
residual of the point found, which encloses the solution if there is one.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from ..errors import ExactnessError
from ..system.budget import spend
from . import Ball, Exact, Scalar, sum_of_products

Vector = tuple[Scalar, ...]
Matrix = tuple[Vector, ...]

_ZERO, _ONE = Exact(0), Exact(1)


def zeros(rows: int, columns: int) -> Matrix:
    """Return a zero matrix."""
    return ((_ZERO,) * columns,) * rows


def identity(size: int) -> Matrix:
    """Return the identity matrix."""
    return diagonal([_ONE] * size)


def diagonal(values: Sequence[Scalar]) -> Matrix:
    """Square matrix with the given diagonal."""
    return tuple(
        tuple(x if i == j else _ZERO for j in range(len(values))) for i, x in enumerate(values)
    )


def block_diagonal(*blocks: Matrix) -> Matrix:
    """Return the matrix with the given blocks down the diagonal."""
    width = sum(len(b[0]) for b in blocks)
    rows: list[Vector] = []
    left = 0
    for block in blocks:
        columns = len(block[0])
        rows += [
            (_ZERO,) * left + tuple(row) + (_ZERO,) * (width - left - columns) for row in block
        ]
        left += columns
    return tuple(rows)


def transpose(a: Matrix) -> Matrix:
    """Transpose."""
    return tuple(zip(*a, strict=True))


def conjugate_transpose(a: Matrix) -> Matrix:
    """Conjugate transpose."""

    def conjugate(x: Scalar) -> Scalar:
        spend()  # in a field with many roots one takes a tenth of a second
        return x.conjugate()

    return tuple(tuple(conjugate(x) for x in column) for column in zip(*a, strict=True))


def dot(a: Iterable[Scalar], b: Iterable[Scalar]) -> Scalar:
    """Return the sum of products; exact zeros are skipped, so sparse rows cost nothing."""
    return sum_of_products(
        [(x, y) for x, y in zip(a, b, strict=True) if not (x.vanishes() or y.vanishes())]
    )


def matmul(*factors: Matrix) -> Matrix:
    """Return the product of one or more matrices, from the left."""
    result = factors[0]
    for factor in factors[1:]:
        columns = transpose(factor)
        result = tuple(tuple(dot(row, column) for column in columns) for row in result)
    return result


def matvec(a: Matrix, x: Sequence[Scalar]) -> Vector:
    """Return the matrix times column."""
    return tuple(dot(row, x) for row in a)


def vecmat(x: Sequence[Scalar], a: Matrix) -> Vector:
    """Return the row times matrix."""
    return tuple(dot(x, column) for column in zip(*a, strict=True))


def add(a: Matrix, b: Matrix) -> Matrix:
    """Sum."""
    return tuple(tuple(x + y for x, y in zip(r, s, strict=True)) for r, s in zip(a, b, strict=True))


def sub(a: Matrix, b: Matrix) -> Matrix:
    """Return the difference."""

    def difference(r: Vector, s: Vector) -> Vector:
        spend()  # of 400 rational rows all of them take a second
        return tuple(x - y for x, y in zip(r, s, strict=True))

    return tuple(difference(r, s) for r, s in zip(a, b, strict=True))


def scale(factor: Scalar | int, a: Matrix) -> Matrix:
    """Return the multiple."""
    return tuple(tuple(factor * x for x in row) for row in a)


def row_sums(a: Matrix) -> Vector:
    """Return ``A 1``, with zeros of no length for rows without entries."""
    return tuple(sum((x for _, x in nonzero(row)), _ZERO) for row in a)


def nonzero(row: Sequence[Scalar]) -> list[tuple[int, Scalar]]:
    """Return entries that are not known to be zero, with their places.

    Each object is asked once.
    """
    zeros = {id(x) for x in {id(x): x for x in row}.values() if x.is_zero() is True}
    return [(j, x) for j, x in enumerate(row) if id(x) not in zeros]


def entries(a: Matrix) -> list[tuple[int, int, Scalar]]:
    """Return all entries as ``(row, column, value)``."""
    return [(i, j, x) for i, row in enumerate(a) for j, x in enumerate(row)]


def largest(a: Matrix) -> float:
    """Return the largest magnitude of an entry (an upper bound where entries are balls)."""
    return max((x.magnitude() for row in a for x in row if not x.vanishes()), default=0.0)


def is_exact(*matrices: Sequence[Sequence[Scalar]]) -> bool:
    """Return whether no ball stands in the matrices."""
    return all(isinstance(x, Exact) for m in matrices for row in m for x in row)


def is_lower_triangular(a: Matrix) -> bool:
    """Return whether every entry above the diagonal is an exact zero."""
    return all(x.vanishes() for i, j, x in entries(a) if j > i)


def _pivot_row(rows: list[list[Scalar]], start: int, column: int) -> int | None:
    """Return the row to pivot on, ``None`` if the column is zero from ``start`` on.

    Exact entries: the first nonzero one. Balls: the one furthest from zero; an undecided column
    cannot be called zero, so it is an error.
    """
    candidates = [i for i in range(start, len(rows)) if rows[i][column].is_zero() is False]
    if candidates:
        if any(isinstance(rows[i][column], Ball) for i in candidates):
            return max(candidates, key=lambda i: rows[i][column].ball().lower_magnitude())
        return candidates[0]
    if any(rows[i][column].is_zero() is None for i in range(start, len(rows))):
        raise ExactnessError(
            f"column {column + 1} holds balls around zero: its rank is not decided; "
            f"give more digits or exact entries"
        )
    return None


def reduced(a: Sequence[Sequence[Scalar]], columns: int) -> tuple[list[list[Scalar]], list[int]]:
    """Return Gauss-Jordan elimination on the first ``columns`` columns: rows and pivot columns."""
    rows = [list(row) for row in a]
    pivots: list[int] = []
    for column in range(columns):
        top = len(pivots)
        if top == len(rows):
            break
        at = _pivot_row(rows, top, column)
        if at is None:
            continue
        rows[top], rows[at] = rows[at], rows[top]
        lead = rows[top][column]
        rows[top] = [x if x.vanishes() else x / lead for x in rows[top]]
        rows[top][column] = _ONE
        for i, row in enumerate(rows):
            spend()
            factor = row[column]
            if i == top or factor.vanishes():
                continue
            rows[i] = [
                x if y.vanishes() else x - factor * y for x, y in zip(row, rows[top], strict=True)
            ]
            rows[i][column] = _ZERO
        pivots.append(column)
    return rows, pivots


def solve(a: Matrix, right: Matrix) -> Matrix:
    """Solve ``a x = right`` for square ``a``.

    Raises
    ------
    ExactnessError
        When ``a`` is singular.
    """
    size = len(a)
    rows, pivots = reduced([(*r, *s) for r, s in zip(a, right, strict=True)], size)
    if len(pivots) < size:
        raise ExactnessError(f"a matrix of size {size} and rank {len(pivots)} cannot be inverted")
    return tuple(tuple(row[size:]) for row in rows)


def inverse(a: Matrix) -> Matrix:
    """Return the inverse of a square matrix.

    Raises
    ------
    ExactnessError
        When it is singular.
    """
    return solve(a, identity(len(a)))


def rank(a: Matrix) -> int:
    """Rank."""
    return len(reduced(a, len(a[0]))[1])


def nullspace(a: Matrix) -> list[Vector]:
    """Return a basis of ``{x : a x = 0}``: a vector for each free column, its entry there 1."""
    columns = len(a[0])
    rows, pivots = reduced(a, columns)
    return _directions(dict(zip(pivots, rows, strict=False)), columns)


def _directions(solved: Mapping[int, Sequence[Scalar]], n: int) -> list[Vector]:
    """Return a solution of reduced equations, by pivots, for each column that has none."""
    basis: list[Vector] = []
    for free in (j for j in range(n) if j not in solved):
        vector: list[Scalar] = [_ZERO] * n
        vector[free] = _ONE
        for pivot, row in solved.items():
            vector[pivot] = -row[free]
        basis.append(tuple(vector))
    return basis


# --- systems with any number of rows: all solutions, or the row that contradicts the others ------


@dataclass(frozen=True, eq=False)
class Affine:
    """Solutions ``point + sum t_k directions[k]`` of a linear system."""

    point: Vector  #: (n,), the solution with every free unknown zero.
    directions: tuple[Vector, ...]  #: Basis of the homogeneous solutions.
    #: Index of the row (from 0) that contradicts those before it, or ``None``.
    failed: int | None
    undecided: bool  #: Whether balls around zero were left out of the decision.


def _pivot(row: Sequence[Scalar], used: set[int]) -> int | None:
    """Return the column to solve for: the first exact entry, the ball furthest from zero."""
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

    Parameters
    ----------
    rows : Matrix
        (m, n).
    right : Vector
        (m,).
    """
    n = len(rows[0])
    solved: dict[
        int, list[Scalar]
    ] = {}  # column -> row with 1 there and 0 in the other solved ones
    undecided = False
    failed: int | None = None
    for index, (row, value) in enumerate(zip(rows, right, strict=True)):
        current = _without(solved, [*row, value])
        at = _pivot(current[:n], set(solved))
        if at is None:
            open_entries = any(x.is_zero() is None for x in current[:n])
            undecided = undecided or open_entries or current[n].is_zero() is None
            if failed is None and not open_entries and current[n].is_zero() is False:
                failed = index
            continue
        lead = current[at]
        current = [x if x.is_zero() is True else x / lead for x in current]
        solved = {column: _without({at: current}, known) for column, known in solved.items()}
        solved[at] = current
    return Affine(*_read_off(solved, n), failed, undecided)


def independent_rows(rows: Matrix, enough: int | None = None) -> list[int]:
    """Return numbers of rows that are independent of those before them, at most ``enough`` of them.

    Over balls a row counts only if its independence is certain.
    """
    solved: dict[int, list[Scalar]] = {}
    chosen: list[int] = []
    for index, row in enumerate(rows):
        if enough is not None and len(chosen) == enough:
            break
        current = _without(solved, list(row))
        at = _pivot(current, set(solved))
        if at is None:
            continue
        lead = current[at]
        solved[at] = [x if x.is_zero() is True else x / lead for x in current]
        chosen.append(index)
    return chosen


def _without(solved: Mapping[int, list[Scalar]], row: list[Scalar]) -> list[Scalar]:
    """Subtract multiples of the solved rows, so that their columns become zero."""
    for column, known in solved.items():
        if row[column].is_zero() is not True:
            row = _subtract(row, row[column], known)
            row[column] = _ZERO
    return row


def _subtract(row: list[Scalar], factor: Scalar, other: list[Scalar]) -> list[Scalar]:
    spend()
    return [x if y.is_zero() is True else x - factor * y for x, y in zip(row, other, strict=True)]


def _read_off(solved: dict[int, list[Scalar]], n: int) -> tuple[Vector, tuple[Vector, ...]]:
    point = tuple(solved[j][n] if j in solved else _ZERO for j in range(n))
    return point, tuple(_directions(solved, n))
