"""Linear algebra over any of the numbers."""

from __future__ import annotations

from collections.abc import Iterable
from itertools import chain

from .arithmetic import (
    RATIONAL,
    Applied,
    Fraction,
    Gradient,
    Interval,
    Number,
    dot_of_gradients,
    dot_of_intervals,
    dot_of_rationals,
    product_of_rationals,
)
from .numbers import (
    Element,
    conj,
    dot_of_elements,
    inverse,
    is_enclosure,
    is_nil,
    live,
    may_vanish,
    smallest,
    total,
    vanishes,
)
from .refusals import Undecided, require

RATIONALS = {*RATIONAL}
INTERVALS = RATIONALS | {Interval}
ELEMENTS = RATIONALS | {Element}
GRADIENTS = INTERVALS | {Gradient}


def multiples(factor: Number, values: Iterable) -> list:
    """Return factor x for every x; an exact zero stays one where the factor is an interval."""
    return [x if is_nil(x) else factor * x for x in values]


def dot(x: list, y: list) -> Number:
    """Return sum x_i y_i; an exact zero stays one whatever it is multiplied by."""
    require(len(x) == len(y), "shapes do not fit")
    kinds = {*map(type, x), *map(type, y)}
    if kinds <= RATIONALS:
        return dot_of_rationals(x, y)
    if kinds <= INTERVALS:
        return dot_of_intervals(x, y)
    if kinds <= ELEMENTS:
        return dot_of_elements(x, y)
    pairs = [(a, b) for a, b in zip(x, y, strict=True) if not (is_nil(a) or is_nil(b))]
    if kinds <= GRADIENTS and any(type(a) is Gradient or type(b) is Gradient for a, b in pairs):
        return dot_of_gradients(pairs)
    for kind in kinds - GRADIENTS:
        if hasattr(kind, "dot"):  # a number of another program
            return kind.dot(pairs)
    return total(a * b for a, b in pairs)


def less(x: list, y: list) -> list:
    """Return x - y."""
    require(len(x) == len(y), "two vectors have other lengths")
    return [a - b for a, b in zip(x, y, strict=True)]


def placewise(n: int, vectors: Iterable) -> list:
    """Return the product of vectors place by place, n ones if there are none; zeros stay exact."""
    found = None
    for x in vectors:
        found = x if found is None else [
            Fraction(0) if is_nil(a) or is_nil(b) else a * b
            for a, b in zip(found, x, strict=True)]  # fmt: skip
    return ones(n) if found is None else found


def transpose(M: list) -> list:
    """Return the transpose."""
    return [list(column) for column in zip(*M, strict=True)]


def star(M: list) -> list:
    """Return the conjugate transpose."""
    return [[conj(x) for x in column] for column in transpose(M)]


class Matrix(list):
    """Rows that are applied to many vectors: what the arithmetic makes of them is kept."""

    def __init__(self, rows: Iterable[list]) -> None:
        super().__init__(rows)
        self.kinds, self.ready = kinds_of(self), None

    def image(self, x: list) -> list | None:
        """Return M x of rationals, or of a vector of intervals; None of other numbers."""
        kinds = {*map(type, x)}
        rational = kinds | self.kinds <= RATIONALS
        if not rational and (kinds != {Interval} or not self.kinds <= INTERVALS):
            return None
        if self.ready is None:
            self.ready = Applied(self)
        return self.ready.to_rationals(x) if rational else self.ready.to_intervals(x)


def kinds_of(rows: Iterable[list]) -> set[type]:
    """Return the types of entries."""
    return {*map(type, chain.from_iterable(rows))}


def apply(M: list, x: list) -> list:
    """Return M x."""
    require(all(len(row) == len(x) for row in M), "shapes do not fit")
    found = M.image(x) if type(M) is Matrix else None
    return [dot(row, x) for row in M] if found is None else found


def times(first: list, *others: list) -> list:
    """Return a product of matrices."""
    for M in others:
        require(len(first[0]) == len(M), "shapes do not fit")
        if kinds_of(first) | kinds_of(M) <= RATIONALS:
            first = product_of_rationals(first, M)
        else:
            columns = transpose(M)
            first = [[dot(row, column) for column in columns] for row in first]
    return first


def combine(M: list, N: list, factor: int = 1) -> list:
    """Return M + factor N."""
    require(len(M) == len(N) and len(M[0]) == len(N[0]), "shapes do not fit")
    return [[a + factor * b for a, b in zip(p, q, strict=True)] for p, q in zip(M, N, strict=True)]


def minus(M: list, N: list) -> list:
    """Return M - N."""
    return combine(M, N, -1)


def scale(factor: Number, M: list) -> list:
    """Return factor M."""
    return [multiples(factor, row) for row in M]


