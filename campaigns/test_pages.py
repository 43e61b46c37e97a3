"""The tables of all pages are those of the data, and the stored answers those of the scenes."""

import itertools
import re
from functools import cache
from importlib import import_module

import pytest

from campaigns import scene_results
from campaigns.pages import WRITERS, all_pages, filled, measured
from glmref.engine.outcome import Outcome
from glmref.scenes import load_scene, names, running

PAGES = all_pages()
#: A table that tools/measure/compare_textbook.py writes from a run.
OTHERS = {"textbook"}
#: What takes seconds: the periodicity of every pair, in balls.
SLOW = {"growth"}
TABLES = [
    pytest.param(page, name, id=name, marks=pytest.mark.slow if name in SLOW else ())
    for page, names in PAGES.items()
    for name in names
]


@pytest.mark.parametrize(("page", "name"), TABLES)
def test_a_table_of_a_page_is_that_of_the_data(page, name):
    text = page.read_text(encoding="utf-8")
    assert filled(text, {name: PAGES[page][name]}) == text, "run `python -m campaigns.pages`"


#: Tables of something else than measurements, and what no number stands for: where it was looked.
FILES = {"advice", "also", "audit-short", "audit-codes", "audit-none", "audit-findings", "growth"}
KEPT = ("marks", "h", "steps", "curve", "tolerance", "t_end", "nudge", "argument", "renew",
        "departure", "goal")  # fmt: skip


def other(found, count):
    """Return the record with larger numbers, each by its own factor, and opposite verdicts."""
    if isinstance(found, dict):
        found = {key: x if key in KEPT else other(x, count) for key, x in found.items()}
        return found | {key: f"{found[key]}!" for key in ("how", "command") if key in found}
    if isinstance(found, list):
        return [other(x, count) for x in found]
    if isinstance(found, bool):
        return not found
    if isinstance(found, int | float):
        return type(found)((1.2 + next(count) % 7 / 10) * found)
    return {None: 1.5, "bounded": "grows"}.get(found, found)


@cache
def renewed(name):
    """Return another record."""
    return other(measured(name), itertools.count())


@pytest.mark.parametrize(("page", "name"), [x for x in TABLES if x.id not in FILES])
def test_other_data_give_another_table(page, name, monkeypatch):
    for module in {import_module(x, "campaigns") for x in WRITERS}:
        if hasattr(module, "measured"):
            monkeypatch.setattr(module, "measured", renewed)
    text = page.read_text(encoding="utf-8")
    assert filled(text, {name: PAGES[page][name]}) != text


@pytest.mark.parametrize(
    "page",  # not the notes of a single campaign, which writes tables of its own there
    [page for page in PAGES if page.parent.name == "docs" or page.name == "README.md"],
    ids=lambda page: f"{page.parent.name}-{page.stem}",
)
def test_every_table_between_marks_is_computed(page):
    there = re.findall(r"<!-- table: (\S+) -->", page.read_text(encoding="utf-8"))
    assert len(set(there)) == len(there) and set(there) - OTHERS == set(PAGES[page])


def test_a_table_is_replaced_in_its_one_place():
    page = "a\n<!-- table: a -->\n| old |\n<!-- end of table -->\nb\n"
    assert filled(page, {"a": lambda: "| new |"}) == page.replace("old", "new")
    for text, count in ((2 * page, 2), (page.replace("table: a", "table: b"), 0)):
        with pytest.raises(ValueError, match=f"{count} places for the table a, not one"):
            filled(text, {"a": lambda: ""})


def test_the_answers_are_to_the_questions_that_the_scenes_ask() -> None:
    told = {one["scene"]: one["question"] for one in measured("scenes")["scenes"]}
    assert told == {name: load_scene(name).question for name in names()}


def test_four_explicit_runs_step_over_a_pole() -> None:
    (found,) = [x["outcomes"] for x in measured("scenes")["scenes"] if x["scene"] == "blow-up"]
    assert found["completed"] == 4
    assert "four runs of explicit methods" in scene_results.PAGE.read_text(encoding="utf-8")


def test_every_run_of_every_scene_ended_in_a_name() -> None:
    known = {*map(str, Outcome), running.BUDGET_SPENT, running.LOST, running.NOT_APPLICABLE}
    known |= {running.START_FAILED, "gave up"}
    for one in measured("scenes")["scenes"]:
        assert set(one["outcomes"]) <= known, one["scene"]
