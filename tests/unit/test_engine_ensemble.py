"""Ensembles: every trajectory is the one that it would be alone, to the last bit."""

import math
import time
from dataclasses import replace
from functools import partial
from math import cos, sin

import numpy as np
import pytest

from glmref import Problem, UsageError, load, problem, solve
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.kernel import prepare
from glmref.engine.outcome import Interrupted, Outcome
from glmref.engine.reference import stepper
from glmref.engine.starting_values import zero_start
from glmref.problems.loops import Loops

STEPS = 12
DRIVEN = Problem(f=("y[1]", "-sin(y[0]) + cos(t)/2 - y[1]/8"), y0=("6/5", "-1/3"), name="driven")


def initial(of, count, seed=3):
    """Initial values around the problem's own."""
    y0 = np.array(of.y0, dtype=float)
    return y0 * (1 + 0.1 * np.random.default_rng(seed).uniform(-1, 1, (count, len(y0))))


def alone(of, method, start, h, solver="fixed-point"):
    """Values, steps and evaluations of one trajectory by the kernel for single ones."""
    kernel = prepare(load(method), of, h=h, solver=solver)
    state = kernel.state(start, np.asarray(of.f(0.0, start[0])), h)
    out = np.zeros((1, 1, of.dimension))
    kernel.advance(state, STEPS, t0=0.0, h=h, every=0, out=out)
    return kernel.values(state), state.step, int(state.tally[0]) + bool(kernel.form.memory)


CASES = [
    ("rk4", "kepler", "fixed-point"),
    ("gauss-3", "pendulum", "fixed-point"),
    ("g6245", "henon-heiles", "fixed-point"),
    ("g6245-w3", "henon-heiles", "newton"),
    ("sdirk-3", "rigid-body", "newton"),
    ("s4-symmetric", "lotka-volterra-logarithmic", "fixed-point"),
    ("lobatto-iiia-3", "pendulum", "fixed-point"),
    ("ab-3", "pendulum", "fixed-point"),
    ("stormer-verlet", "kepler", "fixed-point"),
    ("kahan-li-8", "henon-heiles", "fixed-point"),
]


@pytest.mark.parametrize("width", [None, 1])
@pytest.mark.parametrize("method", ["ab-3", "bdf-2", "abm-4-pece"])
def test_the_trial_steps_of_a_start_are_taken_at_their_times(
    method: str, width: int | None
) -> None:
    """The second pass starts from the solution a step later; at t0 it was off by 1e-3."""
    y0 = initial(DRIVEN, 3)
    found = solve_ensemble(DRIVEN, method, y0, h=0.05, steps=STEPS, width=width)
    for k, start in enumerate(y0):
        single = solve(replace(DRIVEN, y0=tuple(start), initial=None), method, h=0.05, steps=STEPS)
        assert np.abs(found.y[-1, k] - single.y[-1]).max() < 1e-13


@pytest.mark.sampled(2, besides=("g6245", "newton"), whole=6)
@pytest.mark.parametrize(("method", "name", "solver"), CASES)
def test_each_lane_has_the_bits_of_a_single_run(method, name, solver):
    of = problem(name)
    y0 = initial(of, 11)  # more than a block of 8, and not a multiple of it
    starts = zero_start(stepper(load(method), of), y0)
    found = solve_ensemble(
        of, method, y0, h=0.05, steps=STEPS, start=starts, solver=solver, width=8, threads=1
    )
    assert found.completed
    assert found.width == 8
    assert solver in found.kernel or solver == "fixed-point"
    evaluations = 0
    for k, start in enumerate(starts):
        values, steps, cost = alone(of, method, start, 0.05, solver)
        np.testing.assert_array_equal(found.values[k], values)
        assert found.steps[k] == steps == STEPS
        evaluations += cost
    assert found.evaluations == evaluations


