"""Rules for orders that hold to the printed digits (section 5)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from operator import itemgetter, mul
from typing import cast

from .arithmetic import RATIONAL, Fraction
from .document import Method
from .grammar import two_digits
from .linalg import dot
from .numbers import floor
from .refusals import Document, Malformed, as_object, require, whole
from .rule import Case, Fails, Order, Rule, Truth, read_witness
from .series import Series
from .trees import Tree, gamma, is_coloured, is_nystrom, read_tree, size, stands, trees

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


class Sizes:
    """Conditions of a method that carries one value, in integers over 2^bits with their errors."""

    def __init__(self, method: Method, bits: int) -> None:
        self.method, self.bits, self.known = method, bits, {}
        self.A = {c: [self.whole(row) for row in m.A] for c, m in method.parts.items()}
        self.sparse = {c: [([x for x in row if x], [j for j, x in enumerate(row) if x])
                           for row in rows] for c, rows in self.A.items()}  # fmt: skip
        self.width = {c: len(rows[0]) for c, rows in self.A.items()}
        self.norm = {c: max(sum(map(abs, x)) + len(x) for x in A) for c, A in self.A.items()}

    def whole(self, row: list) -> list[int]:
        """Return the integers below 2^bits times rational numbers."""
        return [floor(Fraction(x) * 2**self.bits) for x in row]

    def phi(self, tree: Tree, keep: bool = True) -> tuple[list[int], int]:
        """Return (values, error) of the product over the children of A Phi(child)."""
        if tree not in self.known:
            found = [1 << self.bits] * self.width[tree[0]], 0
            for n, child in enumerate(tree[1]):
                found = self.product(found, self.below(child)) if n else self.below(child)
            if not keep:
                return found
            self.known[tree] = found
        return self.known[tree]

    def product(
        self, left: tuple[list[int], int], right: tuple[list[int], int]
    ) -> tuple[list[int], int]:
        """Return the product place by place: |dx y + x dy + dx dy|, and 1 for the shift."""
        (x, dx), (y, dy) = left, right
        top = max(map(abs, x)) * dy + max(map(abs, y)) * dx + dx * dy
        return [a * b >> self.bits for a, b in zip(x, y, strict=True)], (top >> self.bits) + 2

    def below(self, tree: Tree) -> tuple[list[int], int]:
        """Return A Phi(tree), A that of the colour of the root."""
        key = (tree, "below")
        if key not in self.known:
            x, dx = self.phi(tree)
            error = self.norm[tree[0]] * dx + sum(map(abs, x)) + len(x) * dx
            rows = [sum(map(mul, row, itemgetter(*places)(x))) if len(places) > 1
                    else sum(a * x[j] for a, j in zip(row, places, strict=True))
                    for row, places in self.sparse[tree[0]]]  # fmt: skip
            self.known[key] = [y >> self.bits for y in rows], (error >> self.bits) + 2
        return self.known[key]

    def residual(self, tree: Tree, b: list[int], keep: bool = True) -> tuple[Fraction, Fraction]:
        """Return bounds of |b Phi(tree) - 1 / gamma(tree)| for integers b."""
        x, dx = self.phi(tree, keep)
        error = sum(map(abs, b)) * dx + sum(map(abs, x)) + len(x) * dx
        gap = sum(map(mul, b, x)) >> self.bits
        gap = abs(gap - (1 << self.bits) // gamma(tree))
        error = (error >> self.bits) + 3
        unit = Fraction(1, 1 << self.bits)
        return (gap - error) * unit, (gap + error) * unit

    def exactly(self, tree: Tree, b: list) -> Fraction:
        """Return |b Phi(tree) - 1 / gamma(tree)| itself, of rational numbers."""
        parts = {c: (m.A, m.B) for c, m in self.method.parts.items()}
        slopes = Series.of_tables(parts).derivative(tree)
        return abs(cast("Fraction", dot(b, slopes)) - Fraction(1, gamma(tree)))


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
        return Sizes(self.base, 256 + 4 * max(x.exponent for x in self.declared.values()))

    @cached_property
    def weights(self) -> dict[str, dict[str, tuple[list, list]]]:
        """Return by name and colour the weights, and what they are in integers."""
        return {name: {c: (m.B[0], self.sizes.whole(m.B[0]))
                       for c, m in self.with_weights(name).parts.items()}
                for name in self.declared}  # fmt: skip

    def counted(self, tree: Tree) -> bool:
        """Tell whether the claim is about the condition of a tree."""
        palette, nystrom = self.base.palette, self.method.kind == "nystrom"
        fine = is_coloured(tree, palette) and stands(tree, self.base.system)
        return fine and (is_nystrom(tree) or not nystrom)

    def trees(self, low: int, high: int) -> Iterator[Tree]:
        """Return the trees of these orders whose conditions are meant."""
        level = (t for n in range(low, high + 1) for t in trees(self.base.palette, n))
        return filter(self.counted, level)

    def residual(self, name: str, tree: Tree, *limits: Fraction, keep: bool = True) -> tuple:
        """Return bounds of a residual, itself where a limit is between them."""
        exact, scaled = self.weights[name][tree[0]]
        low, high = self.sizes.residual(tree, scaled, keep)
        if any(low <= x < high for x in limits):
            low = high = self.sizes.exactly(tree, exact)
        return low, high

    def exceeds(self, name: str, tree: Tree, limit: Fraction) -> bool:
        """Tell whether the residual of a tree is above a number."""
        return self.residual(name, tree, limit, keep=False)[0] > limit

    def none_above(self, name: str, low: int, high: int, limit: Fraction) -> bool | Fails:
        """Tell whether no residual of these orders is above a number."""
        for tree in self.trees(low, high):
            if self.residual(name, tree, limit, keep=size(tree) < high)[1] > limit:
                return Fails(tree)
        return True


@dataclass(frozen=True)
class Residuals:
    """The trees of a row: with the largest residual, and of the next order."""

    largest: str
    beyond: str


@dataclass(frozen=True)
class ToDigits:
    """The trees of each row by its name."""

    rows: Document


@dataclass(frozen=True)
class NotToDigits:
    """A row, and a tree or an order that refutes what is declared of it."""

    row: str
    tree: str | None = None
    order: Order | None = None


class ToDigitsCase(DigitsCase):
    """A part that the residuals of every row are those declared."""

    witness: ToDigits

    @cached_property
    def named(self) -> dict[str, tuple[Tree, Tree]]:
        """Return by row the trees `largest` and `beyond`."""
        rows = {name: read_witness(Residuals, x, "row of the witness")
                for name, x in self.witness.rows.items()}  # fmt: skip
        return {name: (read_tree(x.largest), read_tree(x.beyond)) for name, x in rows.items()}


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

    @cached_property
    def tree(self) -> Tree:
        """Return the tree of the witness."""
        return read_tree(self.witness.tree)


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
        size(largest) <= case.declared[name].order == size(beyond) - 1
        and case.counted(largest) and case.counted(beyond)
        for name, (largest, beyond) in case.named.items()
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
    return all(case.exceeds(name, largest, case.declared[name].least)
               for name, (largest, _) in case.named.items())  # fmt: skip


def next_order_is_beyond(case: ToDigitsCase) -> bool:
    """The residual of `beyond` is above 1000 times the declared size."""
    return all(case.exceeds(name, beyond, 1000 * case.declared[name].most)
               for name, (_, beyond) in case.named.items())  # fmt: skip


def tree_or_order_refutes(case: NotToDigitsCase) -> bool | Fails:
    """A residual is above the size, or all are below it, or the next order has none beyond."""
    row = case.row
    if case.witness.tree is not None:
        return case.exceeds(case.name, case.tree, row.most)
    if whole(case.witness.order, row.order, row.order + 1) == row.order:
        return case.none_above(case.name, 1, row.order, row.least)
    return case.none_above(case.name, row.order + 1, row.order + 1, 1000 * row.most)


def a_tree_or_an_order_is_named(case: NotToDigitsCase) -> bool:
    """The witness has a tree or an order, not both."""
    return (case.witness.tree is None) is not (case.witness.order is None)


def tree_is_within_the_order(case: NotToDigitsCase) -> bool:
    """The tree has at most the order of its row, and its condition is meant."""
    if case.witness.tree is None:
        return True
    return size(case.tree) <= case.row.order and case.counted(case.tree)


WITH_DIGITS = (names_are_those_of_the_file, entries_are_rational, value_carried_is_the_solution)

DIGIT_RULES = (
    Rule(
        "to-digits", "order-to-digits", "holds", "the definition", SECTION_5,
        ToDigits, ToDigitsCase,
        (*WITH_DIGITS, every_row_is_shown, trees_are_of_their_orders, residuals_are_within_the_size,
         a_residual_has_the_size, next_order_is_beyond),
        lambda case: Truth("order-to-digits"),
    ),
    Rule(
        "not-to-digits", "order-to-digits", "fails", "the definition", SECTION_5,
        NotToDigits, NotToDigitsCase,
        (*WITH_DIGITS, a_tree_or_an_order_is_named, tree_is_within_the_order,
         tree_or_order_refutes),
        lambda case: Truth("order-to-digits", False),
    ),
)  # fmt: skip
