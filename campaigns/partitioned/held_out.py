"""Multistep methods against pairs and splittings on forty problems that nobody trained on.

Each problem of ``held_out_problems.json`` over two horizons: the error of the last state over the
short one, the largest error of the energy in 64 samples over the long one. Evaluations are counted
as :mod:`.work` does. Times are taken beside them, all methods of a case in turn, round after round,
the least of the rounds: the load of the machine meets all of them alike.

    python -m campaigns.partitioned.held_out data/measurements/held-out.json
    python -m campaigns.partitioned.held_out digits data/measurements/held-out-digits.json

The second form counts evaluations down to an error of 1e-12 over the short horizon, on the
problems of at most six components. Rows are kept as they end, so that the same command goes on
where it was stopped.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from campaigns.driver import arguments, carried_out, complete, record_of, three_digits
from campaigns.pages import markdown
from campaigns.partitioned.error_front import SYMMETRIC, twin
from campaigns.partitioned.work import (
    PROBLEMS,
    Case,
    case_of,
    mean,
    needed,
    needs,
    per_step,
    task_of,
)
from glmref.engine.solve import solve

TOLERANCES = ("1e-06", "1e-09")
NYSTROM = "Runge-Kutta-Nyström"
#: What is compared, by group and by whether T is quadratic.
GROUPS: Mapping[bool, Mapping[str, Sequence[str]]] = {
    True: {
        "splitting": (
            *("blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14", "kahan-li-8"),
            "blanes-casas-rkn-8-19",
        ),
        "pair": ("pair-rkn-6-7b", "pair-rkn-6-8b"),
        NYSTROM: ("dormand-prince-rkn-12-10",),
        "published multistep": SYMMETRIC,
        "new": (
            *("multistep-rkn-8", "multistep-rkn-10", "multistep-rkn-12"),
            *("multivalue-rkn-10", "multivalue-rkn-12"),
        ),
    },
    False: {
        "splitting": ("blanes-moan-6", "kahan-li-8", "mclachlan-ss17-8", "sofroniou-spaletta-8-21"),
        "pair": ("pair-6-8", "pair-8-24"),
        NYSTROM: (),
        "published multistep": (),
        "new": ("multistep-8", "multistep-10"),
    },
}
#: Rounds of the timing, and evaluations of each of its runs.
ROUNDS, TIMED_EVALUATIONS = 5, 4_000
_NEEDED = (
    "needed: evaluations of the steps from which the error stays below the tolerance; "
    "start_evaluations come on top. Multistep methods start from the starting method of their "
    "file, pairs from zero values."
)
_TIMES = (
    f"seconds: the steps needed times the time of one, the least of {ROUNDS} rounds over all "
    "methods in turn; published multistep methods in the one-step form, and with the kernel, of "
    "the new ones."
)


def _cases() -> tuple[Case, ...]:
    found = []
    for name, held in PROBLEMS.items():
        of, parameters = (
            (name, ()) if held.H else ("kepler", tuple((held.parameters or {}).items()))
        )
        case = Case(name, of, held.t_end, held.least, parameters, most=held.most)
        least = round(held.least * held.longer / held.t_end)
        more = max(held.most, 20 * least)
        longer = {"t_end": held.longer, "least": least, "measure": "energy", "most": more}
        found += [case, replace(case, name=f"{name}, long", **longer)]
    return tuple(found)


CASES = _cases()


def quadratic(case: str) -> bool:
    """Return whether T is quadratic in a case of this name."""
    return PROBLEMS[case.removesuffix(", long")].quadratic


#: Problems of many bodies on which :data:`LONG_STEPS` are not run: their kernels take minutes to
#: compile there.
LARGE = (
    *("ring 64", "lennard-jones 7", "ions 8", "ring polymer 16", "morse chain 16", "toda ring 16"),
    *("fput beta 32", "pendulum chain 24", "dna chain 24", "lattice 36"),
)
#: On the one chain with all methods, phi4, the best of these splittings needs at 1e-9 0.94 of the
#: evaluations of the best of the others over the short horizon, 1.6 times as many over the long.
LONG_STEPS = ("kahan-li-8", "blanes-casas-rkn-8-19", "pair-rkn-6-7b", "quinlan-8a")


def methods_for(case: str) -> list[str]:
    """Return what is measured in a case."""
    left_out = LONG_STEPS if case.removesuffix(", long") in LARGE else ()
    found = [x for group in GROUPS[quadratic(case)].values() for x in group]
    return [x for x in found if x not in left_out]


def _seconds(case: Case, steps: Mapping[str, int], rounds: int = ROUNDS) -> dict[str, float]:
    """Time so many steps of each method: all in turn, round after round, the least of each."""
    target, least = case.built(), dict.fromkeys(steps, math.inf)
    for _ in range(rounds):
        for name, count in steps.items():
            few = max(50, min(count, TIMED_EVALUATIONS // per_step(name)))
            run = solve(target, twin(name), h=case.t_end / count, steps=few, every=few)
            if run.completed:
                least[name] = min(least[name], run.seconds / run.steps * count)
    rounded = {name: three_digits(x) for name, x in least.items() if math.isfinite(x)}
    return {name: x for name, x in rounded.items() if x is not None}


def case_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Count and time the methods of a case in JSON."""
    case, key = case_of(task), TOLERANCES[-1]
    rows = {x["method"]: x for x in needs(case, task["methods"])}
    counts = {name: row["needed"].get(key) for name, row in rows.items()}
    steps = {name: max(1, round(n / per_step(name))) for name, n in counts.items() if n}
    for name, seconds in _seconds(case, steps).items():
        rows[name]["seconds"] = {key: seconds}
    return {"case": case.name, "measure": case.measure, "methods": [*rows.values()]}


