"""Rules for the growth of second order in h of parasitic components (section 5)."""

from __future__ import annotations

from functools import cached_property

from .arithmetic import Fraction
from .document import Component
from .linalg import apply, combine, diagonal, dot, inverse_matrix, less, minus, placewise, times
from .numbers import apart, conj, real, vanishes
from .rule import Space, either_way
from .rules_growth import GrowthCase
from .rules_modified import Underlying, underlying_of
from .trees import LEAF, Tree

PATH: Tree = ("o", (LEAF,))
SOURCE = "Hairer, Lubich, Wanner (2006), XIV.3; docs/modified.md; docs/certificates.md, section 5"


class SecondCase(GrowthCase):
    """A part about I1 and I3 of the parasitic components of one method."""

    @cached_property
    def underlying(self) -> Underlying:
        """Return the series of the underlying one-step method."""
        return underlying_of(self)

    @cached_property
    def bend(self) -> list:
        """Return xi([o]) - xi(o)^2/2 at the stages."""
        self.underlying.advance(3)  # eta([o]) belongs to the conditions of order 3
        c = self.underlying.stages(LEAF)
        return less(self.underlying.stages(PATH), [x * x * Fraction(1, 2) for x in c])

    @cached_property
    def terms(self) -> list[tuple]:
        """Return I1, the coefficient of z^2, and I3 of every eigenvalue other than 1."""
        m = self.method.single()
        return [terms_of(m, x, self.bend) for x in self.others("o")]

    @property
    def invariants(self) -> list:
        """Return I1 and I3 of one eigenvalue other than 1 after the other."""
        return [y for I1, _, I3 in self.terms for y in (I1, I3)]

    @cached_property
    def gap(self) -> list:
        """Return the invariants less those declared."""
        return less(self.invariants, self.claimed)


def terms_of(m: Component, x: Space, bend: list) -> tuple:
    """Return I1 and z^2 and z^3 in lambda(z)/zeta of a simple eigenvalue, where z has 0."""
    (W,), N = x.W, [row[0] for row in x.N]
    slopes, moved = [apply(m.U, N)], []
    I1 = dot(W, apply(m.B, placewise(len(m.A), [slopes[0], bend])))
    onto = times(x.N, x.W)
    shift = minus(diagonal([x.zeta] * m.r), m.V)
    reduced = minus(inverse_matrix(combine(shift, onto)), onto)  # of zeta - V, 0 at N
    for _ in range(2):  # A (I - zA)^-1 U and the eigenvector, by powers of z
        moved.append(apply(reduced, apply(m.B, slopes[-1])))
        inner, outer = apply(m.A, slopes[-1]), apply(m.U, moved[-1])
        slopes.append([a + b for a, b in zip(inner, outer, strict=True)])
    return tuple(conj(x.zeta) * y for y in (I1, *(dot(W, apply(m.B, y)) for y in slopes[1:])))


def eigenvalues_are_simple(case: SecondCase) -> bool:
    """Every eigenvalue of V of modulus 1 is simple, 1 too, so that one map Phi underlies."""
    return all(len(x.W) == 1 for x in case.spectra["o"])


def map_is_of_order_2(case: SecondCase) -> bool:
    """The map Phi is y + h f + h^2 f' f / 2 + .."""
    consistent = case.method.vectors_to_one("o", consistent=True)[0] is not None
    return consistent and vanishes(case.underlying.map(PATH) - Fraction(1, 2))


def parasitic_matrices_are_0(case: SecondCase) -> bool:
    """Every growth parameter is 0."""
    return all(vanishes(x.matrices) for x in case.parasitic.values())


def terms_of_first_order_rotate(case: SecondCase) -> bool:
    """The term of z^2 in lambda(z)/zeta is imaginary, so that h f' f' phi rotates."""
    return all(vanishes(real(x)) for _, x, _ in case.terms)


def invariants_are_those_declared(case: SecondCase) -> bool:
    """I1 and I3 of each eigenvalue other than 1 are declared, and no other numbers."""
    return len(case.claimed) == len(case.invariants) and vanishes(case.gap)


def another_invariant_is_declared(case: SecondCase) -> bool:
    """More or fewer numbers than I1 and I3 of each eigenvalue are declared, or another one."""
    return len(case.claimed) != len(case.invariants) or any(map(apart, case.gap))


_SUPPOSED = (eigenvalues_are_simple, map_is_of_order_2, parasitic_matrices_are_0,
             terms_of_first_order_rotate)  # fmt: skip
SECOND_RULES = either_way(
    "second-order other-second-order", "second-order-growth",
    "where the growth parameters are 0 and the terms of z^2 imaginary, a parasitic component obeys "
    "phi' = h^2 (I3 f' f' f' phi + I1 f''(f' f, phi)), but for rotations, commutators and total "
    "derivatives along the solution",
    SOURCE, SecondCase, (*_SUPPOSED, invariants_are_those_declared),
    (*_SUPPOSED, another_invariant_is_declared),
)  # fmt: skip
