"""Polynomials over exact numbers: what stability questions need, decided without a tolerance.

A polynomial is a tuple of scalars, constant term first. Over balls the ring operations enclose; a
decision that a ball leaves open raises :class:`~glmref.claims.ExactnessError`.

Public names::

    Polynomial = tuple[Scalar, ...]
    trim(p) -> Polynomial                      add(p, q), sub(p, q), mul(p, q), scale(c, p)
    divide(p, q) -> (quotient, remainder)      gcd(p, q) -> monic      squarefree(p)
    derivative(p)                              evaluate(p, x)          evaluate_matrix(p, M)
    power(p, n)                                compose_moebius(p, a, b, c, d)
    from_roots(roots)                          interpolate(points, values)
    characteristic_polynomial(M) -> Polynomial faddeev_leverrier(M) -> (Polynomial, adjugate terms)
    reciprocal(p) -> Polynomial                is_self_reciprocal(p) -> bool
    real_roots(p, low=None, high=None) -> int  is_nonnegative(p) -> bool
    is_schur(p) -> bool                        in_closed_disc(p) -> bool
    unimodular_roots(p) -> int                 approximate_roots(p) -> list[complex]
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import pairwise

from .. import linalg
from ..claims import ExactnessError
from ..exact import Exact, Scalar, exact
from ..linalg import Matrix

__all__ = [
    "Polynomial",
    "add",
    "approximate_roots",
    "characteristic_polynomial",
    "compose_moebius",
    "derivative",
    "divide",
    "evaluate",
    "evaluate_matrix",
    "faddeev_leverrier",
    "from_roots",
    "gcd",
    "in_closed_disc",
    "interpolate",
    "is_nonnegative",
    "is_schur",
    "is_self_reciprocal",
    "mul",
    "power",
    "real_roots",
    "reciprocal",
    "scale",
    "squarefree",
    "sub",
    "trim",
    "unimodular_roots",
]

Polynomial = tuple[Scalar, ...]

_ZERO, _ONE = Exact(0), Exact(1)


def trim(p: Sequence[Scalar]) -> Polynomial:
    """Drop leading coefficients that are exact zeros; the zero polynomial is ``()``."""
    size = len(p)
    while size and p[size - 1].is_zero() is True:
        size -= 1
    return tuple(p[:size])


def add(p: Polynomial, q: Polynomial) -> Polynomial:
    """Sum."""
    short, long = sorted((p, q), key=len)
    return trim([a + b for a, b in zip(short, long, strict=False)] + list(long[len(short) :]))


def sub(p: Polynomial, q: Polynomial) -> Polynomial:
    """Difference."""
    return add(p, scale(-1, q))


def scale(factor: Scalar | int, p: Polynomial) -> Polynomial:
    """Multiple."""
    return trim([factor * a for a in p])


def mul(p: Polynomial, q: Polynomial) -> Polynomial:
    """Product."""
    if not p or not q:
        return ()
    result: list[Scalar] = [_ZERO] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        if a.is_zero() is True:
            continue
        for j, b in enumerate(q):
            if b.is_zero() is not True:
                result[i + j] = result[i + j] + a * b
    return trim(result)


def power(p: Polynomial, exponent: int) -> Polynomial:
    """Power with a non-negative exponent."""
    result: Polynomial = (_ONE,)
    for _ in range(exponent):
        result = mul(result, p)
    return result


def divide(p: Polynomial, q: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Quotient and remainder.

    Raises
    ------
        ZeroDivisionError: when ``q`` is zero.
        ExactnessError: when the leading coefficient of ``q`` is a ball around zero.
    """
    if not q:
        raise ZeroDivisionError("division by the zero polynomial")
    if q[-1].is_zero() is None:
        raise ExactnessError("the degree of a divisor is not decided: its leading ball holds zero")
    rest = list(p)
    quotient: list[Scalar] = [_ZERO] * max(0, len(p) - len(q) + 1)
    for shift in range(len(p) - len(q), -1, -1):
        top = rest[shift + len(q) - 1]
        if top.is_zero() is True:
            continue
        factor = top / q[-1]
        quotient[shift] = factor
        for j, b in enumerate(q[:-1]):
            if b.is_zero() is not True:
                rest[shift + j] = rest[shift + j] - factor * b
        rest[shift + len(q) - 1] = _ZERO
    return trim(quotient), trim(rest[: len(q) - 1])


def _monic(p: Polynomial) -> Polynomial:
    if not p:
        return p
    return (*(a / p[-1] for a in p[:-1]), _ONE)


def gcd(p: Polynomial, q: Polynomial) -> Polynomial:
    """Monic greatest common divisor."""
    p, q = trim(p), trim(q)
    if len(p) < len(q):
        p, q = q, p
    while q:
        if len(q) == 1:
            return (_ONE,)
        q = _monic(q)
        p, q = q, divide(p, q)[1]
    return _monic(p)


