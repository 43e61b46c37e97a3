"""Rules for explicit stages, abscissae, error constants, reducibility (section 5)."""

from __future__ import annotations

from collections.abc import Iterator
from copy import copy
from dataclasses import dataclass
from functools import cached_property
from math import factorial

from .arithmetic import Fraction, Number
from .document import Component, Method
from .linalg import apply, dot, kernel, less, minus, multiples, rank, times, transpose
from .numbers import apart, inverse, is_nil, total, vanishes
from .refusals import Refused, Undecided
from .rule import Case, Replaced, Rule, either_way
from .rules_orders import BUTCHER, ComponentCase, u_and_v_exist

MINIMAL = "Kalman (1963), Mathematical description of linear dynamical systems"
CONSTANT = "Hairer, Norsett, Wanner (1993), III.2, (2.13)"


class StageCase(Case):
    """A part about the order in which stages are evaluated."""

    def needs(self, surely: bool) -> dict:
        """Return {stage: stages it needs}, exact zeros left out; or those that it surely needs."""

        def counts(x: Number) -> bool:
            return not is_nil(x) and (not surely or apart(x))

        method = self.method
        if not method.separable:
            n = len(next(iter(method.parts.values())).A)
            return {i: {j for j in range(n)
                        if any(counts(m.A[i][j]) for m in method.parts.values())}
                    for i in range(n)}  # fmt: skip
        q, p = method.parts["f"], method.parts["k"]
        both = (("Q", "P", q.A), ("P", "Q", p.A))
        return {f"{x}{i}": {f"{y}{j}" for j, entry in enumerate(row, 1) if counts(entry)}
                for x, y, A in both for i, row in enumerate(A, 1)}  # fmt: skip


def later(needed: dict) -> set:
    """Return the stages left over when one after another is evaluated: each needs one of them."""
    done = set()
    while ready := {stage for stage, x in needed.items() if x <= done} - done:
        done |= ready
    return set(needed) - done


def stages_need_earlier_ones(case: StageCase) -> bool:
    """In some order of the stages each needs earlier ones only: other entries are exact zeros."""
    return not later(case.needs(False))


def some_stages_need_each_other(case: StageCase) -> bool:
    """Some stages need each other, by entries that are shown not to be 0."""
    return bool(later(case.needs(True)))


# ---------------------------------------------------------------------------- abscissae


class AbscissaeCase(ComponentCase):
    """A part about c = A 1 + U v of each component, v with 0 in what is read as the solution.

    Where 1 is a multiple eigenvalue of V, v is known up to N beta.
    """

    @cached_property
    def parts(self) -> list[tuple[list, list]]:
        """Return of each component c and U N beta for a basis of the beta with w N beta = 0."""
        series, found = self.proof.series(True, False, 1, filled=True), []
        for colour, m in self.method.parts.items():
            leaf, N, w = (colour, ()), series.N[colour], series.w[colour]
            c, unseen = series.stages(leaf), []
            if len(N) > 1:
                reads = apply(N, w)
                unseen = [apply(m.U, apply(transpose(N), beta)) for beta in kernel([reads])]
                j = next(j for j, x in enumerate(reads) if apart(x))
                factor = dot(w, series.eta_of(leaf)) * inverse(reads[j])
                c = less(c, multiples(factor, apply(m.U, N[j])))
            found.append((c, unseen))
        return found

    @cached_property
    def c(self) -> list:
        """Return the abscissae, of one component after the other."""
        return [x for c, _ in self.parts for x in c]


def method_is_no_pair(case: AbscissaeCase) -> bool:
    """The method is no pair, whose stages have two abscissae each."""
    return not case.method.pair


def u_and_v_may_exist(case: AbscissaeCase) -> bool:
    """It is not shown of any component that it has no u and v (else no list is its abscissae)."""

    def may(colour: str) -> bool:
        try:
            return case.exists(colour, True)
        except Undecided:
            return True

    return all(map(may, case.method.parts))


def v_is_seen_once(case: AbscissaeCase) -> bool:
    """All v with 0 in the solution give the same U v."""
    return all(vanishes(unseen) for _, unseen in case.parts)


def abscissae_are_those_declared(case: AbscissaeCase) -> bool:
    """The abscissae are those declared."""
    return len(case.c) == len(case.claimed) and vanishes(less(case.c, case.claimed))


def abscissae_are_others(case: AbscissaeCase) -> bool:
    """The declared list has another length, or one abscissa is another one."""
    return len(case.c) != len(case.claimed) or any(map(apart, less(case.c, case.claimed)))


# ---------------------------------------------------------------------------- error constant


class ConstantCase(Case):
    """A part about the error constant of a multistep method."""

    @cached_property
    def sum_of_beta(self) -> Number:
        """Return sigma(1)."""
        return total(self.method.multistep()[1])

    @cached_property
    def first(self) -> Number:
        """Return the first C_q = (sum alpha_m m^q - q sum beta_m m^(q-1)) / q! other than 0.

        No method of k steps has an order above 2 k.
        """
        alpha, beta = self.method.multistep()
        for q in range(2 * len(alpha)):
            C = dot(alpha, [Fraction(m**q) for m in range(len(alpha))])
            if q:
                C = C - q * dot(beta, [Fraction(m ** (q - 1)) for m in range(len(beta))])
            if C:
                return C * Fraction(1, factorial(q))
        return Fraction(0)

    @property
    def gap(self) -> Number:
        """Return the error constant less the declared one."""
        return self.first * inverse(self.sum_of_beta) - self.proof.claimed([self.proof.declared])[0]


