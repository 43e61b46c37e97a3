"""scipy's explicit and implicit Runge-Kutta methods, one step at a time and without error control.

The solvers choose their step by an error estimate; a huge tolerance lets every step of the size
asked for pass. Radau's Newton iteration is measured in units of the same tolerance and must be
strict, so its own bound is divided by it.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
from scipy.integrate import DOP853, RK23, RK45, Radau

_ANYTHING = 1e10


class Adapter:
    """``scipy.integrate``: RK23, RK45, DOP853 and Radau at constant step size."""

    solvers: ClassVar[Mapping[str, type]] = {
        "dormand-prince-5": RK45,
        "bogacki-shampine-3": RK23,
        "dop853": DOP853,
        "radau-iia-3": Radau,
    }
    methods: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "dormand-prince-5": {},
        "bogacki-shampine-3": {},
        "radau-iia-3": {},
        "dop853": {"order": 8},
    }
    # six simplified Newton iterations with the Jacobian of the step's beginning are all that Radau
    # allows itself; the last change of a stage is what is left of its error
    tolerance: ClassVar[float | Mapping[str, float]] = {"radau-iia-3": 1e-11}

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step of size h, whatever the error estimate says."""
        options: dict[str, Any] = {"rtol": 1e-3, "atol": _ANYTHING}
        if method == "radau-iia-3":
            options["jac"] = problem.jacobian
        solver = self.solvers[method](
            problem.f, t, y, t + 8 * h, first_step=abs(h), max_step=abs(h), **options
        )
        if isinstance(solver, Radau):
            solver.newton_tol = 1e-13 / _ANYTHING
        message = solver.step()
        if solver.status == "failed" or solver.t != t + h:
            raise ArithmeticError(f"{method} did not take the step: {message or solver.t}")
        return solver.y