def test_a_problem_that_depends_on_time_has_its_own_time_in_every_lane():
    y0 = initial(DRIVEN, 3)
    found = solve_ensemble(DRIVEN, "gauss-2", y0, h=0.05, steps=STEPS, solver="fixed-point")
    for k, y in enumerate(y0):
        values, _, _ = alone(DRIVEN, "gauss-2", y[None, :], 0.05)
        np.testing.assert_array_equal(found.values[k], values)


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("width", [1, 8, 16, 32])
def test_neither_width_nor_threads_change_a_bit(width, threads):
    of = problem("henon-heiles")
    y0 = initial(of, 40)
    options = {"h": 0.1, "steps": STEPS, "start": "zero", "solver": "fixed-point"}
    found = solve_ensemble(of, "g6245", y0, width=width, threads=threads, **options)
    first = solve_ensemble(of, "g6245", y0, width=8, threads=1, **options)
    np.testing.assert_array_equal(found.values, first.values)
    assert (found.width, found.threads) == (width, threads)
    assert found.evaluations == first.evaluations


@pytest.mark.slow
def test_the_default_start_is_that_of_single_runs():
    of = problem("pendulum")
    y0 = initial(of, 4)
    for method in ("g6245", "thesis-3-8", "rk4"):
        found = solve_ensemble(of, method, y0, h=0.05, steps=STEPS, every=6)
        for k, y in enumerate(y0):
            single = Problem(force=of.force, y0=tuple(y), name="single")
            run = solve(single, method, h=0.05, steps=STEPS, every=6)
            assert found.t == pytest.approx(run.t)
            # the enhanced start takes its trial steps in lanes here, with the reference there: the
            # starts differ by some units of rounding, which 12 steps of 0.05 do not double
            assert np.abs(found.y[:, k] - run.y).max() < 64 * 2.0**-52 * np.abs(run.y).max()


def test_a_lane_that_leaves_the_finite_numbers_does_not_touch_the_others():
    growth = Problem(f=("y[0]*y[0]",), y0=(1.0,), name="growth")  # y = y0/(1 - y0 t)
    y0 = np.array([[-1.0], [4.0], [-2.0], [0.4]])
    for width in (1, 8):
        found = solve_ensemble(growth, "rk4", y0, h=0.1, steps=20, width=width)
        bad = [outcome is Outcome.NOT_FINITE for outcome in found.outcomes]
        assert bad == [False, True, False, False]
        assert sum(outcome is Outcome.COMPLETED for outcome in found.outcomes) == 3
        assert not found.completed
        assert np.isfinite(found.y).all(), "the last good value is kept"
        assert 2 <= found.steps[1] < 20
        assert found.steps[0] == found.steps[2] == 20
        calm = solve_ensemble(growth, "rk4", y0[[0, 2]], h=0.1, steps=20, width=width)
        np.testing.assert_array_equal(found.values[[0, 2]], calm.values)


def test_a_lane_whose_stages_cannot_be_solved_is_named():
    growth = Problem(f=("y[0]*y[0]",), y0=(1.0,), name="growth")
    y0 = np.array([[-1.0], [1.0]])
    found = solve_ensemble(growth, "implicit-midpoint", y0, h=0.25, steps=20, solver="fixed-point")
    assert found.outcomes.tolist() == [Outcome.COMPLETED, Outcome.STAGE_SOLVE_FAILED]
    single = solve(growth, "implicit-midpoint", h=0.25, steps=20, solver="fixed-point")
    assert single.outcome is Outcome.STAGE_SOLVE_FAILED
    assert found.steps[1] == single.steps
    np.testing.assert_array_equal(found.values[1], single.values)


def test_a_start_of_the_file_has_the_bits_it_would_have_alone():
    """Sums of 9 slopes by a library for matrices depend on how many columns there are."""
    of = problem("uneven-plane")
    y0 = initial(of, 67)
    run = partial(solve_ensemble, of, "multistep-general-8", h=0.02, steps=1)
    whole = run(y0)
    for k in (0, 40, 66):
        np.testing.assert_array_equal(whole.values[k], run(y0[[k]]).values[0])


