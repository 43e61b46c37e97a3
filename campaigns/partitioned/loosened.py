"""Gauss methods whose fixed-point rounds end early: evaluations saved, and energy lost.

    python -m campaigns.partitioned.loosened data/measurements/nonseparable.json

Rounds end where the next change of the stages, as the last two predict it, is below a part of the
tolerance: ``arithmetic="quick"`` with :data:`.options.QUICK` at that part instead of rounding.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Sequence
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any
from unittest import mock

from campaigns.driver import arguments, complete
from campaigns.partitioned.extended import ends
from campaigns.partitioned.work import crossing
from glmref import solve
from glmref.engine import options
from glmref.measure.work_precision import energy_error, reference_state, state_error
from glmref.problems import problem

METHODS = ("gauss-3", "gauss-4", "gauss-5", "gauss-6")
#: Parts of the tolerance at which rounds end, of which the best counts.
PARTS = (1e-3, 1e-4, 1e-5)
#: Steps of the runs whose energy is compared.
STEPS = 100_000
#: Steps of the first run, most steps, and the factor between two runs.
_FIRST, _MOST, _FACTOR = 20, 4_000, 1.22


def ended_at(change: float) -> AbstractContextManager[object]:
    """End quick rounds at a predicted change, relative to the state."""
    return mock.patch.object(options, "QUICK", change)


def reached(curve: Sequence[tuple[int, float]], tolerance: float) -> bool:
    """Return whether the last two of (evaluations, error) are below the tolerance."""
    return len(curve) > 1 and all(error < tolerance for _, error in curve[-2:])


def needed(name: str, method: str, tolerance: float) -> tuple[int, int, float] | None:
    """Return evaluations and steps for a tolerance, and which of :data:`PARTS` needs least."""
    one, end, found = problem(name), ends()[name], []
    exact = reference_state(one, end)
    for part in PARTS:
        curve, taken = [], [_FIRST]
        with ended_at(part * tolerance):
            while taken[-1] <= _MOST and not reached(curve, tolerance):
                n = taken[-1]
                run = solve(one, method, arithmetic="quick", h=end / n, steps=n, every=n)
                error = state_error(run.y[-1], exact) if run.completed else math.inf
                curve.append((run.evaluations, error))
                taken.append(math.ceil(n * _FACTOR))
        if reached(curve, tolerance) and (count := crossing(curve, tolerance)):
            found.append((round(count), taken[-3], part))
    return min(found, default=None)


def energies(name: str, method: str, steps: int, change: float) -> dict[str, float]:
    """Return the largest energy errors at 1,000 samples: rounds to rounding, and to a change."""
    one, h = problem(name), ends()[name] / steps

    def error(arithmetic: str) -> float:
        run = solve(one, method, arithmetic=arithmetic, h=h, steps=STEPS, every=STEPS // 1000)
        return float(f"{energy_error(one, run):.2g}")

    full = error("strict")
    with ended_at(change):
        return {"energy": full, "energy_loosened": error("quick")}


def row(name: str, tolerance: float) -> dict[str, Any]:
    """Return evaluations of the methods, and what the best one does to the energy."""
    found = {m: n for m in METHODS if (n := needed(name, m, tolerance))}
    best = min(found, key=lambda m: found[m][0])
    counts = {m: n for m, (n, *_) in found.items()}
    _, steps, part = found[best]
    head = {"problem": name, "tolerance": tolerance, "methods": counts, "best": best}
    return head | energies(name, best, steps, part * tolerance)


def main(path: Path) -> None:
    """Measure on the problems of the record, and write them into it."""
    record = json.loads(path.read_text(encoding="utf-8"))
    cases = [(x["problem"], x["tolerance"]) for x in record["evaluations"]]
    record["loosened"] = [row(*x) for x in cases]
    complete(path, record)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
