"""Drifts of modified energies: the record, and one row of it measured again."""

from __future__ import annotations

import pytest

from campaigns.driver import fingerprint
from campaigns.modified_slopes import (
    DIGITS,
    METHODS,
    ORDERS,
    PROBLEMS,
    STEPS,
    drifts,
    expected,
    slopes,
)
from campaigns.pages import ROOT, measured

ROWS = measured("modified-slopes")["rows"]
#: A slope is that of the next term within so much; the page says so.
WITHIN = 0.2


def test_every_method_is_measured_on_every_problem_with_digits_to_spare():
    assert [(x["method"], x["problem"], x["steps"]) for x in ROWS] == [
        (method, on, STEPS) for method in METHODS for on in PROBLEMS
    ]
    for x in ROWS:
        assert x["fingerprint"] == fingerprint(x["method"])
        assert min(map(min, x["drifts"])) > 10.0 ** (10 - DIGITS)
        for drift, parasitic in zip(x["drifts"], x["parasitic"], strict=True):
            assert parasitic < min(drift) / 100, (x["method"], x["problem"])


@pytest.mark.slow
@pytest.mark.sampled(1, whole=2)
@pytest.mark.parametrize("method", METHODS)
def test_every_drift_falls_by_the_power_of_the_next_term(method: str) -> None:
    for x in ROWS:
        if x["method"] == method:
            assert slopes(x) == pytest.approx(expected(method), abs=WITHIN), x["problem"]


def test_the_page_says_what_the_record_shows():
    said = " ".join((ROOT / "docs" / "modified.md").read_text(encoding="utf-8").split())
    assert "within 0.2 for four methods and two pairs on five problems over 100,000 steps" in said
    assert (len(METHODS), len(PROBLEMS), STEPS, ORDERS) == (6, 5, 100_000, (1, 5, 7, 9))
    for x in ROWS:
        assert slopes(x)[1:] == pytest.approx([6, 8, 10], abs=WITHIN), (x["method"], x["problem"])


@pytest.mark.slow
@pytest.mark.parametrize("method", ["stormer-verlet", "gsymplectic-n"])
def test_a_row_comes_out_again(method: str) -> None:
    (x,) = (x for x in ROWS if (x["method"], x["problem"]) == (method, "pendulum"))
    assert drifts(method, "pendulum", 0)[0] == pytest.approx(x["drifts"][0], rel=1e-12)