def test_an_infinite_jacobian_stops_its_lane_alone():
    # f' = 1/(2 sqrt(y)) is infinite where a trajectory starts from 0
    edge = Problem(f=("sqrt(y[0])",), y0=(1.0,), name="edge")
    y0 = np.array([[1.0], [0.0], [0.25]])
    found = solve_ensemble(edge, "implicit-midpoint", y0, h=0.01, steps=5, solver="newton", width=8)
    for k, y in enumerate(y0):
        one = Problem(f=edge.f, y0=tuple(y), name="one")
        run = solve(one, "implicit-midpoint", h=0.01, steps=5, solver="newton")
        assert (found.outcomes[k], found.steps[k]) == (run.outcome, run.steps)
        np.testing.assert_array_equal(found.values[k], run.values)
    assert [x is Outcome.STAGE_SOLVE_FAILED for x in found.outcomes] == [False, True, False]


def swing(t, y, params, out):
    """A driven chain with a library function: p_i' = sin(q_{i-1} - 2 q_i + q_{i+1}) + cos(t)/8."""
    n = len(y) // 2
    for i in range(n):
        pull = -2 * y[i]
        if i > 0:
            pull += y[i - 1]
        if i + 1 < n:
            pull += y[i + 1]
        out[i] = y[n + i]
        out[n + i] = sin(pull) + cos(t) / params[0]


SWING = Problem(f=Loops(swing, (24,), (8,)), y0=tuple(i / 8 for i in range(24)), name="swing")
PRODUCTS = Problem(  # no loops, and more components than local variables are made for
    force=tuple(f"q[{(i + 1) % 11}]*q[{(i + 2) % 11}]/4 - q[{i}]" for i in range(11)),
    y0=(*(1 + i / 16 for i in range(11)), *(0,) * 11), name="products",
)  # fmt: skip
LARGE = {
    "fput": (problem("fput", sites=11), 0.05),
    "bodies": (problem("n-body", bodies=4), 1e-3),
    "solar": (problem("outer-solar-system"), 50.0),
    "toda": (problem("toda", sites=11), 0.05),
    "chain": (problem("nonseparable-chain", sites=11), 0.01),
    "swing": (SWING, 0.05),
    "products": (PRODUCTS, 0.05),
}
SEPARABLE = (
    "stormer-verlet", "pair-rkn-6-8b", "multistep-rkn-8", "kahan-li-8", "pair-6-8",
    "yoshida-verlet-6", "multivalue-rkn-12",
)  # fmt: skip
ANY = ("rk4", "ab-3", "gauss-2", "gauss-3", "g6245-w3", "s4-symmetric", "lobatto-iiia-3", "sdirk-3")


@pytest.mark.slow
@pytest.mark.sampled(1, whole=8)
@pytest.mark.parametrize("method", [*SEPARABLE, *ANY])
@pytest.mark.parametrize("name", LARGE)
def test_lanes_of_large_systems_have_the_bits_of_single_runs(name, method):
    of, h = LARGE[name]
    if method in SEPARABLE and not of.separable:
        pytest.skip("a pair needs separate parts")
    y0 = np.array(of.y0) * (1 + np.random.default_rng(5).uniform(-0.01, 0.01, (11, of.dimension)))
    options = {"h": h, "steps": STEPS, "start": "zero", "solver": "fixed-point", "threads": 1}
    found = solve_ensemble(of, method, y0, width=8, **options)
    alone = solve_ensemble(of, method, y0, width=1, **options)
    assert (found.width, alone.width) == (8, 1)
    assert found.completed and np.isfinite(found.values).all()
    np.testing.assert_array_equal(found.values, alone.values)
    assert found.evaluations == alone.evaluations


@pytest.mark.slow
def test_a_lane_of_a_large_system_that_fails_is_named_and_stands_still():
    growth = Problem(f=tuple(f"y[{i}]*y[{i}]" for i in range(21)), y0=(1.0,) * 21, name="growth")
    y0 = np.array([-1.0, 4.0, 1.0, 0.25])[:, None] * np.linspace(0.9, 1, 21)
    for method, h in (("rk4", 0.1), ("implicit-midpoint", 0.25), ("gauss-2", 0.25)):
        options = {"h": h, "steps": 12, "solver": "fixed-point", "threads": 1}
        found = solve_ensemble(growth, method, y0, width=8, **options)
        alone = solve_ensemble(growth, method, y0, width=1, **options)
        assert found.width == 8 and not found.completed and found.outcomes[0] is Outcome.COMPLETED
        assert found.outcomes.tolist() == alone.outcomes.tolist()
        np.testing.assert_array_equal(found.steps, alone.steps)
        np.testing.assert_array_equal(found.values, alone.values)
        assert np.isfinite(found.values).all()


