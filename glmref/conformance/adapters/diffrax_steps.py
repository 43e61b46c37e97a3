"""diffrax's explicit Runge-Kutta methods at constant step size, in double precision."""

# pyright: reportMissingImports=false
from __future__ import annotations

from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np

from ...measure.peers import traced_by_jax

#: Name in the catalogue -> solver.
SOLVERS = {
    "euler": diffrax.Euler,
    "heun-2": diffrax.Heun,
    "midpoint-explicit": diffrax.Midpoint,
    "ralston-2": diffrax.Ralston,
    "bogacki-shampine-3": diffrax.Bosh3,
    "dormand-prince-5": diffrax.Dopri5,
}


class Adapter:
    """``diffrax`` solvers, one step at a time. Makes jax compute in double precision."""

    def __init__(self) -> None:
        jax.config.update("jax_enable_x64", True)
        self.methods: dict[str, dict[str, Any]] = {name: {} for name in SOLVERS}
        self.methods |= {"tsit5": {"order": 5}, "dopri8": {"order": 8}}
        self.solvers = {name: solver() for name, solver in SOLVERS.items()}
        self.solvers |= {"tsit5": diffrax.Tsit5(), "dopri8": diffrax.Dopri8()}
        self.steps: dict[tuple[str, int], tuple[Any, Any]] = {}

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step, compiled once for each method and problem."""
        key = (method, id(problem))
        if key not in self.steps:
            # the problem is kept too: an id is unique only among the living
            self.steps[key] = (problem, self._compiled(method, problem))
        return np.asarray(self.steps[key][1](t, t + h, jnp.asarray(y)))

    def _compiled(self, method: str, problem: Any) -> Any:
        solver, term = self.solvers[method], diffrax.ODETerm(_field(problem))

        def step(t0: Any, t1: Any, y: Any) -> Any:
            state = solver.init(term, t0, t1, y, None)
            return solver.step(term, t0, t1, y, None, state, made_jump=False)[0]

        return jax.jit(step) if problem.expressions is not None else step


def _field(problem: Any) -> Any:
    """Return the right-hand side that jax can trace; a Python function is called back from it."""

    def called(t: Any, y: Any, _: Any) -> Any:
        shape = jax.ShapeDtypeStruct(y.shape, y.dtype)
        return jax.pure_callback(lambda s, x: problem.f(float(s), np.asarray(x)), shape, t, y)

    return called if problem.expressions is None else traced_by_jax(problem)
