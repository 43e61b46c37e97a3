"""Extreme inputs with a known right answer: nothing, linear, scaled, there and back, too far.

Most of these are exact statements: a field of zero applies V, a linear one M(hA), a power of two
commutes with every rounding.
"""

from types import SimpleNamespace

import numpy as np
import pytest

from glmref.catalogue.keys import PAIRS
from glmref.catalogue.lookup import load, names
from glmref.engine.solve import solve
from glmref.errors import GlmrefError
from glmref.problems import Problem, problem
from glmref.problems.formula import Formula
from glmref.problems.user_functions import FunctionFailed
from tests.build import floats
from tests.shipped import shipped

EPS = 2.0**-53
CLASSES = {name: shipped(name)["class"] for name in names("methods")}
#: Methods of one right-hand side with real coefficients, and those of several values among them.
REAL = [
    name
    for name, kind in CLASSES.items()
    if kind not in PAIRS | {"additive", "rosenbrock"} and name != "g6245-w3-complex"
]
SEVERAL = [name for name in REAL if CLASSES[name] in ("glm", "lmm", "one-leg", "sweep")]


# --- no field -------------------------------------------------------------------------------------


def power(method, n):
    """V^n in exact arithmetic, rounded once."""
    from glmref.exact import linalg

    result = linalg.identity(method.r)
    for _ in range(n):
        result = linalg.matmul(method.V, result)
    return np.array([[complex(x).real for x in row] for row in result])


def with_values(name):
    """A method, and values of three components."""
    method = load(name)
    return method, np.arange(1.0, 3 * method.r + 1).reshape(method.r, 3)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("name", SEVERAL)
def test_a_field_of_zero_applies_v(name):
    method, start = with_values(name)
    steps = 5
    for engine in ("interpreted", "reference"):
        found = solve(problem("zero-field"), method, h=0.5, steps=steps, start=start, engine=engine)
        V = floats(method.V)
        # each step rounds r products and r - 1 sums for each value, each within EPS of the terms
        terms = np.linalg.matrix_power(np.abs(V), steps) @ np.abs(start)
        bound = 8 * steps * method.r * EPS * np.max(terms)
        assert np.max(np.abs(found.values - power(method, steps) @ start)) <= bound


INTEGRAL = [
    name
    for name in SEVERAL
    if CLASSES[name] != "sweep" and all(float(x).is_integer() for row in load(name).V for x in row)
]


@pytest.mark.sampled(10)
@pytest.mark.parametrize("name", INTEGRAL)
def test_a_field_of_zero_applies_an_integral_v_to_the_last_bit(name):
    method, start = with_values(name)
    steps = 7
    # the standard form keeps the method's own basis: values are neither scaled nor scaled back
    for options in ({"engine": "interpreted", "form": "standard"}, {"engine": "reference"}):
        found = solve(problem("zero-field"), method, h=0.1, steps=steps, start=start, **options)
        assert (np.asarray(found.values) == power(method, steps) @ start).all()


def test_there_are_many_integral_ones():
    assert len(INTEGRAL) >= 10


# --- linear field ---------------------------------------------------------------------------------


def kronecker_step(method, h, matrix, start):
    """One step of y' = A y by one linear solve."""
    A, U, B, V = (floats(m) for m in
                  (method.A, method.U, method.B, method.V))  # fmt: skip
    d = len(matrix)
    left = np.eye(method.s * d) - np.kron(A, h * matrix)
    stages = np.linalg.solve(left, np.kron(U, np.eye(d)) @ start.ravel())
    new = np.kron(V, np.eye(d)) @ start.ravel() + np.kron(B, h * matrix) @ stages
    return new.reshape(start.shape)


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", REAL)
def test_a_linear_field_is_one_linear_solve(name):
    method, p, h = load(name), problem("linear-field", dimension=3), 0.25
    matrix = np.asarray(p.jacobian(0.0, p.y0))
    start = np.random.default_rng(5).standard_normal((method.r, 3))
    found = solve(p, method, h=h, steps=1, start=start, engine="interpreted")
    assert found.completed
    expected = kronecker_step(method, h, matrix, start)
    # |hA| < 1: each of the s + r sums rounds terms of the size of the largest coefficient
    size = 1 + max(
        abs(float(x)) for m in (method.A, method.U, method.B, method.V) for row in m for x in row
    )
    bound = 200 * (method.s + method.r) * size**2 * EPS * np.max(np.abs(start))
    assert np.max(np.abs(found.values - expected)) < bound


