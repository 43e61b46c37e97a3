"""The defects of the audit seen in runs: errors with the table as shipped and with the right one.

Each table of ``tests/suite/real_defects.json`` makes an integrator, and so does the corrected one.
Both integrate a problem over one unit of time at halved steps; the observed order is the binary
logarithm of the ratio of two errors, the last one above round-off. What the package of a code
itself shows was measured once (commit 975e6561), and stays in the record.

``python -m campaigns.audited_orders FILE`` measures (``data/measurements/audit-orders.json``).
"""

import json
import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete
from campaigns.pages import ROOT, Pages, markdown, measured
from glmref.conformance.vector_problems import problems
from glmref.engine.solve import solve
from glmref.measure.timing import circumstances
from glmref.problems.model import Problem
from tests.suite.real_defects import DEFECTS, mended, published

PAGE = ROOT / "docs" / "audit" / "tables.md"
#: Numbers of steps, and the error below which round-off takes part.
STEPS = (1, 2, 4, 8, 16, 32, 64, 128, 256)
ROUND_OFF = 2e-13
HEAD: Mapping[str, str] = {
    "format": "glmref-measurement-1",
    "name": "audit-orders",
    "question": "Which order do tables of the audit show in runs, as shipped and corrected?",
    "how": "python -m campaigns.audited_orders FILE",
}

Errors = Sequence[float]


def observed(errors: Errors) -> float | None:
    """Return the order from the last two errors above round-off; ``None`` where no two are."""
    good = [x for x in errors if math.isfinite(x) and x > ROUND_OFF]
    return math.log2(good[-2] / good[-1]) if len(good) > 1 else None


def truth(problem: Problem) -> np.ndarray:
    """Return the solution at the end of its time: Gauss, order 10, with an error below 1e-15."""
    return np.asarray(solve(problem, "gauss-5", h=1 / 64, steps=64).y[-1], dtype=float)


def errors_of(integrator: Any, name: str, problem: Problem) -> list[float]:
    """Return the largest error at the end for each number of steps."""
    right, found = truth(problem), []
    for n in STEPS:
        if hasattr(integrator, "solve"):
            y = integrator.solve(name, problem, 1 / n, n)
        else:
            y = np.array([float(x) for x in problem.y0])
            for k in range(n):
                y = integrator.step(name, problem, problem.t_span[0] + k / n, y, 1 / n)
        found.append(float(np.abs(y - right).max()))
    return found


def row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Return errors of a table on the problem that shows most: one with time where it can."""
    name = task["table"]
    entry, shipped = DEFECTS[name], published(name)
    on = shipped.problems[-1]
    found: dict[str, Any] = {
        "table": name, "where": entry["where"], "commit": entry["commit"], "problem": on,
        "declared": entry["declared"],
        "shipped": errors_of(shipped, name, problems()[on].problem),
    }  # fmt: skip
    right = entry["right"] or {}
    if set(right) - {"order"}:
        found["corrected"] = errors_of(mended(name), name, problems()[on].problem)
    return found


# --- the page -----------------------------------------------------------------------------------


def _seen(errors: Errors | None) -> str:
    """Return the observed order as the page shows it."""
    order = None if errors is None else observed(errors)
    return "" if order is None else f"{order:.1f}"


def table(record: Mapping[str, Any]) -> str:
    """Return a row for each table whose defect is larger than the round-off of a run."""
    rows = []
    at = STEPS.index(16)
    for row in record["rows"]:
        right = row.get("corrected")
        rows.append([
            row["table"], row["declared"], _seen(row["shipped"]), _seen(right),
            f"{row['shipped'][at]:.1e}", "" if right is None else f"{right[at]:.1e}",
        ])  # fmt: skip
    for row in record["packages"]:
        name = f"{row['package']} {row['version']}, `{row['method']}`"
        errors = row["errors"]
        rows.append([f"{name} itself", "", _seen(errors), "", f"{errors[1]:.1e}", ""])
    heads = "table; declared; shipped; corrected; error at h = 1/16, shipped; corrected"
    return markdown(heads.split("; "), rows)


PAGES: Pages = {PAGE: {"audit-orders": lambda: table(measured("audit-orders"))}}


def main(path: Path) -> None:
    """Measure into a file."""
    known = json.loads(path.read_text("utf-8")) if path.exists() else {"packages": []}
    rows = carried_out(row, ({"table": name} for name in DEFECTS), beside=path)
    found = {"rows": rows, "packages": known["packages"]}
    complete(path, {**HEAD, **found, "where": circumstances()})


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
