"""The reference engine against its definition: the equations a step must satisfy, and formulas."""

import mpmath
import numpy as np
import pytest

import glmref
from glmref import Problem, load, problem
from glmref.engine.arithmetic import Arithmetic, in_order
from glmref.engine.reference import stepper
from glmref.engine.starting_values import zero_start
from glmref.engine.tableau import lagrange_weights
from glmref.method.stage_order import dependency_blocks

METHODS = ["rk4", "gauss-2", "gauss-3", "gsymplectic-n", "g6245", "lobatto-iiia-3", "ab-3", "bdf-2"]


def residual(engine, t, values, h, step):
    """Largest violation of Y = h A F + U y and y+ = h B F + V y, F = f(Y)."""
    F = step.slopes
    again = [engine.slope(t + c * h, Y) for c, Y in zip(engine.c, step.stages, strict=True)]
    stages = step.stages - (h * engine.A.dot(F) + engine.U.dot(values))
    outputs = step.values - (h * engine.B.dot(F) + engine.V.dot(values))
    parts = [stages, outputs, h * (F - np.stack(again))]
    return max(abs(x) for part in parts for x in part.ravel())


@pytest.mark.parametrize("name", METHODS)
def test_a_step_satisfies_the_equations_that_define_it(name):
    engine = stepper(load(name), problem("double-pendulum"))
    values = zero_start(engine, engine.problem.y0)
    values[1:] = 0.01
    step = engine.step(0.0, values, 0.05)
    assert step.converged
    # stages are settled to a few units of round-off of |y| ~ 1.5
    assert residual(engine, 0.0, values, 0.05, step) < 2e-15


@pytest.mark.parametrize("name", ["gauss-2", "g6245", "rk4"])
def test_a_step_in_fifty_digits_satisfies_its_equations_to_fifty_digits(name):
    engine = stepper(load(name), problem("kepler"), digits=50)
    h = engine.arithmetic.number("0.05")
    step = engine.step(engine.arithmetic.number(0), zero_start(engine, engine.problem.y0), h)
    assert step.converged
    assert (
        residual(engine, 0, zero_start(engine, engine.problem.y0), h, step) < mpmath.mpf(10) ** -47
    )


def test_stages_are_evaluated_at_their_abscissae():
    # y' = 5 t^4 is integrated exactly by order 5 and more, only if t + c_i h is right
    quintic = Problem(f=("5*t**4",), y0=(0.0,))
    for name, exact in (("gauss-3", True), ("rk4", False), ("g6245", True)):
        engine = stepper(load(name), quintic)
        step = engine.step(1.0, zero_start(engine, engine.problem.y0), 0.5)
        error = abs(float(step.values[0, 0]) - (1.5**5 - 1))
        assert (error < 1e-14) == exact, name


def test_the_complex_form_of_a_method_steps_like_its_real_form():
    pendulum = problem("pendulum")
    real, other = stepper(load("g6245-w3"), pendulum), stepper(load("g6245-w3-complex"), pendulum)
    y, z = zero_start(real, real.problem.y0), zero_start(other, other.problem.y0)
    for _ in range(5):
        y = real.step(0.0, y, 0.1).values
        z = other.step(0.0, z, 0.1).values
    assert np.abs(y[0] - z[0]).max() < 4e-15


def test_stormer_verlet_is_kick_drift_kick():
    hh = problem("henon-heiles")
    q, p, h = np.array(hh.y0[:2]), np.array(hh.y0[2:]), 0.1
    half = p + h / 2 * hh.force(q)
    new_q = q + h * half
    new_p = half + h / 2 * hh.force(new_q)
    step = stepper(load("stormer-verlet"), hh).step(0.0, np.array([hh.y0]), h)
    assert np.abs(step.values[0] - np.concatenate([new_q, new_p])).max() < 2e-16
    assert (step.evaluations, step.velocity_evaluations) == (2, 1)


def test_stages_are_ordered_by_what_they_need():
    edges = {(0, 2), (1, 0), (2, 2), (3, 4), (4, 3), (4, 0)}
    blocks = dependency_blocks(5, lambda i, j: (i, j) in edges)
    assert [(b.stages, b.implicit) for b in blocks] == [
        ((2,), True), ((0,), False), ((1,), False), ((3, 4), True)
    ]  # fmt: skip


def test_lagrange_weights_carry_a_polynomial_of_full_degree():
    nodes = [glmref.engine.tableau.Fraction(k, 3) for k in (-2, 0, 1)]
    weights = lagrange_weights(nodes, glmref.engine.tableau.Fraction(2))
    for power in range(3):
        assert sum(w * x**power for w, x in zip(weights, nodes, strict=True)) == 2**power
    assert sum(w * x**3 for w, x in zip(weights, nodes, strict=True)) != 8


# --- its arithmetic -------------------------------------------------------------------------------


SMALL = "1e-60"


@pytest.mark.parametrize("rows", [
    [["0", "1"], ["1", "0"]], [[SMALL, "1"], ["1", "1"]], [["1", "2", "3"], ["2", "4", "1"], ["3", "1", "1"]],
    [["0", "0", "1"], ["0", "0.25", "1"], ["2", "1", "1"]],
])  # fmt: skip
def test_systems_that_need_an_exchange_of_rows_are_solved(rows):
    arithmetic = Arithmetic(40)
    context = arithmetic.context
    a = np.array([[context.mpf(x) for x in row] for row in rows], dtype=object)
    wanted = np.array([context.mpf(k + 2) / 7 for k in range(len(rows))], dtype=object)
    many = np.stack([wanted, 3 * wanted], axis=1)
    for x in (wanted, many):
        found = arithmetic.solve(a, a.dot(x))
        assert np.abs(found - x).max() < context.mpf(10) ** -37
    with pytest.raises(np.linalg.LinAlgError, match="singular"):
        arithmetic.solve(a * 0, wanted)


@pytest.mark.parametrize("columns", [1, 2, 7])
def test_terms_are_added_one_after_the_other_however_many_are_summed_at_once(columns):
    generator = np.random.default_rng(columns)
    weights, rows = generator.normal(size=17), generator.normal(size=(17, columns, 5))
    weights[[2, 11]] = 0
    expected = np.zeros((columns, 5))
    for w, row in zip(weights, rows, strict=True):
        expected = expected + w * row
    assert np.array_equal(in_order(weights, rows), expected)
    for k in range(5):
        assert np.array_equal(in_order(weights, rows[..., k]), expected[:, k])
    assert np.array_equal(in_order(0 * weights, rows[..., 0]), np.zeros(columns))
    # a sum by pairs, or with two sums at a time, has other bits
    assert not np.array_equal((weights[:, None] * rows[:, 0]).T.copy().sum(axis=1), expected[0])
