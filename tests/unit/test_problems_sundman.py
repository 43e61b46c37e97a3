"""The transformed time keeps the Hamiltonian form, and its orbits are those of the problem."""

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.problems import Problem, problem
from glmref.problems.sundman import time_transformed
from tests.build import high, refused

RADIUS = "sqrt(y[0]*y[0] + y[1]*y[1])"


def symplectic_defect(p, y):
    """Largest entry of J S + (J S)^T with S = J^-1 f'(y): zero where f is Hamiltonian."""
    m = p.dimension // 2
    J = np.block([[np.zeros((m, m)), np.eye(m)], [-np.eye(m), np.zeros((m, m))]])
    S = J.T @ np.asarray(p.jacobian(0.0, y))
    return np.max(np.abs(S - S.T)) / np.max(np.abs(S))


@pytest.mark.parametrize("e", ["0", "9/10", "999/1000"])
def test_the_orbit_is_that_of_kepler_at_the_time_it_says(e):
    p, plain = problem("kepler-sundman", eccentricity=e), problem("kepler", eccentricity=e)
    context = high(40)
    fine, reference = p.on(context), plain.on(context)
    for s in (0.3, 2.0, 7.5):
        y = fine.exact(context.mpf(s), fine.y0)
        z = reference.exact(y[2], reference.y0)
        assert max(abs(y[i] - z[i]) for i in (0, 1)) < 1e-30
        assert max(abs(y[3 + i] - z[2 + i]) for i in (0, 1)) < 1e-28
    # s is the eccentric anomaly: a turn takes the period
    assert abs(fine.exact(2 * context.pi, fine.y0)[2] - 2 * context.pi) < 1e-35


def test_the_general_transformation_gives_the_same_equations():
    p = problem("kepler-sundman", eccentricity="9/10")
    general = time_transformed(problem("kepler", eccentricity="9/10"), RADIUS)
    assert general.y0.tolist() == pytest.approx(p.y0.tolist(), rel=1e-15)
    y = np.array([0.3, -0.2, 5.0, 0.4, 1.1, 0.6])
    # r times (H + w) against its expansion: a few roundings of terms of size one
    assert general.f(0.0, y) == pytest.approx(p.f(0.0, y), rel=1e-14, abs=1e-15)
    assert general.hamiltonian(y) == pytest.approx(p.hamiltonian(y), abs=1e-14)
    assert general.quadratic["angular momentum"](y) == p.quadratic["angular momentum"](y)


@pytest.mark.parametrize(
    ("name", "rate"),
    [("kepler", RADIUS), ("henon-heiles", "1 + y[0]*y[0]"), ("pendulum", "1/(2 + y[1]*y[1])")],
)
def test_transformed_equations_are_hamiltonian_again(name, rate):
    p = time_transformed(problem(name), rate)
    y = np.array(p.y0) + 0.01 * np.arange(1, p.dimension + 1)
    # differences of a few roundings of the derivatives
    assert symplectic_defect(p, y) < 1e-13


def test_equations_scaled_alone_are_not():
    # near miss: g f instead of J grad (g (H + w))
    plain = problem("pendulum")
    assert plain.expressions is not None
    rate = "(2 + y[0]*y[0])"
    scaled = Problem(f=tuple(f"{rate}*({x})" for x in plain.expressions), y0=plain.y0)
    assert symplectic_defect(scaled, np.array([0.7, 0.4])) > 1e-3


@pytest.mark.slow
def test_a_constant_step_keeps_a_sharp_orbit():
    """At e = 0.99, 800 steps a period: right to 1e-6 in s, and nothing in t."""
    method, steps = load("g6245-w3"), 8000
    ends = []
    for name in ("kepler-sundman", "kepler"):
        p = problem(name, eccentricity="99/100")
        found = solve(p, method, h=20 * math.pi / steps, steps=steps)
        assert found.completed
        right = p.solution(20 * math.pi)[:2]
        ends.append(float(np.linalg.norm(found.y[-1][:2] - right) / np.linalg.norm(right)))
    assert ends[0] < 1e-9 < 1e-1 < ends[1]


@pytest.mark.slow
def test_the_angular_momentum_is_kept_to_round_off_by_a_symplectic_method():
    p = problem("kepler-sundman", eccentricity="99/100")
    found = solve(p, load("gauss-3"), h=0.02, steps=3000, every=50)
    form = p.quadratic["angular momentum"]
    values = np.array([form(y) for y in found.y])
    # a random walk of 3000 steps with a rounding each in terms of size 10
    assert np.max(np.abs(values - values[0])) < 3000 * 10 * 2.0**-53


def test_what_cannot_be_transformed_is_refused():
    refused(UsageError, "must be canonical", time_transformed, problem("lotka-volterra"), "y[0]")
    refused(UsageError, "must be canonical", time_transformed, problem("pythagorean"), "y[0]")
    p = problem("kepler-sundman")
    refused(UsageError, "w > 0", p.exact, 1.0, [1.0, 0.0, 0.0, 0.0, 1.0, -0.5])
