"""Whether a general linear method of order 8 can beat Gauss with four stages: times, and a bound.

The stages of a diagonally implicit method are solved one after another, those of a Gauss method
are iterated side by side. Predictors can make iterations fewer, not stages: with s stages and one
evaluation for each, which is the least there can be, a method takes s evaluations a step. At the
time per evaluation that was measured, and with the number of steps that an error of 1e-9 needs,

    bound = steps * s * (seconds / evaluations) / seconds of gauss-4

is what would be left of its time if every stage took one iteration. It is no theorem: a better
kernel lowers the time of an evaluation, and other coefficients lower the number of steps.

    python -m campaigns.order6.bound data/measurements/order8-bound.json
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from campaigns.driver import arguments, carried_out, complete, record_of
from campaigns.order6 import compare
from campaigns.order6.compare import Case, Comparison
from campaigns.pages import markdown
from glmref.catalogue.lookup import load
from glmref.method import GLM
from glmref.problems import problem

METHODS = ("g6245-w3", *compare.METHODS["order 8, general linear"], "gauss-3", "gauss-4")
#: In whose time the others are given.
UNIT = "gauss-4"
ROUNDS, TARGET = 9, "1e-09"
NOTE = (
    "Each method with the faster of fixed point and Newton; processor time, medians of "
    f"{ROUNDS} rounds over all methods in turn."
)
#: Two separable problems and one that is not.
CASES = (*compare.CASES[:2], Case("double-pendulum", lambda: problem("double-pendulum"), 10.0, 10))


def main(path: Path) -> None:
    """Measure all cases and write the file."""
    tasks = ({"case": case.name, "methods": list(METHODS)} for case in CASES)
    title = "Order 8 against Gauss with four stages: seconds at 1e-9, and a bound"
    cases = carried_out(row, tasks, beside=path)
    complete(path, record_of("order6.bound", "order8-bound", title, NOTE, cases=cases))


def row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Compare and time the methods on a case of this name: at the target, the faster solver."""
    (case,) = (case for case in CASES if case.name == task["case"])
    found = Comparison(case, task["methods"])
    found.time(ROUNDS)
    methods: dict[str, dict[str, Any]] = {}
    for track in found.as_json()["tracks"]:
        at, name = track["at"][TARGET], track["method"]
        if at and at["seconds"] < methods.get(name, {"seconds": math.inf})["seconds"]:
            methods[name] = {"method": name, "solver": track["solver"], **at}
    return {"case": case.name, "methods": [*methods.values()]}


def bound(found: Mapping[str, Any], stages: int, unit: Mapping[str, Any]) -> float:
    """Return the share of the time of ``unit`` that is left with one evaluation for each stage."""
    least = min(found["steps"] * stages, found["evaluations"])
    return least * found["seconds"] / found["evaluations"] / unit["seconds"]


def table(document: Mapping[str, Any]) -> str:
    """Tabulate time in units of :data:`UNIT`, evaluations of a stage in a step, and the bound."""
    cases = [x["case"] for x in document["cases"]]
    rows = []
    for name in METHODS:
        method = load(name)
        assert isinstance(method, GLM)
        cells = [f"`{name}`", method.s]
        for entry in document["cases"]:
            known = {x["method"]: x for x in entry["methods"]}
            if name not in known or UNIT not in known:
                cells.append("not reached")
                continue
            found, unit = known[name], known[UNIT]
            time = found["seconds"] / unit["seconds"]
            each = found["evaluations"] / found["steps"] / method.s
            text = f"{time:.2g}; {found['steps'] / unit['steps']:.2g}; {each:.2g}"
            if name == UNIT:
                text += f"; {1e3 * unit['seconds']:.3g} ms"
            elif not name.startswith("gauss"):
                text += f"; {bound(found, method.s, unit):.2g}"
            cells.append(text)
        rows.append(cells)
    return markdown(["method", "stages", *cases], rows)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
