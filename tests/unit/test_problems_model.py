"""The problem record: what a user gives, formulas, Jacobians, what is refused."""

import mpmath
import numpy as np
import pytest

from glmref.problems import Problem, names, problem
from glmref.problems.formula import Formula


def test_conserved_functions_come_in_every_form():
    p = Problem(
        f=("y[1]", "-y[0]"),
        y0=(3, 4),
        hamiltonian="(y[0]**2 + y[1]**2)/2",
        quadratic={"norm": np.eye(2)},
        invariants={"plain": lambda y: y[0] ** 2 + y[1] ** 2},
    )
    assert p.hamiltonian(p.y0) == 12.5
    assert p.quadratic["norm"](p.y0) == 25 == p.invariants["plain"](p.y0)
    assert np.asarray(p.quadratic["norm"]).tolist() == [[1, 0], [0, 1]]


def test_values_are_frozen():
    p = problem("pendulum")
    with pytest.raises(AttributeError):
        p.name = "other"
    with pytest.raises(ValueError, match="read-only"):
        p.y0[0] = 1
    with pytest.raises(TypeError):
        p.parameters["q0"] = 1


def test_loops_compile_in_one_piece_with_any_compiler():
    p = problem("toda", sites=4)
    compiled = []
    f_into = p.f.compiled(lambda body: compiled.append(body) or body)
    out = np.empty(8)
    f_into(0.0, p.y0, p.params, out)
    assert len(compiled) == 2 and (out == p.f(0.0, p.y0)).all()
    assert p.force.body is not None and p.expressions is None


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["outer-solar-system", "pleiades", "fput", "toda", "nonseparable-chain"]
)
def test_numba_compiles_the_loops_as_they_stand(name):
    numba = pytest.importorskip("numba")
    p = problem(name)
    out = np.empty(p.dimension)
    p.f.compiled(numba.njit)(0.0, np.array(p.y0), p.params, out)
    # the same operations in the same order, but for fused multiplication
    assert out == pytest.approx(p.f(0.0, p.y0), rel=1e-13, abs=1e-15)
    energy = p.hamiltonian.compiled(numba.njit)(np.array(p.y0), p.hamiltonian.params)
    assert energy == pytest.approx(p.hamiltonian(p.y0), rel=1e-13)


# --- names ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", names())
def test_every_problem_is_built_and_evaluates(name):
    p = problem(name)
    assert p.name == name and p.source
    if name != "fault-shape":  # which every call refuses, see test_problems_facts
        with np.errstate(all="ignore"):
            slope = p.f(p.t_span[0], p.y0)
        assert slope.shape == p.y0.shape and np.isfinite(slope).all()
    assert p.t_span[0] < p.t_span[1] and all(x > 0 for x in p.scales.values())


@pytest.mark.parametrize("name", names())
def test_defaults_written_out_give_the_same_problem(name):
    same = problem(name, **problem(name).parameters)
    assert (same.y0 == problem(name).y0).all()


# -- formulas, and Jacobians derived from them


DERIVED = [
    name
    for name in names()
    if not name.startswith("fault")
    and (problem(name, **({"sites": 9, "mode": 2} if name == "long-chain" else {}))).jacobian
]


def central_differences(f, y, context, step):
    """df/dy by central differences; error |f'''| step**2/6 plus 10**-dps |f| / step."""
    columns = []
    for j in range(len(y)):
        shift = np.array([context.mpf(0)] * len(y), dtype=object)
        shift[j] = step
        columns.append((f(context.mpf(1), y + shift) - f(context.mpf(1), y - shift)) / (2 * step))
    return np.array(columns).T


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", DERIVED)
def test_jacobian_agrees_with_differences_at_60_digits(name):
    context = mpmath.MPContext()
    context.dps = 60
    small = {"nonseparable-chain": {"sites": 4}, "fput": {"sites": 4}}
    high = problem(name, **small.get(name, {})).on(context)
    y = high.y0 + np.array([context.mpf(i + 1) / 97 for i in range(len(high.y0))], dtype=object)
    jacobian = high.jacobian(context.mpf(1), y)
    step = context.mpf(10) ** -20
    difference = jacobian - central_differences(high.f, y, context, step)
    # step**2 = 1e-40 times third derivatives, which the stiff ones scale by up to 1e11
    size = 1 + max(abs(x) for x in jacobian.flat)
    assert max(abs(x) for x in difference.flat) < 1e-30 * size


def test_a_wrong_derivative_is_noticed():
    # near miss: the comparison of the first test at work on a Jacobian off by 1e-12
    context = mpmath.MPContext()
    context.dps = 60
    high = problem("pendulum").on(context)
    wrong = high.jacobian(0, high.y0) * (1 + context.mpf("1e-12"))
    right = central_differences(high.f, high.y0, context, context.mpf(10) ** -20)
    assert max(abs(x) for x in (wrong - right).flat) > 1e-13


# --- formulas -------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("text", ["(t-1)**0.5", "(-a)**1.5", "sqrt((t-a)**-0.5)", "(-y[0])**(1/3)"])
def test_a_negative_number_has_no_power_that_is_not_whole(text):
    f = Formula((text, "t"), parameters={"a": 2})
    assert np.isnan(f(0.25, np.array([1.0, 2.0]))[0])
    assert np.isnan(f(0.25, np.ones((2, 3)))[0]).all()
