"""What a solution says of its run: outcome, sentence, times, counts, in two engines alike."""

import time
from typing import Any

import numpy as np
import pytest

from glmref import Problem, solve
from glmref.engine.outcome import Outcome

GROWTH = Problem(f=("y[0]*y[0]",), y0=(1.0,), name="growth")  # y = 1/(1 - t)


def ends(t: float, y: Any) -> list[float]:
    if t > 0.35:
        raise RuntimeError("no more")
    return [-y[0]]


ENDS = Problem(f=ends, y0=(1.0,), name="ends")
ENGINES = pytest.mark.parametrize("engine", ["reference", "interpreted"])


@ENGINES
@pytest.mark.parametrize(
    ("problem", "method", "options", "outcome", "message", "steps", "times"),
    [
        (GROWTH, "euler", {"steps": 2}, Outcome.COMPLETED, "2 steps completed", 2, [0.5]),
        (
            GROWTH, "euler", {"h": -0.25, "steps": 9, "step_limit": 3}, Outcome.STEP_LIMIT,
            "stopped after step_limit = 3 steps, at t = -0.75", 3, [-0.75],
        ),
        (
            GROWTH, "rk4", {"steps": 40, "every": 4}, Outcome.NOT_FINITE,
            ("the right-hand side or the values are not finite in step 7 of 40, t = 1.5; the problem "
             "or the method is unstable there, or h is too large"), 6, [0.0, 1.0],
        ),
        (
            GROWTH, "implicit-midpoint", {"steps": 20}, Outcome.STAGE_SOLVE_FAILED,
            "the stage equations could not be solved in step 3 of 20, t = 0.5; use a smaller h", 2,
            [0.5],
        ),
        (
            ENDS, "rk4", {"h": 0.1, "steps": 9, "every": 2}, Outcome.FUNCTION_FAILED,
            ("the right-hand side failed in step 4 of 9, t = 0.3: `f` raised RuntimeError: no more "
             "at t = 0.35, (0.703778)"), 3, [0.0, 0.2],
        ),
    ],
    ids=["completed", "limited", "not finite", "not solved", "failed"],
)  # fmt: skip
def test_a_run_says_how_it_ended(
    engine: str, problem: Any, method: str, options: dict[str, Any], outcome: Outcome,
    message: str, steps: int, times: list[float],
) -> None:  # fmt: skip
    begin = time.perf_counter()
    run = solve(problem, method, engine=engine, **{"h": 0.25, **options})
    assert (run.outcome, run.message, run.steps) == (outcome, message, steps)
    assert run.t.tolist() == pytest.approx(times)
    assert len(run.y) == len(times) and (run.method, run.problem) == (method, problem.name)
    assert (
        0 < run.seconds <= time.perf_counter() - begin and run.renewals == 0 and run.notices == ()
    )
    if outcome is Outcome.COMPLETED:
        assert repr(run) == "<Solution of growth by euler: completed, 2 steps, t = 0.5>"


@ENGINES
def test_a_run_that_is_done_is_not_cancelled(engine: str) -> None:
    seen: list[tuple[int, int]] = []
    run = solve(GROWTH, "euler", h=0.25, steps=1, engine=engine, cancel=lambda: True,
                progress=lambda *x: seen.append(x))  # fmt: skip
    assert run.completed and run.message == "1 steps completed" and seen[-1] == (1, 1)
    stopped = solve("kepler", "rk4", h=0.01, steps=100, engine=engine, cancel=lambda: True)
    n = 1 if engine == "reference" else 8
    assert stopped.outcome is Outcome.CANCELLED and stopped.steps == n
    assert stopped.message == f"cancelled before step {n + 1} of 100, t = {n * 0.01:.6g}"
    assert stopped.t.tolist() == pytest.approx([n * 0.01])


def test_the_fixed_point_names_newton_as_the_way_out() -> None:
    run = solve(GROWTH, "implicit-midpoint", h=0.25, steps=20, solver="fixed-point",
                engine="interpreted")  # fmt: skip
    assert run.message == (
        "the stage equations could not be solved in step 3 of 20, t = 0.5; use a smaller h or "
        "solver='newton'"
    )
    assert "fixed-point" in run.kernel


@pytest.mark.parametrize(
    ("method", "options", "counts"),
    [
        # evaluations, of q' alone, at the start, of the finish, renewals
        ("rk4", {"steps": 5}, [20, 0, 0, 0, 0]),
        ("leapfrog", {"steps": 5}, [5, 0, 3, 0, 0]),
        ("ab-3", {"steps": 5}, [5, 0, None, 0, 0]),
        ("stormer-verlet", {"steps": 5}, [10, 5, 0, 0, 0]),
        ("s5i2-w3", {"steps": 8, "every": 8, "renew": 4}, [None, None, 30, 39, 1]),
    ],
)
def test_evaluations_are_counted_by_what_they_are_for(method, options, counts):
    reference, run = (
        solve("kepler", method, h=0.05, engine=x, **options) for x in ("reference", "interpreted")
    )

    def of(x: Any) -> list[int]:
        own = [x.evaluations, x.velocity_evaluations, x.start_evaluations]
        return [*own, x.finish_evaluations, x.renewals]

    for wanted, found in zip(counts, of(reference), strict=True):
        assert wanted in (None, found)
    # a kernel keeps the force at the end of a step, and takes the first guess of a predictor
    kept = method in ("stormer-verlet", "s5i2-w3")
    if not kept:
        assert of(run) == of(reference)
    assert of(run)[3:] == of(reference)[3:] and of(run)[2] - of(reference)[2] in (0, 1, 2, 3)
    assert run.t.tolist() == reference.t.tolist()
    np.testing.assert_allclose(run.y, reference.y, rtol=0, atol=1e-12)


@ENGINES
def test_rows_stand_at_the_times_asked_for(engine: str) -> None:
    wide = solve("pendulum", "g6245", h=0.1, steps=7, every=3, history=True, engine=engine)
    assert wide.t.tolist() == pytest.approx([0, 0.3, 0.6, 0.7]) and wide.history is not None
    assert wide.history.shape == (4, 4, 2)
    np.testing.assert_array_equal(wide.history[:, 0], wide.y)
    np.testing.assert_array_equal(wide.history[-1], wide.values)
    some = solve("pendulum", "g6245", h=0.1, times=[0.3, 0.6], engine=engine)
    np.testing.assert_array_equal(some.y, wide.y[1:3])
    assert some.steps == 6 and some.history is None
    assert some.y.base.size == some.y.size, "nothing is kept but what was asked for"
    assert wide.y.shape == (4, 2) and wide.history.size == 4 * wide.y.size
    last = solve("pendulum", "g6245", h=0.1, steps=7, every=0, engine=engine)
    np.testing.assert_array_equal(last.y, wide.y[-1:])
    assert wide.kernel.startswith("reference" if engine == "reference" else "python")
