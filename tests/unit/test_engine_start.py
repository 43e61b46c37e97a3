"""Starting values: what they are, what they cost, how accurate they are."""

from dataclasses import replace

import numpy as np
import pytest

from glmref import StartingMethod, UsageError, load, problem, solve
from glmref.engine.reference import stepper
from glmref.engine.start import enhanced_start, starting_values, zero_start


def started(name, start, h=0.1, of="pendulum"):
    engine = stepper(load(name), problem(of))
    return starting_values(engine, start, t=0.0, y0=np.array(engine.problem.y0), h=h)


def test_the_zero_start_is_u_times_the_initial_value():
    engine = stepper(load("g6245"), problem("pendulum"))
    values = zero_start(engine, engine.problem.y0)
    np.testing.assert_array_equal(values[0], engine.problem.y0)
    assert not values[1:].any()
    # two past values of a multistep method are both multiples of the solution
    two = stepper(load("leapfrog"), problem("pendulum"))
    np.testing.assert_array_equal(zero_start(two, two.problem.y0)[1], two.problem.y0)


def test_many_zero_starts_at_once_are_the_single_ones():
    engine = stepper(load("stormer-verlet"), problem("kepler"))
    y0 = np.arange(12.0).reshape(3, 4)
    many = zero_start(engine, y0)
    for row, values in zip(y0, many, strict=True):
        np.testing.assert_array_equal(values, zero_start(engine, row))


def test_the_method_s_own_starting_method_is_the_default():
    found = started("thesis-3-8", None)
    assert found.evaluations == 4
    assert "enhanced" not in found.kind
    assert started("rk4", None).kind == "zero"
    assert "enhanced" in started("g6245", None).kind or load("g6245").starting is not None


@pytest.mark.sampled(1, besides=("s4", "g6245"))
@pytest.mark.parametrize("name", ["gsymplectic-n", "s4-symmetric", "g6245"])
def test_each_pass_of_the_enhanced_start_gains_an_order(name):
    # the defect of S is seen after one step: M S(y) - S((M S(y))_1), values 2..r
    def defect(passes, h):
        engine = stepper(load(name), problem("pendulum"), digits=40)
        number = engine.arithmetic.number
        y0, step = np.array(engine.problem.y0), number(h)
        values, _ = enhanced_start(engine, number(0), y0, step, passes)
        after = engine.step(number(0), values, step).values
        again, _ = enhanced_start(engine, step, after[0], step, passes)
        return max(abs(x) for x in (after - again)[1:].ravel())

    slopes = []
    for passes in (1, 2, 3):
        ratio = defect(passes, 0.05) / defect(passes, 0.025)
        slopes.append(float(np.log2(float(ratio))))
    gains = np.diff(slopes)
    assert (gains > 0.7).all(), slopes


def test_the_cost_of_the_enhanced_start_doubles_with_each_pass():
    costs = [started("s4-symmetric", ("enhanced", k)).evaluations for k in (1, 2, 3)]
    steps = [2**k - 1 for k in (1, 2, 3)]
    per_step = [cost / n for cost, n in zip(costs, steps, strict=True)]
    assert max(per_step) < 1.5 * min(per_step)


def test_the_enhanced_start_serves_multistep_methods():
    exact = solve("pendulum", "gauss-5", h=0.01, t_end=1.0).y[-1]
    errors = [
        np.abs(solve("pendulum", "ab-3", h=h, t_end=1.0, start="enhanced").y[-1] - exact).max()
        for h in (0.02, 0.01)
    ]
    assert 6.0 < errors[0] / errors[1] < 10.0, "order 3"


def test_a_pair_starts_by_the_same_iteration():
    found = started("gsymplectic-n-pair", "enhanced", of="henon-heiles")
    single = started("gsymplectic-n", ("enhanced", 4), of="henon-heiles")
    assert np.abs(found.values - single.values).max() < 1e-15


def test_values_functions_and_starting_methods_are_taken_as_given():
    values = np.array([[1.0, 0.0], [0.01, 0.02]])
    np.testing.assert_array_equal(started("gsymplectic-n", values).values, values)
    made = started("gsymplectic-n", lambda problem, h: h * values)
    np.testing.assert_array_equal(made.values, 0.1 * values)
    own = load("gsymplectic-n").starting
    assert own is not None
    assert started("gsymplectic-n", own).evaluations == own.stages


@pytest.mark.parametrize(
    ("name", "start", "message"),
    [
        ("g6245", np.zeros((3, 2)), "shape \\(r, d\\) = \\(4, 2\\)"),
        ("g6245", np.full((4, 2), np.nan), "must be finite"),
        ("g6245", "first", "`start` must be"),
        ("g6245", ("enhanced", 99), "0 to 8 passes"),
        ("g6245", load("gsymplectic-n").starting, "gives 2 values, the method carries 4"),
        ("stormer-verlet", load("gsymplectic-n").starting, "a pair starts from"),
    ],
)
def test_a_start_that_does_not_fit_is_refused(name, start, message):
    with pytest.raises(UsageError, match=message):
        started(name, start, of="kepler" if name == "stormer-verlet" else "pendulum")


def test_an_implicit_starting_method_is_solved():
    method = load("gsymplectic-n")
    implicit = StartingMethod(
        A=((load("implicit-midpoint").A[0][0],),),
        B=((method.V[0][1],), (method.V[0][0],)),
        u=(method.V[0][0], method.V[0][1]),
    )
    engine = stepper(replace(method, starting=implicit), problem("pendulum"))
    y0 = np.array(engine.problem.y0)
    found = starting_values(engine, None, t=0.0, y0=y0, h=0.1)
    stage = found.values[1] / 0.1  # = f(Y), Y = y0 + h/2 f(Y)
    again = engine.slope(0.0, y0 + 0.05 * stage)
    assert np.abs(stage - again).max() < 1e-14
