"""Evaluations that a method needs for a given accuracy, problem by problem.

For each case and method the error is taken on a grid of step sizes, a third of an octave apart.
The evaluations *needed* for a tolerance are where the error falls below it for good: between the
last grid point above and the first after it, interpolated in logarithms. So a lucky zero of the
error at one step size counts for nothing.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from glmref.catalogue.lookup import load
from glmref.engine.outcome import Solution, StartFailed
from glmref.engine.solve import solve
from glmref.engine.sweep import step_form
from glmref.measure.work_precision import energy_error, reference_state, state_error
from glmref.method import PartitionedGLM
from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.problems.table import from_table

TOLERANCES = (1e-6, 1e-9)
#: Grid points to an octave of step sizes.
DENSITY = 3
#: Samples of the energy where the energy is what is measured.
SAMPLES = 64


@dataclass(frozen=True)
class Held:
    """A problem on which no method of this project was trained, and how far it is solved.

    They were chosen before any of them was run: thirty-one with T = p^T p / 2 or with masses and
    nine with another T.
    """

    #: The short and the long horizon.
    t_end: float
    longer: float
    least: int  #: Evaluations at which the grid of the short horizon begins.
    #: As in a problem of a user's own; without H, the parameters of Kepler's problem.
    H: str = ""
    y0: Any = None
    parameters: Mapping[str, Any] | None = None
    quadratic: bool = True  #: Whether T is quadratic.
    most: int = 1_000_000  #: No run takes more evaluations.
    about: str = ""  #: What it is, where the name does not say it.


_FILE = Path(__file__).with_name("held_out_problems.json")
PROBLEMS: Mapping[str, Held] = {
    name: Held(**entry) for name, entry in json.loads(_FILE.read_text(encoding="utf-8")).items()
}


@cache
def problem_of(name: str) -> Problem:
    """Build one of the problems."""
    held = PROBLEMS[name]
    if not held.H:
        return problem("kepler", **held.parameters or {})
    table = {"H": held.H, "y0": held.y0, "t_end": held.t_end, "name": name}
    return from_table(table | ({"parameters": held.parameters} if held.parameters else {}))


@dataclass(frozen=True)
class Case:
    """A problem, how far it is solved, and what is measured."""

    name: str  #: One word.
    #: Of the catalogue, or a name of :data:`PROBLEMS`.
    problem: str
    t_end: float  #: Time, from its beginning.
    least: int  #: Evaluations at which the grid begins.
    parameters: tuple[tuple[str, str], ...] = ()
    #: ``"state"``: Euclidean error of the last state, relative; ``"energy"``: largest error of H
    #: over 64 samples, relative (where the motion is chaotic or the time long).
    measure: str = "state"
    most: int = 2_000_000  #: No run takes more force evaluations than this.

    def built(self) -> Problem:
        """Return the problem."""
        return _problem(self.problem, self.parameters)


@cache
def _problem(name: str, parameters: tuple[tuple[str, str], ...]) -> Problem:
    return problem_of(name) if name in PROBLEMS else problem(name, **dict(parameters))


@cache
def _method(name: str) -> PartitionedGLM:
    found = load(name)
    assert isinstance(found, PartitionedGLM)
    return found


def _error(case: Case) -> Callable[[Solution], float]:
    """Return the function that takes the error of a solution of the case."""
    target = case.built()
    if case.measure == "state":
        reference = reference_state(target, float(target.t_span[0]) + case.t_end)
        return lambda s: state_error(np.asarray(s.y[-1]), reference)

    return lambda s: energy_error(target, s)


def per_step(method: str) -> int:
    """Return evaluations of a step; one less where the last of a step is the first of the next."""
    form = step_form(_method(method))
    return max(1, len(form.U) - form.reuses_force)


def needed(
    entry: Mapping[str, Any], methods: Sequence[str], tolerance: str, what: str = "needed"
) -> tuple[str, float]:
    """Return the cheapest of some methods in a case and its cost (infinite if there is none)."""
    found = {x["method"]: x.get(what, {}).get(tolerance, math.inf) for x in entry["methods"]}
    name = min(methods, key=lambda x: found.get(x, math.inf), default="")
    return name, found.get(name, math.inf)


def mean(values: Sequence[float]) -> float:
    """Return the geometric mean of those that are numbers; NaN where none is."""
    logs = [math.log(x) for x in values if math.isfinite(x)]
    return math.exp(math.fsum(logs) / len(logs)) if logs else math.nan


def needs(
    case: Case, methods: Sequence[str], tolerances: Sequence[float] = TOLERANCES
) -> list[dict[str, Any]]:
    """Return what each method needs: its name, evaluations by tolerance, and those of its start.

    Pairs start from zero values, other methods as their files say. A tolerance that is not reached
    is missing.
    """
    error = _error(case)
    return [_need(case, method, error, tolerances) for method in methods]


def _need(
    case: Case, method: str, error: Callable[[Solution], float], tolerances: Sequence[float]
) -> dict[str, Any]:
    each, cost = per_step(method), 0
    curve: list[tuple[int, float]] = []
    options: dict[str, Any] = {"start": "zero"} if method.startswith("pair-") else {}
    for k in range(200):
        steps = math.ceil(case.least * 2 ** (k / DENSITY) / each)
        if steps * each > case.most:
            break
        options |= {"steps": steps, "h": case.t_end / steps}
        if case.measure == "energy":
            options["every"] = max(1, steps // SAMPLES)
        try:
            solution = solve(case.built(), _method(method), **options)
        except StartFailed:  # the step is too long for a start: the next one is shorter
            continue
        cost = solution.start_evaluations
        if solution.completed:
            curve.append((solution.evaluations, error(solution)))
            if _settled(curve, min(tolerances)):
                break
    found = {f"{t:.0e}": crossing(curve, t) for t in tolerances}
    counts = {key: round(n) for key, n in found.items() if n is not None}
    return {"method": method, "start_evaluations": cost, "needed": counts}


def _settled(curve: Sequence[tuple[int, float]], sharpest: float) -> bool:
    """Return whether the error stays below half the sharpest tolerance for an octave of steps.

    Smaller steps are not taken then. On the curves of ``data/measurements/pairs.json``, which go
    on to the smallest step, no crossing lies behind that point.
    """
    last = curve[-DENSITY:]
    return len(last) == DENSITY and all(e < sharpest / 2 for _, e in last)


def crossing(curve: Sequence[tuple[int, float]], tolerance: float) -> float | None:
    """Interpolate, in logarithms, the evaluations from which the error stays below a tolerance."""
    above = [k for k, (_, e) in enumerate(curve) if not e < tolerance]
    last = above[-1] if above else -1
    if last == len(curve) - 1:
        return None
    if last < 0:
        return float(curve[0][0])
    (n, e), (m, d) = curve[last], curve[last + 1]
    if not (math.isfinite(e) and d > 0):
        return float(m)
    part = math.log(e / tolerance) / math.log(e / d)
    return n * (m / n) ** part


def task_of(case: Case, *methods: str) -> dict[str, Any]:
    """Return a case and methods in JSON."""
    return {"case": asdict(case), "methods": list(methods)}


def case_of(task: Mapping[str, Any]) -> Case:
    """Return the case of a task."""
    return Case(**{**task["case"], "parameters": tuple(map(tuple, task["case"]["parameters"]))})


def need_row(task: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Carry out :func:`needs` for a task in JSON."""
    return needs(case_of(task), task["methods"])
