"""Multistep methods in one-step form against pairs and splittings: evaluations, long runs.

    python -m campaigns.partitioned.multistep data/measurements/multistep.json
    python -m campaigns.partitioned.multistep long data/measurements/multistep-long.json

The first counts force evaluations as :mod:`.work` does, each multistep method from its own start;
the second follows 10^7 steps as :mod:`.long_runs` does. Times stand in the
records of :mod:`.held_out` and of :mod:`campaigns.world`.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import TIMED, arguments, carried_out, complete, record_of
from campaigns.pages import markdown
from campaigns.partitioned import work
from campaigns.partitioned.error_front import angles_of
from campaigns.partitioned.long_runs import (
    EVERY,
    RESTART,
    Case,
    case_of,
    shown_error,
    three_digits,
)
from campaigns.partitioned.long_runs import follow_at as follow
from campaigns.partitioned.work import CASES, mean, need_of, need_row, needed, per_step, task_of
from glmref.catalogue.lookup import load, names
from glmref.catalogue.reader import load_document
from glmref.derive.multistep import multistep_document
from glmref.derive.recipes.multistep import SHIPPED
from glmref.engine.solve import solve
from glmref.method import Method, PartitionedGLM
from glmref.problems import problem
from glmref.problems.model import Problem

#: Published symmetric multistep methods.
SYMMETRIC = (
    *("quinlan-tremaine-8", "quinlan-tremaine-10", "quinlan-tremaine-12"),
    *("quinlan-tremaine-14", "quinlan-8a", "quinlan-8b"),
)
#: What is compared, by group: the columns of the table are the best of each group.
ROWS: Mapping[str, Sequence[str]] = {
    "splitting": ("blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14", "kahan-li-8"),
    "pair": ("pair-6-8", "pair-rkn-6-7b", "pair-rkn-6-8b"),
    "published multistep": SYMMETRIC,
    "new, separable": tuple(x for x in SHIPPED if "rkn" not in x),
    "new, second-order": tuple(x for x in SHIPPED if "rkn" in x),
}


#: Cases of :mod:`.work` that are not measured: one does not discriminate, three take an hour.
LEFT_OUT = ("n-body", "fput-stiff", "outer-solar-system-long", "pendulum-long")
COUNTED = tuple(x for x in CASES if x.name not in LEFT_OUT)


def rows() -> dict[str, list[str]]:
    """Return :data:`ROWS` as far as the catalogue has them."""
    known = set(names("methods"))
    return {group: [x for x in methods if x in known] for group, methods in ROWS.items()}


# --- evaluations ----------------------------------------------------------------------------------

NOTE = (
    "needed: force evaluations of the steps from which the error stays below the tolerance, "
    "interpolated between step sizes a third of an octave apart; start_evaluations come on top. "
    "Multistep methods start from the starting method of their file, pairs from zero values."
)
TIME_NOTE = (
    "The time of a step is that of 4,000 steps, the start not counted, the least of five runs of "
    "the compiled engine. Published symmetric multistep methods are timed in the one-step form of "
    "the new ones, for which there is the shorter kernel."
)


def evaluations(path: Path, cases: Sequence[work.Case] = COUNTED) -> None:
    """Count for all cases and methods, and write the file."""
    record = record_of(
        "partitioned.multistep",
        "multistep",
        "Force evaluations that multistep methods, pairs and splittings need",
        NOTE,
    )
    record["groups"] = rows()
    methods = [x for group in rows().values() for x in group]
    counted = iter(
        carried_out(need_row, (task_of(x, name) for x in cases for name in methods), beside=path)
    )
    record["cases"] = []
    for case in cases:
        found = [need_of(x) for _ in methods for x in next(counted)]
        counts = [need.counted() for need in found if need.start != "enhanced"]
        record["cases"].append({"case": case.name, "measure": case.measure, "methods": counts})
    complete(path, record)


@cache
def twin(name: str) -> Method:
    """Return a published symmetric multistep method in the one-step form of the new ones.

    The same formula for the positions, up to the rounding of the cosines of its roots: the engine
    steps it by the same kernel, which a comparison of times has to do. Its file keeps the published
    form. Other methods are returned as they are.
    """
    if name not in SYMMETRIC:
        return load(name)
    of_p = cosines(name)
    return load_document(multistep_document(f"{name}-in-one-step-form", [], of_p, title=name))


def cosines(name: str) -> list[Fraction]:
    """Return cosines of the pairs of roots of a symmetric multistep method, to nine digits."""
    return [Fraction(float(c)).limit_denominator(10**9) for c in np.cos(angles_of(name))[::-1]]


def seconds_per_step(name: str, target: Problem, h: float, steps: int = 4_000) -> float | None:
    """Time a step, the least of five runs of so many; ``None`` where they are lost at once.

    Short runs and the least of them: what else the machine does falls between them.
    """
    runs = [solve(target, twin(name), h=h, steps=steps, every=steps) for _ in range(5)]
    if min(run.steps for run in runs) < steps // 4:
        return None
    return min(run.seconds / run.steps for run in runs)


def run_seconds(task: Mapping[str, Any]) -> float | None:
    """Return the time of a run of a method on a case with so many steps, its start not counted."""
    case, (name,), steps = work.case_of(task), task["methods"], task["steps"]
    each = seconds_per_step(name, case.built(), case.t_end / steps)
    return None if each is None else three_digits(steps * each)


def table(document: Mapping[str, Any], tolerance: str) -> str:
    """Return the best of each group, case by case, in Markdown.

    The last line holds geometric means.
    """
    groups = document["groups"]
    rivals = [x for key, methods in groups.items() if not key.startswith("new") for x in methods]
    new = [x for key, methods in groups.items() if key.startswith("new") for x in methods]
    head = ["case", *(f"best {key}" for key in groups), "new / best other"]
    rows: list[list[str]] = []
    ratios: list[float] = []
    for entry in document["cases"]:
        cells = [entry["case"]]
        for methods in groups.values():
            name, found = needed(entry, methods, tolerance)
            cells.append(f"{found:,.0f} ({name})" if math.isfinite(found) else "-")
        mine, theirs = (needed(entry, x, tolerance)[1] for x in (new, rivals))
        if math.isfinite(mine) and math.isfinite(theirs):
            ratios.append(mine / theirs)
        cells.append(f"{mine / theirs:.2f}" if math.isfinite(mine) else "-")
        rows.append(cells)
    rows.append(["geometric mean", *[""] * len(groups), f"{mean(ratios):.2f}"])
    return markdown(head, rows)


#: Method in whose evaluations :func:`mean_table` counts.
UNIT = "quinlan-tremaine-10"


def mean_table(document: Mapping[str, Any]) -> str:
    """Return method against method: evaluations in units of :data:`UNIT`, in Markdown.

    Geometric means over the second-order problems, and over those with a long horizon.
    """
    cases = [x for x in document["cases"] if x["case"] != "lotka-volterra"]
    long = [x for x in cases if x["case"].endswith("-long")]
    groups = ((cases, "cases"), (long, "long cases"))
    columns = [(t, some, word) for t in ("1e-06", "1e-09") for some, word in groups]
    heads = [f"$10^{{{int(t[2:])}}}$, {len(some)} {word}" for t, some, word in columns]
    rows = []
    for group in ("published multistep", "new, second-order"):
        for name in document["groups"][group]:
            cells = [f"`{name}`"]
            for tolerance, some, _ in columns:
                shares = [
                    needed(x, [name], tolerance)[1] / needed(x, [UNIT], tolerance)[1] for x in some
                ]
                cells.append(f"{mean(shares):.2f}")
            rows.append(cells)
    return markdown(["method", *heads], rows)


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
    "neither grows by more than a factor 10 in the last two decades. restarted, where it is there: "
    f"the energy error of the same run started anew from the solution every {RESTART:,} steps. "
    f"ns: nanoseconds a step. {TIME_NOTE}"
)
#: Published methods that are run and scanned beside the new ones.
PUBLISHED = tuple(f"quinlan-tremaine-{order}" for order in (8, 10, 12, 14))


def step_of(name: str, case: Case) -> float:
    """Return the step size of a method on a case, by its evaluations."""
    return case.per_evaluation * per_step(name)


def long_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Follow a method on a case in JSON."""
    case, restart = case_of(task), task["restart"]
    return follow(
        task["method"], case, step_of(task["method"], case), task["steps"], restart=restart
    ).as_json()


