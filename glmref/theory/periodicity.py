"""Periodicity interval: how far all eigenvalues of M(iy) stay on the unit circle, with proof.

``y_max`` is the largest y such that for 0 < y < y_max all eigenvalues of M(iy) are simple and of
modulus one, and beyond which some are not. It exists only if the roots of P(w, iy) are mirrored in
the circle for every y (G-symplectic and symmetric methods), which is decided exactly. Then

* from below: with w = rho (1 + i t)/(1 - i t), |rho| = 1, the function ``(1 - i t)^r P(w, iy)`` is
  real in t up to a factor that t does not change. Where it alternates at r points around the
  circle there are r simple roots between them. Taylor's formula in ball arithmetic proves that for
  a whole interval of y at a time;
* from above: a disc that holds a root and misses the circle.

A method that is G-symplectic with a definite G needs none of this: its M(iy) is unitary in G.
"""

from __future__ import annotations

import cmath
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import pi, tan

from ..exact import Ball, Exact, ball, isolated_roots
from ..method import Method
from . import polynomials as poly
from .polynomials import Polynomial
from .stability import axis_polynomial
from .symplectic import g_symplectic

FINEST = Fraction(1, 2**44)  # step below which a collision of eigenvalues is taken to be near
FARTHEST = 64  # beyond this y the interval is reported as proven so far
_I = Exact(-1).sqrt()

#: Rational points of the unit circle, well spread: (4 + 3 i)/5 has an angle of 37 degrees.
TURNS = tuple(
    power * x
    for power in (Exact(1), _I, Exact(-1), -_I)
    for x in (Exact(1), (4 + 3 * _I) / 5, (3 + 4 * _I) / 5)
)


@dataclass(frozen=True, eq=False)
class Periodicity:
    """Periodicity interval of a method."""

    #: Ball around y_max; the exact 0 where there is no interval; ``None`` if not known.
    end: Ball | None
    infinite: bool  #: Whether the whole axis belongs to it, by proof.
    proven: Fraction  #: Every y in (start, proven) belongs to the interval.
    witness: str = ""  #: What happens at the end, or why it is not known.
    #: 0, or where the proof begins for a method whose V has repeated eigenvalues (every pair has:
    #: one of q and one of p).
    start: Fraction = Fraction(0)

    @property
    def value(self) -> float | None:
        """Midpoint of ``end``, infinity, or ``None``: also where the ball contains 0 and more."""
        if self.infinite or self.end is None:
            return float("inf") if self.infinite else None
        return None if self.end.is_zero() is None else float(self.end)


def periodicity(
    m: Method, *, conserving: bool = False, width: Fraction = Fraction(1, 10**10)
) -> Periodicity:
    """Find the periodicity interval on the imaginary axis.

    Parameters
    ----------
    m : Method
        A method, or a pair (taken on the oscillator q' = p, p' = -q).
    conserving : bool
        Take it as proved elsewhere that the roots are mirrored in the circle (an enclosed
        G-symplectic method with nonsingular G); needed for published decimals.
    width : Fraction
        Wanted width of the ball around y_max.

    Eigenvalues that are zero for every y are left out: carried values that die out at once.

    References: Lambert and Watson, J. Inst. Maths Applics 18 (1976) 189, for multistep methods;
    D'Ambrosio and Hairer, J. Sci. Comput. 60 (2014) 627, for parasitic eigenvalues.
    """
    if m.parts == 1 and m.is_exact and _is_definite(m):
        return Periodicity(
            None, True, Fraction(FARTHEST), "M(iy) is unitary in the definite form G"
        )
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


def _is_definite(m: Method) -> bool:
    """Return whether the method is G-symplectic with positive definite G (Sylvester)."""
    found = g_symplectic(m)
    if not found.holds or found.G is None:
        return False
    minors = (tuple(row[:k] for row in found.G[:k]) for k in range(1, m.carried + 1))
    for minor in minors:  # the constant coefficient of the characteristic polynomial: a determinant
        determinant = poly.characteristic(minor)[0] * (-1) ** len(minor)
        if determinant.real.sign() <= 0:
            return False
    return True


