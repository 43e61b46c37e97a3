"""Timing: median and quartiles, budgets, circumstances without names of hosts."""

import json
import os
import platform
import time

from glmref.measure.timing import Timing, circumstances, repeat


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
