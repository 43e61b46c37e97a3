"""The answers of the scenes that are stored, and the sentence of the page about them."""

from __future__ import annotations

from campaigns.pages import measured
from campaigns.scene_results import PAGE
from glmref.scenes import load_scene, names


def test_the_answers_are_to_the_questions_that_the_scenes_ask() -> None:
    told = {one["scene"]: one["question"] for one in measured("scenes")["scenes"]}
    assert told == {name: load_scene(name).question for name in names()}


def test_four_explicit_runs_step_over_a_pole() -> None:
    (found,) = [x["outcomes"] for x in measured("scenes")["scenes"] if x["scene"] == "blow-up"]
    assert found["completed"] == 4
    assert "four runs of explicit methods" in PAGE.read_text(encoding="utf-8")


def test_every_run_of_every_scene_ended_in_a_name() -> None:
    from glmref.engine.outcome import Outcome
    from glmref.scenes.running import BUDGET_SPENT, LOST, NOT_APPLICABLE, START_FAILED

    known = {*map(str, Outcome), BUDGET_SPENT, LOST, NOT_APPLICABLE, START_FAILED, "gave up"}
    for one in measured("scenes")["scenes"]:
        assert set(one["outcomes"]) <= known, one["scene"]