def _mirrored(q: Sequence[Polynomial]) -> bool | None:
    """Return whether P is a multiple of its mirror image for every y."""
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
        self.start = Fraction(0)

    def run(self) -> Periodicity:
        simple = self._roots(Fraction(0)) is not None
        self.start = y = Fraction(0) if simple else Fraction(1, 64)
        step = Fraction(1, 8)
        while y < FARTHEST:
            if self._alternates(y, step):
                y, step = y + step, step * 2
                continue
            step /= 2
            if step < FINEST:
                return self._end(y)
        reason = f"all eigenvalues stay on the circle up to y = {float(y):.6g}"
        return Periodicity(None, False, y, reason, self.start)

    def _end(self, y: Fraction) -> Periodicity:
        """Look for eigenvalues off the circle just beyond y, where the march has stopped."""
        gap = self.width
        if y == self.start > 0 and self._off_circle(y):
            reason = f"at y = {y} an eigenvalue of M(iy) is off the circle"
            return Periodicity(Ball.around(ball(y / 2), y / 2), False, Fraction(0), reason)
        if self._off_circle(y + gap):
            end = Ball.around(ball(y + gap / 2), gap / 2)
            reason = f"two eigenvalues of M(iy) meet near y = {float(y):.10g} and leave the circle"
            return Periodicity(end, False, y, reason, self.start)
        reason = (
            f"two eigenvalues of M(iy) come together near y = {float(y):.10g}, and what they do "
            f"there is not decided"
        )
        return Periodicity(None, False, y, reason, self.start)

    def _coefficients(self, y: Ball) -> list[Ball]:
        return [poly.evaluate(tuple(p), y).ball() if p else ball(0) for p in self.q]

    def _alternates(self, y: Fraction, step: Fraction) -> bool:
        """Prove r simple unimodular roots for all values in [y, y + step]."""
        roots = [complex(w) for w in self._roots(y + step / 2) or ()]
        if not roots or any(abs(abs(w) - 1) > 1e-3 for w in roots):
            return False
        rho, separators = _separators(roots)
        if rho is None:
            return False
        offset = Ball.around(ball(0), step / 2)
        shifted, turn = [], ball(1)
        for p in self.q:
            shifted.append(_taylor([c * turn for c in p], y + step / 2))
            turn = turn * rho
        values = [self._real_form(shifted, t, offset) for t in separators]
        if not all(_opposite(a, b) for a, b in pairwise(values)):
            return False
        # through w = -rho, where t jumps from +infinity to -infinity, the form changes by (-1)^r
        return len(values) == 1 or _opposite(values[-1], values[0] * (-1) ** self.degree)

    def _real_form(self, shifted: list[list[Ball]], t: Fraction, offset: Ball) -> Ball:
        """Return ``(1 - i t)^r P(rho (1 + i t)/(1 - i t))`` at an exact t, for an interval of y.

        The powers of the offset are collected before it is put in: near a double root the value and
        the slope in y are both small, and only so does the enclosure stay small.
        """
        up, down = ball(_I * t + 1), ball(-(_I * t) + 1)
        powers_up, powers_down = [ball(1)], [ball(1)]
        for _ in range(self.degree):
            powers_up.append(powers_up[-1] * up)
            powers_down.append(powers_down[-1] * down)
        total = [ball(0)] * max(len(p) for p in shifted)
        for k, p in enumerate(shifted):
            weight = powers_up[k] * powers_down[self.degree - k]
            for j, c in enumerate(p):
                total[j] = total[j] + weight * c
        return poly.evaluate(tuple(total), offset).ball()

    def _roots(self, y: Fraction) -> list[Ball] | None:
        """Return balls around the roots at y, ``None`` where some are not apart or not finite."""
        coefficients = self._coefficients(ball(y))
        return None if coefficients[-1].contains_zero() else isolated_roots(coefficients)

    def _off_circle(self, y: Fraction) -> bool:
        """Prove that some root at y has a modulus other than one."""
        return any(not (w * w.conjugate() - 1).contains_zero() for w in self._roots(y) or ())


def _opposite(a: Ball, b: Ball) -> bool:
    """Return whether two values, real up to a common factor, surely have opposite signs."""
    product = (a * b.conjugate()).real
    return product.is_zero() is False and product.sign() < 0


def _taylor(p: Sequence[Ball], at: Fraction) -> list[Ball]:
    """Return coefficients of ``p(at + x)`` by repeated synthetic division."""
    result = list(p)
    for i in range(len(result)):
        for j in range(len(result) - 2, i - 1, -1):
            result[j] = result[j] + result[j + 1] * at
    return result


def _separators(roots: list[complex]) -> tuple[Exact | None, list[Fraction]]:
    """Return rho and increasing t: points rho (1 + i t)/(1 - i t) between the roots.

    The turn keeps t = infinity, which is w = -rho, away from all the points.
    """
    angles = sorted(cmath.phase(w) for w in roots)
    gaps = list(zip(angles, [*angles[1:], angles[0] + 2 * pi], strict=True))
    if any(b - a < 1e-13 for a, b in gaps):
        return None, []
    middles = [(a + b) / 2 for a, b in gaps]

    def room(turn: Exact) -> float:
        return min(abs(cmath.exp(1j * x) + complex(turn)) for x in middles)

    rho = max(TURNS, key=room)
    angle = cmath.phase(complex(rho))
    wrapped = sorted((x - angle + pi) % (2 * pi) - pi for x in middles)
    return rho, [Fraction(tan(x / 2)) for x in wrapped]
