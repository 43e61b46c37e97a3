"""The front of methods for semi-separable systems: interval, evaluations, what the page says."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned import semi_separable
from campaigns.partitioned.semi_separable import (
    CHAOTIC,
    FOUND,
    FRONT,
    SEARCHED,
    Pair,
    long_run,
    needed,
)
from glmref.catalogue.lookup import load
from glmref.derive import recipes
from glmref.derive.general_multistep import EndedHalf

PAGE = (Path(__file__).parents[2] / "docs" / "velocities.md").read_text("utf-8")
WHOLE = measured("nonseparable")["semi-separable"]
ROWS = {x["method"]: x for x in WHOLE["front"]}
TEN = "multistep-kinetic-10"


@pytest.mark.parametrize("ratio", [-0.6, 0.4])
def test_a_step_of_the_charge_turns_by_both_frequencies(ratio: float) -> None:
    found = np.linalg.eigvals(Pair.of(TEN).step(0.05, ratio))
    for omega in (1.0, ratio):
        assert np.abs(found - np.exp(0.05j * omega)).min() < 1e-9


def test_the_interval_ends_where_parasitic_roots_grow() -> None:
    one = Pair.of(TEN)
    h = one.interval
    worst = [max(np.abs(np.linalg.eigvals(one.step(x, 0.6)))) for x in (h, h + 0.01)]
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
    steps, count = needed(load(TEN), "-") or (0, 0)
    assert (steps, count) == (20, round(12 * math.sqrt(20 / 12)))
    monkeypatch.setattr(semi_separable, "_errors", lambda *_: iter(runs[:-1]))
    assert needed(load(TEN), "-") is None


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
    assert f"comes to {min(map(mean, FRONT)):.3f} of Gauss" in PAGE
    assert min(FRONT, key=mean) == "found-12"
    assert kept("found-12") == kept(TEN) == set(SEARCHED)
    assert kept("found-10") < kept(TEN)


def test_the_page_says_how_chaotic_the_bottle_is() -> None:
    times = {x["method"]: x["reported"] for x in WHOLE["moved"]}
    (low, high), (less, more) = (
        (f"{min(times[m]):.0f}", f"{max(times[m]):.0f}") for m in (TEN, "multistep-kinetic-8")
    )
    assert f"between {low} and {high} (`-10`) or {less} and {more} (`-8`)" in PAGE
    first = {x["method"]: x["reported"] for x in WHOLE["long"] if x["problem"] == CHAOTIC}
    assert all(first[m] == x[0] for m, x in times.items())


def test_the_page_has_the_roots_of_the_command() -> None:
    q, p = FOUND["found-12"]
    assert f'--q "{q}"' in PAGE
    assert f'--p "{p}"' in PAGE


@pytest.mark.slow
def test_the_roots_make_a_proved_method() -> None:
    q, p = FOUND["found-12"]
    found = recipes.run("general-multistep", {"q": q, "p": p, "kind": "semi-separable"})
    (statement,) = found.statements
    assert re.search(r"order 12 on all systems, symmetric", statement.text)


@pytest.mark.slow
def test_what_is_stored_is_what_is_measured() -> None:
    (x,) = (x for x in ROWS["found-12"]["cases"] if x["problem"] == "magnetic-trap")
    method = Pair.of("found-12").method
    assert (needed(method, x["problem"]) or (0, 0))[1] == x["evaluations"]
    found = long_run(method, x["problem"], x["h"], 1_000_000)
    assert found == {"energy": x["energy"], "reported": x["reported"]}
