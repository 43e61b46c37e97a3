"""Ten million steps with every method of order 6 and 8: energy and parasitic part, bounded or not.

``python -m campaigns.order6.long_runs FILE`` runs and writes ``FILE`` (the one shipped is
``data/measurements/long-runs.json``). The parasitic part of the values is what they lack to the
start of their own solution: ``values - S(F(y_1))`` with the start S and the finish F of the file,
which is blind to nothing above O(h^(p+1)).

A method with growth parameters 0 may still grow at second order in h: the parasitic component then
grows as exp(c h^2 t) on some solutions. That rate is measured apart, on runs whose start is nudged
by :data:`NUDGE`, so that the parasitic part stands out from the first step on. For one method it is
scanned over h and the size of the nudge (:func:`scan_rate`).
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from campaigns.order6.compare import METHODS, four_digits
from glmref.catalogue.lookup import load
from glmref.compute.records import in_json
from glmref.engine.outcome import Solution
from glmref.engine.reference import Stepper, apply_finish, apply_start, stepper
from glmref.errors import GlmrefError
from glmref.measure.longtime import along, follow
from glmref.method import GLM
from glmref.problems import problem
from glmref.problems.model import Problem

STEPS = 10_000_000
#: Samples of each stretch at which the parasitic part is formed.
LOOKS = 40
#: A quantity is bounded when the last half of a run exceeds what its first hundredth shows at the
#: most by this factor. Growth is exponential where there is any: it passes the factor or is not
#: there; and a chaotic solution visits other parts of its energy surface, which takes a few.
FACTOR = 30.0

#: Size of the nudge that makes a parasitic part visible, and steps of the nudged runs.
NUDGE, NUDGED_STEPS = 1e-6, 2_000_000

#: Method, run, and (h, nudge) of the scan of rates.
SCANNED = ("g6245-w3", "pendulum-2.3")
SCAN = (
    *((h, NUDGE) for h in (0.2, 0.16, 0.13, 0.1, 0.08, 0.05)),
    *((0.1, nudge) for nudge in (1e-7, 1e-5)),
)

RUNS: Mapping[str, Callable[[], Problem]] = {
    "pendulum-2.3": lambda: problem("pendulum", q0="23/10"),
    "henon-heiles": lambda: problem("henon-heiles"),
}


@dataclass(frozen=True)
class LongRun:
    """What a long run showed."""

    #: What was run.
    method: str
    run: str
    h: float  #: Step size.
    steps: int  #: completed.
    outcome: str  #: By name.
    energy: float  #: Largest relative error of H.
    energy_early: float  #: The same in the first hundredth.
    #: Largest Euclidean norm of the parasitic part, relative to y_0; parasitic_early.
    parasitic: float
    parasitic_early: float
    bounded: bool  #: Whether both stay within :data:`FACTOR` of their early size.
    #: Time at which the parasitic part first exceeds FACTOR times its early size.
    lost: float | None
    #: Exponential rate of growth of a nudged parasitic part, for each unit of time.
    rate: float | None = None


def parasitic_part(engine: Stepper, values: np.ndarray, h: float) -> tuple[np.ndarray, float]:
    """Return the finished solution (d,) and norm of ``values - S(F(y_1))`` for values (r, d)."""
    method = engine.method
    y = engine.solution(values)
    with np.errstate(all="ignore"):
        try:
            if method.finishing is not None:
                y, _ = apply_finish(method.finishing, engine, 0.0, y, h)
            assert method.starting is not None
            ideal, _ = apply_start(method.starting, engine, 0.0, y, h)
        except (ArithmeticError, GlmrefError):  # coupled stages without solution: far from all
            return y, math.inf
        size = float(np.linalg.norm(values[1:] - ideal[1:]))
    return y, size if math.isfinite(size) else math.inf


def long_run(name: str, run: str, *, h: float = 0.1, steps: int = STEPS) -> LongRun:
    """Run one method on one of :data:`RUNS`."""
    subject, method = RUNS[run](), load(name)
    assert isinstance(method, GLM)
    engine = stepper(method, subject)
    unit = float(np.linalg.norm(np.array(subject.y0, dtype=float)))
    bare = replace(method, finishing=None)  # every row finished would cost more than the run
    solution = follow(subject, bare, h=h, steps=steps, lost=lambda part: _gone(part, unit))
    assert subject.hamiltonian is not None
    at = _looks(len(solution.t))
    t = np.asarray(solution.t, dtype=float)[at]
    looks = [parasitic_part(engine, np.asarray(solution.history)[k], h) for k in at]
    rest = np.array([size for _, size in looks]) / unit
    energy = along(subject.hamiltonian, np.array([y for y, _ in looks], dtype=float))
    energy = np.abs(energy / energy[0] - 1)
    early = t <= t[0] + h * steps / 100
    rest_early, energy_early = float(rest[early].max()), float(energy[early].max())
    over = np.flatnonzero(~(rest < FACTOR * rest_early))
    largest = float(np.max(np.where(np.isfinite(energy), energy, math.inf)))
    return LongRun(
        method=name,
        run=run,
        h=h,
        steps=solution.steps,
        outcome=str(solution.outcome),
        energy=largest,
        energy_early=energy_early,
        parasitic=float(rest.max()),
        parasitic_early=rest_early,
        bounded=solution.completed and not len(over) and largest < FACTOR * energy_early,
        lost=float(t[over[0]]) if len(over) else None,
    )


def growth_rate(
    name: str, run: str, *, h: float = 0.1, steps: int = NUDGED_STEPS, nudge: float = NUDGE
) -> float:
    """Return the rate at which a nudged parasitic part grows over the second half of a run.

    The largest parts seen in the tenths of the run before the middle and before the end are
    compared; what does not grow gives a rate of either sign of the order of 1/(t h steps).
    """
    subject, method = RUNS[run](), load(name)
    assert isinstance(method, GLM) and method.starting is not None
    engine, y0 = stepper(method, subject), np.array(subject.y0, dtype=float)
    values, _ = apply_start(method.starting, engine, 0.0, y0, h)
    shift = np.random.default_rng(1).standard_normal(values[1:].shape)
    values[1:] += nudge * shift / np.linalg.norm(shift)
    bare = replace(method, finishing=None)
    solution = follow(subject, bare, h=h, steps=steps, start=values)
    t = np.asarray(solution.t, dtype=float)
    sizes = []
    for end in (0.5, 1.0):
        rows = np.flatnonzero((t > (end - 0.1) * h * steps) & (t <= end * h * steps))
        looks = rows[:: max(1, len(rows) // LOOKS)]
        parts = (parasitic_part(engine, np.asarray(solution.history)[k], h)[1] for k in looks)
        sizes.append(max(parts, default=math.inf))
    if not solution.completed or not all(map(math.isfinite, sizes)):
        return math.inf
    return math.log(sizes[1] / sizes[0]) / (0.5 * h * steps)


def scan_rate(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the rate of :data:`SCANNED` at an h and a nudge of :data:`SCAN`.

    The number of steps goes with h^-3: with a rate proportional to h^2 every run then sees its
    parasitic part grow by the same factor, and each rate is known equally well.
    """
    name, run = SCANNED
    h, nudge = case["h"], case["nudge"]
    steps = round(NUDGED_STEPS * (0.1 / h) ** 3)
    rate = four_digits(growth_rate(name, run, h=h, steps=steps, nudge=nudge))
    return {"method": name, "run": run, "h": h, "steps": steps, "nudge": nudge, "rate": rate}


