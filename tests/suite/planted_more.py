"""Wrong integrators, continued: single entries, halves of pairs, histories, Rosenbrock methods."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np

from glmref.catalogue.lookup import load
from glmref.engine.reference import StageSolver
from tests.build import floats

from .planted import Base, StoppedBase, planted
from .planted_runs import PLANTED, Foreign, Run, RunOnly
from .real_defects import Rosenbrock

__all__ = ["PLANTED", "Foreign"]


# --- halves of pairs ----------------------------------------------------------------------------


@planted("step", "B_hat[1][1] is -0.5 and must be 0.5", methods=("stormer-verlet",))
class KickSign(Base):
    without = ("stages", "solve")

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        q, p = np.split(y, 2)
        p = p - h / 2 * problem.dp(q)
        q = q + h * problem.dq(p)
        return np.concatenate([q, p - h / 2 * problem.dp(q)])


def composed(problem: Any, y: Any, sizes: tuple[float, ...]) -> Any:
    """Steps of position Verlet, one after the other."""
    q, p = np.split(y, 2)
    for h in sizes:
        q = q + h / 2 * problem.dq(p)
        p = p + h * problem.dp(q)
        q = q + h / 2 * problem.dq(p)
    return np.concatenate([q, p])


#: Sizes of the three steps of a method of order 4 (Forest and Ruth; Yoshida): outer, inner.
OUTER, INNER = 1 / (2 - 2 ** (1 / 3)), 1 - 2 / (2 - 2 ** (1 / 3))


@planted("step", "A[2][2] is 1.351207192 and must be -0.175603596", methods=("forest-ruth-4",))
class CompositionOutOfOrder(Base):
    without = ("stages", "solve")

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return composed(problem, y, (OUTER * h, OUTER * h, INNER * h))


# --- arithmetic, starts, stage equations --------------------------------------------------------


@planted("step", "the integrator does something more", methods=("rk4",))
class StepSquared(Base):
    """h squared in one of the stages."""

    without = ("stages", "solve")

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        f, k1 = problem.f, problem.f(t, y)
        k2 = f(t + h / 2, y + h * h / 2 * k1)
        k3 = f(t + h / 2, y + h / 2 * k2)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(t + h, y + h * k3))


@planted("stages", "the integrator does something more", methods=("gauss-2",))
class StagesSolvedLoosely(StoppedBase):
    class Loose(StageSolver):
        def __call__(self, function: Any, x: Any, scale: Any, alike: Any = ()) -> Any:
            while np.abs((new := function(x)) - x).max() > 1e-7:
                x = new
            return new

    solver: ClassVar[type[StageSolver]] = Loose


@planted("start", "0.125 times the right ones (h)", methods=("thesis-3-8",))
class StartTimesStep(Base):
    def start(self, method: str, problem: Any, h: float) -> Any:
        values = super().start(method, problem, h)
        values[1:] *= h
        return values


@planted("finish", methods=("g4123",))
class FinishBackwards(Base):
    without = ("solve",)

    def finish(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return super().finish(method, problem, t, y, -h)


# --- runs ---------------------------------------------------------------------------------------


@planted("trajectory", "StepHalved", methods=("dormand-prince-5",))
class AccurateStepHalved(RunOnly):
    """The error of a step is below what the vectors show as wrong."""

    def rows(self, run: Run) -> np.ndarray:
        return run.rows(h=run.h / 2, steps=2 * run.steps)[-1]


@planted("trajectory", methods=("dormand-prince-5",))
class LastSlopeOfWrongStage(Base):
    """First same as last, only where the input is the last output; stage 6 is kept and not 7."""

    without = ("stages", "solve")

    def __init__(self) -> None:
        super().__init__()
        self.last: Any = (None, None)

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        engine, (end, slope) = self._engine(method, problem), self.last
        slopes = [slope if end is not None and np.array_equal(end, y) else problem.f(t, y)]
        for i in range(1, 7):
            at = y + h * sum(engine.A[i, j] * k for j, k in enumerate(slopes))
            slopes.append(problem.f(t + engine.c[i] * h, at))
        new = y + h * sum(b * k for b, k in zip(engine.B[0], slopes, strict=True))
        self.last = (new.copy(), slopes[5])
        return new


@planted("trajectory", methods=("ab-2",))
class PastNotCarried(RunOnly):
    """The slope of the first step is used in all steps."""

    def rows(self, run: Run) -> np.ndarray:
        values = np.array(run.start)
        rows = [values[0]]
        for n in range(run.steps):
            values = np.array([run.step(n, values)[0], *values[1:]])
            rows.append(values[0])
        return np.array(rows)


@planted("order", "falls like h^2", "these give order 2", methods=("ab-4",))
class HistoryReversed(RunOnly):
    """Starts by Runge-Kutta steps, and keeps their slopes in the wrong order."""

    starts = "own"

    def rows(self, run: Run) -> np.ndarray:
        f, h, t, y = run.problem.f, run.h, run.t(0), np.array(run.problem.y0)
        rows, slopes = [y], [f(t, y)]
        for n in range(run.steps):
            if n < 3:
                y = Foreign().step("", run.problem, t, y, h)
            else:
                y = y + h / 24 * np.array([55, -59, 37, -9]) @ np.array(slopes)
            t += h
            rows.append(y)
            slopes = [*slopes, f(t, y)] if n < 3 else [f(t, y), *slopes[:3]]
        return np.array(rows)


# --- claims of integrators outside the catalogue ------------------------------------------------


@planted("order", "every number is a single precision number", methods=("mine",))
class SinglePrecisionClaimed(Foreign):
    methods: ClassVar = {"mine": {"order": 4}}

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        return super().step(method, problem, t, y, h).astype(np.float32)


@planted("order", "its coefficients have order 3", "nearest is forest-ruth-4", methods=("mine",))
class CompositionClaimed(Foreign):
    methods: ClassVar = {"mine": {"order": 4, "symplectic": True}}
    problems = ("pendulum", "kepler")
    step: Any = CompositionOutOfOrder.step


@planted("order", "at the times at which f is called misses", methods=("mine",))
class TimesClaimed(Foreign):
    """Right for y' = f(y) only."""

    methods: ClassVar = {"mine": {"order": 4}}

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        f, k1 = problem.f, problem.f(t, y)
        k2 = f(t + h / 3, y + h / 2 * k1)
        k3 = f(t + h / 3, y + h / 2 * k2)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + f(t + h, y + h * k3))