def nanoseconds(task: Mapping[str, Any]) -> float | None:
    """Return the time of a step of a method on a case in JSON."""
    case = case_of(task)
    target = problem(case.problem, **dict(case.parameters))
    each = seconds_per_step(task["method"], target, step_of(task["method"], case))
    return None if each is None else three_digits(1e9 * each)


def long_runs(path: Path, steps: int = 10_000_000, cases: Sequence[Case] = LONG) -> None:
    """Follow every new and published method on every case, and write the file.

    New methods whose error grows are run again with new starts; the starts of published ones take
    too long for that.
    """
    pairs = [(name, case) for name in (*SHIPPED, *PUBLISHED) for case in cases]
    tasks = [{"method": x, "steps": steps, "restart": 0, **asdict(case)} for x, case in pairs]
    found = carried_out(long_row, tasks, beside=path)
    times = carried_out(nanoseconds, tasks, beside=path, limits=TIMED)
    rows = [
        {**row, "parameters": dict(case.parameters), "ns": ns}
        for (_, case), row, ns in zip(pairs, found, times, strict=True)
    ]
    growing = [k for k, x in enumerate(rows) if not x["bounded"] and x["method"] in SHIPPED]
    again = carried_out(long_row, ({**tasks[k], "restart": RESTART} for k in growing), beside=path)
    for k, row in zip(growing, again, strict=True):
        rows[k]["restarted"] = row["energy"]
    title = "Multistep methods in one-step form over ten million steps"
    name = "multistep-long"
    complete(path, record_of("partitioned.multistep long", name, title, LONG_NOTE, runs=rows))


