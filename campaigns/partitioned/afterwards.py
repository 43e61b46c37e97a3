"""The methods for every Hamiltonian on systems that were written down after the last was chosen.

    python -m campaigns.partitioned.afterwards data/measurements/nonseparable.json

The record has the systems themselves, under ``afterwards``: nothing was chosen on them.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete
from campaigns.partitioned.extended import TOLERANCES
from campaigns.partitioned.loosened import METHODS as GAUSS
from campaigns.partitioned.nonseparable import LONG, METHODS
from campaigns.partitioned.semi_separable import end_of, long_run, needed, step_of
from glmref.catalogue.lookup import load
from glmref.measure.peers import runner
from glmref.measure.work_precision import reference_state, state_error
from glmref.problems.model import Problem

#: The code that chooses its steps, and its tolerances: four in a decade.
RIVAL = "scipy-dop853"
_TOLERANCES = 10.0 ** -np.arange(3, 14, 0.25)
#: Steps of the first run: Gauss methods need few for 1e-6.
_STEPS = 20


def system(case: Mapping[str, Any]) -> Problem:
    """Return the problem of a row."""
    names = ("coordinates", "momenta")
    options = {key: case[key].split() for key in names}
    return Problem.from_hamiltonian(case["H"], case["y0"], name=case["problem"], **options)


def rival(one: Problem) -> dict[float, int | None]:
    """Return the least evaluations of the rival for each tolerance of the last state."""
    end = end_of(one)
    exact, times = reference_state(one, end), np.array([end])
    runs = [runner(RIVAL, one, tolerance=x, times=times)() for x in _TOLERANCES]
    found = [(x.evaluations or 0, state_error(x.y[-1], exact)) for x in runs if len(x.y)]
    return {
        tolerance: min((n for n, error in found if error < tolerance), default=None)
        for tolerance in TOLERANCES
    }


def row(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return evaluations for the tolerances, and what long runs at the step of the least keep."""
    one, peer = system(case), rival(system(case))
    evaluations: dict[str, dict[str, int | None]] = {}
    for tolerance in TOLERANCES:
        found = {
            name: needed(load(name), one, tolerance, steps=_STEPS) for name in (*METHODS, *GAUSS)
        }
        counts = {name: x and x[1] for name, x in found.items()}
        evaluations[f"{tolerance:g}"] = {**counts, RIVAL: peer[tolerance]}
    long = []
    for name in METHODS:
        if (step := step_of(load(name), one)) is not None:
            for renew, steps in LONG.items():
                kept = long_run(name, one, step[0], steps, renew)
                long.append({"method": name, "h": step[0], "renew": renew, **kept})
    return {**case, "evaluations": evaluations, "long": long}


def main(path: Path) -> None:
    """Measure the systems of the record again, and write them into it."""
    record = json.loads(path.read_text(encoding="utf-8"))
    keys = ("problem", "H", "coordinates", "momenta", "y0")
    cases = [{key: x[key] for key in keys} for x in record["afterwards"]]
    record["afterwards"] = carried_out(row, cases, beside=path)
    complete(path, record)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
