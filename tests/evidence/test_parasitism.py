"""Parasitism measured: rates against mu f', losses against prediction, bounded where mu = 0.

The scene is the pendulum from 2.3 radians with h = 0.1 (Butcher, Habib, Hill and Norton 2014;
Khan 2018, section 3.1): P is lost at t about 14, N at about 1062.
"""

import math

import numpy as np
import pytest
from mpmath import ellipk, sin

from glmref.catalogue.lookup import load, names
from glmref.exact.expression import parse
from glmref.measure.longtime import follow, watch
from glmref.measure.parasitic import loss, modes, solution_direction
from glmref.problems import problem
from tests.evidence.propagators import growth, predicted_propagator
from tests.shipped import shipped

PENDULUM = problem("pendulum", q0="23/10")
PERIOD = float(4 * ellipk(sin(1.15) ** 2))
FREE = ("thesis-3-8", "s4-symmetric", "g6245", "g6245-w3")
#: Complex coefficients; growth of second order in h that a million steps show, see below.
SPECIAL = {*FREE, "g6245-w3-complex", "s3i1-w3", "s5i1-i"}


def test_the_predicted_propagator_of_a_linear_problem_is_an_exponential():
    subject = problem("harmonic-oscillator")
    found = predicted_propagator(0.5, subject, time=2.0)
    # exp(mu t J) is a rotation by mu t = 1; the classical method errs by 800 h^5 / 120
    expected = [[math.cos(1), math.sin(1)], [-math.sin(1), math.cos(1)]]
    assert np.max(np.abs(found - expected)) < 1e-11
    assert predicted_propagator(1j, subject, time=1.0)[0, 0] == pytest.approx(math.cosh(1))


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["gsymplectic-n", "gsymplectic-p"])
def test_the_measured_growth_rate_is_that_of_mu_f_prime_within_two_percent(name):
    method = load(name)
    found = growth(method, PENDULUM, h=PERIOD / 200, time=PERIOD)
    (claimed,) = (float(parse(text)) for text in method.claims["growth"])
    assert found.mu.real == pytest.approx(claimed, abs=1e-14)
    assert found.predicted_rate > 0.01
    assert found.rate == pytest.approx(found.predicted_rate, rel=0.02)
    assert found.discrepancy < 0.01


@pytest.mark.slow
def test_the_measured_rate_approaches_the_predicted_one_with_the_square_of_h():
    gaps = []
    for steps in (100, 200, 400):
        found = growth(load("gsymplectic-n"), PENDULUM, h=PERIOD / steps, time=PERIOD)
        gaps.append(abs(found.rate - found.predicted_rate))
    assert 3.5 < gaps[0] / gaps[1] < 4.5
    assert 3.5 < gaps[1] / gaps[2] < 4.5


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["leapfrog", "milne-simpson", "gsymplectic-n"])
def test_decay_makes_a_parasitic_part_grow_at_minus_mu(name):
    from glmref.problems import Problem

    decay = Problem(f=("-y[0] - y[0]*y[0]/4",), y0=(1,))
    for mode in modes(load(name)):
        found = growth(load(name), decay, h=0.005, time=3.0, mode=mode)
        assert found.rate == pytest.approx(found.predicted_rate, rel=0.02)


