"""A solution between the rows that a run kept."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import UsageError
from ..system.arguments import listed, number, shown
from .outcome import Solution
from .solve import solve

#: Distance of a time from a row, in units of h, below which the row is the solution there.
_SAME = 1e-12


def at(solution: Solution, t: Any) -> np.ndarray:
    """See :meth:`.outcome.Solution.at`."""
    if solution.origin is None:
        raise UsageError("a solution that was loaded has no right-hand side; keep more rows")
    if np.ndim(t) == 0:
        return _at(solution, number("t", t))
    times = [number("t", x) for x in listed("t", t)]
    return np.array([_at(solution, x) for x in times]).reshape(-1, solution.y.shape[1])


def _at(solution: Solution, t: float) -> np.ndarray:
    problem, method = solution.origin
    rows = np.asarray(solution.t, dtype=float)
    if not len(rows):
        raise UsageError("no row was kept; give `every` or `times` to solve")
    steps = (t - rows) / solution.h  # how many steps after each row; h may be negative
    after = np.flatnonzero(steps >= -_SAME)
    if not len(after) or steps[-1] > _SAME:
        ends = f"{rows[0]:g} to {rows[-1]:g}"
        raise UsageError(
            f"`t` must lie within the rows kept, {ends}, got {shown(t)}; keep more with `every`"
        )
    row = int(after[-1])
    if steps[row] <= _SAME:
        return solution.y[row]
    n = max(1, math.ceil(steps[row] - _SAME))
    begin = float(rows[row])
    start = replace(problem, y0=tuple(solution.y[row].tolist()), t_span=(begin, t))
    found = solve(start, method, h=(t - begin) / n, steps=n)
    if not found.completed:
        raise UsageError(f"between the rows at t = {t:g}: {found.message}")
    return found.y[-1]
