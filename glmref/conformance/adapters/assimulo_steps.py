"""Assimulo's explicit Runge-Kutta methods at constant step size, forward in time only."""

# pyright: reportMissingImports=false
from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from assimulo.problem import Explicit_Problem
from assimulo.solvers import ExplicitEuler, RungeKutta4

_QUIET = 50


class Adapter:
    """``assimulo.solvers``: ExplicitEuler and RungeKutta4."""

    solvers: ClassVar[Mapping[str, Any]] = {"euler": ExplicitEuler, "rk4": RungeKutta4}
    methods = tuple(solvers)

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step."""
        if h < 0:
            raise NotImplementedError("these solvers of Assimulo go forward in time only")
        given = Explicit_Problem(lambda s, x: np.array(problem.f(s, x)), np.array(y), t)
        solver = self.solvers[method](given)
        solver.verbosity, solver.h = _QUIET, h
        return np.array(solver.simulate(t + h, 1)[1][-1])
