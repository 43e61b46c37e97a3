"""The start of a pair in the engine: values, cost, order of the stages, and what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from glmref import PairStartingMethod, UsageError, load, problem, solve
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.reference import stepper
from glmref.engine.starting_values import starting_values
from glmref.method import as_matrix, as_vector
from tests.build import floats

H = 0.1


def started(name, start=None, of="pendulum", h=H):
    engine = stepper(load(name) if isinstance(name, str) else name, problem(of))
    return starting_values(engine, start, t=0.0, y0=np.array(engine.problem.y0), h=h)


def by_hand(start, of, h):
    """Values and numbers of calls of k and f, stage by stage in the order Q_1, P_1, Q_2, ..."""
    m = of.dimension // 2
    q0, p0 = np.array(of.y0[:m], dtype=float), np.array(of.y0[m:], dtype=float)
    A, A_hat = floats(start.A), floats(start.A_hat)
    f, k = np.zeros((A.shape[1], m)), np.zeros((A.shape[0], m))
    for _ in range(sum(start.stages) + 1):  # explicit: the sweeps settle one stage each at least
        k = np.array([of.dp(q0 + h * row @ f) for row in A])
        f = np.array([of.dq(p0 + h * row @ k) for row in A_hat])
    u, u_hat = floats([start.u])[0], floats([start.u_hat])[0]
    q = np.outer(u, q0) + h * floats(start.B) @ f
    p = np.outer(u_hat, p0) + h * floats(start.B_hat) @ k
    return np.concatenate([q, p], axis=1)


@pytest.mark.parametrize("name", ["pair-4-4", "pair-6-8", "pair-rkn-6-7"])
@pytest.mark.parametrize("of", ["pendulum", "henon-heiles", "kepler"])
def test_the_start_of_the_file_is_the_default_and_what_its_tableau_says(name, of):
    found = started(name, of=of)
    assert "explicit start" in found.kind
    expected = by_hand(load(name).starting, problem(of), H)
    # a few dozen roundings of numbers below 3
    np.testing.assert_allclose(found.values, expected, rtol=0, atol=2e-14)
    np.testing.assert_array_equal(found.values[0], problem(of).y0)


def test_f_and_k_are_evaluated_once_a_stage_and_only_where_something_reads_it():
    calls = {"dp": 0, "dq": 0, "f": 0}
    base = problem("henon-heiles")

    def counted(name):
        function = getattr(base, name)

        def call(*x):
            calls[name] += 1
            return function(*x)

        return call

    engine = stepper(load("pair-4-4"), base)
    engine.problem = replace(base, dp=counted("dp"), dq=counted("dq"), f=counted("f"))
    calls.update(dp=0, dq=0, f=0)
    start = load("pair-4-4").starting
    taken = engine.of(start).step(0.0, np.array([base.y0]), H)
    evaluations, velocities = taken.evaluations, taken.velocity_evaluations
    assert start.stages == (5, 5)
    # nothing reads k(Q_1): four evaluations of the force
    assert (evaluations, velocities) == (calls["dp"], calls["dq"]) == (4, 5)
    assert calls["f"] == 0
    assert start.read_stages() == frozenset(range(1, 10))  # five Q, then five P


def test_all_engines_start_alike_and_count_alike():
    runs = [
        solve("henon-heiles", "pair-6-8", h=0.05, steps=20, engine=engine)
        for engine in ("compiled", "reference", "interpreted")
    ]
    own = started("pair-6-8", of="henon-heiles", h=0.05)
    assert own.evaluations == 13
    # the compiled sweep evaluates one force more at the first step where it may keep one
    assert {run.start_evaluations - own.evaluations for run in runs} <= {0, 1}
    for run in runs[1:]:
        np.testing.assert_allclose(run.values, runs[0].values, rtol=0, atol=1e-14)
    given = solve("henon-heiles", "pair-6-8", h=0.05, steps=20, start=own.values)
    np.testing.assert_array_equal(given.values, runs[0].values)
    zero = solve("henon-heiles", "pair-6-8", h=0.05, steps=20, start="zero")
    assert np.abs(zero.values[1] - runs[0].values[1]).max() > 1e-10


@pytest.mark.parametrize("of", ["henon-heiles", "kepler"])
def test_many_trajectories_start_as_one(of):
    base = problem(of)
    y0 = np.array(base.y0) + np.linspace(0, 0.05, 3)[:, None]
    many = solve_ensemble(base, "pair-6-8", y0, h=0.05, steps=5)
    for row, end in zip(y0, many.y[-1], strict=True):
        one = solve(replace(base, y0=tuple(row), initial=None), "pair-6-8", h=0.05, steps=5)
        np.testing.assert_allclose(end, one.y[-1], rtol=0, atol=1e-13)
    zero = solve_ensemble(base, "pair-6-8", y0, h=0.05, steps=5, start="zero")
    given = solve_ensemble(base, "pair-6-8", y0, h=0.05, steps=5, start=load("pair-6-8").starting)
    np.testing.assert_array_equal(given.y, many.y)
    assert np.abs(zero.y - many.y).max() > 0


def made(A, A_hat, B, B_hat):
    return PairStartingMethod(
        A=as_matrix(A, "A"), A_hat=as_matrix(A_hat, "A_hat"), B=as_matrix(B, "B"),
        B_hat=as_matrix(B_hat, "B_hat"), u=as_vector([1, 0], "u"),
        u_hat=as_vector([1, 0], "u_hat"),
    )  # fmt: skip


def test_an_implicit_start_is_solved_and_not_taken_for_many():
    start = made([["1/2"]], [["1/2"]], [["0"], ["1"]], [["0"], ["1"]])
    pair, of = load("pair-4-4"), problem("pendulum")
    assert any(block.implicit for block in start.stage_blocks())
    found = started("pair-4-4", start).values
    q0, p0 = of.y0
    f, k = found[1] / H  # Q = q0 + h/2 f(P), P = p0 + h/2 k(Q)
    assert abs(of.dq(np.array([p0 + H / 2 * k]))[0] - f) < 1e-14
    assert abs(of.dp(np.array([q0 + H / 2 * f]))[0] - k) < 1e-14
    with pytest.raises(UsageError, match="need an explicit starting method"):
        solve_ensemble(of, pair, [list(of.y0)], h=H, steps=2, start=start)
    # as the start of the file it gives way to the enhanced start
    own = solve_ensemble(of, replace(pair, starting=start), [list(of.y0)], h=H, steps=2)
    enhanced = solve_ensemble(of, pair, [list(of.y0)], h=H, steps=2, start="enhanced")
    np.testing.assert_array_equal(own.y, enhanced.y)
