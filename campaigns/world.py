"""Time that methods of the catalogue and other people's integrators need for an error of 1e-9.

Eight problems over two horizons. The error is that of the last state for the short horizon and that
of the energy, the largest of 64 samples, for the long one. A peer gets the first tolerance of a
grid, two to a decade, that reaches the goal; a method the number of steps from which the error
stays below it (:mod:`campaigns.partitioned.work`).

    python -m campaigns.world data/measurements/world.json

Peers: heyoka, IAS15 of rebound (gravitating bodies only), DOP853 of scipy, CVODE of SUNDIALS with
Adams formulas through scikit-sundae. heyoka and rebound are compiled, DOP853 and CVODE call a
function of numpy arrays, whose time is most of theirs: compare their evaluations.
"""

from __future__ import annotations

import math
import sys
from collections import Counter
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from itertools import islice
from pathlib import Path
from time import process_time
from typing import Any

import numpy as np

from campaigns.driver import TIMED, arguments, carried_out, complete, record_of, three_digits
from campaigns.pages import markdown
from campaigns.partitioned.error_front import twin
from campaigns.partitioned.work import Case, case_of, need_row, per_step, task_of
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.peers import measure_peer, runner

GOAL = 1e-9
METHODS = (
    *("multistep-rkn-12", "multistep-rkn-10", "multivalue-rkn-12", "multivalue-rkn-10"),
    *("multistep-8", "quinlan-tremaine-12"),
    *("pair-rkn-6-8b", "blanes-moan-rkn-6-14"),
)
#: Peers, and the packages whose versions are recorded.
PEERS: Mapping[str, str] = {
    "heyoka": "heyoka",
    "rebound-ias15": "rebound",
    "scipy-dop853": "scipy",
    "cvode-adams": "scikit-sundae",
}
#: Tolerances that are tried; the tolerance of IAS15 is of another kind and begins larger.
TOLERANCES = tuple(10 ** (-k / 2) for k in range(17, 31))
TIME_NOTE = (
    "The time of a step is that of 4,000 steps, the start not counted, the least of five runs of "
    "the compiled engine. Published symmetric multistep methods are timed in the one-step form of "
    "the new ones, for which there is the shorter kernel."
)
#: Steps of a run that is timed, and how many of them.
STEPS, RUNS = 4_000, 5
_PERIOD = 2 * math.pi
_E2, _E6 = (("eccentricity", "1/5"),), (("eccentricity", "3/5"),)


def _both(
    problem: str,
    t_end: float,
    longer: float,
    least: int,
    parameters: tuple[tuple[str, str], ...] = (),
    name: str = "",
) -> list[Case]:
    """Return a short and a long case; the fewest evaluations of the long one in proportion."""
    name = name or problem
    more = round(least * longer / t_end)
    return [
        Case(name, problem, t_end, least, parameters),
        Case(f"{name}, long", problem, longer, more, parameters, measure="energy"),
    ]


CASES = (
    *_both("kepler", 10 * _PERIOD, 100 * _PERIOD, 600, _E2, "kepler 0.2"),
    *_both("kepler", 10 * _PERIOD, 100 * _PERIOD, 1800, _E6, "kepler 0.6"),
    *_both("henon-heiles", 50.0, 500.0, 300),
    *_both("pendulum", 50.0, 500.0, 300),
    *_both("toda", 50.0, 500.0, 500),
    *_both("fput", 200.0, 1000.0, 400),
    *_both("figure-eight", 20.0, 100.0, 400),
    *_both("outer-solar-system", 200_000.0, 1_000_000.0, 1000),
)


def _peer(name: str, case: Case) -> dict[str, Any] | None:
    """Return the first run of a peer that reaches the goal.

    The result is ``None`` where it cannot take the problem.
    """
    found: dict[str, Any] = {}
    for tolerance in TOLERANCES:
        try:
            found = measure_peer(
                name, case.built(), tolerance=tolerance, t_end=case.t_end, ask=(case.measure,),
                repeats=1,
            )  # fmt: skip
        except UsageError:
            return None
        error = found.get(f"{case.measure}_error")
        if error is not None and error < GOAL:
            return {
                "method": name,
                "tolerance": three_digits(tolerance),
                "evaluations": found["evaluations"],
                "seconds": three_digits(_spent(name, case, tolerance)),
            }
    return {"method": name, "tolerance": None, "evaluations": None, "seconds": None}


