"""Rules for starts and finishes (sections 4 and 6)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

from .arithmetic import Fraction, Number
from .document import Method
from .linalg import apply, dot, is_exact, less, times, transpose
from .numbers import apart, is_nil, total, vanishes
from .refusals import as_list, as_object, keys, require
from .rule import Fails, Rule
from .rules_orders import (
    UNIQUE,
    AtLeast,
    AtMost,
    BoundCase,
    bound_is_at_most_the_order,
    bound_is_below_the_order,
    order_is_enclosed_or_open,
)
from .series import Series, Solved, external, path_orders
from .trees import LEAF, PATHS, Tree, cuts, size, through


class StartCase(BoundCase):
    """A part about the start of the file: its series, and how it differs from eta."""

    @property
    def declared(self) -> bool:
        """Tell whether the file gives a start."""
        return "starting" in self.method.document

    @cached_property
    def u(self) -> dict[str, list]:
        """Return the u of the start by colour; a pair without one has (1, 0, .., 0)."""
        method = self.method
        if not self.declared:
            return {c: [Fraction(int(k == 0)) for k in range(m.r)] for c, m in method.parts.items()}
        table, hats = as_object(method.document["starting"]), self.hats
        keys(table, " ".join(f"A{h} B{h} u{h}" for h in hats.values()), "name kind order", "start")
        found = {c: method.list("u" + h, table) for c, h in hats.items()}
        for c, h in hats.items():
            rows = as_list(table["B" + h], "B of the start is no matrix")
            fits = len(rows) == len(found[c]) == method.part(c).r
            require(fits, "the start has another number of values")
        return found

    @property
    def hats(self) -> dict[str, str]:
        """Return the ends of the keys of the start by colour."""
        return {"f": "", "k": "_hat"} if self.method.pair else {"o": ""}

    @cached_property
    def start(self) -> Series:
        """Return the series of the start, one for all parts about a method."""
        return self.proof.of_method(("given start",), self.series_of_start)

    def series_of_start(self) -> Series:
        """Return the series of the start; a pair without one has (y0, 0, ..)."""
        method = self.method
        if not self.declared:
            require(method.pair, "the file has no start")
            zero = [[Fraction(0)]]
            tables = {c: (zero, zero * m.r) for c, m in method.parts.items()}
            return Series.of_tables(tables, self.u)
        table = as_object(method.document["starting"])
        tables = {c: (method.matrix("A" + h, table), method.matrix("B" + h, table))
                  for c, h in self.hats.items()}  # fmt: skip
        return Series.of_tables(tables, self.u)

    def gap(self, order: int, p: int) -> Callable[[Tree], list]:
        """Return the function that gives start(t) - eta(t) through an order.

        At order p eta may be moved by eigenvectors N beta.
        """
        method, start, free = self.method, self.start, not self.method.pair
        require(not free or not method.system, "a start of a Rosenbrock method")
        series = self.proof.series(not free, self.kind[1], order, filled=True)
        sigma = ahead(start, series) if free and order else Fraction(0)
        return lambda tree: start_gap(start, series, tree, sigma, size(tree) == p)

    @property
    def past_the_bound(self) -> tuple[int, int]:
        """Return the orders of eta and of the method with which order q + 1 is looked at."""
        known = self.order.high
        return min(self.q + 1, self.most), self.q + 2 if known is None else known


def ahead(start: Series, series: Solved) -> Number:
    """Return what a start reads at the single vertex less what eta does, of one method."""
    return dot(series.w["o"], less(start.value(LEAF), series.eta_of(LEAF)))


def start_gap(start: Series, series: Solved, tree: Tree, sigma: Number, last: bool) -> list:
    """Return start(t) - eta(t), at the `last` order less its part along eigenvectors N beta.

    Of one method eta is moved along the flow through sigma.
    """
    found = less(start.value(tree), series.eta_of(tree))
    if not series.free:
        return found
    if not is_nil(sigma):
        found = less(found, series.shift(tree, sigma))
    if last:
        W, N = series.W["o"], series.N["o"]
        return less(found, apply(transpose(N), apply(W, found)))
    return found


def order_is_enclosed(case: StartCase) -> bool:
    """Both bounds of the order are shown and agree."""
    return case.order.enclosed


def bound_is_the_order(case: StartCase) -> bool:
    """The bound, 1 at least, is the order that both bounds show."""
    return case.order.enclosed and 1 <= case.q == case.order.low


def start_has_the_u(case: StartCase) -> bool:
    """The u of the start is that of the method (from order 1 on)."""
    if not case.q:
        return True
    series = case.proof.series(not case.method.pair, case.kind[1], 1)
    return all(
        len(u) == len(case.u[c]) and vanishes(less(case.u[c], u)) for c, u in series.u.items()
    )


def start_uses_right_stages_along_paths(case: StartCase) -> bool:
    """Along trees without branches a value of the start uses stages that are the solution."""
    if case.kind[1] not in PATHS or not case.declared:
        return True  # without a start its values are 0 on a tree where eta is, and on the path too
    return uses_right_stages(case.start, case.method, case.kind[1], case.past_the_bound[1])


def uses_right_stages(start: Series, method: Method, which: bool | str, p: int) -> bool:
    """Tell whether the stages that the values of a start use have the order that these need."""
    (A, B), (A_hat, B_hat) = ((start.part(c).A, start.part(c).B) for c in "fk")
    if which == "nystrom-paths":
        links = {"f": (times(A, A_hat), "f", 2)}
        used = [(B_hat, "f", p - 1), (times(B, A_hat), "f", p - 2)]
    else:
        links = {"f": (A, "k", 1), "k": (A_hat, "f", 1)}
        used = [(B, "k", p - 1), (B_hat, "f", p - 1)]
    orders = {c: path_orders(method, start, c, p) for c in links}
    if not method.separable:  # a stage is used as a stage Q and as a stage P
        times_of = [start.stages((c, ())) for c in "fk"]
        if len(A) != len(A_hat) or not vanishes(less(*times_of)):
            return False
    before = None
    while before != orders:
        before = {c: list(x) for c, x in orders.items()}
        if not method.separable:
            both = [min(pair) for pair in zip(orders["f"], orders["k"], strict=True)]
            orders = {"f": list(both), "k": list(both)}
        for c, (M, other, gain) in links.items():
            for i, row in enumerate(M):
                least = [orders[other][j] + gain for j, x in enumerate(row) if not is_nil(x)]
                orders[c][i] = min([orders[c][i], *least])
    return all(is_nil(x) or orders[c][j] >= least
               for M, c, least in used for row in M for j, x in enumerate(row))  # fmt: skip


def start_agrees(case: StartCase) -> bool | Fails:
    """The start is the starting series of the method at every tree through q."""
    gap = case.gap(case.q, int(case.order.low or 0))
    for tree in through(case.method, case.q, case.kind[1]):
        if not vanishes(gap(tree)):
            return Fails(tree)
    return True


def series_is_known(case: StartCase) -> bool:
    """Both bounds of the order are shown, or the series is the same whatever the order is.

    That is so of pairs and of the bound 0 where 1 is a simple eigenvalue of each V, and of u. An
    upper bound is shown only where no other principal parts satisfy the conditions.
    """
    if case.is_the_order or case.order.enclosed or case.witness.tree == "":
        return True
    series = case.proof.series(case.method.pair, case.kind[1], 1)
    return series.simple and (case.q == 0 or case.method.pair)


def start_is_wrong(case: StartCase) -> bool:
    """The start is another series at the tree, or has another u where q is 0."""
    if case.is_the_order:
        return True
    order, p = case.past_the_bound
    if case.witness.tree == "":
        series = case.proof.series(bool(case.method.pair), case.kind[1], order, filled=True)
        gaps = [x for c, u in series.u.items() for x in less(case.u[c], u)]
        return case.q == 0 and any(map(apart, gaps))
    gap = case.gap(order, p)
    return any(map(apart, gap(case.tree)))


def start_follows_from_the_equations(case: StartCase) -> bool:
    """The start is proved to be the starting series that the equations give."""
    proof, q, nystrom = case.proof, case.q, case.order.trees in (True, "nystrom-paths")
    if not case.declared:
        return case.method.pair and proof.root().zero_start_holds(q, nystrom)
    if case.method.pair:
        return q <= proof.even_orders()[nystrom]
    if not bound_is_the_order(case):  # there the first value is free
        return False
    proof.odd_start(q).root(proof.block("starting"))
    return True


# ---------------------------------------------------------------------------- finishes


class FinishCase(StartCase):
    """A part about the finish of the file, after its start."""

    @cached_property
    def external(self) -> tuple[list, list]:
        """Return u and the row that reads the solution."""
        require(not self.method.pair, "pairs have no finish")
        return external(self.method, "o")

    @cached_property
    def finish(self) -> Series:
        """Return the series of the finish."""
        table = as_object(self.method.document["finishing"])
        keys(table, "A b", "name kind order", "finish")
        A, b = self.method.matrix("A", table), [self.method.list("b", table)]
        return Series.of_tables({"o": (A, b)})

    def defect(self, tree: Tree) -> Number:
        """Return (a b)(t), a the output of the start and b the finish."""
        return finished(self.start, self.finish, self.external[1], tree)


def finished(start: Series, finish: Series, w: list, tree: Tree) -> Number:
    """Return (a b)(t), a what w reads of the start and b the finish."""

    def output(t: Tree) -> Number:
        return dot(w, start.value(t))

    return output(tree) + total(x * finish.value(s)[0] for s, x in cuts(tree, output).items())


def output_of_the_start_is_y(case: FinishCase) -> bool:
    """The output of the start begins with y itself: w u = 1 for the u of the start."""
    return vanishes(dot(case.external[1], case.u["o"]) - 1)


def finish_undoes_the_start(case: FinishCase) -> bool | Fails:
    """The finish gives y back at every tree through q."""
    for tree in through(case.method, case.q, False):
        if not vanishes(case.defect(tree)):
            return Fails(tree)
    return True


def finish_is_wrong_or_the_order_is_reached(case: FinishCase) -> bool:
    """The finish does not give y back at the tree; or, without a tree, q is the order."""
    if case.witness.tree is None:
        return case.order.high is not None and case.is_the_order
    return apart(case.defect(case.tree))


def finish_has_trees(case: FinishCase) -> bool:
    """The bound is at most 14, through which trees are listed."""
    return case.q <= 14


def file_has_start_and_finish(case: FinishCase) -> bool:
    """The file gives a start and a finish."""
    return {"starting", "finishing"} <= set(case.method.document)


def solution_is_the_first_value(case: FinishCase) -> bool:
    """The solution is read from the first value: u_1 = 1 and w = (1, 0, .., 0)."""
    u, w = case.external
    first = [Fraction(int(k == 0)) for k in range(len(w))]
    return vanishes(less(w, first)) and vanishes(u[0] - 1)


def first_value_starts_at_y(case: FinishCase) -> bool:
    """The first value of the start begins with y itself: u_1 = 1."""
    return vanishes(case.u["o"][0] - 1)


def start_is_exact_or_proved(case: FinishCase) -> bool:
    """The start is exact, or its decimals are proved to be those of a root."""
    proof = case.proof
    if "starting" not in proof.blocks:
        m = case.start.part("o")
        return is_exact(m.A) and is_exact(m.B)
    proof.odd_start(case.q).root(proof.block("starting"))
    return True


def finish_follows_from_the_digits(case: FinishCase) -> bool:
    """The finish undoes the first value of the start, or has parity and is proved."""
    proof, document = case.proof, case.method.document
    closing = as_object(document["finishing"])
    keys(closing, "A b", "name kind order", "finish")
    if proof.record.undoes():
        return True
    if "finishing" not in proof.blocks:
        return False
    start = proof.odd_start(case.q)
    proof.record.finish(start, proof.block("starting"), case.q).root(proof.block("finishing"))
    return True


START_RULES = (
    Rule(
        "start-at-least", "start", "at least",
        "the start is a starting series of the order: principal parts and the flow are free",
        UNIQUE, AtLeast, StartCase,
        (order_is_enclosed, bound_is_below_the_order, start_has_the_u,
         start_uses_right_stages_along_paths, start_agrees),
    ),
    Rule(
        "start-at-most", "start", "at most",
        "the starting series is unique up to the flow, and at the order itself up to N beta",
        UNIQUE, AtMost, StartCase,
        (order_is_enclosed_or_open, bound_is_at_most_the_order, series_is_known, start_is_wrong),
    ),
    Rule(
        "implied-start", "start", "at least",
        "a start with parity whose conditions have one root within the digits",
        "docs/certificates.md, 6.7", AtLeast, StartCase,
        (bound_is_below_the_order, start_has_the_u,
         start_follows_from_the_equations),
    ),
    Rule(
        "finish-at-least", "finish", "at least",
        "the product of the series of the output of the start and of the finish is y",
        "Butcher (2016), section 38 (composition of B-series)", AtLeast, FinishCase,
        (bound_is_below_the_order, file_has_start_and_finish, output_of_the_start_is_y,
         finish_undoes_the_start),
    ),
    Rule(
        "finish-at-most", "finish", "at most", "the same; no finish is above the order",
        "Butcher (2016), section 38", AtMost, FinishCase,
        (finish_has_trees, order_is_enclosed_or_open, file_has_start_and_finish,
         output_of_the_start_is_y, finish_is_wrong_or_the_order_is_reached),
    ),
    Rule(
        "implied-finish", "finish", "at least",
        "a Runge-Kutta method with the stages of the first value, b and A - 1 b, is its inverse; "
        "else a finish with parity whose conditions have one root within the digits",
        "Butcher (2016), section 383; docs/certificates.md, 6.7", AtLeast, FinishCase,
        (bound_is_the_order, file_has_start_and_finish, solution_is_the_first_value,
         first_value_starts_at_y, start_is_exact_or_proved, finish_follows_from_the_digits),
    ),
)  # fmt: skip
