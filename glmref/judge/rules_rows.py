"""Rules for embedded rows, row sums and dense output (section 5)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property, partial

from .arithmetic import Fraction
from .claims import ABSENT
from .document import Component, Method, gaps_of_rows
from .linalg import apply, dot, identity, is_exact, kernel, less, minus, ones, transpose
from .numbers import apart, inverse, total, vanishes
from .proof import Part, Proof, read_parts
from .refusals import as_object, require, whole
from .rule import Bound, Case, Fails, NoWitness, Order, RowOrder, Rule, Truth, either_way
from .series import Series
from .trees import Tree, gamma, size, trees

PAGE = "docs/certificates.md, section 4"
DENSE = "Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), II.6"


def differences_of(method: Method) -> list:
    """Return the sum of the weights of each estimate; of a Nystrom method those of q' left out.

    Of class glm return what each estimate is for y' = 0 and y' = 1, for all values that are exact.
    """
    require(method.rows(), "no rows are embedded")
    if method.kind == "glm":
        return [
            x for weights, _ in method.rows().values() for x in estimates(method, *weights["o"])
        ]
    return [total(w[1:] if method.kind == "nystrom" and c == "f" else w)
            for _, estimate in method.rows().values() for c, w in estimate.items()]  # fmt: skip


def estimates(method: Method, b: list, v: list) -> list:
    """Return d u and x e 1 + d v of the row (b, v) for a basis of all (u, v, x).

    e = w B - b, d = w V - v; V u = u, U u = x 1, w u = x, x B 1 + V v = u + v. Return a 1 where no
    x is 1.
    """
    m = method.single()
    require(all(map(is_exact, (m.U, m.B, m.V))), "values in decimals")
    constants, both = exact_values(m, method.declared.get("o"))
    if not any(x[-1] for x in both):
        return [Fraction(1)]
    w = method.declared.get("o") or fixed_output(m, constants)
    require(len(b) == len(m.A) and len(v) == m.r, "embedded has another length")
    e, d = less(apply(transpose(m.B), w), b), less(apply(transpose(m.V), w), v)
    return [y for x in both
            for y in (dot(d, x[: m.r]), total(e) * x[-1] + dot(d, x[m.r : -1]))]  # fmt: skip


def exact_values(m: Component, w: list | None) -> tuple[list, list]:
    """Return bases of all (u, x) and of all (u, v, x) whose values are exact for y' = 0 and 1."""
    shift, nil = minus(m.V, identity(m.r)), [Fraction(0)] * m.r
    outside = [[*row, Fraction(-1)] for row in [*m.U, *([w] if w else [])]]
    constants = kernel([[*row, Fraction(0)] for row in shift] + outside)
    slopes = zip(shift, identity(m.r), apply(m.B, ones(len(m.B[0]))), strict=True)
    both = kernel([[*row, *nil, Fraction(0)] for row in shift]
                  + [[*row[:-1], *nil, row[-1]] for row in outside]
                  + [[*(-x for x in unit), *row, x] for row, unit, x in slopes])  # fmt: skip
    return constants, both


def fixed_output(m: Component, constants: list) -> list:
    """Return the row that divides the first value that is not 0 by u there, the same for all u."""
    k = next(k for k in range(m.r) if any(x[k] for x in constants))
    u = next(x[k] * inverse(x[-1]) for x in constants if x[-1])
    require(vanishes([x[k] - u * x[-1] for x in constants]), "the output is not fixed")
    return [inverse(u) if j == k else Fraction(0) for j in range(m.r)]


def gaps_of_end(method: Method) -> list:
    """Return b(1) - b."""
    ends = [total(x) for x in method.matrix("dense")]
    return less(ends, method.single().B[0])


@dataclass(frozen=True)
class Row:
    """The name of a row and the parts about it."""

    row: str
    parts: list


@dataclass(frozen=True)
class DenseWitness:
    """An order and a tree of the next one."""

    order: Order
    tree: Tree


