"""Choosing a solver, sharing kernels, and the work array."""

import math

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine.shape import shape_of
from glmref.engine.solver_choice import choose_solver, contraction
from glmref.engine.sweep import step_form


def rule(method, of, h):
    form, shape = step_form(load(method)), shape_of(of)
    return choose_solver(form, shape, of, h), contraction(form, shape, of, h)


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
