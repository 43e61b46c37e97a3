"""The tables of docs/scene-results.md are those of the data."""

from __future__ import annotations

import pytest

from campaigns.pages import filled
from campaigns.scene_results import PAGE, TABLES, measured
from glmref.scenes import load_scene, names


def test_the_tables_of_the_page_are_those_of_the_data() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert filled(text, TABLES) == text, "run `python -m campaigns.scene_results`"


@pytest.mark.parametrize("name", TABLES)
def test_a_table_that_is_out_of_date_or_in_another_place_is_noticed(name: str) -> None:
    text = PAGE.read_text(encoding="utf-8")
    cut = TABLES[name]().rpartition("\n")[0]
    changed = text.replace(TABLES[name](), cut)
    assert filled(changed, TABLES) == text != changed
    with pytest.raises(ValueError, match="0 places"):
        filled(text.replace(f"<!-- table: {name} -->", ""), TABLES)


def test_the_answers_are_to_the_questions_that_the_scenes_ask() -> None:
    told = {one["scene"]: one["question"] for one in measured("scenes")["scenes"]}
    assert told == {name: load_scene(name).question for name in names()}


def test_four_explicit_runs_step_over_a_pole() -> None:
    (found,) = [x["outcomes"] for x in measured("scenes")["scenes"] if x["scene"] == "blow-up"]
    assert found["completed"] == 4
    assert "four runs of explicit methods" in PAGE.read_text(encoding="utf-8")


def test_every_run_of_every_scene_ended_in_a_name() -> None:
    from glmref.measure.attempt import OUTCOMES
    from glmref.scenes.running import BUDGET_SPENT, LOST, NOT_APPLICABLE, START_FAILED

    known = {*OUTCOMES, BUDGET_SPENT, LOST, NOT_APPLICABLE, START_FAILED, "gave up"}
    for one in measured("scenes")["scenes"]:
        assert set(one["outcomes"]) <= known, one["scene"]
