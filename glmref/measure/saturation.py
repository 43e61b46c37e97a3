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
#: Steps after which growth may have stopped, in units of those between these sizes: in the second
#: half of them the part has been large, so that its equation does not hold. It is not followed
#: where the last are more numbers than WORK.
LENGTHS, WORK = (2.5, 4.0), 8e7
#: The energy error has grown if it becomes so many times that of the first half of 1/rate steps; it
#: grows no more if it is in the second half of the run below so many times that of the first.
GROWN = STOPPED = 2.0


def saturation(
    method: Method, problem: Problem, h: float, start: np.ndarray, part: np.ndarray, rate: float,
    *, limit: float = math.inf,
) -> float | None:  # fmt: skip
    """Find the level at which the energy error stays though a parasitic part grew.

    The part (r, d), of the size of the solution, is added to the values (r, d) of step 0; its rate
    of growth is that per step in the linear equation. Returns the largest relative error of the
    energy; ``None`` where it comes to :data:`TOO_MUCH`, does not grow or does not stop, where the
    problem has no energy, or the run would take too long; NaN where that is not seen within
    ``limit`` steps.
    """
    if problem.hamiltonian is None or not rate > 0:
        return None
    lengths = [some * math.log(LARGE / PLANTED) / rate for some in LENGTHS]
    last = min(lengths[-1], limit)
    if not lengths[-1] * start.size <= WORK:
        return None
    planted = start + PLANTED * part

    def errors(run: Solution) -> np.ndarray:
        return np.nan_to_num(energy_deviation(problem, np.real(run.y)), nan=math.inf)

    try:
        run = follow(
            problem, method, h=h, steps=math.ceil(last), start=lambda *_: planted,
            lost=lambda some: bool((errors(some) >= TOO_MUCH).any()),
        )  # fmt: skip
    except GlmrefError:
        return None
    found, at = errors(run), np.abs(run.t - run.t[0]) / abs(h)
    early = float(found[at <= 1 / (2 * rate)].max())
    for steps in lengths:
        if run.steps < steps:
            return None if not run.completed or found.max() >= TOO_MUCH else math.nan
        first, second = (
            float(found[x].max()) for x in (at <= steps / 2, (at > steps / 2) & (at <= steps))
        )
        largest = max(first, second)
        if GROWN * early < largest < TOO_MUCH and second < STOPPED * first:
            return largest
    return None
