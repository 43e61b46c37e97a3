"""Timing, drift, laws of growth, paths in a plane: exact on made-up series, and on known problems."""

import json
import math
import os
import platform
import time
from dataclasses import replace

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.solve import solve
from glmref.errors import UsageError
from glmref.measure.law import fit_law, samples_of
from glmref.measure.longtime import (
    along,
    energy_scale,
    exponent,
    follow,
    g_form,
    quantities,
    watch,
)
from glmref.measure.orbit import POINTS, marks, orbit
from glmref.measure.timing import circumstances, repeat
from glmref.measure.work_precision import Deadline, check_interruption, measure
from glmref.method.rounding import float_arrays
from glmref.problems import Problem, problem
from glmref.scenes.running import _kept_series
from tests.build import refused, scene_text


def test_repeat_runs_as_often_as_asked_and_returns_the_last_result():
    calls = iter(range(10))
    result, timing = repeat(lambda: next(calls), repeats=4, budget=60.0)
    assert (result, timing.repeats) == (3, 4)


def test_repeat_runs_once_even_without_a_budget():
    result, timing = repeat(lambda: "done", repeats=100, budget=0.0)
    assert (result, timing.repeats) == ("done", 1)


def test_repeat_measures_the_wall_clock():
    _, timing = repeat(lambda: time.sleep(0.01), repeats=2)
    assert timing.median >= 0.01


def test_circumstances_name_versions_and_machine_and_nothing_private():
    found = circumstances()
    text = json.dumps(found)
    assert {"machine", "system", "processor", "cores", "versions"} == set(found)
    assert {"python", "numpy", "numba"} <= set(found["versions"])
    assert os.getcwd() not in text
    assert platform.node() not in text or platform.node() in found["processor"]


# -- laws of error growth, on made-up deviations and on known runs


T = np.arange(0, 4097.0)


@pytest.mark.parametrize(
    ("kind", "power"), [("bounded", 0.0), ("random walk", 0.5), ("linear", 1.0), ("quadratic", 2.0)]
)
def test_pure_powers_have_their_law(kind, power):
    wave = 2 + np.sin(T)
    law = fit_law(T, np.where(T > 0, 1e-9 * T**power * wave / 4096**power, 0.0))
    assert law.kind == kind
    # the wave averages out over the 100 and more periods of each stretch
    assert law.exponent == pytest.approx(power, abs=0.05)
    assert law.time == 4096


def test_random_walks_are_random_walks():
    # one walk's exponent scatters by 0.3; the mean of 64 has a standard error of 0.04
    steps = np.random.default_rng(1).standard_normal((64, len(T) - 1))
    walks = np.concatenate([np.zeros((64, 1)), np.cumsum(steps, axis=1)], axis=1) * 1e-16
    rms = np.sqrt(np.mean(walks**2, axis=0))
    assert fit_law(T, rms).kind == "random walk"
    assert fit_law(T, rms).exponent == pytest.approx(0.5, abs=0.12)


def test_what_reaches_its_own_size_or_ends_early_has_blown_up():
    grown = fit_law(T, np.exp(T / 100) * 1e-9)
    assert grown.kind == "blow-up" and math.isnan(grown.exponent)
    # 1e-9 exp(t/100) = 1 at t = 100 log(1e9)
    assert grown.time == pytest.approx(100 * math.log(1e9), abs=1)
    assert fit_law(T, 0 * T, ended=True).kind == "blow-up"
    assert fit_law(T, np.where(T > 9, math.nan, 0.0)).time == 10


def test_nothing_is_bounded():
    law = fit_law(T, 0 * T)
    assert (law.kind, law.largest, law.last) == ("bounded", 0.0, 0.0)


