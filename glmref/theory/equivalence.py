"""Superfluous parts of a method: stages and values without influence, and stages that repeat."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import UsageError
from ..exact import Exact, Scalar, linalg
from ..exact.judging import asked
from ..exact.linalg import Matrix, Vector
from ..method import GLM
from .reduction import observed_rows, reached_rows

_ZERO = Exact(0)

#: The reduced rows, a basis of the span of rows, and their pivot columns.
_echelon = asked("linalg.echelon")


def _keep_observed(m: GLM) -> GLM:
    """Carry ``z = C y`` instead of y, the rows of C a basis of what the stages see."""
    C, pivots = _echelon(observed_rows(m))
    if len(C) == m.r or not C:
        return m

    def coordinates(rows: Matrix) -> Matrix:
        """Return coordinates in the basis C: C has unit columns at its pivots."""
        return tuple(tuple(row[j] for j in pivots) for row in rows)

    return m.bare(U=coordinates(m.U), B=linalg.matmul(C, m.B), V=coordinates(linalg.matmul(C, m.V)))


def _keep_reachable(m: GLM) -> GLM:
    """Restrict to the values ``y = X z`` that a start can make; others stay zero once they are."""
    basis, pivots = _echelon(reached_rows(m))
    if len(basis) == m.r or not basis:
        return m
    X = linalg.transpose(basis)
    image = linalg.matmul(m.V, X)
    return m.bare(
        U=linalg.matmul(m.U, X),
        B=tuple(m.B[i] for i in pivots),
        V=tuple(image[i] for i in pivots),
    )


def _equal(a: Vector, b: Vector) -> bool:
    return all((x - y).is_zero() is True for x, y in zip(a, b, strict=True))


def merge_equal_stages(m: GLM) -> GLM:
    """Merge stages that always have the same value: equal rows of U and, once merged, of A.

    References: Hundsdorfer and Spijker, SIAM J. Numer. Anal. 18 (1981) 957, for Runge-Kutta
    methods.
    """
    groups = _coarsest_partition(m)
    if len(groups) == m.s:
        return m
    first = [group[0] for group in groups]

    def merged(rows: Matrix) -> Matrix:
        return tuple(tuple(_total(row, group) for group in groups) for row in rows)

    return m.bare(
        A=merged(tuple(m.A[i] for i in first)),
        U=tuple(m.U[i] for i in first),
        B=merged(m.B),
    )


def _total(row: Vector, group: Sequence[int]) -> Scalar:
    total: Scalar = _ZERO
    for j in group:
        total = total + row[j]
    return total


def _coarsest_partition(m: GLM) -> list[list[int]]:
    """Split the stages until stages of one class have equal U and equal sums of A over classes."""
    groups = _classes(list(range(m.s)), m.U)
    while True:
        sums = tuple(tuple(_total(row, group) for group in groups) for row in m.A)
        finer = [part for group in groups for part in _classes(group, sums)]
        if len(finer) == len(groups):
            return sorted(groups)
        groups = finer


def _classes(stages: list[int], rows: Matrix) -> list[list[int]]:
    classes: list[list[int]] = []
    for i in stages:
        for group in classes:
            if _equal(rows[group[0]], rows[i]):
                group.append(i)
                break
        else:
            classes.append([i])
    return classes


def drop_idle_stages(m: GLM) -> GLM:
    """Drop stages that feed neither a value nor a stage that does.

    References: Dahlquist and Jeltsch (1979), for Runge-Kutta methods.
    """
    keep = sorted(m.read_stages())
    if len(keep) == m.s or not keep:
        return m
    return m.bare(
        A=tuple(tuple(m.A[i][j] for j in keep) for i in keep),
        U=tuple(m.U[i] for i in keep),
        B=tuple(tuple(row[j] for j in keep) for row in m.B),
    )


def reduce(m: GLM) -> GLM:
    """Remove what has no influence: idle and equal stages, values unseen or out of reach.

    Values that no stage ever sees go, even where they are an output; what is left computes the same
    stages. Values that can only be reached by a start that puts something there go too.

    Raises
    ------
    UsageError
        For methods with published decimals, whose rank is not decided.
    """
    if not m.is_exact:
        raise UsageError("superfluous stages and values are decided for exact methods only")
    while True:
        size = (m.s, m.r)
        m = drop_idle_stages(merge_equal_stages(m))
        m = _keep_reachable(_keep_observed(m))
        if (m.s, m.r) == size:
            return m
