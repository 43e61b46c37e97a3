"""One run of one method on one problem: steps by the reference or by a kernel, rows, outcome."""

from __future__ import annotations

import contextlib
import math
import time
from bisect import bisect
from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from ..problems.user_functions import FunctionFailed, UserFunction, raised
from .kept import expressed
from .kernel import Kernel, State, prepare, with_newton
from .maps import Map, map_of
from .memory import NEWTON_BYTES, gibibytes, memory
from .outcome import Outcome, Solution, StartFailed, all_finite, outcome_of
from .parasites import EARLY, WINDOW, Watch, watched, windows
from .plan import Plan
from .reference import Stepper, apply_finish
from .renewals import RenewalFailed, Renewing, renewing
from .solver_choice import newton_bytes, with_band
from .starting_values import Start, starting_values

#: Renewals from which on compiling their start takes less time than it saves.
_MANY = 20
#: Windows that are looked at together at most, and the numbers in them, of large systems.
_TOGETHER, _NUMBERS = 16, 2**23


class _Window(NamedTuple):
    """Solutions of a window, and from where the steps since the one before follow."""

    solutions: np.ndarray  #: (WINDOW, d).
    step: int  #: Of the last one.
    sound: tuple[np.ndarray, np.ndarray] | None  #: See :class:`Run`.
    base: tuple[int, np.ndarray]


