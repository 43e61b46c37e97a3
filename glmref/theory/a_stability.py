"""A- and L-stability, decided exactly.

A-stability is decided on the polynomial P(w, z) of :mod:`glmref.theory.stability`: no pole of M in
the left half-plane (signs of Schur and Cohn after a Moebius transformation), and all roots in the
closed unit disc along the imaginary axis (Schur-Cohn with polynomials in y as coefficients; each
must nowhere be negative, which Sturm's theorem decides).

Public names::

    a_stability(m) -> Decision                          l_stability(m) -> Decision
    is_a_stable(m), is_l_stable(m) -> bool | None
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from ..exact import Exact
from ..method import GLM
from . import polynomials as poly
from .polynomials import Polynomial
from .root_location import in_closed_disc, is_nonnegative, is_schur, unimodular_roots
from .stability import (
    Bivariate,
    divided,
    is_mirror_image,
    leading_part,
    on_imaginary_axis,
    only_zeros,
    schur_transform,
    size_difference,
    stability_polynomial,
    vanishes_at_inverse,
    without_content,
)

__all__ = ["Decision", "a_stability", "is_a_stable", "is_l_stable", "l_stability"]

_ZERO, _ONE = Exact(0), Exact(1)

#: Points of the imaginary axis tried before the full proof; one bad point decides.
SAMPLES = tuple(Fraction(x) for x in ("1", "3", "1/3", "10", "1/10", "50", "1/50", "2", "6"))


@dataclass(frozen=True)
class Decision:
    """A yes, a no, or ``None`` with the reason in ``witness``."""

    holds: bool | None
    witness: str = ""


def a_stability(m: GLM) -> Decision:
    """Decide A-stability: M(z) power-bounded for every z with negative real part.

    Returns
    -------
    Decision
        holds ``True`` or ``False`` by proof, or ``None`` with the reason: for methods with
        published decimals, and for a repeated eigenvalue of modulus one that z does not move.

    References: Dahlquist, BIT 3 (1963) 27; Hairer and Wanner (1996), section IV.3; Marden,
    "Geometry of Polynomials" (1966), sections 42 and 45.
    """
    if not m.is_exact:
        return Decision(None, "published decimals: A-stability is decided for exact methods only")
    P = stability_polynomial(m)
    quick = _quick_refusal(m, P)
    if quick is not None:
        return quick
    P = without_content(m, P)
    if not _poles_in_right_half(P[-1]):
        return Decision(False, "M(z) has a pole in the left half-plane or on the imaginary axis")
    fixed = _fixed_part(P)
    if len(poly.squarefree(fixed)) < len(fixed) and unimodular_roots(fixed):
        return Decision(None, "M(z) has a repeated eigenvalue of modulus 1 that z does not move")
    failure = _leaves_disc(on_imaginary_axis(P))
    return Decision(failure is None, failure or "")


def _quick_refusal(m: GLM, P: Bivariate) -> Decision | None:
    leading, unbounded = leading_part(P)
    if unbounded:
        return Decision(False, "an eigenvalue of M(z) grows without bound as z goes to infinity")
    if not in_closed_disc(leading):
        return Decision(False, _escape(leading, "as z goes to infinity"))
    if m.is_diagonally_implicit:
        for i in m.implicit_stages:
            a = m.A[i - 1][i - 1]
            if a.real.sign() < 0 and not all(vanishes_at_inverse(p, a) for p in P):
                return Decision(False, f"M(z) has the pole z = {1 / float(a.real):.6g}")
    axis = on_imaginary_axis(P)
    for y in SAMPLES:
        p = poly.trim([poly.evaluate(c, y) for c in axis])
        if p and (len(p) <= m.r or not in_closed_disc(p)):
            return Decision(False, _escape(p, f"at z = {y} i"))
    return None


def _escape(p: Polynomial, where: str) -> str:
    size = max((abs(x) for x in poly.approximate_roots(p)), default=float("inf"))
    return f"M(z) has an eigenvalue of modulus {size:.10g} {where}"


def _poles_in_right_half(denominator: Polynomial) -> bool:
    """Whether all zeros have positive real part: z = (x + 1)/(x - 1) takes that to |x| > 1."""
    if poly.evaluate(denominator, -1).is_zero() is True:
        return False  # x = 0, which the reversal below would lose
    moved = poly.compose_moebius(denominator, 1, 1, 1, -1)
    padded = (*moved, *((_ZERO,) * (len(denominator) - len(moved))))
    return is_schur(poly.trim(padded[::-1]))


def _fixed_part(P: Bivariate) -> Polynomial:
    """Factor of P that does not depend on z, a polynomial in w."""
    degree = max(len(p) for p in P)
    common: Polynomial = ()
    for k in range(degree):
        layer = poly.trim([p[k] if k < len(p) else _ZERO for p in P])
        common = poly.gcd(common, layer) if common else layer
        if len(common) == 1:
            break
    return common


def _leaves_disc(q: Bivariate) -> str | None:
    """Say why some root leaves the closed disc for some real y, or ``None``.

    Schur-Cohn with polynomials in y: the difference of the outer coefficients' squared moduli must
    be non-negative for all y at every stage. Where it vanishes identically the polynomial must be
    its own mirror image, and its derivative by w takes its place (Cohn).
    """
    previous: Polynomial = (_ONE,)
    while len(q) > 1:
        low, high = q[0], q[-1]
        if not low:
            q = q[1:]
            continue
        difference = size_difference(high, low)
        difference = tuple(x.real for x in difference)
        if not difference:
            if not is_mirror_image(q):
                return "the eigenvalues of M(iy) are not mirrored in the unit circle and leave it"
            if len(q) == 2:
                return None
            q = tuple(poly.scale(k, p) for k, p in enumerate(q))[1:]
            previous = (_ONE,)
            continue
        if not is_nonnegative(difference):
            return "for some y an eigenvalue of M(iy) lies outside the unit circle"
        reduced = schur_transform(q)
        q, previous = divided(reduced, previous), high
    return None


def l_stability(m: GLM) -> Decision:
    """Decide L-stability: A-stable, and all eigenvalues of M(z) tend to 0 as z goes to infinity.

    References: Ehle (1969); Hairer and Wanner (1996), Definition IV.3.7.
    """
    if not m.is_exact:
        return Decision(None, "published decimals: L-stability is decided for exact methods only")
    if not only_zeros(*leading_part(stability_polynomial(m))):
        return Decision(False, "the eigenvalues of M(z) do not all tend to 0 as z goes to infinity")
    return a_stability(m)


def is_a_stable(m: GLM) -> bool | None:
    """Whether the method is A-stable; ``None`` where that is not decided."""
    return a_stability(m).holds


def is_l_stable(m: GLM) -> bool | None:
    """Whether the method is L-stable; ``None`` where that is not decided."""
    return l_stability(m).holds
