"""Polynomials over exact numbers: what stability questions need, decided without a tolerance.

A polynomial is a tuple of scalars, constant term first. Over balls the ring operations enclose; a
decision that a ball leaves open raises :class:`~glmref.errors.ExactnessError`. Division, and where
the roots lie, are the judge's.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from ..exact import Exact, Scalar, isolated_roots
from ..exact.judging import asked
from ..system.budget import spend

Polynomial = tuple[Scalar, ...]

_ZERO, _ONE = Exact(0), Exact(1)

#: Quotient and remainder; the monic greatest common divisor; the product of x minus each number;
#: the coefficients conjugated and reversed: roots mirrored in the unit circle.
divide, gcd, from_roots, mirror = (
    asked(f"polynomials.{x}") for x in ("divide", "gcd", "from_roots", "mirror")
)
#: The factors of odd multiplicity; the chain of Sturm.
odd_factors, sturm_chain = asked("polynomials.odd_factors"), asked("polynomials.sturm_chain")
#: Whether all roots lie inside the unit circle, or on it (Schur, Cohn).
is_schur, in_disc = asked("polynomials.is_schur"), asked("polynomials.in_disc")
#: The monic polynomial det(w I - M) of a square matrix; its blocks where it is block triangular.
characteristic, blocks_of = asked("linalg.characteristic"), asked("linalg.blocks_of")


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


def monic(p: Polynomial) -> Polynomial:
    """Return the multiple with leading coefficient 1; the zero polynomial is returned as it is."""
    if not p:
        return p
    return (*(a / p[-1] for a in p[:-1]), _ONE)


def derivative(p: Polynomial) -> Polynomial:
    """Return the derivative."""
    return trim([k * a for k, a in enumerate(p)][1:])


def share_only_one(p: Polynomial, q: Polynomial) -> bool:
    """Return whether 1 is a simple root of both, and no other root is common; entries are exact."""
    return gcd(p, q) == (-1, 1) and all(evaluate(derivative(x), 1) != 0 for x in (p, q))


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


def approximate_roots(p: Polynomial) -> list[complex]:
    """Return roots in floating point, as often as they occur: for messages and guesses."""
    found: list[complex] = []
    p = trim(p)
    while len(p) > 1:
        once = squarefree(p)
        found += map(complex, isolated_roots(once) or ())
        p = divide(p, once)[0]
    return found
