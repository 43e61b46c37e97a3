"""Work-precision records: what is asked is there, what is not asked is not, all of it is JSON."""

import math

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.errors import UsageError
from glmref.measure.work_precision import (
    Deadline,
    Reference,
    check_interruption,
    measure,
    reference_state,
    state_error,
)
from glmref.problems import Problem, problem
from tests.build import refused, scene_text

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


@pytest.mark.parametrize(
    ("ask", "message"), [(("speed",), "got 'speed'"), (("energy",), "has no Hamiltonian")]
)
def test_questions_without_answer_are_refused(ask, message):
    plain = Problem(f=("-y[0]",), y0=(1,))
    refused(UsageError, message, measure, plain, load("rk4"), h=0.1, steps=10, ask=ask, **FAST)


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


def test_a_stored_reference_is_found_by_its_time():
    found = reference_state(problem("henon-heiles"), 10.0)
    assert found.kind == "stored"
    assert found.state[0] == pytest.approx(-0.014151561495647998, rel=1e-15)


def test_a_state_error_is_relative_and_euclidean():
    reference = Reference(np.array([3.0, 4.0]), 0.0, "exact")
    assert state_error(np.array([3.0, 4.5]), reference) == pytest.approx(0.1)
    assert state_error(np.array([0.5]), Reference(np.zeros(1), 0.0, "exact")) == 0.5


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
    with pytest.raises(KeyboardInterrupt):
        check_interruption(found, Deadline(1.0))


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
