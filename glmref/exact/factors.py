"""Factors of polynomials over the rational numbers."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import lcm

import flint


def rational_factors(p: Sequence[Fraction]) -> list[tuple[tuple[Fraction, ...], int]]:
    """Return the monic irreducible factors of a polynomial over Q, each with its multiplicity.

    Parameters
    ----------
    p : Sequence[Fraction]
        Coefficients, constant first; the last is not 0.
    """
    scale = lcm(*(x.denominator for x in p))
    _, found = flint.fmpz_poly([int(x * scale) for x in p]).factor()
    return [
        (tuple(Fraction(int(x), int(factor[factor.degree()])) for x in factor), int(times))
        for factor, times in found
    ]