def test_a_wrong_coefficient_shows_on_the_linear_field():
    p, method = problem("linear-field", dimension=3), load("rk4")
    start = np.ones((1, 3))
    matrix = np.asarray(p.jacobian(0.0, p.y0))
    found = solve(p, load("rk38"), h=0.25, steps=1, start=start, engine="interpreted")
    same = kronecker_step(method, 0.25, matrix, start)
    # methods of one order and as many stages agree on linear problems; one of order 3 does not
    assert np.max(np.abs(found.values - same)) < 1e-14
    other = solve(p, load("heun-3"), h=0.25, steps=1, start=start, engine="interpreted")
    assert np.max(np.abs(other.values - same)) > 1e-5


# --- scaled states --------------------------------------------------------------------------------

SCALED = ("rk4", "gauss-2", "sdirk-3", "g6245-w3", "s4-symmetric", "bdf-2", "stormer-verlet")


@pytest.mark.sampled(6)
@pytest.mark.parametrize("name", SCALED)
@pytest.mark.parametrize("exponent", [-500, 500])
def test_powers_of_two_commute_with_every_step(name, exponent):
    """2^500 is 3e150: in and out of the scale nothing is rounded, so every bit is the same."""
    ends = []
    for scale in (0, exponent):
        p = problem("harmonic-oscillator", q0=2.0**scale)
        ends.append(solve(p, name, h=0.1, steps=50, solver="auto").y[-1])
    assert (ends[1] == np.ldexp(ends[0], exponent)).all()


@pytest.mark.parametrize("name", ["rk4", "gauss-2", "g6245-w3", "s4-symmetric", "stormer-verlet"])
def test_denormal_states_lose_digits_but_not_the_run(name):
    p = problem("harmonic-oscillator", q0=1e-310)
    found = solve(p, name, h=0.1, steps=100)
    assert found.completed
    # the unit is 2^-1074 = 5e-324; each step rounds about forty times, and the errors add up
    right = np.array([np.cos(10.0), -np.sin(10.0)]) * 1e-310
    # of order two and better: t h^2/24 of the amplitude
    truncation = 5e-3 * 1e-310
    assert np.max(np.abs(found.y[-1] - right)) < 100 * 40 * 5e-324 + truncation


# --- step sizes -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rk4", "gauss-3", "g6245", "g6245-w3", "thesis-3-8"])
def test_the_smallest_steps_move_by_h_f(name):
    p = problem("pendulum", q0="23/10")
    for h in (1e-15, 1e-12, 1e-9):
        found = solve(p, name, h=h, steps=1000, engine="compiled")
        assert found.completed
        # p' = -sin q: after 1000 h the momentum is -1000 h sin(q0) (1 + O((1000 h)^2)); sums are
        # compensated, so that rounding is that of the increments
        expected = -1000 * h * np.sin(2.3)
        assert found.y[-1][1] == pytest.approx(expected, rel=2 * (1000 * h) ** 2 + 1e-11)


SYMMETRIC = ("gauss-2", "gauss-3", "lobatto-iiia-3", "stormer-verlet", "suzuki-verlet-4")


@pytest.mark.parametrize("name", SYMMETRIC)
def test_symmetric_methods_return_to_round_off(name):
    p, h, steps = problem("pendulum", q0="23/10"), 0.1, 1000
    there = solve(p, name, h=h, steps=steps)
    back = solve(p, name, h=-h, steps=steps, start=np.asarray(there.values))
    # the linear instability of the flow over t = 100 magnifies round-off by less than 1e4
    assert np.max(np.abs(back.y[-1] - p.y0)) < 1e4 * 20 * EPS


def test_methods_without_symmetry_return_to_their_error_only():
    p, h, steps = problem("pendulum", q0="23/10"), 0.1, 1000
    there = solve(p, "rk4", h=h, steps=steps)
    back = solve(p, "rk4", h=-h, steps=steps, start=np.asarray(there.values))
    assert 1e-9 < np.max(np.abs(back.y[-1] - p.y0)) < 1.0


def attempt(*given, **options):
    """Return outcome, sentence and solution of a run, also of one that is refused."""
    try:
        with np.errstate(all="ignore"):
            found = solve(*given, **options)
    except FunctionFailed as error:
        return SimpleNamespace(outcome="right-hand side failed", message=str(error), solution=None)
    except GlmrefError as error:
        return SimpleNamespace(outcome="refused", message=str(error), solution=None)
    return SimpleNamespace(outcome=str(found.outcome), message=found.message, solution=found)


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", ["rk4", "gauss-2", "g6245", "bdf-2", "stormer-verlet"])
@pytest.mark.parametrize("h", [1e3, 1e8, 1e300, -1e8])
def test_far_beyond_stability_a_run_ends_in_a_name(name, h):
    found = attempt(problem("henon-heiles"), load(name), h=h, steps=20)
    assert found.outcome in ("completed", "not finite", "stage solve failed", "refused")
    if found.solution is not None:
        assert np.isfinite(found.solution.y).all()