@pytest.mark.slow
def test_a_wrong_growth_parameter_does_not_pass():
    found = growth(load("gsymplectic-p"), PENDULUM, h=PERIOD / 200, time=PERIOD)
    (other,) = (float(parse(text)) for text in load("gsymplectic-n").claims["growth"])
    assert abs(other) < 0.1 * abs(found.mu)
    assert (
        found.rate > 10 * growth(load("gsymplectic-n"), PENDULUM, h=PERIOD / 200, time=PERIOD).rate
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", FREE)
def test_a_method_with_mu_zero_carries_its_parasitic_part_unchanged(name):
    for mode in modes(load(name)):
        if mode.zeta.imag < -1e-9:
            continue
        found = growth(load(name), PENDULUM, h=PERIOD / 400, time=PERIOD, mode=mode)
        assert abs(found.mu) < 1e-15
        # the identity to leading order; what is left is of second order in h
        assert np.max(np.abs(found.measured - np.eye(2))) < 0.05
        assert abs(found.rate) < 1e-3


def without_growth(least):
    """G-symplectic methods with several values and no growth parameter, of some order or more."""
    return [
        name
        for name in names("methods")
        if shipped(name)["class"] in ("glm", "sweep")
        and shipped(name)["claims"].get("parasitism-free") is True
        and shipped(name)["claims"].get("g-symplectic") is True
        and shipped(name)["claims"]["order"] >= least
    ]


@pytest.mark.sampled(4)
@pytest.mark.parametrize("name", without_growth(6))
def test_the_growth_parameters_of_methods_of_order_six_and_more_vanish(name):
    # simple modes all; each mu is a sum of (s + r)^2 products of rounded numbers
    method = load(name)
    found = modes(method)
    assert len(found) == method.r - 1
    assert max(abs(mode.mu) for mode in found) < (method.s + method.r) ** 2 * 2.0**-52


def follow_pendulum(name, steps):
    method = load(name)
    u = solution_direction(method)
    found = follow(
        PENDULUM,
        method,
        h=0.1,
        steps=steps,
        lost=lambda part: loss(PENDULUM, part, u).time is not None,
    )
    return found, loss(PENDULUM, found, u)


@pytest.mark.parametrize(
    ("name", "time", "percent"), [("gsymplectic-p", 14.0, 4), ("gsymplectic-n", 1062.0, 1)]
)
def test_p_is_lost_at_about_14_and_n_at_about_1062(name, time, percent):
    _, told = follow_pendulum(name, 20_000)
    assert told.reason == "parasitic"
    assert told.time == pytest.approx(time, rel=percent / 100)


@pytest.mark.slow
def test_n_survives_where_mu_f_prime_does_not_grow():
    gentle = problem("pendulum", q0="6/5")
    method = load("gsymplectic-n")
    assert (
        growth(method, gentle, h=0.05, time=float(4 * ellipk(sin(0.6) ** 2))).predicted_rate < 1e-6
    )
    found = follow(gentle, method, h=0.1, steps=20_000)
    assert loss(gentle, found, solution_direction(method)).time is None


#: Energy errors over the run: h^4 and h^6 times constants of the methods, see the scene's table.
BOUNDS = {"thesis-3-8": 2e-6, "s4-symmetric": 2e-6, "g6245": 1e-9, "g6245-w3": 1e-9}


@pytest.mark.sampled(0)
@pytest.mark.parametrize("name", FREE)
def test_parasitism_free_methods_stay_bounded_over_a_million_steps(name):
    found, told = follow_pendulum(name, 1_000_000)
    assert (found.completed, found.steps, told.time) == (True, 1_000_000, None)
    assert told.largest < 3e-3
    (energy,) = watch(PENDULUM, found)
    assert energy.largest < BOUNDS[name]
    # the running samples reach back to t = 2000 and beyond: bounded there, and no growth since
    assert abs(energy.exponent) < 0.1
    assert math.isfinite(energy.slope)


@pytest.mark.slow
@pytest.mark.sampled(1, whole=5)
@pytest.mark.parametrize(
    "name",
    [n for n in without_growth(6) if shipped(n)["claims"]["order"] == 6 and n not in SPECIAL],
)
def test_the_other_methods_of_order_six_stay_bounded_over_a_million_steps(name):
    found, told = follow_pendulum(name, 1_000_000)
    assert (found.completed, found.steps, told.time) == (True, 1_000_000, None)
    # smooth values beyond u y_1 are part of it: a few hundredths for methods that carry them
    assert told.largest < 0.05
    (energy,) = watch(PENDULUM, found)
    assert energy.largest < 1e-6
    assert abs(energy.exponent) < 0.1


@pytest.mark.slow
def test_s3i1_has_no_growth_parameter_and_is_lost_all_the_same_after_half_a_million_steps():
    """mu = 0 stops growth of first order in h, not that of higher order: it begins at round-off."""
    found, told = follow_pendulum("s3i1-w3", 1_000_000)
    assert told.reason == "parasitic"
    assert 20_000 < told.time < 90_000
    # at half the step the same time passes, and the energy has only begun to show it
    half = follow(PENDULUM, load("s3i1-w3"), h=0.05, steps=2_000_000)
    assert loss(PENDULUM, half, solution_direction(load("s3i1-w3"))).time is None
    (energy,) = watch(PENDULUM, half)
    assert energy.largest < 1e-6