class RowCase(Case):
    """A part about the order of the method with the weights of an embedded row."""

    witness: Row

    @cached_property
    def rows(self) -> dict:
        """Return the weights of the rows of the file by name."""
        return self.method.rows()

    @property
    def name(self) -> str:
        """Return the name of the row."""
        return self.witness.row

    @cached_property
    def parts(self) -> tuple[Part, ...]:
        """Return the parts about the row."""
        return read_parts(self.witness.parts, self.proof.table)

    @cached_property
    def names(self) -> list[str]:
        """Return the rules of the parts."""
        return [part.rule for part in self.parts]

    @cached_property
    def bound(self) -> Bound:
        """Return what the parts show of the order of the row."""
        method = self.method.with_row(self.rows[self.name][0]).for_claim("order")
        inner = self.proof.of_row(self.name, method)
        for part in self.parts:
            inner.apply(part)
        if self.names == ["no-order-1"]:
            return Bound("order", 0, 0, True, self.method.kind == "nystrom")
        return inner.known["order"]


def row_is_one_of_the_file(case: RowCase) -> bool:
    """The file has a row of the name in `embedded`."""
    return case.name in case.rows


def parts_bound_the_order(case: RowCase) -> bool:
    """The parts are a lower and an upper bound, or `no-order-1`; where it fails one is enough."""
    low, high = "order-at-least", "order-at-most"
    at_root = case.proof.record.root is not None
    both = [["implied-order", high]] if at_root else [[low, high], ["no-order-1"]]
    return case.names in both or case.names in (
        [[high]] if case.proof.holds else [[high], [low], ["implied-order"]]
    )


def order_is_that_of_the_solution(case: RowCase) -> bool:
    """The order is that of the solution, principal `identity`, on the trees of the class."""
    kinds = (True, "nystrom-paths") if case.method.kind == "nystrom" else (False,)
    return case.bound.identity and case.bound.trees in kinds


def check_rows(holds: bool, declared: Mapping[str, object], names: set, found: list) -> None:
    """Refuse orders of rows that do not decide what is declared: of all rows, or of one."""
    orders = {x.row: x for x in found}
    require(len(orders) == len(found) and set(declared) == names, "rows")
    if holds:
        require(set(orders) == names, "a row is missing")
        require(all(x.low == x.high == declared[x.row] for x in found),
                "the order of a row is not shown to be this")  # fmt: skip
    else:
        require(any(not x.low <= whole(declared[x.row]) <= x.high for x in found),
                "the rows may have the orders")  # fmt: skip


class RowsCase(Case):
    """A part about numbers of the file that are all 0, or not."""

    def __init__(self, gaps: Callable[[Method], list], proof: Proof, witness: object) -> None:
        super().__init__(proof, witness)
        self.numbers = gaps(self.method)


def all_numbers_are_0(case: RowsCase) -> bool:
    """Every number is 0."""
    return vanishes(case.numbers)


def a_number_is_not_0(case: RowsCase) -> bool:
    """Some number is not 0."""
    return any(map(apart, case.numbers))


class AbsentCase(Case):
    """A part about what the file does not have, which settles the claim."""

    @cached_property
    def rule(self) -> tuple[str, object]:
        """Return the key that the claim is about, and the value of the claim without it."""
        return ABSENT.get(self.proof.claim, ("", None))

    @property
    def named(self) -> bool:
        """Tell whether the claim names rows."""
        return self.proof.claim == "embedded-order"


def claim_is_about_a_part_of_the_file(case: AbsentCase) -> bool:
    """The claim is about something that a file may have beside its method."""
    return case.proof.claim in ABSENT


def file_has_it_not(case: AbsentCase) -> bool:
    """The file has it not; for `embedded-order` it has no rows, or others than are declared."""
    if not case.named:
        return case.rule[0] not in case.method.document
    rows = set(case.method.rows()) if case.rule[0] in case.method.document else set()
    return not rows or rows != set(as_object(case.proof.declared))


def pairs_without_a_start_have_one(case: AbsentCase) -> bool:
    """The claim is not about the start of a pair, which is (y0, 0, ..) where the file has none."""
    return case.rule[0] != "starting" or not case.method.pair


