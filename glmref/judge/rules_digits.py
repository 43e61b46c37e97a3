"""Rules for orders that hold to the printed digits (section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from .arithmetic import RATIONAL, Fraction
from .document import Method
from .fixed_point import Sizes, Weights, sizes_of
from .grammar import two_digits
from .numbers import floor
from .refusals import Document, Malformed, as_object, require, whole
from .rule import Case, Fails, Order, Rule, read_witness
from .trees import Tree, is_coloured, is_nystrom, size, stands

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
        return sizes_of(tuple(tables), self.base.palette, self.base.system,
                        self.method.kind == "nystrom",
                        max(x.exponent for x in self.declared.values()))  # fmt: skip

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
            if order < high - 1:
                self.sizes.prepare(self.sizes.level(order))
            if order >= low:
                for tree in self.sizes.above(order, self.weights[name], floor(limit)):
                    if self.residual(name, tree, limit)[1] > limit:
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