def diagonal(values: list) -> list:
    """Return the diagonal matrix of `values`."""
    return [
        [x if i == j else Fraction(0) for j in range(len(values))] for i, x in enumerate(values)
    ]


def identity(n: int) -> list:
    """Return the unit matrix."""
    return diagonal([Fraction(1)] * n)


def ones(n: int) -> list:
    """Return a vector of ones."""
    return [Fraction(1)] * n


def equal(x: list, y: list, why: str) -> None:
    """Refuse two vectors or matrices that differ."""
    same = len(x) == len(y) and (not isinstance(x[0], list) or len(x[0]) == len(y[0]))
    require(same, f"{why}: shapes do not fit")
    difference = (
        minus(x, y) if isinstance(x[0], list) else [a - b for a, b in zip(x, y, strict=True)]
    )
    require(vanishes(difference), f"{why} does not hold")


def echelon(M: list) -> tuple[list, list[int]]:
    """Return the reduced rows and the pivot columns of M; pivots are not 0 in any interval."""
    rows, pivots = [list(row) for row in M], []
    for column in range(len(rows[0]) if rows else 0):
        top = len(pivots)
        below = [i for i in range(top, len(rows)) if live(rows[i][column])]
        good = [i for i in below if not may_vanish(rows[i][column])]
        if not below:
            continue
        if not good:
            raise Undecided("an interval holds 0: nothing is decided")
        found = max(good, key=lambda i, k=column: smallest(rows[i][k]))
        rows[top], rows[found] = rows[found], rows[top]
        factor = inverse(rows[top][column])
        rows[top] = [factor * x if live(x) else x for x in rows[top]]
        for i, row in enumerate(rows):
            if i != top and live(row[column]):
                head = row[column]
                rows[i] = [
                    x - head * y if live(y) else x for x, y in zip(row, rows[top], strict=True)
                ]
        pivots.append(column)
    return rows[: len(pivots)], pivots


def rank(M: list) -> int:
    """Return the rank of M."""
    return len(echelon(M)[1])


def solve(M: list, y: list) -> tuple[list | None, bool]:
    """Return (x, unique) with M x = y, or (None, False) where the equations contradict."""
    n = len(M[0])
    rows, pivots = echelon([[*row, b] for row, b in zip(M, y, strict=True)])
    if n in pivots:
        return None, False
    x = [Fraction(0)] * n
    for row, column in zip(rows, pivots, strict=True):
        x[column] = row[n]
    return x, len(pivots) == n


def kernel(M: list) -> list:
    """Return a basis of the vectors x with M x = 0."""
    rows, pivots = echelon(M)
    basis = []
    for free in set(range(len(M[0]))) - set(pivots):
        x = [Fraction(int(j == free)) for j in range(len(M[0]))]
        for row, column in zip(rows, pivots, strict=True):
            x[column] = -row[free]
        basis.append(x)
    return basis


def inverse_matrix(M: list) -> list:
    """Return the inverse of M."""
    n = len(M)
    rows, pivots = echelon([[*row, *unit] for row, unit in zip(M, identity(n), strict=True)])
    require(pivots == list(range(n)), "a matrix that must be inverted is singular")
    return [row[n:] for row in rows]


def at_matrix(p: list, V: list) -> list:
    """Return p(V)."""
    value = scale(p[-1], identity(len(V)))
    for c in reversed(p[:-1]):
        value = combine(times(value, V), scale(c, identity(len(V))))
    return value


def characteristic(M: list) -> list:
    """Return det(x I - M), constant first (Faddeev, LeVerrier)."""
    n = len(M)
    require(n <= 40, "beyond the limits of this checker")
    coefficients: list[Number] = [Fraction(1)]
    N = [[Fraction(0)] * n for _ in range(n)]
    for k in range(1, n + 1):
        N = combine(times(M, N), scale(coefficients[-1], identity(n)))
        product_ = times(M, N)
        coefficients.append(total(product_[i][i] for i in range(n)) * Fraction(-1, k))
    return coefficients[::-1]


def is_exact(M: list) -> bool:
    """Tell whether no entry is an interval or a rectangle."""
    return not any(is_enclosure(x) for row in M for x in row)


def blocks_of(V: list) -> list:
    """Return the diagonal blocks of V: exact zeros say in which order it is block triangular."""
    reach = [{j for j, x in enumerate(row) if not is_nil(x)} | {i} for i, row in enumerate(V)]
    for _ in range(len(V).bit_length()):  # each time paths of twice the length
        reach = [set().union(*(reach[j] for j in x)) for x in reach]
    groups = {tuple(j for j in sorted(x) if i in reach[j]) for i, x in enumerate(reach)}
    return [[[V[i][j] for j in group] for i in group] for group in sorted(groups)]


def entries(matrices: Iterable) -> list:
    """Return the entries of matrices."""
    return [x for M in matrices for row in M for x in row]
