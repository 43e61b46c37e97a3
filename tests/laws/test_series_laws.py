"""Laws of series: a group on which the flow acts; order belongs to the conjugacy class."""

from fractions import Fraction as F
from math import factorial

from hypothesis import given
from hypothesis import strategies as st

from glmref.catalogue.lookup import load
from glmref.method import GLM
from glmref.method.component import GENERAL, ROOTED, SEPARABLE
from glmref.theory.order import order_of
from glmref.theory.series import Series, compose, flow, identity, inverse
from glmref.theory.trees import pruned, trees_up_to
from tests.bseries import combine
from tests.build import invertible
from tests.examples import examples

ORDER = 4
fractions = st.fractions(min_value=-2, max_value=2, max_denominator=6)
palettes = st.sampled_from([ROOTED, GENERAL, SEPARABLE])


@st.composite
def scalar_series(draw, palette, order=ORDER):
    level = trees_up_to(order, palette)
    return Series({t: draw(fractions) for t in level}, 1, order, palette)


@st.composite
def three_series(draw):
    palette = draw(st.sampled_from([ROOTED, SEPARABLE]))
    return tuple(draw(scalar_series(palette)) for _ in range(3))


@st.composite
def one_series(draw):
    return draw(scalar_series(draw(palettes), 3))


@given(three_series())
@examples(30)
def test_composition_is_associative(series):
    a, b, c = series
    assert compose(compose(a, b), c) == compose(a, compose(b, c))


@given(one_series())
@examples(30)
def test_every_series_has_one_inverse(a):
    one = identity(a.order, a.palette)
    assert compose(a, inverse(a)) == one == compose(inverse(a), a)
    assert compose(a, one) == a == compose(one, a)


@given(fractions, fractions, palettes)
@examples(30)
def test_flows_form_a_one_parameter_group(s, t, palette):
    assert compose(flow(ORDER, s, palette), flow(ORDER, t, palette)) == flow(ORDER, s + t, palette)


@given(one_series(), fractions)
@examples(30)
def test_a_composition_with_the_flow_counts_the_ways_to_grow_a_tree(a, s):
    after = compose(flow(a.order, s, a.palette), a)
    for t in trees_up_to(a.order, a.palette):
        grown = [(t.order - kept.order, ways, a[kept]) for kept, ways in pruned(t).items()]
        total = sum(F(ways, factorial(j)) * s**j * x for j, ways, x in grown)
        assert after[t] == s**t.order * F(1, t.density) + total


@given(three_series(), fractions)
@examples(20)
def test_composition_is_linear_in_what_is_applied_last(series, factor):
    a, b, c = series
    both = compose(a, combine([(factor, b), (1 - factor, c)]))
    assert both == combine([(factor, compose(a, b)), (1 - factor, compose(a, c))])


GAUSS_2 = {"A": [["1/4", "1/4-sqrt(3)/6"], ["1/4+sqrt(3)/6", "1/4"]], "b": ["1/2", "1/2"]}
HEUN_3 = {"A": [[0, 0, 0], ["1/3", 0, 0], [0, "2/3", 0]], "b": ["1/4", 0, "3/4"]}


def runge_kutta(A, b):
    return GLM(A=A, U=[[1]] * len(A), B=[b], V=[[1]])


def conjugate(method, a, b):
    """Apply the Runge-Kutta step (a, b) backwards, then the method, then (a, b) forwards."""
    m, s = len(b), method.s
    back = [[a[i][j] - b[j] for j in range(m)] for i in range(m)]
    backwards, zero = [-x for x in b], [0] * m
    rows = [[*row, *[0] * s, *zero] for row in back]
    rows += [[*backwards, *row, *zero] for row in method.A]
    rows += [[*backwards, *method.B[0], *row] for row in a]
    return runge_kutta(rows, [*backwards, *method.B[0], *b])


@given(st.lists(fractions, min_size=5, max_size=5), st.sampled_from([(GAUSS_2, 4), (HEUN_3, 3)]))
@examples(12)
def test_conjugation_leaves_the_order_with_a_free_principal_part(x, known):
    tableau, order = known
    a, b = [[F(0), F(0)], [x[0], x[1]]], [x[2], x[3]]
    method = conjugate(runge_kutta(**tableau), a, b)
    result = order_of(method, max_order=6)
    assert (result.order, result.decided) == (order, True)


@given(invertible(2), st.permutations([0, 1, 2]))
@examples(20)
def test_equivalent_methods_have_the_same_order(T, stages):
    result = order_of(load("g4123").transform(T).permute_stages(stages))
    assert (result.order, str(result.failing_tree)) == (4, "[[o][o]]")
