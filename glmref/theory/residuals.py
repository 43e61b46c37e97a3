"""What a matrix of residuals says: all zero, some entry not zero, or open.

The linear systems the residuals belong to are solved by :func:`glmref.exact.linalg.solve_affine`.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..exact.linalg import Matrix


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
    nonzero: tuple[float, tuple[int, int]] | None = None
    open_size = -1.0
    for i, row in enumerate(residual):
        for j, x in enumerate(row):
            zero = x.is_zero()
            if zero is True:
                continue
            size = x.magnitude()
            if zero is None:
                open_size = max(open_size, size)
            elif nonzero is None or size > nonzero[0]:
                nonzero = (size, (i, j))
    if nonzero is not None:
        return Residual(False, *nonzero)
    if open_size >= 0:
        return Residual(None, open_size)
    return Residual(True)