@pytest.mark.sampled(2)
@pytest.mark.parametrize("d", [1, 12])
@pytest.mark.parametrize("method", ["multistep-rkn-8", "stormer-verlet", "multivalue-rkn-12"])
def test_kicked_values_of_a_run_that_fails_are_those_of_its_last_step(method, d):
    """Here the force is the first that is no number: velocities are read with the one before."""
    force = tuple(f"6*q[{i}]*q[{i}]" for i in range(d))
    growth = Problem(force=force, y0=(1.5,) * d + (0.1,) * d, name="growth")
    y0 = np.array([growth.y0])
    options = {"h": 0.01, "start": "zero", "threads": 1}
    for width in (1, 8):
        found = solve_ensemble(growth, method, y0, steps=170, width=width, **options)
        assert found.outcomes[0] is Outcome.NOT_FINITE
        before = solve_ensemble(growth, method, y0, steps=int(found.steps[0]), **options)
        assert before.completed and np.isfinite(found.values).all()
        np.testing.assert_array_equal(found.values, before.values)


def branching(t, y, params, out):
    """A body whose course depends on the state."""
    for i in range(len(y)):
        out[i] = -y[i]
        if y[i] > 0:
            out[i] = -2 * y[i]


@pytest.mark.slow
def test_what_has_no_lanes_goes_one_by_one():
    def width(of, method, h=0.01, **options):
        y0 = np.array([of.y0])
        return solve_ensemble(of, method, y0, h=h, steps=1, start="zero", **options).width

    branch = Problem(f=Loops(branching, (24,)), y0=(1.0,) * 24, name="branch")
    assert width(branch, "rk4") == width(branch, "rk4", width=8) == 1
    assert width(Problem(f=lambda t, y: [-x if x > 0 else x for x in y], y0=(1.0,)), "rk4") == 1
    chain = problem("nonseparable-chain", sites=16)
    assert width(chain, "gauss-2") == 8
    assert width(chain, "gauss-2", solver="newton") == 1
    assert width(chain, "gauss-2", 0.4, width=8) == 1, "a single run takes Newton's method there"


@pytest.mark.slow
def test_lanes_that_leave_the_cache_are_taken_for_pairs_of_bodies_only():
    def width(of, **options):
        return solve_ensemble(
            of, "rk4", np.array([of.y0]), h=1e-4, steps=1, solver="fixed-point", **options
        ).width

    large = problem("fput", sites=512)
    assert width(large) == 1 and width(large, width=8) == 8
    assert width(problem("fput", sites=32)) == 8
    assert width(problem("n-body", bodies=96)) == 8


def test_the_source_of_lanes_is_kept(monkeypatch):
    of, h = LARGE["fput"]
    y0 = np.array([of.y0, of.y0])
    first = solve_ensemble(of, "gauss-2", y0, h=h, steps=2)
    written = []
    monkeypatch.setattr("glmref.engine.runners.lane_source", lambda *given: written.append(given))
    monkeypatch.setattr("glmref.engine.kernel.shape_of", lambda *given, **_: written.append(given))
    moved = y0 + 1.0 / 64
    assert solve_ensemble(of, "gauss-2", moved, h=h, steps=2).width == first.width == 8
    assert not written, "the shape and the source do not depend on the initial values"


def test_cancelling_keeps_what_was_done():
    of, calls = problem("kepler"), []

    def cancel():
        calls.append(1)
        return len(calls) > 2

    found = solve_ensemble(of, "gauss-2", initial(of, 4), h=1e-3, steps=10**8, cancel=cancel)
    assert set(found.outcomes) == {Outcome.CANCELLED}
    assert np.isfinite(found.values).all()
    assert (found.steps > 0).all() and (found.steps < 10**8).all()


