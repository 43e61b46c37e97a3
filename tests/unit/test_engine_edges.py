"""Step sizes, times, states and sizes at the edge: an outcome or one sentence, never a traceback."""

import os
import sys
import time

import numpy as np
import pytest

from glmref import Problem, UsageError, load, problem, solve
from glmref.engine import arithmetic, kernel, run, solver_choice
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.memory import memory
from glmref.engine.outcome import Outcome, StartFailed
from glmref.engine.shape import shape_of
from glmref.engine.solver_choice import contraction, newton_bytes
from glmref.engine.sweep import step_form
from tests.build import refused

REST = Problem(f=("0*y[0]", "0*y[1]"), y0=("1/3", "-2/7"), name="rest")
ENGINES = ["compiled", "reference", "interpreted"]


@pytest.mark.parametrize("engine", ENGINES)
def test_arrays_and_complex_numbers_at_the_edge_are_refused_in_one_sentence(engine):
    request = {"engine": engine, "h": 0.1}
    lists = "`times` must be a list of numbers"
    refused(UsageError, lists, solve, "pendulum", "rk4", times=np.array(0.1), **request)
    start, real = [[1j, 0.0]], "starting values must be real"
    refused(UsageError, real, solve, "pendulum", "rk4", steps=1, start=start, **request)


@pytest.mark.parametrize("engine", ENGINES)
def test_no_steps_and_long_strides_are_fine(engine):
    none = solve("pendulum", "gauss-2", h=0.1, steps=0, engine=engine)
    assert none.completed and none.t.tolist() == [0.0] and none.steps == 0
    np.testing.assert_array_equal(none.y[0], problem("pendulum").y0)
    for every in (8, 10**25):
        run = solve("pendulum", "gauss-2", h=0.1, steps=7, every=every, engine=engine)
        assert run.t == pytest.approx([0.0, 0.7])
    subnormal = solve(REST, "rk4", h=5e-324, steps=3, engine=engine)
    assert subnormal.completed and subnormal.t.tolist() == [1.5e-323]
    back = solve(REST, "gauss-2", h=-0.1, steps=3, every=2, engine=engine)
    assert back.t == pytest.approx([0.0, -0.2, -0.3])


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("name", ["s4-symmetric", "s3-w3", "g6245"])
def test_values_near_the_end_of_the_range_stay_finite(name, engine):
    method = load(name)
    start = np.full((method.r, 2), 1.7e308)
    start[::2] *= -1
    ended = solve(REST, method, h=0.1, steps=3, every=1, start=start, engine=engine, history=True)
    assert np.isfinite(ended.values).all() and np.isfinite(ended.y).all()
    assert np.isfinite(ended.history).all() and len(ended.t) == ended.steps + 1
    assert ended.completed == (ended.steps == 3)
    if not ended.steps:
        np.testing.assert_array_equal(ended.values, start)


def test_a_basis_that_overflows_ends_the_run_before_it(monkeypatch):
    # the values of the kernel stay in range, what they stand for does not from the third step on
    growth = Problem(f=("y[0]",), y0=(1.0,), name="growth")
    plain = solve(growth, "rk4", h=1.0, steps=6, every=1)

    def beyond(self, state):
        found = self.form.back(state.vectors[: self.form.rows])
        return np.where(np.abs(found) > 8.0, np.inf, found)

    monkeypatch.setattr(kernel.Kernel, "values", beyond)
    ended = solve(growth, "rk4", h=1.0, steps=6, every=1)
    assert ended.outcome is Outcome.NOT_FINITE and ended.steps == 2
    np.testing.assert_array_equal(ended.y, plain.y[:3])
    np.testing.assert_array_equal(ended.values, plain.y[2:3])
    # at the first step the given values are what is left
    at_once = solve(growth, "rk4", h=4.0, steps=1, every=1)
    assert at_once.outcome is Outcome.NOT_FINITE and at_once.steps == 0
    assert at_once.values.tolist() == at_once.y.tolist() == [[1.0]]


#: q grows by a factor of 1.0101 in a step, and the values that make the solution lag by half a step:
#: over 40 steps it grows by 1.4918 and they by 1.4844. A kernel looks at q + q'.
GROWTH = Problem.from_equations({"q": "q/1000", "p": "-p/1000"}, {"q": 1, "p": 0})


def largest(factor):
    """Return starting values whose solution is the largest number over a factor."""
    values = solve(GROWTH, "multistep-general-8", h=10, steps=0).values
    return values * (sys.float_info.max / factor)


