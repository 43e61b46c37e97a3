"""Drift records: exact on made-up series, and on problems whose behaviour is known."""

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.longtime import (
    along,
    drift,
    energy_deviation,
    energy_scale,
    exponent,
    follow,
    g_form,
    watch,
)
from glmref.problems import Problem, problem

T = np.linspace(0.0, 1000.0, 2001)


@pytest.mark.parametrize("power", [0.0, 0.5, 1.0, 2.0])
def test_the_exponent_of_a_power_is_that_power(power):
    # the stretches are dyadic, so that a pure power gives its exponent but for the sampling
    assert abs(exponent(T, 1e-9 * T**power) - power) < 0.02


def test_a_bounded_oscillation_has_exponent_zero():
    assert abs(exponent(T, np.sin(7 * T))) < 0.05


def test_random_walks_have_exponent_one_half_on_average():
    random = np.random.default_rng(1)
    steps = random.standard_normal((400, len(T) - 1))
    walks = np.hstack([np.zeros((400, 1)), np.cumsum(steps, axis=1)])
    rms = np.sqrt(np.mean(walks**2, axis=0))
    assert abs(exponent(T, rms) - 0.5) < 0.1


def test_no_exponent_from_nothing_or_from_too_little():
    assert math.isnan(exponent(T, 0 * T))
    assert math.isnan(exponent(T[:10], T[:10]))
    assert math.isnan(exponent(T, np.full_like(T, np.nan)))


def test_drift_is_relative_to_the_first_value():
    found = drift("energy", T, -2.0 + 1e-3 * T, kind="hamiltonian")
    assert (found.start, found.scale) == (-2.0, 2.0)
    assert found.largest == pytest.approx(0.5)
    assert found.last == pytest.approx(0.5)
    assert found.slope == pytest.approx(5e-4)


def test_a_quantity_that_starts_at_zero_is_measured_absolutely():
    assert drift("momentum", T, 1e-3 * T).largest == pytest.approx(1.0)


def test_samples_and_times_must_agree_in_number():
    with pytest.raises(UsageError, match="as many samples"):
        drift("energy", T, T[:-1])


def test_the_record_is_plain_json():
    found = drift("energy", T, np.full(len(T), np.nan)).as_json()
    assert found["largest"] is None and found["quantity"] == "energy"


def test_functions_of_states_work_on_rows_even_if_they_are_not_vectorised():
    y = np.arange(12.0).reshape(6, 2)
    expected = y[:, 0] + y[:, 1]
    assert np.array_equal(along(lambda s: s[0] + s[1], y), expected)
    assert np.array_equal(along(lambda s: float(s[0]) + float(s[1]), y), expected)
    square = np.arange(4.0).reshape(2, 2)
    assert np.array_equal(along(lambda s: s[0], square), square[:, 0])


def test_g_form_is_the_double_sum():
    random = np.random.default_rng(3)
    history = random.standard_normal((5, 3, 2))
    G, C = random.standard_normal((3, 3)), random.standard_normal((2, 2))
    G, C = G + G.T, C + C.T
    expected = [
        sum(G[i, j] * row[i] @ C @ row[j] for i in range(3) for j in range(3)) for row in history
    ]
    assert np.allclose(g_form(history, G, C), expected, rtol=1e-13)


@pytest.mark.parametrize("steps", [1, 999, 1000, 1001, 5000])
def test_following_in_stretches_is_one_long_run(steps):
    subject, method = problem("pendulum"), load("rk4")
    long = follow(subject, method, h=0.01, steps=steps, engine="interpreted")
    once = solve(subject, method, h=0.01, steps=steps, engine="interpreted")
    assert (long.steps, long.evaluations) == (steps, 4 * steps)
    # a stretch restarts the compensation of y, nothing else
    assert np.max(np.abs(long.y[-1] - once.y[-1])) < 1e-12
    assert long.t[-1] == pytest.approx(steps * 0.01, rel=1e-12)
    assert np.all(np.diff(long.t) > 0)
    assert len(long.t) == len(long.y) == len(long.history) <= steps + 1


