"""Whether growth of a parasitic part stops before the energy is lost, from a run that begins large.

The linear equation of a parasitic part (:mod:`.prediction`) holds while the part is small. Beyond,
nonlinear terms change its frequencies, and growth may stop: the run saturates. What becomes of it
does not depend on how the part came to a size at which the linear equation still holds. So it is
planted with such a size, in the direction that it has by then, and followed; nothing is fitted.
"""

from __future__ import annotations

import math

import numpy as np

from ..engine.outcome import Solution
from ..errors import GlmrefError
from ..method import Method
from ..problems.model import Problem
from .longtime import energy_deviation, follow

#: Relative error at which the energy is lost.
TOO_MUCH = 0.1
#: Size of a planted part, relative to the solution, and that at which its equation ends.
PLANTED, LARGE = 3e-3, 0.3
#: Steps for which it is followed, in units of those between these sizes; it is not followed where
#: that is more numbers than WORK.
PATIENCE, WORK = 2.5, 5e7
#: The energy error has grown if it becomes so many times that of the first half of 1/rate steps; it
#: grows no more if it is in the second half of the run below so many times that of the first.
GROWN = STOPPED = 2.0


def saturation(
    method: Method, problem: Problem, h: float, start: np.ndarray, part: np.ndarray, rate: float
) -> float | None:
    """Find the level at which the energy error stays though a parasitic part grew.

    The part (r, d), of the size of the solution, is added to the values (r, d) of step 0; its rate
    of growth is that per step in the linear equation. Returns the largest relative error of the
    energy; ``None`` where it comes to :data:`TOO_MUCH`, does not grow or does not stop, where the
    problem has no energy, or the run would take too long.
    """
    steps = PATIENCE * math.log(LARGE / PLANTED) / rate if rate > 0 else math.inf
    if problem.hamiltonian is None or not steps * start.size <= WORK:
        return None
    planted = start + PLANTED * part

    def errors(run: Solution) -> np.ndarray:
        return np.nan_to_num(energy_deviation(problem, np.real(run.y)), nan=math.inf)

    try:
        run = follow(
            problem, method, h=h, steps=math.ceil(steps), start=lambda *_: planted,
            lost=lambda some: bool((errors(some) >= TOO_MUCH).any()),
        )  # fmt: skip
    except GlmrefError:
        return None
    found = errors(run)
    largest = float(found.max())
    if not run.completed or run.steps < steps or largest >= TOO_MUCH:
        return None
    at = np.abs(run.t - run.t[0]) / abs(h)
    first, second = (float(found[x].max()) for x in (at <= steps / 2, at > steps / 2))
    grew = largest > GROWN * float(found[at <= 1 / (2 * rate)].max())
    return largest if grew and second < STOPPED * first else None
