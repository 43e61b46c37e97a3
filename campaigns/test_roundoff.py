"""The round-off meter: what it refuses, and that it tells a kept form from a lost one."""

import json

import pytest

from campaigns.pages import measured
from campaigns.roundoff import STEPS, VARIANTS, bodies, cases, options_of, round_off, row
from glmref.catalogue.lookup import load
from glmref.compute.records import in_json
from glmref.errors import UsageError
from glmref.problems import problem

BODIES = [problem("rigid-body", inertia1=n) for n in (2, "17/8")]
STORED = measured("roundoff")["rows"]
OPTIONS = {"h": 1 / 16, "steps": 2000, "first": 100, "engine": "interpreted"}


@pytest.mark.sampled(1)
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
    assert json.loads(json.dumps(in_json(found), allow_nan=False))["runs"] == 2


@pytest.mark.parametrize(
    ("name", "problems", "message"),
    [("ab-2", BODIES, "no form G"), ("gauss-1", [problem("pendulum")], "no quadratic invariants")],
)
def test_what_cannot_be_measured_is_refused(name, problems, message):
    with pytest.raises(UsageError, match=message):
        round_off(load(name), problems, **OPTIONS)


def test_every_variant_is_another_kernel():
    for name, exact in (("gauss-2", "mu form"), ("gsymplectic-n", "sweep form")):
        kernels = []
        for variant in VARIANTS:
            options = {**OPTIONS, **options_of(load(name), variant), "steps": 200}
            kernels.append(round_off(load(name), BODIES[:1], **options).kernel)
        assert len(set(kernels)) == 4
        assert [exact in kernel for kernel in kernels] == [True, True, False, False]
        assert ["not compensated" in kernel for kernel in kernels] == [False, True, False, True]


def test_the_bodies_differ_and_have_two_invariants_each():
    assert len({str(body.parameters) for body in bodies(8)}) == 8
    assert all(len(body.quadratic) == 2 for body in bodies(8))


def test_a_run_has_no_chance_in_it():
    case = {"method": "gauss-1", "variant": "rounded tableau, plain sums"}
    assert row(case, steps=20_000) == row(case, steps=20_000)


def test_every_variant_is_in_the_record():
    known = [{k: x[k] for k in ("method", "variant", "fingerprint")} for x in STORED]
    assert known == cases() and all(x["steps"][-1] == STEPS for x in STORED)


def test_a_pair_is_refused():
    with pytest.raises(UsageError, match="pair of methods"):
        row({"method": "stormer-verlet", "variant": "exact form, plain sums"}, steps=1000)
