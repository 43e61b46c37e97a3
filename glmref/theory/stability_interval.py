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
from typing import Any

from ..errors import ExactnessError
from ..exact import Exact
from ..exact.judging import asked, fast_judge
from ..judge.polynomials import sign_changes
from ..method import GLM
from ..system.budget import spend
from . import polynomials as poly
from .polynomials import Polynomial
from .stability import Bivariate, stability_polynomial, without_content

_ZERO = Exact(0)
_differences = asked("rules_stability.differences")

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
    return _interval(m, real=True)


def imaginary_interval(m: GLM) -> Interval:
    """Return the largest y with all eigenvalues of M(it) in the closed disc for 0 <= t <= y.

    For a real method; eigenvalues at -it are their conjugates.
    """
    return _interval(m, real=False)


def _interval(m: GLM, *, real: bool) -> Interval:
    if not (m.is_exact and m.is_real):
        return Interval(None, "decided for exact real methods only")
    try:
        P = without_content(m, stability_polynomial(m))
        degree = (len(P) - 1) * (max(map(len, P)) - 1)
        rational = all(x.as_fraction() is not None for p in P for x in p if isinstance(x, Exact))
        if degree > MOST and not rational:
            return Interval(None, "too large for roots among the coefficients")
        return _end(P, real=real)
    except ExactnessError as error:
        return Interval(None, str(error))


def _end(P: Bivariate, *, real: bool) -> Interval:
    if not poly.in_disc(poly.trim([p[0] if p else _ZERO for p in P])):
        return Interval(0.0, "V has an eigenvalue outside the unit circle")
    if real:  # at z = i y, P(w, z^2) is P(w, -y^2), and the differences are polynomials in y^2
        P = tuple(sum(((c, _ZERO) for c in p), ()) for p in P)
    ends: list[Fraction] = []
    for difference in _differences(P, _lowered):
        end = Fraction(0) if difference is None else None
        if difference:
            end = _turns_negative(difference[::2] if real else difference)
        if end is not None:
            ends.append(end)
        if end == 0:
            break
    if not ends:
        return Interval(float("inf"), "no eigenvalue leaves the closed unit disc")
    return Interval(float(min(ends)), "an eigenvalue leaves the closed unit disc")


def _lowered(p: list[Any], factor: Any) -> list[Any]:
    """Divide polynomials of the judge by one where it divides all: it keeps the degrees down."""
    judge = fast_judge().polynomials
    if len(factor.p) < 2:
        return p
    parts = [judge.divide(x.p, factor.p) for x in p]
    return p if any(rest for _, rest in parts) else [judge.OnAxis(x) for x, _ in parts]


def _turns_negative(p: Polynomial) -> Fraction | None:
    """Return the first x > 0 with p < 0 beyond; 0 where at once, ``None`` where never."""
    low = 0
    while p[low].is_zero() is True:
        low += 1
    p = p[low:]  # a power of x, which is positive
    if p[0].sign() < 0:
        return Fraction(0)
    ends = map(first_root, poly.odd_factors(p))  # at roots of others it touches zero
    return min((x for x in ends if x is not None), default=None)


def first_root(p: Polynomial) -> Fraction | None:
    """Return the smallest real root in (0, FARTHEST], exact if simple, else to a relative width.

    Parameters
    ----------
    p : Polynomial
        Of degree 1 or more, with real coefficients and no multiple root.

    Returns
    -------
    Fraction or None
        A bound of the root from above, or the root where it has a denominator of at most 1000;
        ``None`` where there is none.
    """
    chain, left, right = poly.sturm_chain(p), Fraction(0), FARTHEST

    def changes(x: Fraction) -> int:
        spend()
        return sign_changes([poly.evaluate(q, x).sign() for q in chain])

    below = changes(left)
    if below == changes(right):
        return None
    while right - left > WIDTH * max(1, right):
        middle = (left + right) / 2
        simple = middle.limit_denominator(1000)
        is_root = left < simple <= right and poly.evaluate(p, simple).is_zero() is True
        if is_root and changes(simple) == below - 1:
            return simple
        if changes(middle) < below:
            right = middle
        else:
            left = middle
    return right
