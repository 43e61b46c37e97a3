"""Strongly stable multistep methods: evaluations, ten million steps without renewal, and time.

    python -m campaigns.partitioned.strong data/measurements/strong-multistep.json

The problems are those of ``nonseparable.json``, whose rivals are not measured again: named ones,
and systems that were written down after other methods had been fixed.
"""

from __future__ import annotations

import json
import math
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import TIMED, arguments, carried_out, complete, three_digits
from campaigns.pages import Pages, markdown, measured
from campaigns.partitioned.nonseparable import (
    _DOCS,
    LONG,
    LOST,
    TOLERANCES,
    ends,
    growth,
    long_run,
    long_table,
    needed,
    step_of,
)
from glmref import Problem, solve
from glmref.catalogue.lookup import load
from glmref.derive.recipes.strong_multistep import SHIPPED
from glmref.measure.timing import circumstances
from glmref.measure.work_precision import reference_state, state_error
from glmref.problems import problem

#: What is timed against what, the first of its numbers of steps, and steps by rounds.
FAST, _RIVAL, _COARSE = "multistep-strong-8", "gauss-4", 20
TIMES = {100_000: 25, 1_000_000: 7}
#: The numbers of steps of the scenes.
_COUNTS = np.unique(np.geomspace(20, 4000, 28).round().astype(int)).tolist()


def written_down() -> dict[str, Mapping[str, Any]]:
    """Return the systems that are in the record only, by name."""
    return {x["problem"]: x for x in measured("nonseparable")["afterwards"]}


def problem_of(name: str) -> Problem:
    """Return a problem of the record."""
    given = written_down().get(name)
    if given is None:
        return problem(name)
    names = {key: given[key].split() for key in ("coordinates", "momenta")}
    return Problem.from_hamiltonian(given["H"], given["y0"], name=name, **names)


