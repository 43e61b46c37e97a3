"""How far along an axis a method is stable, exactly: the negative real and the imaginary interval.

Along the ray z = d x, x > 0, the eigenvalues of M(z) are the roots in w of a polynomial whose
coefficients are polynomials in x. The reduction of Schur and Cohn over these coefficients gives
real polynomials in x; all roots lie in the closed unit disc as long as none of them has become
negative. The interval ends at the first x at which one of them turns negative, which Sturm's
theorem isolates.

References
----------
    Marden, "Geometry of Polynomials" (1966), sections 42 and 45; Hairer and Wanner, "Solving
    Ordinary Differential Equations II" (1996), sections IV.2 and V.1.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from ..errors import ExactnessError
from ..exact import Exact
from ..method import GLM
from . import polynomials as poly
from .polynomials import Polynomial
from .root_location import first_root, in_closed_disc, odd_part
from .stability import (
    Bivariate,
    on_imaginary_axis,
    schur_cohn,
    stability_polynomial,
    without_content,
)

#: Width to which the end of an interval is enclosed.
WIDTH = Fraction(1, 10**16)
#: Largest r s for which polynomials with irrational coefficients are reduced: minutes beyond.
MOST = 12
#: Bound of the ends that are looked for: a zero beyond counts as none.
FARTHEST = Fraction(10**9)


@dataclass(frozen=True)
class Interval:
    """Stability interval [0, end] along an axis."""

    #: The end, rounded to double; infinity for a whole half-axis; ``None`` if not known.
    end: float | None
    witness: str = ""  #: What happens there, or why it is not known.


def real_interval(m: GLM) -> Interval:
    """Return the largest x with all eigenvalues of M(-t) in the closed disc for 0 <= t <= x."""

    def turned(P: Bivariate) -> Bivariate:
        return tuple(tuple(c if k % 2 == 0 else -c for k, c in enumerate(p)) for p in P)

    return _interval(m, turned)


def imaginary_interval(m: GLM) -> Interval:
    """Return the largest y with all eigenvalues of M(it) in the closed disc for 0 <= t <= y.

    For a real method; eigenvalues at -it are their conjugates.
    """
    return _interval(m, on_imaginary_axis)


def _interval(m: GLM, along: object) -> Interval:
    if not (m.is_exact and m.is_real):
        return Interval(None, "decided for exact real methods only")
    try:
        P = without_content(m, stability_polynomial(m))
        degree = (len(P) - 1) * (max(map(len, P)) - 1)
        rational = all(x.as_fraction() is not None for p in P for x in p if isinstance(x, Exact))
        if degree > MOST and not rational:
            return Interval(None, "too large for roots among the coefficients")
        return _end(along(P))  # type: ignore[operator]
    except ExactnessError as error:
        return Interval(None, str(error))


def _end(q: Bivariate) -> Interval:
    at_zero = poly.trim([poly.evaluate(p, 0) for p in q])
    if not in_closed_disc(at_zero):
        return Interval(0.0, "V has an eigenvalue outside the unit circle")
    ends: list[Fraction] = []
    for difference in schur_cohn(q):
        end = Fraction(0) if difference is None else None
        if difference:
            end = _turns_negative(difference)
        if end is not None:
            ends.append(end)
        if end == 0:
            break
    if not ends:
        return Interval(float("inf"), "no eigenvalue leaves the closed unit disc")
    return Interval(float(min(ends)), "an eigenvalue leaves the closed unit disc")


def _turns_negative(p: Polynomial) -> Fraction | None:
    """Return the first x > 0 with p < 0 beyond; 0 where at once, ``None`` where never."""
    low = 0
    while p[low].is_zero() is True:
        low += 1
    p = p[low:]  # a power of x, which is positive
    if p[0].sign() < 0:
        return Fraction(0)
    return first_root(odd_part(p), Fraction(0), FARTHEST, WIDTH)  # at others it touches zero