def _cause(run: Mapping[str, Any]) -> str:
    """Return whether a run is bounded.

    Else from when on it is not, and what starting anew changes.
    """
    if run["bounded"]:
        return "yes"
    marks, energy = run["marks"], [math.inf if x is None else x for x in run["energy"]]
    first = energy[-3]
    grown = next((n for n, e in zip(marks, energy, strict=True) if e > 10 * first), None)
    if grown is None:
        return "no: the carried values grow"
    text = f"no: grown tenfold within {grown * run['h']:.3g} time units"
    if "restarted" not in run:
        return text
    new = run["restarted"][-1]
    cured = new is not None and new <= 10 * run["restarted"][-3]
    return f"{text}; started again every {RESTART:,} steps " + (
        f"{new:.1e}" if cured else "it grows too: the step is too long"
    )


def long_table(document: Mapping[str, Any]) -> str:
    """Return energy errors after 10^5, 10^6 and 10^7 steps and the time of a step, in Markdown."""
    heads, rows = "method, problem, h, $10^5$, $10^6$, $10^7$, ns a step, bounded", []
    for run in document["runs"]:
        what = ", ".join([run["problem"], *(f"{k} = {v}" for k, v in run["parameters"].items())])
        cells = [*map(shown_error, run["energy"][-3:])]
        cells += ["-" if run["ns"] is None else f"{run['ns']:.0f}", _cause(run)]
        rows.append([f"`{run['method']}`", what, f"{run['h']:g}", *cells])
    return markdown(heads.split(", "), rows)


def shipped_table(documents: Mapping[str, Mapping[str, Any]]) -> str:
    """Return what to know of each shipped method, in Markdown.

    From the records ``multistep-long``, ``multistep-growth`` and ``multistep-resonances``.
    """
    rows = []
    first = {
        x["method"]: x["ranges"][0][0]
        for x in documents["multistep-growth"]["scans"]
        if x["orbit"].startswith("Kepler")
    } | {
        x["method"]: x["holes"][0]
        for x in documents["multistep-resonances"]["scans"]
        if x["problem"] == "kepler"
    }
    for name, shipped in SHIPPED.items():
        method = load(name)
        assert isinstance(method, PartitionedGLM)
        order = method.claims["order"] if shipped.q else method.claims["nystrom-order"]
        values = len(method.V) + len(method.V_hat)
        runs = [x["bounded"] for x in documents["multistep-long"]["runs"] if x["method"] == name]
        cells = ["separable" if shipped.q else "second order", order, values]
        cells += [2 if shipped.slopes else 1, f"{first[name]:g}", f"{sum(runs)} of {len(runs)}"]
        rows.append([f"`{name}`", *cells])
    heads = "method, systems, order, values, kicks a step, first resonance, bounded"
    return markdown(heads.split(", "), rows)


if __name__ == "__main__":
    *what, file = arguments(sys.argv[1:])
    (long_runs if what == ["long"] else evaluations)(Path(file))
