"""The round-off meter: what it refuses, and that it tells a kept form from a lost one."""

import json

import pytest

from campaigns.roundoff import VARIANTS, bodies, main, options_of, round_off, rows
from glmref.catalogue.lookup import load
from glmref.compute.records import in_json
from glmref.errors import UsageError
from glmref.problems import problem

BODIES = [problem("rigid-body", inertia1=n) for n in (2, "17/8")]
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


def test_known_rows_are_passed_on_and_the_others_measured():
    found = list(rows(methods=["gauss-1"], steps=20_000))
    assert [row["variant"] for row in found] == list(VARIANTS)
    marked = [{**found[1], "exponent": "known"}]
    again = list(rows(methods=["gauss-1"], steps=20_000, known=marked))
    assert [row["exponent"] == "known" for row in again] == [False, True, False, False]
    assert again[0] == found[0]  # a run has no chance in it


def test_the_command_keeps_rows_that_a_file_holds(tmp_path, capsys):
    path = tmp_path / "folder" / "roundoff.json"
    kept = [
        {"method": "gauss-1", "variant": variant, "steps": [10_000_000], "exponent": 0.5}
        for variant in VARIANTS
    ]
    path.parent.mkdir()
    path.write_text(json.dumps({"rows": kept}), encoding="utf-8")
    assert main([str(path), "gauss-1"]) == 0
    assert json.loads(path.read_text(encoding="utf-8"))["rows"] == kept
    assert capsys.readouterr().err.count("exponent 0.500") == 4


def test_the_command_without_a_file_says_how_it_is_used(capsys):
    assert main([]) == 2
    assert capsys.readouterr().err.startswith("usage: ")


def test_a_pair_is_refused():
    with pytest.raises(UsageError, match="pair of methods"):
        list(rows(methods=["stormer-verlet"], steps=1000))
