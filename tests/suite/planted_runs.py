"""Wrong integrators, continued: arithmetic, manners, runs, and claims of integrators of their own."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from glmref.conformance.adapters.reference import Adapter as Reference

from .planted import PLANTED, Base, planted

__all__ = ["PLANTED", "Foreign"]

# --- arithmetic and manners ---------------------------------------------------------------------


@planted("repeatable", "keeps something from call to call", methods=("dormand-prince-5",))
class LastSlopeKept(Base):
    """First same as last, but the slope of the last call is used whatever the new input is."""

    without = ("stages", "solve")

    def __init__(self) -> None:
        super().__init__()
        self.last: Any = None

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        first = problem.f(t, y) if self.last is None or len(self.last) != len(y) else self.last
        engine = self._engine(method, problem)
        slopes = [first]
        for i in range(1, 7):
            at = y + h * sum(engine.A[i, j] * k for j, k in enumerate(slopes))
            slopes.append(problem.f(t + engine.c[i] * h, at))
        self.last = slopes[-1]
        return y + h * sum(b * k for b, k in zip(engine.B[0], slopes, strict=True))


@planted("step", "raised ZeroDivisionError", methods=("rk4",))
class RaisesInTwoDimensions(Base):
    without = ("stages",)

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        if problem.dimension == 4:
            raise ZeroDivisionError("radius")
        return super().step(method, problem, t, y, h)


# --- runs ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Run:
    """A run as the suite asks for it."""

    right: Reference
    method: str
    problem: Any
    h: float
    steps: int
    start: Any

    def t(self, n: int) -> float:
        """Return the time after n steps."""
        return self.problem.t_span[0] + n * self.h

    def step(self, n: int, values: Any) -> np.ndarray:
        """Take step n + 1 as it is right."""
        return self.right.step(self.method, self.problem, self.t(n), values, self.h)

    def rows(self, **changes: Any) -> np.ndarray:
        """Return the rows of the right integrator, for this run or one with changes."""
        run = replace(self, **changes)
        return self.right.solve(run.method, run.problem, run.h, run.steps, run.start)


class RunOnly(Base):
    """Shows nothing but ``solve``; :meth:`rows` is what it does wrong."""

    without = ("step", "stages", "start", "finish")

    def solve(
        self, method: str, problem: Any, h: float, steps: int, start: Any = None
    ) -> np.ndarray:
        return self.rows(Run(Reference(self.methods), method, problem, h, steps, start))

    def rows(self, run: Run) -> np.ndarray:
        raise NotImplementedError


@planted("trajectory", "TimeNotAdvanced", methods=("rk4",))
class TimeNotAdvanced(RunOnly):
    def rows(self, run: Run) -> np.ndarray:
        rows = [np.array(run.problem.y0)]
        for _ in range(run.steps):
            rows.append(run.step(0, rows[-1])[0])
        return np.array(rows)


@planted("trajectory", "StepMissing", methods=("gauss-2",))
class StepMissing(RunOnly):
    def rows(self, run: Run) -> np.ndarray:
        return run.rows(steps=run.steps - 1)[-1]


@planted("trajectory", "StepHalved", methods=("rk4",))
class StepHalved(RunOnly):
    def rows(self, run: Run) -> np.ndarray:
        return run.rows(h=run.h / 2, steps=2 * run.steps)[::2]


@planted("trajectory", "StartZeroed", methods=("gsymplectic-n",))
class RunWithoutStart(RunOnly):
    def rows(self, run: Run) -> np.ndarray:
        y0 = np.array(run.problem.y0)
        return run.rows(start=np.stack([y0, 0 * y0]))


@planted("trajectory", "FinishSkipped", methods=("g4123",))
class RunWithoutFinish(RunOnly):
    def rows(self, run: Run) -> np.ndarray:
        values = run.right.start(run.method, run.problem, run.h)
        for n in range(run.steps):
            values = run.step(n, values)
        return values[0]


# --- claims of integrators outside the catalogue ------------------------------------------------


class Foreign:
    """A method the catalogue lacks, with claims of its own."""

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        f = problem.f
        k1 = f(t, y)
        k2 = f(t + h / 2, y + h / 2 * k1)
        k3 = f(t + h / 2, y + h / 2 * k2)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(t + h, y + h * k3))


@planted("order", "falls like h^", "not h^5", methods=("mine",))
class OrderOverclaimed(Foreign):
    methods: ClassVar = {"mine": {"order": 5}}


@planted("symplectic", "M^T J M", methods=("mine",))
class SymplecticityOverclaimed(Foreign):
    methods: ClassVar = {"mine": {"order": 4, "symplectic": True}}


@planted("symmetric", "one back miss the beginning", methods=("mine",))
class SymmetryOverclaimed(Foreign):
    methods: ClassVar = {"mine": {"order": 4, "symmetric": True}}
