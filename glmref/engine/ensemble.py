"""Many initial values at once: lanes of one block side by side, blocks spread over threads.

A block of lanes is stepped by one kernel (:mod:`.lanes`) whose inner loop the compiler turns into
SIMD instructions; every trajectory has the bits :func:`.solve.solve` gives it, except where
``arithmetic="fused"`` lets the compiler choose which operations it joins. Kernels release the
interpreter's lock, so blocks run in threads. Python callables, implicit pairs, and large systems
with Newton's method or beyond the cache are stepped one by one, still in threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from ..system.arguments import one_of, shown, whole
from .arithmetic import in_order
from .clocks import solved_form, with_clocks, without_clocks
from .expressions import Unsupported
from .function_checks import inspected
from .kept import stepper_of
from .kernel import SOLVERS
from .outcome import StartFailed
from .plan import check_arithmetic, check_callable, notices_of, plan_of, resolved, step_size
from .reference import Stepper
from .runners import WIDTHS, EnsembleSolution, Lanes, Runner, Singles, rows_at, slopes_at
from .starting_values import array_of, default_passes, enhanced_start, zero_start


def solve_ensemble(
    problem: Problem | str, method: Any, initial: Any, *, h: float,
    t_end: float | None = None, steps: int | None = None, every: int = 0, start: Any = None,
    arithmetic: str = "strict", solver: str = "auto", threads: int | None = None,
    width: int | None = None, cancel: Callable[[], bool] | None = None,
) -> EnsembleSolution:  # fmt: skip
    """Integrate N initial values of one problem.

    Parameters
    ----------
    problem, method, h, t_end, steps, every, arithmetic, solver
        As for :func:`.solve.solve`.
    initial : Any
        (N, d) initial values.
    start : Any
        ``None``: the method's own explicit starting method, else the enhanced start;
        ``"enhanced"``, ``"zero"``, an explicit starting method, or values (N, r, d).
    threads : int or None
        Number of threads, by default one per processor.
    width : int or None
        Lanes per block, by default what fits the first-level cache; 1 for one by one.
    cancel : Callable[[], bool] or None
        Called about every 100 ms.

    Raises
    ------
    UsageError
        One sentence on an argument that does not fit.
    """
    given_problem, method = resolved(problem, method)
    problem, d = solved_form(given_problem, method), given_problem.dimension
    y0 = array_of(initial, "`initial`", (None, d), f"(N, d) with d = {d}")
    if y0.dtype.kind == "c":
        raise UsageError("`initial` must be real, got complex numbers")
    if not np.isfinite(y0).all():
        row = int(np.flatnonzero(~np.isfinite(y0).all(axis=1))[0])
        raise UsageError(f"`initial` must be finite, got {shown(y0[row].tolist())} in row {row}")
    if problem is not given_problem:
        y0 = with_clocks(y0, problem)
    if width is not None and (width := whole("width", width)) not in (1, *WIDTHS):
        raise UsageError(f"`width` must be 1 or one of {WIDTHS}, got {shown(width)}")
    if check_arithmetic(arithmetic) == "quick":
        raise UsageError('`arithmetic="quick"` is for single runs; an ensemble takes "fused"')
    one_of("solver", solver, SOLVERS)
    check_callable("cancel", cancel)
    h = step_size(h)
    plan = plan_of(problem, h, t_end, steps, every, None, None)
    workers = os.cpu_count() or 1 if threads is None else whole("threads", threads, 1)
    given = (method, problem, y0[0], h, arithmetic, solver, workers, width, cancel)
    runner: Runner | None = None
    with np.errstate(all="ignore"):
        # before anything is compiled: numba ends the process on some functions that give no state
        seen = inspected(stepper_of(method, problem), float(problem.t_span[0]), y0[0])
        if width != 1:
            with suppress(Unsupported, ImportError):
                runner = Lanes(*given)
        runner = runner or Singles(*given)
        values, evaluations = _starts(runner, method, problem, y0, h, start)
        found = runner.run(values, evaluations, plan)
        # whose start has overflowed: no step is taken
        if not runner.engine.in_range(values):
            lost = np.array([not runner.engine.in_range(x) for x in values], dtype=bool)
            found.y[:, lost] = y0[lost]
            found.values[lost] = zero_start(runner.engine, y0[lost])
        notices = seen.afterwards(found.t[-1], found.y[-1, 0]) if seen.seen else ()
    found = replace(found, notices=(*found.notices, *notices_of(method), *notices))
    return without_clocks(found, given_problem)


def _starts(
    runner: Runner, method: Method, problem: Problem, y0: np.ndarray, h: float,
    start: Any,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """Return starting values (N, r, d) and the evaluations they cost."""
    engine = runner.engine
    if start is None:
        start = _own_start(method, engine)
    if isinstance(start, Method):
        if not _explicit(start, engine):
            raise UsageError("many trajectories need an explicit starting method")
        return _many_starts(start, engine, y0, h)
    if not isinstance(start, str):
        shape = (len(y0), *engine.shape)
        values = array_of(start, "starting values", shape, f"(N, r, d) = {shape}")
        if values.dtype.kind == "c":
            raise UsageError("starting values must be real, got complex numbers")
        if not engine.in_range(values):
            raise StartFailed("starting values must be finite; give others, or use a smaller h")
        return values, 0
    if start == "zero":
        return zero_start(engine, y0), 0
    if start != "enhanced":
        raise UsageError(f"`start` must be enhanced, zero or values (N, r, d), got {shown(start)}")
    t0, passes = float(problem.t_span[0]), default_passes(method)
    return enhanced_start(engine, t0, y0, h, passes, runner.one_step)


def _own_start(method: Method, engine: Stepper) -> Any:
    """Return the explicit start of the file, else the enhanced start.

    There is none where one value is carried.
    """
    own = method.starting
    if method.is_one_step:
        return "zero"
    return own if own is not None and _explicit(own, engine) else "enhanced"


def _explicit(start: Method, engine: Stepper) -> bool:
    """Return whether no stage that is read needs an equation solved."""
    return not any(block.implicit for block in engine.of(start).blocks)


def _many_starts(
    start: Method, engine: Stepper, y0: np.ndarray, h: float
) -> tuple[np.ndarray, int]:
    """Return an explicit starting method on all initial values (N, d), stage by stage.

    Returns values (N, r, d) and the evaluations, of k alone for a pair on a separable problem.
    """
    inner, problem = engine.of(start), engine.problem
    t0, evaluations = float(problem.t_span[0]), 0
    # trajectories side by side: sums and right-hand sides go along them
    parts = [np.ascontiguousarray(y0[:, c.columns].T) for c in inner.components]
    slopes = [
        np.zeros((c.B.shape[1], *part.shape))
        for c, part in zip(inner.components, parts, strict=True)
    ]
    for node in (block.stages[0] for block in inner.blocks):
        whose, i = inner.nodes[node]
        rows = [parts[n] + h * in_order(inner.components[n].A[i], slopes[n]) for n in whose]
        if inner.joint:
            found = slopes_at(problem, t0 + inner.c[node] * h, np.concatenate(rows).T).T
            for n in whose:
                slopes[n][i] = found[inner.components[n].columns]
        else:
            function = (problem.dp, problem.dq)[whose[0]]
            slopes[1 - whose[0]][i] = rows_at(function, rows[0].T).T
        evaluations += len(y0) * (inner.joint or whose[0] == 0)
    values = np.zeros((len(y0), *engine.shape))
    for c, part, slope in zip(inner.components, parts, slopes, strict=True):
        made = c.V.dot(part[None].reshape(1, -1)).reshape(-1, *part.shape)
        made = made + h * np.stack([in_order(row, slope) for row in c.B])
        values[:, : len(made), c.columns] = made.transpose(2, 0, 1)
    return values, evaluations