def derivative(p: Polynomial) -> Polynomial:
    """Derivative."""
    return trim([k * a for k, a in enumerate(p)][1:])


def squarefree(p: Polynomial) -> Polynomial:
    """Monic polynomial with the roots of ``p``, each once."""
    p = trim(p)
    return _monic(p) if len(p) <= 2 else _monic(divide(p, gcd(p, derivative(p)))[0])


def evaluate(p: Polynomial, x: Scalar | int | Fraction) -> Scalar:
    """Value at ``x``."""
    total: Scalar = _ZERO
    for a in reversed(p):
        total = total * x + a
    return total


def evaluate_matrix(p: Polynomial, m: Matrix) -> Matrix:
    """Value at a square matrix."""
    one = linalg.identity(len(m))
    total = linalg.zeros(len(m), len(m))
    for a in reversed(p):
        total = linalg.add(linalg.matmul(total, m), linalg.scale(a, one))
    return total


def from_roots(roots: Sequence[Scalar]) -> Polynomial:
    """Monic polynomial with the given roots."""
    result: Polynomial = (_ONE,)
    for root in roots:
        result = mul(result, (-root, _ONE))
    return result


def interpolate(points: Sequence[int], values: Sequence[Scalar]) -> Polynomial:
    """Polynomial of degree below ``len(points)`` through the given values (Newton's form)."""
    table = list(values)
    size = len(points)
    for level in range(1, size):
        for i in range(size - 1, level - 1, -1):
            table[i] = (table[i] - table[i - 1]) * Fraction(1, points[i] - points[i - level])
    result: Polynomial = ()
    for i in range(size - 1, -1, -1):
        result = add(mul(result, (exact(-points[i]), _ONE)), trim((table[i],)))
    return result


def compose_moebius(
    p: Polynomial, a: Scalar | int, b: Scalar | int, c: Scalar | int, d: Scalar | int
) -> Polynomial:
    """Return ``(c x + d)^n p((a x + b)/(c x + d))`` with n the degree of ``p``."""

    def linear(constant: Scalar | int, slope: Scalar | int) -> Polynomial:
        return trim([exact(t) if isinstance(t, int) else t for t in (constant, slope)])

    upper, lower = linear(b, a), linear(d, c)
    result: Polynomial = ()
    factor: Polynomial = (_ONE,)
    for coefficient in reversed(p):  # Horner's rule, with the denominators carried along
        result = add(mul(result, upper), scale(coefficient, factor))
        factor = mul(factor, lower)
    return result


def faddeev_leverrier(m: Matrix) -> tuple[Polynomial, list[Matrix]]:
    """Characteristic polynomial and adjugate: ``adj(w I - M) = sum of w^k N_k``.

    Returns
    -------
        The monic polynomial det(w I - M), and the matrices N_0 .. N_(n-1).

    References: Gantmacher, "The Theory of Matrices" (1959), volume I, chapter IV, section 5.
    """
    size = len(m)
    one = linalg.identity(size)
    coefficients: list[Scalar] = [_ONE]
    terms = [one]
    for k in range(1, size + 1):
        product = linalg.matmul(m, terms[-1])
        trace: Scalar = _ZERO
        for i in range(size):
            trace = trace + product[i][i]
        coefficients.append(trace * Fraction(-1, k))
        if k < size:
            terms.append(linalg.add(product, linalg.scale(coefficients[-1], one)))
    return tuple(reversed(coefficients)), terms[::-1]


def characteristic_polynomial(m: Matrix) -> Polynomial:
    """Monic polynomial det(w I - M)."""
    return faddeev_leverrier(m)[0]


def reciprocal(p: Polynomial) -> Polynomial:
    """``w^n`` times the conjugate of ``p(1/conj(w))``: roots mirrored in the unit circle."""
    return trim([a.conjugate() for a in reversed(p)])


def is_self_reciprocal(p: Polynomial) -> bool:
    """Whether ``p`` is a multiple of its reciprocal, so that roots come in mirrored pairs."""
    q = reciprocal(p)
    if len(p) != len(q):
        return False
    return all((a * q[-1] - b * p[-1]).is_zero() is True for a, b in zip(p, q, strict=True))


def _sturm_chain(p: Polynomial) -> list[Polynomial]:
    chain = [p, derivative(p)]
    while len(chain[-1]) > 1:
        remainder = divide(chain[-2], chain[-1])[1]
        if not remainder:
            break
        # division by |leading coefficient| keeps the signs and keeps the numbers small
        chain.append(scale(-remainder[-1].sign(), _monic(remainder)))
    return [q for q in chain if q]


def _sign_changes(signs: list[int]) -> int:
    kept = [s for s in signs if s]
    return sum(a != b for a, b in pairwise(kept))


