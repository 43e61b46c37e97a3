"""Real and complex form of a method that carries conjugate pairs: the gamma transformation.

With ``gamma = [[1/2, i/2], [1/2, -i/2]]`` on each pair, (A, U, B, V) becomes
(A, U gamma, gamma^-1 B, gamma^-1 V gamma) and G becomes gamma^* G gamma.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..method import GLM

_ONE = Exact(1)


def _gamma_blocks(r: int, pairs: Sequence[int], block: Matrix) -> Matrix:
    blocks: list[Matrix] = []
    k = 0
    while k < r:
        if k in pairs:
            blocks.append(block)
            k += 2
        else:
            blocks.append(((_ONE,),))
            k += 1
    return linalg.block_diagonal(*blocks)


def _gamma() -> Matrix:
    """[[1/2, i/2], [1/2, -i/2]]: a conjugate pair (x + i y)/2, (x - i y)/2 from real (x, y)."""
    half = Exact(Fraction(1, 2))
    i_half = Exact(-1).sqrt() * half
    return ((half, i_half), (half, -i_half))


def complex_pairs(m: GLM) -> list[int]:
    """Places k (from 0) where values k and k + 1 are conjugate: rows of B, columns of U."""
    found: list[int] = []
    k = 0
    while k + 1 < m.r:
        column, other = ([row[j] for row in m.U] for j in (k, k + 1))
        first = (*m.B[k], *column)
        second = tuple(x.conjugate() for x in (*m.B[k + 1], *other))
        if not all(x.is_real() for x in first) and all(
            (x - y).is_zero() is True for x, y in zip(first, second, strict=True)
        ):
            found.append(k)
            k += 1
        k += 1
    return found


def rotation_pairs(m: GLM) -> list[int]:
    """Places k (from 0) where V has a block ``[[a, -b], [b, a]]``, b not zero, in k and k + 1."""
    found: list[int] = []
    for k in range(m.r - 1):
        (a, b), (c, d) = m.V[k][k : k + 2], m.V[k + 1][k : k + 2]
        if b.is_zero() is False and (b + c).is_zero() is True and (a - d).is_zero() is True:
            found.append(k)
    return found


def to_real(m: GLM, pairs: Sequence[int] | None = None) -> GLM:
    """Carry real and imaginary part instead of conjugate pairs: ``(A, U g, g^-1 B, g^-1 V g)``.

    Parameters
    ----------
    m : GLM
        A method with conjugate pairs of values.
    pairs : Sequence[int] or None
        Places of the first value of each pair, from 0; found when not given.

    References: Khan (2018), equation (3.7).
    """
    places = complex_pairs(m) if pairs is None else pairs
    return m.transform(linalg.inverse(_gamma_blocks(m.r, places, _gamma())))


def to_complex(m: GLM, pairs: Sequence[int] | None = None) -> GLM:
    """Undo :func:`to_real`: carry conjugate pairs, so that rotation blocks of V become diagonal.

    References: Khan (2018), equation (3.7).
    """
    places = rotation_pairs(m) if pairs is None else pairs
    return m.transform(_gamma_blocks(m.r, places, _gamma()))
