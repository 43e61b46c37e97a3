"""What stiff problems cost: evaluations, Jacobians and matrices, beside scipy's Radau and BDF.

A diagonally implicit method solves one stage at a time: its matrices are n by n, n the number of
unknowns of a stage (half of the components for q'' = g(q)), one for each Jacobian and each distinct
diagonal entry; a fully implicit one with s stages needs a matrix of s n unknowns. What is measured
here is a fixed step against an adaptive one, and says so.

    python -m campaigns.stiff data/measurements/stiff-cost.json
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from glmref.catalogue.lookup import load
from glmref.compute.records import in_json
from glmref.engine.kernel import prepare
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.work_precision import reference_state, state_error
from glmref.method import GLM
from glmref.problems import problem
from glmref.problems.model import Problem

#: Problem, its parameters, end, and the numbers of steps that are tried.
CASES: tuple[tuple[str, dict[str, Any], float, tuple[int, ...]], ...] = (
    ("fput-stiff", {"omega": 5000}, 1.0, (100, 5000, 20000)),
    ("van-der-pol", {"mu": 10**6}, 0.5, (1000, 10000)),
    ("van-der-pol", {"mu": 10**6}, 2.0, (2_000_000,)),
)
METHODS = (
    "sdirk-2", "sdirk-4", "tr-bdf2", "dimsim-2-type-2", "gsymplectic-p", "gsymplectic-n",
    "s4-symmetric", "g6245", "g6245-w3", "gauss-2", "radau-iia-3",
)  # fmt: skip
PEERS = (("Radau", 1e-4), ("Radau", 1e-6), ("BDF", 1e-4), ("BDF", 1e-6))


@dataclass(frozen=True)
class Matrices:
    """Newton matrices of a compiled kernel."""

    size: int  #: Rows of the largest.
    distinct: int  #: How many are factored for each Jacobian.
    #: Whether they are written out and inverted in place, afresh at every stage (up to three
    #: unknowns), instead of kept from step to step.
    inline: bool


@dataclass(frozen=True)
class StiffCost:
    """What one run cost, and how good it was."""

    name: str  #: Method or solver.
    problem: str  #: What was solved.
    t_end: float  #: End of the run.
    h: float | None  #: Step size, or ``None`` for an adaptive solver.
    tolerance: float | None  #: Relative, of an adaptive one.
    outcome: str  #: How it ended.
    error: float | None  #: Of the last state, relative.
    evaluations: int  #: Of the right-hand side.
    jacobians: int  #: evaluated.
    matrices: int  #: Factored, each of ``size`` rows.
    size: int


def matrices_of(method: GLM, problem: Problem, *, h: float) -> Matrices:
    """Read off a kernel which Newton matrices it uses.

    Raises
    ------
    UsageError
        For a method without implicit stages.
    """
    kernel = prepare(method, problem, h=h, solver="newton")
    if not kernel.form.implicit_stages:
        raise UsageError("an explicit method has no Newton matrices")
    unknowns = kernel.shape.half if kernel.shape.halved else kernel.shape.dimension
    places = [
        line.strip()
        for line in kernel.source.text.splitlines()
        if line.strip().startswith(("factor(", "complex_factor("))
    ]
    if not places:
        return Matrices(unknowns, 1, True)
    # after the arrays come the size, the numbers of diagonals and how the array is laid out
    rows = {int(place.rpartition("],")[2].split(",")[0]) for place in places}
    return Matrices(max(rows), len(set(places)), False)


def stiff_cost(problem: Problem, method: GLM, *, h: float, steps: int) -> StiffCost:
    """Run a method with Newton's method at a fixed step and count.

    Where stages are solved inline every solve has a Jacobian and a matrix of its own.
    """
    matrices = matrices_of(method, problem, h=h)
    with np.errstate(all="ignore"):
        run = solve(problem, method, h=h, steps=steps, solver="newton")
    implicit = len(method.implicit_stages)
    jacobians = run.steps * implicit if matrices.inline else run.factorisations
    error = None
    if run.completed:
        reference = reference_state(problem, float(run.t[-1]))
        error = state_error(np.asarray(run.y[-1]), reference)
    return StiffCost(
        name=method.name,
        problem=problem.name,
        t_end=steps * h,
        h=h,
        tolerance=None,
        outcome=str(run.outcome),
        error=error,
        evaluations=run.total_evaluations,
        jacobians=jacobians,
        matrices=jacobians * matrices.distinct,
        size=matrices.size,
    )


def peer_cost(problem: Problem, solver: str, *, tolerance: float, t_end: float) -> StiffCost:
    """Run scipy's ``"Radau"`` or ``"BDF"`` with the problem's Jacobian and count."""
    integrate = import_module("scipy.integrate")
    start = float(problem.t_span[0])
    floor = tolerance * 1e-2 * float(np.max(np.abs(problem.y0)))
    solved = integrate.solve_ivp(
        problem.f, (start, start + t_end), problem.y0, method=solver, rtol=tolerance, atol=floor,
        jac=problem.jacobian,
    )  # fmt: skip
    error = None
    if solved.success:
        error = state_error(solved.y[:, -1], reference_state(problem, start + t_end))
    return StiffCost(
        name=f"scipy {solver}",
        problem=problem.name,
        t_end=t_end,
        h=None,
        tolerance=tolerance,
        outcome="completed" if solved.success else "gave up",
        error=error,
        evaluations=int(solved.nfev),
        jacobians=int(solved.njev),
        matrices=int(solved.nlu),
        size=problem.dimension,
    )


def row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Return the cost of a method at a fixed step, or of a solver with a tolerance."""
    subject, t_end = problem(task["problem"], **task["parameters"]), task["t_end"]
    if "solver" in task:
        solver, tolerance = task["solver"], task["tolerance"]
        return in_json(peer_cost(subject, solver, tolerance=tolerance, t_end=t_end))
    method, steps = load(task["method"]), task["steps"]
    assert isinstance(method, GLM)
    return in_json(stiff_cost(subject, method, h=t_end / steps, steps=steps))


NOTE = (
    "error: of the last state, relative; matrices: factored, each of `size` rows; up to three "
    "unknowns they are written out and inverted afresh at every implicit stage"
)


def main(path: Path) -> None:
    """Measure every case and write the file."""
    tasks: list[dict[str, Any]] = []
    for name, parameters, t_end, counts in CASES:
        case = {"problem": name, "parameters": parameters, "t_end": t_end}
        tasks += [{**case, "method": x, "steps": n} for x in METHODS for n in counts]
        tasks += [{**case, "solver": x, "tolerance": tolerance} for x, tolerance in PEERS]
    rows = carried_out(row, tasks, beside=path)
    title = "Counts on stiff problems: Newton at a fixed step beside scipy's Radau and BDF"
    complete(path, record_of("stiff", "stiff-cost", title, NOTE, rows=rows))


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
