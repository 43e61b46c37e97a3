"""When two tableaux are the same method: change of values, order of stages, superfluous parts.

The real and the complex form of a method are in :mod:`glmref.theory.complex_form`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import islice, product

from ..errors import UsageError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector, independent_rows, solve_affine
from ..method import GLM
from ..method.stage_order import reached
from .involutions import matchings
from .reduction import observed_rows, reached_rows

_ZERO, _ONE = Exact(0), Exact(1)
MAX_MATCHINGS = 50


@dataclass(frozen=True, eq=False)
class Equivalence:
    """How one method becomes another: ``m1.transform(T).permute_stages(stages)`` is m2."""

    T: Matrix  #: (r, r) nonsingular.
    stages: tuple[int, ...]  #: (s,) old number of each new stage, from 0.


def _markov(m: GLM, count: int) -> list[Matrix]:
    """``U V^k B`` for k = 0 .. count - 1: what a change of values leaves alone, like A."""
    result: list[Matrix] = []
    left = m.U
    for _ in range(count):
        result.append(linalg.matmul(left, m.B))
        left = linalg.matmul(left, m.V)
    return result


def _transformations(m1: GLM, m2: GLM) -> list[Matrix]:
    """Candidates T with T B1 = B2, U2 T = U1, T V1 = V2 T; stages already in the same order.

    ``U2 V2^k T = U1 V1^k`` determines T where the stages see all values. Where they do not, some
    solutions of all equations together, which may all be singular.
    """
    left, right = m2.U, m1.U
    layer2, layer1 = m2.U, m1.U
    for _ in range(m1.r):
        chosen = independent_rows(left, m1.r)
        if len(chosen) == m1.r:
            rows = tuple(left[i] for i in chosen)
            T = linalg.solve(rows, tuple(right[i] for i in chosen))
            return [T] if _transforms(m1, m2, T) else []
        layer2, layer1 = linalg.matmul(layer2, m2.V), linalg.matmul(layer1, m1.V)
        left, right = (*left, *layer2), (*right, *layer1)
    return _all_transformations(m1, m2)


def _transforms(m1: GLM, m2: GLM, T: Matrix) -> bool:
    pairs = (
        (linalg.matmul(m2.U, T), m1.U),
        (linalg.matmul(T, m1.B), m2.B),
        (linalg.matmul(T, m1.V), linalg.matmul(m2.V, T)),
    )
    return all(_equal(a, b) for first, second in pairs for a, b in zip(first, second, strict=True))


def _all_transformations(m1: GLM, m2: GLM) -> list[Matrix]:
    """Solutions of the linear equations for T, with small whole numbers as free parameters."""
    r, s = m1.r, m1.s
    equations: list[Vector] = []
    right: list[Scalar] = []

    def equation(coefficients: dict[int, Scalar], value: Scalar) -> None:
        equations.append(tuple(coefficients.get(n, _ZERO) for n in range(r * r)))
        right.append(value)

    for i, k in product(range(s), range(r)):
        equation({a * r + k: m2.U[i][a] for a in range(r)}, m1.U[i][k])
    for a, j in product(range(r), range(s)):
        equation({a * r + b: m1.B[b][j] for b in range(r)}, m2.B[a][j])
    for a, k in product(range(r), repeat=2):
        coefficients: dict[int, Scalar] = {}
        for b in range(r):
            first, second = a * r + b, b * r + k
            coefficients[first] = coefficients.get(first, _ZERO) + m1.V[b][k]
            coefficients[second] = coefficients.get(second, _ZERO) - m2.V[a][b]
        equation(coefficients, _ZERO)
    solution = solve_affine(tuple(equations), tuple(right))
    if solution.failed is not None:
        return []
    found: list[Matrix] = []
    factors = product((0, 1, -1, 2, 3), repeat=len(solution.directions))
    for choice in islice(factors, 200):
        flat = solution.point
        for t, direction in zip(choice, solution.directions, strict=True):
            flat = tuple(x + t * y for x, y in zip(flat, direction, strict=True))
        found.append(tuple(flat[a * r : a * r + r] for a in range(r)))
    return found


def equivalence(m1: GLM, m2: GLM) -> Equivalence | None:
    """Find T and an order of the stages that turn one method into another, or ``None``.

    Both must be exact. Superfluous stages and values are not removed first: see :func:`reduce`.

    Raises
    ------
    UsageError
        For methods with published decimals, whose equality is not decided.

    References: Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), section
    503.
    """
    if not (m1.is_exact and m2.is_exact):
        raise UsageError("equivalence is decided for exact methods only")
    if (m1.s, m1.r) != (m2.s, m2.r):
        return None
    pairs = [(m1.A, m2.A), *zip(_markov(m1, m1.r), _markov(m2, m2.r), strict=True)]
    for stages in islice(matchings(pairs, m1.s), MAX_MATCHINGS):
        reordered = m1.permute_stages(stages)
        for T in _transformations(reordered, m2):
            if linalg.rank(T) == m1.r:
                return Equivalence(T, stages)
    return None


def equivalent(m1: GLM, m2: GLM) -> Matrix | None:
    """The matrix T with ``y2 = T y1`` that turns one method into another, or ``None``."""
    found = equivalence(m1, m2)
    return None if found is None else found.T


def _row_basis(rows: Matrix) -> Matrix:
    """Reduced echelon basis of the span of the rows."""
    columns = len(rows[0])
    chosen = [rows[i] for i in independent_rows(rows, columns)]
    if not chosen:
        return ()
    pivots: list[int] = []
    work = [list(row) for row in chosen]
    for column in range(columns):
        top = len(pivots)
        at = next((i for i in range(top, len(work)) if work[i][column].is_zero() is False), None)
        if at is None:
            continue
        work[top], work[at] = work[at], work[top]
        lead = work[top][column]
        work[top] = [x / lead for x in work[top]]
        for i, row in enumerate(work):
            if i != top and row[column].is_zero() is not True:
                factor = row[column]
                work[i] = [x - factor * y for x, y in zip(row, work[top], strict=True)]
        pivots.append(column)
        if len(pivots) == len(work):
            break
    return tuple(tuple(row) for row in work)


def _pivot_columns(basis: Matrix) -> list[int]:
    return [next(j for j, x in enumerate(row) if x.is_zero() is False) for row in basis]


def _observed(m: GLM) -> Matrix:
    """Basis of the span of the rows of U, U V, U V^2, ..: what the stages can see."""
    return _row_basis(observed_rows(m))


def reachable_values(m: GLM) -> list[Vector]:
    """Basis of the span of u and of the columns of B, V B, V^2 B, ..: what a start can ask for.

    Values outside are zero for ever once the start leaves them zero.
    """
    return list(_row_basis(reached_rows(m)))


def _keep_observed(m: GLM) -> GLM:
    """Carry ``z = C y`` instead of y, the rows of C a basis of what the stages see."""
    C = _observed(m)
    if len(C) == m.r or not C:
        return m
    pivots = _pivot_columns(C)

    def coordinates(rows: Matrix) -> Matrix:
        """Coordinates in the basis C: C has unit columns at its pivots."""
        return tuple(tuple(row[j] for j in pivots) for row in rows)

    return m.bare(U=coordinates(m.U), B=linalg.matmul(C, m.B), V=coordinates(linalg.matmul(C, m.V)))


def _keep_reachable(m: GLM) -> GLM:
    """Restrict to the values ``y = X z`` that can be reached."""
    basis = tuple(reachable_values(m))
    if len(basis) == m.r or not basis:
        return m
    pivots = _pivot_columns(basis)
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
    read = {j for j in range(m.s) if any(row[j].is_zero() is not True for row in m.B)}
    active = reached(read, lambda i: [j for j, x in enumerate(m.A[i]) if x.is_zero() is not True])
    if len(active) == m.s or not active:
        return m
    keep = sorted(active)
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