@planted("repeatable", "keeps something from call to call", methods=("mine",))
class LastSlopeKeptForeign(Foreign):
    """First same as last, whatever the new input is; of a method the catalogue lacks."""

    methods: ClassVar = {"mine": {"order": 4}}

    def __init__(self) -> None:
        self.last: Any = None

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        known = self.last is not None and len(self.last) == len(y)
        f, k1 = problem.f, np.asarray(self.last if known else problem.f(t, y))
        k2 = f(t + h / 2, y + h / 2 * k1)
        k3 = f(t + h / 2, y + h / 2 * k2)
        self.last = f(t + h, y + h * k3)
        return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + self.last)


@planted("answer", "changes the array", methods=("mine",))
class InputOverwrittenForeign(Foreign):
    methods: ClassVar = {"mine": {"order": 4}}

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        y[...] = super().step(method, problem, t, y, h)
        return y


@planted("symplectic", "M^T J M", methods=("mine",))
class RunNotSymplectic(Foreign):
    """A claim of one that shows its runs only; it was not looked at."""

    methods: ClassVar = {"mine": {"order": 4, "symplectic": True}}

    def __init__(self) -> None:
        self.single, self.step = self.step, None  # type: ignore[method-assign]

    def solve(self, method: str, problem: Any, h: float, steps: int) -> Any:
        y, t = np.array(problem.y0), problem.t_span[0]
        for n in range(steps):
            y = self.single(method, problem, t + n * h, y, h)
        return y


class Grk4t(Rosenbrock):
    """Kaps and Rentrop's method, with its table."""

    methods: ClassVar = {"mine": {"order": 4}}

    def __init__(self) -> None:
        known: Any = load("grk4t")
        self.b = np.array([float(x) for x in known.b])
        self.A, self.G = (floats(rows) for rows in (known.alpha, known.gamma))


@planted("order", "falls like h^1", methods=("mine",))
class JacobianTransposed(Grk4t):
    def jacobian(self, problem: Any, t: float, y: Any) -> Any:
        return problem.jacobian(t, y).T


@planted("order", "falls like h^1.00", methods=("mine",))
class OtherGamma(Grk4t):
    def __init__(self) -> None:
        super().__init__()
        np.fill_diagonal(self.G, 0.25)


@planted("order", "falls like h^0.98", methods=("mine",))
class NoDerivativeByTime(Grk4t):
    def by_time(self, problem: Any, t: float, y: Any) -> Any:
        return 0.0