class Run:
    """One run: the rows kept so far and how it ends."""

    def __init__(
        self, problem: Problem, method: Method, h: float, plan: Plan,
        reference: Stepper, start: Start, history: bool,
        cancel: Callable[[], bool] | None, progress: Callable[[int, int], None] | None,
    ) -> None:  # fmt: skip
        self.problem, self.method, self.h, self.plan = problem, method, h, plan
        self.reference, self.start, self.history = reference, start.values, history
        self.cancel, self.progress = cancel, progress
        # all values are kept where the caller requests them, or where the solution combines several
        self.wide = history or not reference.first_value
        #: The rows (m, 1 or r, d) and how many there are so far; their step numbers where they do
        #: not follow from ``every``.
        self.rows, self.kept = self._room(), 0
        self.marks: list[int] = []
        #: The solutions in the rows, where they were needed before the end.
        self.solutions: np.ndarray | None = None
        self.values, self.done = start.values, 0
        self.outcome, self.detail = Outcome.COMPLETED, ""
        #: Whether Ctrl-C ended the run, and not `cancel`.
        self.interrupted = False
        self.counts = [0, 0, 0, 0]
        self.seconds = self.build_seconds = 0.0
        self.start_evaluations, self.finish_evaluations = start.evaluations, 0
        self.kernel, self.notices, self.too_large = "", [], False
        self.renew, self.again, self.renewals = 0, None, 0
        #: Kernels of the finishing method, and of the start that renews, where there are any.
        self.finishing: Map | None = None
        self.starting: Map | None = None
        #: What renews the values between compiled steps, where Python need not.
        self.within: Renewing | None = None
        #: Step and values from which the steps so far followed: those of the last renewal.
        self.base = (0, start.values)
        #: What looks for a parasitic part that grows, and the time from which it is large.
        self.watch: Watch | None = None
        if watched(method, problem) and reference.arithmetic.digits is None:
            self.watch = Watch(method, problem)
        self.suspect: float | None = None
        #: Copies of a kernel's state up to which nothing was found; ``None`` for that of ``base``.
        self.sound: tuple[np.ndarray, np.ndarray] | None = None
        #: Rows whose energy has been asked, see :meth:`_from_rows`.
        self.asked = 0
        #: Windows that are not looked at yet.
        self.taken: list[_Window] = []

    def renewed_by(self, renew: int, start: Any) -> None:
        """Renew the values by ``start`` after every ``renew`` steps; 0 for never."""
        if self.reference.shape[0] > 1:  # one value has no parasitic part
            self.renew, self.again = renew, start
        if 0 < self.renew < WINDOW:  # no window lies between two renewals
            self.watch = None

    def _renewal(self, n: int, y: np.ndarray) -> np.ndarray:
        """Return values S(F(y)) after step n: the solution y, finished and started again.

        Raises
        ------
        RenewalFailed
            Where start or finish has no value.
        """
        arithmetic = self.reference.arithmetic
        h = arithmetic.number(self.h)
        t = arithmetic.number(self.problem.t_span[0]) + n * h
        try:
            y = self._finish(t, y)
            made, cost = self._mapped(self.starting, t, y)
            if made is None:
                again = starting_values(self.reference, self.again, t=t, y0=y, h=h)
                made, cost = again.values, again.evaluations
            if not self.reference.in_range(made):
                raise ArithmeticError("the values are not finite")
        except (StartFailed, FunctionFailed, ArithmeticError, ValueError) as error:
            raise RenewalFailed(error) from error
        self.start_evaluations += cost
        self.base, self.renewals = (n, made), self.renewals + 1
        return made

    def _finish(self, t: Any, y: np.ndarray) -> np.ndarray:
        """Return the solution of values that give y at a time, as the finishing method makes it."""
        made, cost = self._mapped(self.finishing, t, y)
        if made is not None:
            y = made[0]
        elif self.method.finishing is not None:
            h = self.reference.arithmetic.number(self.h)
            y, cost = apply_finish(self.method.finishing, self.reference, t, y, h)
        self.finish_evaluations += cost
        return y

    def _mapped(self, kernel: Map | None, t: Any, y: np.ndarray) -> tuple[np.ndarray | None, int]:
        """Return the values (r, d) that a kernel makes of y, ``None`` for none, and their cost."""
        return (None, 0) if kernel is None else kernel.of(float(t), y, self.h)

    def _renewed(self, kernel: Kernel, state: State, y: np.ndarray) -> State:
        """Return the state of a kernel after a renewal from the solution; the counts go on."""
        values = self._renewal(state.step, y)
        t = float(self.problem.t_span[0]) + state.step * self.h
        other = self._state(kernel, t, values, self.starting)
        other.tally[:], other.chunk = state.tally, state.chunk
        self.start_evaluations += bool(kernel.form.memory)
        return other

    def _state(
        self, kernel: Kernel, t: float, values: np.ndarray, again: Map | None = None
    ) -> State:
        """Return the state of a kernel at a time, with what it remembers of a step before.

        After a renewal by a kernel (``again``) as that one evaluates the right-hand side.
        """
        slope = np.full(self.problem.dimension, np.nan)
        # a method may not evaluate there
        with contextlib.suppress(ArithmeticError, ValueError):
            if kernel.form.memory:
                slope_at = self.reference.slope
                if again is not None and again.slope_place is not None:
                    slope_at = partial(again.slope, self.h)
                slope = slope_at(t, self.reference.solution(values))
        return kernel.state(values, slope, self.h)

    def _not_renewed(self, error: RenewalFailed) -> None:
        self.outcome, why = outcome_of(error.why)
        self.detail = f" (in renewing the values{why})"

    def _renews(self, n: int) -> bool:
        here = self.renew > 0 and n % self.renew == 0 and 0 < n < self.plan.steps
        return here and self.within is None

    def _pause(self, done: int) -> bool:
        if self.progress is None and self.cancel is None:  # it is called after every step
            return False
        return self._asked("progress", done, self.plan.steps) or self._asked("cancel")

    def _asked(self, name: str, *arguments: int) -> bool:
        """Call ``progress`` or ``cancel``; whether the run is to end, as where one raises."""
        function = getattr(self, name)
        try:
            return function is not None and bool(function(*arguments)) and name == "cancel"
        except Exception as error:
            self.notices.append(str(raised(name, error)))
            return True

    # --- reference ------------------------------------------------------------------------------

    def by_reference(self) -> None:
        """Take the steps one by one as in a paper."""
        self.kernel = "reference, double precision"
        if self.reference.arithmetic.digits is not None:
            self.kernel = f"reference, {self.reference.arithmetic.digits} digits"
        t0 = self.reference.arithmetic.number(self.problem.t_span[0])
        h, rows = self.reference.arithmetic.number(self.h), self.plan.rows
        wanted = set(rows) if isinstance(rows, tuple) else rows
        if 0 in wanted:
            self._keep(0, self.values)
        begin = time.perf_counter()
        recent = [self.values]
        try:
            while self.done < self.plan.steps:
                taken = self.reference.step(t0 + self.done * h, self.values, h)
                self.counts[0] += taken.evaluations
                self.counts[1] += taken.velocity_evaluations
                self.counts[2] += taken.iterations
                if not self.reference.in_range(taken.values):
                    self.outcome = Outcome.NOT_FINITE
                    break
                if not taken.converged:
                    self.outcome = Outcome.STAGE_SOLVE_FAILED
                    break
                self.values, self.done = taken.values, self.done + 1
                if self.done in wanted:
                    self._keep(self.done, self.values)
                if self._pause(self.done) and self.done < self.plan.steps:
                    self.outcome = Outcome.CANCELLED
                    break
                if self.watch is not None:
                    recent.append(self.values)
                    if len(recent) == WINDOW:
                        solutions = self._solutions(np.array(recent))
                        if self.suspect is None and self.watch.large(solutions, self.done):
                            self._warn(self.done)
                        recent = []
                if self._renews(self.done):
                    y, recent = self.reference.solution(self.values), []
                    self.values = self._renewal(self.done, y)
        except KeyboardInterrupt:
            self.outcome, self.interrupted = Outcome.CANCELLED, True
        except (ArithmeticError, ValueError) as error:
            # a right-hand side of plain Python numbers raises where an array would hold a NaN
            self.outcome, self.detail = Outcome.NOT_FINITE, f" ({error})"
        except FunctionFailed as error:
            self.outcome, self.detail = Outcome.FUNCTION_FAILED, f": {error}"
        except RenewalFailed as error:
            self._not_renewed(error)
        self.seconds = time.perf_counter() - begin

    def _room(self) -> np.ndarray:
        """Allocate all requested rows (committed lazily by the system).

        Zeros: where one half of a pair carries fewer values than the other, nothing is written.
        """
        width = self.start.shape[0] if self.wide else 1
        shape = (max(1, len(self.plan.rows)), width, self.problem.dimension)
        complex_ = np.iscomplexobj(self.start) or np.iscomplexobj(getattr(self.reference, "V", 0.0))
        kind = self.start.dtype if self.start.dtype == object else complex if complex_ else float
        needed = math.prod(shape) * np.dtype(kind).itemsize
        try:
            if needed > memory():
                raise MemoryError
            return np.zeros(shape, dtype=kind)
        except MemoryError:
            raise UsageError(
                f"the {shape[0]} rows asked for need {gibibytes(needed)}, more than this "
                f"machine has; keep fewer with `every`"
            ) from None

    def _keep(self, n: int, values: np.ndarray) -> None:
        self.rows[self.kept] = values if self.wide else values[:1]
        self.kept += 1
        if not self.plan.every:
            self.marks.append(n)

    # --- kernel ---------------------------------------------------------------------------------

    def by_kernel(self, arithmetic: str, form: str, solver: str, *, interpreted: bool) -> None:
        """Take the steps in a compiled loop."""
        t0 = float(self.problem.t_span[0])
        problem = expressed(self.problem)
        kernel = prepare(
            self.method, problem, h=self.h, arithmetic=arithmetic, form=form, solver=solver,
            history=self.wide, interpreted=interpreted,
        )  # fmt: skip
        self._adopt(kernel)
        if kernel.built.engine == "native" or interpreted:
            self.finishing = map_of(self.method.finishing, self.problem, interpreted=interpreted)
            start = self.method.starting if self.again is None else self.again
            if self.renew and self.plan.steps > _MANY * self.renew and isinstance(start, Method):
                self.starting = map_of(start, self.problem, interpreted=interpreted)
        self.start_evaluations += bool(kernel.form.memory)
        state = self._state(kernel, t0, self.start)
        other = renewing(kernel, self.starting, self.reference, self.renew)
        if other is not None:
            kernel, self.within = other, other.built.kernel  # type: ignore[assignment]
        if self.plan.rows[0] == 0:
            self._keep(0, self.start)
        # the kernel writes its rows where they stay
        out = self.rows[self.kept :] if self.plan.every else self.rows[:0]
        marks = {self.plan.steps} if self.plan.every else {n for n in self.plan.rows if n}
        returns = self.renew and self.within is None
        renewals = range(self.renew, self.plan.steps, self.renew) if returns else ()
        begins = set(windows(self.plan.steps, self.renew)) if self.watch is not None else set()
        try:
            for mark in sorted(marks.union(renewals, begins)):
                if 0 < mark <= state.step:  # within a window
                    continue
                self.outcome = self._advance(kernel, state, mark, t0, out)
                if self.outcome is Outcome.STAGE_SOLVE_FAILED and solver == "auto":
                    kernel, state = self._retry(kernel, state, mark, t0, out)
                if self.outcome is not Outcome.COMPLETED:
                    break
                if mark in marks and not self.plan.every:
                    self._keep(mark, kernel.values(state))
                if self._renews(mark):
                    y = self.reference.solution(kernel.values(state))
                    if self._alarming(kernel, state, t0, y[None], range(mark, mark + 1)):
                        self._locate(kernel, state, t0)
                    state, self.sound = self._renewed(kernel, state, y), None
                self._from_rows(kernel, state, t0, out)
                if mark in begins and self.suspect is None:
                    self.outcome = self._window(kernel, state, t0, out)
                    if self.outcome is not Outcome.COMPLETED:
                        break
            if self.outcome not in (Outcome.COMPLETED, Outcome.CANCELLED):
                self._locate(kernel, state, t0)
        except KeyboardInterrupt:
            self.outcome, self.interrupted = Outcome.CANCELLED, True
        except RenewalFailed as error:
            self._not_renewed(error)
        self._look(kernel, state, t0)
        self.done, self.values = state.step, kernel.values(state)
        self.counts = [int(x) for x in state.tally]
        every, written = self.plan.every, int(state.tally[5])
        self.kept += written
        self._back_to_finite_values(kernel, t0)
        if every and self.done == self.plan.steps and self.done % every:
            self._keep(self.done, self.values)
        if self.outcome is Outcome.NOT_FINITE and state.trouble is None:
            state.trouble = self._exception()
        if state.trouble is not None:
            failed = self.outcome is Outcome.FUNCTION_FAILED
            self.detail = f": {state.trouble}" if failed else f" ({state.trouble})"

    # --- parasitic part -------------------------------------------------------------------------

    def _from_base(self, kernel: Kernel, t0: float) -> State:
        """Return the state of a kernel after the last renewal, or at the start."""
        n, values = self.base
        state = self._state(kernel, t0 + n * self.h, values, self.starting if n else None)
        state.tally[4] = n
        return state

    def _solutions(self, values: np.ndarray) -> np.ndarray:
        """Return the solutions (n, d) of values as rows have them, see :meth:`_successive`."""
        if self.reference.first_value:
            return values[:, 0]
        return np.einsum("kd,nkd->nd", self.reference.weights, values)

    def _alarming(
        self, kernel: Kernel, state: State, t0: float, solutions: np.ndarray, steps: range
    ) -> list[int]:
        """Return which of some solutions (n, d) ask for a closer look, see :class:`.Watch`."""
        if self.watch is None or self.suspect is not None:
            return []
        if self.taken and self.taken[0].step <= EARLY:  # the first errors are compared with
            self._look(kernel, state, t0)
        return self.watch.alarming(solutions, steps)

    def _follow(self, kernel: Kernel, state: State, t0: float) -> None:
        """Count the renewals that a kernel did by itself, and look where the energy says so."""
        if self.within is None or not (self.within.plan[3] or self.within.plan[5]):
            return
        steps, solutions, count, spent = self.within.taken()
        self.renewals += count
        self.start_evaluations += spent
        for k in self._alarming(kernel, state, t0, solutions, steps):
            if k:
                n, self.sound = steps[k - 1], None
                values, _ = self._mapped(self.starting, t0 + n * self.h, solutions[k - 1])
                assert values is not None  # as when it was made
                self.base = n, values
            self._locate(kernel, state, t0, steps[k])
        if count:
            self.base, self.sound = (steps[count - 1], self.within.values), None

    def _from_rows(self, kernel: Kernel, state: State, t0: float, out: np.ndarray) -> None:
        """Look where the energy of rows says so, of at most one in the steps of a window."""
        every, written = self.plan.every, int(state.tally[5])
        if not every or self.renew:
            return
        apart = -(-WINDOW // every)
        rows, self.asked = range(self.asked, written, apart), written
        steps = range((rows.start + 1) * every, (written + 1) * every, apart * every)
        solutions = self._solutions(out[rows.start : written : apart])
        if self._alarming(kernel, state, t0, solutions, steps):
            self._locate(kernel, state, t0)

    def _warn(self, step: int) -> None:
        """Say that the window with this last step is large."""
        assert self.watch is not None
        first = max(0, step - WINDOW + 1)
        self.suspect = self._time(first)
        self.notices.append(self.watch.notice(self.suspect, first))

    def _window(self, kernel: Kernel, state: State, t0: float, out: np.ndarray) -> Outcome:
        """Take the steps of a window, keep the rows asked for, and look at the parasitic part."""
        first, every, written = state.step, self.plan.every, int(state.tally[5])
        values, outcome = self._successive(kernel, state, t0)
        state.tally[5] = written
        if every:
            rows = values[every - first % every :: every]
            out[written : written + len(rows)] = rows
            state.tally[5] += len(rows)
        else:
            marks = self.plan.rows
            for n in marks[bisect(marks, first) : bisect(marks, state.step)]:
                self._keep(n, values[n - first])
        if len(values) == WINDOW:
            solutions = self._solutions(values)
            self.taken.append(_Window(solutions, state.step, self.sound, self.base))
            self.sound = state.work.copy(), state.tally.copy()
            if len(self.taken) == self._together:
                self._look(kernel, state, t0)
        return outcome

    @property
    def _together(self) -> int:
        """How many windows are looked at together."""
        numbers = WINDOW * math.prod(self.rows.shape[1:])
        return max(1, min(_TOGETHER, _NUMBERS // numbers))

    def _look(self, kernel: Kernel, state: State, t0: float) -> None:
        """Look at the windows that were taken; one by one they take four times as long."""
        rest, self.taken = self.taken, []
        while rest and self.suspect is None:
            assert self.watch is not None
            k = self.watch.first_large([x.solutions for x in rest], [x.step for x in rest])
            if k is None:
                return
            now = self.sound, self.base
            self.sound, self.base = rest[k].sound, rest[k].base
            self._locate(kernel, state, t0, rest[k].step)
            (self.sound, self.base), rest = now, rest[k + 1 :]

    def _successive(
        self, kernel: Kernel, state: State, t0: float, count: int = WINDOW
    ) -> tuple[np.ndarray, Outcome]:
        """Return the values of a state and of the steps after it, n = ``count`` at most.

        They are (n, r, d), or (n, 1, d) where the solution is the first value.

        Rows are written anew from the first one.
        """
        values = np.zeros((count, *self.rows.shape[1:]))
        values[0], first = kernel.values(state)[: self.rows.shape[1]], state.step
        state.tally[5] = 1
        outcome = self._advance(kernel, state, first + count - 1, t0, values, every=1)
        return values[: state.step - first + 1], outcome

    def _locate(self, kernel: Kernel, state: State, t0: float, last: int | None = None) -> None:
        """Take the steps since the last sound state again; warn where one window is large.

        The warning is of the first one or, before it, of that from which the energy error had
        grown. Up to step ``last``, by default that of the state.

        Each window has half of the one before. Nothing of these steps is counted or kept.
        """
        self._look(kernel, state, t0)
        if self.watch is None or self.suspect is not None:
            return
        ended, trouble = (state.work.copy(), state.tally.copy()), state.trouble
        last = state.step if last is None else last
        seconds, half, self.watch.grown = self.seconds, WINDOW // 2, None
        if self.sound is None:
            begin = self._from_base(kernel, t0)
            self.sound = begin.work, begin.tally
        state.take_back(*self.sound)
        ends = range(state.step + WINDOW - 1, last + 1, half)
        solutions = np.zeros((0, self.problem.dimension))
        for group in (ends[k:][: self._together] for k in range(0, len(ends), self._together)):
            more, _ = self._successive(kernel, state, t0, group[-1] - state.step + 1)
            solutions = np.concatenate([solutions, self._solutions(more)[min(len(solutions), 1) :]])
            whole = [n for n in group if n <= state.step]
            begin = state.step + 1 - len(solutions)
            windows = [solutions[n + 1 - WINDOW - begin :][:WINDOW] for n in whole]
            k = self.watch.first_large(windows, whole)
            if k is not None or len(whole) < len(group):
                self._warn(self.watch.grown or (state.step if k is None else whole[k]))
                break
            solutions = solutions[-half:]
        state.take_back(*ended)
        state.trouble, self.seconds = trouble, seconds

    def _exception(self) -> Exception | None:
        """Return what a user's function raises in the step that has no finite values.

        A compiled function divides by zero without a word; the same step in Python raises.
        """
        if not isinstance(self.problem.f, UserFunction):
            return None
        t = float(self.problem.t_span[0]) + self.done * self.h
        try:
            self.reference.step(t, self.values, self.h)
        except (ArithmeticError, ValueError) as error:
            return error
        return None

    def _back_to_finite_values(self, kernel: Kernel, t0: float) -> None:
        """Give up steps whose values are finite in the basis of the kernel only.

        Near the end of the range the change of basis overflows, and the sum that is the solution;
        so may values at the start, where the given ones are what is left.
        """
        last = self.done - (not self.reference.in_range(self.values))
        written = self.rows[: self.kept]
        wrong = np.zeros(self.kept, dtype=bool)
        if not kernel.form.finite_together:
            wrong |= ~np.isfinite(written).all(axis=(1, 2))
        if not self.reference.first_value:
            self.solutions = self.reference.solution(written)
            wrong |= ~np.isfinite(self.solutions).all(axis=1)
        if wrong.any():
            row = int(wrong.argmax())
            last = min(last, (row * self.plan.every or self.marks[row]) - 1)
        if last == self.done:
            return
        self.solutions = None
        if self.outcome is not Outcome.STAGE_SOLVE_FAILED:
            self.outcome = Outcome.NOT_FINITE
        back, (first, values) = 1, self.base
        while last > first:
            state = self._from_base(kernel, t0)
            kernel.advance(state, last, t0=t0, h=self.h, every=0, out=self.rows[:0])
            self.values = kernel.values(state)
            if state.step == last and self.reference.in_range(self.values):
                break
            last, back = last - back, 2 * back
        if last <= first:
            last, self.values = first, values
        self.done = last
        if self.plan.every:
            self.kept = min(self.kept, last // self.plan.every + 1)
        else:
            self.marks = [n for n in self.marks if n <= last]
            self.kept = len(self.marks)

    def _advance(
        self, kernel: Kernel, state: State, mark: int, t0: float, out: np.ndarray,
        every: int | None = None,
    ) -> Outcome:  # fmt: skip
        every = self.plan.every if every is None else every
        if self.within is not None:
            watching = self.watch is not None and self.suspect is None
            self.within.keep((mark - state.step) // self.renew + 1 if watching else 0)
        try:
            outcome, seconds = kernel.advance(
                state, mark, t0=t0, h=self.h, every=every, out=out, pause=self._pause
            )
        finally:
            self._follow(kernel, state, t0)
        self.seconds += seconds
        paused = self._pause(state.step) and state.step < self.plan.steps
        if paused and outcome is Outcome.COMPLETED:
            return Outcome.CANCELLED
        return outcome

    def _adopt(self, kernel: Kernel) -> None:
        self.build_seconds += kernel.seconds
        self.kernel = kernel.description
        if kernel.built.notice and kernel.built.notice not in self.notices:
            self.notices.append(kernel.built.notice)

    def _retry(
        self, kernel: Kernel, state: State, mark: int, t0: float, out: np.ndarray
    ) -> tuple[Kernel, State]:
        """Go on from the same step with Newton's method after the fixed point failed."""
        if kernel.options.solver == "newton" or len(kernel.form.components) > 1:
            return kernel, state
        needed = newton_bytes(kernel.form, with_band(kernel.shape))
        if needed > NEWTON_BYTES:
            self.too_large = True
            self.notices.append(
                f"the fixed point did not converge at step {state.step + 1}, and Newton's matrices "
                f"would take {gibibytes(needed)}"
            )
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
        # where only the end was requested, the last good step is the end that there is
        short = self.outcome is not Outcome.COMPLETED and not self.plan.every
        if short and (not self.marks or self.marks[-1] != self.done):
            self._keep(self.done, self.values)
        if self.plan.limited and self.outcome is Outcome.COMPLETED:
            self.outcome = Outcome.STEP_LIMIT
        t0 = self.reference.arithmetic.number(self.problem.t_span[0])
        h = self.reference.arithmetic.number(self.h)
        t = self._times(t0, h)
        stacked = self.rows[: self.kept]
        if 2 * len(stacked) < len(self.rows):
            stacked = stacked.copy()  # a run that ended early lets go of the rest
        y = self.solutions
        if y is None or len(y) < self.kept:
            y = self.reference.solution(stacked)
        y = self._finished(t, y.copy() if self.history else y)
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
            renewals=self.renewals, suspect=self.suspect,
        )  # fmt: skip

    def _times(self, t0: Any, h: Any) -> np.ndarray:
        """Return times t0 + n h of the rows kept; whole numbers n are exact in doubles."""
        every = self.plan.every
        if self.rows.dtype == object:
            steps = [min(i * every, self.done) for i in range(self.kept)] if every else self.marks
            return np.array([t0 + n * h for n in steps])
        if not every:
            return t0 + np.array(self.marks, dtype=float) * h
        t = np.arange(self.kept, dtype=float)
        t *= every
        if self.kept:
            t[-1] = min(t[-1], self.done)
        t *= h
        t += t0
        return t

    def _finished(self, t: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Apply the finishing method to every row; where it fails, the rows before are kept."""
        if self.method.finishing is None:
            return y
        first, every = 0, self.plan.every
        if self.finishing is not None and every:  # all at once; where one has no value, one by one
            rows = np.array(y)[:, None]
            t0 = float(self.problem.t_span[0])
            first, cost = self.finishing(rows, t0, self.h, every=every, last=self.done)
            self.finish_evaluations, y = self.finish_evaluations + cost, rows[:, 0]
        for row in range(first, len(y)):
            try:
                y[row] = self._finish(t[row], y[row])
            except (StartFailed, FunctionFailed, ArithmeticError, ValueError) as error:
                return self._unfinished(*outcome_of(error), t, y, row)
            except KeyboardInterrupt:
                self.interrupted = True
                return self._unfinished(Outcome.CANCELLED, "", t, y, row)
            if not all_finite(y[row]):
                return self._unfinished(Outcome.NOT_FINITE, "", t, y, row)
        return y

    def _unfinished(
        self, how: Outcome, why: str, t: np.ndarray, y: np.ndarray, row: int
    ) -> np.ndarray:
        if self.outcome is Outcome.COMPLETED:
            self.outcome = how
        self.detail = f" (of the finishing method at t = {float(t[row]):.6g}{why})"
        return y[:row]

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
            Outcome.FUNCTION_FAILED: f"the right-hand side failed in {where}{self.detail}",
        }[self.outcome]

    @property
    def _newton(self) -> bool:
        return self.too_large or "newton" in self.kernel or "reference" in self.kernel

    def _time(self, n: int) -> float:
        return float(self.problem.t_span[0]) + n * self.h
