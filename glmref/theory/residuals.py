"""What a matrix of residuals says: all zero, some entry not zero, or open.

The linear systems the residuals belong to are solved by :func:`glmref.exact.linalg.solve_affine`.
"""

from __future__ import annotations

from dataclasses import dataclass
from operator import itemgetter

from ..exact.linalg import Matrix, entries


@dataclass(frozen=True)
class Residual:
    """What a residual matrix says: all zero, some entry not zero, or open."""

    #: ``True``, ``False``, or ``None`` where only balls around zero keep it open.
    holds: bool | None
    residual: float = 0.0  #: Upper bound of the largest entry, 0.0 when all are zero.
    #: (row, column) of the largest entry that is not zero, or ``None``.
    entry: tuple[int, int] | None = None


def verdict_of(residual: Matrix) -> Residual:
    """Judge a residual matrix: see :class:`Residual`."""
    zeros = [(x.is_zero(), x, (i, j)) for i, j, x in entries(residual)]
    known, open_ = ([(x.magnitude(), at) for zero, x, at in zeros if zero is answer]
                    for answer in (False, None))  # fmt: skip
    if known:
        return Residual(False, *max(known, key=itemgetter(0)))
    return Residual(None, max(open_)[0]) if open_ else Residual(True)
