"""A wrong integrator, which shows that a red cell is red: RK4 whose third weight is 0.3334."""

from __future__ import annotations

from typing import Any

import numpy as np


class Adapter:
    """The classical method with a wrong digit."""

    methods = ("rk4",)

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one wrong step."""
        f = problem.f
        k1 = f(t, y)
        k2 = f(t + h / 2, y + h / 2 * k1)
        k3 = f(t + h / 2, y + h / 2 * k2)
        k4 = f(t + h, y + h * k3)
        return y + h * (k1 / 6 + k2 / 3 + 0.3334 * k3 + k4 / 6)
