"""Losses of long runs, seen and predicted: the record, and what the page says of it."""

import pytest

from campaigns.driver import fingerprint
from campaigns.pages import measured
from campaigns.parasitic_losses import (
    ELSE,
    KINDS,
    LEAVES,
    LEVELS,
    PAGE,
    STEPS,
    WITHIN,
    agrees,
    cases,
    counts,
    departs,
    lost_at,
    row,
    saturated,
)
from glmref.measure.prediction import SATURATES

ROWS = measured("parasitic-losses")["rows"]


def test_the_record_holds_the_runs_that_it_says():
    keys = ("method", "problem", "fingerprint", "h", "survey")
    stored = {tuple(x[key] for key in keys) for x in ROWS}
    assert stored == {tuple(x[key] for key in keys) for x in cases()} and len(stored) == len(ROWS)
    for name, known in {(x["method"], x["fingerprint"]) for x in ROWS}:
        assert known == fingerprint(name)
    for x in ROWS:
        assert (x["passed"] is None) == (x["survey"] == "bounded")
        if x["passed"] is not None:
            steps = [STEPS if n is None else n for n in x["passed"]]
            assert steps == sorted(steps) and len(steps) == len(LEVELS) and steps[-1] <= STEPS


def _run(passed, verdict="lost", steps=None):
    return {"survey": "lost", "method": "g6245", "passed": [1] * (12 - len(passed)) + passed,
            "predicted": {"verdict": verdict, "steps": steps, "level": None, "departure": None}}  # fmt: skip


def test_what_saturates_and_what_agrees():
    # steps of 1e-5, 1e-4, .. 1e-1
    assert not saturated(_run([2000, 3000, 4000, 5000, 6000]))
    assert saturated(_run([2000, 3000, 4000, 9000, 15_000]))
    assert not saturated(_run([2, 3, 4, 9000, 15_000]))  # the error of the steps, no growth
    assert saturated(_run([2000, 3000, 4000, None, None])) and lost_at(_run([None])) == STEPS
    said = [agrees(_run([1000], "lost", steps)) for steps in (499, 500, 2000, 2001)]
    assert said == [False, True, True, False]
    assert not agrees(_run([1000], "saturates", 1000)) and not agrees(_run([1000], "open"))
    found = counts([_run([1000], "lost", 900), _run([1000], "lost", 90), _run([1000], "open")])
    assert list(found.values()) == [3, 0, 1, 1, 0, 0, 1, 0, 0]


def test_when_a_departure_agrees():
    x = _run([2000, None])  # 1e-2 and 1e-1

    def told(departure):
        x["predicted"]["departure"] = departure
        return departs(x)

    assert told([0.01, 1340.0]) and told([0.01, 3000.0])
    assert not any(told([0.01, steps]) for steps in (1330.0, 3010.0, None))
    # not passed, not recorded, not predicted
    assert not any(map(told, ([0.1, 2000.0], [1e-13, 2000.0], None)))


def test_the_sentences_of_the_page_are_those_of_the_record():
    free, first, bounded = (counts([x for x in ROWS if kind(x)]) for kind in KINDS.values())
    said = " ".join(PAGE.read_text(encoding="utf-8").split())
    for found, of in ((free, "are zero"), (first, "are not")):
        known = f"{found[WITHIN]} of {found['runs']} lost runs whose growth parameters {of}"
        assert known in said
        assert f"in {found[LEAVES]} of those whose growth parameters {of}" in said
    assert f"{bounded[ELSE]} of {bounded['runs']} bounded runs" in said
    both, seen = free["seen and predicted to saturate"], free["seen to saturate before the loss"]
    known = f"{both} of {seen} runs that saturate before they are lost are predicted to saturate"
    assert f"{known}, and {free[SATURATES] - both} other" in said


@pytest.mark.slow
@pytest.mark.parametrize("name", ["s3i1-w3", "s5i1-i"])
def test_runs_and_predictions_repeat(name):
    x = next(x for x in ROWS if x["method"] == name and x["problem"] == "kepler, e = 1/10")
    found = row(x)
    assert found["predicted"]["verdict"] == x["predicted"]["verdict"]
    assert found["predicted"]["steps"] == pytest.approx(x["predicted"]["steps"], rel=0.05)
    # round-off decides when another part ends the saturation
    assert found["passed"][8] == pytest.approx(x["passed"][8], rel=0.05)
