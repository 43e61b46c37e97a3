"""Sums of products, and real matrices of balls: where proofs spend their time.

Both do what loops over the operators would do, in fewer steps; the enclosures are as narrow.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import flint

from ..errors import ExactnessError
from ..system.budget import spend
from .ball import Ball, ball
from .jet import Jet
from .number import Exact

__all__ = ["BallMatrix", "sum_of_products"]

_NIL = flint.fmpq(0)
_SCALARS = frozenset({Ball, Exact})
_ZERO = Exact(0)


def sum_of_products(pairs: Sequence[tuple[Any, Any]]) -> Any:
    """Sum of ``x * y`` over numbers of any kind.

    Returns
    -------
        Exact where no ball took part; a ball; a jet where one took part.
    """
    spend()
    kinds = {type(x) for x, _ in pairs} | {type(y) for _, y in pairs}
    if Jet in kinds:
        return Jet.sum_of_products(pairs)
    if kinds <= _SCALARS:
        return _sum_of_scalars(pairs)
    total: Any = _ZERO
    for x, y in pairs:
        total = total + x * y
    return total


def _sum_of_scalars(pairs: Sequence[tuple[Exact | Ball, Exact | Ball]]) -> Exact | Ball:
    """The same where no jet takes part: rationals, other exact numbers and balls apart."""
    rational, exactly, total = _NIL, None, None
    for x, y in pairs:
        if type(x) is Exact and type(y) is Exact:
            if x._q is not None and y._q is not None:
                rational += x._q * y._q
            else:
                exactly = x * y if exactly is None else exactly + x * y
        else:
            a = x._acb if type(x) is Ball else x.ball()._acb
            b = y._acb if type(y) is Ball else y.ball()._acb
            total = a * b if total is None else total + a * b
    if exactly is not None:
        rest: Any = exactly + Exact(rational)
    elif total is None or rational != 0:
        rest = Exact(rational)
    else:
        return Ball._wrap(total)
    return rest if total is None else Ball._wrap(total) + rest


class BallMatrix:
    """A matrix of balls whose products and inverse are computed as a whole.

    Args:
        rows: (m, n) exact numbers or balls, one row at least.
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
        """The identity."""
        return cls._wrap(flint.acb_mat(size, size, 1))

    def __matmul__(self, other: BallMatrix) -> BallMatrix:
        return BallMatrix._wrap(self._matrix * other._matrix)

    def __sub__(self, other: BallMatrix) -> BallMatrix:
        return BallMatrix._wrap(self._matrix - other._matrix)

    def midpoint(self) -> BallMatrix:
        """The midpoints, as balls of radius zero."""
        return BallMatrix._wrap(self._matrix.mid())

    def inverse(self) -> BallMatrix:
        """Enclose the inverse of every matrix in these balls.

        Raises
        ------
            ExactnessError: when one of them may be singular.
        """
        try:
            return BallMatrix._wrap(self._matrix.inv())
        except ZeroDivisionError:
            raise ExactnessError("a matrix of balls may be singular") from None

    def rows(self) -> tuple[tuple[Ball, ...], ...]:
        """(m, n) the entries."""
        return tuple(tuple(map(Ball._wrap, row)) for row in self._matrix.tolist())
