"""Rules for orders that hold to the printed digits (section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache
from operator import mul
from typing import TypeAlias, cast

from .arithmetic import RATIONAL, Fraction, products_of_whole
from .document import Method
from .grammar import two_digits
from .linalg import dot
from .numbers import floor
from .refusals import Document, Malformed, as_object, require, whole
from .rule import Case, Fails, Order, Rule, read_witness
from .series import Series
from .trees import Tree, gamma, is_coloured, is_nystrom, pool_of, size, stands

#: Pairs of a colour and the rows of A.
Tables: TypeAlias = "tuple[tuple[str, tuple[tuple[Fraction, ...], ...]], ...]"
SECTION_5 = "docs/certificates.md, section 5"


@dataclass(frozen=True)
class Declared:
    """What is declared of a row: its order; the residuals are at most `most`, one above `least`."""

    order: int
    most: Fraction
    least: Fraction
    exponent: int

    @classmethod
    def of(cls, value: object) -> Declared:
        """Return what a claim says of one row: an order and a size of two digits."""
        if not isinstance(value, list) or len(value) != 2:
            raise Malformed("an order and a size are declared of a row")
        most, least = two_digits(value[1])
        return cls(whole(value[0], 1, 14), most, least, int(value[1].partition("e-")[2]))


class Fixed:
    """Numbers in units of 2^-bits with errors of at most `radius`; `size` is the largest."""

    __slots__ = ("radius", "size", "values")

    def __init__(self, values: list[int], radius: int) -> None:
        self.values, self.radius = values, radius
        self.size = max(map(abs, values))


@dataclass(frozen=True)
class Weights:
    """A row of weights, in units b, b A by colour, and bounds of residuals by tree.

    `most` has those of whole orders, from above only: see :meth:`Sizes.bound`.
    """

    row: list[Fraction]
    b: Fixed
    before: dict[str, Fixed]
    known: dict[Tree, tuple[int, int]]
    most: dict[Tree, int]


class Sizes:
    """Conditions of a method that carries one value, in integers over 2^bits with their errors.

    Parameters
    ----------
    tables : dict
        A by colour, rows of rational numbers.
    bits : int
        Numbers are integers over 2^bits, below what they stand for by less than 1.
    """

    def __init__(self, tables: dict[str, list[list[Fraction]]], bits: int) -> None:
        self.tables, self.bits, self.one = tables, bits, 1 << bits
        self.A = {c: [self.whole(row) for row in A] for c, A in tables.items()}
        self.norm = {c: max(sum(map(abs, x)) + len(x) for x in A) for c, A in self.A.items()}
        self.products = {c: Fixed([self.one] * len(A[0]), 0) for c, A in tables.items()}
        self.phis: dict[Tree, Fixed] = {}
        self.images: dict[Tree, Fixed] = {}
        self.rows: dict[tuple[Fraction, ...], Weights] = {}

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

    def bound(self, level: list[Tree], weights: dict[str, Weights]) -> None:
        """Bound the residuals of trees of one order from above, all in products of matrices.

        b Phi(t) is sum b_i x_i y_i, x of the tree without the last branch and y of that branch. If
        none is off by more than r, the product is by (b + rb) (x + rx) (y + ry) - b x y at most.
        """
        groups: dict[tuple, dict[Tree, dict[Tree, Tree]]] = {}
        for tree in level:
            alone = len(tree[1]) == 1
            colour, children = tree[1][0] if alone else tree
            if len(children) > 1 and tree not in weights[tree[0]].most:
                key = tree[0], colour if alone else "", size(children[-1])
                before = groups.setdefault(key, {}).setdefault((colour, children[:-1]), {})
                before[children[-1]] = tree
        for (root, below, _), trees in groups.items():
            row, most = weights[root], weights[root].most
            b = self.before(row, below) if below else row.b
            firsts = [self.phi(t) for t in trees]
            place = {
                t: k for k, t in enumerate(dict.fromkeys(t for x in trees.values() for t in x))
            }
            lasts = [self.below(t) for t in place]
            rows = [list(map(mul, b.values, x.values)) for x in firsts]
            products = products_of_whole(rows, [y.values for y in lasts])
            for x, branches, found in zip(firsts, trees.values(), products, strict=True):
                for branch, tree in branches.items():
                    y, n = lasts[place[branch]], len(b.values)
                    error = (b.size + b.radius) * (x.size + x.radius) * (y.size + y.radius)
                    error = n * (error - b.size * x.size * y.size) >> 2 * self.bits
                    gap = (found[place[branch]] >> 2 * self.bits) - self.one // gamma(tree)
                    most[tree] = abs(gap) + error + 3

    def most(self, tree: Tree, weights: Weights) -> int:
        """Return a bound of the residual from above, that of its order where it is known."""
        found = weights.most.get(tree)
        return self.residual(tree, weights)[1] if found is None else found

    def exactly(self, tree: Tree, weights: Weights) -> Fraction:
        """Return |b Phi(tree) - 1 / gamma(tree)| itself in units."""
        tables = {c: (A, [weights.row]) for c, A in self.tables.items()}
        slopes = Series.of_tables(tables).derivative(tree)
        gap = cast("Fraction", dot(weights.row, slopes)) - Fraction(1, gamma(tree))
        return abs(gap) * self.one


@lru_cache(maxsize=1)
def sizes_of(
    tables: tuple[tuple[str, tuple[tuple[Fraction, ...], ...]], ...], exponent: int
) -> Sizes:
    """Return the conditions of tables, pairs of a colour and rows, for sizes near 10^-exponent."""
    return Sizes({c: [list(row) for row in A] for c, A in tables}, 192 + 4 * exponent)


class DigitsCase(Case):
    """A part about the residuals of the rows of weights, and what is declared of them."""

    @cached_property
    def rows(self) -> dict:
        """Return the weights of the rows of `embedded` by name."""
        return self.method.rows()

    @cached_property
    def declared(self) -> dict[str, Declared]:
        """Return what is declared by name of the row."""
        return {name: Declared.of(value) for name, value in as_object(self.proof.declared).items()}

    @cached_property
    def base(self) -> Method:
        """Return the method that the claim is about, with c apart where the file has it."""
        return self.method.for_claim("order")

    def with_weights(self, name: str) -> Method:
        """Return the method with the weights of a row."""
        if name == "b":
            return self.base
        require(name in self.rows, "no row of embedded has the name")
        return self.method.with_row(self.rows[name][0]).for_claim("order")

    @cached_property
    def sizes(self) -> Sizes:
        """Return the conditions in integers with bits for the smallest number declared."""
        tables = ((c, tuple(tuple(map(Fraction, row)) for row in m.A))
                  for c, m in self.base.parts.items())  # fmt: skip
        return sizes_of(tuple(tables), max(x.exponent for x in self.declared.values()))

    @cached_property
    def weights(self) -> dict[str, dict[str, Weights]]:
        """Return the weights by name and colour."""
        return {name: {c: self.sizes.weights(list(map(Fraction, m.B[0])))
                       for c, m in self.with_weights(name).parts.items()}
                for name in self.declared}  # fmt: skip

    def counted(self, tree: Tree) -> bool:
        """Tell whether the claim is about the condition of a tree."""
        palette, nystrom = self.base.palette, self.method.kind == "nystrom"
        fine = is_coloured(tree, palette) and stands(tree, self.base.system)
        return fine and (is_nystrom(tree) or not nystrom)

    def residual(self, name: str, tree: Tree, limit: Fraction) -> tuple:
        """Return bounds of a residual in units, itself where the limit is between them."""
        weights = self.weights[name][tree[0]]
        low, high = self.sizes.residual(tree, weights)
        if low <= limit < high:
            low = high = self.sizes.exactly(tree, weights)
        return low, high

    def exceeds(self, name: str, tree: Tree, limit: Fraction) -> bool:
        """Tell whether the residual of a tree is above a number."""
        limit = limit * self.sizes.one
        return self.residual(name, tree, limit)[0] > limit

    def none_above(self, name: str, low: int, high: int, limit: Fraction) -> bool | Fails:
        """Tell whether no residual of these orders is above a number."""
        limit = limit * self.sizes.one
        for order in range(1, high + 1):
            level = pool_of(self.base, order, self.method.kind == "nystrom")
            if order < high - 1:
                self.sizes.prepare(level)
            elif order >= low:
                self.sizes.bound(level, self.weights[name])
            for tree in level if order >= low else ():
                most = self.sizes.most(tree, self.weights[name][tree[0]])
                if most > limit and self.residual(name, tree, limit)[1] > limit:
                    return Fails(tree)
        return True


@dataclass(frozen=True)
class Residuals:
    """The trees of a row: with the largest residual, and of the next order."""

    largest: Tree
    beyond: Tree


@dataclass(frozen=True)
class ToDigits:
    """The trees of each row by its name."""

    rows: Document


@dataclass(frozen=True)
class NotToDigits:
    """A row, and a tree or an order that refutes what is declared of it."""

    row: str
    tree: Tree | None = None
    order: Order | None = None


class ToDigitsCase(DigitsCase):
    """A part that the residuals of every row are those declared."""

    witness: ToDigits

    @cached_property
    def named(self) -> dict[str, Residuals]:
        """Return the trees by row."""
        return {name: read_witness(Residuals, x, "row of the witness")
                for name, x in self.witness.rows.items()}  # fmt: skip


class NotToDigitsCase(DigitsCase):
    """A part that the residuals of one row are not those declared."""

    witness: NotToDigits

    @property
    def name(self) -> str:
        """Return the name of the row."""
        return self.witness.row

    @cached_property
    def row(self) -> Declared:
        """Return what is declared of the row."""
        require(self.name in self.declared, "no row has this name")
        return self.declared[self.name]


def names_are_those_of_the_file(case: DigitsCase) -> bool:
    """The declared names are `b` and those of the rows of the file."""
    return set(case.declared) == {"b", *case.rows} and "b" not in case.rows


def entries_are_rational(case: DigitsCase) -> bool:
    """The entries are rational, as decimals are that are taken as they stand."""
    methods = map(case.with_weights, case.declared)
    return all(type(x) in RATIONAL for one in methods for m in one.parts.values()
               for row in (*m.A, *m.B) for x in row)  # fmt: skip


def value_carried_is_the_solution(case: DigitsCase) -> bool:
    """The one value that the method carries, with each row of weights, is the solution."""
    parts = [m for name in case.declared for m in case.with_weights(name).parts.values()]
    return all(m.r == 1 and x == 1 for m in parts for row in (*m.U, *m.V) for x in row)


def every_row_is_shown(case: ToDigitsCase) -> bool:
    """The witness has the trees of every row that is declared."""
    return set(case.named) == set(case.declared)


def trees_are_of_their_orders(case: ToDigitsCase) -> bool:
    """`largest` has at most the order of its row, `beyond` the next; both are meant."""
    return all(
        size(x.largest) <= case.declared[name].order == size(x.beyond) - 1
        and case.counted(x.largest) and case.counted(x.beyond)
        for name, x in case.named.items()
    )  # fmt: skip


def residuals_are_within_the_size(case: ToDigitsCase) -> bool | Fails:
    """No residual through the order of its row is above the declared size."""
    for name, row in case.declared.items():
        outcome = case.none_above(name, 1, row.order, row.most)
        if not outcome:
            return outcome
    return True


def a_residual_has_the_size(case: ToDigitsCase) -> bool:
    """The residual of `largest` is above the number of two digits before the declared size."""
    return all(case.exceeds(name, x.largest, case.declared[name].least)
               for name, x in case.named.items())  # fmt: skip


def next_order_is_beyond(case: ToDigitsCase) -> bool:
    """The residual of `beyond` is above 1000 times the declared size."""
    return all(case.exceeds(name, x.beyond, 1000 * case.declared[name].most)
               for name, x in case.named.items())  # fmt: skip


def tree_or_order_refutes(case: NotToDigitsCase) -> bool | Fails:
    """A residual is above the size, or all are below it, or the next order has none beyond."""
    row = case.row
    if case.witness.tree is not None:
        return case.exceeds(case.name, case.witness.tree, row.most)
    if whole(case.witness.order, row.order, row.order + 1) == row.order:
        return case.none_above(case.name, 1, row.order, row.least)
    return case.none_above(case.name, row.order + 1, row.order + 1, 1000 * row.most)


def a_tree_or_an_order_is_named(case: NotToDigitsCase) -> bool:
    """The witness has a tree or an order, not both."""
    return (case.witness.tree is None) is not (case.witness.order is None)


def tree_is_within_the_order(case: NotToDigitsCase) -> bool:
    """The tree has at most the order of its row, and its condition is meant."""
    tree = case.witness.tree
    return tree is None or (size(tree) <= case.row.order and case.counted(tree))


WITH_DIGITS = (names_are_those_of_the_file, entries_are_rational, value_carried_is_the_solution)

DIGIT_RULES = (
    Rule(
        "to-digits", "order-to-digits", "holds", "the definition", SECTION_5,
        ToDigits, ToDigitsCase,
        (*WITH_DIGITS, every_row_is_shown, trees_are_of_their_orders, residuals_are_within_the_size,
         a_residual_has_the_size, next_order_is_beyond),
    ),
    Rule(
        "not-to-digits", "order-to-digits", "fails", "the definition", SECTION_5,
        NotToDigits, NotToDigitsCase,
        (*WITH_DIGITS, a_tree_or_an_order_is_named, tree_is_within_the_order,
         tree_or_order_refutes),
    ),
)  # fmt: skip
