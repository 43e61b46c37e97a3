"""The path of a run in a plane, as a few points that can be drawn.

Which plane: ``x`` and ``y`` of every body where there are several; ``q_1`` and ``q_2`` of a system
with two degrees of freedom or more; ``q`` and ``p`` of one with one; else ``y_1`` and ``y_2``.

Which points: the steps nearest to ``n {k phi}``, k = 0, 1, 2, .., with n the number of steps, phi
the golden ratio and {} the part behind the point, and the last step. They lie evenly over the run,
and their distances have no period: evenly spaced ones that beat with a revolution would show a few
clumps instead of an orbit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.solve import solve
from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from .longtime import energy_deviation

#: Points of all bodies together, at the most.
POINTS = 400
#: Digits kept of a coordinate: a picture shows three or four.
DIGITS = 7
#: Relative error of the energy from which a run is lost.
LOST = 1.0
_GOLDEN = (math.sqrt(5.0) - 1) / 2


@dataclass(frozen=True, eq=False)
class Orbit:
    """Points of a run in a plane."""

    axes: tuple[str, str]  #: Names of the two components.
    t: np.ndarray  #: (m,) times.
    paths: np.ndarray  #: (bodies, m, 2) points of each body.
    ended: str = ""  #: Why the path stops before the run does, in one sentence, or ``""``.

    def as_json(self) -> dict[str, Any]:
        """Return the record's ``orbit`` block: for each body its points [t, x, y]."""
        return {
            "axes": list(self.axes),
            "paths": [
                [[_short(t), _short(x), _short(y)] for t, (x, y) in zip(self.t, path, strict=True)]
                for path in self.paths
            ],
            "ended": self.ended or None,
        }


def plane_of(problem: Problem) -> tuple[tuple[str, str], list[tuple[int, int]]]:
    """Return names of the two axes, and for each body the two components of the state.

    Raises
    ------
    UsageError
        For a problem with one component.
    """
    d = problem.dimension
    if d < 2:
        raise UsageError(f"{problem.name} has one component; do not ask for an orbit")
    if problem.bodies > 1:
        space = d // 2 // problem.bodies
        if space > 1:
            return ("x", "y"), [(space * k, space * k + 1) for k in range(problem.bodies)]
    if d == 2 and (problem.canonical or problem.separable):
        return ("q", "p"), [(0, 1)]
    two = problem.canonical or problem.separable
    return (("q_1", "q_2") if two else ("y_1", "y_2")), [(0, 1)]


def marks(steps: int, points: int) -> list[int]:
    """Return numbers of steps, increasing, from 0 to the last, at most so many."""
    found = {round(steps * (k * _GOLDEN % 1.0)) for k in range(max(points - 1, 1))}
    return sorted(found | {steps})


def orbit(
    problem: Problem,
    method: Method,
    *,
    h: float,
    steps: int,
    start: Any = None,
    renew: int = 0,
) -> Orbit:
    """Take the steps and keep points of the path, with the options of :func:`glmref.solve`.

    It ends where the numbers are not finite or the energy error reaches the energy itself.
    """
    axes, pairs = plane_of(problem)
    t0 = float(problem.t_span[0])
    kept = marks(steps, max(POINTS // len(pairs), 2))
    solution = solve(
        problem, method, h=h, times=[t0 + n * h for n in kept], start=start, renew=renew
    )
    t = np.asarray(solution.t, dtype=float)
    y = np.real(np.asarray(solution.y)).astype(float).reshape(len(t), -1)
    good, why = _good(problem, y)
    if not why and not solution.completed:
        why = str(solution.outcome)
    paths = np.array([y[:good][:, list(pair)] for pair in pairs])
    return Orbit(axes, t[:good], paths, f"{why} after t = {t[good - 1]:.6g}" if why else "")


def _good(problem: Problem, y: np.ndarray) -> tuple[int, str]:
    """Return how many rows are good, and why the next one is not."""
    finite = np.all(np.isfinite(y), axis=1)
    bad, why = ~finite, "not finite"
    if problem.hamiltonian is not None:
        bad = bad | ~(energy_deviation(problem, y) < LOST)
    if not bad.any():
        return len(y), ""
    first = max(int(np.argmax(bad)), 1)  # the start is shown whatever it is
    return first, why if not finite[first] else "lost"


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")