def _signs_at(chain: list[Polynomial], x: Scalar | None, infinity: int) -> list[int]:
    if x is not None:
        return [evaluate(q, x).sign() for q in chain]
    return [q[-1].sign() * (infinity if len(q) % 2 == 0 else 1) for q in chain]


def real_roots(p: Polynomial, low: Scalar | None = None, high: Scalar | None = None) -> int:
    """Number of distinct real roots in ``(low, high]`` by Sturm's theorem; ``None`` is infinite.

    Args:
        p: not zero, with real coefficients.
        low, high: ends of the interval.
    """
    p = squarefree(p)
    if len(p) <= 1:
        return 0
    chain = _sturm_chain(p)
    return _sign_changes(_signs_at(chain, low, -1)) - _sign_changes(_signs_at(chain, high, 1))


def _odd_part(p: Polynomial) -> Polynomial:
    """Product of the factors of odd multiplicity (Yun's algorithm)."""
    result: Polynomial = (_ONE,)
    common = gcd(p, derivative(p))
    rest, other = divide(p, common)[0], divide(derivative(p), common)[0]
    multiplicity = 1
    while len(rest) > 1:
        other = sub(other, derivative(rest))
        factor = gcd(rest, other) if other else _monic(rest)
        if multiplicity % 2:
            result = mul(result, factor)
        rest = divide(rest, factor)[0]
        other = divide(other, factor)[0] if other else ()
        multiplicity += 1
    return result


def is_nonnegative(p: Polynomial) -> bool:
    """Whether a polynomial with real coefficients is nowhere negative on the real line."""
    p = trim(p)
    if not p:
        return True
    if len(p) % 2 == 0 or p[-1].sign() < 0:
        return False
    low = 0
    while p[low].is_zero() is True:
        low += 1
    if low % 2:
        return False
    p = p[low:]
    if all(a.is_zero() is True for a in p[1::2]):  # even: half the degree in x^2, on x^2 > 0
        return real_roots(_odd_part(p[::2]), low=_ZERO) == 0
    return real_roots(_odd_part(p)) == 0


def is_schur(p: Polynomial) -> bool:
    """Whether all roots lie inside the unit circle (Schur, Cohn), decided by signs.

    References: Marden, "Geometry of Polynomials" (1966), section 42.
    """
    p = trim(p)
    while len(p) > 1:
        low, high = p[0], p[-1]
        if low.is_zero() is True:
            p = p[1:]
            continue
        if (high * high.conjugate() - low * low.conjugate()).real.sign() <= 0:
            return False
        mirrored = tuple(a.conjugate() for a in reversed(p))
        p = _monic(
            trim([high.conjugate() * a - low * b for a, b in zip(p, mirrored, strict=True)][1:])
        )
    return True


def in_closed_disc(p: Polynomial) -> bool:
    """Whether all roots lie inside or on the unit circle.

    Where the Schur-Cohn step degenerates the polynomial is its own mirror image up to a factor, and
    then its roots lie on the circle exactly if those of its derivative lie in the closed disc.

    References: Cohn, Math. Z. 14 (1922) 110; Marden, "Geometry of Polynomials" (1966), section 45.
    """
    p = trim(p)
    while len(p) > 1:
        low, high = p[0], p[-1]
        if low.is_zero() is True:
            p = p[1:]
            continue
        sign = (high * high.conjugate() - low * low.conjugate()).real.sign()
        if sign < 0:
            return False
        if sign == 0:
            if not is_self_reciprocal(p):
                return False
            p = derivative(p)
            continue
        mirrored = tuple(a.conjugate() for a in reversed(p))
        p = _monic(
            trim([high.conjugate() * a - low * b for a, b in zip(p, mirrored, strict=True)][1:])
        )
    return True


def unimodular_roots(p: Polynomial) -> int:
    """Number of distinct roots on the unit circle.

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
    return real_roots(tuple(a.real for a in _monic(moved))) + at_infinity if moved else at_infinity


def approximate_roots(p: Polynomial) -> list[complex]:
    """Roots in floating point (Durand, Kerner): for messages and guesses, never for decisions."""
    p = trim(p)
    coefficients = [complex(a / p[-1]) for a in p[:-1]]
    size = len(coefficients)
    radius = 1 + max((abs(a) for a in coefficients), default=0.0)
    roots = [min(radius, 2.0) * (0.4 + 0.9j) ** k for k in range(size)]
    for _ in range(500):
        change = 0.0
        for k in range(size):
            value, spread = 1 + 0j, 1 + 0j
            for a in reversed(coefficients):
                value = value * roots[k] + a
            for j in range(size):
                if j != k:
                    spread *= roots[k] - roots[j]
            if spread == 0:
                spread = 1e-12 + 0j
            step = value / spread
            roots[k] -= step
            change = max(change, abs(step))
        if change < 1e-15 * radius:
            break
    return roots
