"""solve(): what is asked for, what comes back, and every way to end."""

import math
import threading
import tracemalloc

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine.function_checks import CALLS
from glmref.engine.kernel import prepare
from glmref.engine.outcome import Interrupted, Outcome

GROWTH = Problem(f=("y[0]*y[0]",), y0=(1.0,), name="growth")  # y = 1/(1 - t)


@pytest.mark.parametrize("engine", ["interpreted", "reference"])
@pytest.mark.parametrize("before", [[], [0.25], [0.25, 1.0], [0.5, 1.0, 1.5], [1.25, 1.5]])
def test_a_run_that_fails_between_times_ends_with_its_last_good_step_once(before, engine):
    found = solve(GROWTH, "rk4", h=0.25, times=[*before, 5.0], engine=engine)
    assert found.outcome is Outcome.NOT_FINITE and found.steps == 6
    assert found.t.tolist() == sorted({*before, 1.5}) and len(found.y) == len(found.t)


@pytest.mark.parametrize(("method", "stages"), [("sdirk-3", 2), ("gauss-2", 2), ("gauss-3", 3)])
def test_slopes_that_are_linear_in_time_are_guessed(method, stages, tmp_path, monkeypatch):
    """The first guess of a stage is extrapolated from two slopes or more: one round confirms it."""
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    of = Problem(f=("t + 0*y[0]",), y0=(1.0,), t_span=(1.0, 2.0))
    found = solve(of, method, h=1 / 128, steps=128, engine="interpreted", solver="fixed-point")
    assert found.completed and stages * 128 <= found.evaluations < 1.3 * stages * 128


def test_a_fixed_point_that_does_not_contract_gives_way_to_newton():
    stiff = Problem(f=("-1000*(y[0] - cos(t))",), y0=(1.0,), name="stiff")
    run = solve(stiff, "gauss-2", h=0.5, steps=10)
    assert run.completed
    assert abs(run.y[-1, 0] - math.cos(5.0)) < 0.1
    assert "newton" in run.kernel
    forced = solve(stiff, "gauss-2", h=0.5, steps=10, solver="fixed-point")
    assert forced.outcome is Outcome.STAGE_SOLVE_FAILED
    assert "newton" in forced.message


def test_newton_takes_over_in_the_middle_of_a_run():
    # contraction h |f'| / 2 = 5 t^4 grows from 0 through 1
    late = Problem(f=("-100*t**4*(y[0] - 1) + 0*y[0]",), y0=(2.0,), name="late")
    run = solve(late, "implicit-midpoint", h=0.1, steps=20)
    assert run.completed
    assert any("Newton from there on" in notice for notice in run.notices)
    whole = solve(late, "implicit-midpoint", h=0.1, steps=20, solver="newton")
    assert abs(run.y[-1, 0] - whole.y[-1, 0]) < 1e-12


def test_an_interrupt_ends_the_run_as_cancelled():
    import _thread

    solve("kepler", "gauss-2", h=0.001, steps=10)  # compiled: an interrupt there ends the call
    timer = threading.Timer(0.3, _thread.interrupt_main)
    timer.start()
    with pytest.raises(Interrupted) as caught:
        solve("kepler", "gauss-2", h=0.001, steps=10**9)
    run = caught.value.solution
    assert run.outcome is Outcome.CANCELLED
    assert run.steps > 0


def test_chunks_do_not_change_a_bit():
    kepler, method, h = problem("kepler"), load("g6245"), 0.02
    for solver in ("fixed-point", "newton"):
        kernel = prepare(method, kepler, h=h, solver=solver)
        ends = []
        for pieces in ((400,), (1, 7, 100, 292), (200, 200)):
            values = np.zeros((4, 4))
            values[0] = kepler.y0
            state = kernel.state(values, kepler.f(0.0, kepler.y0), h)
            out, done = np.zeros((1, 1, 4)), 0
            for piece in pieces:
                done += piece
                kernel.advance(state, done, t0=0.0, h=h, every=0, out=out)
            ends.append(kernel.values(state))
        np.testing.assert_array_equal(ends[0], ends[1])
        np.testing.assert_array_equal(ends[0], ends[2])


