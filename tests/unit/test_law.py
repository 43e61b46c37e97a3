"""Laws of error growth, on made-up deviations and on known runs."""

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.law import fit_law, samples_of
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
    kepler, method = problem("kepler"), load("rk4")
    run = solve(kepler, method, h=0.1, steps=2, every=1)
    with pytest.raises(UsageError, match="conserves no 'heat'; it has energy, angular momentum"):
        samples_of(kepler, method, run, "heat")
    with pytest.raises(UsageError, match="has no 'form of angular momentum'"):
        samples_of(kepler, method, run, "form of angular momentum")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameters", "method", "h", "steps", "kind"),
    [
        ("pendulum", {"q0": "23/10"}, "gsymplectic-p", 0.1, 400, "blow-up"),
        ("pendulum", {"q0": "23/10"}, "rk4", 0.1, 4096, "linear"),
        ("pendulum", {"q0": "23/10"}, "gauss-2", 0.1, 4096, "bounded"),
        ("pendulum", {"q0": "23/10"}, "g6245", 0.1, 2048, "bounded"),
        ("harmonic-oscillator", {}, "ab-2", 0.05, 2048, "linear"),
        ("rigid-body", {}, "rk4", 0.1, 32768, "linear"),
    ],
)
def test_laws_of_known_runs(name, parameters, method, h, steps, kind):
    subject, one = problem(name, **parameters), load(method)
    run = solve(subject, one, h=h, steps=steps, every=max(1, steps // 2048))
    deviation = samples_of(subject, one, run, "energy")
    assert fit_law(run.t, deviation, ended=not run.completed).kind == kind
