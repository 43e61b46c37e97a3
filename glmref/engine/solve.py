"""``solve(problem, method, h=..., ...)``: start, n steps, finish; every way to end has a name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from ..system.arguments import flag, one_of, shown, whole
from .clocks import solved_form, without_clocks
from .foreign import refuse_foreign, shown_progress
from .function_checks import inspected
from .gauge import Gauge, gauge_of
from .kept import expressed, stepper_of
from .kernel import SOLVERS
from .outcome import Interrupted, Solution, StartFailed, all_finite
from .parasites import too_large, watched
from .plan import check_arithmetic, check_callable, notices_of, plan_of, resolved, step_size
from .reference import Stepper, stepper
from .run import Run
from .starting_values import problem_start, starting_values
from .sweep import FORMS

ENGINES = ("compiled", "reference", "interpreted")
#: Upper limit of `digits`; beyond it a single step takes minutes.
MOST_DIGITS = 10_000


@lru_cache(maxsize=256)
def _growth(reference: Stepper) -> tuple[str, ...]:
    """Say of a method that is not zero-stable how fast its values grow, whatever the problem."""
    radii = [np.abs(np.linalg.eigvals(c.V)).max() for c in reference.components if len(c.V) > 1]
    if not radii or max(radii) < 1 + _GROWS:
        return ()
    size = f"V has an eigenvalue of size {max(radii):.4g}, by which errors grow in every step"
    return (f"the method is not zero-stable: {size}; glmref.analyze says more",)


def _gauged(
    problem: Problem, method: Method, h: float, steps: int, start: Any, gauge: str,
    digits: int | None,
) -> tuple[Gauge, Problem]:  # fmt: skip
    """Return the shear of ``gauge="auto"``, and the problem in the coordinates to run in."""
    if gauge != "auto":
        raise UsageError(f'`gauge` must be "auto" or None, got {shown(gauge)}')
    if digits is not None:
        raise UsageError("`gauge` goes with double precision; leave out `digits` or `gauge`")

    def pilot(steps: int) -> tuple[np.ndarray, np.ndarray, int]:
        found = solve(problem, method, h=h, steps=steps, every=1, start=start)
        return found.t, found.y, found.evaluations + found.start_evaluations

    return gauge_of(problem, expressed(problem), method, steps, pilot)


def _in_original(found: Solution, sheared: Gauge) -> Solution:
    """Return a run in sheared coordinates in those of the problem, with the shear."""
    found = replace(found, gauge=sheared)
    for key in ("y", "values", "history") if sheared.taken else ():
        rows = getattr(found, key)
        if rows is not None:
            found = replace(found, **{key: sheared.original(rows)})
    return found


#: Beyond 1; multiple eigenvalues of size 1 are computed to a root of round-off.
_GROWS = 1e-3


def solve(
    problem: Problem | str, method: Method | str | Path, *, h: float,
    t_end: float | None = None, steps: int | None = None, every: int = 0,
    times: Sequence[float] | None = None, start: Any = None, renew: int = 0,
    gauge: str | None = None, engine: str = "compiled",
    arithmetic: str = "strict", form: str = "auto", solver: str = "auto", history: bool = False,
    digits: int | None = None, step_limit: int | None = None,
    cancel: Callable[[], bool] | None = None,
    progress: Callable[[int, int], None] | bool | None = None, **elsewhere: Any,
) -> Solution:  # fmt: skip
    """Integrate a problem with a method at constant step size.

    Parameters
    ----------
    problem : Problem or str
        The problem, or its name. Integration starts at ``problem.t_span[0]``.
    method : Method or str or Path
        A GLM or a pair, its name or its file. One that is wrong on purpose is refused by name; as
        an object, ``glmref.load(name)``, it runs, and ``notices`` says so.
    h : float
        Step size; negative to go back in time.
    t_end : float or None
        Final time, a whole number of steps away; by default the problem's.
    steps : int or None
        Number of steps, instead of ``t_end``.
    every : int
        Keep every k-th step and the last; 0 keeps only the end.
    times : Sequence[float] or None
        Instead of ``every``, the times to keep, on the grid t0 + n h.
    start : Any
        See :func:`.starting_values.starting_values`; by default the method's own starting method.
    renew : int
        Renew the carried values from the solution, by the starting method ``start``, after
        every so many steps; 0 for never. A parasitic part that grows starts from nothing each time,
        so that it takes many more steps to become large. What is exact for one step
        (G-symplecticity, symmetry) does not hold across a renewal, and each renewal adds the error
        of the start. ``history`` keeps the values from before it.
    gauge : str or None
        ``"auto"``: take a pilot orbit of at most 1,000 steps, and run in the coordinates p + G q
        where these remove most of the growth of a parasitic part, see :mod:`.gauge`; ``gauge`` of
        the solution says what was found. The rows are those of the problem in every case.
    engine : str
        ``"compiled"``; ``"reference"``, the step as in a paper; ``"interpreted"``, the compiled
        engine's source run by the interpreter. Additive methods take the reference engine always.
    arithmetic : str
        ``"strict"``, ``"fused"``, ``"quick"``, ``"compensated"`` or ``"naive"``, see
        :func:`.kernel.prepare`.
    form, solver : str
        Override what is chosen, see :func:`.kernel.prepare`.
    history : bool
        Keep all values at every time kept, not only the solution.
    digits : int or None
        Decimal digits (reference engine only).
    step_limit : int or None
        Take at most so many steps.
    cancel : Callable[[], bool] or None
        Called about every 50 ms; ``True`` ends the run.
    progress : Callable[[int, int], None] or bool or None
        Called as ``progress(steps done, steps in all)``; ``True`` shows the part that is done on a
        line of the terminal.
    **elsewhere : Any
        Arguments of other solvers, such as ``rtol``: refused with what to give instead.

    Returns
    -------
    Solution
        A :class:`Solution`; its ``outcome`` says how the run ended.

    Raises
    ------
    UsageError
        One sentence on an argument that does not fit.
    Interrupted
        On Ctrl-C: a KeyboardInterrupt whose ``solution`` has what was computed before.
    """
    for name in elsewhere:
        refuse_foreign(name)
    given_problem, chosen = resolved(problem, method)
    problem = solved_form(given_problem, chosen)
    one_of("engine", engine, ENGINES)
    if digits is not None:
        digits = whole("digits", digits, 1, MOST_DIGITS)
        if engine != "reference":
            raise UsageError("`digits` goes with engine='reference' only")
    check_callable("cancel", cancel)
    if progress is True or progress is False:
        progress = shown_progress if progress else None
    check_callable("progress", progress)
    check_arithmetic(arithmetic)
    one_of("form", form, ("auto", *FORMS))
    one_of("solver", solver, SOLVERS)
    history = flag("history", history)
    h, renew = step_size(h), whole("renew", renew)
    plan = plan_of(problem, h, t_end, steps, every, times, step_limit)
    sheared: Gauge | None = None
    if gauge is not None:
        sheared, problem = _gauged(problem, chosen, h, plan.steps, start, gauge, digits)
    if digits is None:
        reference = stepper_of(chosen, problem)
    else:
        reference = stepper(chosen, problem, digits=digits)
    t0, y0 = problem_start(problem, reference)
    if not all_finite(y0):
        raise UsageError(f"`y0` must be finite, got {shown(y0.tolist())}")
    with np.errstate(all="ignore"):
        seen = inspected(reference, t0, y0)
        try:
            given = starting_values(reference, start, t=t0, y0=y0, h=reference.arithmetic.number(h))
        except (ArithmeticError, ValueError) as error:
            raise StartFailed(
                f"the starting values could not be computed ({error}); use a smaller h"
            ) from error
        if not reference.in_range(given.values):
            raise StartFailed("the starting values are not finite; use a smaller h")
        if sheared is not None and sheared.taken and given.kind == "given":
            raise UsageError(
                "`gauge` changes the coordinates, but `start` gives values in those of the "
                "problem; give a starting method, or leave `start` out"
            )
        if renew and given.kind == "given":  # they are those of y0, at every renewal
            raise UsageError(
                "`renew` makes the values again by a starting method, but `start` gives the values "
                "at y0 alone; give a starting method, or leave `start` out"
            )
        run = Run(problem, chosen, h, plan, reference, given, history, cancel, progress)
        run.renewed_by(renew, start)
        run.notices += notices_of(chosen)
        if digits is None:
            run.notices += _growth(reference)
        if digits is None and watched(chosen, problem):  # whatever the renewals
            run.notices += too_large(chosen, expressed(problem), h)
        if chosen.additive and engine != "reference":  # kernels are not generated for sums
            run.notices.append("an additive method runs in the reference engine, step by step")
        if engine == "reference" or chosen.additive:
            run.by_reference()
        else:
            run.by_kernel(arithmetic, form, solver, interpreted=engine == "interpreted")
        solution = run.solution()
        if seen.seen:
            at_end = (solution.t[-1], solution.y[-1]) if len(solution.t) else (t0, y0)
            notices = seen.afterwards(*at_end)
            solution = replace(solution, notices=(*solution.notices, *notices))
        if sheared is not None:
            solution = _in_original(solution, sheared)
        solution = without_clocks(solution, given_problem)
        solution = replace(solution, names=given_problem.labels, origin=(given_problem, chosen))
        if run.interrupted or seen.interrupted:
            raise Interrupted(solution)
        return solution
