"""The tables of docs/scene-results.md, from the files in data/measurements.

    python -m campaigns.scene_results
    python -m campaigns.scene_results run.json

The first form puts the tables into the page. The second first takes what ``glmref run --all --quick
--format json`` wrote, questions and answers, into data/measurements/scenes.json, or what ``glmref
run van-der-pol-jump --format json`` wrote, the records of one scene, into stiff-cost.json.
"""

import json
import sys
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from campaigns.pages import ROOT, Pages, markdown, measured, write
from glmref.catalogue.lookup import data_root

PAGE = ROOT / "docs" / "scene-results.md"
FOLDER = data_root() / "measurements"
#: Scene of the table of stiff problems, and its columns.
JUMP = "van-der-pol-jump"
COLUMNS = ("method", "h", "tolerance", "outcome", "state_error", "evaluations")


def stiff() -> str:
    """Return the counts over the jump of Van der Pol's equation, with those of scipy."""
    rows = []
    for name, h, tolerance, outcome, error, count in map(costs, measured("stiff-cost")["rows"]):
        if tolerance or h == 1e-6:
            step = f"h = {h:.3g}" if h else f"tol {tolerance:.0e}"
            shown = outcome if error is None else f"{error:.1e}"
            rows.append([f"`{name}`", step, shown, f"{count:,}"])
    return markdown(["method", "step", "error", "evaluations"], rows)


def costs(row: Mapping[str, Any]) -> list[Any]:
    """Return the columns of a row; a run at a fixed step has no tolerance."""
    return [row.get(key) for key in COLUMNS]


def long() -> str:
    """Return a hundred million steps."""
    rows = []
    for run in measured("pendulum-1e8")["runs"]:
        law, memory = run["law"], run["peak_memory_mb"]
        exponent = "-" if law["exponent"] is None else f"{law['exponent']:.3f}"
        when = "" if law["kind"] != "blow-up" else f" at t = {law['time']:.3g}"
        growth = memory["at the end"] - memory["after 1 per cent"]
        rows.append(
            (
                f"`{run['method']}`", run["h"], law["kind"] + when, exponent,
                f"{law['largest']:.1e}", f"{run['seconds']['process']:.0f} s", f"{growth:.1f} MB",
            )
        )  # fmt: skip
    head = ["method", "h", "law of the energy error", "exponent", "largest", "processor", "memory"]
    return markdown(head, rows)


PAGES: Pages = {PAGE: {"stiff": stiff, "long": long}}


def renew(path: Path) -> None:
    """Take questions and answers of a run, or the costs of one scene, into the data."""
    found = json.loads(path.read_text(encoding="utf-8"))
    one = isinstance(found, dict)
    documents = [found] if one else sorted(found, key=lambda one: one["scene"])
    head = {"format": "glmref-measurement-1"}
    where = {"where": documents[0]["records"][0]["where"]}
    how = "glmref run {} --format json > run.json && python -m campaigns.scene_results run.json"
    if one:
        rows = [dict(zip(COLUMNS, costs(x), strict=True)) for x in found["records"]]
        head |= {"what": found["title"], "how": how.format(found["scene"]), **where, "rows": rows}
    else:
        said = "the answer of every scene, with the step sizes of --quick"
        scenes = [
            {
                "scene": one["scene"],
                "question": one["question"],
                "answer": one["answer"],
                "outcomes": dict(sorted(Counter(x["outcome"] for x in one["records"]).items())),
            }
            for one in documents
        ]
        head |= {"what": said, "how": how.format("--all --quick"), **where, "scenes": scenes}
    text = json.dumps(head, indent=1, ensure_ascii=False, allow_nan=False)
    name = "stiff-cost" if one else "scenes"
    (FOLDER / f"{name}.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:]:
        renew(Path(sys.argv[1]))
    write(PAGES)
