"""The tables of all pages are those of the data, and the stored answers those of the scenes."""

import re

import pytest

from campaigns import scene_results
from campaigns.pages import all_pages, filled, measured
from glmref.engine.outcome import Outcome
from glmref.scenes import load_scene, names, running

PAGES = all_pages()
#: Tables that tools/measure/engine_tables.py writes into pages of this package.
OTHERS = {"against-c"}
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
