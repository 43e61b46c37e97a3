"""``solve(problem, method, h=..., ...)``: start, n steps, finish; every way to end has a name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import GLM, PartitionedGLM
from ..problems.model import Problem
from .inspection import inspected
from .outcome import Outcome, Solution, StartFailed
from .plan import check_arithmetic, notices_of, plan_of, resolved, step_size
from .reference import stepper
from .run import Run
from .start import problem_start, starting_values

__all__ = ["Outcome", "Solution", "solve"]

ENGINES = ("compiled", "reference", "interpreted")


def solve(
    problem: Problem | str, method: GLM | PartitionedGLM | str, *, h: float,
    t_end: float | None = None, steps: int | None = None, every: int = 0,
    times: Sequence[float] | None = None, start: Any = None, engine: str = "compiled",
    arithmetic: str = "strict", form: str = "auto", solver: str = "auto", history: bool = False,
    digits: int | None = None, step_limit: int | None = None,
    cancel: Callable[[], bool] | None = None, progress: Callable[[int, int], None] | None = None,
) -> Solution:  # fmt: skip
    """Integrate a problem with a method at constant step size.

    Args:
        problem: the problem, or its name. Integration starts at ``problem.t_span[0]``.
        method: a GLM or a pair, or its name. One that is wrong on purpose is refused by name; as an
            object, ``glmref.load(name)``, it runs and the solution says so in ``notices``.
        h: step size; negative to go back in time.
        t_end: final time, a whole number of steps away; by default the problem's.
        steps: number of steps, instead of ``t_end``.
        every: keep every k-th step and the last; 0 keeps only the end.
        times: instead of ``every``, the times to keep, on the grid t0 + n h.
        start: see :func:`.start.starting_values`; by default the method's own starting method.
        engine: ``"compiled"``; ``"reference"``, the step as in a paper; ``"interpreted"``, the
            compiled engine's source run by the interpreter.
        arithmetic: ``"strict"``, ``"fused"``, ``"compensated"`` or ``"naive"``, see
            :func:`.kernel.prepare`.
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
    check_arithmetic(arithmetic)
    h = step_size(h)
    plan = plan_of(problem, h, t_end, steps, every, times, step_limit)
    reference = stepper(method, problem, digits=digits)
    t0, y0 = problem_start(problem, reference)
    if digits is None and not np.isfinite(y0).all():
        raise UsageError(f"`y0` must be finite, got {y0}")
    with np.errstate(all="ignore"):
        seen = inspected(reference, t0, y0)
        try:
            given = starting_values(reference, start, t=t0, y0=y0, h=reference.arithmetic.number(h))
        except (ArithmeticError, ValueError) as error:
            raise StartFailed(
                f"the starting values could not be computed ({error}); use a smaller h"
            ) from error
        if digits is None and not np.isfinite(given.values).all():
            raise StartFailed("the starting values are not finite; use a smaller h")
        run = Run(problem, method, h, plan, reference, given, history, cancel, progress)
        run.notices += notices_of(method)
        if engine == "reference":
            run.by_reference()
        else:
            run.by_kernel(arithmetic, form, solver, interpreted=engine == "interpreted")
        solution = run.solution()
        if not seen.seen:
            return solution
        at_end = (solution.t[-1], solution.y[-1]) if len(solution.t) else (t0, y0)
        notices = seen.afterwards(*at_end)
        return replace(solution, notices=(*solution.notices, *notices))
