"""Polynomials over exact numbers: what stability questions need, decided without a tolerance.

A polynomial is a tuple of scalars, constant term first. Over balls the ring operations enclose; a
decision that a ball leaves open raises :class:`~glmref.errors.ExactnessError`.

Where the roots lie is decided in :mod:`glmref.theory.root_location`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction

from ..errors import ExactnessError
from ..exact import Exact, Scalar, exact, linalg
from ..exact.linalg import Matrix
from ..system.budget import spend

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
    """Return the difference."""
    return add(p, scale(-1, q))


def scale(factor: Scalar | int, p: Polynomial) -> Polynomial:
    """Return the multiple."""
    return trim([factor * a for a in p])


def mul(p: Polynomial, q: Polynomial) -> Polynomial:
    """Return the product."""
    result: list[Scalar] = [_ZERO] * (len(p) + len(q) - 1)
    for i, a in enumerate(p):
        spend()
        if a.is_zero() is True:
            continue
        for j, b in enumerate(q):
            if b.is_zero() is not True:
                result[i + j] = result[i + j] + a * b
    return trim(result)


def divide(p: Polynomial, q: Polynomial) -> tuple[Polynomial, Polynomial]:
    """Return the quotient and remainder.

    Raises
    ------
    ZeroDivisionError
        When ``q`` is zero.
    ExactnessError
        When the leading coefficient of ``q`` is a ball around zero.
    """
    if not q:
        raise ZeroDivisionError("division by the zero polynomial")
    if q[-1].is_zero() is None:
        raise ExactnessError("the degree of a divisor is not decided: its leading ball holds zero")
    rest = list(p)
    quotient: list[Scalar] = [_ZERO] * max(0, len(p) - len(q) + 1)
    for shift in range(len(p) - len(q), -1, -1):
        spend()
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


def monic(p: Polynomial) -> Polynomial:
    """Return the multiple with leading coefficient 1; the zero polynomial is returned as it is."""
    if not p:
        return p
    return (*(a / p[-1] for a in p[:-1]), _ONE)


def gcd(p: Polynomial, q: Polynomial) -> Polynomial:
    """Return monic greatest common divisor."""
    p, q = trim(p), trim(q)
    if len(p) < len(q):
        p, q = q, p
    while q:
        if len(q) == 1:
            return (_ONE,)
        q = monic(q)
        p, q = q, divide(p, q)[1]
    return monic(p)


def derivative(p: Polynomial) -> Polynomial:
    """Return the derivative."""
    return trim([k * a for k, a in enumerate(p)][1:])


def share_only_one(p: Polynomial, q: Polynomial) -> bool:
    """Return whether 1 is a root of both, simple in each, and no other root is common.

    The entries are exact.
    """
    common = gcd(p, q)
    simple = all((evaluate(derivative(x), 1)).is_zero() is False for x in (p, q))
    return len(common) == 2 and (evaluate(common, 1)).is_zero() is True and simple


def squarefree(p: Polynomial) -> Polynomial:
    """Return monic polynomial with the roots of ``p``, each once."""
    p = trim(p)
    return monic(p) if len(p) <= 2 else monic(divide(p, gcd(p, derivative(p)))[0])


def evaluate(p: Polynomial, x: Scalar | int | Fraction) -> Scalar:
    """Return the value at ``x``."""
    total: Scalar = _ZERO
    for a in reversed(p):
        total = total * x + a
    return total


def evaluate_matrix(p: Polynomial, m: Matrix) -> Matrix:
    """Return the value at a square matrix."""
    one = linalg.identity(len(m))
    total = linalg.zeros(len(m), len(m))
    for a in reversed(p):
        total = linalg.add(linalg.matmul(total, m), linalg.scale(a, one))
    return total


def from_roots(roots: Sequence[Scalar]) -> Polynomial:
    """Return monic polynomial with the given roots."""
    result: Polynomial = (_ONE,)
    for root in roots:
        result = mul(result, (-root, _ONE))
    return result


def interpolate(points: Sequence[int], values: Sequence[Scalar]) -> Polynomial:
    """Return the polynomial of degree below ``len(points)`` through the values (Newton's form)."""
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
    """Return the characteristic polynomial and adjugate: ``adj(w I - M) = sum of w^k N_k``.

    Returns
    -------
    tuple[Polynomial, list[Matrix]]
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
    """Return monic polynomial det(w I - M)."""
    return faddeev_leverrier(m)[0]


def reciprocal(p: Polynomial) -> Polynomial:
    """Return ``w^n`` times the conjugate of ``p(1/conj(w))``: roots mirrored in the unit circle."""
    return trim([a.conjugate() for a in reversed(p)])


def is_self_reciprocal(p: Polynomial) -> bool:
    """Return whether ``p`` is a multiple of its reciprocal: roots come in mirrored pairs."""
    q = reciprocal(p)
    if len(p) != len(q):
        return False
    return all((a * q[-1] - b * p[-1]).is_zero() is True for a, b in zip(p, q, strict=True))


def approximate_roots(p: Polynomial) -> list[complex]:
    """Return roots in floating point (Durand, Kerner): for messages and guesses, not decisions."""
    p = trim(p)
    coefficients = [complex(a / p[-1]) for a in p[:-1]]
    size = len(coefficients)
    radius = 1 + max((abs(a) for a in coefficients), default=0.0)
    roots = [min(radius, 2.0) * (0.4 + 0.9j) ** k for k in range(size)]
    last = math.inf
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
        # near the roots changes fall until rounding stops them: what comes after gains nothing
        if change < 1e-15 * radius or last <= change < 1e-9 * radius:
            break
        last = change
    return roots