def main(path: Path, cases: Sequence[Case] = CASES) -> None:
    """Measure all cases and write the file."""
    tasks = (task_of(case, *methods_for(case.name)) for case in cases)
    title = "Evaluations and time on forty problems on which no method was trained"
    record = record_of("partitioned.held_out", "held-out", title, _NEEDED, _TIMES)
    record["cases"] = carried_out(case_row, tasks, beside=path)
    complete(path, record | {"not measured": [x.name for x in CASES if x not in cases]})


#: Tolerances down to which evaluations are counted over the short horizon, and the components
#: of the largest problem.
DIGITS, COMPONENTS = (1e-6, 1e-9, 1e-12), 6


def count_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Count the evaluations of the methods of a case in JSON, at all of :data:`DIGITS`."""
    case = case_of(task)
    rows = needs(case, task["methods"], DIGITS)
    return {"case": case.name, "measure": case.measure, "methods": rows}


def digits(path: Path) -> None:
    """Count evaluations at all of :data:`DIGITS` and write the file."""
    short = (x for x in CASES if x.measure == "state" and x.name not in LARGE)
    cases = [x for x in short if x.built().dimension <= COMPONENTS]
    tasks = (task_of(case, *methods_for(case.name)) for case in cases)
    title = "Evaluations for 6, 9 and 12 digits on small problems on which no method was trained"
    record = record_of("partitioned.held_out digits", "held-out-digits", title, _NEEDED)
    complete(path, record | {"cases": carried_out(count_row, tasks, beside=path)})


# --- tables ---------------------------------------------------------------------------------------


def best(
    entry: Mapping[str, Any], group: str, tolerance: str, what: str = "needed"
) -> tuple[str, float]:
    """Return the method of a group that needs least in a case, and how much; infinity: none."""
    return needed(entry, GROUPS[quadratic(entry["case"])][group], tolerance, what)


def ratio(entry: Mapping[str, Any], other: str, tolerance: str, what: str = "needed") -> float:
    """Return the best new method over the best of another group; NaN where one of both has none."""
    mine, theirs = (best(entry, x, tolerance, what)[1] for x in ("new", other))
    return mine / theirs if math.isfinite(mine) and math.isfinite(theirs) else math.nan


def _shown(values: Sequence[float]) -> str:
    known = [x for x in values if math.isfinite(x)]
    wins = sum(x < 1 for x in known)
    return f"{mean(known):.2f} ({wins} of {len(known)})" if known else "-"


def _two_digits(x: float) -> str:
    return f"{x:.2f}" if math.isfinite(x) else "-"


def _horizon(document: Mapping[str, Any], measure: str, *, second: bool) -> list[dict[str, Any]]:
    return [
        x for x in document["cases"] if x["measure"] == measure and quadratic(x["case"]) == second
    ]


def summary(document: Mapping[str, Any]) -> str:
    """Return the geometric means of the best new method over the best of each group, in Markdown.

    In brackets in how many cases the new one needs less.
    """
    heads = "T, horizon, what, new / published multistep, new / splitting, new / pair, new / RKN"
    rows = []
    kinds: Sequence[tuple[str, str, str]] = (
        ("evaluations, $10^{-6}$", "1e-06", "needed"),
        ("evaluations, $10^{-9}$", "1e-09", "needed"),
        ("time, $10^{-9}$", "1e-09", "seconds"),
    )
    for second in (True, False):
        for measure, horizon in (("state", "short"), ("energy", "long")):
            cases = _horizon(document, measure, second=second)
            for words, tolerance, what in kinds:
                cells = [
                    _shown([ratio(x, other, tolerance, what) for x in cases])
                    for other in ("published multistep", "splitting", "pair", NYSTROM)
                ]
                kind = "quadratic" if second else "other"
                rows.append([kind, horizon, words, *cells])
    return markdown(heads.split(", "), rows)


def singles(document: Mapping[str, Any]) -> str:
    """Tabulate one method for all problems with quadratic T over the best published multistep.

    Of each case, geometric means, with the number of cases in which the method reaches the
    tolerance; in Markdown.
    """
    columns = [(measure, tolerance) for measure in ("state", "energy") for tolerance in TOLERANCES]
    names = {"state": "short", "energy": "long"}
    heads = [f"{names[m]}, $10^{{{int(t[2:])}}}$" for m, t in columns]
    rows = []
    for name in methods_for(next(iter(PROBLEMS))):
        cells = [f"`{name}`"]
        for measure, tolerance in columns:
            shares = []
            for entry in _horizon(document, measure, second=True):
                counts = {x["method"]: x["needed"].get(tolerance) for x in entry["methods"]}
                unit = best(entry, "published multistep", tolerance)[1]
                if counts.get(name) and math.isfinite(unit):
                    shares.append(counts[name] / unit)
            cells.append(f"{mean(shares):.2f} ({len(shares)})" if shares else "-")
        rows.append(cells)
    return markdown(["method", *heads], rows)


def table(document: Mapping[str, Any], measure: str) -> str:
    """Tabulate all cases of a horizon: evaluations at 1e-9 by group, ratios, the fastest."""
    heads = (
        "problem, best splitting, best pair, Nyström, best published multistep, best new, "
        "new / multistep, new / splitting, the same at $10^{-6}$, fastest"
    )
    rows = []
    for entry in document["cases"]:
        if entry["measure"] != measure:
            continue
        cells = [entry["case"].removesuffix(", long")]
        for group in ("splitting", "pair", NYSTROM, "published multistep", "new"):
            name, count = best(entry, group, "1e-09")
            cells.append(f"{count:,.0f} ({name})" if math.isfinite(count) else "-")
        others = ("published multistep", "splitting")
        cells += [_two_digits(ratio(entry, x, "1e-09")) for x in others]
        cells.append(", ".join(_two_digits(ratio(entry, x, "1e-06")) for x in others))
        times = {x["method"]: x.get("seconds", {}).get("1e-09", math.inf) for x in entry["methods"]}
        fastest = min(times, key=lambda x: times[x])
        cells.append(fastest if math.isfinite(times[fastest]) else "-")
        rows.append(cells)
    return markdown(heads.split(", "), rows)


if __name__ == "__main__":
    *what, file = arguments(sys.argv[1:])
    (digits if what == ["digits"] else main)(Path(file))
