"""Cases of runs: trajectories, and errors against the exact solution at several step sizes."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cache
from typing import Any

import mpmath
import numpy as np

from ..engine.reference import Stepper
from ..errors import DataError
from ..exact import ball
from ..method import Method
from ..problems import problem
from ..problems.formula import to_number
from .bench import DIGITS, FAULT_DIGITS, SAFETY, SHOWN, Bench
from .bounded import Bounded
from .faults import wrong_runs
from .numbers import decimal_text, decimals, exact_decimal, fraction_of, upper_text
from .proof import add_wrong, distance
from .scheme import ball_field, enclosed_step, error_bound, error_field
from .taylor import taylor_states
from .vector_problems import TestProblem

_RUN_STEPS, _ORDER_STEPS, _ORDER_TIME = 8, (4, 8, 16, 32), 2
#: A bound of rounding errors beyond this shows nothing in double precision, where it is 1e-8: that
#: of a run of a method with entries of a hundred grows a thousandfold in each step.
_USEFUL = 10**8
#: Change of a value in the differences that give the derivative of a step to 40 digits.
_SMALL = Fraction(1, 10**20)


class RunCases:
    """Makes the cases of runs of the method on a bench."""

    def __init__(self, bench: Bench) -> None:
        self.bench, self.method, self.name = bench, bench.method, bench.name

    def trajectory(self, task: TestProblem) -> dict[str, Any]:
        """Take eight steps from y0, or from starting values that are given."""
        h = self.bench.size(task)
        engine, values, given = self.bench.begin(task, h, DIGITS)
        for sharp in (False, True):
            run = _Run(self.bench, task, engine, values, given, h, sharp=sharp)
            for _ in range(_RUN_STEPS):
                run.advance()
            if run.error < _USEFUL:
                break
        case = {
            "id": f"trajectory/{self.name}/{task.name}",
            "kind": "trajectory",
            "problem": task.name,
            "t": task.t0,
            "h": exact_decimal(h),
            "steps": _RUN_STEPS,
            "y0": list(task.y0),
            **({} if given is None else {"input": given}),
            "solution": run.shown,
            "output": decimals(run.values, SHOWN),
            "bound": upper_text(run.distance, 1),
            "rounding": upper_text(SAFETY * run.error),
            "flags": [],
        }
        coarse, values, _ = self.bench.begin(task, h, FAULT_DIGITS)
        ((t0, size),) = self.bench.numbers(coarse, [[Fraction(task.t0), h]])
        if task.name != "kepler":
            found = wrong_runs(coarse, self.method, task.problem, t0, values, size, _RUN_STEPS)
            if task.name == "forced":
                found = (x for x in found if x.flag == "TimeNotAdvanced")
            add_wrong(case, found, right=run.shown[-1:])
        return case

    def order(self, task: TestProblem) -> dict[str, Any]:
        """Return errors at t = 2 for steps 1/2 to 1/16, against the exact solution."""
        exact_end = _pendulum_end(task)
        rows = []
        for steps in _ORDER_STEPS:
            h = Fraction(_ORDER_TIME, steps)
            engine, values, given = self.bench.begin(task, h, FAULT_DIGITS)
            ((size, end),) = self.bench.numbers(engine, [[h, Fraction(_ORDER_TIME)]])
            for n in range(steps):
                values = engine.step(n * size, values, size).values
            y = self.bench.solution(engine, values, end, size)
            right = engine.arithmetic.context.mpf
            error = max(abs(a - right(b)) for a, b in zip(y, exact_end, strict=True))
            started = {} if given is None else {"input": given}
            rows.append({"steps": steps, **started, "error": decimal_text(error, 6)})
        order = self.bench.shown_order()
        return {
            "id": f"order{order}/{self.name}/{task.name}",
            "kind": "order",
            "problem": task.name,
            "t": task.t0,
            "t_end": str(_ORDER_TIME),
            "y0": list(task.y0),
            "order": order,
            "exact": list(exact_end),
            "rows": rows,
            "bound": "1e-40",
            "flags": [],
        }


class _Run:
    """A run in mpmath, followed by balls and by error bounds.

    An error bound adds absolute values, also of terms that cancel. With ``sharp`` this is done
    within each step only; the error before a step is carried over it by the step's derivative.
    """

    def __init__(
        self, bench: Bench, task: TestProblem, engine: Stepper, values: np.ndarray,
        given: list[list[str]] | None, h: Fraction, *, sharp: bool = False,
    ) -> None:  # fmt: skip
        self.bench, self.task, self.engine, self.values, self.h = bench, task, engine, values, h
        self.sharp = sharp
        self.context = engine.arithmetic.context
        self.size = to_number(h, self.context)
        self.n = 0
        self.balls_field = ball_field(task.expressions)
        self.errors_field = error_field(task.expressions, self.context)
        rows = [list(task.y0)] if given is None else given
        self.balls: list[list[Any]] = [[ball(Fraction(x)) for x in row] for row in rows]
        self.errors: list[list[Any]] = self._numbers(rows)
        starting = getattr(bench.method, "starting", None)
        if given is None and starting is not None:
            y0 = np.array(engine.problem.y0)
            stages = bench.inner_stages(starting.A, task, self.time, y0, self.size)
            self.balls, self.errors = self._both(starting, self.balls, self.errors, stages)
        self.shown: list[list[str]] = []
        self.distance, self.error = Fraction(0), self.context.mpf(0)
        self._show()

    def _numbers(self, rows: Sequence[Sequence[str]]) -> list[list[Any]]:
        return [[self.context.mpf(x) for x in row] for row in rows]

    def _both(self, method: Method, balls: Any, errors: Any, stages: Any) -> tuple[Any, Any]:
        t = Fraction(self.task.t0) + self.n * self.h
        time = self.time
        guesses = [[ball(fraction_of(x)) for x in row] for row in stages]
        _, new = enclosed_step(method, self.balls_field, t, balls, self.h, guesses)
        _, bounds = error_bound(
            method, self.errors_field, time, errors, self.size, stages, self.context
        )
        return new, bounds

    @property
    def time(self) -> Any:
        """Time reached."""
        return self.context.mpf(self.task.t0) + self.n * self.size

    def advance(self) -> None:
        """Take one step and show the solution after it."""
        taken = self.engine.step(self.time, self.values, self.size)
        stages = [row for part in taken.stages for row in part] if self.bench.pair else taken.stages
        before = [[Bounded.of(x) for x in row] for row in self.errors]
        exact = [[Bounded(x.value, 0) for x in row] for row in before] if self.sharp else before
        self.balls, self.errors = self._both(self.bench.method, self.balls, exact, stages)
        if self.sharp:
            self._carry([x.error for row in before for x in row])
        self.values, self.n = taken.values, self.n + 1
        self._show()

    def _carry(self, errors: Sequence[Any]) -> None:
        """Add what errors before a step make of its result, ``|M| e`` with M its derivative."""
        width = to_number(_SMALL, self.context)
        for k, error in enumerate(errors):
            shift = np.zeros_like(self.values).ravel()
            shift[k] = width
            ends = [
                self.engine.step(self.time, self.values + x, self.size).values
                for x in (shift.reshape(self.values.shape), -shift.reshape(self.values.shape))
            ]
            slopes = abs(ends[0] - ends[1]) / (2 * width)
            for row, column in zip(self.errors, slopes, strict=True):
                for x, slope in zip(row, column, strict=True):
                    x.error = x.error + slope * error

    def _show(self) -> None:
        """Print the solution (finished), and measure how far it is from the enclosure."""
        first, errors = self.bench.read_off(self.balls), self.bench.read_off(self.errors)
        finishing = getattr(self.bench.method, "finishing", None)
        if finishing is not None:
            stages = self.bench.inner_stages(
                finishing.A, self.task, self.time, self.engine.solution(self.values), self.size
            )
            first, errors = self._both(finishing, first, errors, stages)
        solution = self.bench.solution(self.engine, self.values, self.time, self.size)
        self.shown.append(decimals(solution, SHOWN))
        rows = [(first[0], self.shown[-1])]
        rows += list(zip(self.balls, decimals(self.values, SHOWN), strict=True))
        for enclosed, printed in rows:
            self.distance = max(self.distance, distance(enclosed, printed))
        parts = [x for row in (*errors, *self.errors) for x in row]
        self.error = max([self.error, *(x.error for x in parts if hasattr(x, "error"))])


@cache
def _pendulum_end(task: TestProblem) -> list[str]:
    """Return the solution of the pendulum at the end of the order runs.

    By Jacobi's elliptic functions, confirmed by a Taylor series of another module.
    """
    known = problem("pendulum", q0=task.y0[0], p0=task.y0[1])
    context = mpmath.MPContext()
    context.dps = DIGITS
    end = known.on(context).solution(context.mpf(_ORDER_TIME))
    (other,) = taylor_states(task.problem, [_ORDER_TIME], digits=SHOWN + 10)
    shown, again = decimals(end, SHOWN), decimals(other, SHOWN)
    if any(
        abs(Fraction(a) - Fraction(b)) > Fraction(1, 10**SHOWN)
        for a, b in zip(shown, again, strict=True)
    ):
        raise DataError(f"two ways to the end of the pendulum differ: {shown} and {again}")
    return shown