def test_following_keeps_few_rows_of_many_steps():
    found = follow(problem("pendulum"), load("rk4"), h=0.01, steps=16000, engine="interpreted")
    assert len(found.t) <= 6000


def test_following_stops_where_it_is_told():
    found = follow(
        problem("pendulum"), load("rk4"), h=0.01, steps=50_000, engine="interpreted",
        lost=lambda part: True,
    )  # fmt: skip
    assert found.steps == 1000


def test_following_carries_the_values_of_a_multivalue_method():
    subject, method = problem("pendulum", q0="6/5"), load("gsymplectic-n")
    long = follow(subject, method, h=0.05, steps=1200, engine="interpreted")
    once = solve(subject, method, h=0.05, steps=1200, engine="interpreted", history=True)
    assert np.max(np.abs(long.history[-1] - once.history[-1])) < 1e-11


@pytest.mark.parametrize("name", ["gsymplectic-n", "g4123", "pair-rkn-6-8b", "rk4"])
def test_following_renews_as_a_run_does(name):
    subject, method = problem("pendulum", q0="6/5"), load(name)
    options = {"h": 0.05, "steps": 250, "engine": "interpreted", "renew": 40}
    long, once = follow(subject, method, **options), solve(subject, method, **options)
    assert long.renewals == once.renewals == (0 if name == "rk4" else 6)
    assert long.start_evaluations == once.start_evaluations
    assert np.max(np.abs(long.y[-1] - once.y[-1])) < 1e-12


def test_watch_names_what_a_problem_conserves():
    subject = problem("rigid-body")
    method = load("gsymplectic-n")
    found = follow(subject, method, h=0.1, steps=200, engine="interpreted")
    G = np.array([[float(x) for x in row] for row in method.G])
    kinds = [(one.quantity, one.kind) for one in watch(subject, found, G=G)]
    assert kinds == [
        ("momentum", "quadratic"),
        ("energy", "quadratic"),
        ("momentum", "form"),
        ("energy", "form"),
    ]


def test_watch_needs_history_for_the_form():
    subject = problem("rigid-body")
    found = solve(subject, "rk4", h=0.1, steps=3, engine="reference")
    with pytest.raises(UsageError, match="history=True"):
        watch(subject, found, G=np.eye(1))


def test_watch_of_a_problem_without_invariants_is_empty():
    plain = Problem(f=("y[1]", "-y[0]"), y0=(1, 0))
    assert watch(plain, solve(plain, "rk4", h=0.1, steps=3, engine="reference")) == []


def test_an_energy_that_cancels_is_measured_by_its_terms():
    """In Sundman's time the energy is H - H_0 times a factor: zero at the start but for rounding.

    With e = 0.9 the terms of Kepler's energy are of size 1 to 20, not 1e-16 and not 1e5.
    """
    transformed = problem("kepler-sundman", eccentricity=0.9)
    start = np.asarray(transformed.y0, dtype=float)
    assert abs(along(transformed.hamiltonian, start[None])[0]) < 1e-14
    assert 0.1 < energy_scale(transformed, start) < 100
    # where nothing cancels it is the energy itself, to the last bit
    plain = problem("kepler", eccentricity=0.9)
    start = np.asarray(plain.y0, dtype=float)
    assert energy_scale(plain, start) == abs(plain.hamiltonian(start))


def test_the_deviation_of_the_energy_is_relative_to_the_first_row():
    p = problem("harmonic-oscillator")
    y = np.array([[1.0, 0.0], [0.0, 1.0], [2.0, 0.0]])
    energy = along(p.hamiltonian, y)
    expected = np.abs(energy - energy[0]) / abs(energy[0])
    np.testing.assert_array_equal(energy_deviation(p, y), expected)
    assert expected[2] == 3.0
