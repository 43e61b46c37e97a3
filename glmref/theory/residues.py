"""Growth parameters of each half of a pair, where the roots come in pairs with rational cosines.

At a simple eigenvalue zeta of V, chi its characteristic polynomial, the growth parameter
``zeta^-1 w B U v`` is ``sigma(zeta)/(zeta chi'(zeta))``, with ``sigma = chi tr(U (z - V)^-1 B)``, a
polynomial: the residue of sigma/chi at zeta, over zeta. At two conjugate zeta whose sum 2 c is
rational it is a number mu with ``sigma = mu z chi'`` modulo ``z^2 - 2 c z + 1``. Where a symmetric
method is rational in c, mu is so too, and no square root is needed.

These are the growth parameters of a pair whose stages are shared and whose V and V^ have no common
eigenvalue but 1: to first order a component of q at zeta obeys a' = mu f_q a, one of p at an
eigenvalue of V^ b' = mu k_p b, f_q and k_p the derivatives along the solution.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from ..exact import Exact, exact
from ..exact.factors import rational_factors
from ..exact.judging import consulted, inward, outward
from ..exact.linalg import Matrix
from ..method import Method
from ..method.component import Component
from . import polynomials as poly
from .judged import judged_component
from .polynomials import Polynomial


@dataclass(frozen=True)
class Residue:
    """The growth parameter at a pair of conjugate eigenvalues, or at -1."""

    cosine: Fraction  #: The real part of the eigenvalues, -1 for the eigenvalue -1.
    mu: Exact  #: Real; the same at both eigenvalues.

    @property
    def eigenvalues(self) -> tuple[Exact, ...]:
        """Zeta with the argument in (0, pi], and its conjugate unless zeta is -1."""
        if self.cosine == -1:
            return (exact(-1),)
        sine = exact(self.cosine**2 - 1).sqrt()  # on the positive imaginary axis
        return exact(self.cosine + sine), exact(self.cosine - sine)


def cosines(V: Matrix) -> tuple[Fraction, ...] | None:
    """Return the real parts of the pairs of eigenvalues of V, decreasing, -1 for -1.

    None unless all eigenvalues are simple: 1, perhaps -1, and pairs on the unit circle with
    rational real parts.

    Parameters
    ----------
    V : Matrix
        (r, r) of exact entries.
    """
    chi = [x.as_fraction() if isinstance(x, Exact) else None
           for x in poly.characteristic(V)]  # fmt: skip
    rational = [x for x in chi if x is not None]
    if len(rational) < len(chi):
        return None
    found, one = [], 0
    for factor, times in rational_factors(rational):
        if times > 1 or len(factor) > 3:
            return None
        if len(factor) == 3 and factor[0] == 1 and abs(factor[1]) < 2:
            found.append(-factor[1] / 2)
        elif factor == (1, 1):
            found.append(Fraction(-1))
        elif factor == (-1, 1):
            one += 1
        else:
            return None
    return tuple(sorted(found, reverse=True)) if one else None


def _sigma(m: Component, chi: Polynomial) -> Polynomial:
    """Return the polynomial ``chi tr(U (z - V)^-1 B)``."""
    with consulted() as judge:
        numerator = judge.rules_residues.trace_numerator
        return outward(numerator(judged_component(m), inward(chi)))


def _residue(cosine: Fraction, chi: Polynomial, sigma: Polynomial) -> Residue | None:
    """Divide sigma by z chi' modulo the factor of the cosine; None where mu is not real."""
    factor = (exact(1), exact(1)) if cosine == -1 else (exact(1), exact(-2 * cosine), exact(1))
    slope = poly.divide((exact(0), *poly.derivative(chi)), factor)[1]
    wanted = poly.divide(sigma, factor)[1] if len(sigma) >= len(factor) else sigma
    at = next(i for i, x in enumerate(slope) if x.is_zero() is False)
    mu = (wanted[at] if at < len(wanted) else exact(0)) / slope[at]
    if poly.sub(wanted, poly.scale(mu, slope)):
        return None
    return Residue(cosine, exact(mu))


def residues(m: Method) -> Mapping[str, tuple[Residue, ...]] | None:
    """Return the growth parameters of each half of a pair, by the colour of the half.

    None unless the pair is exact, its stages are shared, V and V^ have the simple eigenvalue 1 in
    common and no other, their eigenvalues are such as :func:`cosines` finds, and each mu is real.
    """
    if {c.colour for c in m.components} != set("fk") or not m.shared or not m.is_exact:
        return None
    chis = {c.colour: poly.characteristic(c.V) for c in m.components}
    if not poly.share_only_one(*chis.values()):
        return None
    found: dict[str, tuple[Residue, ...]] = {}
    for c in m.components:
        roots = cosines(c.V)
        if roots is None:
            return None
        sigma = _sigma(c, chis[c.colour])
        half = [_residue(x, chis[c.colour], sigma) for x in roots]
        known = [x for x in half if x is not None]
        if len(known) < len(half):
            return None
        found[c.colour] = tuple(known)
    return found


def both_ways(half: tuple[Residue, ...]) -> list[tuple[Residue, int]]:
    """Return residues with the numbers of their eigenvalues, arguments increasing in (0, 2 pi)."""
    return [(x, 0) for x in half] + [(x, 1) for x in reversed(half) if x.cosine != -1]


def in_order(found: Mapping[str, tuple[Residue, ...]]) -> list[Exact]:
    """Return mu at every eigenvalue but 1, of q and then of p, by increasing argument."""
    return [x.mu for half in found.values() for x, _ in both_ways(half)]


def rates_on_one_sign(found: Mapping[str, tuple[Residue, ...]]) -> dict[int, float]:
    """Return the largest parasitic rate over |H_pq|, by the sign of H_pq, to first order in h.

    For a Hamiltonian of one degree of freedom f_q = H_pq and k_p = -H_pq: a component of q grows
    like exp(mu int H_pq dt), one of p like exp(-mu int H_pq dt). Where an explicit symmetric half
    has k roots, the k - 1 numbers mu have the sum -1, so that both rates are at least 1/(k - 1).
    """
    q, p = ([float(complex(x.mu).real) for x in half] for half in found.values())
    drives = [*q, *(-mu for mu in p)]
    return {sign: max([0.0, *(sign * mu for mu in drives)]) for sign in (1, -1)}
