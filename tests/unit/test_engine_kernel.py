"""Choosing a solver, sharing kernels, and the work array."""

import math

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine.kernel import prepare
from glmref.engine.shape import shape_of
from glmref.engine.solver_choice import choose_solver, contraction
from glmref.engine.sweep import step_form


def rule(method, of, h):
    form, shape = step_form(load(method)), shape_of(of)
    return choose_solver(form, shape, of, h), contraction(form, shape, of, h)


def test_contraction_is_h_a_J_and_its_square_on_a_separable_problem():
    oscillator = problem("harmonic-oscillator", frequency=3)
    midpoint = step_form(load("implicit-midpoint"))
    halved = contraction(midpoint, shape_of(oscillator), oscillator, 0.1)
    assert halved == pytest.approx((0.1 * 3 / 2) ** 2)
    plain = Problem(f=("3*y[1]", "-3*y[0]"), y0=(1.0, 0.0))
    assert contraction(midpoint, shape_of(plain), plain, 0.1) == pytest.approx(0.1 * 3 / 2)


def test_contraction_is_that_at_the_first_time(tmp_path, monkeypatch):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))  # where norms are remembered
    midpoint = step_form(load("implicit-midpoint"))
    for t0 in (1.0, 4.0):
        of = Problem(f=("t*y[0]",), y0=(1.0,), t_span=(t0, 9.0))
        assert contraction(midpoint, shape_of(of), of, 0.1) == pytest.approx(0.1 * t0 / 2)


def test_contraction_of_a_block_is_that_of_its_eigenvalues():
    oscillator = problem("harmonic-oscillator", frequency=3)
    # the eigenvalues of A of Gauss with two stages are (3 +- i sqrt 3)/12, of modulus 1/sqrt(12)
    gauss = step_form(load("gauss-2"))
    assert contraction(gauss, shape_of(oscillator), oscillator, 0.1) == pytest.approx(0.09 / 12)
    # its largest row sum, 1/2 + sqrt(3)/6, would say seven times as much
    kepler = problem("kepler", eccentricity="3/5")
    assert rule("gauss-4", kepler, 2 * math.pi / 60)[0] == "fixed-point"


def test_an_explicit_method_has_no_contraction():
    stiff = problem("fput-stiff", omega=500)
    assert rule("rk4", stiff, 0.1) == ("fixed-point", 0.0)


def test_a_poor_contraction_takes_newton_and_a_cheap_one_the_fixed_point():
    heavy = problem("n-body")
    assert rule("gauss-3", heavy, 1e-3)[0] == "fixed-point"
    stiff = problem("fput-stiff", omega=500)
    assert rule("gauss-3", stiff, 0.1)[0] == "newton"
    assert (
        choose_solver(step_form(load("gauss-2")), shape_of(heavy), heavy, 0.1, "newton") == "newton"
    )


def test_an_unknown_jacobian_of_a_large_system_leaves_the_fixed_point():
    large = Problem(f=lambda t, y: -np.asarray(y), y0=tuple([1.0] * 70), name="large")
    solver, rho = rule("gauss-2", large, 0.1)
    assert math.isnan(rho)
    assert solver == "fixed-point"


@pytest.mark.sampled(3, besides=("toda", "double-pendulum"))
@pytest.mark.parametrize("method", ["g6245", "s4-symmetric", "gauss-2", "sdirk-3"])
@pytest.mark.parametrize(
    "name", ["pendulum", "kepler", "rigid-body", "double-pendulum", "lotka-volterra-logarithmic", "toda"]
)  # fmt: skip
def test_newton_and_the_fixed_point_find_the_same_stages(method, name):
    steps = 20
    h = 0.02
    ends = [
        solve(name, method, h=h, steps=steps, solver=solver, start="zero").y[-1]
        for solver in ("fixed-point", "newton")
    ]
    # both iterate to round-off; per step they differ by a few units of it
    scale = max(1.0, np.abs(ends[0]).max())
    assert np.abs(ends[0] - ends[1]).max() < 8 * 2.0**-52 * steps * scale


def test_newton_works_without_a_jacobian():
    def f(t, y):
        return [y[1], -math.sin(y[0])]

    plain = Problem(f=f, y0=(1.2, 0.0), name="plain")
    run = solve(plain, "gauss-2", h=0.1, steps=5, solver="newton", engine="interpreted")
    exact = solve(Problem(force=("-sin(q[0])",), y0=(1.2, 0.0)), "gauss-2", h=0.1, steps=5)
    assert run.factorisations >= 1
    assert np.abs(run.y - exact.y).max() < 1e-15


def test_the_head_of_the_work_array_is_the_state():
    kepler = problem("kepler")
    kernel = prepare(load("s4-symmetric"), kepler, h=0.1)
    values = np.arange(12.0).reshape(3, 4)
    state = kernel.state(values, np.ones(4), 0.1)
    assert state.y.base is not None
    assert np.shares_memory(state.y, state.work)
    assert np.shares_memory(state.memory, state.work)
    assert np.abs(kernel.values(state) - values).max() < 2e-15
    weights = [w for _, w in kernel.form.memory]
    np.testing.assert_allclose(state.memory, 0.1 * np.outer(weights, np.ones(4)))


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["outer-solar-system", "nonseparable-chain", "arenstorf", "toda"])
def test_array_kernels_agree_with_the_reference(name):
    h = {"outer-solar-system": 20.0, "arenstorf": 1e-4}.get(name, 0.01)
    for method in ("gauss-2", "g6245"):
        fast = solve(name, method, h=h, steps=10, start="zero")
        slow = solve(name, method, h=h, steps=10, start="zero", engine="reference")
        scale = np.abs(slow.values).max()
        assert np.abs(fast.values - slow.values).max() < 40 * 2.0**-52 * scale
        assert fast.kernel.startswith("native")


def test_an_explicit_method_has_no_solver_to_choose():
    of = problem("kepler")
    form, shape = step_form(load("rk4")), shape_of(of)
    assert choose_solver(form, shape, of, 0.1) == "fixed-point"
    for solver in ("fixed-point", "newton"):
        assert choose_solver(form, shape, of, 0.1, solver) == solver