def test_unknown_quantities_are_refused():
    kepler, method = problem("kepler"), load("rk4")
    run = solve(kepler, method, h=0.1, steps=2, every=1)
    with pytest.raises(UsageError, match="conserves no 'heat'; there are energy, angular momentum"):
        samples_of(kepler, method, run, "heat")
    with pytest.raises(UsageError, match="conserves no 'form of angular momentum'"):
        samples_of(kepler, method, run, "form of angular momentum")
    run, g_symplectic = solve(kepler, "gsymplectic-n", h=0.1, steps=2), load("gsymplectic-n")
    with pytest.raises(UsageError, match="solve with history=True"):
        samples_of(kepler, g_symplectic, run, "form of angular momentum")
    stiff = problem("van-der-pol")
    with pytest.raises(UsageError, match="conserves no 'energy'; there are none"):
        samples_of(stiff, method, solve(stiff, method, h=1e-6, steps=2), "energy")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "parameters", "method", "h", "steps", "kind"),
    [
        ("pendulum", {"q0": "23/10"}, "gsymplectic-p", 0.1, 400, "blow-up"),
        ("pendulum", {"q0": "23/10"}, "rk4", 0.1, 4096, "linear"),
        ("pendulum", {"q0": "23/10"}, "gauss-2", 0.1, 4096, "bounded"),
        ("pendulum", {"q0": "23/10"}, "g6245", 0.1, 2048, "bounded"),
        ("harmonic-oscillator", {}, "ab-2", 0.05, 2048, "linear"),
        ("rigid-body", {}, "rk4", 0.1, 32768, "linear"),
    ],
)
def test_laws_of_known_runs(name, parameters, method, h, steps, kind):
    subject, one = problem(name, **parameters), load(method)
    run = solve(subject, one, h=h, steps=steps, every=max(1, steps // 2048))
    deviation = samples_of(subject, one, run, "energy")
    assert fit_law(run.t, deviation, ended=not run.completed).kind == kind


# -- drift records: exact on made-up series, and on problems whose behaviour is known


TIMES = np.linspace(0.0, 1000.0, 2001)


def test_random_walks_have_exponent_one_half_on_average():
    random = np.random.default_rng(1)
    steps = random.standard_normal((400, len(TIMES) - 1))
    walks = np.hstack([np.zeros((400, 1)), np.cumsum(steps, axis=1)])
    rms = np.sqrt(np.mean(walks**2, axis=0))
    assert abs(exponent(TIMES, rms) - 0.5) < 0.1


def test_functions_of_states_work_on_rows_even_if_they_are_not_vectorised():
    y = np.arange(12.0).reshape(6, 2)
    expected = y[:, 0] + y[:, 1]
    assert np.array_equal(along(lambda s: s[0] + s[1], y), expected)
    assert np.array_equal(along(lambda s: float(s[0]) + float(s[1]), y), expected)
    square = np.arange(4.0).reshape(2, 2)
    assert np.array_equal(along(lambda s: s[0], square), square[:, 0])


def test_g_form_is_the_double_sum():
    random = np.random.default_rng(3)
    history = random.standard_normal((5, 3, 2))
    G, C = random.standard_normal((3, 3)), random.standard_normal((2, 2))
    G, C = G + G.T, C + C.T
    expected = [
        sum(G[i, j] * row[i] @ C @ row[j] for i in range(3) for j in range(3)) for row in history
    ]
    assert np.allclose(g_form(history, G, C), expected, rtol=1e-13)


@pytest.mark.parametrize("steps", [1, 999, 1000, 1001, 5000])
def test_following_in_stretches_is_one_long_run(steps):
    subject, method = problem("pendulum"), load("rk4")
    long = follow(subject, method, h=0.01, steps=steps, engine="interpreted")
    once = solve(subject, method, h=0.01, steps=steps, engine="interpreted")
    assert (long.steps, long.evaluations) == (steps, 4 * steps)
    # a stretch restarts the compensation of y, nothing else
    assert np.max(np.abs(long.y[-1] - once.y[-1])) < 1e-12
    assert long.t[-1] == pytest.approx(steps * 0.01, rel=1e-12)
    assert np.all(np.diff(long.t) > 0)
    assert len(long.t) == len(long.y) == len(long.history) <= steps + 1


def test_following_stops_where_it_is_told():
    found = follow(
        problem("pendulum"), load("rk4"), h=0.01, steps=50_000, engine="interpreted",
        lost=lambda part: True,
    )  # fmt: skip
    assert found.steps == 1000


@pytest.mark.parametrize("name", ["gsymplectic-n", "g4123", "pair-rkn-6-8b", "rk4"])
def test_following_renews_as_a_run_does(name):
    subject, method = problem("pendulum", q0="6/5"), load(name)
    options = {"h": 0.05, "steps": 250, "engine": "interpreted", "renew": 40}
    long, once = follow(subject, method, **options), solve(subject, method, **options)
    assert long.renewals == once.renewals == (0 if name == "rk4" else 6)
    assert long.start_evaluations == once.start_evaluations
    assert np.max(np.abs(long.y[-1] - once.y[-1])) < 1e-12


def test_what_a_method_keeps_is_its_form_and_not_that_of_the_solution():
    subject, method = problem("kepler"), load("gsymplectic-n")
    found = solve(subject, method, h=0.05, steps=400, every=1, history=True)
    G, _ = float_arrays(method.G)
    form, solution = (max(x for _, x in _kept_series(subject, found, y)) for y in (G, None))
    assert form < 1e-14 and solution > 1e-6


def test_a_quadratic_form_that_is_zero_is_measured_by_its_terms():
    falling = replace(problem("kepler"), y0=("1/2",) * 4)  # an angular momentum of 1/4 - 1/4
    found = solve(falling, "rk4", h=0.01, steps=1, every=1)
    scales = {name: scale for name, _, _, scale in quantities(falling, found)}
    assert scales["angular momentum"] == 0.5


def test_watch_needs_history_for_the_form():
    subject = problem("rigid-body")
    found = solve(subject, "rk4", h=0.1, steps=3, engine="reference")
    refused(UsageError, "history=True", watch, subject, found, G=np.eye(1))


def test_an_energy_that_cancels_is_measured_by_its_terms():
    """In Sundman's time the energy is H - H_0 times a factor: zero at the start but for rounding.

    With e = 0.9 the terms of Kepler's energy are of size 1 to 20, not 1e-16 and not 1e5.
    """
    transformed = problem("kepler-sundman", eccentricity=0.9)
    start = np.asarray(transformed.y0, dtype=float)
    assert abs(along(transformed.hamiltonian, start[None])[0]) < 1e-14
    assert 0.1 < energy_scale(transformed, start) < 100
    # where nothing cancels it is the energy itself, to the last bit
    plain = problem("kepler", eccentricity=0.9)
    start = np.asarray(plain.y0, dtype=float)
    assert energy_scale(plain, start) == abs(plain.hamiltonian(start))


# -- paths in a plane: which plane, which points, and where they stop


def test_marks_are_spread_evenly_from_the_start_to_the_end():
    for steps in (1, 7, 399, 400, 10_000, 123_457):
        found = marks(steps, POINTS)
        assert found[0] == 0 and found[-1] == steps and found == sorted(set(found))
        assert len(found) <= POINTS
        # of n places {k phi} the largest gap is below 1.9/n (three gaps, the ratio of two is phi)
        assert max(np.diff(found)) <= 1.9 * steps / (POINTS - 1) + 1


def largest_gap(places, period):
    """Largest part of a revolution without a point."""
    phases = np.sort(np.unique(np.array(places) % period)) / period
    return float(np.max(np.diff([*phases, phases[0] + 1])))


@pytest.mark.parametrize("period", [50, 100, 101, 250, 400, 800, 1000])
def test_no_revolution_beats_with_the_marks(period):
    steps = 100 * period
    assert largest_gap(marks(steps, POINTS), period) < 0.05
    # evenly spaced ones do beat: one in steps/400 is four to a revolution, always the same four
    evenly = range(0, steps, steps // POINTS)
    if period % 4 == 0:
        assert largest_gap(evenly, period) > 0.2


@pytest.mark.slow
def test_points_lie_on_the_path():
    subject = problem("kepler")
    found = orbit(subject, load("gauss-5"), h=2 * np.pi / 200, steps=400)
    # gauss-5 at 200 steps a revolution errs by less than 1e-9 here; seven digits are kept
    exact = np.array([subject.solution(t)[:2] for t in found.t])
    assert np.max(np.abs(found.paths[0] - exact)) < 1e-6
    assert np.max(np.abs(found.paths[0] - exact[:, ::-1])) > 0.5  # the axes are not exchanged
    assert found.ended == "" and found.t[-1] == pytest.approx(4 * np.pi)


def test_bodies_share_the_points():
    found = orbit(problem("figure-eight"), load("gauss-2"), h=0.05, steps=1000)
    assert found.paths.shape == (3, POINTS // 3, 2)
    # one curve is followed by all: each passes the start of every other one
    for path in found.paths:
        for start in found.paths[:, 0]:
            assert np.min(np.linalg.norm(path - start, axis=1)) < 0.2


def test_an_energy_of_zero_has_the_size_of_its_terms():
    # r (H + w) is 0 at the start, but for rounding
    subject = problem("kepler-sundman")
    assert abs(subject.hamiltonian(subject.y0)) < 1e-15
    found = orbit(subject, load("rk4"), h=0.1, steps=300)
    assert found.ended == "" and len(found.t) > 200
    assert orbit(subject, load("euler"), h=0.1, steps=3000).ended.startswith("lost after")


def test_numbers_that_are_not_finite_are_left_out():
    pair = Problem(f=("y[0]*y[0]", "y[1]"), y0=[1, 1], t_span=(0, 2))
    found = orbit(pair, load("rk4"), h=0.1, steps=20)
    assert found.ended and np.isfinite(found.paths).all()
    assert 1.0 <= found.t[-1] < 2.0


# -- work-precision records: what is asked is there, what is not asked is not, all of it is JSON


FAST = {"engine": "interpreted", "repeats": 2}


def test_the_state_error_of_rk4_on_the_oscillator_is_what_the_formula_says():
    found = measure(problem("harmonic-oscillator"), load("rk4"), h=0.1, steps=100, **FAST)
    # R(ih) = exp(ih)(1 + (ih)^5/120 + ...): a relative error of t h^4/120, and dissipation h^6/144
    assert found.state_error == pytest.approx(10 * 0.1**4 / 120, rel=0.02)
    assert found.energy_error == pytest.approx(10 * 0.1**5 / 72, rel=0.02)


def test_a_question_less_costs_no_evaluation_more():
    subject = problem("pendulum")
    costs = [
        measure(subject, load("gauss-2"), h=0.1, steps=50, ask=ask, **FAST).evaluations
        for ask in (("state", "energy"), ("energy",), ())
    ]
    assert costs[0] >= costs[1] >= costs[2]


def test_a_run_that_fails_is_a_record_with_its_sentence():
    explode = Problem(f=("y[0]*y[0]",), y0=(1,), exact=lambda t, y0: y0)
    found = measure(explode, load("rk4"), h=0.5, steps=200, ask=("state",), engine="reference")
    assert found.outcome == "not finite"
    assert found.state_error is None
    assert "not finite in step" in found.message


def test_the_start_is_computed_once_and_its_cost_is_recorded():
    found = measure(problem("pendulum"), load("gsymplectic-n"), h=0.1, steps=10, ask=(), **FAST)
    # three evaluations of the explicit start, one for the predictor
    assert found.start_evaluations == 4
    assert 0 < found.start_seconds < 1


def test_a_run_over_its_budget_is_cancelled_and_keeps_what_it_has():
    found = measure(
        problem("pendulum"), load("gauss-3"), h=1e-3, steps=10**8, ask=(), budget=0.05,
        engine="interpreted",
    )  # fmt: skip
    assert found.outcome == "cancelled"
    assert 0 < found.steps < 10**8
    assert math.isclose(found.t_end, found.steps * 1e-3, rel_tol=1e-9)


def test_a_run_cancelled_by_nobody_else_was_cancelled_by_the_user():
    from glmref.engine.outcome import Outcome
    from glmref.engine.solve import solve

    found = solve(
        problem("pendulum"), "rk4", h=1e-3, steps=10**7, engine="interpreted", cancel=lambda: True
    )
    assert found.outcome is Outcome.CANCELLED
    refused(KeyboardInterrupt, "", check_interruption, found, Deadline(1.0))


@pytest.mark.parametrize(
    ("problem_", "ask"),
    [
        ('name = "blow-up"', ["state"]),
        # the near miss, of a run that is sampled: it can be computed
        ('H = "p**2/2 - cos(q)"\ny0 = { q = 1, p = 0 }', ["state", "invariants"]),
    ],
)
def test_a_reference_that_cannot_be_computed_is_a_state_of_the_record(tmp_path, problem_, ask):
    """The closed form 1/(1 - t) was evaluated at t = 1, and its division ended the task."""
    from glmref.scenes.planning import plan
    from glmref.scenes.reading import load_scene
    from glmref.scenes.running import perform

    path, answer = tmp_path / "singular.toml", 'kind = "fastest"\nat = 1e-3'
    keys = {"methods": ["rk4"], "ask": ask, "t_end": 1, "steps": [16], "repeats": 1}
    path.write_text(scene_text("singular", problem_, answer, **keys))
    (task,) = plan(load_scene(path)).tasks
    record = perform(task)
    assert record["outcome"] == "completed"
    if "invariants" in ask:
        assert record["reference"] == "computed" and record["state_error"] < 1e-3
        return
    assert (record["reference"], record["state_error"]) == ("cannot be computed", None)
    assert "the exact solution of blow-up has no value at t = 1" in record["notices"][-1]
