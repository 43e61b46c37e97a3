"""Order 6 and 8 against Gauss methods and compositions: time and evaluations at equal error.

``python -m campaigns.order6.compare FILE`` measures and writes ``FILE`` (the one shipped
is ``data/measurements/order6.json``). Every method is run with the fixed point and with Newton's
method on every problem; the errors of a ladder of step numbers are found first, then the runs that
bracket each error asked for are timed in turn, round after round, so that a disturbance of the
machine meets all of them alike. Time and evaluations at the error itself are interpolated on the
log-log line through the two runs. Start and finish are counted in evaluations, not timed.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from statistics import median
from time import thread_time
from typing import Any

import numpy as np

from campaigns.driver import TIMED, arguments, carried_out, complete, record_of
from glmref.catalogue.lookup import load
from glmref.engine.kernel import Kernel, prepare
from glmref.engine.outcome import Outcome
from glmref.engine.reference import Stepper, apply_finish, stepper
from glmref.engine.starting_values import starting_values
from glmref.errors import GlmrefError
from glmref.measure.work_precision import Reference, reference_state, state_error
from glmref.method import GLM
from glmref.problems import problem
from glmref.problems.model import Problem

#: Errors at which methods are compared: relative, Euclidean, of the last state.
TARGETS = (1e-6, 1e-9)
ROUNDS = 15
#: Step numbers of a ladder grow by this factor; so many rungs at the most.
RUNG, MOST_RUNGS = math.sqrt(2.0), 18
SOLVERS = ("fixed-point", "newton")

METHODS: Mapping[str, Sequence[str]] = {
    "order 6, general linear": (
        *("g6245", "g6245-w3", "c2-3-10-w3", "s5t-w3", "s5i2-w3", "s5i1-w3", "s5i1-i", "s4-w3"),
        *("s3-w3", "s3i1-w3", "t115-i", "t115-w3", "t115a-i", "t115a-w3", "s5z-w3", "s3z"),
    ),
    "order 8, general linear": (
        *("order8-s5-w3", "order8-s5a-w3", "order8-s5q3-w3", "order8-s5i1-w3", "order8-s3-w3-i"),
        "order8-s4i2-w3-i",
    ),
    "Gauss": ("gauss-3", "gauss-4"),
    "midpoint composition": ("yoshida-6-midpoint", "triple-jump-6", "suzuki-4"),
}


@dataclass(frozen=True)
class Case:
    """One problem of the comparison."""

    name: str  #: Key of the record.
    build: Callable[[], Problem]  #: The problem.
    t_end: float  #: Final time.
    first: int  #: Step number of the first rung.
    methods: Sequence[str] = ()  #: Those compared on it; all where empty.


#: A few of each kind, for large systems: the best on the orbits, and the fewest implicit stages.
FEW = (
    *("g6245", "g6245-w3", "s5i2-w3", "s5i1-w3", "s3-w3", "order8-s3-w3-i"),
    *("gauss-3", "yoshida-6-midpoint"),
)

CASES: tuple[Case, ...] = (
    Case("kepler-0.6", lambda: problem("kepler", eccentricity="3/5"), 20 * math.pi, 500),
    Case("henon-heiles", lambda: problem("henon-heiles"), 100.0, 200),
    Case("nonseparable-chain-40", lambda: problem("nonseparable-chain", sites=20), 10.0, 25, FEW),
    Case("fput-stiff-12", lambda: problem("fput-stiff", springs=3), 20.0, 1000, FEW),
    Case("fput-stiff-80", lambda: problem("fput-stiff", springs=20), 2.0, 100, FEW),
)


@dataclass
class Run:
    """One run of a track: number of steps, error, counts, and the seconds of every round."""

    steps: int
    error: float
    evaluations: int
    factorisations: int
    seconds: list[float] = field(default_factory=list)


class Track:
    """One method with one solver on one problem: a kernel that is built once."""

    def __init__(self, name: str, solver: str, case: Case, subject: Problem) -> None:
        self.name, self.solver, self.case, self.subject = name, solver, case, subject
        method = load(name)
        assert isinstance(method, GLM)
        self.method = method
        self.engine: Stepper = stepper(method, subject)
        h = case.t_end / case.first
        self.kernel: Kernel = prepare(method, subject, h=h, solver=solver)
        self.start_evaluations = 0
        self.runs: list[Run] = []
        self._begin: dict[int, np.ndarray] = {}

    def advance(self, steps: int) -> tuple[Outcome, float, np.ndarray, Any]:
        """Take the steps; return outcome, seconds, the values at the end and the counts."""
        h, subject = self.case.t_end / steps, self.subject
        y0 = np.array(subject.y0, dtype=float)
        if steps not in self._begin:
            given = starting_values(self.engine, None, t=0.0, y0=y0, h=h)
            self._begin[steps], self.start_evaluations = given.values, given.evaluations
        slope = np.asarray(subject.f(0.0, y0), dtype=float)
        state = self.kernel.state(self._begin[steps], slope, h)
        out = np.empty((1, 1, subject.dimension))
        begin = thread_time()
        outcome, _ = self.kernel.advance(state, steps, t0=0.0, h=h, every=0, out=out)
        seconds = thread_time() - begin
        return outcome, seconds, self.kernel.values(state), state.tally

    def climb(self, reference: Reference) -> None:
        """Run the ladder until the smallest target is passed; keep the runs around each target."""
        found: list[Run] = []
        for k in range(MOST_RUNGS):
            steps = round(self.case.first * RUNG**k)
            try:
                outcome, _, values, tally = self.advance(steps)
                y, h = self.engine.solution(values), self.case.t_end / steps
                if outcome is Outcome.COMPLETED and self.method.finishing is not None:
                    y, _ = apply_finish(self.method.finishing, self.engine, self.case.t_end, y, h)
            except GlmrefError:  # start or finish has no solution at this h
                continue
            if outcome is not Outcome.COMPLETED:
                continue
            error = state_error(np.asarray(y, dtype=float), reference)
            if math.isfinite(error):
                found.append(Run(steps, error, int(tally[0]), int(tally[3])))
            if error < min(TARGETS):
                break
        kept: dict[int, Run] = {}
        for target in TARGETS:
            for one in bracket(found, target):
                kept[one.steps] = one
        self.runs = [kept[n] for n in sorted(kept)]

    def time(self) -> None:
        """Time every kept run once."""
        for run in self.runs:
            run.seconds.append(self.advance(run.steps)[1])

    def as_json(self) -> dict[str, Any]:
        """Return the record."""
        return {
            "method": self.name,
            "solver": self.solver,
            "kernel": self.kernel.description,
            "start_evaluations": self.start_evaluations,
            "runs": [
                {
                    "steps": run.steps,
                    "error": four_digits(run.error),
                    "seconds": four_digits(median(run.seconds)),
                    "evaluations_per_step": four_digits(run.evaluations / run.steps),
                    "factorisations_per_step": four_digits(run.factorisations / run.steps),
                }
                for run in self.runs
            ],
            "at": {f"{target:g}": at_error(self.runs, target) for target in TARGETS},
        }


def bracket(runs: Sequence[Run], target: float) -> tuple[Run, ...]:
    """Return the last run above a target and the first below it; empty where there are not both."""
    for before, after in pairwise(runs):
        if before.error > target >= after.error:
            return before, after
    return ()


def at_error(runs: Sequence[Run], target: float) -> dict[str, float | None] | None:
    """Return seconds, evaluations and steps at an error, interpolated; ``None`` where not met."""
    found = bracket(runs, target)
    if not found:
        return None
    first, last = found
    part = math.log(first.error / target) / math.log(first.error / last.error)

    def between(a: float, b: float) -> float | None:
        return four_digits(math.exp(math.log(a) + part * math.log(b / a)))

    return {
        "seconds": between(median(first.seconds), median(last.seconds)),
        "evaluations": between(first.evaluations, last.evaluations),
        "steps": between(first.steps, last.steps),
    }


def four_digits(value: float) -> float | None:
    """Round to four digits; ``None`` for what is not finite."""
    return float(f"{value:.4g}") if math.isfinite(value) else None


class Comparison:
    """All methods on one problem: the ladders are climbed at once, the timing is apart."""

    def __init__(self, case: Case, names: Sequence[str]) -> None:
        self.case, self.subject = case, case.build()
        end = float(self.subject.t_span[0]) + case.t_end
        self.reference = reference_state(self.subject, end)
        self.tracks = [Track(x, solver, case, self.subject) for x in names for solver in SOLVERS]
        for track in self.tracks:
            track.climb(self.reference)

    def time(self, rounds: int = ROUNDS) -> None:
        """Time every kept run so often, in turn."""
        for _ in range(rounds):
            for track in self.tracks:
                track.time()

    def as_json(self) -> dict[str, Any]:
        """Return the record."""
        return {
            "case": self.case.name,
            "problem": self.subject.name,
            "dimension": self.subject.dimension,
            "t_end": self.case.t_end,
            "reference": {"kind": self.reference.kind, "error": four_digits(self.reference.error)},
            "tracks": [track.as_json() for track in self.tracks],
        }


def main(path: Path) -> None:
    """Measure all cases and write the file."""
    names = [name for group in METHODS.values() for name in group]
    cases = [{"case": case.name, "methods": list(case.methods or names)} for case in CASES]
    found = carried_out(row, cases, beside=path, limits=TIMED)
    title = "Order 6 and 8: seconds and evaluations at equal error"
    about = {"seconds": "processor time, medians of interleaved rounds", "rounds": ROUNDS}
    complete(path, record_of("order6.compare", "order6", title, **about, cases=found))


def row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Compare and time the methods on a case of this name."""
    (case,) = (case for case in CASES if case.name == task["case"])
    found = Comparison(case, task["methods"])
    found.time()
    return found.as_json()


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