@pytest.mark.parametrize("name", ["rk4", "gauss-2", "s4-symmetric", "sdirk-3", "lobatto-iiia-3"])
def test_evaluations_are_counted_exactly(name):
    calls = [0]

    def f(t, y):
        calls[0] += 1
        return [y[1], -math.sin(y[0])]

    pendulum = Problem(f=f, y0=(1.2, 0.0), name="counted")
    run = solve(pendulum, name, h=0.1, steps=25, engine="interpreted", solver="fixed-point")
    # the predictor's start is among start_evaluations; CALLS look at the function
    assert calls[0] == run.total_evaluations + CALLS
    calls[0] = 0
    slow = solve(pendulum, name, h=0.1, steps=25, engine="reference")
    assert calls[0] == slow.total_evaluations + CALLS


def test_memory_does_not_grow_with_the_number_of_steps():
    kepler, method = problem("kepler"), load("gauss-2")
    solve(kepler, method, h=0.01, steps=10)
    peaks = []
    for steps in (1_000, 100_000):
        tracemalloc.start()
        solve(kepler, method, h=0.01, steps=steps)
        peaks.append(tracemalloc.get_traced_memory()[1])
        tracemalloc.stop()
    assert peaks[1] < peaks[0] + 20_000


def test_a_finishing_method_is_applied_to_every_row_and_counted():
    from glmref import FinishingMethod

    method = load("rk4")
    finish = FinishingMethod(A=(), b=())
    assert solve("pendulum", method, h=0.1, steps=5).finish_evaluations == 0
    from dataclasses import replace

    from glmref.exact import exact

    shifted = replace(method, finishing=FinishingMethod(A=((exact(0),),), b=(exact(1),)))
    plain = solve("pendulum", method, h=0.1, steps=4, every=2)
    run = solve("pendulum", shifted, h=0.1, steps=4, every=2)
    f = problem("pendulum").f
    for row in range(3):
        expected = plain.y[row] + 0.1 * np.asarray(f(0.0, plain.y[row]))
        assert np.abs(run.y[row] - expected).max() < 1e-15
    assert run.finish_evaluations == 3
    assert finish.stages == 0


@pytest.mark.slow
def test_arithmetic_can_be_chosen():
    kernels = {
        arithmetic: solve("pendulum", "gauss-2", h=0.1, steps=10, arithmetic=arithmetic).kernel
        for arithmetic in ("strict", "fused", "compensated", "naive")
    }
    assert kernels["fused"] == kernels["strict"].replace(", scalar", ", fused, scalar")
    assert "mu form" in kernels["strict"]
    assert "standard form" in kernels["compensated"]
    assert "not compensated" in kernels["naive"]


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize(("method", "steps"), [("gauss-5", 200), ("blanes-moan-rkn-6-14", 4000)])
def test_fused_sums_are_compensated_all_the_same(method, steps):
    """At these steps the error of the method is below round-off, so that the energy shows sums.

    Uncompensated, each of N steps loses up to one unit of roundoff u for each of several values,
    half of it in the mean: a random walk of more than sqrt(N) u/2. Compensated sums lose nothing
    of size u in a step; what is left is the rounding of h f, which is smaller by a factor h.
    """
    p, walk = problem("kepler"), math.sqrt(400_000) / 2 * 2.0**-53

    def deviation(arithmetic):
        run = solve(p, method, h=2 * math.pi / steps, steps=400_000, every=400,
                    arithmetic=arithmetic)  # fmt: skip
        energy = [p.hamiltonian(y) for y in run.y]
        return max(abs(x / energy[0] - 1) for x in energy)

    assert deviation("fused") < walk
    assert deviation("naive") > walk


@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["gauss-3", "g6245-w3"])
def test_quick_rounds_are_fewer_and_end_near(name):
    strict, quick = (
        solve("henon-heiles", name, h=0.1, steps=200, arithmetic=arithmetic, solver="fixed-point")
        for arithmetic in ("strict", "quick")
    )
    assert quick.evaluations < 0.97 * strict.evaluations and "quick" in quick.kernel
    assert 0 < np.abs(quick.y - strict.y).max() < 1e-10
    assert "quick" not in solve("kepler", "rk4", h=0.1, steps=1, arithmetic="quick").kernel
