"""Force evaluations that splittings and pairs need for a given accuracy, problem by problem.

For each case and method the error is taken on a grid of step sizes, a third of an octave apart.
The evaluations *needed* for a tolerance are where the error falls below it for good: between the
last grid point above and the first after it, interpolated in logarithms. So a lucky zero of the
error at one step size counts for nothing. Times are taken afterwards, at the step sizes found, all
methods in turn, several rounds.

    python -m campaigns.partitioned.work data/measurements/pairs.json
"""

from __future__ import annotations

import math
import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import TIMED, arguments, carried_out, complete, record_of, three_digits
from campaigns.partitioned.held_out_problems import PROBLEMS, problem_of
from glmref.catalogue.lookup import load
from glmref.compute.records import finite
from glmref.engine.outcome import Solution, StartFailed
from glmref.engine.solve import solve
from glmref.engine.sweep import step_form
from glmref.measure.work_precision import energy_error, reference_state, state_error
from glmref.method import PartitionedGLM
from glmref.problems import problem
from glmref.problems.model import Problem

TOLERANCES = (1e-6, 1e-9)
#: Grid points to an octave of step sizes.
DENSITY = 3
#: Rounds of the timing.
ROUNDS = 9
#: Samples of the energy where the energy is what is measured.
SAMPLES = 64

SPLITTINGS = (
    *("stormer-verlet", "forest-ruth-4", "mclachlan-4", "yoshida-verlet-6", "kahan-li-6"),
    *("blanes-moan-6", "blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14", "kahan-li-8"),
    "suzuki-umeno-8",
)
PAIRS = (
    *("pair-4-4", "pair-4-5", "pair-4-6", "pair-6-7", "pair-6-8", "pair-6-9", "pair-6-10"),
    *("pair-8-24", "pair-rkn-6-7", "pair-rkn-6-7b", "pair-rkn-6-8", "pair-rkn-6-8b"),
    *("pair-rkn-6-9", "pair-rkn-8-16"),
)
#: Pairs that are measured from the enhanced start too.
ENHANCED = ("pair-6-7", "pair-6-8", "pair-rkn-6-7b", "pair-rkn-6-8b")
METHODS = SPLITTINGS + PAIRS


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
    timed: bool = False  #: Whether times are taken too.
    most: int = 2_000_000  #: No run takes more force evaluations than this.

    def built(self) -> Problem:
        """Return the problem."""
        return _problem(self.problem, self.parameters)


@cache
def _problem(name: str, parameters: tuple[tuple[str, str], ...]) -> Problem:
    return problem_of(name) if name in PROBLEMS else problem(name, **dict(parameters))


_PERIOD = 2 * math.pi
_E2, _E6 = (("eccentricity", "1/5"),), (("eccentricity", "3/5"),)
CASES = (
    Case("kepler-0.2", "kepler", 10 * _PERIOD, 300, _E2, timed=True),
    Case("kepler-0.2-long", "kepler", 300 * _PERIOD, 9000, _E2),
    Case("kepler-0.6", "kepler", 10 * _PERIOD, 900, _E6, timed=True),
    Case("kepler-0.6-long", "kepler", 300 * _PERIOD, 27000, _E6),
    Case("henon-heiles", "henon-heiles", 50.0, 150, timed=True),
    Case("henon-heiles-long", "henon-heiles", 5000.0, 10000, measure="energy"),
    Case("outer-solar-system", "outer-solar-system", 200_000.0, 500, timed=True),
    Case("outer-solar-system-long", "outer-solar-system", 2_000_000.0, 5000),
    Case("pendulum", "pendulum", 50.0, 150, timed=True),
    Case("pendulum-long", "pendulum", 5000.0, 15000),
    Case("toda", "toda", 50.0, 150),
    Case("toda-long", "toda", 1000.0, 3000),
    Case("fput", "fput", 200.0, 400),
    Case("fput-stiff", "fput-stiff", 10.0, 1000),
    Case("figure-eight", "figure-eight", 20.0, 150),
    Case("pleiades", "pleiades", 1.5, 1000),
    Case("n-body", "n-body", 1.0, 100),
    Case("harmonic-oscillator", "harmonic-oscillator", 100.0, 100),
    Case("lotka-volterra", "lotka-volterra-logarithmic", 50.0, 200),
)
#: Separable problems of the catalogue that are not measured, and why.
LEFT_OUT = {
    "long-chain": "100,000 components, linear: it asks about memory, not about accuracy",
    "pythagorean": "close encounters: no constant step size reaches 1e-9",
    "scaled-kepler": "Kepler's problem in other units",
    "stiff-spring-pendulum": "stiff: stability, not accuracy, bounds the step of explicit methods",
}


