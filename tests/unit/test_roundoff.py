"""The round-off meter: what it refuses, and that it tells a kept form from a lost one."""

import json

import pytest

from glmref.catalogue import load
from glmref.claims import UsageError
from glmref.experiments.roundoff import round_off
from glmref.problems import problem

BODIES = [problem("rigid-body", inertia1=n) for n in (2, "17/8")]
OPTIONS = {"h": 1 / 16, "steps": 2000, "first": 100, "engine": "interpreted"}


@pytest.mark.parametrize("name", ["gauss-1", "gsymplectic-n"])
def test_a_kept_form_shows_round_off_only(name):
    found = round_off(load(name), BODIES, **OPTIONS)
    assert found.runs == 4
    assert found.steps[-1] == 2000 and found.steps[0] >= 100
    # a few units of the last place after 2000 steps
    assert max(found.rms) < 100 * 2.0**-53
    assert abs(found.mean) <= max(found.rms)


def test_a_form_that_is_not_kept_shows_a_drift():
    found = round_off(load("euler"), BODIES, **OPTIONS)
    assert max(found.rms) > 1e-9
    assert found.exponent > 0.9


def test_the_record_is_plain_json():
    found = round_off(load("gauss-1"), BODIES[:1], **{**OPTIONS, "steps": 200})
    assert json.loads(json.dumps(found.as_json(), allow_nan=False))["runs"] == 2


@pytest.mark.parametrize(
    ("name", "problems", "message"),
    [
        ("ab-2", BODIES, "no form G"),
        ("gauss-1", [problem("pendulum")], "no quadratic invariants"),
    ],
)
def test_what_cannot_be_measured_is_refused(name, problems, message):
    with pytest.raises(UsageError, match=message):
        round_off(load(name), problems, **OPTIONS)
