"""Periodicity interval: how far all eigenvalues of M(iy) stay on the unit circle, with proof.

``y_max`` is the largest y such that for 0 < y < y_max all eigenvalues of M(iy) are simple and of modulus
one, and beyond which some are not. It exists only if the roots of P(w, iy) are mirrored in the
circle for every y (G-symplectic and symmetric methods), which is decided exactly. Then

* from below: with w = (1 + i t)/(1 - i t) the function ``(1 - i t)^r P(w, iy)`` is real in t up to a factor
  that t does not change. Where it alternates at r points around the circle there are r simple roots
  between them; ball arithmetic proves that for a whole interval of y at a time;
* from above: the disc of radius ``r |P/P'|`` around any w holds a root; if it misses the circle, a root
  is off it.

Public names::

    periodicity(m) -> Periodicity                for a GLM, and for a pair on q' = p, p' = -q
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import pi, tan

from ..exact import Ball, Exact, Scalar, ball
from ..method import GLM, PartitionedGLM
from . import polynomials as poly
from .polynomials import Polynomial
from .stability import axis_polynomial

__all__ = ["Periodicity", "periodicity"]

FINEST = Fraction(1, 2**44)  # step below which a collision of eigenvalues is taken to be near
FARTHEST = 64  # beyond this y the interval is reported as proven so far
_I = Exact(-1).sqrt()


@dataclass(frozen=True, eq=False)
class Periodicity:
    """Periodicity interval of a method.

    Attributes
    ----------
        end: ball around y_max; the exact 0 where there is no interval; ``None`` where it is not known.
        infinite: whether the whole axis belongs to it, by proof.
        proven: every y in (0, proven) belongs to the interval.
        witness: what happens at the end, or why it is not known.
    """

    end: Ball | None
    infinite: bool
    proven: Fraction
    witness: str = ""

    @property
    def value(self) -> float | None:
        """Midpoint of ``end`` as a float, infinity for the whole axis."""
        return float("inf") if self.infinite else None if self.end is None else float(self.end)


def periodicity(
    m: GLM | PartitionedGLM, *, conserving: bool = False, width: Fraction = Fraction(1, 10**10)
) -> Periodicity:
    """Find the periodicity interval on the imaginary axis.

    Args:
        m: a method, or a pair (taken on the oscillator q' = p, p' = -q).
        conserving: take it as proved elsewhere that the roots are mirrored in the circle (an
            enclosed G-symplectic method with nonsingular G); needed for published decimals.
        width: wanted width of the ball around y_max.

    Eigenvalues that are zero for every y are left out: carried values that die out at once.

    References: Lambert and Watson, J. Inst. Maths Applics 18 (1976) 189, for multistep methods;
    D'Ambrosio and Hairer, J. Sci. Comput. 60 (2014) 627, for parasitic eigenvalues.
    """
    q = list(axis_polynomial(m))
    while q and not q[0]:
        q = q[1:]
    if not conserving:
        mirrored = _mirrored(q)
        if mirrored is False:
            return Periodicity(
                ball(0),
                False,
                Fraction(0),
                "the eigenvalues of M(iy) leave the unit circle at once",
            )
        if mirrored is None:
            reason = "published decimals: that the eigenvalues are mirrored is not decided"
            return Periodicity(None, False, Fraction(0), reason)
    if len(q) == 2 and _never_both_zero(q):
        return Periodicity(None, True, Fraction(FARTHEST), "the only eigenvalue has modulus 1")
    return _March(tuple(q), width).run()


def _mirrored(q: Sequence[Polynomial]) -> bool | None:
    """Whether P is a multiple of its mirror image for every y."""
    low, high = q[0], q[-1]
    verdict: bool | None = True
    for p, other in zip(q, reversed(q), strict=True):
        left = poly.mul(p, tuple(x.conjugate() for x in low))
        right = poly.mul(tuple(x.conjugate() for x in other), high)
        zeros = [x.is_zero() for x in poly.sub(left, right)]
        if False in zeros:
            return False
        if zeros:
            verdict = None
    return verdict


def _never_both_zero(q: Sequence[Polynomial]) -> bool:
    return all(isinstance(x, Exact) for p in q for x in p) and len(poly.gcd(q[0], q[1])) == 1


class _March:
    """Walk along y: prove interval after interval, then prove that the eigenvalues have left."""

    def __init__(self, q: tuple[Polynomial, ...], width: Fraction) -> None:
        self.q = [[x.ball() for x in p] for p in q]
        self.degree = len(q) - 1
        self.width = width

    def run(self) -> Periodicity:
        y, step = Fraction(0), Fraction(1, 8)
        while y < FARTHEST:
            if self._alternates(y, step):
                y, step = y + step, step * Fraction(3, 2)
                step = _rounded(step)
                continue
            step /= 2
            if step < FINEST:
                return self._end(y)
        return Periodicity(None, False, y, f"all eigenvalues stay on the circle up to y = {y}")

    def _end(self, y: Fraction) -> Periodicity:
        """The march has stopped at y: look for eigenvalues off the circle just beyond."""
        gap = self.width
        beyond = y + gap
        if self._off_circle(beyond):
            end = Ball.around(ball(y + gap / 2), gap / 2)
            return Periodicity(
                end, False, y, f"two eigenvalues of M(iy) meet near y = {float(y):.10g}"
            )
        return Periodicity(
            None,
            False,
            y,
            f"two eigenvalues of M(iy) come together near y = {float(y):.10g}, and what they do "
            f"there is not decided",
        )

    def _coefficients(self, y: Ball) -> list[Ball]:
        return [poly.evaluate(tuple(p), y).ball() if p else ball(0) for p in self.q]

    def _alternates(self, y: Fraction, step: Fraction) -> bool:
        """Prove r simple unimodular roots for all values in [y, y + step]."""
        roots = self._approximate(y + step / 2)
        if roots is None or any(abs(abs(w) - 1) > 1e-3 for w in roots):
            return False
        separators = _separators(roots)
        if separators is None:
            return False
        coefficients = self._coefficients(Ball.around(ball(y + step / 2), step / 2))
        values = [self._real_form(coefficients, t) for t in separators]
        for a, b in zip(values, values[1:], strict=False):
            if not _opposite(a, b):
                return False
        # through w = -1, where t jumps from +infinity to -infinity, the form changes by (-1)^r
        last, first = values[-1], values[0] * (-1) ** self.degree
        return len(values) == 1 or _opposite(last, first)

    def _real_form(self, coefficients: list[Ball], t: Fraction) -> Ball:
        """``(1 - i t)^r P((1 + i t)/(1 - i t))`` at an exact t."""
        up, down = ball(_I * t + 1), ball(-(_I * t) + 1)
        total, factor = coefficients[-1], down
        for c in reversed(coefficients[:-1]):
            total, factor = total * up + c * factor, factor * down
        return total

    def _approximate(self, y: Fraction) -> list[complex] | None:
        values: tuple[Scalar, ...] = tuple(c.midpoint() for c in self._coefficients(ball(y)))
        if values[-1].magnitude() < 1e-12 * max(v.magnitude() for v in values):
            return None
        return poly.approximate_roots(values)

    def _off_circle(self, y: Fraction) -> bool:
        """Prove that some root at y has a modulus other than one."""
        coefficients = tuple(self._coefficients(ball(y)))
        slope = poly.derivative(coefficients)
        roots = self._approximate(y) or []
        for start in sorted(roots, key=lambda w: -abs(abs(w) - 1))[:2]:
            w = ball(Fraction(start.real)) + ball(Fraction(start.imag)) * _I
            for _ in range(12):  # Newton on midpoints: a guess, proved below
                w = (w - poly.evaluate(coefficients, w) / poly.evaluate(slope, w)).midpoint()
            radius = self.degree * poly.evaluate(coefficients, w) / poly.evaluate(slope, w)
            distance = (w * w.conjugate() - 1).real  # |w|^2 - 1
            bound = ball(Fraction(radius.magnitude())) if radius.magnitude() < 1 else ball(1)
            # a root within r of w has | |root|^2 - 1 | >= | |w|^2 - 1 | - r (2 |w| + r)
            reach = bound * (2 * Fraction(max(w.magnitude(), 1.0)) + bound)
            if _surely_larger(distance, reach):
                return True
        return False


def _surely_larger(distance: Ball, reach: Ball) -> bool:
    return any(x.is_zero() is False and x.sign() > 0 for x in (distance - reach, -distance - reach))


def _opposite(a: Ball, b: Ball) -> bool:
    """Whether two values, real up to a common factor, surely have opposite signs."""
    product = (a * b.conjugate()).real
    return product.is_zero() is False and product.sign() < 0


def _rounded(step: Fraction) -> Fraction:
    """A power of two near the step, so that the numbers stay short."""
    power = Fraction(1)
    while power > step:
        power /= 2
    while power * 2 <= step:
        power *= 2
    return power if power * Fraction(3, 2) > step else power * Fraction(3, 2)


def _separators(roots: list[complex]) -> list[Fraction] | None:
    """Parameters t of points on the circle half-way between neighbouring roots, increasing."""
    angles = sorted(cmath.phase(w) for w in roots)
    gaps = zip(angles, [*angles[1:], angles[0] + 2 * pi], strict=True)
    middles = [(a + b) / 2 for a, b in gaps]
    wrapped = sorted(x if x < pi else x - 2 * pi for x in middles)
    if any(b - a < 1e-13 for a, b in zip(wrapped, wrapped[1:], strict=False)):
        return None
    if wrapped and pi - abs(wrapped[-1]) < 1e-9:
        return None
    return [Fraction(tan(x / 2)) for x in wrapped]