@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("rows", [{}, {"every": 1}, {"every": 7}, {"every": 40}, {"history": True}])
@pytest.mark.parametrize(("factor", "steps"), [(1.488, 39), (1.493, 40)])
def test_a_last_solution_beyond_the_range_is_given_up(engine, rows, factor, steps):
    given = {"h": 10, "start": largest(factor), "engine": engine, **rows}
    ended = solve(GROWTH, "multistep-general-8", steps=40, **given)
    assert ended.outcome == (Outcome.COMPLETED if steps == 40 else Outcome.NOT_FINITE)
    assert ended.steps == steps
    whole = solve(GROWTH, "multistep-general-8", steps=steps, **given)
    np.testing.assert_array_equal(ended.values, whole.values)
    assert np.isfinite(whole.y).all() and np.isfinite(ended.y).all()
    np.testing.assert_array_equal(ended.y, whole.y[: len(ended.y)])
    assert len(ended.y) == len(whole.y) - (rows.get("every", 0) > 1 and steps == 39)


@pytest.mark.parametrize("width", [None, 1])
@pytest.mark.parametrize("every", [0, 1, 7])
def test_a_last_solution_beyond_the_range_is_given_up_in_an_ensemble(width, every):
    starts = np.array([largest(1.488), largest(1.493)])
    first = np.tile(GROWTH.y0, (2, 1))  # of which nothing is taken
    given = {"h": 10, "start": starts, "width": width}
    found = solve_ensemble(GROWTH, "multistep-general-8", first, steps=40, every=every, **given)
    assert list(found.outcomes) == [Outcome.NOT_FINITE, Outcome.COMPLETED]
    assert list(found.steps) == [39, 40]
    before = solve_ensemble(GROWTH, "multistep-general-8", first, steps=39, **given)
    np.testing.assert_array_equal(found.y[-1, 0], before.y[-1, 0])
    np.testing.assert_array_equal(found.values[0], before.values[0])
    assert np.isfinite(found.y).all() and found.y[-1, 1, 0] > found.y[-1, 0, 0]


def test_starting_values_whose_sum_is_beyond_the_range_are_refused():
    values = np.array([[1.7e308, 0.0], *[[1e308, 0.0]] * 8])
    with pytest.raises(StartFailed, match="starting values must be finite"):
        solve(GROWTH, "multistep-general-8", h=10, steps=2, start=values)
    with pytest.raises(StartFailed, match="starting values must be finite"):
        solve_ensemble(GROWTH, "multistep-general-8", [[1, 0]], h=10, steps=2, start=[values])


# --- sizes --------------------------------------------------------------------------------------


def test_the_norm_of_a_large_jacobian_is_estimated_without_it(monkeypatch):
    gauss, chain = step_form(load("gauss-3")), problem("fput", sites=200)
    shape = shape_of(chain)
    estimated = contraction(gauss, shape, chain, 0.1)
    monkeypatch.setattr(solver_choice, "_DENSE_UP_TO", 1000)
    assert estimated == pytest.approx(contraction(gauss, shape, chain, 0.1), rel=0.1)
    whole = shape_of(chain, split=False)
    dense = contraction(gauss, whole, chain, 0.1)
    monkeypatch.setattr(solver_choice, "_DENSE_UP_TO", 1)
    assert contraction(gauss, whole, chain, 0.1) == pytest.approx(dense, rel=0.1)


def test_a_large_chain_starts_at_once_in_little_memory():
    chain = problem("fput", sites=20_000)
    begin = time.process_time()
    run = solve(chain, "gauss-3", h=0.1, steps=1)
    assert run.completed and "fixed-point" in run.kernel
    assert time.process_time() - begin < 5


@pytest.mark.slow
def test_the_memory_of_newton_is_what_its_work_array_takes(monkeypatch):
    monkeypatch.setattr(solver_choice, "_BANDED_FROM", 1000)
    form, chain = step_form(load("gauss-3")), problem("fput", sites=30)
    shape = shape_of(chain)
    taken = kernel.prepare(load("gauss-3"), chain, h=0.1, solver="newton").source.work_size
    least = kernel.prepare(load("gauss-3"), chain, h=0.1, solver="fixed-point").source.work_size
    assert newton_bytes(form, shape) == pytest.approx(8 * (taken - least), rel=0.1)