@dataclass(frozen=True)
class Need:
    """What one method needs in one case."""

    method: str  #: Its name.
    start: str  #: ``"zero"`` or ``"enhanced"`` for pairs, ``""`` for splittings.
    #: (evaluations of the steps, error) for each step size, coarse to fine.
    curve: tuple[tuple[int, float], ...]
    start_evaluations: int  #: What the start costs.
    #: Tolerance -> evaluations of the steps; missing where it was not reached.
    needed: dict[float, float]
    #: Tolerance -> median time of the steps at that many evaluations.
    seconds: dict[float, float] = field(default_factory=dict)

    def counted(self) -> dict[str, Any]:
        """Return the evaluations in JSON's types."""
        needed = {f"{t:.0e}": round(n) for t, n in self.needed.items()}
        return {
            "method": self.method, "start_evaluations": self.start_evaluations, "needed": needed,
        }  # fmt: skip


@cache
def _method(name: str) -> PartitionedGLM:
    found = load(name)
    assert isinstance(found, PartitionedGLM)
    return found


def _run(case: Case, method: str, steps: int, start: str) -> Solution:
    target = case.built()
    options: dict[str, Any] = {"steps": steps, "h": case.t_end / steps}
    if case.measure == "energy":
        options["every"] = max(1, steps // SAMPLES)
    if start:
        options["start"] = ("enhanced", 3) if start == "enhanced" else start
    return solve(target, _method(method), **options)


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
    case: Case, methods: Sequence[str] = METHODS, tolerances: Sequence[float] = TOLERANCES
) -> list[Need]:
    """Measure the error of each method on the grid of step sizes.

    Pairs start from zero values, those of :data:`ENHANCED` from the enhanced start of three passes
    (seven steps) too.
    """
    error, result = _error(case), []
    for method in methods:
        starts = ("zero", "enhanced") if method in ENHANCED else ("zero",)
        for start in starts if method.startswith("pair-") else ("",):
            result.append(_need(case, method, start, error, tolerances))
    return result


def _need(
    case: Case,
    method: str,
    start: str,
    error: Callable[[Solution], float],
    tolerances: Sequence[float],
) -> Need:
    each, curve, cost = per_step(method), [], 0
    for k in range(200):
        steps = math.ceil(case.least * 2 ** (k / DENSITY) / each)
        if steps * each > case.most:
            break
        try:
            solution = _run(case, method, steps, start)
        except StartFailed:  # the step is too long for a start: the next one is shorter
            continue
        cost = solution.start_evaluations
        if solution.completed:
            curve.append((solution.evaluations, error(solution)))
            if _settled(curve, min(tolerances)):
                break
    found = {t: crossing(curve, t) for t in tolerances}
    needed = {t: n for t, n in found.items() if n is not None}
    return Need(method, start, tuple(curve), cost, needed)


def _settled(curve: Sequence[tuple[int, float]], sharpest: float = min(TOLERANCES)) -> bool:
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


