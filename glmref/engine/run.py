"""One run of one method on one problem: steps by the reference or by a kernel, rows, outcome."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from ..method import GLM, PartitionedGLM
from ..problems.model import Problem
from .outcome import Outcome, Solution, StartFailed
from .plan import Plan
from .reference import Stepper, apply_finish
from .start import Start

if TYPE_CHECKING:
    from .kernel import Kernel, State

__all__ = ["Run"]


class Run:
    """One run: the rows kept so far and how it ends."""

    def __init__(
        self, problem: Problem, method: GLM | PartitionedGLM, h: float, plan: Plan,
        reference: Stepper, start: Start, history: bool,
        cancel: Callable[[], bool] | None, progress: Callable[[int, int], None] | None,
    ) -> None:  # fmt: skip
        self.problem, self.method, self.h, self.plan = problem, method, h, plan
        self.reference, self.start, self.history = reference, start.values, history
        self.cancel, self.progress = cancel, progress
        self.kept: list[tuple[int, np.ndarray]] = []
        self.values, self.done = start.values, 0
        self.outcome, self.detail = Outcome.COMPLETED, ""
        self.counts = [0, 0, 0, 0]
        self.seconds = self.build_seconds = 0.0
        self.start_evaluations, self.finish_evaluations = start.evaluations, 0
        self.kernel, self.notices = "", []

    def _pause(self, done: int) -> bool:
        if self.progress is not None:
            self.progress(done, self.plan.steps)
        return self.cancel is not None and bool(self.cancel())

    # --- reference ------------------------------------------------------------------------------

    def by_reference(self) -> None:
        """Take the steps one by one as in a paper."""
        self.kernel = "reference, double precision"
        if self.reference.arithmetic.digits is not None:
            self.kernel = f"reference, {self.reference.arithmetic.digits} digits"
        t0 = self.reference.arithmetic.number(self.problem.t_span[0])
        h, wanted = self.reference.arithmetic.number(self.h), set(self.plan.rows)
        if 0 in wanted:
            self._keep(0, self.values)
        begin = time.perf_counter()
        try:
            while self.done < self.plan.steps:
                taken = self.reference.step(t0 + self.done * h, self.values, h)
                self.counts[0] += taken.evaluations
                self.counts[1] += taken.velocity_evaluations
                self.counts[2] += taken.iterations
                if not self._numbers(taken.values):
                    self.outcome = Outcome.NOT_FINITE
                    break
                if not taken.converged:
                    self.outcome = Outcome.STAGE_SOLVE_FAILED
                    break
                self.values, self.done = taken.values, self.done + 1
                if self.done in wanted:
                    self._keep(self.done, self.values)
                if self._pause(self.done):
                    self.outcome = Outcome.CANCELLED
                    break
        except KeyboardInterrupt:
            self.outcome = Outcome.CANCELLED
        except (ArithmeticError, ValueError) as error:
            # a right-hand side of plain Python numbers raises where an array would hold a NaN
            self.outcome, self.detail = Outcome.NOT_FINITE, f" ({error})"
        self.seconds = time.perf_counter() - begin

    def _numbers(self, values: np.ndarray) -> bool:
        if values.dtype == object:
            return all(x == x and abs(x) != math.inf for x in values.ravel())
        return bool(np.isfinite(values).all())

    def _keep(self, n: int, values: np.ndarray) -> None:
        self.kept.append((n, np.array(values if self.history else values[:1])))

    # --- kernel ---------------------------------------------------------------------------------

    def by_kernel(self, arithmetic: str, form: str, solver: str, *, interpreted: bool) -> None:
        """Take the steps in a compiled loop."""
        from .kernel import prepare

        t0 = float(self.problem.t_span[0])
        slope = self.reference.slope(t0, self.start[0])
        kernel = prepare(
            self.method, self.problem, h=self.h, arithmetic=arithmetic, form=form, solver=solver,
            history=self.history, interpreted=interpreted,
        )  # fmt: skip
        self._adopt(kernel)
        if kernel.form.memory:
            self.start_evaluations += 1
        state = kernel.state(self.start, slope, self.h)
        if self.plan.rows and self.plan.rows[0] == 0:
            self._keep(0, self.start)
        width = self.start.shape[0] if self.history else 1
        regular = len(range(0, self.plan.steps + 1, self.plan.every)) - 1 if self.plan.every else 0
        out = np.full((max(regular, 1), width, self.problem.dimension), np.nan)
        marks = [self.plan.steps] if self.plan.every else [n for n in self.plan.rows if n]
        try:
            for mark in marks:
                self.outcome = self._advance(kernel, state, mark, t0, out)
                if self.outcome is Outcome.STAGE_SOLVE_FAILED and solver == "auto":
                    kernel, state = self._retry(kernel, state, mark, t0, out)
                if self.outcome is not Outcome.COMPLETED:
                    break
                if not self.plan.every:
                    self._keep(mark, kernel.values(state))
        except KeyboardInterrupt:
            self.outcome = Outcome.CANCELLED
        self.done, self.values = state.step, kernel.values(state)
        self.counts = [int(x) for x in state.tally[:4]]
        for row in range(int(state.tally[5])):
            self.kept.append(((row + 1) * self.plan.every, out[row]))
        if self.plan.every and self.done == self.plan.steps and self.done % self.plan.every:
            self._keep(self.done, self.values)

    def _advance(
        self, kernel: Kernel, state: State, mark: int, t0: float, out: np.ndarray
    ) -> Outcome:
        outcome, seconds = kernel.advance(
            state, mark, t0=t0, h=self.h, every=self.plan.every, out=out, pause=self._pause
        )
        self.seconds += seconds
        if self.progress is not None:
            self.progress(state.step, self.plan.steps)
        return outcome

    def _adopt(self, kernel: Kernel) -> None:
        self.build_seconds += kernel.seconds
        self.kernel = kernel.description
        if kernel.built.notice and kernel.built.notice not in self.notices:
            self.notices.append(kernel.built.notice)

    def _retry(
        self, kernel: Kernel, state: State, mark: int, t0: float, out: np.ndarray
    ) -> tuple[Kernel, State]:
        """The fixed point failed: go on from the same step with Newton."""
        from .kernel import with_newton

        if kernel.options.solver == "newton" or isinstance(self.method, PartitionedGLM):
            return kernel, state
        other = with_newton(kernel)
        self._adopt(other)
        self.notices.append(
            f"the fixed point did not converge at step {state.step + 1}; Newton from there on"
        )
        state = other.resumed(state)
        self.outcome = self._advance(other, state, mark, t0, out)
        return other, state

    # --- result ---------------------------------------------------------------------------------

    def solution(self) -> Solution:
        """Finish the rows and put everything together."""
        # where only the end was asked for, the last good step is the end that there is
        short = self.outcome is not Outcome.COMPLETED and not self.plan.every
        if short and (not self.kept or self.kept[-1][0] != self.done):
            self._keep(self.done, self.values)
        if self.plan.limited and self.outcome is Outcome.COMPLETED:
            self.outcome = Outcome.STEP_LIMIT
        t0 = self.reference.arithmetic.number(self.problem.t_span[0])
        h = self.reference.arithmetic.number(self.h)
        t = np.array([t0 + n * h for n, _ in self.kept])
        rows = [np.array(values) for _, values in self.kept]
        stacked = np.stack(rows) if rows else np.zeros((0, 1, self.problem.dimension))
        y = self._finished(t, stacked[:, 0].copy())
        t, stacked = t[: len(y)], stacked[: len(y)]
        return Solution(
            t=t, y=y, outcome=self.outcome,
            message=self._message(), steps=self.done, values=self.values,
            history=stacked if self.history else None,
            evaluations=self.counts[0], velocity_evaluations=self.counts[1],
            iterations=self.counts[2], factorisations=self.counts[3], seconds=self.seconds,
            start_evaluations=self.start_evaluations, finish_evaluations=self.finish_evaluations,
            build_seconds=self.build_seconds, method=self.method.name, problem=self.problem.name,
            h=self.h, kernel=self.kernel, notices=tuple(self.notices),
        )  # fmt: skip

    def _finished(self, t: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Apply the finishing method to every row; where it fails, the rows before are kept."""
        finishing = getattr(self.method, "finishing", None)
        if finishing is None:
            return y
        h = self.reference.arithmetic.number(self.h)
        for row in range(len(y)):
            try:
                y[row], cost = apply_finish(finishing, self.reference, t[row], y[row], h)
            except StartFailed:
                if self.outcome is Outcome.COMPLETED:
                    self.outcome = Outcome.STAGE_SOLVE_FAILED
                self.detail = f" (of the finishing method at t = {float(t[row]):.6g})"
                return y[:row]
            self.finish_evaluations += cost
        return y

    def _message(self) -> str:
        where = f"step {self.done + 1} of {self.plan.steps}, t = {self._time(self.done):.6g}"
        return {
            Outcome.COMPLETED: f"{self.done} steps completed",
            Outcome.STAGE_SOLVE_FAILED: f"the stage equations could not be solved in {where}"
            f"{self.detail}; use a smaller h" + ("" if self._newton else " or solver='newton'"),
            Outcome.NOT_FINITE: f"the right-hand side or the values are not finite in {where}"
            f"{self.detail}; the problem or the method is unstable there, or h is too large",
            Outcome.STEP_LIMIT: f"stopped after step_limit = {self.done} steps, at "
            f"t = {self._time(self.done):.6g}",
            Outcome.CANCELLED: f"cancelled before {where}",
        }[self.outcome]

    @property
    def _newton(self) -> bool:
        return "newton" in self.kernel or "reference" in self.kernel

    def _time(self, n: int) -> float:
        return float(self.problem.t_span[0]) + n * self.h
