"""The largest stable step size that a tableau predicts for a solution, before any step is taken.

Along the solution the Jacobian of f has eigenvalues lambda; a damped one, Re lambda <= 0, is
reproduced as damped while h lambda lies in the stability region of the method. The prediction is
the smallest h at which some h lambda leaves it for the first time: 2.785/|lambda| of the classical
fourth order method on the negative axis, none of an A-stable method. It is that of the linearised
equations at each time (Hairer, Wanner, Solving Ordinary Differential Equations II, section IV.2).
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from ..catalogue.lookup import load
from ..engine.solve import solve
from ..method import GLM, Method
from ..problems.model import Problem
from .stability import bounded, interval

#: Method, numbers of steps and states kept of the run along which Jacobians are taken.
_GUIDE, _STEPS, _SAMPLES = "radau-iia-3", (64, 512, 4096, 32_768, 262_144), 1024
#: Angles that are distinguished; of eigenvalues in one sector the largest counts.
_SECTORS = 36
#: Components of the largest Jacobian whose eigenvalues are computed.
MOST_COMPONENTS = 100
#: |z| looked at one by one, and beyond that by factors: what is bounded there stays bounded.
_NEAR, _FAR = 64.0, np.geomspace(64.0, 1e12, 60)


def stable_step(problem: Problem, method: Method, *, t_end: float) -> float | None:
    """Return the predicted largest stable step size along the solution from t0 on to ``t_end``.

    ``math.inf`` where every damped eigenvalue stays in the region for every h; ``None`` where
    nothing is predicted: of more than :data:`MOST_COMPONENTS` components, and of partitioned
    methods, whose steps are no functions of eigenvalues.
    """
    if not isinstance(method, GLM) or problem.dimension > MOST_COMPONENTS:
        return None
    spectrum = damped_eigenvalues(problem, float(t_end))
    if spectrum is None:
        return None
    return min((ray_end(method, x) / abs(x) for x in spectrum), default=math.inf)


@lru_cache(maxsize=8)
def damped_eigenvalues(problem: Problem, t_end: float) -> tuple[complex, ...] | None:
    """Return the largest damped eigenvalue of the Jacobian in each sector, along the solution.

    Those with |lambda| t_end < 1, which do nothing over the run, are left out; one of each
    conjugate pair is kept. ``None`` where no run shows the solution.
    """
    for steps in _STEPS:
        every = max(1, steps // _SAMPLES)
        run = solve(problem, load(_GUIDE), h=t_end / steps, steps=steps, every=every)
        if run.completed:
            break
    else:
        if len(run.t) < 2:  # a solution that ends early is shown up to its end
            return None
    with np.errstate(all="ignore"):
        matrices = np.array([problem.slope_at(t, y) for t, y in zip(run.t, run.y, strict=True)])
    matrices = matrices[np.isfinite(matrices).all(axis=(1, 2))]
    if not len(matrices):
        return None
    values = np.linalg.eigvals(matrices).ravel()
    # the real part of what rotates is zero but for rounding
    values = values[(values.real <= 1e-9 * np.abs(values)) & (np.abs(values) * t_end >= 1)]
    sectors: dict[int, complex] = {}
    for value in values:
        x = complex(min(value.real, 0.0), abs(value.imag))
        sector = round(np.angle(x) / (math.pi / 2 / _SECTORS))
        sectors[sector] = max(sectors.get(sector, 0j), x, key=abs)
    return tuple(sectors.values())


@lru_cache(maxsize=4096)
def ray_end(method: GLM, direction: complex) -> float:
    """Return the |z| at which a ray from 0 leaves the stability region, infinite where it stays."""
    end = interval(method, direction, most=_NEAR, samples=1024)
    if end < _NEAR:
        return end
    stays = bounded(method, _FAR * direction / abs(direction))
    return math.inf if stays.all() else float(_FAR[int(np.argmin(stays))])