def value_is_that_without_it(case: AbsentCase) -> bool:
    """The claim holds where the declared value is that without it, and `embedded-order` fails."""
    if case.named:
        return not case.proof.holds
    declared, value = case.proof.declared, case.rule[1]
    return (type(declared) is type(value) and declared == value) == case.proof.holds


class DenseCase(Case):
    """A part about the order of b(theta), power by power of theta."""

    witness: DenseWitness

    @cached_property
    def columns(self) -> list:
        """Return the weights of each power of theta."""
        columns = transpose(self.method.matrix("dense"))
        require(len(columns[0]) == len(self.method.single().A), "dense has another length")
        return columns

    @cached_property
    def series(self) -> Series:
        """Return the series of the stages."""
        m = self.method.single()
        return Series.of_tables({"o": (m.A, m.B)})

    def gaps(self, tree: Tree) -> list:
        """Return what must be 0 at a tree, by powers of theta."""
        return dense_gaps(self.columns, self.series, tree)


def dense_gaps(columns: list, series: Series, tree: Tree) -> list:
    """Return the coefficients of b(theta) Phi(t) - theta^|t| / gamma(t)."""
    n = size(tree)
    found = apply(columns, series.derivative(tree))
    found += [Fraction(0)] * (n - len(found))
    found[n - 1] = found[n - 1] - Fraction(1, gamma(tree))
    return found


def c_is_A_1(case: DenseCase) -> bool:
    """c of the file, where it has one, is A 1."""
    return "c" not in case.method.document or vanishes(gaps_of_rows(case.method))


def every_power_is_right(case: DenseCase) -> bool | Fails:
    """The condition holds, power by power of theta."""
    for n in range(1, case.witness.order + 1):
        for tree in trees(case.method.palette, n):
            if not vanishes(case.gaps(tree)):
                return Fails(tree)
    return True


def dense_tree_is_of_the_next_order(case: DenseCase) -> bool:
    """The tree of the witness is one of the next order."""
    return size(case.witness.tree) == case.witness.order + 1 and case.witness.tree in trees(
        case.method.palette, case.witness.order + 1
    )


def a_power_is_wrong(case: DenseCase) -> bool:
    """The condition of the tree does not hold."""
    return any(map(apart, case.gaps(case.witness.tree)))


def all_or_not(names: str, claim: str, gaps: Callable[[Method], list]) -> tuple[Rule, Rule]:
    """Return the rules that the numbers of a case are all 0, and that one is not."""
    return either_way(names, claim, "the definition", PAGE, partial(RowsCase, gaps),
                      (all_numbers_are_0,), (a_number_is_not_0,))  # fmt: skip


ROW_RULES = (
    Rule(
        "row", "embedded-order", "holds", "the definition", PAGE, Row, RowCase,
        (row_is_one_of_the_file, parts_bound_the_order, order_is_that_of_the_solution),
        lambda case: RowOrder(
            case.name, case.bound.low or 0, 20 if case.bound.high is None else case.bound.high
        ),
    ),
    *all_or_not("differences no-differences", "embedded-difference", differences_of),
    *all_or_not("row-sums no-row-sums", "row-sums", gaps_of_rows),
    *all_or_not("dense-end no-dense-end", "dense-end", gaps_of_end),
    Rule(
        "absent", "embedded-order", "holds", "the definition", PAGE, NoWitness, AbsentCase,
        (claim_is_about_a_part_of_the_file, file_has_it_not,
         pairs_without_a_start_have_one, value_is_that_without_it),
        lambda case: Truth(case.proof.claim, case.proof.holds),
    ),
    Rule(
        "dense", "dense-order", "at least", "the conditions of order for b(theta)",
        DENSE, DenseWitness, DenseCase,
        (c_is_A_1, every_power_is_right, dense_tree_is_of_the_next_order, a_power_is_wrong),
        lambda case: Bound("dense-order", case.witness.order, case.witness.order, True),
    ),
    Rule(
        "not-dense", "dense-order", "at most", "one condition that fails excludes the order",
        DENSE, DenseWitness, DenseCase, (dense_tree_is_of_the_next_order, a_power_is_wrong),
        lambda case: Bound("dense-order", None, case.witness.order, True),
    ),
)  # fmt: skip
