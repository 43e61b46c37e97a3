"""Methods for semi-separable systems: what the record of the front has, what the page says."""

from pathlib import Path

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned.nonseparable import long_run, step_of
from glmref.catalogue.lookup import load
from glmref.problems import problem

PAGE = (Path(__file__).parents[2] / "docs" / "velocities.md").read_text("utf-8")
WHOLE = measured("nonseparable")["semi-separable"]
ROWS = {x["method"]: x for x in WHOLE["front"]}
TEN, TWELVE = "multistep-kinetic-10", "multistep-kinetic-12"


#: Where the time of a notice changes with the last bits.
CHAOTIC = "magnetic-bottle"
#: Problems that the search used, and steps below which every gyration is stable.
SEARCHED = {"magnetic-trap", "penning-trap", "relativistic-charge", "rotating-three-body"}
BELOW = ((TWELVE, "dipole-charge", 0.0016), (TEN, "magnetic-bottle", 0.0008))


def test_the_page_asks_for_steps_within_the_interval_for_every_ratio() -> None:
    assert ROWS["multistep-kinetic-8"]["interval"] == 0.1
    assert r"choose $h$ below $0.1/\omega$ for the fastest frequency" in PAGE


def mean(name: str) -> float:
    """Return the evaluations over those of the best Gauss method."""
    return float(np.exp(np.mean(np.log([x["over_gauss"] for x in ROWS[name]["cases"]]))))


def kept(name: str) -> set[str]:
    """Return the problems on which the energy is not lost; a loss has a notice."""
    cases = ROWS[name]["cases"]
    lost = [x for x in cases if x["energy"] is None or x["energy"] > 1e-8]
    assert all(x["reported"] for x in lost)
    return {x["problem"] for x in cases if x not in lost}


def test_the_page_gives_the_best_of_the_front() -> None:
    assert min(ROWS, key=mean) == TWELVE
    assert f"`{TWELVE}` {mean(TWELVE):.2f} of the best Gauss" in PAGE
    assert kept(TWELVE) == kept(TEN) == SEARCHED
    assert kept("found-10") < kept(TEN)


def test_the_page_says_how_chaotic_the_bottle_is() -> None:
    steps = {x["method"]: x["h"] for x in WHOLE["long"] if x["problem"] == CHAOTIC}
    here = [x for x in WHOLE["moved"] if x["problem"] == CHAOTIC and x["h"] == steps[x["method"]]]
    times = {x["method"]: x["reported"] for x in here}
    (low, high), (less, more) = (
        (f"{min(times[m]):.0f}", f"{max(times[m]):.0f}") for m in (TEN, "multistep-kinetic-8")
    )
    assert f"between {low} and {high} (`-10`) or {less} and {more} (`-8`)" in PAGE
    first = {x["method"]: x["reported"] for x in WHOLE["long"] if x["problem"] == CHAOTIC}
    assert all(first[m] == x[0] for m, x in times.items())


def test_the_page_says_what_a_smaller_step_does_not_keep() -> None:
    found = {(x["method"], x["problem"], x["h"]): x["reported"] for x in WHOLE["moved"]}
    kept, lost = (found[x] for x in BELOW)
    assert kept == [None] * 4
    assert f"At $h = {BELOW[0][2]}$ it is not, at four starts." in PAGE
    (time,) = (x for x in lost if x)
    assert len(lost) == 4
    assert f"at $h = {BELOW[1][2]}$ at one of four starts, at {time:,.0f}" in PAGE
    # the largest frequencies, and the bounds of a gyration, on the page
    assert 43 * BELOW[0][2] < 0.177
    assert 71 * BELOW[1][2] < 0.232
    assert [x[0] for x in BELOW] == [TWELVE, TEN]


def test_steps_of_the_lost_runs_are_beyond_the_bounds_of_a_gyration() -> None:
    """At the largest frequencies of the page; leapfrog's interval, 1, is the longest of all."""
    largest = {"dipole-charge": 43, CHAOTIC: 71}
    assert all(f"{omega} until" in PAGE for omega in largest.values())
    found = [
        largest[x["problem"]] * x["h"]
        for x in WHOLE["long"]
        if x["problem"] in largest and x["method"] in ROWS
    ]
    assert f"$h\\omega$ comes to {min(found):.1f} to {max(found):.1f}" in PAGE
    assert min(found) > 0.232  # the largest bound on the page
    assert sum(x > 1 for x in found) == len(found) - 1 == 5


@pytest.mark.slow
def test_what_is_stored_is_what_is_measured() -> None:
    (x,) = (x for x in ROWS[TWELVE]["cases"] if x["problem"] == "magnetic-trap")
    one = problem(x["problem"])
    assert step_of(load(TWELVE), one) == (x["h"], x["evaluations"])
    assert long_run(TWELVE, one, x["h"], 1_000_000) == {k: x[k] for k in ("energy", "reported")}
