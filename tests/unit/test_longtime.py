"""Drift records: exact on made-up series, and on problems whose behaviour is known."""

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.longtime import (
    along,
    drift,
    energy_scale,
    exponent,
    follow,
    g_form,
    watch,
)
from glmref.problems import problem
from tests.build import refused

T = np.linspace(0.0, 1000.0, 2001)


def test_random_walks_have_exponent_one_half_on_average():
    random = np.random.default_rng(1)
    steps = random.standard_normal((400, len(T) - 1))
    walks = np.hstack([np.zeros((400, 1)), np.cumsum(steps, axis=1)])
    rms = np.sqrt(np.mean(walks**2, axis=0))
    assert abs(exponent(T, rms) - 0.5) < 0.1


def test_samples_and_times_must_agree_in_number():
    refused(UsageError, "as many samples", drift, "energy", T, T[:-1])


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


def test_following_stops_where_it_is_told():
    found = follow(
        problem("pendulum"), load("rk4"), h=0.01, steps=50_000, engine="interpreted",
        lost=lambda part: True,
    )  # fmt: skip
    assert found.steps == 1000


@pytest.mark.parametrize("name", ["gsymplectic-n", "g4123", "pair-rkn-6-8b", "rk4"])
def test_following_renews_as_a_run_does(name):
    subject, method = problem("pendulum", q0="6/5"), load(name)
    options = {"h": 0.05, "steps": 250, "engine": "interpreted", "renew": 40}
    long, once = follow(subject, method, **options), solve(subject, method, **options)
    assert long.renewals == once.renewals == (0 if name == "rk4" else 6)
    assert long.start_evaluations == once.start_evaluations
    assert np.max(np.abs(long.y[-1] - once.y[-1])) < 1e-12


def test_watch_needs_history_for_the_form():
    subject = problem("rigid-body")
    found = solve(subject, "rk4", h=0.1, steps=3, engine="reference")
    refused(UsageError, "history=True", watch, subject, found, G=np.eye(1))


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
