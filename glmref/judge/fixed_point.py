"""Conditions of rounded tables in fixed point, with bounds of all errors (section 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from operator import mul
from typing import NamedTuple, TypeAlias, cast

from .arithmetic import Fraction, products_of_whole
from .linalg import dot
from .numbers import floor
from .series import Series
from .trees import Palette, Tree, counted, gamma, size

#: Pairs of a colour and the rows of A.
Tables: TypeAlias = "tuple[tuple[str, tuple[tuple[Fraction, ...], ...]], ...]"


class Fixed:
    """Numbers in units of 2^-bits with errors of at most `radius`; `size` is the largest."""

    __slots__ = ("radius", "size", "values")

    def __init__(self, values: list[int], radius: int) -> None:
        self.values, self.radius = values, radius
        self.size = max(map(abs, values))


class Group(NamedTuple):
    """Trees by their places in an order: the gaps of their conditions, none off by more."""

    places: list[int]
    gaps: list[int]
    error: int

    def above(self, limit: int) -> list[int]:
        """Return the places of trees whose residual may be above a number of units."""
        return [k for k, gap in zip(self.places, self.gaps, strict=True)
                if abs(gap) + self.error > limit]  # fmt: skip


@dataclass(frozen=True)
class Weights:
    """A row of weights in units, b A by colour, bounds of residuals by tree, by root and order."""

    row: list[Fraction]
    b: Fixed
    before: dict[str, Fixed]
    known: dict[Tree, tuple[int, int]]
    groups: dict[tuple[str, int], list[Group]]


class Sizes:
    """Conditions of a method that carries one value, in integers over 2^bits with their errors.

    Parameters
    ----------
    tables : dict
        A by colour, rows of rational numbers.
    palette, system, nystrom
        Which trees count, see :func:`counted`.
    bits : int
        Numbers are integers over 2^bits, below what they stand for by less than 1.
    """

    def __init__(self, tables: dict[str, list[list[Fraction]]], palette: Palette, system: str,
                 nystrom: bool, bits: int) -> None:  # fmt: skip
        self.tables, self.bits, self.one = tables, bits, 1 << bits
        self.palette, self.system, self.nystrom = palette, system, nystrom
        self.A = {c: [self.whole(row) for row in A] for c, A in tables.items()}
        self.norm = {c: max(sum(map(abs, x)) + len(x) for x in A) for c, A in self.A.items()}
        self.products = {c: Fixed([self.one] * len(A[0]), 0) for c, A in tables.items()}
        self.phis: dict[Tree, Fixed] = {}
        self.images: dict[Tree, Fixed] = {}
        self.rows: dict[tuple[Fraction, ...], Weights] = {}
        self.levels: dict[int, list[Tree]] = {}

    def level(self, order: int) -> list[Tree]:
        """Return the trees of an order that count."""
        if order not in self.levels:
            self.levels[order] = counted(self.palette, self.system, order, self.nystrom)
        return self.levels[order]

    def whole(self, row: list[Fraction]) -> list[int]:
        """Return the integers below 2^bits times rational numbers."""
        return [floor(Fraction(x) * self.one) for x in row]

    def weights(self, row: list[Fraction]) -> Weights:
        """Return a row of rational weights in units, and what is found with it."""
        key = tuple(row)
        if key not in self.rows:
            self.rows[key] = Weights(row, Fixed(self.whole(row), 1), {}, {}, {})
        return self.rows[key]

    def before(self, weights: Weights, colour: str) -> Fixed:
        """Return b A in units, A that of a colour."""
        b, known = weights.b, weights.before
        if colour not in known:
            A = self.A[colour]
            (row,) = products_of_whole([b.values], [list(x) for x in zip(*A, strict=True)])
            error = len(A) * (b.size + 1 + max(abs(x) for row in A for x in row))
            known[colour] = Fixed([y >> self.bits for y in row], (error >> self.bits) + 2)
        return known[colour]

    def phi(self, tree: Tree) -> Fixed:
        """Return the product over the children of A Phi(child)."""
        colour, children = tree
        if not children:
            return self.products[colour]
        if len(children) == 1:
            return self.below(children[0])
        found = self.phis.get(tree)
        if found is None:
            x, y = self.phi((colour, children[:-1])), self.below(children[-1])
            # |(x + d)(y + e) - x y| <= |x| ry + |y| rx + rx ry; the shift loses less than 1
            error = x.size * y.radius + y.size * x.radius + x.radius * y.radius
            values = [a * b >> self.bits for a, b in zip(x.values, y.values, strict=True)]
            found = self.phis[tree] = Fixed(values, (error >> self.bits) + 2)
        return found

    def below(self, tree: Tree) -> Fixed:
        """Return A Phi(tree), A that of the colour of the root."""
        if tree not in self.images:
            self.prepare([tree])
        return self.images[tree]

    def prepare(self, level: list[Tree]) -> None:
        """Find A Phi(tree) for trees of one order, all in one product of matrices."""
        for colour, A in self.A.items():
            new = [t for t in level if t[0] == colour and t not in self.images]
            phis = [self.phi(t) for t in new]
            rows = products_of_whole([x.values for x in phis], A)
            for t, x, row in zip(new, phis, rows, strict=True):
                # each entry of A is less than 1 too small, which weighs |x|_1 + s r at most
                error = self.norm[colour] * x.radius + len(x.values) * (x.size + x.radius)
                image = Fixed([y >> self.bits for y in row], (error >> self.bits) + 2)
                self.images[t] = image

    def residual(self, tree: Tree, weights: Weights) -> tuple[int, int]:
        """Return bounds of |b Phi(tree) - 1 / gamma(tree)| in units.

        Of a tree with one branch b Phi(tree) is (b A) Phi(branch).
        """
        found = weights.known.get(tree)
        if found is None:
            alone = len(tree[1]) == 1
            b = self.before(weights, tree[1][0][0]) if alone else weights.b
            x = self.phi(tree[1][0] if alone else tree)
            error = len(x.values) * (b.size * x.radius + b.radius * (x.size + x.radius))
            gap = sum(map(mul, b.values, x.values)) >> self.bits
            gap, error = abs(gap - self.one // gamma(tree)), (error >> self.bits) + 3
            found = weights.known[tree] = max(gap - error, 0), gap + error
        return found

    def above(self, order: int, weights: dict[str, Weights], limit: int) -> list[Tree]:
        """Return trees of an order, in order: all with a residual above a number of units."""
        groups, level = self.groups(order, weights), self.level(order)
        return [level[k] for k in sorted(k for x in groups for k in x.above(limit))]

    def groups(self, order: int, weights: dict[str, Weights]) -> list[Group]:
        """Return the conditions of an order."""
        for colour, row in weights.items():
            if (colour, order) not in row.groups:  # two colours may have one row of weights
                places = {t: k for k, t in enumerate(self.level(order)) if t[0] == colour}
                row.groups[colour, order] = list(self.grouped(order, places, row))
        return [x for colour, row in weights.items() for x in row.groups[colour, order]]

    def grouped(self, order: int, places: dict[Tree, int], row: Weights) -> Iterator[Group]:
        """Yield the trees of one order and colour in groups, by products of matrices.

        The gap is sum b_i x_i y_i - 1 / gamma(t), x of the tree without the last branch and y of
        that branch, and so is 1 / gamma(t) a product. If none is off by more than r, the first
        product is by (b + rb) (x + rx) (y + ry) - b x y at most, the second by 2 units.
        """
        joined: dict[tuple, dict[Tree, dict[Tree, int]]] = {}
        for tree, k in places.items():
            alone = len(tree[1]) == 1
            colour, children = tree[1][0] if alone else tree
            if children:
                key, first = (colour if alone else "", size(children[-1])), (colour, children[:-1])
                joined.setdefault(key, {}).setdefault(first, {})[children[-1]] = k
            else:
                low, high = self.residual(tree, row)
                yield Group([k], [low], high - low)
        for (below, _), trees in joined.items():
            b = self.before(row, below) if below else row.b
            branches = dict.fromkeys(t for x in trees.values() for t in x)
            column = {t: k for k, t in enumerate(branches)}
            firsts, lasts = [self.phi(t) for t in trees], [self.below(t) for t in column]
            over = order * (order - 1) if below else order
            lefts = [[*map(mul, b.values, x.values), -self.one**2 * size(t) // (gamma(t) * over)]
                     for t, x in zip(trees, firsts, strict=True)]  # fmt: skip
            rights = [[*y.values, self.one // gamma(t)] for t, y in zip(column, lasts, strict=True)]
            most, radius = max(y.size for y in lasts), max(y.radius for y in lasts)
            products = products_of_whole(lefts, rights)
            for x, at, found in zip(firsts, trees.values(), products, strict=True):
                error = (b.size + b.radius) * (x.size + x.radius) * (most + radius)
                error = len(b.values) * (error - b.size * x.size * most) >> 2 * self.bits
                gaps = [found[column[t]] >> 2 * self.bits for t in at]
                yield Group(list(at.values()), gaps, error + 4)

    def exactly(self, tree: Tree, weights: Weights) -> Fraction:
        """Return |b Phi(tree) - 1 / gamma(tree)| itself in units."""
        tables = {c: (A, [weights.row]) for c, A in self.tables.items()}
        slopes = Series.of_tables(tables).derivative(tree)
        gap = cast("Fraction", dot(weights.row, slopes)) - Fraction(1, gamma(tree))
        return abs(gap) * self.one


@lru_cache(maxsize=1)
def sizes_of(tables: Tables, palette: Palette, system: str, nystrom: bool, exponent: int) -> Sizes:
    """Return the conditions of tables, pairs of a colour and rows, for sizes near 10^-exponent."""
    rows = {c: [list(row) for row in A] for c, A in tables}
    return Sizes(rows, palette, system, nystrom, 192 + 4 * exponent)
