"""A hundred million steps of the pendulum: time, memory, and the law of the energy error.

    python -m campaigns.pendulum data/measurements/pendulum-1e8.json

Samples thin out as the run goes on (:func:`.longtime.follow`), so that memory grows with the
logarithm of the number of steps. The peak of the process's memory is read after the first hundredth
of the steps and again at the end: the difference is what the rest of the run took.

All values are kept after 1000 * 4^k steps and at the end. These *checkpoints* are ends of
stretches, which do not depend on the length of the run: a shorter run passes through the same.
"""

from __future__ import annotations

import math
import resource
import sys
from collections.abc import Mapping
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from campaigns.driver import TIMED, arguments, carried_out, complete, record_of
from glmref.catalogue.lookup import load
from glmref.measure.law import fit_law, samples_of
from glmref.measure.longtime import ROWS, follow
from glmref.measure.parasitic import parasitic_size, solution_direction
from glmref.problems import problem

STEPS = 10**8
RUNS = (("g6245", 0.05), ("g6245", 0.1), ("g6245-w3", 0.1), ("gauss-3", 0.1), ("rk4", 0.1))
ANGLE = "23/10"
#: Step numbers of the checkpoints: ends of stretches of a run that is longer.
CHECKPOINTS = tuple(ROWS * 4**k for k in range(20))


def long_run(name: str, *, steps: int, h: float) -> dict[str, Any]:
    """Run one method for many steps and say how its energy fared, as a record.

    It has outcome, seconds, memory, law of the energy deviation, and the root mean square of the
    deviation over each doubling of time, with the size of the values beyond the solution where
    there are any; and the values (r, d) at the checkpoints.
    """
    subject, method = problem("pendulum", q0=ANGLE), load(name)
    follow(subject, method, h=h, steps=max(1, steps // 100))
    before, wall, busy = _peak(), perf_counter(), process_time()
    run = follow(subject, method, h=h, steps=steps)
    wall, busy = perf_counter() - wall, process_time() - busy
    t = np.asarray(run.t, dtype=float)
    deviation = samples_of(subject, method, run, "energy")
    law = fit_law(t, deviation, ended=not run.completed)
    return {
        "method": name,
        "problem": "pendulum",
        "q0": ANGLE,
        "h": h,
        "steps": run.steps,
        "outcome": str(run.outcome),
        "kernel": run.kernel,
        "evaluations": run.evaluations,
        "seconds": {"wall": round(wall, 1), "process": round(busy, 1)},
        "peak_memory_mb": {"after 1 per cent": round(before, 1), "at the end": round(_peak(), 1)},
        "samples": len(t),
        "law": law.as_json(),
        "doublings": _doublings(t, deviation, _rest(method, run)),
        "checkpoints": _checkpoints(np.rint(t / h), np.asarray(run.history), steps),
    }


def _checkpoints(taken: np.ndarray, history: np.ndarray, steps: int) -> list[dict[str, Any]]:
    """Return all values after each number of steps in :data:`CHECKPOINTS`, and at the end."""
    kept = [n for n in CHECKPOINTS if n < steps] + [steps]
    rows = ((n, history[np.flatnonzero(taken == n)]) for n in kept)
    return [
        {"steps": n, "values": found[0].tolist()}
        for n, found in rows
        if len(found) and np.isfinite(found).all()
    ]


def _peak() -> float:
    """Return the largest resident memory of this process so far, in MB; Linux counts it in kB."""
    unit = 1e6 if sys.platform == "darwin" else 1e3
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / unit


def _rest(method: Any, run: Any) -> np.ndarray:
    """Return the size of the values beyond the solution at every sample.

    It is zero where there are none.
    """
    if method.r == 1:
        return np.zeros(len(run.t))
    return parasitic_size(run, solution_direction(method))


def _doublings(t: np.ndarray, deviation: np.ndarray, rest: np.ndarray) -> list[dict[str, float]]:
    """Return deviation and size of the values beyond the solution over T/2 .. T, T = t_end/2^k."""
    rows, end = [], float(t[-1])
    while end >= float(t[-1]) / 2**20:
        inside = (t > end / 2) & (t <= end)
        part = deviation[inside]
        if len(part) >= 32 and np.isfinite(part).all():
            rms = float(np.sqrt(np.mean(part**2)))
            largest, mean = float(np.max(np.abs(part))), float(np.mean(part))
            beyond = float(np.max(rest[inside]))
            row = {"t": end, "rms": rms, "mean": mean, "largest": largest, "beyond": beyond}
            rows.append(row)
        end /= 2
    return rows[::-1]


def row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Carry out :func:`long_run` for a task in JSON."""
    return long_run(task["method"], steps=task["steps"], h=task["h"])


NOTE = (
    "Relative energy error |H - H0|/|H0| at samples that thin out with time; law: exponent of the "
    "rms over dyadic stretches."
)


def main(path: Path) -> None:
    """Measure and write the file."""
    tasks = ({"method": name, "h": h, "steps": STEPS} for name, h in RUNS)
    runs = carried_out(row, tasks, beside=path, limits=TIMED)
    title = f"Pendulum from {ANGLE} radians, {STEPS:,} steps: energy, time, memory"
    complete(path, record_of("pendulum", "pendulum-1e8", title, NOTE, runs=runs))
    for run in runs:
        exponent = run["law"]["exponent"]
        said = "-" if exponent is None or math.isnan(exponent) else f"{exponent:.2f}"
        sys.stdout.write(f"{run['method']}, h = {run['h']}: {run['law']['kind']}, t^{said}\n")


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
