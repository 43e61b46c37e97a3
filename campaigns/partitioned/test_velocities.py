"""The front of methods for semi-separable systems: interval, evaluations, what the page says."""

import math
from pathlib import Path

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned import semi_separable
from campaigns.partitioned.semi_separable import (
    BELOW,
    CHAOTIC,
    FRONT,
    SEARCHED,
    Pair,
    arrays,
    charge,
    long_run,
    needed,
)
from glmref.catalogue.lookup import load
from glmref.derive.halves import EndedHalf
from glmref.engine.parasites import step_matrix
from glmref.problems import problem

PAGE = (Path(__file__).parents[2] / "docs" / "velocities.md").read_text("utf-8")
WHOLE = measured("nonseparable")["semi-separable"]
ROWS = {x["method"]: x for x in WHOLE["front"]}
TEN, TWELVE = "multistep-kinetic-10", "multistep-kinetic-12"


def step(pair: Pair, ratio: float, h: float) -> np.ndarray:
    return step_matrix(arrays(pair.q, pair.p), charge(ratio), h)


@pytest.mark.parametrize("ratio", [-0.6, 0.4])
def test_a_step_of_the_charge_turns_by_both_frequencies(ratio: float) -> None:
    found = np.linalg.eigvals(step(Pair.of(TEN), ratio, 0.05))
    for omega in (1.0, ratio):
        assert np.abs(found - np.exp(0.05j * omega)).min() < 1e-9


def test_the_interval_ends_where_parasitic_roots_grow() -> None:
    one = Pair.of(TEN)
    h = one.interval
    worst = [max(np.abs(np.linalg.eigvals(step(one, 0.6, x)))) for x in (h, h + 0.01)]
    assert worst[0] < 1 + 1e-7 < worst[1] - 1e-4


def test_the_page_asks_for_steps_within_the_interval_for_every_ratio() -> None:
    eight = "multistep-kinetic-8"
    assert Pair.of(eight).interval == ROWS[eight]["interval"] == 0.1
    assert r"choose $h$ below $0.1/\omega$ for the fastest frequency" in PAGE


@pytest.mark.slow
def test_an_explicit_half_of_q_has_another_interval() -> None:
    one = Pair.of(TEN)
    other = Pair(EndedHalf(one.q.cosines, one.q.minus_one, explicit=True), one.p)
    assert other.interval < one.interval


def test_evaluations_are_those_of_the_first_of_two_runs_in_a_row(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    runs = [(10, 10, 1e-7), (11, 11, 1e-9), (12, 12, 1e-8), (20, 20, 1e-10), (40, 40, 1e-12)]
    monkeypatch.setattr(semi_separable, "_errors", lambda *_: iter(runs))
    steps, count = needed(load(TEN), problem("kepler")) or (0, 0)
    assert (steps, count) == (20, round(12 * math.sqrt(20 / 12)))
    monkeypatch.setattr(semi_separable, "_errors", lambda *_: iter(runs[:-1]))
    assert needed(load(TEN), problem("kepler")) is None


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
    assert tuple(ROWS) == FRONT
    assert min(FRONT, key=mean) == TWELVE
    assert f"`{TWELVE}` {mean(TWELVE):.2f} of the best Gauss" in PAGE
    assert kept(TWELVE) == kept(TEN) == set(SEARCHED)
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
    kept, lost = (found[x[:3]] for x in BELOW)
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
        if x["problem"] in largest and x["method"] in FRONT
    ]
    assert f"$h\\omega$ comes to {min(found):.1f} to {max(found):.1f}" in PAGE
    assert min(found) > 0.232  # the largest bound on the page
    assert sum(x > 1 for x in found) == len(found) - 1 == 5


@pytest.mark.slow
def test_what_is_stored_is_what_is_measured() -> None:
    (x,) = (x for x in ROWS[TWELVE]["cases"] if x["problem"] == "magnetic-trap")
    method = Pair.of(TWELVE).method
    assert (needed(method, problem(x["problem"])) or (0, 0))[1] == x["evaluations"]
    found = long_run(method, problem(x["problem"]), x["h"], 1_000_000)
    assert found == {"energy": x["energy"], "reported": x["reported"]}
