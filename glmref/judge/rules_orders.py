"""Rules for orders and stage orders (sections 4 and 6)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from .arithmetic import Fraction
from .document import Method
from .linalg import apply, is_exact, kernel, less, ones
from .numbers import apart, total, vanishes
from .refusals import not_covered, require, shown
from .rule import Bound, Case, Fails, NoWitness, Order, Rule
from .series import Solved, path_orders
from .trees import (
    PATHS,
    Tree,
    gamma,
    is_coloured,
    is_nystrom,
    mode,
    paths,
    pool_of,
    read_tree,
    size,
    stands,
    through,
)

BUTCHER = "Butcher, Numerical Methods for Ordinary Differential Equations (2016), section 530"
UNIQUE = "docs/certificates.md, section 4 (why two starting series agree below the order)"


def counts(method: Method, tree: Tree | None, order: int, which: bool | str) -> bool:
    """Tell whether a tree is one of an order that counts for a method."""
    if tree is None or size(tree) != order:
        return False
    if which in PATHS:
        return tree in paths(method.palette, order)
    return (
        is_coloured(tree, method.palette)
        and stands(tree, method.system)
        and (not which or is_nystrom(tree))
    )


@dataclass(frozen=True)
class OrderWitness:
    """An order, its principal part, `free` or `identity`, and the trees that count."""

    order: Order
    principal: str
    trees: str


@dataclass(frozen=True)
class OrderAtMost(OrderWitness):
    """The order and a tree of the next one."""

    tree: Tree | None = None


def bound(about: str, p: int, low: bool, kind: tuple[bool, bool | str]) -> Bound:
    """Return a lower or an upper bound of an order of a kind."""
    return Bound(about, p if low else None, None if low else p, *kind)


class OrderCase(Case):
    """A part about the order p of a method: principal part, trees, series."""

    witness: OrderAtMost  # those of lower bounds have no tree

    @cached_property
    def kind(self) -> tuple[bool, bool | str]:
        """Return the principal part and the trees that the witness names."""
        return mode(self.witness.principal, self.witness.trees)

    @property
    def along_paths(self) -> bool:
        """Tell whether trees without branches stand for all."""
        return self.kind[1] in PATHS

    @property
    def order(self) -> int:
        """Return p."""
        return self.witness.order

    def series(self, order: int) -> Solved:
        """Return the starting series, ready for the conditions of an order."""
        return self.proof.series(*self.kind, order)

    def shows(self, about: str, holds: bool) -> Bound:
        """Return a bound of the order, of this kind."""
        return bound(about, self.order, holds, self.kind)


@dataclass(frozen=True)
class OfColour:
    """The colour of a component."""

    colour: str


class ComponentCase(Case):
    """A part about u and v of every component, or of one colour."""

    witness: OfColour

    def exists(self, colour: str, consistent: bool) -> bool:
        """Tell whether the vectors of a component exist."""
        return self.method.vectors_to_one(colour, consistent)[0] is not None


def u_exists(case: ComponentCase) -> bool:
    """Every component has some u with V u = u and U u = 1."""
    return all(case.exists(c, False) for c in case.method.parts)


def u_and_v_exist(case: ComponentCase) -> bool:
    """Every component has u and v with V u = u, U u = 1 and B 1 + V v = u + v."""
    return all(case.exists(c, True) for c in case.method.parts)


def no_u_exists(case: ComponentCase) -> bool:
    """No u has V u = u and U u = 1."""
    return not case.exists(case.witness.colour, False)


def no_u_and_v_exist(case: ComponentCase) -> bool:
    """No u and v have V u = u, U u = 1 and B 1 + V v = u + v."""
    return not case.exists(case.witness.colour, True)


# ---------------------------------------------------------------------------- order


def stages_begin_at_the_solution(case: OrderCase) -> bool:
    """U u = 1 for every component."""
    parts = case.method.parts
    return all(
        vanishes(less(apply(parts[c].U, u), ones(len(parts[c].U))))
        for c, u in case.series(case.order).u.items()
    )


def conditions_hold(case: OrderCase) -> bool | Fails:
    """W R(t) = 0 for every tree t through the order."""
    series = case.series(case.order)
    for tree in through(case.method, case.order, case.kind[1]):
        if not vanishes(series.condition(tree)):
            return Fails(tree)
    return True


def paths_stand_for_trees(case: OrderCase) -> bool:
    """Trees without branches decide for pairs with the simple eigenvalue 1 of each V."""
    if not case.along_paths:
        return True
    known = case.method.separable or case.kind[1] == "paths"
    return known and case.method.pair and case.series(case.order).simple


def shared_stages_have_one_time(case: OrderCase) -> bool:
    """Along trees without branches, shared stages have the same abscissae for Q and P."""
    if not case.along_paths or case.method.separable:
        return True
    series = case.series(case.order)
    return vanishes(less(*(series.stages((c, ())) for c in "fk")))


def stages_are_right_along_paths(case: OrderCase) -> bool:
    """On trees without branches below the order the stages that count are the solution."""
    p = case.order
    if not case.along_paths or p < 2:
        return True
    series = case.series(p)
    return all(
        min(path_orders(case.method, series, c, p - 1)) >= p - 1 for c in PATHS[str(case.kind[1])]
    )


def lower_bound_is_shown_along_paths(case: OrderCase) -> bool:
    """Along trees without branches the lower bound of the same order is shown before."""
    known = case.known("order")
    return not case.along_paths or (known.low == case.order and known.kind == case.kind)


def tree_is_of_the_next_order(case: OrderCase) -> bool:
    """The tree of the witness is one of the next order that counts."""
    if case.along_paths or (case.order and not case.series(case.order + 1).simple):
        return True  # all conditions of the next order are looked at
    return counts(case.method, case.witness.tree, case.order + 1, case.kind[1])


def next_order_fails(case: OrderCase) -> bool:
    """A condition of the next order is not 0 whatever the principal parts are."""
    p = case.order
    series = case.series(p + 1)
    if case.along_paths:
        gaps = [x for t in pool_of(case.method, p + 1, case.kind[1]) for x in series.condition(t)]
        # a free principal part may be added to one of them, and is taken away at the other
        return any(map(apart, gaps if case.kind[0] else [total(gaps)]))
    if p and not series.simple:
        return series.last == p and not series.loose
    return any(map(apart, series.condition(shown(case.witness.tree, "the tree is missing"))))


def theorem_is_about_the_method(case: OrderCase) -> bool:
    """The method is symmetric, or carries the solution only, and the trees are not paths."""
    root = case.proof.root()
    return not case.along_paths and root.is_of_the_theorem(*case.kind, case.proof.row)


def principal_parts_are_0(case: OrderCase) -> bool:
    """The principal parts below the order, where the theorem needs them, are 0."""
    return case.proof.root().principal_is_zero(case.order, *case.kind)


def equations_give_the_order(case: OrderCase) -> bool:
    """The equations of the enclosure give the conditions of every order through p."""
    root = case.proof.root()
    return root.gives_order(case.order, case.kind[1], case.proof.row, case.method)


# ---------------------------------------------------------------------------- stage order


@dataclass(frozen=True)
class AtLeast:
    """A lower bound."""

    q: Order


@dataclass(frozen=True)
class AtMost(AtLeast):
    """An upper bound, and a tree of the order after it; the empty text stands for u."""

    tree: str | None = None


class BoundCase(Case):
    """A part about a bound q of an order that rests on the order of the method."""

    witness: AtMost  # those of lower bounds have no tree

    @property
    def q(self) -> int:
        """Return the bound."""
        return self.witness.q

    @cached_property
    def order(self) -> Bound:
        """Return what is known of the order of the method."""
        return self.known("order")

    @property
    def kind(self) -> tuple[bool, bool | str]:
        """Return the kind of the order of the method, else that of the claim."""
        shown = self.order.low is not None
        return self.order.kind if shown else self.proof.mode()

    def shows(self, about: str, holds: bool) -> Bound:
        """Return a bound of the same kind as that of the order."""
        return bound(about, self.q, holds, self.kind)

    @property
    def most(self) -> int:
        """Return the order of the method; where it is not known one above q, which q is not."""
        return self.q + 1 if self.order.high is None else self.order.high

    @property
    def is_the_order(self) -> bool:
        """Tell whether q is the order of the method, which nothing exceeds."""
        return self.q == self.most

    @cached_property
    def tree(self) -> Tree:
        """Return the tree of the witness, which must be one of order q + 1."""
        tree = read_tree(self.witness.tree)
        fine = counts(self.method, tree, self.q + 1, self.kind[1])
        require(fine, "the tree has another order")
        return tree


def bound_is_below_the_order(case: BoundCase) -> bool:
    """The order is shown to be at least the bound."""
    return case.order.low is not None and case.q <= case.order.low


def series_is_that_of_the_order(case: BoundCase) -> bool:
    """Both bounds of the order are shown, or the series is the only one without them."""
    order = case.order
    return (
        order.enclosed
        or (order.high is not None and case.q < order.high)
        or (order.identity and case.proof.mode()[0])
    )


def order_is_enclosed_or_open(case: BoundCase) -> bool:
    """Where the order is bounded above, its bounds agree."""
    return case.order.high is None or case.order.enclosed


def bound_is_at_most_the_order(case: BoundCase) -> bool:
    """The bound is at most the order."""
    return case.q <= case.most


def principal_parts_are_unique(case: BoundCase) -> bool:
    """Below the bound no other principal parts satisfy the conditions.

    Along trees without branches they are 0, which the order shows: `free` ones may be others above.
    """
    free_paths = case.kind[1] in PATHS and not case.kind[0]
    if free_paths and not case.is_the_order and case.q >= (case.order.low or 0):
        return False
    return case.is_the_order or not case.proof.series(*case.kind, case.q + 1, filled=True).loose


def stage_defect(series: Solved, tree: Tree, last: bool) -> list:
    """Return xi(t) - c^|t| / gamma(t), z times it at the `last` order: U N beta may be added there.

    z are the rows with z U N = 0; c is what the stages are at the single vertex.
    """
    c, method = series.stages((tree[0], ())), series.method
    gap = less(series.stages(tree), [x ** size(tree) * Fraction(1, gamma(tree)) for x in c])
    if not last or all(m.r == 1 for m in method.parts.values()):
        return gap
    N, U = series.N[tree[0]], method.part(tree[0]).U
    added = [apply(U, n) for n in N] if len(N) > 1 else [ones(len(U))]  # U u = 1
    if not is_exact(added):
        not_covered("decimals in U where the eigenvalue 1 of V is multiple")
    return apply(kernel(added), gap)


def abscissae_apart(case: BoundCase) -> list:
    """Return by how much the abscissae of a stage differ: those of all parts, or A 1 and c."""
    if not case.method.additive and case.method.system != "time":
        return []
    series = case.proof.series(*case.kind, 1)
    first, *others = (series.stages((c, ())) for c in case.method.parts)
    return [x for other in others for x in less(first, other)]


def a_stage_has_one_abscissa(case: BoundCase) -> bool:
    """All parts of an additive method give a stage one abscissa; where c stands apart it is A 1."""
    return case.q == 0 or vanishes(abscissae_apart(case))


def stages_are_the_solution(case: BoundCase) -> bool | Fails:
    """Every stage is the solution at its abscissa on every tree through q."""
    series = case.proof.series(*case.kind, case.q, filled=True)
    for tree in through(case.method, case.q, case.kind[1]):
        if size(tree) > 1 and not vanishes(stage_defect(series, tree, size(tree) == case.most)):
            return Fails(tree)
    return True


def a_stage_is_wrong(case: BoundCase) -> bool:
    """A stage is not the solution at the tree, whatever the principal part is, or has two times."""
    if case.is_the_order:
        return True
    tree = case.tree
    if case.q == 0:
        return any(map(apart, abscissae_apart(case)))
    series = case.proof.series(*case.kind, case.q + 1, filled=True)
    return any(map(apart, stage_defect(series, tree, case.q + 1 == case.most)))


def equations_give_the_stage_order(case: BoundCase) -> bool:
    """The equations of the enclosure give the order of every stage."""
    return case.proof.root().gives_stage_order(case.q)


ORDER_RULES = (
    Rule(
        "preconsistent", "preconsistent", "holds", "the definition", BUTCHER,
        NoWitness, ComponentCase,
        (u_exists,),
    ),
    Rule(
        "consistent", "consistent", "holds", "the definition", BUTCHER, NoWitness, ComponentCase,
        (u_and_v_exist,),
    ),
    Rule(
        "not-preconsistent", "preconsistent", "fails",
        "without u no start makes a stage the solution: the order is 0",
        BUTCHER, OfColour, ComponentCase, (no_u_exists,),
    ),
    Rule(
        "no-order-1", "consistent", "fails", "order 1 is that u and v exist: the order is 0",
        BUTCHER, OfColour, ComponentCase,
        (no_u_and_v_exist,),
    ),
    Rule(
        "order-at-least", "order", "at least",
        "a starting method S has M S = S E + O(h^(p+1)), E the flow: B-series with any "
        "coefficients are those of Runge-Kutta methods up to a given order",
        "Butcher (1972), An algebraic theory of integration methods", OrderWitness, OrderCase,
        (stages_begin_at_the_solution, conditions_hold, paths_stand_for_trees,
         shared_stages_have_one_time, stages_are_right_along_paths),
    ),
    Rule(
        "order-at-most", "order", "at most",
        "two starting series of order p agree below p up to the flow, so that one condition of "
        "order p + 1 that fails excludes the order",
        UNIQUE, OrderAtMost, OrderCase,
        (lower_bound_is_shown_along_paths, tree_is_of_the_next_order, next_order_fails),
    ),
    Rule(
        "implied-order", "order", "at least",
        "the equations and symmetry give the conditions of every order through p",
        "docs/certificates.md, 6.2 to 6.4 and 6.8", OrderWitness, OrderCase,
        (theorem_is_about_the_method, equations_give_the_order, principal_parts_are_0),
    ),
    Rule(
        "stage-order-at-least", "stage-order", "at least", "the definition", UNIQUE,
        AtLeast, BoundCase,
        (bound_is_below_the_order, series_is_that_of_the_order,
         a_stage_has_one_abscissa, stages_are_the_solution),
    ),
    Rule(
        "stage-order-at-most", "stage-order", "at most",
        "the starting series is unique up to the flow and, at the order itself, up to N beta",
        UNIQUE, AtMost, BoundCase,
        (order_is_enclosed_or_open, bound_is_at_most_the_order, principal_parts_are_unique,
         a_stage_is_wrong),
    ),
    Rule(
        "implied-stage-order", "stage-order", "at least",
        "the equations `defect`, mirrored, are those of every stage",
        "docs/certificates.md, 6.3", AtLeast, BoundCase,
        (bound_is_below_the_order, equations_give_the_stage_order),
    ),
)  # fmt: skip
