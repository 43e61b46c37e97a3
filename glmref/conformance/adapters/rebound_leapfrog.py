"""REBOUND's leapfrog (drift, kick, drift) on two bodies, one of them without mass.

The heavier body rests at the origin, so that the other one moves as the problem ``kepler`` says.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

from typing import Any

import numpy as np
import rebound


class Adapter:
    """``rebound.Simulation`` with ``integrator = "leapfrog"``: the position Verlet method."""

    methods = ("position-verlet",)
    problems = ("kepler",)

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step of a simulation made for it."""
        if problem.name != "kepler":
            raise NotImplementedError("the forces are REBOUND's own: only kepler")
        simulation = rebound.Simulation()
        simulation.integrator = "leapfrog"
        simulation.G, simulation.dt, simulation.t = 1.0, h, t
        simulation.add(m=1.0)
        simulation.add(m=0.0, x=y[0], y=y[1], vx=y[2], vy=y[3])
        simulation.N_active = 1
        simulation.steps(1)
        simulation.synchronize()
        body = simulation.particles[1]
        return np.array([body.x, body.y, body.vx, body.vy])
