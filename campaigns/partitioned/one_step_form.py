"""Symmetric multistep methods in one-step form, in summed form, and with velocities of differences.

    python -m campaigns.partitioned.one_step_form data/measurements/one-step-form.json

The positions of all three satisfy one formula. The *one-step form* carries a value for each root
and starts and reads the velocity by them; the *summed form* of the files carries the mean velocity
over a step and sums of forces, and starts by collocation. With *differences* its velocities are
central differences of its positions, of the order of the method, as where only positions are kept.

Evaluations are those from which the error stays below a tolerance, on the held-out problems of at
most six components: the error of the last state over the short horizon, the largest one of the
energy in 64 samples over the long one. Beside them stand times of a step of both forms, which take
turns, and the energy error of a million small steps, which is rounding.
"""

import math
import statistics
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import TIMED, arguments, carried_out, complete, record_of, three_digits
from campaigns.pages import measured
from campaigns.partitioned.error_front import SYMMETRIC, angles_of
from campaigns.partitioned.work import PROBLEMS, crossing, mean, quadratic
from glmref.catalogue.lookup import load
from glmref.catalogue.reader import load_document
from glmref.derive.multistep import multistep_document
from glmref.engine.outcome import Solution, StartFailed
from glmref.engine.solve import solve
from glmref.measure.work_precision import energy_error, reference_state, state_error
from glmref.method import Method
from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.problems.table import from_table
from tools.measure.timing import interleaved, ratios

#: The tolerance of the sentences, and all.
KEY, TOLERANCES = "1e-09", (1e-6, 1e-9)
#: Grid points to an octave of step sizes, samples of the energy, components of the largest problem.
_DENSITY, SAMPLES, _COMPONENTS = 3, 64, 6
#: Steps of a run that is timed, and rounds; steps of a run of rounding, and its part of the step.
STEPS, ROUNDS, LONG, PART = 20_000, 9, 1_000_000, 4
_NOTES = (
    "needed: evaluations of the steps from which the error stays below the tolerance, by form.",
    f"slower: time of a step of the summed over that of the one-step form, median of {ROUNDS}.",
    f"rounding: largest energy error in {LONG:,} steps, each 1/{PART} of the step of 1e-9.",
)


@cache
def problem_of(name: str) -> Problem:
    """Build one of the problems held out."""
    held = PROBLEMS[name]
    if "H" not in held:
        return problem("kepler", **held["parameters"])
    given = {k: held[k] for k in ("H", "y0", "t_end", "parameters") if held.get(k) is not None}
    return from_table({**given, "name": name})


def cases() -> list[str]:
    """Return the small problems with quadratic T, over both horizons."""
    small = [x for x in PROBLEMS if quadratic(x) and problem_of(x).dimension <= _COMPONENTS]
    return [x for name in small for x in (name, f"{name}, long")]