def method_is_multistep(case: ConstantCase) -> bool:
    """The file is of class `lmm` or `one-leg`."""
    return case.method.kind in ("lmm", "one-leg")


def beta_has_a_sum(case: ConstantCase) -> bool:
    """The beta do not sum to 0."""
    return apart(case.sum_of_beta)


def constant_is_the_declared_one(case: ConstantCase) -> bool:
    """The error constant is the declared one."""
    return vanishes(case.gap)


def constant_is_none_or_another(case: ConstantCase) -> bool:
    """The beta sum to 0, so that there is no error constant, or it is another one."""
    return vanishes(case.sum_of_beta) or apart(case.gap)


# ---------------------------------------------------------------------------- reducibility


class ReducibleCase(Case):
    """A part about values that no stage sees, or that none reaches."""

    @cached_property
    def found(self) -> set[bool | None]:
        """Return for all components whether the ranks are below r, None where that is open."""
        return {x for c in self.method.parts for x in ranks_are_less(self.method, c)}


def seen_rows(m: Component) -> list:
    """Return the rows of U, U V, .., U V^(r-1): what the stages see of the values."""
    rows = list(m.U)
    for _ in range(m.r - 1):
        rows += times(rows[-len(m.U) :], m.V)
    return rows


def reached_rows(m: Component, u: list | None) -> list:
    """Return u and the columns of B, V B, .., V^(r-1) B: what a run reaches from the solution."""
    rows = ([u] if u else []) + transpose(m.B)
    for _ in range(m.r - 1):
        rows += [apply(m.V, x) for x in rows[-len(m.B[0]) :]]
    return rows


def ranks_are_less(method: Method, colour: str) -> Iterator[bool | None]:
    """Yield whether a value is never seen, and never reached, None where it is left open."""
    m = method.part(colour)

    def reached() -> list:  # by any u: the difference of two is never seen
        return reached_rows(m, method.vectors_to_one(colour)[0])

    for rows in (lambda: seen_rows(m), reached):
        try:
            yield rank(rows()) < m.r
        except Refused:
            yield None


def a_value_is_idle(case: ReducibleCase) -> bool:
    """A component has values that are never seen, or never reached."""
    return True in case.found


def no_value_is_idle(case: ReducibleCase) -> bool:
    """All values of every component are seen and reached."""
    return case.found == {False}


@dataclass(frozen=True)
class Blocks:
    """U, B, V of another method."""

    U: list
    B: list
    V: list


class EquivalentCase(Case):
    """A part about another method with the same A, which makes the same steps."""

    witness: Blocks

    @cached_property
    def other(self) -> Method:
        """Return the other method."""
        read = self.method.numbers
        U, B, V = map(read.matrix, (self.witness.U, self.witness.B, self.witness.V))
        other = copy(self.method)
        other.parts = {"o": Component(self.method.single().A, U, B, V)}
        other.check_shapes()
        return other


def responses_agree(case: EquivalentCase) -> bool:
    """U V^k B is the same for both methods for k below r + r'."""
    m, n = case.method.single(), case.other.single()
    left, right = m.U, n.U
    for _ in range(m.r + n.r):
        if not vanishes(minus(times(left, m.B), times(right, n.B))):
            return False
        left, right = times(left, m.V), times(right, n.V)
    return True


def both_are_preconsistent(case: EquivalentCase) -> bool:
    """Both methods have some u with V u = u and U u = 1, or none has."""
    u, v = (x.vectors_to_one("o")[0] for x in (case.method, case.other))
    return (u is None) == (v is None)


STRUCTURE_RULES = (
    *either_way(
        "explicit implicit", "explicit", "the definition", BUTCHER, StageCase,
        (stages_need_earlier_ones,), (some_stages_need_each_other,),
    ),
    *either_way(
        "abscissae other-abscissae", "abscissae", "the definition", BUTCHER, AbscissaeCase,
        (method_is_no_pair, u_and_v_exist, v_is_seen_once, abscissae_are_those_declared),
        (method_is_no_pair, u_and_v_may_exist, v_is_seen_once, abscissae_are_others),
    ),
    *either_way(
        "error-constant other-error-constant", "error-constant", "the definition", CONSTANT,
        ConstantCase, (method_is_multistep, beta_has_a_sum, constant_is_the_declared_one),
        (method_is_multistep, constant_is_none_or_another),
    ),
    *either_way(
        "reducible irreducible", "reducible",
        "values outside the span of (u, B, V B, ..), or in the kernel of (U; U V; ..), can go; a "
        "system that is reached and seen is minimal",
        MINIMAL, ReducibleCase, (a_value_is_idle,), (no_value_is_idle,),
    ),
    Rule(
        "equivalent", "symmetric-reduced", "holds",
        "by Cayley and Hamilton the U V^k B are the same for all k, and so are the stages",
        MINIMAL, Blocks, EquivalentCase, (responses_agree, both_are_preconsistent),
        lambda case: Replaced(case.other),
    ),
)  # fmt: skip