def timed(case: Case, found: Sequence[Need], rounds: int = ROUNDS) -> list[Need]:
    """Add the times: the steps alone, all methods in turn in each round, the median of rounds.

    They are taken at the number of steps that the sharpest tolerance needs.
    """
    tolerance = min(TOLERANCES)
    samples: dict[int, list[float]] = {}
    for _ in range(rounds):
        for k, need in enumerate(found):
            if tolerance in need.needed:
                steps = max(1, round(need.needed[tolerance] / per_step(need.method)))
                solution = _run(replace(case, measure="state"), need.method, steps, need.start)
                samples.setdefault(k, []).append(solution.seconds)
    return [
        replace(need, seconds={tolerance: statistics.median(samples[k])} if k in samples else {})
        for k, need in enumerate(found)
    ]


def _as_json(case: Case, found: Sequence[Need]) -> dict[str, Any]:
    return {
        "case": case.name,
        "problem": case.problem,
        "parameters": dict(case.parameters),
        "time": case.t_end,
        "measure": case.measure,
        "methods": [
            {
                "method": need.method,
                "start": need.start or "none",
                "start_evaluations": need.start_evaluations,
                "needed": {f"{t:.0e}": round(n) for t, n in need.needed.items()},
                "seconds": {f"{t:.0e}": three_digits(x) for t, x in need.seconds.items()},
                "curve": [[n, three_digits(e)] for n, e in need.curve],
            }
            for need in found
        ],
    }


NOTE = (
    "needed: force evaluations of the steps from which the error stays below the tolerance, "
    "interpolated between step sizes a third of an octave apart; start_evaluations come on top. "
    "seconds: median of nine rounds over all methods in turn, compiled engine, steps alone. "
    "Pairs start from zero values (no cost), some from the enhanced start of three passes too."
)


def main(path: Path, cases: Sequence[Case] = CASES, methods: Sequence[str] = METHODS) -> None:
    """Measure all cases, then the times of those that ask for it, and write the file."""
    pairs = [(case, method) for case in cases for method in methods]
    rows = carried_out(need_row, (task_of(case, x) for case, x in pairs), beside=path)
    found: dict[Case, list[Need]] = {case: [] for case in cases}
    for (case, _), row in zip(pairs, rows, strict=True):
        found[case] += map(need_of, row)
    tasks = [
        {**task_of(case), "needs": [_as_row(x) for x in found[case]]}
        for case in cases
        if case.timed
    ]
    times = carried_out(time_row, tasks, beside=path, limits=TIMED)
    timed_cases = (case for case in cases if case.timed)
    found |= {case: [*map(need_of, x)] for case, x in zip(timed_cases, times, strict=True)}
    write(path, found)


def task_of(case: Case, *methods: str) -> dict[str, Any]:
    """Return a case and methods in JSON."""
    return {"case": asdict(case), "methods": list(methods)}


def case_of(task: Mapping[str, Any]) -> Case:
    """Return the case of a task."""
    return Case(**{**task["case"], "parameters": tuple(map(tuple, task["case"]["parameters"]))})


def need_of(row: Mapping[str, Any]) -> Need:
    """Return what is needed from its form in JSON, where keys are texts and tuples lists."""
    numbers = {key: {float(t): x for t, x in row[key].items()} for key in ("needed", "seconds")}
    curve = tuple((n, math.nan if e is None else e) for n, e in row["curve"])
    return Need(**{**row, **numbers, "curve": curve})


def _as_row(need: Need) -> dict[str, Any]:
    return {**asdict(need), "curve": [(n, finite(e)) for n, e in need.curve]}


def need_row(task: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Carry out :func:`needs` for a task in JSON."""
    return [_as_row(x) for x in needs(case_of(task), task["methods"])]


def time_row(task: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Carry out :func:`timed` for a task in JSON."""
    return [_as_row(x) for x in timed(case_of(task), [need_of(x) for x in task["needs"]])]


def write(path: Path, found: Mapping[Case, Sequence[Need]]) -> None:
    """Write the records of all cases as one JSON document."""
    title = "Force evaluations and time that splittings and explicit pairs need"
    left_out = (f"{name} is left out: {why}" for name, why in LEFT_OUT.items())
    record = record_of("partitioned.work", "pairs", title, NOTE, *left_out)
    complete(path, record | {"cases": [_as_json(case, rows) for case, rows in found.items()]})


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