class Case:
    """A problem held out, over its short or its long horizon."""

    def __init__(self, name: str) -> None:
        given = PROBLEMS[name.removesuffix(", long")]
        self.name, self.long = name, name.endswith(", long")
        self.problem = problem_of(name.removesuffix(", long"))
        self.t_end = given["longer"] if self.long else given["t_end"]
        self.least = round(given["least"] * self.t_end / given["t_end"])
        most = given.get("most", 1_000_000)
        self.most = max(most, 20 * self.least) if self.long else most

    def run(self, method: Method, steps: int) -> Solution:
        """Take so many steps, with samples where the energy is measured."""
        every = max(1, steps // SAMPLES) if self.long else steps
        return solve(self.problem, method, h=self.t_end / steps, steps=steps, every=every)

    def error(self, found: Solution) -> float:
        """Return the error of the energy, or of the last state."""
        if not found.completed:
            return math.inf
        if self.long:
            return energy_error(self.problem, found)
        end = float(self.problem.t_span[0]) + self.t_end
        return state_error(np.asarray(found.y[-1]), reference_state(self.problem, end))

    def needed(self, error: Callable[[int], float]) -> dict[str, int]:
        """Return the evaluations by tolerance; ``error`` is that of a number of steps."""
        curve: list[tuple[int, float]] = []
        for k in range(200):
            steps = math.ceil(self.least * 2 ** (k / _DENSITY))
            below = [x < min(TOLERANCES) / 2 for _, x in curve[-_DENSITY:]]
            if steps > self.most or (len(below) == _DENSITY and all(below)):
                break
            with suppress(StartFailed):  # the step is too long for a start: the next one is shorter
                curve.append((steps, error(steps)))
        found = {f"{x:.0e}": crossing(curve, x) for x in TOLERANCES}
        return {key: round(n) for key, n in found.items() if n is not None}


@cache
def twin(name: str) -> Method:
    """Return a method in one-step form, up to the rounding of the cosines of its roots."""
    near = [Fraction(float(c)).limit_denominator(10**9) for c in np.cos(angles_of(name))[::-1]]
    return load_document(multistep_document(f"{name}-in-one-step-form", [], near, title=name))


def difference_weights(k: int) -> list[float]:
    """Return the weights of q(jh) - q(-jh), j = 1, .., k, in h q'(0), of order 2k."""
    whole = math.factorial(k) ** 2
    return [
        (-1) ** (j + 1) * whole / (j * math.factorial(k - j) * math.factorial(k + j))
        for j in range(1, k + 1)
    ]


def with_differences(problem: Problem, found: Solution, at: np.ndarray, order: int) -> np.ndarray:
    """Return states (n, d) at steps (n,) whose velocities are differences of the positions."""
    m = problem.dimension // 2
    q, h = found.y[:, :m], found.t[1] - found.t[0]
    weights = enumerate(difference_weights(order // 2), 1)
    velocity = sum(w * (q[at + j] - q[at - j]) for j, w in weights) / h
    mass = np.ones(m)
    if problem.dq is not None:
        mass = 1 / np.diag([problem.dq(unit) for unit in np.eye(m)])
    return np.hstack([q[at], velocity * mass])


def _by_differences(case: Case, method: Method, order: int, steps: int) -> float:
    """Return the error of so many steps in summed form with velocities of differences."""
    beyond, h = order // 2, case.t_end / steps
    found = solve(case.problem, method, h=h, steps=steps + beyond, every=1)
    if not found.completed:
        return math.inf
    apart = max(1, steps // SAMPLES) if case.long else steps
    at = np.arange(apart, steps + 1, apart)
    at = np.array([0, *at[at >= beyond]])
    states = with_differences(case.problem, found, at[1:], order)
    return case.error(replace(found, t=found.t[at], y=np.vstack([found.y[:1], states])))


def forms_of(name: str) -> dict[str, Method]:
    """Return a published method in one-step form and in summed form."""
    return {"one-step": twin(name), "summed": load(name)}


def counts(given: Mapping[str, Any]) -> dict[str, Any]:
    """Return the evaluations of the forms of a method on a case, by tolerance."""
    case, name = Case(given["case"]), given["method"]
    order = load(name).claims["nystrom-order"]
    assert isinstance(order, int)
    runs: dict[str, Callable[[int], float]] = {
        form: lambda steps, x=x: case.error(case.run(x, steps))
        for form, x in forms_of(name).items()
    }
    runs["differences"] = partial(_by_differences, case, load(name), order)
    needed = {form: case.needed(error) for form, error in runs.items()}
    return {**given, "measure": "energy" if case.long else "state", "needed": needed}


def both(given: Mapping[str, Any]) -> dict[str, Any]:
    """Time steps of both forms in turn, and take the energy error of a million small steps."""
    target, h, forms = problem_of(given["case"]), given["h"], forms_of(given["method"])
    ways = {k: partial(solve, target, x, h=h, steps=STEPS, every=STEPS) for k, x in forms.items()}
    slower = statistics.median(ratios(interleaved(ways, ROUNDS), "summed", "one-step"))
    rounding = {}
    for form, x in forms.items():
        found = solve(target, x, h=h / PART, steps=LONG, every=LONG // SAMPLES)
        rounding[form] = three_digits(energy_error(target, found)) if found.completed else None
    return {**given, "slower": three_digits(slower), "rounding": rounding}


def main(path: Path) -> None:
    """Measure all, and write the record."""
    title = "Published symmetric multistep methods in one-step and in summed form"
    record = record_of("partitioned.one_step_form", "one-step-form", title, *_NOTES)
    tasks = [{"case": case, "method": name} for case in cases() for name in SYMMETRIC]
    record["needed"] = carried_out(counts, tasks, beside=path)
    timed = [
        {"case": x["case"], "method": x["method"], "h": float(f"{Case(x['case']).t_end / n:.3g}")}
        for x in record["needed"]
        if x["measure"] == "state" and (n := x["needed"]["one-step"].get(KEY))
    ]
    record["both"] = carried_out(both, timed, beside=path, limits=TIMED)
    complete(path, record)


def gains(measure: str, form: str) -> list[float]:
    """Return evaluations of a form at 1e-9 over those of the one-step form, one mean a method."""
    found: dict[str, list[float]] = {}
    for x in measured("one-step-form")["needed"]:
        mine, other = (x["needed"][k].get(KEY) for k in ("one-step", form))
        if x["measure"] == measure and mine and other:
            found.setdefault(x["method"], []).append(other / mine)
    return [mean(x) for x in found.values()]


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
