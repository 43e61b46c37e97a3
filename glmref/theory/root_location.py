"""Where the roots of a polynomial lie: on the real line, in the unit disc; decided by signs.

Exact numbers only are decided; a ball whose sign is open raises
:class:`~glmref.errors.ExactnessError`.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

from ..exact import Exact, Scalar, exact
from ..system.budget import spend
from .polynomials import (
    Polynomial,
    compose_moebius,
    derivative,
    divide,
    evaluate,
    gcd,
    is_self_reciprocal,
    monic,
    mul,
    reciprocal,
    scale,
    squarefree,
    sub,
    trim,
)

_ZERO, _ONE = Exact(0), Exact(1)


def _sturm_chain(p: Polynomial) -> list[Polynomial]:
    chain = [p, derivative(p)]
    while len(chain[-1]) > 1:
        remainder = divide(chain[-2], chain[-1])[1]
        if not remainder:
            break
        # division by |leading coefficient| keeps the signs and keeps the numbers small
        chain.append(scale(-remainder[-1].sign(), monic(remainder)))
    return [q for q in chain if q]


def _sign_changes(signs: list[int]) -> int:
    kept = [s for s in signs if s]
    return sum(a != b for a, b in pairwise(kept))


def _signs_at(chain: list[Polynomial], x: Scalar | None, infinity: int) -> list[int]:
    spend()
    if x is not None:
        return [evaluate(q, x).sign() for q in chain]
    return [q[-1].sign() * (infinity if len(q) % 2 == 0 else 1) for q in chain]


def real_roots(p: Polynomial) -> int:
    """Count distinct real roots by Sturm's theorem."""
    p = squarefree(p)
    if len(p) <= 1:
        return 0
    chain = _sturm_chain(p)
    return _sign_changes(_signs_at(chain, None, -1)) - _sign_changes(_signs_at(chain, None, 1))


def first_root(p: Polynomial, low: Fraction, high: Fraction, width: Fraction) -> Fraction | None:
    """Return the smallest real root in ``(low, high]``, exact if simple, else to a relative width.

    Parameters
    ----------
    p : Polynomial
        Not zero, with real coefficients.
    low, high : Fraction
        Ends of the interval.
    width : Fraction
        The root lies at most so far below what is returned, relative to its size above 1.

    Returns
    -------
    Fraction or None
        A bound of the root from above, or the root where it has a denominator of at most 1000;
        ``None`` where there is none.
    """
    p = squarefree(p)
    if len(p) <= 1:
        return None
    chain = _sturm_chain(p)
    left, right = low, high
    below = _sign_changes(_signs_at(chain, exact(left), 1))
    if below == _sign_changes(_signs_at(chain, exact(right), 1)):
        return None
    while right - left > width * max(1, right):
        simple = ((left + right) / 2).limit_denominator(1000)
        is_root = left < simple <= right and evaluate(p, simple).is_zero() is True
        if is_root and _sign_changes(_signs_at(chain, exact(simple), 1)) == below - 1:
            return simple
        middle = (left + right) / 2
        if _sign_changes(_signs_at(chain, exact(middle), 1)) < below:
            right = middle
        else:
            left = middle
    return right


def odd_part(p: Polynomial) -> Polynomial:
    """Return the product of the factors of odd multiplicity (Yun's algorithm)."""
    result: Polynomial = (_ONE,)
    common = gcd(p, derivative(p))
    rest, other = divide(p, common)[0], divide(derivative(p), common)[0]
    multiplicity = 1
    while len(rest) > 1:
        other = sub(other, derivative(rest))
        factor = gcd(rest, other) if other else monic(rest)
        if multiplicity % 2:
            result = mul(result, factor)
        rest = divide(rest, factor)[0]
        other = divide(other, factor)[0] if other else ()
        multiplicity += 1
    return result


def _end_sizes(p: Polynomial) -> int:
    """Return the sign of |p_n| - |p_0|."""
    low, high = p[0], p[-1]
    return (high * high.conjugate() - low * low.conjugate()).real.sign()


def _schur_step(p: Polynomial) -> Polynomial:
    """Return (conj(p_n) p - p_0 p~)/x, which has one root less inside the circle."""
    low, high = p[0], p[-1].conjugate()
    mirrored = tuple(a.conjugate() for a in reversed(p))
    return monic(trim([high * a - low * b for a, b in zip(p, mirrored, strict=True)][1:]))


def is_schur(p: Polynomial) -> bool:
    """Return whether all roots lie inside the unit circle (Schur, Cohn), decided by signs.

    References: Marden, "Geometry of Polynomials" (1966), section 42.
    """
    p = trim(p)
    while len(p) > 1:
        if _end_sizes(p) <= 0:
            return False
        p = _schur_step(p)
    return True


def in_closed_disc(p: Polynomial) -> bool:
    """Return whether all roots lie inside or on the unit circle.

    Where the Schur-Cohn step degenerates the polynomial is its own mirror image up to a factor, and
    then its roots lie on the circle exactly if those of its derivative lie in the closed disc.

    References: Cohn, Math. Z. 14 (1922) 110; Marden, "Geometry of Polynomials" (1966), section 45.
    """
    p = trim(p)
    while len(p) > 1:
        sign = _end_sizes(p)
        if sign < 0:
            return False
        if sign == 0:
            if not is_self_reciprocal(p):
                return False
            p = derivative(p)
            continue
        p = _schur_step(p)
    return True


def unimodular_roots(p: Polynomial) -> int:
    """Return the number of distinct roots on the unit circle.

    They are shared by ``p`` and its mirror image. On that common factor w = (1 + i t)/(1 - i t)
    carries the circle to the real line (and w = -1 to infinity), where Sturm's theorem counts.
    """
    p = trim(p)
    while p and p[0].is_zero() is True:
        p = p[1:]
    common = squarefree(p if is_self_reciprocal(p) else gcd(p, reciprocal(p)))
    if len(common) <= 1:
        return 0
    i = Exact(-1).sqrt()
    moved = trim(compose_moebius(common, i, 1, -i, 1))
    at_infinity = len(common) - len(moved)
    return real_roots(tuple(a.real for a in monic(moved))) + at_infinity if moved else at_infinity
