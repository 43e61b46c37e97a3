"""``solve(problem, method, h=..., ...)``: start, n steps, finish; every way to end has a name."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from ..claims import UsageError
from ..method import GLM, PartitionedGLM
from ..problems.model import Problem
from .outcome import Outcome, Solution

if TYPE_CHECKING:
    from .kernel import Kernel, State
    from .reference import Stepper

__all__ = ["Outcome", "Solution", "solve"]

ENGINES = ("compiled", "reference", "interpreted")
_WHOLE = 1e-9  # how far (t_end - t0) / h may be from an integer, per step


@dataclass(frozen=True)
class Plan:
    """Which steps are taken and which are kept.

    Attributes
    ----------
        steps: how many steps.
        every: record every so many, 0 for none.
        rows: step numbers to keep, in order.
    """

    steps: int
    every: int
    rows: tuple[int, ...] | range
    limited: bool


def solve(
    problem: Problem | str,
    method: GLM | PartitionedGLM | str,
    *,
    h: float,
    t_end: float | None = None,
    steps: int | None = None,
    every: int = 0,
    times: Sequence[float] | None = None,
    start: Any = None,
    engine: str = "compiled",
    arithmetic: str = "strict",
    form: str = "auto",
    solver: str = "auto",
    history: bool = False,
    digits: int | None = None,
    step_limit: int | None = None,
    cancel: Callable[[], bool] | None = None,
    progress: Callable[[int, int], None] | None = None,
) -> Solution:
    """Integrate a problem with a method at constant step size.

    Args:
        problem: the problem, or its name. Integration starts at ``problem.t_span[0]``.
        method: a GLM or a pair, or its name.
        h: step size; negative to go back in time.
        t_end: final time, a whole number of steps away; by default the problem's.
        steps: number of steps, instead of ``t_end``.
        every: keep every k-th step and the last; 0 keeps only the end.
        times: instead of ``every``, the times to keep, on the grid t0 + n h.
        start: see :func:`.start.starting_values`; by default the method's own starting method.
        engine: ``"compiled"``; ``"reference"``, the step as in a paper; ``"interpreted"``, the
            compiled engine's source run by the interpreter.
        arithmetic: ``"strict"``, ``"compensated"`` or ``"naive"``, see :func:`.kernel.prepare`.
        form, solver: override what is chosen, see :func:`.kernel.prepare`.
        history: keep all values at every time kept, not only the solution.
        digits: decimal digits (reference engine only).
        step_limit: take at most so many steps.
        cancel: called about every 50 ms; ``True`` ends the run.
        progress: called as ``progress(steps done, steps in all)``.

    Returns
    -------
        A :class:`Solution`; its ``outcome`` says how the run ended. Ctrl-C ends a run as cancelled.

    Raises
    ------
        UsageError: one sentence on an argument that does not fit.
    """
    problem, method = resolved(problem, method)
    if engine not in ENGINES:
        raise UsageError(f"`engine` must be one of {', '.join(ENGINES)}, got {engine!r}")
    if digits is not None and (engine != "reference" or digits < 1):
        raise UsageError("`digits` must be positive and goes with engine='reference' only")
    h = step_size(h)
    plan = plan_of(problem, h, t_end, steps, every, times, step_limit)
    from .reference import stepper
    from .start import problem_start, starting_values

    reference = stepper(method, problem, digits=digits)
    t0, y0 = problem_start(problem, reference)
    if digits is None and not np.isfinite(y0).all():
        raise UsageError(f"`y0` must be finite, got {y0}")
    with np.errstate(all="ignore"):
        given = starting_values(reference, start, t=t0, y0=y0, h=reference.arithmetic.number(h))
        run = _Run(problem, method, h, plan, reference, given.values, history, cancel, progress)
        run.start_evaluations = given.evaluations
        if engine == "reference":
            run.by_reference()
        else:
            run.by_kernel(arithmetic, form, solver, interpreted=engine == "interpreted")
        return run.solution()


def resolved(problem: Any, method: Any) -> tuple[Problem, GLM | PartitionedGLM]:
    if isinstance(problem, str):
        from ..problems import problem as by_name

        problem = by_name(problem)
    if isinstance(method, str):
        from ..catalogue import load

        method = load(method)
    if not isinstance(problem, Problem):
        raise UsageError(f"`problem` must be a Problem or its name, got {type(problem).__name__}")
    if not isinstance(method, GLM | PartitionedGLM):
        raise UsageError(f"`method` must be a method or its name, got {type(method).__name__}")
    if problem.context is not None:
        raise UsageError("`problem` must be the one in double precision; give `digits` instead")
    return problem, method


def step_size(h: Any) -> float:
    try:
        value = float(h)
    except (TypeError, ValueError):
        raise UsageError(f"`h` must be a number, got {h!r}") from None
    if not math.isfinite(value) or value == 0.0:
        raise UsageError(f"`h` must be finite and not zero, got {h!r}")
    return value


def _whole(x: float, what: str, h: float) -> int:
    n = round(x) if math.isfinite(x) else -1
    if n < 0 or abs(x - n) > _WHOLE * max(1, n):
        hint = f"; with h = {h * x / max(1, round(x))!r} it would be" if x > 0.5 else ""
        raise UsageError(f"{what} is not a whole number of steps of h = {h!r}{hint}")
    return n


def plan_of(
    problem: Problem, h: float, t_end: Any, steps: Any, every: Any, times: Any, limit: Any
) -> Plan:
    """Check what is asked for and turn it into step numbers."""
    t0 = float(problem.t_span[0])
    for name, value, least in (("steps", steps, 0), ("every", every, 0), ("step_limit", limit, 0)):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if value is not None and not (whole and value >= least):
            raise UsageError(f"`{name}` must be a whole number >= {least}, got {value!r}")
    if times is not None:
        if every or steps is not None or t_end is not None:
            raise UsageError("give `times`, or `every` with `t_end` or `steps`, not both")
        marks = [_whole((float(t) - t0) / h, f"t = {float(t)!r}", h) for t in times]
        if not marks or any(b <= a for a, b in pairwise(marks)):
            raise UsageError("`times` must be a nonempty list in the direction of h")
        total, rows = marks[-1], tuple(marks)
    else:
        if steps is not None and t_end is not None:
            raise UsageError("give `steps` or `t_end`, not both")
        if steps is None:
            end = float(problem.t_span[1] if t_end is None else t_end)
            if t_end is None and h < 0:
                raise UsageError("going back in time needs `t_end` or `steps`")
            total = _whole((end - t0) / h, f"t_end - t0 = {end - t0!r}", h)
        else:
            total = int(steps)
        rows = (total,)
    limited = limit is not None and limit < total
    if limit is not None and limited:
        total = int(limit)
    if every:
        rows = range(0, total + 1, every)
        if total % every:
            rows = (*rows, total)
    elif limited:
        rows = (*(n for n in rows if n < total), total)
    return Plan(total, int(every), rows, limited)


class _Run:
    """One run: the rows kept so far and how it ends."""

    def __init__(
        self, problem: Problem, method: GLM | PartitionedGLM, h: float, plan: Plan,
        reference: Stepper, values: np.ndarray, history: bool,
        cancel: Callable[[], bool] | None, progress: Callable[[int, int], None] | None,
    ) -> None:  # fmt: skip
        self.problem, self.method, self.h, self.plan = problem, method, h, plan
        self.reference, self.start, self.history = reference, values, history
        self.cancel, self.progress = cancel, progress
        self.kept: list[tuple[int, np.ndarray]] = []
        self.values, self.done = values, 0
        self.outcome, self.detail = Outcome.COMPLETED, ""
        self.counts = [0, 0, 0, 0]
        self.seconds = self.build_seconds = 0.0
        self.start_evaluations = self.finish_evaluations = 0
        self.kernel, self.notices = "", []

    def _pause(self, done: int) -> bool:
        if self.progress is not None:
            self.progress(done, self.plan.steps)
        return self.cancel is not None and bool(self.cancel())

    # --- reference ------------------------------------------------------------------------------

    def by_reference(self) -> None:
        """Take the steps one by one as in a paper."""
        import time

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

        kernel = prepare(
            self.method, self.problem, h=self.h, arithmetic=arithmetic, form=form, solver=solver,
            history=self.history, interpreted=interpreted,
        )  # fmt: skip
        self._adopt(kernel)
        t0 = float(self.problem.t_span[0])
        # a single value is the solution; the force that a pair remembers must be the one there
        first = self.start[0] if len(self.start) == 1 else self.problem.y0
        slope = np.asarray(self.problem.f(t0, first), dtype=float)
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
        shape = (0, 1, self.problem.dimension)
        stacked = np.stack(rows) if rows else np.zeros(shape)
        return Solution(
            t=t, y=self._finished(t, stacked[:, 0].copy()), outcome=self.outcome,
            message=self._message(), steps=self.done, values=self.values,
            history=stacked if self.history else None,
            evaluations=self.counts[0], velocity_evaluations=self.counts[1],
            iterations=self.counts[2], factorisations=self.counts[3], seconds=self.seconds,
            start_evaluations=self.start_evaluations, finish_evaluations=self.finish_evaluations,
            build_seconds=self.build_seconds, method=self.method.name, problem=self.problem.name,
            h=self.h, kernel=self.kernel, notices=tuple(self.notices),
        )  # fmt: skip

    def _finished(self, t: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Apply the finishing method to every row."""
        finishing = getattr(self.method, "finishing", None)
        if finishing is None:
            return y
        from .reference import apply_finish

        h = self.reference.arithmetic.number(self.h)
        for row in range(len(y)):
            y[row], cost = apply_finish(finishing, self.reference, t[row], y[row], h)
            self.finish_evaluations += cost
        return y

    def _message(self) -> str:
        where = f"step {self.done + 1} of {self.plan.steps}, t = {self._time(self.done):.6g}"
        return {
            Outcome.COMPLETED: f"{self.done} steps completed",
            Outcome.STAGE_SOLVE_FAILED: f"the stage equations could not be solved in {where}; use "
            f"a smaller h" + ("" if self._newton else " or solver='newton'"),
            Outcome.NOT_FINITE: f"the right-hand side or the values are not finite in {where}; the "
            f"problem or the method is unstable there, or h is too large",
            Outcome.STEP_LIMIT: f"stopped after step_limit = {self.done} steps, at "
            f"t = {self._time(self.done):.6g}",
            Outcome.CANCELLED: f"cancelled before {where}",
        }[self.outcome]

    @property
    def _newton(self) -> bool:
        return "newton" in self.kernel or "reference" in self.kernel

    def _time(self, n: int) -> float:
        return float(self.problem.t_span[0]) + n * self.h
