"""Sums of products, and real matrices of balls: where proofs spend their time.

Both do what loops over the operators would do, in fewer steps; the enclosures are as narrow.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import flint

from ..errors import ExactnessError
from ..system.budget import spend
from .number import Ball, Exact, ball

_NIL = flint.fmpq(0)
_ZERO = Exact(0)


def sum_of_products(pairs: Sequence[tuple[Any, Any]]) -> Any:
    """Return the sum of ``x * y`` over numbers of any kind.

    Returns
    -------
    Any
        Exact where no ball took part, else a ball.
    """
    spend()
    rational, exactly, total = _NIL, None, None
    for x, y in pairs:
        first, second = type(x), type(y)
        if second is Ball:
            if first is Ball:
                product = x._acb * y._acb
            elif first is Exact:
                product = (x._ball or x.ball())._acb * y._acb
            else:
                return _sum_of_others(pairs)
            total = product if total is None else total + product
        elif second is Exact:
            if first is Exact:
                if x._q is not None and y._q is not None:
                    rational += x._q * y._q
                else:
                    exactly = x * y if exactly is None else exactly + x * y
            elif first is Ball:
                product = x._acb * (y._ball or y.ball())._acb
                total = product if total is None else total + product
            else:
                return _sum_of_others(pairs)
        else:
            return _sum_of_others(pairs)
    if exactly is not None:
        rest: Any = exactly + Exact._of(rational)
    elif total is None or rational:
        rest = Exact._of(rational)
    else:
        return Ball._wrap(total)
    return rest if total is None else Ball._wrap(total) + rest


def _sum_of_others(pairs: Sequence[tuple[Any, Any]]) -> Any:
    """Return the same where a number takes part that is neither exact nor a ball."""
    total: Any = _ZERO
    for x, y in pairs:
        total = total + x * y
    return total


class BallMatrix:
    """A matrix of balls whose products and inverse are computed as a whole.

    Parameters
    ----------
    rows : Sequence[Sequence[Exact or Ball]]
        (m, n) exact numbers or balls, one row at least.
    """

    def __init__(self, rows: Sequence[Sequence[Exact | Ball]]) -> None:
        entries = [ball(x)._acb for row in rows for x in row]
        self._matrix = flint.acb_mat(len(rows), len(rows[0]), entries)

    @classmethod
    def _wrap(cls, matrix: flint.acb_mat) -> BallMatrix:
        self = cls.__new__(cls)
        self._matrix = matrix
        return self

    @classmethod
    def identity(cls, size: int) -> BallMatrix:
        """Return the identity."""
        return cls._wrap(flint.acb_mat(size, size, 1))

    def __matmul__(self, other: BallMatrix) -> BallMatrix:
        return BallMatrix._wrap(self._matrix * other._matrix)

    def __sub__(self, other: BallMatrix) -> BallMatrix:
        return BallMatrix._wrap(self._matrix - other._matrix)

    def midpoint(self) -> BallMatrix:
        """Return the midpoints, as balls of radius zero."""
        return BallMatrix._wrap(self._matrix.mid())

    def inverse(self) -> BallMatrix:
        """Enclose the inverse of every matrix in these balls.

        Raises
        ------
        ExactnessError
            When one of them may be singular.
        """
        try:
            return BallMatrix._wrap(self._matrix.inv())
        except ZeroDivisionError:
            raise ExactnessError("a matrix of balls may be singular") from None

    def rows(self) -> tuple[tuple[Ball, ...], ...]:
        """Return the entries, (m, n)."""
        return tuple(tuple(map(Ball._wrap, row)) for row in self._matrix.tolist())
