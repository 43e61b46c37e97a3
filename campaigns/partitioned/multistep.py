"""Multistep methods in one-step form against pairs and splittings: evaluations, long runs, holes.

    python -m campaigns.partitioned.multistep data/measurements/multistep.json
    python -m campaigns.partitioned.multistep long data/measurements/multistep-long.json
    python -m campaigns.partitioned.multistep resonances data/measurements/multistep-resonances.json

The first counts force evaluations as :mod:`.work` does, each multistep method from its own start;
the second follows 10^7 steps as :mod:`.long_runs` does; the third runs 4,000 step sizes up to the
end of the periodicity interval.

Public names::

    ROWS, evaluations(path), table(document, tolerance) -> str
    LONG, long_runs(path), long_table(document) -> str
    scan(name, case, sizes, steps) -> Scan, resonances(path), scan_table(document) -> str
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.partitioned.long_runs import EVERY, Case, three_digits
from campaigns.partitioned.long_runs import follow_at as follow
from campaigns.partitioned.work import CASES, needs
from glmref.catalogue.lookup import load, names
from glmref.catalogue.strict_json import write_json
from glmref.derive.recipes.multistep import SHIPPED
from glmref.engine.solve import solve
from glmref.measure.longtime import along
from glmref.measure.timing import circumstances
from glmref.method import Method
from glmref.problems import problem
from glmref.theory.periodicity import periodicity

__all__ = [
    "LONG",
    "ROWS",
    "Scan",
    "evaluations",
    "long_runs",
    "long_table",
    "resonances",
    "scan",
    "scan_table",
    "table",
]

#: What is compared, by group: the columns of the table are the best of each group.
ROWS: Mapping[str, Sequence[str]] = {
    "splitting": ("blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14", "kahan-li-8"),
    "pair": ("pair-6-8", "pair-rkn-6-7b", "pair-rkn-6-8b"),
    "published multistep": (
        *("quinlan-tremaine-8", "quinlan-tremaine-10", "quinlan-tremaine-12"),
        *("quinlan-tremaine-14", "quinlan-8a", "quinlan-8b"),
    ),
    "new, separable": tuple(x for x in SHIPPED if "rkn" not in x),
    "new, second-order": tuple(x for x in SHIPPED if "rkn" in x),
}


#: Cases of :mod:`.work` that are not measured: one does not discriminate, three take an hour.
LEFT_OUT = ("n-body", "fput-stiff", "outer-solar-system-long", "pendulum-long")


def rows() -> dict[str, list[str]]:
    """:data:`ROWS` as far as the catalogue has them."""
    known = set(names("methods"))
    return {group: [x for x in methods if x in known] for group, methods in ROWS.items()}


def _record(name: str, title: str, how: str, notes: Sequence[str]) -> dict[str, Any]:
    return {
        "format": "glmref-measurement-1",
        "name": name,
        "title": title,
        "how": how,
        "notes": list(notes),
        "circumstances": circumstances(),
    }


# --- evaluations ----------------------------------------------------------------------------------

NOTE = (
    "needed: force evaluations of the steps from which the error stays below the tolerance, "
    "interpolated between step sizes a third of an octave apart; start_evaluations come on top. "
    "Multistep methods start from the starting method of their file, pairs from zero values."
)


def evaluations(path: Path) -> None:
    """Count for all cases and methods, and write the file after each case."""
    record = _record(
        "multistep",
        "Force evaluations that multistep methods, pairs and splittings need",
        "python -m campaigns.partitioned.multistep FILE",
        [NOTE],
    )
    record["groups"] = rows()
    record["cases"] = []
    for case in (x for x in CASES if x.name not in LEFT_OUT):
        found = needs(case, [x for group in rows().values() for x in group])
        record["cases"].append(
            {
                "case": case.name,
                "measure": case.measure,
                "methods": [
                    {
                        "method": need.method,
                        "start_evaluations": need.start_evaluations,
                        "needed": {f"{t:.0e}": round(n) for t, n in need.needed.items()},
                    }
                    for need in found
                    if need.start != "enhanced"
                ],
            }
        )
        write_json(path, record)


def needed(entry: Mapping[str, Any], methods: Sequence[str], tolerance: str) -> tuple[str, float]:
    """The method of some that needs fewest evaluations in a case, and how many; infinity: none."""
    found = {
        x["method"]: x["needed"].get(tolerance, math.inf)
        for x in entry["methods"]
        if x["method"] in methods
    }
    best = min(found, key=lambda x: found[x])
    return best, found[best]


def table(document: Mapping[str, Any], tolerance: str) -> str:
    """The best of each group, case by case, in Markdown; the last line holds geometric means."""
    groups = document["groups"]
    rivals = [x for key, methods in groups.items() if not key.startswith("new") for x in methods]
    new = [x for key, methods in groups.items() if key.startswith("new") for x in methods]
    head = ["case", *(f"best {key}" for key in groups), "new / best other"]
    lines = [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    ratios: list[float] = []
    for entry in document["cases"]:
        cells = [entry["case"]]
        for methods in groups.values():
            name, count = needed(entry, methods, tolerance)
            cells.append(f"{count:,.0f} ({name})" if math.isfinite(count) else "-")
        mine, theirs = (needed(entry, x, tolerance)[1] for x in (new, rivals))
        if math.isfinite(mine) and math.isfinite(theirs):
            ratios.append(mine / theirs)
        cells.append(f"{mine / theirs:.2f}" if math.isfinite(mine) else "-")
        lines.append(f"| {' | '.join(cells)} |")
    mean = math.exp(math.fsum(map(math.log, ratios)) / len(ratios))
    lines.append(f"| geometric mean |{' |' * len(groups)} {mean:.2f} |")
    return "\n".join(lines) + "\n"


# --- long runs ------------------------------------------------------------------------------------

#: Problems and step sizes, about what an energy error of 1e-9 asks for.
LONG = (
    Case("pendulum", 0.064, (("q0", "5/2"),)),
    Case("henon-heiles", 0.08),
    Case("kepler", 0.04, (("eccentricity", "1/10"),)),
    Case("kepler", 0.024, (("eccentricity", "3/10"),)),
    Case("kepler", 0.0096, (("eccentricity", "3/5"),)),
    Case("toda", 0.04, (("sites", "16"),)),
    Case("outer-solar-system", 40.0),
)
LONG_NOTE = (
    f"Largest relative energy error up to each mark, sampled every {EVERY} steps, and largest "
    "entry of the values carried beyond the first; from the starting method of the file; bounded: "
    "neither grows by more than a factor 10 in the last two decades."
)


def long_runs(path: Path, steps: int = 10_000_000, cases: Sequence[Case] = LONG) -> None:
    """Follow every new method on every case, and write the file after each run."""
    record = _record(
        "multistep-long",
        "Multistep methods in one-step form over ten million steps",
        "python -m campaigns.partitioned.multistep long FILE",
        [LONG_NOTE],
    )
    record["runs"] = []
    for name in SHIPPED:
        for case in cases:
            run = follow(name, case, case.per_evaluation, steps).as_json()
            record["runs"].append({**run, "parameters": dict(case.parameters)})
            write_json(path, record)


def long_table(document: Mapping[str, Any]) -> str:
    """Energy errors after 10^5, 10^6 and 10^7 steps, in Markdown."""
    lines = ["| method | problem | h | $10^5$ | $10^6$ | $10^7$ | bounded |", "|---" * 7 + "|"]
    for run in document["runs"]:
        what = ", ".join([run["problem"], *(f"{k} = {v}" for k, v in run["parameters"].items())])
        cells = ["not finite" if x is None else f"{x:.1e}" for x in run["energy"][-3:]]
        verdict = "yes" if run["bounded"] else "no"
        lines.append(
            f"| `{run['method']}` | {what} | {run['h']:g} | {' | '.join(cells)} | {verdict} |"
        )
    return "\n".join(lines) + "\n"


# --- resonances -----------------------------------------------------------------------------------


@dataclass(frozen=True)
class Scan:
    """Energy errors at many step sizes.

    Attributes
    ----------
    sizes : tuple[float, ...]
        Step sizes.
    errors : tuple[float, ...]
        Largest relative energy error of each run. floor: the running minimum of the errors at
        larger step sizes, what the order leaves to expect.
    holes : tuple[float, ...]
        Step sizes whose error exceeds a hundred times the largest of the next smaller ones that is
        not a hole itself, or whose run is lost.
    """

    sizes: tuple[float, ...]
    errors: tuple[float, ...]
    holes: tuple[float, ...]


def scan(method: Method, case: Case, sizes: Sequence[float], steps: int) -> Scan:
    """Run all step sizes, small to large, and mark those where the error leaps.

    A hole is a step size whose error is more than a hundred times the median of the twenty regular
    step sizes before it. From the first step size on after which nothing is regular the order is
    lost, and nothing is called a hole.
    """
    target = problem(case.problem, **dict(case.parameters))
    errors: list[float] = []
    for h in sizes:
        run = solve(target, method, h=float(h), steps=steps, every=max(1, steps // 64))
        energy = along(target.hamiltonian, run.y)  # type: ignore[arg-type]
        size = np.abs(energy - energy[0]).max() / abs(energy[0])
        errors.append(float(size) if run.completed and np.isfinite(size) else math.inf)
    last = max((k for k, e in enumerate(errors) if e < 1e-2), default=-1)
    regular: list[float] = []
    holes: list[float] = []
    for h, e in zip(sizes[: last + 1], errors, strict=False):
        before = float(np.median(regular[-20:])) if regular else e
        if e > 100 * max(before, 1e-13):
            holes.append(float(h))
        else:
            regular.append(e)
    return Scan(tuple(map(float, sizes)), tuple(errors), tuple(holes))


def resonances(path: Path, count: int = 4000, steps: int = 5000) -> None:
    """Scan every new method on three orbits, up to the end of its periodicity interval."""
    record = _record(
        "multistep-resonances",
        f"{count:,} step sizes of multistep methods in one-step form",
        "python -m campaigns.partitioned.multistep resonances FILE",
        [f"{steps:,} steps each; {' '.join((scan.__doc__ or '').split())}"],
    )
    record["scans"] = []
    orbits = (
        (Case("pendulum", 1.0, (("q0", "5/2"),)), 1.0),
        (Case("kepler", 1.0, (("eccentricity", "1/5"),)), 0.8**-1.5),
    )
    for name in SHIPPED:
        method = load(name)
        end = periodicity(method).value or 0.0
        for case, frequency in orbits:
            sizes = np.arange(1, count + 1) * (end / frequency / count)
            sizes = sizes[sizes > 0.05 * sizes[-1]]
            found = scan(method, case, sizes.tolist(), steps)
            good = [h for h, e in zip(found.sizes, found.errors, strict=True) if e < 1e-2]
            record["scans"].append(
                {
                    "method": name,
                    "problem": case.problem,
                    "end": three_digits(end),
                    "sizes": len(sizes),
                    "largest": three_digits(max(good, default=0.0) * frequency),
                    "holes": [three_digits(h * frequency) for h in found.holes],
                }
            )
            write_json(path, record)


def scan_table(document: Mapping[str, Any]) -> str:
    """Holes by method and problem, in Markdown."""
    lines = [
        "| method | problem | interval | largest $h \\omega$, error < 0.01 | holes | the first |",
        "|---" * 6 + "|",
    ]
    for x in document["scans"]:
        first = ", ".join(f"{h:g}" for h in x["holes"][:4]) or "-"
        lines.append(
            f"| `{x['method']}` | {x['problem']} | {x['end']:g} | {x['largest']:g} | "
            f"{len(x['holes'])} of {x['sizes']} | {first} |"
        )
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    kinds = {"long": long_runs, "resonances": resonances}
    if sys.argv[1] in kinds:
        kinds[sys.argv[1]](Path(sys.argv[2]))
    else:
        evaluations(Path(sys.argv[1]))