def _measured(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the evaluations by tolerance, and a long run at the step of the smallest one."""
    one, name = problem_of(case["problem"]), case["method"]
    end, method = ends().get(one.name, 20.0), load(name)
    exact = reference_state(one, end)
    curve: list[tuple[int, float]] = []
    for steps in _COUNTS:
        found = solve(one, method, h=end / steps, steps=steps, every=steps)
        error = state_error(found.y[-1], exact) if found.completed else math.inf
        curve.append((found.evaluations + found.start_evaluations, error))
    counts = {f"{x:g}": needed(curve, x) for x in TOLERANCES}
    row = {**case, "evaluations": counts}
    if least := counts[f"{TOLERANCES[-1]:g}"]:
        h = float(f"{end / (least - curve[0][0] + _COUNTS[0]):.3g}")
        row |= {"h": h, "steps": LONG[0], **long_run(name, one, h, LONG[0])}
        if row["reported"] is not None:
            row["growth"] = growth(one, name, h, row["reported"], 0)
    return row


def times(case: Mapping[str, Any]) -> dict[str, Any]:
    """Time whole runs at the step sizes of 1e-9: the least of many, which take turns."""
    one = problem_of(case["problem"])
    found = step_of(load(_RIVAL), one, _COARSE)
    assert found is not None
    row: dict[str, Any] = {**case, "rival_h": found[0], "seconds": {}}
    for steps, rounds in TIMES.items():
        ways: dict[str, dict[str, Any]] = {
            "own": {"method": FAST, "h": case["h"], "steps": steps},
            "rival": {
                "method": _RIVAL, "h": found[0], "steps": round(steps * case["h"] / found[0])
            },
        }  # fmt: skip
        least = dict.fromkeys(ways, math.inf)
        for turn in range(rounds + 1):  # the first one compiles
            for way, options in ways.items():
                begin = time.process_time()
                solve(one, **options)
                if turn:
                    least[way] = min(least[way], time.process_time() - begin)
        row["seconds"][str(steps)] = {way: three_digits(x) for way, x in least.items()}
    return row


def kept(runs: Sequence[Mapping[str, Any]]) -> dict[str, float]:
    """Return the step sizes of the long runs that are neither lost nor reported, by problem."""
    return {
        x["problem"]: x["h"] for x in runs
        if x["method"] == FAST and "h" in x and x["reported"] is None and x["energy"] < LOST
    }  # fmt: skip


def ratios(rows: Sequence[Mapping[str, Any]], steps: int) -> list[float]:
    """Return the times over that of the rival, in increasing order."""
    found = [x["seconds"][str(steps)] for x in rows]
    return sorted(x["own"] / x["rival"] for x in found)


def main(path: Path) -> None:
    """Measure all, and write the record."""
    record = json.loads(path.read_text(encoding="utf-8"))
    names = dict.fromkeys(
        [*(x["problem"] for x in measured("nonseparable")["long"]), *written_down()]
    )
    cases = [{"problem": x, "method": m} for x in names for m in SHIPPED]
    record["runs"] = carried_out(_measured, cases, beside=path)
    timed = [{"problem": name, "h": h} for name, h in kept(record["runs"]).items()]
    rows = carried_out(times, timed, beside=path, limits=TIMED)
    record["times"] = {"where": circumstances(), "rows": rows}
    complete(path, record)


def rivals(name: str, tolerance: float) -> dict[str, int]:
    """Return the evaluations that the record of the other methods has, by method."""
    if (given := written_down().get(name)) is not None:
        found = given["evaluations"][f"{tolerance:g}"]
    else:
        rows = measured("nonseparable")["evaluations"]
        found = next(
            (x["methods"] for x in rows if (x["problem"], x["tolerance"]) == (name, tolerance)), {}
        )
    return {k: n for k, n in found.items() if n}


def best_gauss(counts: Mapping[str, int]) -> int:
    """Return the fewest evaluations of a Gauss method."""
    return min(n for name, n in counts.items() if name.startswith("gauss"))


def _rows() -> dict[str, dict[str, Any]]:
    """Return the measurements by problem and method."""
    found: dict[str, dict[str, Any]] = {}
    for x in measured("strong-multistep")["runs"]:
        found.setdefault(x["problem"], {})[x["method"]] = x
    return found


def table(tolerance: float = TOLERANCES[-1]) -> str:
    """Return the evaluations on the problems held out that have rivals in the record."""
    lines = []
    for name, own in _rows().items():
        if name not in written_down() and (counts := rivals(name, tolerance)):
            shown = [own[m]["evaluations"][f"{tolerance:g}"] for m in SHIPPED]
            shown += [counts["multistep-general-8b"], best_gauss(counts), counts["scipy-dop853"]]
            lines.append([name, *(f"{n:,}" for n in shown)])
    heads = ["problem", *(f"`{m}`" for m in SHIPPED), "`multistep-general-8b`"]
    return markdown([*heads, "best Gauss", "DOP853"], lines)


#: What the table of long runs has beside: a pair without renewal, and one with.
_PAIRS = (("multistep-general-8", 0), ("multistep-general-8c", 1000))


def long_rows() -> list[dict[str, Any]]:
    """Return the long runs of the table, by problem, method and ``renew``."""
    record = measured("nonseparable")
    runs = [{**x, "renew": 0} for x in measured("strong-multistep")["runs"]]
    runs += record["long"]
    runs += [{**x, "problem": one["problem"]} for one in record["afterwards"] for x in one["long"]]
    columns = [*((m, 0) for m in SHIPPED), *_PAIRS]
    return [x for x in runs if (x["method"], x["renew"]) in columns]


def _long_table() -> str:
    return long_table(long_rows(), [*((m, 0) for m in SHIPPED), *_PAIRS], LOST)


PAGES: Pages = {
    _DOCS / "nonseparable.md": {"strong": table},
    _DOCS / "nonseparable" / "long-runs.md": {"strong-long": _long_table},
}


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
