"""A user's own problems, from plain Python functions, in every engine."""

import math

import numpy as np
import pytest

from glmref import Problem, solve
from glmref.engine.outcome import Outcome

INTERPRETED = ("reference", "interpreted")
ALL = [*INTERPRETED, pytest.param("compiled", marks=pytest.mark.slow)]  # numba takes a second each


def pendulum(t, y):
    return [y[1], -math.sin(y[0])]


@pytest.mark.parametrize("engine", ALL)
@pytest.mark.parametrize("method", ["rk4", "gauss-2", "g6245", "bdf-2"])
def test_a_plain_function_is_stepped_like_its_expressions(method, engine):
    plain = Problem(f=pendulum, y0=(1.2, 0.0), name="plain")
    same = Problem(f=("y[1]", "-sin(y[0])"), y0=("6/5", 0), name="expressions")
    options = {"h": 0.1, "steps": 10, "engine": engine, "solver": "fixed-point"}
    ours, theirs = solve(plain, method, **options), solve(same, method, **options)
    assert ours.completed
    np.testing.assert_array_equal(ours.y, theirs.y)
    assert ours.evaluations == theirs.evaluations


def importing(t, y):
    import math

    return [y[1], -math.sin(y[0])]


def collecting(*state, **options):
    return [state[1][1], -np.sin(state[1][0])]


@pytest.mark.slow
@pytest.mark.parametrize("f", [importing, collecting])
@pytest.mark.parametrize("arithmetic", ["strict", "fused"])
def test_what_numba_refuses_in_a_way_of_its_own_is_interpreted_too(f, arithmetic):
    run = solve(Problem(f=f, y0=(1.0, 0.0)), "rk4", h=0.1, steps=5, arithmetic=arithmetic)
    assert run.completed and run.kernel.startswith("python")
    assert any("numba cannot compile" in x for x in run.notices)
    pendulum = Problem(f=lambda t, y: [y[1], -np.sin(y[0])], y0=(1.0, 0.0))
    np.testing.assert_allclose(run.y, solve(pendulum, "rk4", h=0.1, steps=5).y, rtol=1e-14)


@pytest.mark.slow
def test_what_numba_cannot_compile_is_interpreted_with_a_notice_for_pairs_too():
    state = {"k": 1.0}

    def opaque(q):
        return [-state["k"] * q[0]]

    plain = Problem(dq=lambda p: [p[0]], dp=opaque, y0=(1.0, 0.0), name="opaque")
    run = solve(plain, "stormer-verlet", h=0.1, steps=20)
    assert run.kernel.startswith("python")
    assert any("numba cannot compile" in x and "interpreted" in x for x in run.notices)
    exact = solve(Problem(force=("-q[0]",), y0=(1, 0)), "stormer-verlet", h=0.1, steps=20)
    np.testing.assert_array_equal(run.y, exact.y)


@pytest.mark.parametrize("engine", ["compiled", "reference", "interpreted"])
@pytest.mark.parametrize("method", ["stormer-verlet", "gauss-2", "g6245"])
def test_given_starting_values_replace_the_problem_s_own(method, engine):
    # kernels keep a force, or a guess, from before the first step: it has to be that of the start
    other = Problem(force=("-sin(q[0])",), y0=(0.3, -0.8), name="other")
    begin = solve(other, method, h=0.1, steps=0, engine="reference").values
    far = Problem(force=("-sin(q[0])",), y0=(2.0, 1.0), name="far")
    there = solve(far, method, h=0.1, steps=10, start=begin, engine=engine)
    here = solve(other, method, h=0.1, steps=10, start=begin, engine=engine)
    np.testing.assert_array_equal(there.values, here.values)


@pytest.mark.parametrize("engine", ["compiled", "reference", "interpreted"])
def test_a_finishing_method_that_cannot_be_solved_keeps_the_rows_before(engine):
    from dataclasses import replace

    from glmref import FinishingMethod, load
    from glmref.exact import exact

    # finish by Y = y + Y^2 h: no real solution once 4 h y > 1, which y = 1/(1 - t) comes to
    growth = Problem(f=("y[0]*y[0]",), y0=(1.0,), name="growth")
    finishing = FinishingMethod(A=((exact(1),),), b=(exact(1),))
    method = replace(load("rk4"), finishing=finishing)
    run = solve(growth, method, h=0.1, steps=8, every=1, engine=engine)
    assert run.outcome is Outcome.STAGE_SOLVE_FAILED
    assert "finishing method at t = 0.6" in run.message
    assert len(run.t) == len(run.y) == 6
    assert np.isfinite(run.y).all()


@pytest.mark.parametrize("method", ["rk4", "gauss-2"])
def test_a_large_function_that_ignores_t_is_compiled_as_formulas(method):
    """The function of a formula takes t, and nothing sets the time of a stage that none needs."""
    n = 40

    def ring(t, y):
        q, p = y[:n], y[n:]
        return np.concatenate((p, np.roll(q, 1) - 2 * q + np.roll(q, -1)))

    problem = Problem(f=ring, y0=np.sin(np.arange(2.0 * n)))
    found = solve(problem, method, h=0.05, steps=3)
    wanted = solve(problem, method, h=0.05, steps=3, engine="reference")
    assert not found.notices
    assert np.abs(found.y[-1] - wanted.y[-1]).max() < 1e-14


def given_as_a_list(t, y):
    return np.concatenate([y[:1], -y[1:] if y[0] > 0 else y[1:]])


def read_from_a_text(t, y):
    return [float(str(0.5)) * y[0] if y[0] > 0 else -y[0], y[1]]


@pytest.mark.sampled(0)
@pytest.mark.parametrize(
    ("f", "reason"), [(given_as_a_list, "concatenate"), (read_from_a_text, "convert string")]
)
def test_a_notice_says_what_numba_cannot_do(f, reason):
    """Not its pipeline, with which its messages begin; and its errors are of many kinds."""
    (notice,) = solve(Problem(f=f, y0=[1.0, 1.0]), "rk4", h=0.1, steps=2).notices
    assert "numba cannot compile" in notice and reason in notice
    assert "pipeline" not in notice
