"""Series: flow, composition, inverse, elementary weights."""

import random
from fractions import Fraction as F

import pytest

from glmref import load
from glmref.errors import UsageError
from glmref.exact import Ball, exact
from glmref.method.component import GENERAL, ROOTED
from glmref.theory.coefficients import combination, is_zero, plus, times
from glmref.theory.series import Series, compose, flow, modified_equation, substitute
from glmref.theory.trees import Tree, single, trees, trees_up_to
from tests.bseries import derivative, elementary_weights
from tests.build import refused

RK4 = ([[0, 0, 0, 0], [F(1, 2), 0, 0, 0], [0, F(1, 2), 0, 0], [0, 0, 1, 0]],
       [F(1, 6), F(1, 3), F(1, 3), F(1, 6)])  # fmt: skip


def test_rk4_agrees_with_the_flow_through_order_4_and_not_5():
    weights, exact_flow = elementary_weights(*RK4, 5), flow(5)
    differing = [t for t in weights if weights[t] != exact_flow[t]]
    assert {t.order for t in differing} == {5}
    assert str(differing[0]) == "[oooo]"


def test_two_steps_as_one_tableau_are_the_composition():
    A, b = RK4
    twice = [[*row, 0, 0, 0, 0] for row in A] + [[*b, *row] for row in A]
    assert elementary_weights(twice, [*b, *b], 6) == compose(
        elementary_weights(A, b, 6), elementary_weights(A, b, 6)
    )


def test_composition_is_the_sum_over_all_cuts():
    a = Series({t: F(n + 2, 3) for n, t in enumerate(trees_up_to(4))}, 1, 4)
    b = Series({t: F(5, n + 7) for n, t in enumerate(trees_up_to(4))}, 11, 4)
    o, path, bush, t = map(Tree, ("o", "[o]", "[oo]", "[o[o]]"))
    kept = b[t] + a[o] * (b[Tree("[[o]]")] + b[bush]) + (a[o] ** 2 + a[path]) * b[path]
    assert compose(a, b)[t] == 11 * a[t] + kept + a[o] * a[path] * b[o]


@pytest.mark.parametrize("palette", [ROOTED, GENERAL])
def test_derivative_satisfies_the_differential_equation_of_the_flow(palette):
    # d/dt of the flow is f of the flow: |t| / gamma(t) = product over the children
    series = derivative(flow(5, 1, palette))
    assert all(series[t] == F(t.order, t.density) for t in series)
    assert palette is GENERAL or series.empty() == 0


def test_vector_valued_series_compose_from_the_left():
    start = elementary_weights(RK4[0], [RK4[1], [1, 0, 0, -1]], 5, u=(1, 0))
    after = compose(flow(5), start)
    assert after.empty() == (1, 0)
    assert after[single()] == (2, 0)


def test_coefficients_of_any_kind_are_added_and_multiplied():
    wide, x = Ball.decimal("0.0", 1), exact(2).sqrt()
    kinds = [0, 1, F(1, 2), F(0), x, x - x, wide]
    for a in kinds:
        for b in kinds:
            for found, truth in ((plus(a, b), exact(0) + a + b), (times(a, b), exact(1) * a * b)):
                assert is_zero(found - truth) is not False
            assert is_zero(combination([(a, b), (b, a)]) - (a * b + b * a)) is not False
    assert plus((1, 0), (0, x)) == (1, x) and times(2, (1, x)) == (2, 2 * x)
    assert times(1, x) is x and times(x, 1) is x and plus(0, x) is x and plus(x, 0) is x
    assert combination([]) == 0 and combination([(x, 0)]) == 0
    for value, zero in (
        (0, True), (1, False), (F(0), True), (x - x, True), (wide, None), ((), True),
        ((0, 0), True), ((0, wide), None), ((wide, 1), False), ((0, 1), False),
    ):  # fmt: skip
        assert is_zero(value) is zero


@pytest.mark.parametrize("palette", [ROOTED, GENERAL])
def test_a_field_that_is_substituted_is_found_again(palette):
    drawn = random.Random(5)
    level = trees_up_to(4, palette)
    value = {t: F(drawn.randint(-9, 9), 7) for t in level}
    a = Series(value | {t: F(1) for t in trees(1, palette)}, 1, 4, palette)
    found = modified_equation(a)
    assert substitute(found, flow(4, 1, palette)) == a
    back = modified_equation(flow(4, 1, palette), a)
    assert substitute(back, a) == flow(4, 1, palette)
    # substituting twice is substituting what was substituted: the law of Chartier, Hairer, Vilmart
    assert substitute(substitute(found, back), a) == substitute(found, substitute(back, a))


def test_series_of_methods_are_their_weights_and_several_values_are_refused():
    assert Series.of(load("rk4"), 5) == elementary_weights(*RK4, 5)
    verlet = Series.of(load("stormer-verlet"), 3)
    assert verlet.empty("f") == 1 and verlet[Tree("f[k]")] == F(1, 2)
    refused(UsageError, "one value", Series.of, load("ab-2"), 2)
    refused(UsageError, "below each", modified_equation, verlet, verlet)
    refused(UsageError, "consistent", modified_equation, flow(3), flow(3, 2))
