"""Relations between algebraic numbers, found by lattice reduction and checked exactly."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import flint

from .number import Exact

BITS = 1200  # of the numbers whose relation is looked for
FACTORED = 128  # bits of the numbers that are factored completely, within a tenth of a second


def factorization(n: int) -> dict[int, int]:
    """Return coprime factors of a positive whole number with their powers.

    They are primes where the number has at most :data:`FACTORED` bits. Of a longer one, which could
    take years, only primes of up to 15 bits are found, and what is left is one factor.
    """
    whole = flint.fmpz(n)
    found = whole.factor() if n.bit_length() <= FACTORED else whole.factor_smooth(15)
    return {int(p): int(k) for p, k in found}


def cyclotomic(n: int) -> list[int]:
    """Return coefficients of the n-th cyclotomic polynomial, constant first."""
    return [int(x) for x in flint.fmpz_poly.cyclotomic(n).coeffs()]


class RationalCombinations:
    """Numbers as rational combinations of the same basis; its lattice is reduced once.

    Parameters
    ----------
    basis : Sequence[Exact]
        Linearly independent numbers.
    bits : int
        Of the numbers whose relation is looked for; large weights need more.
    """

    def __init__(self, basis: Sequence[Exact], bits: int = BITS) -> None:
        self.basis, self.bits = tuple(basis), bits
        n, parts = len(self.basis), [self._parts(x) for x in basis]
        self._reduced: list[list[Any]] | None = None
        if None not in parts:
            rows = [[0, *(int(k == j) for j in range(n)), *(x or ())] for k, x in enumerate(parts)]
            self._reduced = flint.fmpz_mat(rows).lll().tolist()

    def _parts(self, x: Exact) -> list[int] | None:
        """Return real and imaginary part times 2^bits; ``None`` where a last bit is unknown."""
        before, flint.ctx.prec = flint.ctx.prec, 2 * self.bits
        try:
            ball = x.ball(self.bits + 64)._acb
            parts = [
                (flint.arb(2) ** self.bits * part.mid()).floor().unique_fmpz()
                for part in (ball.real, ball.imag)
            ]
        finally:
            flint.ctx.prec = before
        return None if None in parts else [int(x) for x in parts]  # type: ignore[arg-type]

    def weights(self, value: Exact) -> list[Fraction] | None:
        """Return rational weights with ``value = sum weights * basis``, ``None`` if none are found.

        What is returned holds exactly; ``None`` proves nothing.
        """
        parts = self._parts(value)
        if parts is None or self._reduced is None:
            return None
        new = [1, *[0] * len(self.basis), *parts]
        lead, *row = map(int, flint.fmpz_mat([new, *self._reduced]).lll().tolist()[0])
        if not lead:
            return None
        weights = [Fraction(-x, lead) for x in row[: len(self.basis)]]
        total: Any = Exact(0)
        for w, x in zip(weights, self.basis, strict=True):
            if w:
                total = total + x * w
        return weights if (total - value).is_zero() else None


def box(value: Exact) -> tuple[list[Fraction], list[Fraction]]:
    """Return rational ends around real and imaginary part, about 2^-40 apart."""
    ball = value.ball(256)._acb

    def ends(x: Any) -> list[Fraction]:
        low = int((x.mid() * 2**40).floor().unique_fmpz()) - 1
        return [Fraction(low, 2**40), Fraction(low + 3, 2**40)]

    nothing = [Fraction(0), Fraction(0)]
    return ends(ball.real), nothing if value.is_real() else ends(ball.imag)
