"""Our reference engine, double precision: the step as in a paper, with every operation offered."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...catalogue.lookup import load
from ...engine.reference import Stepper, apply_finish, stepper
from ...engine.starting_values import starting_values
from ...method import Method
from ..vectors import file_names


class Adapter:
    """The reference engine as some methods, by default all that have vectors."""

    def __init__(self, methods: Sequence[str] | None = None) -> None:
        self.methods = tuple(file_names() if methods is None else methods)
        self._known: dict[str, Method] = {}
        self._engines: dict[tuple[str, int], Stepper] = {}

    def _method(self, name: str) -> Any:
        if name not in self._known:
            self._known[name] = load(name)
        return self._known[name]

    def _engine(self, method: str, problem: Any) -> Stepper:
        key = (method, id(problem))
        if key not in self._engines or self._engines[key].problem is not problem:
            self._engines[key] = stepper(self._method(method), problem)
        return self._engines[key]

    def _taken(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> Any:
        engine = self._engine(method, problem)
        taken = engine.step(t, y.reshape(engine.shape), h)
        if not taken.converged:
            raise ArithmeticError(f"the stages of {method} could not be solved at t = {t}")
        return taken

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step."""
        return self._taken(method, problem, t, y, h).values

    def stages(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> Any:
        """Return stage values of one step."""
        return self._taken(method, problem, t, y, h).stages

    def start(self, method: str, problem: Any, h: float) -> np.ndarray:
        """Return starting values by the method's own starting method."""
        known, engine = self._method(method), self._engine(method, problem)
        starting = getattr(known, "starting", None)
        t, y0 = problem.t_span[0], np.array(problem.y0)
        if starting is None:
            if engine.shape[0] > 1:
                raise NotImplementedError(f"the data of {method} give no starting method")
            return y0[None, :]
        return starting_values(engine, starting, t=t, y0=y0, h=h).values

    def finish(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Return the solution that belongs to the values."""
        engine = self._engine(method, problem)
        first = y.reshape(engine.shape)[0]
        finishing = getattr(self._method(method), "finishing", None)
        return first if finishing is None else apply_finish(finishing, engine, t, first, h)[0]

    def solve(
        self, method: str, problem: Any, h: float, steps: int, start: np.ndarray | None = None
    ) -> np.ndarray:
        """Start, steps and finish."""
        engine, t0 = self._engine(method, problem), problem.t_span[0]
        values = starting_values(engine, start, t=t0, y0=np.array(problem.y0), h=h).values
        rows = [self.finish(method, problem, t0, values, h)]
        for n in range(steps):
            values = self.step(method, problem, t0 + n * h, values, h)
            rows.append(self.finish(method, problem, t0 + (n + 1) * h, values, h))
        return np.array(rows)