def _looks(rows: int) -> list[int]:
    """Return row numbers at which to form the parasitic part: spread as samples, in stretches."""
    step = max(1, rows // (14 * LOOKS))
    return sorted({*range(0, rows, step), rows - 1})


def _gone(part: Solution, unit: float) -> bool:
    """Return whether the values have left every bound, so that going on shows nothing."""
    values = np.asarray(part.values)
    return not bool(np.isfinite(values).all()) or float(np.linalg.norm(values[1:])) > 10 * unit


def row(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return one run of one method, with the rate at which its parasitic part grows."""
    name, run = case["method"], case["run"]
    return in_json(replace(long_run(name, run), rate=growth_rate(name, run)), four_digits)


def main(path: Path) -> None:
    """Run everything and write the file."""
    groups = ("order 6, general linear", "order 8, general linear")
    names = [name for group in groups for name in METHODS[group]]
    cases = ({"run": run, "method": x} for run in RUNS for x in names)
    runs = carried_out(row, cases, beside=path)
    scan = carried_out(scan_rate, ({"h": h, "nudge": nudge} for h, nudge in SCAN), beside=path)
    title = "Ten million steps of h = 0.1 with the methods of order 6 and 8"
    about = {"factor": FACTOR, "nudge": NUDGE, "nudged_steps": NUDGED_STEPS}
    record = record_of("order6.long_runs", "long-runs", title, **about, runs=runs, scan=scan)
    complete(path, record)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