# --- sizes ----------------------------------------------------------------------------------------


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", REAL)
def test_one_component_is_enough(name):
    p = problem("dahlquist", real=-1)
    found = solve(p, name, h=0.01, steps=20, engine="interpreted")
    assert found.completed
    # of order one and better at h = 0.01: twenty local errors of at most three h^2 each
    assert found.y[-1][0] == pytest.approx(np.exp(-0.2), abs=60 * 0.01**2)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stormer-verlet", "rk4", "g6245-w3"])
def test_a_hundred_thousand_components(name):
    p = problem("long-chain")
    assert p.dimension == 100_000
    found = solve(p, name, h=0.05, steps=20)
    exact = p.solution(1.0)
    assert found.completed
    order = load(name).claims["order"]
    # omega <= 0.62 for this mode: (omega h)^order, and the second order of Störmer-Verlet
    allowed = 10 * 0.031**order + 1e-12
    assert np.linalg.norm(found.y[-1] - exact) / np.linalg.norm(exact) < allowed


# --- faults ---------------------------------------------------------------------------------------

METHODS = ("rk4", "gauss-2", "sdirk-4", "g6245-w3", "bdf-2")


@pytest.mark.sampled(5)
@pytest.mark.parametrize("name", METHODS)
@pytest.mark.parametrize("fault", ["fault-nan", "fault-infinity"])
def test_what_is_no_number_stops_the_run_where_it_comes(name, fault):
    h = 0.1
    found = attempt(problem(fault), load(name), h=h, steps=100)
    assert found.outcome == "not finite" and found.solution is not None
    ends = float(found.solution.t[-1])
    # NaN from t = 1 on, overflow from t = 7.09 on; the last steps before reach over it
    first = 1.0 if fault == "fault-nan" else 7.1
    assert first - 3 * h < ends < first + 1e-9
    assert np.isfinite(found.solution.y).all()


@pytest.mark.sampled(5)
@pytest.mark.parametrize("entry", ["1000000", "0", "1/(y[0] - y[0])", "sqrt(0 - 1 - t)"])
@pytest.mark.parametrize("name", ["sdirk-4", "gauss-2", "bdf-2"])
def test_a_wrong_jacobian_gives_the_right_answer_or_a_failure(name, entry):
    p = Problem(
        f=("-1000000*(y[0] - cos(t))",), y0=[1.0],
        jacobian=Formula((entry,), variables=("t", "y"), shape=(1, 1)),
    )  # fmt: skip
    found = attempt(p, load(name), h=0.01, steps=100, solver="newton", start="zero")
    assert found.outcome in ("completed", "stage solve failed", "not finite")
    if found.outcome == "completed":
        assert found.solution.y[-1][0] == pytest.approx(np.cos(1.0), abs=1e-3)
    right = Problem(f=p.f, y0=[1.0])
    assert attempt(right, load(name), h=0.01, steps=100, solver="newton").outcome == "completed"


# --- chaos ----------------------------------------------------------------------------------------


def test_of_a_chaotic_run_only_the_invariant_can_be_judged():
    p = problem("henon-heiles")
    ends, energies = [], []
    for nudge in (0.0, 1e-15):
        start = np.array([p.y0 + nudge])
        found = solve(p, "gauss-3", h=0.1, steps=20_000, start=start)
        ends.append(found.y[-1])
        energies.append(p.hamiltonian(found.y[-1]))
    assert np.linalg.norm(ends[0] - ends[1]) > 1e-3
    assert abs(energies[0] - energies[1]) < 1e-7


@pytest.mark.parametrize(("size", "outcome"), [(1e5, "completed"), (1e8, "stage solve failed")])
def test_both_engines_take_the_same_change_for_what_cancellation_leaves(size, outcome):
    # stages of a right-hand side with rounding errors of size times 2^-53
    cancels = Problem(
        f=lambda t, y: [-((y[0] + size) - size) + 0.1 * y[1], -y[1] - ((3 * y[0] + size) - size)],
        y0=(1.0, 0.5), name="cancels",
    )  # fmt: skip
    runs = [solve(cancels, "gauss-2", h=0.1, steps=50, engine=x) for x in ("reference", "compiled")]
    assert [x.outcome for x in runs] == [outcome] * 2
