"""Laws of error growth, on made-up deviations and on runs whose cause is known."""

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.errors import UsageError
from glmref.measure.law import diagnose, fit_law, samples_of
from glmref.problems import problem

T = np.arange(0, 4097.0)


@pytest.mark.parametrize(
    ("kind", "power"), [("bounded", 0.0), ("random walk", 0.5), ("linear", 1.0), ("quadratic", 2.0)]
)
def test_pure_powers_have_their_law(kind, power):
    wave = 2 + np.sin(T)
    law = fit_law(T, np.where(T > 0, 1e-9 * T**power * wave / 4096**power, 0.0))
    assert law.kind == kind
    # the wave averages out over the 100 and more periods of each stretch
    assert law.exponent == pytest.approx(power, abs=0.05)
    assert law.time == 4096


def test_random_walks_are_random_walks():
    # one walk's exponent scatters by 0.3; the mean of 64 has a standard error of 0.04
    steps = np.random.default_rng(1).standard_normal((64, len(T) - 1))
    walks = np.concatenate([np.zeros((64, 1)), np.cumsum(steps, axis=1)], axis=1) * 1e-16
    rms = np.sqrt(np.mean(walks**2, axis=0))
    assert fit_law(T, rms).kind == "random walk"
    assert fit_law(T, rms).exponent == pytest.approx(0.5, abs=0.12)


def test_what_reaches_its_own_size_or_ends_early_has_blown_up():
    grown = fit_law(T, np.exp(T / 100) * 1e-9)
    assert grown.kind == "blow-up" and math.isnan(grown.exponent)
    # 1e-9 exp(t/100) = 1 at t = 100 log(1e9)
    assert grown.time == pytest.approx(100 * math.log(1e9), abs=1)
    assert fit_law(T, 0 * T, ended=True).kind == "blow-up"
    assert fit_law(T, np.where(T > 9, math.nan, 0.0)).time == 10


def test_nothing_is_bounded():
    law = fit_law(T, 0 * T)
    assert (law.kind, law.largest, law.last) == ("bounded", 0.0, 0.0)


def test_unknown_quantities_are_refused():
    from glmref.engine.solve import solve

    kepler, method = problem("kepler"), load("rk4")
    run = solve(kepler, method, h=0.1, steps=2, every=1)
    with pytest.raises(UsageError, match="conserves no 'heat'; it has energy, angular momentum"):
        samples_of(kepler, method, run, "heat")
    with pytest.raises(UsageError, match="has no 'form of angular momentum'"):
        samples_of(kepler, method, run, "form of angular momentum")


# problem, its parameters, method, h, steps, quantity, arithmetic, law, cause
KNOWN = [
    ("pendulum", {"q0": "23/10"}, "gsymplectic-p", 0.1, 400, "energy", "strict", "blow-up",
     "parasitism"),
    ("pendulum", {"q0": "23/10"}, "rk4", 0.1, 4096, "energy", "strict", "linear", "drift"),
    ("pendulum", {"q0": "23/10"}, "g6245", 0.1, 2048, "energy", "strict", "bounded",
     "bounded truncation"),
    ("pendulum", {"q0": "23/10"}, "gauss-2", 0.1, 4096, "energy", "strict", "bounded",
     "bounded truncation"),
    ("harmonic-oscillator", {}, "ab-2", 0.05, 2048, "energy", "strict", "linear", "drift"),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("case", KNOWN, ids=lambda case: f"{case[2]}-{case[0]}")
def test_laws_and_causes_of_known_runs(case):
    name, parameters, method, h, steps, quantity, arithmetic, kind, cause = case
    found = diagnose(
        problem(name, **parameters), load(method), h=h, steps=steps, quantity=quantity,
        precise_steps=100, arithmetic=arithmetic,
    )  # fmt: skip
    assert (found.law.kind, found.cause) == (kind, cause)
    if cause in ("drift", "bounded truncation"):
        # what is of order p in h; of rk4 on the pendulum and of ab-2 on the oscillator the secular
        # part of the energy error is one order smaller
        order = {"rk4": 5, "ab-2": 3, "gauss-2": 4, "g6245": 6}[method]
        assert found.order == pytest.approx(order, abs=0.2)


@pytest.mark.slow
def test_what_a_higher_precision_removes_is_round_off():
    """Gauss-2 keeps the energy of the rigid body exactly: what is seen of it is round-off.

    The near miss is the same run of rk4, whose drift stays at any precision.
    """
    body = problem("rigid-body")
    walk = diagnose(
        body, load("gauss-2"), h=0.1, steps=4096, quantity="energy", precise_steps=64,
        arithmetic="naive", digits=25,
    )  # fmt: skip
    assert walk.cause == "round-off"
    assert walk.law.largest < 1e-13
    drift = diagnose(body, load("rk4"), h=0.1, steps=32768, precise_steps=200)
    assert (drift.cause, drift.law.kind) == ("drift", "linear")


def test_records_are_plain_json():
    import json

    found = diagnose(
        problem("harmonic-oscillator"), load("rk4"), h=0.1, steps=64, precise_steps=8
    ).as_json()
    assert json.loads(json.dumps(found, allow_nan=False))["law"]["kind"]
