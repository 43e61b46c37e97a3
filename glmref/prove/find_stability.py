"""What the kernel finds of linear stability: A- and L-stability of M(z)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any

from ..errors import ExactnessError
from ..exact import Exact
from ..method import GLM
from ..theory import polynomials as poly
from ..theory.root_location import in_closed_disc
from ..theory.stability import (
    leading_part,
    on_imaginary_axis,
    only_zeros,
    stability_matrix,
    stability_polynomial,
    without_content,
)
from .algebra import bounded, escape, in_right_half, leaves_disc, multiple_on_axis
from .ranges import Known

#: Points of the imaginary axis at which a violation of A-stability is looked for.
SAMPLES = tuple(Fraction(x) for x in ("1", "3", "1/3", "10", "1/10", "50", "1/50", "2", "6"))


class StabilityRules:
    """A part of :class:`~glmref.prove.kernel.Kernel`."""

    if TYPE_CHECKING:
        method: Any
        exact: bool
        bounded: Mapping[str, bool | None]

        def __init__(self, method: Any) -> None: ...

    def _a_stable(self, witness: Mapping[str, Any]) -> Known:
        """Decide that M(z) = V + z B (I - z A)^-1 U is power-bounded for every z with Re z <= 0.

        Holds where (1) V is power-bounded; (2) M has no pole there; (3) the limits for large z are
        finite and in the closed disc; (4) on the imaginary axis all eigenvalues lie in the closed
        disc: then, by the maximum principle for the moduli of eigenvalues, they do so in the half
        plane, and in its interior only an eigenvalue that z does not move has modulus 1; (5) on the
        axis eigenvalues of modulus 1 are simple (y = 0 apart, which is (1)): those that z does not
        move are then simple in the interior, too, where no other one has modulus 1.
        Dahlquist, BIT 3 (1963) 27; Hairer and Wanner (1996), IV.3; Marden (1966), 42 and 45.
        """
        if self.method.rosenbrock:
            return type(self)(self.method.linear_form)._a_stable(witness)
        if not self.exact:
            raise ExactnessError(
                "published decimals: A-stability is decided for exact methods only"
            )
        m = self.method
        if self.bounded["o"] is False:
            return Known(False, True, "V = M(0) is not power-bounded")
        P = stability_polynomial(m)
        leading, unbounded = leading_part(P)
        if unbounded:
            return Known(
                False, True, "an eigenvalue of M(z) grows without bound as z goes to infinity"
            )
        if not in_closed_disc(leading):
            return Known(False, True, escape(leading, "as z goes to infinity"))
        if m.is_diagonally_implicit:
            for a in (m.A[i - 1][i - 1] for i in m.implicit_stages):
                reversed_ = [tuple(reversed(p)) for p in P]
                if a.real.sign() < 0 and any(
                    poly.evaluate(p, a).is_zero() is False for p in reversed_
                ):
                    return Known(False, True, f"M(z) has the pole z = {1 / float(a.real):.6g}")
        axis = on_imaginary_axis(P)
        for y in SAMPLES:
            p = poly.trim([poly.evaluate(c, y) for c in axis])
            if len(p) > m.r and not in_closed_disc(p):
                return Known(False, True, escape(p, f"at z = {y} i"))
        poles = self._poles(m, P)
        if not in_right_half(poles):
            return Known(
                False, True, "M(z) has a pole in the left half-plane or on the imaginary axis"
            )
        content = poly.divide(poly.trim(P[-1]), poles)[0]
        P = tuple(poly.divide(p, content)[0] for p in P)
        failure, strict = leaves_disc(on_imaginary_axis(P))
        if failure is not None:
            return Known(False, True, failure)
        if m.r == 1:
            return Known(True)
        if strict or not multiple_on_axis(on_imaginary_axis(P)):
            return Known(True)
        for y in SAMPLES:
            if bounded(stability_matrix(m, Exact(-1).sqrt() * y)) is False:
                return Known(False, True, f"M(z) is not power-bounded at z = {y} i")
        return Known(None, True, "M(z) has eigenvalues of modulus 1 that may be multiple")

    @staticmethod
    def _poles(m: GLM, P: Sequence[Any]) -> Any:
        """Return a polynomial whose zeros are the poles of M(z): what no entry divides out."""
        if m.r == 1:
            return without_content(m, tuple(P))[-1]
        determinant = poly.trim(P[-1])
        if in_right_half(determinant):
            return determinant
        points, values, candidate = [], [], 0
        while len(points) <= m.s:
            factor = poly.evaluate(determinant, candidate)
            if factor.is_zero() is False:
                points.append(candidate)
                M = stability_matrix(m, candidate)
                values.append([factor * x for row in M for x in row])
            candidate = -candidate if candidate > 0 else 1 - candidate
        shared = determinant
        for k in range(m.r * m.r):
            entry = poly.trim(poly.interpolate(points, [v[k] for v in values]))
            if entry:
                shared = poly.gcd(shared, entry)
        return poly.divide(determinant, shared)[0]

    def _l_stable(self, witness: Mapping[str, Any]) -> Known:
        """Decide A-stability and that eigenvalues of M(z) tend to 0 at infinity (Ehle 1969)."""
        if self.method.rosenbrock:
            return type(self)(self.method.linear_form)._l_stable(witness)
        if not self.exact:
            raise ExactnessError(
                "published decimals: L-stability is decided for exact methods only"
            )
        if not only_zeros(*leading_part(stability_polynomial(self.method))):
            return Known(
                False, True, "the eigenvalues of M(z) do not all tend to 0 as z goes to infinity"
            )
        return self._a_stable(witness)
