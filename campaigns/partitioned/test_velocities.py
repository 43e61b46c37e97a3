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


#: Problems that the search used.
SEARCHED = {"magnetic-trap", "penning-trap", "relativistic-charge", "rotating-three-body"}


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


def test_steps_of_the_lost_runs_are_beyond_the_bounds_of_a_gyration() -> None:
    """At the largest frequencies of the page; leapfrog's interval, 1, is the longest of all."""
    largest = {"dipole-charge": 43, "magnetic-bottle": 71}
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
