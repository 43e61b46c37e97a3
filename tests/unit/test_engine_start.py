"""Starting values: what they are, what they cost, how accurate they are."""

from dataclasses import replace

import numpy as np
import pytest

from glmref import GLM, Problem, StartingMethod, UsageError, load, problem, solve
from glmref.engine.outcome import StartFailed
from glmref.engine.reference import stepper
from glmref.engine.starting_values import RENEWAL, enhanced_start, renewal_of, starting_values


def started(name, start, h=0.1, of="pendulum"):
    engine = stepper(load(name), problem(of))
    return starting_values(engine, start, t=0.0, y0=np.array(engine.problem.y0), h=h)


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


def test_values_are_made_anew_where_parasitic_parts_stay_as_they_are():
    # carried values, and a form or a symmetry that keeps the size of what is wrong in them
    for name in ("g6245", "leapfrog", "gsymplectic-n-pair", "s4-symmetric"):
        assert renewal_of(load(name)) == RENEWAL == 10_000
    for name in ("rk4", "gauss-2", "stormer-verlet", "ab-3", "bdf-2"):
        assert renewal_of(load(name)) == 0


def test_starts_are_named():
    assert started("ab-3", None).kind == "enhanced, 3 passes"
    assert started("ab-3", "enhanced").kind == "enhanced, 3 passes"
    assert started("ab-3", ("enhanced", 1)).kind == "enhanced, 1 passes"
    assert started("ab-3", "zero").kind == "zero"
    assert started("gsymplectic-n", np.zeros((2, 2))).kind == "given"
    assert started("gsymplectic-n", lambda problem, h: np.zeros((2, 2))).kind == "given"
    # 2^k - 1 trial steps
    assert [started("ab-3", ("enhanced", k)).evaluations for k in range(4)] == [0, 1, 3, 7]
    steps = [started("g6245", ("enhanced", k)).evaluations for k in (1, 2)]
    assert 2 * steps[0] < steps[1] < 4 * steps[0]


def test_values_that_cannot_start_are_refused_in_a_sentence():
    for start, sentence in [
        (
            [[1.0, 2.0], [3.0]],
            "starting values must be an array of numbers, got [[1.0, 2.0], [3.0]]",
        ),
        (
            [["a", "b"]] * 2,
            "starting values must be an array of numbers, got [['a', 'b'], ['a', 'b']]",
        ),
        (np.full((2, 2), 1j), "starting values must be real for a real method, got complex ones"),
        (("enhanced", -1), "`passes` must be a whole number from 0 to 8, got -1"),
        (("enhanced", 1.5), "`passes` must be a whole number from 0 to 8, got 1.5"),
    ]:
        with pytest.raises(UsageError) as found:
            started("gsymplectic-n", start)
        assert str(found.value) == sentence
    other = GLM([["0"]], [["1", "0"]], [["1"], ["0"]], [["1/2", "0"], ["0", "1/3"]])
    engine = stepper(other, problem("pendulum"))
    with pytest.raises(UsageError, match="needs a preconsistent method"):
        starting_values(engine, None, t=0.0, y0=np.ones(2), h=0.1)
    growth = stepper(load("bdf-2"), Problem(f=("y[0]*y[0]",), y0=(1.0,)))
    with pytest.raises(StartFailed, match="a trial step of the enhanced start failed; use a small"):
        starting_values(growth, None, t=0.0, y0=np.ones(1), h=2.0)


def test_a_complex_method_starts_from_complex_values():
    run = solve("kepler", "g6245-w3-complex", h=0.01, steps=4, engine="reference")
    assert np.iscomplexobj(run.values)
    onward = solve(
        "kepler", "g6245-w3-complex", h=0.01, steps=4, engine="reference", start=run.values
    )
    whole = solve("kepler", "g6245-w3-complex", h=0.01, steps=8, engine="reference")
    np.testing.assert_allclose(onward.values, whole.values, rtol=0, atol=1e-13)
