"""Rules for the underlying one-step method: symplectic, conjugate, preserving H (section 5)."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, cached_property, partial
from typing import TypeAlias

from .arithmetic import Fraction, Number
from .document import Method
from .linalg import apply, dot, identity, kernel, less, minus, multiples, solve, transpose
from .numbers import apart, total, vanishes
from .refusals import require
from .rule import Bound, Case, Fails, NoWitness, Rule, Truth
from .rules_orders import AtLeast, bound
from .rules_symplectic import method_is_real
from .series import Solved
from .trees import (
    LEAF,
    Palette,
    Tree,
    cuts,
    is_superfluous,
    neighbours,
    signed_versions,
    size,
    symmetry,
    trees,
)

LARGEST = 8  # of [c, f]: where it is Hamiltonian through this order, c is known to be, too
ONE: Palette = (("o", "o"),)
Map: TypeAlias = "Callable[[Tree], Number]"
SYMPLECTIC = "Hairer, Lubich, Wanner (2006), theorems VI.7.6 and IX.9.3"
CONJUGATE = "Hairer, Zbinden (2013), On conjugate symplecticity of B-series integrators"
ENERGY = "Celledoni, McLachlan, Owren, Quispel (2010); Hairer, Lubich, Wanner (2006), lemma IX.9.7"


class Underlying(Solved):
    """The series eta with M eta = eta Phi that is read as the solution, and Phi."""

    def __init__(self, method: Method) -> None:
        super().__init__(method, True, False)
        self.phi: dict[Tree, Number] = {}
        #: Phi in variables in which it is symplectic through order 1, 2, .., None beyond the last
        self.conjugates: list[Map | None] = [self.map]

    def residual(self, tree: Tree) -> list:
        """Return B xiD(t) less what of (Phi eta)(t) is not eta(t), and keep Phi(t)."""
        right = self.value(tree)
        for s, weight in cuts(tree, self.map).items() if not self.solved else ():
            if s != tree:
                right = less(right, multiples(weight, self.eta_of(s)))
        (self.phi[tree],) = apply(self.W[tree[0]], right)
        return less(right, multiples(self.phi[tree], self.u[tree[0]]))

    def map(self, tree: Tree) -> Number:
        """Return Phi(t)."""
        if tree not in self.phi:
            self.advance(size(tree))
            self.right(tree)
        return self.phi[tree]

    def conjugate(self, order: int) -> Map | None:
        """Return Phi in variables in which it is symplectic through an order, or None."""
        for n in range(len(self.conjugates) + 1, order + 1):
            before = self.conjugates[-1]
            self.conjugates.append(None if before is None else straightened(before, n))
        return self.conjugates[order - 1]


def pairs(order: int) -> list[tuple[Tree, Tree, Tree, Tree]]:
    """Return (u o v, v o u, u, v) for every edge of the free trees of an order, each once."""
    return [(t, moved, u, v) for t in trees(ONE, order) for u, v, moved in neighbours(t)
            if t <= moved]  # fmt: skip


def symplectic_gaps(a: Map, order: int) -> list[Number]:
    """Return a(u o v) + a(v o u) - a(u) a(v) of an order."""
    return [a(t) + a(moved) - a(u) * a(v) for t, moved, u, v in pairs(order)]


def energy_gaps(a: Map, order: int) -> list[Number]:
    """Return the coefficients of H(Phi(y)) - H(y) at h^order.

    H(Phi(y)) is the sum of the products of a over the children of t, by sigma(t), times the
    elementary Hamiltonian H(t), which is 0 where the free tree is superfluous.
    """
    found = []
    for t in {min(signed_versions(t)) for t in trees(ONE, order + 1)}:
        if not is_superfluous(t):
            signs = signed_versions(t)  # H(u o v) = -H(v o u)
            products: list[Number] = [Fraction(sign, symmetry(s)) for s, sign in signs.items()]
            for n, s in enumerate(signs):
                for child in s[1]:
                    products[n] = products[n] * a(child)
            found.append(total(products))
    return found


def conjugated(a: Map, c: dict[Tree, Number]) -> Map:
    """Return the map a' with a' chi = chi a, chi = y + the terms c."""
    known: dict[Tree, Number] = {}

    def value(t: Tree) -> Number:
        if t not in known:
            x = a(t)
            for s, weight in cuts(t, lambda b: c.get(b, Fraction(0))).items():
                x = x + (weight * a(s) if s != t else 0)
            for s, weight in cuts(t, value).items():
                x = x - (weight * c[s] if s != t and s in c else 0)
            known[t] = x
        return known[t]

    return value


@cache
def change_rows(order: int) -> tuple[list[Tree], list[list[Fraction]]]:
    """Return trees of an order, and what c at these adds to each gap of the next order."""
    unknowns = trees(ONE, order)
    rows = []
    for t, moved, _, _ in pairs(order + 1):
        row = dict.fromkeys(unknowns, Fraction(0))
        for s in (t, moved):
            for rest, ways in cuts(s, lambda b: Fraction(int(b == LEAF))).items():
                if size(rest) == order:
                    row[rest] -= ways
            if len(s[1]) == 1:
                row[s[1][0]] += 1
        rows.append(list(row.values()))
    return unknowns, rows


def straightened(a: Map, order: int) -> Map | None:
    """Return a in variables in which the gaps of an order vanish, too, None where there are none.

    Each order leaves Hamiltonian terms of the change open, which change no later answer.
    """
    gaps = symplectic_gaps(a, order)
    if vanishes(gaps):
        return a
    unknowns, rows = change_rows(order - 1)
    c, _ = solve(rows, [-x for x in gaps])
    return None if c is None else conjugated(a, dict(zip(unknowns, c, strict=True)))


def underlying_of(case: Case) -> Underlying:
    """Return the series of the underlying one-step method, one for all parts about a method."""
    return case.proof.of_method(("underlying",), partial(Underlying, case.method))


class UnderlyingCase(Case):
    """A part about the underlying one-step method."""

    witness: AtLeast

    def underlying(self, order: int) -> Underlying:
        """Return the series of the map, which is looked at through an order."""
        require(order <= LARGEST, "beyond the limits of this checker")
        return underlying_of(self)

    def gaps(self, order: int) -> list[Number]:
        """Return what must vanish at an order."""
        return symplectic_gaps(self.underlying(order).map, order)

    def shows(self, about: str, holds: bool) -> Bound:
        """Return a bound."""
        return bound(about, self.witness.q, holds, (True, False))

    @cached_property
    def is_simple(self) -> bool:
        """Tell whether 1 is a simple eigenvalue of V."""
        m = self.method.single()
        shift = minus(m.V, identity(m.r))
        N, W = kernel(shift), kernel(transpose(shift))
        return len(N) == 1 and apart(dot(W[0], N[0]))


class ConjugateCase(UnderlyingCase):
    """A part about symplecticity in other variables."""

    def gaps(self, order: int) -> list[Number]:
        """Return 1 where no change of variables removes the gaps through an order, else 0."""
        return [Fraction(int(self.underlying(order).conjugate(order) is None))]


class EnergyCase(UnderlyingCase):
    """A part about the Hamiltonian itself."""

    def gaps(self, order: int) -> list[Number]:
        """Return what must vanish at an order."""
        return energy_gaps(self.underlying(order).map, order)


def one_map_underlies_the_method(case: UnderlyingCase) -> bool:
    """1 is a simple eigenvalue of V."""
    return case.is_simple


def map_is_that_of_a_step(case: UnderlyingCase) -> bool:
    """1 is a simple eigenvalue of V and the method is consistent: the map is y + h f + .."""
    return case.is_simple and case.method.vectors_to_one("o", consistent=True)[0] is not None


def conditions_hold_through_q(case: UnderlyingCase) -> bool | Fails:
    """The conditions of every order through q hold."""
    return all(vanishes(case.gaps(n)) for n in range(2, case.witness.q + 1))


def a_condition_fails_after_q(case: UnderlyingCase) -> bool:
    """A condition of order q + 1 does not hold."""
    return any(map(apart, case.gaps(case.witness.q + 1)))


def _bounds(about: str, case: type[UnderlyingCase], theorem: str, source: str) -> tuple[Rule, Rule]:
    """Return the rules for both bounds of an order."""
    return (
        Rule(f"{about}-at-least", about, "at least", theorem, source, AtLeast, case,
             (map_is_that_of_a_step, conditions_hold_through_q)),
        Rule(f"{about}-at-most", about, "at most", theorem, source, AtLeast, case,
             (map_is_that_of_a_step, a_condition_fails_after_q)),
    )  # fmt: skip


MODIFIED_RULES = (
    *_bounds(
        "hamiltonian", UnderlyingCase,
        "the modified field of a map is Hamiltonian through the order through which "
        "a(u o v) + a(v o u) = a(u) a(v)", SYMPLECTIC,
    ),
    *_bounds(
        "conjugate-symplectic", ConjugateCase,
        "the equations for the change are linear order by order, and what those through order 8 "
        "leave open is Hamiltonian: a contradiction excludes every change", CONJUGATE,
    ),
    *_bounds(
        "energy", EnergyCase,
        "elementary Hamiltonians of free trees that are not superfluous are independent", ENERGY,
    ),
    Rule(
        "conjugate", "conjugate-symplectic", "holds",
        "the underlying method of a method that conserves a form is conjugate to a symplectic one",
        "D'Ambrosio, Hairer, Zbinden, BIT 53 (2013) 867", NoWitness, UnderlyingCase,
        (one_map_underlies_the_method, method_is_real),
        lambda case: Truth("conjugate-symplectic"),
    ),
)  # fmt: skip
