"""Relations between algebraic numbers, found by lattice reduction and checked exactly."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint

from .number import Exact

BITS = 1200  # of the numbers whose relation is looked for


def factorization(n: int) -> dict[int, int]:
    """Primes of a positive whole number with their powers."""
    return {int(p): int(k) for p, k in flint.fmpz(n).factor()}


def cyclotomic(n: int) -> list[int]:
    """Coefficients of the n-th cyclotomic polynomial, constant first."""
    return [int(x) for x in flint.fmpz_poly.cyclotomic(n).coeffs()]


def rational_combination(
    value: Exact, basis: Sequence[Exact], *, bits: int = BITS
) -> list[Fraction] | None:
    """Rational weights with ``value = sum weights * basis``, or ``None`` where none were found.

    What is returned holds exactly; ``None`` proves nothing: large weights need more bits.
    """
    columns = [value, *basis]
    size, rows, parts = len(columns), [], list[int]()
    before, flint.ctx.prec = flint.ctx.prec, 2 * bits
    try:
        for k, x in enumerate(columns):
            ball = x.ball(bits + 64)._acb
            for part in (ball.real, ball.imag):
                scaled = (flint.arb(2) ** bits * part.mid()).floor().unique_fmpz()
                if scaled is None:  # a part so large that its last bit is unknown
                    return None
                parts.append(int(scaled))
            rows.append([*(int(k == j) for j in range(size)), *parts[-2:]])
    finally:
        flint.ctx.prec = before
    first = flint.fmpz_mat(rows).lll()
    lead = int(first[0, 0])
    if not lead:
        return None
    weights = [Fraction(-int(first[0, j]), lead) for j in range(1, size)]
    total: Any = Exact(0)
    for w, x in zip(weights, basis, strict=True):
        if w:
            total = total + x * w
    return weights if (total - value).is_zero() else None


def box(value: Exact) -> tuple[list[Fraction], list[Fraction]]:
    """Rational ends around the real and around the imaginary part, about 2^-40 apart."""
    ball = value.ball(256)._acb

    def ends(x: Any) -> list[Fraction]:
        low = int((x.mid() * 2**40).floor().unique_fmpz()) - 1
        return [Fraction(low, 2**40), Fraction(low + 3, 2**40)]

    nothing = [Fraction(0), Fraction(0)]
    return ends(ball.real), nothing if value.is_real() else ends(ball.imag)
