"""Growth of first order along long orbits: the equation, its solution, when it is clear."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.kept import stepper_of
from glmref.measure import first_order
from glmref.measure.first_order import Coupling, FirstOrder, along, coupling_of
from glmref.measure.linearised import jacobians
from glmref.measure.prediction import _on_values
from glmref.problems import problem
from glmref.problems.model import Problem


@pytest.mark.parametrize("name", ["milne-simpson", "gsymplectic-n", "g6245", "multistep-general-8"])
def test_the_coupling_has_the_derivatives_of_the_eigenvalues(name: str) -> None:
    """On y' = i y an eigenvalue zeta of V goes on as zeta exp(i mu h), mu the growth parameter."""
    method, circle = load(name), problem("harmonic-oscillator")
    engine, h = stepper_of(method, circle), 1e-6
    values = np.zeros(engine.shape)
    moves = np.eye(values.size)
    step = np.array([engine.step(0, x.reshape(engine.shape), h).values.ravel() for x in moves]).T
    V, bundles = _on_values(engine)
    J = np.array([[0.0, 1.0], [-1.0, 0.0]])
    assert np.allclose(step, V, atol=1e-4)
    for b in bundles:
        (M,) = coupling_of(engine, b.zeta, b.left, b.right).of(J[None])
        seen = b.left @ (step - V) @ b.right / (h * b.zeta)
        assert np.allclose(M, seen, atol=1e-4)


def identity(d: int) -> Coupling:
    """Return the coupling of a part that obeys the variational equation of the solution."""
    return Coupling(np.ones((d, d)), np.arange(d))


def test_the_slope_of_the_orbit_is_a_part_with_the_growth_parameter_one(monkeypatch):
    monkeypatch.setattr(first_order, "BLOCK", 1 << 14)
    monkeypatch.setattr(first_order, "NUMBERS", 1 << 16)
    swing = problem("pendulum")
    slope = lambda y: np.array(swing.f(0.0, y), dtype=float)  # noqa: E731
    found = along(swing, 0.001, identity(2), slope(np.array(swing.y0, dtype=float)))
    assert found is not None
    y, longer = first_order._orbit(swing, 0.001, 1 << 14) or (np.zeros(0), 0)
    assert found.steps[1] == first_order.CHUNK * longer
    sizes = np.array([float(np.linalg.norm(slope(x))) for x in y[:: first_order.CHUNK]])
    # the midpoint rule turns by 0.008^2 / 12 of the time too little, and the period of the
    # pendulum depends on the size: by t = 40 that is 0.008^2 / 12 * 40^2 = 0.0085, a few times
    assert np.exp(found.logarithms[:80]) == pytest.approx(sizes[:80] / sizes[0], abs=0.05)


def made_up(logarithms: np.ndarray) -> FirstOrder:
    count = len(logarithms)
    return FirstOrder(np.arange(count) * 10.0, logarithms, np.ones((count, 1)))


def test_growth_on_the_orbit_says_when() -> None:
    found = made_up(np.linspace(0, 20, 2001)).reached(np.exp(10.0))
    assert found is not None
    assert found[0] == pytest.approx(10_000, abs=10) and found[1] == pytest.approx(1e-3)


@pytest.mark.parametrize(
    ("logarithms", "clear"),
    [
        (np.linspace(0, 8, 2001), True),
        (np.linspace(0, 6, 2001), False),  # too little
        (np.minimum(np.linspace(0, 80, 2001), 8), False),  # it has stopped
        (np.sin(np.linspace(0, 80, 2001)), False),
    ],
)
def test_growth_goes_on_beyond_the_orbit_where_it_is_clear(logarithms, clear):
    found = made_up(logarithms).reached(np.exp(30.0))
    assert (found is not None) == clear
    if found is not None:
        assert found[0] == pytest.approx(20_000 * 30 / 8)


def test_a_system_of_many_components_has_no_long_orbit() -> None:
    large = problem("toda", sites=256)
    assert along(large, 0.1, identity(2), np.ones(large.dimension)) is None


def test_python_that_takes_one_state_is_differentiated_and_not_followed_for_long() -> None:
    """A right-hand side with a choice cannot be recorded; one component is zero all along."""

    def f(t: float, y: np.ndarray) -> list[float]:
        return [y[1], -math.sin(y[0]) if y[0] < 9 else 0.0, 2 * y[0] + 3 * y[2]]

    given = Problem(f=f, y0=(1, 0, 0), hamiltonian=lambda y: y[1] ** 2 / 2 - np.cos(y[0]))
    y = np.array([[0.5, 1.0, 0.0], [1.5, -1.0, 0.0]])
    found = jacobians(given, y)
    for J, (q, *_) in zip(found, y, strict=True):
        assert J == pytest.approx(np.array([[0, 1, 0], [-math.cos(q), 0, 0], [2, 0, 3]]), abs=1e-9)
    assert along(given, 0.1, identity(3), np.ones(3)) is None