def test_memory_is_that_of_the_machine_or_of_the_process(monkeypatch):
    resource = pytest.importorskip("resource")
    free = (resource.RLIM_INFINITY, resource.RLIM_INFINITY)
    monkeypatch.setattr(os, "sysconf", {"SC_PAGE_SIZE": 4096, "SC_PHYS_PAGES": 1000}.__getitem__)
    monkeypatch.setattr(resource, "getrlimit", lambda _: free)
    assert memory() == 4096 * 1000
    for limit in (4096 * 1000 - 1, 4096 * 1000 + 1):
        monkeypatch.setattr(resource, "getrlimit", lambda _, limit=limit: (limit, limit))
        assert memory() == min(limit, 4096 * 1000)
    # a system that does not say
    monkeypatch.delattr(os, "sysconf")
    monkeypatch.setattr(resource, "getrlimit", lambda _: free)
    assert memory() == 2**36


def test_newton_beyond_the_limit_is_not_tried(monkeypatch):
    stiff = Problem(f=("-1000*(y[0] - cos(t))",), y0=(1.0,), name="stiff")
    for module in (solver_choice, run, arithmetic):
        monkeypatch.setattr(module, "NEWTON_BYTES", 8)
    for engine in ENGINES:
        ended = solve(stiff, "gauss-2", h=0.5, steps=10, engine=engine)
        assert ended.outcome is Outcome.STAGE_SOLVE_FAILED
        assert "newton" not in ended.message and "smaller h" in ended.message
        assert engine == "reference" or any("Newton's matrices" in x for x in ended.notices)


def test_rows_take_the_memory_of_the_data():
    import tracemalloc

    n = 200_000
    solve("kepler", "stormer-verlet", h=0.01, steps=10, every=1)
    tracemalloc.start()
    run = solve("kepler", "stormer-verlet", h=0.01, steps=n, every=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 1.2 * (run.y.nbytes + run.t.nbytes)
    picked = solve("kepler", "stormer-verlet", h=0.01, times=run.t[[5, 77_777, n]].tolist())
    np.testing.assert_array_equal(picked.y, run.y[[5, 77_777, n]])
    np.testing.assert_array_equal(picked.t, run.t[[5, 77_777, n]])


@pytest.mark.parametrize("engine", ["compiled", "interpreted", "reference"])
@pytest.mark.parametrize("f", ["(-y[0])**0.5", "(t-1)**1.5", "sqrt((-a)**0.5)", "(a-pi)**(1/3)"])
def test_a_power_without_a_real_value_ends_the_run_by_name(f, engine):
    given = Problem(f=("y[1]", f), y0=(1.0, 0.5), parameters={"a": 2})
    for method in ("rk4", "gauss-2"):
        found = solve(given, method, h=0.01, steps=3, engine=engine)
        assert found.outcome is Outcome.NOT_FINITE


@pytest.mark.parametrize("engine", ["compiled", "interpreted", "reference"])
def test_a_step_whose_weights_are_below_the_range_has_an_outcome(engine):
    fall = Problem(force=("-q[0]",), y0=(1.0, 0.5), name="spring")
    run = solve(fall, "gauss-3", h=-5e-324, steps=2, engine=engine)
    assert run.outcome in (Outcome.COMPLETED, Outcome.NOT_FINITE)  # 1/(h b) is infinite
    np.testing.assert_array_equal(run.y[-1], [1.0, 0.5])


@pytest.mark.slow
def test_numbers_of_mpmath_that_diverge_end_a_run_soon():
    square = Problem(f=("sin(y[0])*y[0]*y[0]*y[0]",), y0=(1e299,), name="cube")
    for method in ("rk4", "gauss-2"):
        run = solve(square, method, h=0.1, steps=40, engine="reference", digits=30)
        assert run.outcome in (Outcome.NOT_FINITE, Outcome.STAGE_SOLVE_FAILED)
        assert run.steps < 20


def test_an_ensemble_whose_first_kick_overflows_keeps_its_initial_values():
    quartic = Problem(force=("-q[0]**3",), y0=(1e299, 1e299), name="quartic")
    first = np.array([[1e299, 1e299], [0.5, 0.5]])
    found = solve_ensemble(quartic, "stormer-verlet", first, h=0.01, steps=6, every=3)
    assert list(found.outcomes) == [Outcome.NOT_FINITE, Outcome.COMPLETED]
    np.testing.assert_array_equal(found.y[:, 0], [first[0]] * 3)
    assert np.isfinite(found.y).all() and np.isfinite(found.values).all()
