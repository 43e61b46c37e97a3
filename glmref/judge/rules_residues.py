"""Rules for growth of pairs by the eigenvalues that their halves share, or do not (section 5)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from .arithmetic import Fraction
from .document import Component
from .grammar import rational
from .linalg import (
    characteristic,
    is_exact,
    times,
)
from .numbers import total
from .polynomials import (
    derivative,
    divide,
    gcd,
    horner,
    multiply,
    plus,
)
from .refusals import Document, as_list, require
from .rule import Bounded, Case, NoWitness, Rule, Truth
from .rules_growth import GROWTH


@dataclass(frozen=True)
class Cosines:
    """The real parts of the eigenvalues of each half by its colour."""

    cosines: Document


class UnsharedCase(Case):
    """A part about pairs whose V and V^ share the eigenvalue 1 only."""

    @cached_property
    def ends(self) -> list:
        """Return the characteristic polynomials of V and V^."""
        return [characteristic(m.V) for m in self.method.parts.values()]


def pair_is_separable(case: UnsharedCase) -> bool:
    """The method is a separable pair."""
    return case.method.separable


def powers_of_all_are_bounded(case: UnsharedCase) -> bool:
    """The powers of V and of V^ are shown by `bounded` to be bounded."""
    return {x.colour for x in case.proof.all_shown(Bounded)} == set(case.method.parts)


def one_is_all_that_is_shared(case: UnsharedCase) -> bool:
    """The characteristic polynomials of V and V^ have the greatest common divisor x - 1."""
    return gcd(*case.ends) == [-1, 1]


def one_is_simple_in_both(case: UnsharedCase) -> bool:
    """1 is a simple eigenvalue of V and of V^."""
    return all(bool(horner(derivative(p), Fraction(1))) for p in case.ends)


def the_empty_list_is_judged(case: UnsharedCase) -> bool:
    """For the claim `growth` the empty list holds and every other fails."""
    if case.proof.claim != "growth":
        return True
    return (not case.claimed) == case.proof.holds


# ---------------------------------------------------------------------------- residues


class ResiduesCase(UnsharedCase):
    """A part about the eigenvalues of the halves of a pair that share stages, but 1 no eigenvalue.

    At a simple eigenvalue zeta the parameter (1/zeta) w B U v is sigma(zeta) / (zeta chi'(zeta)),
    chi = det(x I - V) and sigma = chi tr(U (x I - V)^-1 B).
    """

    witness: Cosines

    @cached_property
    def cosines(self) -> dict[str, list]:
        """Return the real parts of the eigenvalues of each half but 1, -1 for the eigenvalue -1."""
        given = self.witness.cosines
        require(set(given) == set(self.method.parts), "cosines are given of both halves")
        return {c: [rational(x) for x in as_list(given[c])] for c in self.method.parts}

    @cached_property
    def factors(self) -> dict[str, list]:
        """Return x + 1 or x^2 - 2 c x + 1 for each cosine."""
        one = Fraction(1)
        return {
            c: [[one, one] if x == -1 else [one, -2 * x, one] for x in cosines]
            for c, cosines in self.cosines.items()
        }

    @cached_property
    def parts(self) -> list:
        """Return sigma and x chi' modulo the factor of each eigenvalue, arguments increasing."""
        found = []
        for (c, m), chi in zip(self.method.parts.items(), self.ends, strict=True):
            sigma, slope = trace_numerator(m, chi), [Fraction(0), *derivative(chi)]
            half = [(divide(sigma, f)[1], divide(slope, f)[1]) for f in self.factors[c]]
            upper_ones = [x for x, f in zip(half, self.factors[c], strict=True) if len(f) == 3]
            found += half + upper_ones[::-1]
        return found

    @property
    def agrees(self) -> bool:
        """Tell whether the parameters are those declared, for `parasitism-free` all 0."""
        if self.proof.claim == "parasitism-free":
            return (not any(rest for rest, _ in self.parts)) == self.proof.declared
        mine = self.claimed
        return len(mine) == len(self.parts) and not any(
            plus(rest, [mu * x for x in slope], -1)
            for mu, (rest, slope) in zip(mine, self.parts, strict=True)
        )


def trace_numerator(m: Component, chi: list) -> list:
    """Return chi tr(U (x I - V)^-1 B), a polynomial, from its series in 1/x."""
    moments, image = [], m.B
    for _ in range(len(chi) - 1):
        product = times(m.U, image)
        moments.append(total(row[i] for i, row in enumerate(product)))
        image = times(m.V, image)
    n = len(moments)
    return [total(chi[j + 1 + i] * moments[i] for i in range(n - j)) for j in range(n)]


def stages_are_shared(case: ResiduesCase) -> bool:
    """The method is a pair that is not separable."""
    return case.method.pair and not case.method.separable


def entries_are_exact(case: ResiduesCase) -> bool:
    """U, B and V hold no decimals."""
    return all(is_exact(M) for m in case.method.parts.values() for M in (m.U, m.B, m.V))


def cosines_decrease(case: ResiduesCase) -> bool:
    """The cosines of each half decrease, from below 1 to -1."""
    return all(
        all(-1 <= x < 1 for x in cosines) and all(x > y for x, y in pairwise(cosines))
        for cosines in case.cosines.values()
    )


def cosines_give_all_eigenvalues(case: ResiduesCase) -> bool:
    """det(x I - V) is x - 1 times the factors of the cosines, in each half."""
    for factors, chi in zip(case.factors.values(), case.ends, strict=True):
        found = [Fraction(-1), Fraction(1)]
        for factor in factors:
            found = multiply(found, factor)
        if plus(found, chi, -1):
            return False
    return True


def residues_decide(case: ResiduesCase) -> bool:
    """The parameters are those declared where the statement holds, and others where it fails."""
    return case.agrees == case.proof.holds


RESIDUE_RULES = (
    Rule(
        "unshared", "growth", "holds",
        "components of a separable pair feed each other only where their eigenvalues are the same, "
        "and the simple eigenvalue 1 belongs to the solution",
        GROWTH, NoWitness, UnsharedCase,
        (pair_is_separable, powers_of_all_are_bounded, one_is_all_that_is_shared,
         one_is_simple_in_both, the_empty_list_is_judged),
    ),
    Rule(
        "residues", "growth", "holds",
        "a component of one half at an eigenvalue that the other has not grows by its own "
        "derivative only: a' = mu f_q a, mu = sigma(zeta) / (zeta chi'(zeta))",
        GROWTH, Cosines, ResiduesCase,
        (stages_are_shared, entries_are_exact, one_is_all_that_is_shared, cosines_decrease,
         cosines_give_all_eigenvalues, residues_decide),
        lambda case: Truth(case.proof.claim, case.proof.holds),
    ),
)  # fmt: skip