def _spent(name: str, case: Case, tolerance: float) -> float:
    """Return the processor time of a run to the end, the least of three."""
    target = case.built()
    end = np.array([float(target.t_span[0]) + case.t_end])
    run = runner(name, target, tolerance=tolerance, times=end)
    samples = []
    for _ in range(3):
        begun = process_time()
        run()
        samples.append(process_time() - begun)
    return min(samples)


def peer_row(task: Mapping[str, Any]) -> dict[str, Any] | None:
    """Measure a peer on a case in JSON."""
    return _peer(task["peer"], case_of(task))


def run_seconds(task: Mapping[str, Any]) -> float | None:
    """Return the time of a run of a method on a case with so many steps, its start not counted.

    By short runs, and the least of them: what else the machine does falls between them. ``None``
    where they are lost at once.
    """
    case, (name,), steps = case_of(task), task["methods"], task["steps"]
    options = {"h": case.t_end / steps, "steps": STEPS, "every": STEPS}
    runs = [solve(case.built(), twin(name), **options) for _ in range(RUNS)]
    if min(run.steps for run in runs) < STEPS // 4:
        return None
    return three_digits(steps * min(run.seconds / run.steps for run in runs))


def main(path: Path, cases: Sequence[Case] = CASES) -> None:
    """Count the evaluations of methods, time these and the peers, and write the file."""
    title = "Methods of the catalogue and other people's integrators at an error of 1e-9"
    about = " ".join((__doc__ or "").split("\n\n")[1].split())
    record = record_of("world", "world", title, about, TIME_NOTE, cases=[])
    record["where"]["versions"] |= {x: version(x) for x in PEERS.values()}
    pairs = [(case, name) for case in cases for name in METHODS]
    needed = carried_out(need_row, (task_of(case, name) for case, name in pairs), beside=path)
    counts = [row[0]["needed"].get(f"{GOAL:.0e}") for row in needed]
    tasks = (
        {**task_of(case, name), "steps": count / per_step(name)}
        for (case, name), count in zip(pairs, counts, strict=True)
        if count
    )
    seconds = iter(carried_out(run_seconds, tasks, beside=path, limits=TIMED))
    rows = iter(
        [
            {
                "method": name,
                "evaluations": count,
                "seconds": next(seconds) if count else None,
            }
            for (_, name), count in zip(pairs, counts, strict=True)
        ]
    )
    others = ({**task_of(case), "peer": name} for case in cases for name in PEERS)
    peers = iter(carried_out(peer_row, others, beside=path, limits=TIMED))
    for case in cases:
        found = [*islice(rows, len(METHODS)), *filter(None, islice(peers, len(PEERS)))]
        record["cases"].append(
            {"case": case.name, "time": case.t_end, "measure": case.measure, "methods": found}
        )
    complete(path, record)


def _best(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the row of the least time."""
    return min(rows, key=lambda x: math.inf if x["seconds"] is None else x["seconds"])


def winners(document: Mapping[str, Any]) -> dict[str, int]:
    """Count in how many cases each is the fastest."""
    return dict(Counter(_best(entry["methods"])["method"] for entry in document["cases"]))


def table(document: Mapping[str, Any]) -> str:
    """Tabulate milliseconds, in brackets evaluations; the fastest of a case is bold."""
    names = [*METHODS, *PEERS]
    rows = []
    for entry in document["cases"]:
        known, best = {x["method"]: x for x in entry["methods"]}, _best(entry["methods"])
        cells = [entry["case"]]
        for name in names:
            row = known.get(name)
            if row is None or row["seconds"] is None:
                cells.append("-" if row is None else "not reached")
                continue
            shown = f"{1e3 * row['seconds']:.3g}"
            count = f" ({row['evaluations']:,})" if row["evaluations"] else ""
            cells.append((f"**{shown}**" if row is best else shown) + count)
        rows.append(cells)
    return markdown(["case", *names], rows)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
