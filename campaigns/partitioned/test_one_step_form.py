"""Forms of one multistep method: the sentence of the page, and velocities of differences."""

import statistics

import numpy as np
import pytest

from campaigns.pages import ROOT, measured
from campaigns.partitioned import one_step_form as forms
from campaigns.partitioned.error_front import SYMMETRIC
from campaigns.partitioned.work import mean
from glmref import solve
from glmref.problems import problem

RECORD = measured("one-step-form")


def test_the_page_gives_the_means() -> None:
    page = " ".join((ROOT / "docs" / "multivalue.md").read_text("utf-8").split())
    summed = {f"{mean(forms.gains(x, 'summed')):.2f}" for x in ("state", "energy")}
    (count,) = summed
    long = mean(forms.gains("energy", "differences"))
    slower = statistics.median(x["slower"] for x in RECORD["both"])
    assert f"need {count} times the evaluations of their one-step form" in page
    assert f"and {long:.2f} times over long horizons where velocities" in page
    assert f"A step takes {slower:.1f} times the time." in page


def test_every_method_is_counted_in_every_case() -> None:
    found = {(x["case"], x["method"]) for x in RECORD["needed"]}
    assert found == {(case, m) for case in forms.cases() for m in SYMMETRIC}
    # `dipole` over the long horizon: none reaches 1e-9 within the evaluations that are allowed
    gone = {
        x["case"] for x in RECORD["needed"] if not all(forms.KEY in n for n in x["needed"].values())
    }
    assert gone == {"dipole, long"}


@pytest.mark.parametrize("k", [1, 4, 7])
def test_differences_have_their_order(k: int) -> None:
    """They are exact on odd powers below 2k + 1, and not on that one."""
    j = np.arange(1, k + 1)
    for n in range(1, 2 * k + 2, 2):
        found = float(np.dot(forms.difference_weights(k), 2.0 * j**n))
        # weights of size one against powers up to k^n: a few roundings
        assert (abs(found - (n == 1)) < 1e-14 * k**n * k) == (n <= 2 * k)


def test_velocities_of_differences_are_those_of_the_orbit() -> None:
    """With masses, where momenta are no velocities; one order less is wrong by more."""
    given = problem("kepler", eccentricity="1/10")
    found = solve(given, "quinlan-tremaine-8", h=0.02, steps=60, every=1)
    at = np.array([20, 40])
    right = np.array([given.solution(float(t)) for t in found.t[at]])
    errors = [np.abs(forms.with_differences(given, found, at, n) - right).max() for n in (8, 2)]
    # truncation (h omega)^8 / 630, positions of 1e-13, rounding eps / h
    assert errors[0] < 1e-12 < 1e-5 < errors[1]


def test_one_row_is_that_of_the_record() -> None:
    given = {"case": "isochrone", "method": "quinlan-tremaine-8"}
    (stored,) = (x for x in RECORD["needed"] if given.items() <= x.items())
    found = forms.counts(given)
    for form, counts in stored["needed"].items():
        assert found["needed"][form] == pytest.approx(counts, rel=1e-3)
