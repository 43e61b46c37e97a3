"""Fix what is left free: from one solution of many to a square system with rational parameters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import TypeVar

import numpy as np

from ..errors import GlmrefError
from ..prove.enclosure import gaps_of
from .ansatz import Ansatz
from .partitioned import PairAnsatz
from .polish import ConvergenceError
from .search import evaluate, levenberg_marquardt

_Ansatz = TypeVar("_Ansatz", Ansatz, PairAnsatz)


class RankError(GlmrefError):
    """The Jacobian at a solution has not full rank: the equations are not independent there."""


def pivots(
    jacobian: np.ndarray, *, first: Sequence[int] = (), tolerance: float = 1e-8
) -> list[int]:
    """Return the unknowns to fix, so that the rest is determined, by elimination with pivoting.

    The Jacobian is (m, n), m <= n. Columns ``first`` are eliminated first, so that they are not
    among those to fix; ``tolerance`` is the smallest pivot, relative to the largest entry.

    Raises
    ------
    RankError
        When the m rows have numerical rank below m.
    """
    rows = np.array(jacobian, dtype=float)
    m, n = rows.shape
    scale = float(np.abs(rows).max())
    taken: list[int] = []
    for k in range(m):
        part = np.abs(rows[k:, :])
        part[:, taken] = 0.0
        if k < len(first):
            part[:, [j for j in range(n) if j != first[k]]] = 0.0
        i, j = np.unravel_index(int(part.argmax()), part.shape)
        if part[i, j] < tolerance * scale:
            raise RankError(f"the {m} equations have rank {k} at the solution")
        rows[[k, k + int(i)]] = rows[[k + int(i), k]]
        rows[k + 1 :] -= np.outer(rows[k + 1 :, j] / rows[k, j], rows[k])
        taken.append(int(j))
    return [j for j in range(n) if j not in taken]


def fix_parameters(
    ansatz: _Ansatz, point: Sequence[float], *, places: int = 3
) -> tuple[_Ansatz, list[float]]:
    """Fix the free parameters at decimals near a solution and solve again, in double precision.

    From m equations for n >= m unknowns and a solution (n,) it makes a square ansatz and a solution
    of it. Only parameters of the method are fixed, never a principal part ``xi``.

    Raises
    ------
    RankError
        See :func:`pivots`.
    ConvergenceError
        When the rounded parameters admit no solution nearby.
    """
    document = ansatz.document()
    names = list(document["unknowns"])
    _, jacobian = evaluate(gaps_of(document), np.array([point]))
    parts = [k for k, x in enumerate(names) if x.startswith("xi")]
    free = [names[k] for k in pivots(jacobian[0], first=parts)]
    values = dict(zip(names, point, strict=True))
    fixed = {x: str(Fraction(round(values[x] * 10**places), 10**places)) for x in free}
    square = replace(ansatz, fixed={**ansatz.fixed, **fixed})
    smaller = square.document()
    start = np.array([[values.get(x, 0.0) for x in smaller["unknowns"]]])
    solved, residual = levenberg_marquardt(gaps_of(smaller), start, iterations=100)
    if not residual[0] < 1e-10:
        raise ConvergenceError(
            f"with {', '.join(f'{k} = {v}' for k, v in fixed.items())} the residual stays at "
            f"{residual[0]:.3g}; give more places"
        )
    return square, [float(x) for x in solved[0]]
