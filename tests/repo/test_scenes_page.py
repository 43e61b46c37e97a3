"""The tables of docs/scenes.md are those of the data.

``python tests/repo/test_scenes_page.py`` puts them in; with the output of ``glmref run --all --quick --format
json`` as an argument it first renews data/measurements/scenes.json.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.lookup import data_root
from glmref.scenes import load_scene, names

PAGE = Path(__file__).parents[2] / "docs" / "scenes.md"
FOLDER = data_root() / "measurements"


def measured(name: str) -> dict[str, Any]:
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def row(*cells: object) -> str:
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def table(head: list[str], rows: list[str]) -> str:
    return "\n".join([row(*head), "|" + "---|" * len(head), *rows])


def scenes() -> str:
    """Every scene, its question and its answer."""
    rows = [
        row(f"`{one['scene']}`", one["question"], one["answer"])
        for one in measured("scenes")["scenes"]
    ]
    return table(["scene", "question", "answer"], rows)


def stiff() -> str:
    """Counts beside those of scipy."""
    rows = []
    for one in measured("stiff-cost")["rows"]:
        step = f"h = {one['h']:.3g}" if one["h"] else f"tol {one['tolerance']:.0e}"
        error = one["outcome"] if one["error"] is None else f"{one['error']:.1e}"
        matrices = f"{one['matrices']:,} of {one['size']}"
        problem = f"{one['problem']}, t = {one['t_end']:g}"
        count = f"{one['evaluations']:,}"
        rows.append(
            row(problem, one["name"], step, error, count, f"{one['jacobians']:,}", matrices)
        )
    head = ["problem", "method", "step", "error", "evaluations", "Jacobians", "matrices"]
    return table(head, rows)


def long() -> str:
    """A hundred million steps."""
    rows = []
    for run in measured("pendulum-1e8")["runs"]:
        law, memory = run["law"], run["peak_memory_mb"]
        exponent = "-" if law["exponent"] is None else f"{law['exponent']:.3f}"
        when = "" if law["kind"] != "blow-up" else f" at t = {law['time']:.3g}"
        growth = memory["at the end"] - memory["after 1 per cent"]
        rows.append(
            row(
                f"`{run['method']}`", run["h"], law["kind"] + when, exponent,
                f"{law['largest']:.1e}", f"{run['seconds']['process']:.0f} s", f"{growth:.1f} MB",
            )
        )  # fmt: skip
    head = ["method", "h", "law of the energy error", "exponent", "largest", "processor", "memory"]
    return table(head, rows)


TABLES: Mapping[str, Callable[[], str]] = {"scenes": scenes, "stiff": stiff, "long": long}


def filled(text: str) -> str:
    """The page with every table put in anew."""
    for name, make in TABLES.items():
        pattern = rf"(<!-- table: {name} -->\n).*?(<!-- end of table -->)"
        text, count = re.subn(
            pattern, lambda m, make=make: f"{m[1]}{make()}\n{m[2]}", text, flags=re.DOTALL
        )
        assert count == 1, f"docs/scenes.md has {count} places for the table {name!r}"
    return text


def test_the_tables_of_the_page_are_those_of_the_data() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert filled(text) == text, "python tests/repo/test_scenes_page.py puts them in"


@pytest.mark.parametrize("name", TABLES)
def test_a_table_that_is_out_of_date_or_in_another_place_is_noticed(name: str) -> None:
    text = PAGE.read_text(encoding="utf-8")
    cut = TABLES[name]().rpartition("\n")[0]
    assert filled(text.replace(TABLES[name](), cut)) == text != text.replace(TABLES[name](), cut)
    with pytest.raises(AssertionError, match="0 places"):
        filled(text.replace(f"<!-- table: {name} -->", ""))


def test_the_answers_are_to_the_questions_that_the_scenes_ask() -> None:
    told = {one["scene"]: one["question"] for one in measured("scenes")["scenes"]}
    assert told == {name: load_scene(name).question for name in names()}


def test_every_run_of_every_scene_ended_in_a_name() -> None:
    from glmref.measure.attempt import OUTCOMES
    from glmref.scenes.running import BUDGET_SPENT, LOST, NOT_APPLICABLE, START_FAILED

    known = {*OUTCOMES, BUDGET_SPENT, LOST, NOT_APPLICABLE, START_FAILED, "gave up"}
    for one in measured("scenes")["scenes"]:
        assert set(one["outcomes"]) <= known, one["scene"]


def renew(path: Path) -> None:
    """Take questions and answers of a run into the data."""
    documents = json.loads(path.read_text(encoding="utf-8"))
    circumstances = documents[0]["records"][0]["where"]
    document = {
        "format": "glmref-measurement-1",
        "what": "the answer of every scene, with the step sizes of --quick",
        "how": "glmref run --all --quick --format json > run.json; python tests/repo/test_scenes_page.py run.json",
        "where": circumstances,
        "scenes": [
            {
                "scene": one["scene"],
                "question": one["question"],
                "answer": one["answer"],
                "outcomes": outcomes(one["records"]),
            }
            for one in sorted(documents, key=lambda one: one["scene"])
        ],
    }
    text = json.dumps(document, indent=1, ensure_ascii=False, allow_nan=False)
    (FOLDER / "scenes.json").write_text(text + "\n", encoding="utf-8")


def outcomes(records: list[dict[str, Any]]) -> dict[str, int]:
    """How often each outcome was met."""
    found: dict[str, int] = {}
    for record in records:
        found[record["outcome"]] = found.get(record["outcome"], 0) + 1
    return dict(sorted(found.items()))


if __name__ == "__main__":
    if len(sys.argv) > 1:
        renew(Path(sys.argv[1]))
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
