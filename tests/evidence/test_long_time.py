"""Long runs: Brouwer's law over ten million steps, bounded energy, and where boundedness ends."""

import numpy as np
import pytest

from glmref.catalogue import load
from glmref.experiments.longtime import follow, watch
from glmref.experiments.parasitic import parasitic_size, solution_direction
from glmref.experiments.roundoff import round_off
from glmref.problems import problem

BODIES = [problem("rigid-body", inertia1=f"{16 + k}/8") for k in range(8)]
LONG = {"h": 1 / 16, "steps": 10_000_000, "solver": "fixed-point"}


@pytest.mark.slow
@pytest.mark.parametrize("name", ["g6245", "g6245-w3", "gauss-2", "gauss-3"])
def test_round_off_is_a_random_walk_over_ten_million_steps(name):
    """The exponent of a random walk is 1/2; sixteen walks give it to about 0.05."""
    found = round_off(load(name), BODIES, **LONG)
    assert found.exponent <= 0.6, found
    assert found.rms[-1] < 2e-14
    assert abs(found.mean) < found.rms[-1]


@pytest.mark.slow
@pytest.mark.parametrize("name", ["g6245-w3", "gauss-2"])
def test_compensation_alone_is_not_enough(name):
    """Rounded coefficients that miss the identities give a drift, compensated or not."""
    method, shorter = load(name), {**LONG, "steps": 1_000_000}
    strict = round_off(method, BODIES, **shorter)
    plain = [
        round_off(method, BODIES, **shorter, form="standard", arithmetic=arithmetic)
        for arithmetic in ("compensated", "naive")
    ]
    assert all(one.rms[-1] > 3 * strict.rms[-1] for one in plain), (strict, plain)
    assert strict.exponent <= 0.65


@pytest.mark.parametrize(
    ("name", "bound"), [("gauss-2", 5e-6), ("s4-symmetric", 5e-6), ("g6245", 1e-8)]
)
def test_the_energy_error_of_a_good_method_is_bounded(name, bound):
    subject = problem("pendulum")
    found = follow(subject, load(name), h=0.1, steps=50_000)
    (energy,) = watch(subject, found)
    assert energy.largest < bound
    assert abs(energy.exponent) < 0.1


def test_the_energy_error_of_a_method_that_is_not_symplectic_drifts():
    subject = problem("pendulum")
    found = follow(subject, load("rk4"), h=0.05, steps=50_000)
    (energy,) = watch(subject, found)
    assert energy.exponent == pytest.approx(1.0, abs=0.1)


@pytest.mark.slow
def test_parasitism_free_to_first_order_is_not_forever():
    """mu = 0 stops growth of first order in h; what is left needs millions of steps to show.

    The rigid body with moments (23/8, 1, 2/3), h = 1/8: the values beyond the solution of G6245
    stay where they are for four million steps, then grow exponentially; at half the step, ten
    million steps show nothing. The symmetric method of order 4 stays bounded at both.
    """
    subject = problem("rigid-body", inertia1="23/8")

    def largest(name, h, begin, end):
        method = load(name)
        found = follow(subject, method, h=h, steps=end)
        size = parasitic_size(found, solution_direction(method))
        count = found.t / h
        return float(np.max(size[(count >= begin) & (count <= end)]))

    early, late = largest("g6245", 1 / 8, 1_000, 2_000_000), largest("g6245", 1 / 8, 1, 10_000_000)
    assert early < 1e-5
    assert late > 100 * early
    assert largest("g6245", 1 / 16, 1, 10_000_000) < 1e-5
    assert largest("s4-symmetric", 1 / 8, 1, 10_000_000) < 1e-3
