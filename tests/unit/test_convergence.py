"""The order meter itself: exact on made-up sequences, honest on irregular ones."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mpmath import mp, mpf

from glmref.catalogue.lookup import load
from glmref.engine.reference import stepper
from glmref.measure.convergence import (
    isochronous,
    isochronous_separable,
    isochronous_threefold,
    method_order,
    observed_order,
)
from glmref.measure.underlying import Underlying
from glmref.problems import problem


def run_of(*terms):
    """n -> sum of c h^p with h = 1/n, at 60 digits, in two components."""

    def run(n):
        with mp.workdps(60):
            h = mpf(1) / n
            value = sum(mpf(c) * h ** mpf(p) for c, p in terms)
            return [1 + value, 2 - 3 * value]

    return run


@given(st.integers(1, 12), st.floats(-2, 2), st.floats(-2, 2))
def test_an_integer_order_is_found_to_a_hundredth(p, a, b):
    found = observed_order(run_of((1, p), (a, p + 1), (b, p + 2)))
    # two extrapolated values agree to 0.01, and halving h more than halves what they lack
    assert found.settled
    assert abs(found.order - p) < 0.01


def test_orders_that_agree_where_they_turn_round_do_not_count_as_settled():
    # 3.96801 and 3.96793 at the coarsest steps, then away from them, then to 4
    found = observed_order(run_of((1, 4), (-0.75, 5), (2, 6)))
    assert abs(found.orders[0] - found.orders[1]) < 1e-3
    assert found.steps[-1] > 48
    assert abs(found.order - 4) < 0.01


def test_an_order_that_is_no_integer_is_reported_as_it_is():
    assert abs(observed_order(run_of((1, 2.5))).order - 2.5) < 1e-6


def test_differences_do_not_see_a_wrong_limit_and_a_target_does():
    shifted = run_of((1, 3), (1, 0))
    assert abs(observed_order(shifted).order - 3) < 1e-6
    assert abs(observed_order(shifted, target=[mpf(1), mpf(2)]).order) < 0.01


def test_the_window_stops_when_it_is_settled():
    calls = []
    run = run_of((1, 4), (0.1, 5))

    def counted(n):
        calls.append(n)
        return run(n)

    observed_order(counted)
    assert calls == [6, 12, 24, 48, 96]


@pytest.mark.sampled(1)
@pytest.mark.parametrize("build", [isochronous, isochronous_separable, isochronous_threefold])
def test_every_solution_of_an_isochronous_problem_has_period_two_pi(build):
    from glmref.engine.solve import solve

    subject = build()
    for scale in (0.5, 1.0):
        planar = build is not isochronous_separable
        start = [float(x) * (scale if planar else 1) for x in subject.y0]
        copy = type(subject)(
            **{k: getattr(subject, k) for k in ("f", "force", "parameters") if getattr(subject, k)
               is not None and not (k == "f" and subject.force is not None)},
            y0=start,
        )  # fmt: skip
        end = solve(copy, load("gauss-4"), h=2 * math.pi / 200, steps=200, engine="reference").y[-1]
        assert max(abs(end - start)) < 1e-12


def test_a_start_with_digits_takes_no_elimination_more_than_once(monkeypatch):
    engine = stepper(load("ab-3"), isochronous(), digits=30)
    underlying, context = Underlying(engine), engine.arithmetic.context
    monkeypatch.delattr(type(engine.arithmetic), "solve")
    underlying.start(context.mpf(0), engine.problem.y0, context.mpf(1) / 100, order=3)


def test_the_solution_read_by_the_left_eigenvector_is_a_conjugate_one():
    # the same values, another name for the solution: the steps are those of the same method
    engine = stepper(load("ab-3"), isochronous(), digits=30)
    underlying, context = Underlying(engine, conjugate=True), engine.arithmetic.context
    ((_, _, left),) = underlying.readers
    v, y0 = engine.arithmetic.array(engine.method.V), engine.problem.y0
    assert max(abs(x) for x in left.dot(v) - left) < 1e-28
    assert max(abs(x) for x in underlying.solution(underlying.lifted(y0)) - y0) < 1e-28
    h = context.mpf(1) / 100
    start = underlying.start(context.mpf(0), engine.problem.y0, h, order=6)
    assert max(abs(x) for x in underlying.solution(start) - engine.problem.y0) < 1e-28
    rest = underlying.parasitic(h, underlying.run(context.mpf(0), start, h, 1), h, order=6)
    assert max(abs(x) for x in rest.ravel()) < 1e-11  # h^7 and a constant


def test_the_flow_of_the_isochronous_problem_solves_it():
    subject = isochronous()
    d = 1e-6
    for t in (0.0, 1.0, 2.5):
        slope = (subject.solution(t + d) - subject.solution(t - d)) / (2 * d)
        # central differences: d^2 y'''/6 and rounding 1e-16/d
        assert max(abs(slope - subject.f(t, subject.solution(t)))) < 1e-9


@pytest.mark.sampled(3)
@pytest.mark.parametrize(
    ("name", "order"), [("euler", 1), ("rk4", 4), ("gauss-2", 4), ("ab-2", 2), ("bdf-3", 3)]
)
def test_well_known_orders(name, order):
    found = method_order(load(name), isochronous(), expected=order)
    assert found.settled
    assert abs(found.order - order) < 0.05


def test_an_expectation_that_is_wrong_does_not_change_the_result():
    for expected in (2, 3, 5):
        found = method_order(load("rk4"), isochronous(), expected=expected)
        assert abs(found.order - 4) < 0.05


@pytest.mark.slow
def test_the_starting_map_gains_an_order_with_every_pass():
    engine = stepper(load("gsymplectic-n"), problem("pendulum"), digits=40)
    underlying, context = Underlying(engine), engine.arithmetic.context
    y0, h = engine.problem.y0, context.mpf(1) / 20

    def error(order, h):
        best = underlying.start(0, y0, h, order=7)
        return max(abs(x) for x in (underlying.start(0, y0, h, order=order) - best).ravel())

    for order in (1, 2, 3):
        slope = math.log2(float(error(order, h) / error(order, h / 2)))
        assert slope > order + 0.7


def test_the_starting_map_is_invariant_under_a_step():
    engine = stepper(load("ark-4"), isochronous(), digits=40)
    underlying, context = Underlying(engine), engine.arithmetic.context
    h = context.mpf(1) / 1000
    start = underlying.start(0, engine.problem.y0, h, order=6)
    rest = underlying.parasitic(0, underlying.run(0, start, h, 1), h, order=6)
    assert max(abs(x) for x in rest.ravel()) < 1e-18
