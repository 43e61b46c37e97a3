"""Parasitic growth of second order in h: the invariants I1 and I3 of each eigenvalue.

**Trace rule.** Let V be nonsingular with simple eigenvalues, lambda_i(z) those of the stability
matrix M(z) = V + z B (I - zA)^-1 U that begin in zeta_i. As det M(z) = det V det(I - z A') /
det(I - z A) with A' = A - U V^-1 B,

    sum of log(lambda_i(z)/zeta_i) = sum of z^n (tr A^n - tr A'^n) / n.

A symmetric method has A' = -P A P, a G-symplectic one A' = -D^-1 A^T D (U = D^-1 B^T G V and
D A + A^T D = B^T G B give U V^-1 B = A + D^-1 A^T D): of both the right-hand side is
``2 z tr A + (2/3) z^3 tr A^3 + ..``. The eigenvalue at 1 takes z and, from order 3 on, no z^3. So
the growth parameters have the sum ``2 tr A - 1`` and the I3 the sum ``(2/3) tr A^3``: a triangular
A with nonnegative diagonal and growth parameters zero has tr A = 1/2 and some I3 > 0. One whose I3
are all zero has three nonzero diagonal entries at least: a + b = 1/2 with a^3 + b^3 = 0 asks for
a^2 - a b + b^2 = 0, which has no real solution but a = b = 0.

**Full blocks.** Let V = diag(1, -1), G = diag(1, g), g = 1 or -1, D = diag(d) nonsingular with
sum 1, X the rows 1 and w, B = X D, U = X^T G V and A = (1/2) X^T G X D + D^-1 K with K
antisymmetric: every G-symplectic method with this V, G and B u = 1, since D A + A^T D = B^T G B
leaves only K free; a triangular A is one K of them. Let mu = g sum d w^2 = 0, m = sum d w, and
k = D^-1 K 1, l = D^-1 K w. A start with values 0 and m/2 of the tree o gives c = 1/2 + k, and the
one condition that no change of variables removes for order 3 is
``sum d k^2 = (1 + 3 g m^2) / 12``. With P = (1/2) X^T G X D and Q = D^-1 K the terms of tr A^3 that
are odd in K vanish, for A^T = D (P - Q) D^-1; ``tr P^3 = (1 + 3 g m^2) / 8`` and
``tr P Q^2 = -(1/2) (sum d k^2 + g sum d l^2)``. Hence

    I3(-1) = (2/3) tr A^3 = -g sum d l^2 .

So I3 = 0 where K w = 0. Symmetric stages have palindromic d, w and K_12, K_13 with K_23 = K_12 (an
antisymmetric w gives mu = 2 g d_1 w_1^2 = 0, so w = 0): two leave w = 0, for d = 1/2 and mu = 0.
Three have l = (l_1, 0, -l_1), so that I3 = 0 only where K w = 0, with w = p (1, a, 1), K_12 = t,
K_13 = -a t. Then mu = 0 gives d_1 = a^2 / (2 (a^2 - 1)); k = (k_1, 0, -k_1); and with order 3

    I1 = 0 where  g p^2 = (2 a - 1) (a + 1)^2 / (3 a^2),  k_1^2 = (a^2 - 1) / (6 a):

a > 1 with g = 1, or -1 < a < 0 with g = -1. The order is 4, the stage order 2, the linear test
equation has lambda_1(z) = 1 + z + z^2/2 + z^3/6 + z^4/24 + z^5 (1 - 2 a)/144 + .., and so a = -1/10
is the only one of order 6: the method ``s3z``.

A pair of eigenvalues instead of -1, V = diag(1, R) with a rotation R and G = diag(1, g, g), has two
rows w. Where m = 0, c is 1/2 + k as before, the block of G X D X^T that belongs to w has the trace
sum mu = 0 and with it a cube of trace 0, and so ``I3 = -(g/2) sum d |l|^2`` at both.

References
----------
Hairer, Lubich, Wanner (2006), sections XIV.3 and XV.5: modified equations of parasitic components.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from ..errors import ExactnessError
from ..exact import Exact, Scalar
from ..exact.judging import consulted, inward, outward
from ..method import Component, Method
from .coefficients import is_zero, plus
from .judged import judged_component
from .parasitism import growth
from .spectrum import eigenvectors
from .trees import Tree, single
from .underlying import UnderlyingMethod


@dataclass(frozen=True, eq=False)
class SecondOrder:
    """What grows at one simple eigenvalue to second order in h, where mu = 0.

    Attributes
    ----------
    eigenvalue : Exact
        Zeta.
    I1, I3 : Exact or Ball
        Modulo total derivatives along the orbit, and a commutator with mean zero on q'' = -V'(q),
        ``phi' = h^2 (I3 f' f' f' phi + I1 f''(f' f, phi))`` for real zeta. I1 = 0 where the stage
        order is 2 or more; I3 is the coefficient of z^3 in ``log(lambda(z)/zeta)``, lambda the
        eigenvalue of the stability matrix M(z) that begins in zeta.
    """

    eigenvalue: Exact
    I1: Scalar
    I3: Scalar


def second_order(m: Method, series: UnderlyingMethod | None = None) -> tuple[SecondOrder, ...]:
    """Return the invariants of second order at the parasitic eigenvalues, by argument.

    On marked trees, x a leaf that stands for phi, tau with w tau = 0 of the parasitic starting map,
    ``beta(t) = zeta^-1 w B xiD(t)`` through order 3, ``I3 = beta([[[x]]])`` and
    ``I1 = beta([x[o]]) - beta([xoo])/2``.

    Parameters
    ----------
    m : Method
        Of one component, with exact V, and simple eigenvalues of modulus one.
    series : UnderlyingMethod or None
        Its series in the output gauge, where it is known.

    Raises
    ------
    ExactnessError
        Where a growth parameter is not zero, or that or the eigenvalues are open; where z^2 in
        lambda(z)/zeta has a real part: ``h f' f' phi`` grows before I1 and I3 do; or where the
        underlying one-step method is not shown to have order 2: then f'' along the solution is no
        total derivative.
    """
    found = growth(m)
    if found.free is not True and (found.free is False or not found.growths):
        raise ExactnessError(
            f"growth of second order needs growth parameters zero: {found.witness}"
        )
    if any(g.multiplicity > 1 for g in found.growths):
        raise ExactnessError("growth of second order needs simple eigenvalues of modulus one")
    start = (series or UnderlyingMethod.of_method(m)).through(2)
    t = Tree("[o]")
    if any(is_zero(plus(start.phi[x], Fraction(-1, x.order))) is False for x in (single(), t)):
        raise ExactnessError("growth of second order needs a method of order 2 or more")
    bend = start.stage_defect(t)
    return tuple(_second_order_at(m.components[0], g.eigenvalue, bend) for g in found.growths)


def _second_order_at(m: Component, zeta: Exact, bend: Sequence[Scalar]) -> SecondOrder:
    (left,), (right,) = eigenvectors(m.V, zeta)
    with consulted() as judge:
        rules, space = judge.rules_second_growth, inward([zeta, [left], [[x] for x in right]])
        found = rules.terms_of(judged_component(m), rules.Space(*space), inward(bend))
        I1, turn, I3 = outward(found)
    if is_zero(plus(turn, turn.conjugate())) is False:
        raise ExactnessError("growth of second order needs terms of z^2 that are imaginary")
    return SecondOrder(zeta, I1, I3)
