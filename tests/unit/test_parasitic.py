"""Parasitic parts: derivatives of steps, modes, losses and growth that can be done by hand."""

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.kept import stepper_of
from glmref.errors import UsageError
from glmref.exact import Ball, exact
from glmref.exact.linalg import solve_affine
from glmref.measure import first_order
from glmref.measure.first_order import Coupling, FirstOrder, along, coupling_of
from glmref.measure.linearised import jacobians, step_derivatives
from glmref.measure.longtime import follow
from glmref.measure.parasitic import LOST, loss, modes, parasitic_size, solution_direction
from glmref.measure.prediction import _on_values
from glmref.measure.underlying import Underlying
from glmref.problems import Problem, problem
from glmref.theory.residuals import Residual, verdict_of
from tests.build import refused


def test_n_has_one_mode_with_the_growth_parameter_of_its_file():
    (mode,) = modes(load("gsymplectic-n"))
    assert mode.zeta == pytest.approx(-1)
    assert mode.mu == pytest.approx(1 - 2 / math.sqrt(3), abs=1e-14)
    assert mode.left @ mode.right == pytest.approx(1)


def run(name, steps, **options):
    subject = problem("pendulum", q0="23/10")
    method = load(name)
    found = follow(subject, method, h=0.1, steps=steps, engine="interpreted", **options)
    return subject, method, found, solution_direction(method)


def test_a_run_of_p_is_lost_to_its_parasitic_part():
    subject, _, found, u = run("gsymplectic-p", 200)
    told = loss(subject, found, u)
    assert told.reason == "parasitic"
    assert 13 < told.time < 15
    assert told.largest > LOST


def test_a_good_run_is_not_lost():
    subject, _, found, u = run("g6245", 200)
    told = loss(subject, found, u)
    assert (told.time, told.reason) == (None, "")
    assert told.largest < 1e-4


def test_an_energy_error_of_the_size_of_the_energy_is_a_loss():
    subject = problem("harmonic-oscillator")
    found = follow(subject, load("euler"), h=0.5, steps=100, engine="interpreted")
    told = loss(subject, found, solution_direction(load("euler")))
    assert told.reason == "energy"


def test_a_run_that_ends_early_is_lost_for_the_reason_it_gives():
    explode = Problem(f=("y[0]*y[0]",), y0=(1,))
    found = follow(explode, load("rk4"), h=0.5, steps=100, engine="reference")
    told = loss(explode, found, np.ones(1))
    assert told.reason == "not finite"


def test_the_parasitic_size_needs_all_values():
    from glmref.engine.solve import solve

    found = solve(problem("pendulum"), "rk4", h=0.1, steps=2, engine="reference")
    refused(UsageError, "history=True", parasitic_size, found, np.ones(1))


# -- derivatives of a step by its stages against differences of steps


def swing(t: float, y: np.ndarray) -> np.ndarray:
    """Return the slope of the pendulum, with a choice that symbols cannot show."""
    return np.array([y[1], -math.sin(y[0]) if y[0] < 99 else 0.0])


ORBITS = {
    "pendulum": lambda: problem("pendulum"),
    "henon-heiles": lambda: problem("henon-heiles"),
    "toda": lambda: problem("toda", sites=3),  # without a formula of its derivatives
    "not separable": lambda: problem("nonseparable-chain", sites=2),
    "two terms": lambda: Problem(
        f=("y[1] - y[0]", "-y[0]**3"), terms=(("y[1]", "-y[0]**3"), ("-y[0]", "0")), y0=(1, 0)
    ),
    "python": lambda: Problem(f=swing, y0=(0.5, 1.0)),
}


@pytest.mark.parametrize(
    ("name", "on"),
    [
        ("gsymplectic-n", "pendulum"),
        ("gauss-2", "not separable"),
        ("s3i1-w3", "toda"),
        ("pair-4-4", "toda"),
        ("pair-4-4", "henon-heiles"),
        ("gsymplectic-n-pair", "pendulum"),
        ("g6245", "python"),
        ("multistep-8", "henon-heiles"),
        ("lobatto-iiia-iiib-2", "not separable"),
        ("ars-2-2-2", "two terms"),
    ],
)
def test_a_step_is_differentiated(name: str, on: str) -> None:
    method, subject, h, tiny = load(name), ORBITS[on](), 0.1, 1e-5
    engine = stepper_of(method, subject)
    generator = np.random.default_rng(1)
    y = np.array(subject.y0) + 0.1 * generator.normal(size=(2, subject.dimension))
    values = 0.05 * generator.normal(size=(2, *engine.shape))
    values += np.array([Underlying(engine).lifted(x) for x in y])
    found = step_derivatives(method, subject, h, values)
    for x, step in zip(values, found, strict=True):
        for move, column in zip(np.eye(x.size), step.T, strict=True):
            ends = [engine.step(0.0, x + s * tiny * move.reshape(x.shape), h) for s in (1, -1)]
            seen = (ends[0].values - ends[1].values).ravel() / (2 * tiny)
            assert column == pytest.approx(seen, abs=1e-8)


def test_stages_that_are_not_solved_have_no_derivatives() -> None:
    method, stiff = load("gauss-2"), Problem(f=("-exp(40*y[0])",), y0=(1.0,))
    values = np.array([[[1.0]], [[-9.0]]])
    with np.errstate(all="ignore"):
        lost, found = step_derivatives(method, stiff, 1e6, values)
    assert np.isnan(lost).all() and np.isfinite(found).all()


# -- growth of first order along long orbits: the equation, its solution, when it is clear


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


# -- linear systems with any number of rows


def M(*rows):
    return tuple(tuple(exact(x) for x in row) for row in rows)


def test_all_solutions_of_an_underdetermined_system():
    rows = M([1, 1, 0], [0, 0, 1], [1, 1, 1])
    found = solve_affine(rows, (exact(2), exact(3), exact(5)))
    assert found.failed is None and not found.undecided
    assert found.point == (2, 0, 3)
    assert found.directions == ((-1, 1, 0),)


def test_the_size_of_a_residual_is_that_of_its_largest_entry():
    wide, wider = Ball.decimal("0.00", 2), Ball.decimal("0.0", 1)
    for row in ((wide, wider), (wider, wide)):
        assert verdict_of((row,)).residual == wider.magnitude()
    assert verdict_of(((exact(0), exact(0)),)) == Residual(True, 0.0, None)
    for rows, entry in ((((exact(-3), exact(2)),), (0, 0)), (((exact(1),), (exact(2),)), (1, 0))):
        assert verdict_of(rows).entry == entry


def test_decisions_that_balls_leave_open_are_said():
    wide = Ball.decimal("0.0", 1)
    assert solve_affine(((exact(1),), (wide,)), (exact(2), exact(0))).undecided
    opened = solve_affine(((wide,),), (exact(1),))
    assert opened.undecided and opened.failed is None and opened.point == (0,)
    only = solve_affine(((exact(0),),), (wide,))
    assert only.undecided and only.failed is None
    best = solve_affine(((Ball.decimal("0.5", 1), Ball.decimal("2.0", 1)),), (exact(1),))
    assert best.point[0] == 0 and best.point[1].contains(exact(1) / 2)
    found = solve_affine(M([1, 2], [0, 1], [1, 3]), (exact(1), exact(1), exact(3)))
    assert found.failed == 2 and found.directions == () and found.point == (-1, 1)
