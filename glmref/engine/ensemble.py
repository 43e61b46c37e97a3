"""Many initial values at once: lanes of one block side by side, blocks spread over threads.

A block of lanes is stepped by one kernel (:mod:`.lanes`) whose inner loop the compiler turns into
SIMD instructions; every trajectory has the bits :func:`.solve.solve` gives it. Kernels release the
interpreter's lock, so blocks run in threads. Right-hand sides that are loop bodies or callables,
implicit pairs and large systems are stepped one by one, still in threads.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from ..errors import UsageError
from ..exact.linalg import Vector
from ..method import GLM, PairStartingMethod, PartitionedGLM, StartingMethod
from ..problems.model import Problem
from .codegen import SCALAR_LIMIT
from .inspection import inspected
from .kernel import choose_form
from .partitioned_start import explicit_order
from .plan import notices_of, plan_of, resolved, step_size
from .reference import stepper
from .runners import WIDTHS, EnsembleSolution, Lanes, Runner, Singles, rows_at, slopes_at
from .start import corrector, default_passes, zero_start

__all__ = ["EnsembleSolution", "solve_ensemble"]


def solve_ensemble(
    problem: Problem | str, method: GLM | PartitionedGLM | str, initial: Any, *, h: float,
    t_end: float | None = None, steps: int | None = None, every: int = 0, start: Any = None,
    arithmetic: str = "strict", solver: str = "auto", threads: int | None = None,
    width: int | None = None, cancel: Callable[[], bool] | None = None,
) -> EnsembleSolution:  # fmt: skip
    """Integrate N initial values of one problem.

    Args:
        problem, method, h, t_end, steps, every, arithmetic, solver: as for :func:`.solve.solve`.
        initial: (N, d) initial values.
        start: ``None``: the method's own explicit starting method, else the enhanced start;
            ``"enhanced"``, ``"zero"``, an explicit starting method, or values (N, r, d).
        threads: number of threads, by default one per processor.
        width: lanes per block, by default what fits the first-level cache; 1 for one by one.
        cancel: called about every 100 ms.

    Raises
    ------
        UsageError: one sentence on an argument that does not fit.
    """
    problem, method = resolved(problem, method)
    y0 = np.array(initial, dtype=float)
    if y0.ndim != 2 or y0.shape[1] != problem.dimension or not len(y0):
        raise UsageError(
            f"`initial` must have shape (N, d) with d = {problem.dimension}, got {y0.shape}"
        )
    if width is not None and width not in (1, *WIDTHS):
        raise UsageError(f"`width` must be 1 or one of {WIDTHS}, got {width!r}")
    h = step_size(h)
    plan = plan_of(problem, h, t_end, steps, every, None, None)
    workers = threads if threads is not None else (os.cpu_count() or 1)
    if not isinstance(workers, int) or workers < 1:
        raise UsageError(f"`threads` must be a positive whole number, got {threads!r}")
    # the solver is chosen where the ensemble starts, not where the problem does
    first = replace(problem, y0=tuple(y0[0]), initial=None) if problem.context is None else problem
    one_by_one = width == 1 or not _has_lanes(method, problem)
    runner: Runner = (Singles if one_by_one else Lanes)(
        method, first, h, arithmetic, solver, workers, width, cancel
    )
    with np.errstate(all="ignore"):
        inspected(stepper(method, problem), float(problem.t_span[0]), y0[0])
        values, evaluations = _starts(runner, method, problem, y0, h, start)
        found = runner.run(values, evaluations, plan)
    return replace(found, notices=(*found.notices, *notices_of(method)))


def _has_lanes(method: GLM | PartitionedGLM, problem: Problem) -> bool:
    if problem.dimension > SCALAR_LIMIT:
        return False
    form, shape = choose_form(method, problem, "auto")
    return not shape.loops and not (isinstance(method, PartitionedGLM) and form.implicit_stages)


def _starts(
    runner: Runner, method: GLM | PartitionedGLM, problem: Problem, y0: np.ndarray, h: float,
    start: Any,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """Starting values (N, r, d) and the evaluations they cost."""
    engine = runner.engine
    if start is None:
        start = _own_start(method)
    if isinstance(start, StartingMethod):
        return _runge_kutta_starts(start, problem, y0, h)
    if isinstance(start, PairStartingMethod) and isinstance(method, PartitionedGLM):
        order = explicit_order(start, method)
        if order is None:
            raise UsageError("many trajectories need an explicit starting method")
        return _pair_starts(start, order, problem, y0, h, engine.shape[0])
    if not isinstance(start, str):
        values = np.array(start, dtype=float)
        if values.shape != (len(y0), *engine.shape):
            raise UsageError(
                f"starting values must have shape (N, r, d) = {(len(y0), *engine.shape)}, got "
                f"{values.shape}"
            )
        return values, 0
    if start == "zero":
        return zero_start(engine, y0), 0
    if start != "enhanced":
        raise UsageError(f"`start` must be enhanced, zero or values (N, r, d), got {start!r}")
    correct, passes, cost = corrector(engine), default_passes(method), 0

    def enhanced(k: int, y: np.ndarray) -> np.ndarray:
        nonlocal cost
        if k == 0:
            return zero_start(engine, y)
        values = enhanced(k - 1, y)
        after, spent = runner.one_step(values)
        cost += spent
        return values + correct(after - enhanced(k - 1, engine.solution(after)))

    return enhanced(passes, y0), cost


def _own_start(method: GLM | PartitionedGLM) -> Any:
    """The explicit start of the file, else the enhanced start; none where one value is carried."""
    if isinstance(method, PartitionedGLM):
        own, one = method.starting, method.r == method.r_hat == 1
        explicit = own is not None and explicit_order(own, method) is not None
    else:
        own, one = method.starting, method.r == 1
        explicit = own is not None and _explicit(own)
    return "zero" if one else own if explicit else "enhanced"


def _explicit(start: StartingMethod) -> bool:
    m = start.stages
    return all(start.A[i][j].is_zero() is True for i in range(m) for j in range(i, m))


def _runge_kutta_starts(
    start: StartingMethod, problem: Problem, y0: np.ndarray, h: float
) -> tuple[np.ndarray, int]:
    """An explicit starting method on all initial values, one column each."""
    t0, slopes = float(problem.t_span[0]), []
    row_sums = [sum(float(x) for x in row) for row in start.A]
    for i, row in enumerate(start.A):
        stage = y0.copy()
        for j, slope in enumerate(slopes):
            stage += h * float(row[j]) * slope
        slopes.append(slopes_at(problem, t0 + row_sums[i] * h, stage))
    values = np.stack([float(u) * y0 for u in start.u], axis=1)
    for k, row in enumerate(start.B):
        for weight, slope in zip(row, slopes, strict=True):
            values[:, k] += h * float(weight) * slope
    return values, len(slopes) * len(y0)


def _pair_starts(
    start: PairStartingMethod,
    order: list[tuple[str, int]],
    problem: Problem,
    y0: np.ndarray,
    h: float,
    rows: int,
) -> tuple[np.ndarray, int]:
    """An explicit start on many initial values at once, on a separable problem.

    Args:
        order: see :func:`explicit_order`. y0: (N, d). rows: max(r, r^).

    Returns
    -------
        values (N, rows, d) and the evaluations of k.
    """
    m = y0.shape[1] // 2
    q0, p0 = y0[:, :m], y0[:, m:]
    slopes: dict[tuple[str, int], np.ndarray] = {}

    def total(base: np.ndarray, row: Vector, letter: str) -> np.ndarray:
        terms = [(x, slopes.get((letter, j))) for j, x in enumerate(row)]
        return base + sum((h * float(x) * s for x, s in terms if s is not None), 0 * base)

    for letter, i in order:
        if letter == "Q":
            slopes["Q", i] = rows_at(problem.dp, total(q0, start.A[i], "P"))
        else:
            slopes["P", i] = rows_at(problem.dq, total(p0, start.A_hat[i], "Q"))
    values = np.zeros((len(y0), rows, y0.shape[1]))
    for k, (u, row) in enumerate(zip(start.u, start.B, strict=True)):
        values[:, k, :m] = total(float(u) * q0, row, "P")
    for k, (u, row) in enumerate(zip(start.u_hat, start.B_hat, strict=True)):
        values[:, k, m:] = total(float(u) * p0, row, "Q")
    return values, sum(letter == "Q" for letter, _ in order) * len(y0)