@pytest.mark.parametrize("width", [None, 1])
def test_a_start_that_overflows_keeps_the_initial_value(width):
    # the start squares h y: beyond the range for the first trajectory alone
    of = Problem(f=("y[0]*y[0]",), y0=(1.0,))
    given = [[1e160], [1e-300]]
    found = solve_ensemble(of, "s4-symmetric", given, h=1e-3, steps=2, width=width)
    assert [str(x) for x in found.outcomes] == ["not finite", "completed"]
    assert np.isfinite(found.y).all() and np.isfinite(found.values).all()
    assert found.y[-1, 0] == given[0] and list(found.steps) == [0, 2]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"initial": np.ones(4)}, "`initial` must have shape \\(N, d\\) with d = 4"),
        ({"initial": np.ones((2, 3))}, "got \\(2, 3\\)"),
        ({"initial": [[1.0] * 4, [math.nan] * 4]}, "`initial` must be finite, got .* in row 1"),
        ({"width": 5}, "`width` must be 1 or one of"),
        ({"threads": 0}, "`threads` must be a whole number >= 1, got 0"),
        ({"start": np.ones((2, 4))}, "starting values must have shape \\(N, r, d\\)"),
        ({"start": "first"}, "`start` must be enhanced, zero or values"),
        ({"arithmetic": "exact"}, "`arithmetic` must be one of"),
        ({"h": math.inf}, "`h` must be finite"),
    ],
)
def test_arguments_that_do_not_fit_are_refused(arguments, message):
    given = {"initial": np.ones((2, 4)), "h": 0.1, "steps": 1, **arguments}
    y0 = given.pop("initial")
    with pytest.raises(UsageError, match=message):
        solve_ensemble("kepler", "gauss-2", y0, **given)


@pytest.mark.parametrize("width", [1, 8])
def test_ctrl_c_keeps_the_rows_that_were_read(width):
    of, calls = problem("kepler"), []

    def cancel():
        calls.append(1)
        if len(calls) > 2:
            raise KeyboardInterrupt
        return False

    y0 = initial(of, 2)
    options = {"h": 0.05, "every": 2, "width": width, "threads": 1}
    with pytest.raises(Interrupted) as caught:
        solve_ensemble(of, "rk4", y0, steps=6, cancel=cancel, **options)
    found = caught.value.solution
    whole = solve_ensemble(of, "rk4", y0, steps=6, **options)
    assert set(found.outcomes) == {Outcome.CANCELLED} and not found.completed
    rows = len(found.t)
    assert found.t.tolist() == pytest.approx([*whole.t[: rows - 1], found.steps.min() * 0.05])
    np.testing.assert_array_equal(found.y[: rows - 1], whole.y[: rows - 1])
    np.testing.assert_array_equal(found.y[-1], found.values[:, 0])


@pytest.mark.slow
def test_what_was_built_is_said_with_its_seconds():
    of = problem("henon-heiles")
    y0 = initial(of, 3)

    def run(method, **options):
        begin = time.perf_counter()
        found = solve_ensemble(of, method, y0, h=0.1, steps=2, start="zero", **options)
        assert 0 < found.seconds + found.build_seconds < time.perf_counter() - begin
        assert found.build_seconds > 0 and found.seconds > 0
        return found

    assert run("rk4", width=8).kernel == "native, standard form, 8 lanes"
    assert run("rk4", width=8, arithmetic="fused").kernel == "native, standard form, 8 lanes, fused"
    words = run("g6245-w3", width=8, solver="newton").kernel.split(", ")
    assert words[0] == "native" and words[2:] == ["newton", "8 lanes"]
    alone = run("rk4", width=1)
    assert alone.kernel == "native, standard form, compensated, scalar target"
    assert alone.threads >= 1 and alone.width == 1


def test_interpreted_kernels_are_stepped_in_one_thread(monkeypatch):
    monkeypatch.setattr("glmref.engine.runners.prepare", partial(prepare, interpreted=True))
    of, y0 = Problem(f=("-y[0]",), y0=(1.0,)), np.array([[1.0], [-2.0]])
    found = solve_ensemble(of, "rk4", y0, h=0.1, steps=3, threads=4, width=1)
    assert found.kernel.startswith("python") and found.threads == 1
    factor = sum((-0.1) ** k / math.factorial(k) for k in range(5)) ** 3
    assert found.y[-1].ravel().tolist() == pytest.approx([factor, -2 * factor], rel=1e-14)
