"""The tables of docs/scene-results.md, from the files in data/measurements.

    python -m campaigns.scene_results
    glmref run --all --quick --format json > run.json; python -m campaigns.scene_results run.json

The first form puts the tables into the page; the second first takes questions and answers of a run
into data/measurements/scenes.json.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from pathlib import Path

from campaigns.pages import ROOT, Pages, markdown, measured, write
from glmref.catalogue.lookup import data_root

PAGE = ROOT / "docs" / "scene-results.md"
FOLDER = data_root() / "measurements"
#: Problem and end of the table of stiff problems, and its methods.
JUMP = ("van-der-pol", 2.0)
SHOWN = (
    "sdirk-4", "dimsim-2-type-2", "gsymplectic-p", "g6245", "gauss-2", "radau-iia-3",
    "scipy Radau", "scipy BDF",
)  # fmt: skip


def stiff() -> str:
    """Return the counts over the jump of Van der Pol's equation, with those of scipy."""
    rows = []
    for one in measured("stiff-cost")["rows"]:
        if (one["problem"], one["t_end"]) != JUMP or one["name"] not in SHOWN:
            continue
        step = f"h = {one['h']:.3g}" if one["h"] else f"tol {one['tolerance']:.0e}"
        error = one["outcome"] if one["error"] is None else f"{one['error']:.1e}"
        rows.append([one["name"], step, error, f"{one['evaluations']:,}"])
    return markdown(["method", "step", "error", "evaluations"], rows)


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
    """Take questions and answers of a run into the data."""
    documents = json.loads(path.read_text(encoding="utf-8"))
    circumstances = documents[0]["records"][0]["where"]
    document = {
        "format": "glmref-measurement-1",
        "what": "the answer of every scene, with the step sizes of --quick",
        "how": "glmref run --all --quick --format json > run.json; "
        "python -m campaigns.scene_results run.json",
        "where": circumstances,
        "scenes": [
            {
                "scene": one["scene"],
                "question": one["question"],
                "answer": one["answer"],
                "outcomes": dict(sorted(Counter(x["outcome"] for x in one["records"]).items())),
            }
            for one in sorted(documents, key=lambda one: one["scene"])
        ],
    }
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    (FOLDER / "scenes.json").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    if sys.argv[1:]:
        renew(Path(sys.argv[1]))
    write(PAGES)
