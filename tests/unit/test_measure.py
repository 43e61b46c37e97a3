"""Timing: median and quartiles, budgets, circumstances without names of hosts; attempts of runs."""

import json
import math
import os
import platform
import time
from typing import Any

import pytest

from glmref.catalogue.lookup import load
from glmref.measure.attempt import FUNCTION_FAILED, REFUSED, attempt
from glmref.measure.timing import Timing, circumstances, repeat
from glmref.problems import Problem, problem


def test_one_duration_is_its_own_quartiles():
    assert Timing.of([2.0]) == Timing(2.0, 2.0, 2.0, 1)


def test_quartiles_of_five_durations_are_the_second_and_the_fourth():
    assert Timing.of([5.0, 1.0, 4.0, 2.0, 3.0]) == Timing(3.0, 2.0, 4.0, 5)


def test_quartiles_are_in_order():
    timing = Timing.of([0.3, 0.1, 0.7, 0.2])
    assert timing.q25 <= timing.median <= timing.q75


def test_as_json_has_four_plain_numbers():
    assert json.loads(json.dumps(Timing.of([1.0]).as_json())) == {
        "median": 1.0,
        "q25": 1.0,
        "q75": 1.0,
        "repeats": 1,
    }


def test_repeat_runs_as_often_as_asked_and_returns_the_last_result():
    calls = iter(range(10))
    result, timing = repeat(lambda: next(calls), repeats=4, budget=60.0)
    assert (result, timing.repeats) == (3, 4)


def test_repeat_runs_once_even_without_a_budget():
    result, timing = repeat(lambda: "done", repeats=100, budget=0.0)
    assert (result, timing.repeats) == ("done", 1)


def test_repeat_measures_the_wall_clock():
    _, timing = repeat(lambda: time.sleep(0.01), repeats=2)
    assert timing.median >= 0.01


def test_circumstances_name_versions_and_machine_and_nothing_private():
    found = circumstances()
    text = json.dumps(found)
    assert {"machine", "system", "processor", "cores", "versions"} == set(found)
    assert {"python", "numpy", "numba"} <= set(found["versions"])
    assert os.getcwd() not in text
    assert platform.node() not in text or platform.node() in found["processor"]


def test_an_attempt_ends_in_a_name_and_hides_no_defect(monkeypatch: pytest.MonkeyPatch) -> None:
    given: dict[str, Any] = {"steps": 2, "evaluations": 20_000}
    calm = problem("harmonic-oscillator")
    found = attempt(calm, load("rk4"), h=0.1, **given)
    assert found.outcome == "completed" and found.solution is not None
    refused = attempt(calm, load("rk4"), h=math.nan, **given)
    assert refused.outcome == REFUSED and "`h` must be finite" in refused.message
    short = Problem(f=lambda t, y: y[:1], y0=[1.0, 1.0], name="user")
    failed = attempt(short, load("rk4"), h=0.1, engine="interpreted", **given)
    assert failed.outcome == FUNCTION_FAILED and "shape (2,)" in failed.message

    def broken(*args: object, **options: object) -> None:
        raise KeyError("a defect")

    monkeypatch.setattr("glmref.measure.attempt.solve", broken)
    with pytest.raises(KeyError, match="a defect"):
        attempt(calm, load("rk4"), h=0.1, **given)
