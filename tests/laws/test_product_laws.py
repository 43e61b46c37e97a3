"""Sums of products and gradients: as narrow as the loops, and never beside the truth.

Every test puts balls around rationals, computes the same in exact arithmetic, and asks that the
true number lies in the enclosure and that a number slightly beside it does not.
"""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from glmref.errors import DataError
from glmref.exact import Ball, Exact, ball, exact, sum_of_products
from glmref.exact.expression import parse
from glmref.exact.judging import Gradient, as_number, as_scalar, consulted, coordinates
from glmref.theory.coefficients import combination
from tests.build import refused
from tests.examples import examples

LAWS = examples(60)
fractions = st.fractions(min_value=-4, max_value=4, max_denominator=12)
RADIUS = Fraction(1, 10**40)
KINDS = ("whole", "rational", "surd", "ball", "narrow")


def enclosed(x: Fraction) -> Ball:
    """A ball of radius 1e-40 around a rational, its midpoint 1e-41 beside it."""
    return Ball.around(ball(x + RADIUS / 10), RADIUS)


@st.composite
def numbers(draw: st.DrawFn) -> tuple[Exact, Exact | Ball]:
    """A true number, and what stands for it."""
    kind = draw(st.sampled_from(KINDS))
    x = Fraction(draw(st.integers(0, 1))) if kind == "whole" else draw(fractions)
    if kind == "surd":
        value = exact(x) + exact(2).sqrt()
        return value, value
    if kind in ("whole", "rational"):
        return exact(x), exact(x)
    return exact(x), enclosed(x) if kind == "ball" else ball(x)


terms = st.lists(st.tuples(numbers(), numbers()), max_size=8)


def looped(pairs: Sequence[tuple[Any, Any]]) -> Any:
    """The sum, operator by operator."""
    total: Any = Exact(0)
    for x, y in pairs:
        total = total + x * y
    return total


@LAWS
@given(terms)
def test_a_sum_of_products_contains_the_true_one_and_is_as_narrow_as_the_loop(drawn):
    pairs = [(x, y) for (_, x), (_, y) in drawn]
    truth = looped([(x, y) for (x, _), (y, _) in drawn])
    found, loop = sum_of_products(pairs), looped(pairs)
    assert isinstance(found, Ball) == any(isinstance(z, Ball) for pair in pairs for z in pair)
    if isinstance(found, Exact):
        assert found == truth
        assert found != truth + Fraction(1, 10**200)
        return
    assert found.overlaps(truth)  # the true number may be irrational, and is a narrow ball here
    # the radii of both are sums of the same products; 1e-150 covers the roundings to 512 bits
    assert found.radius() <= loop.radius() * 1.001 + 1e-150
    assert not found.overlaps(truth + Fraction(3 * found.radius()) + Fraction(1, 10**150))


@LAWS
@given(terms)
def test_a_combination_is_the_loop(drawn):
    # Certain zeros and ones stand as ints in vectors of the order conditions.
    row = [x for (_, x), _ in drawn]
    vector: list[Any] = [
        int(float(y)) if isinstance(z, Exact) and (y == 0 or y == 1) else z for _, (y, z) in drawn
    ]
    truth = looped([(x, y) for (x, _), (y, _) in drawn])
    found = combination(list(zip(row, vector, strict=True)))
    number = ball(found)
    assert number.overlaps(truth)
    assert not number.overlaps(truth + Fraction(1, 10**30))  # eight terms of width below 1e-38


@LAWS
@given(
    st.lists(st.tuples(fractions, fractions, fractions, fractions), min_size=1, max_size=6),
    fractions,
    fractions,
)
def test_gradients_of_a_sum_of_products_contain_the_true_ones(coefficients, x, y):
    # f = sum (a X + b Y) (c X + d Y), df/dX = sum a (c x + d y) + c (a x + b y)
    with consulted():
        X, Y = coordinates([as_number(enclosed(x)), as_number(enclosed(y))])
        rows = [[as_number(exact(x)) for x in row] for row in coefficients]
        found = Gradient.dot([(X * a + Y * b, X * c + Y * d) for a, b, c, d in rows])
    by_x = sum(a * (c * x + d * y) + c * (a * x + b * y) for a, b, c, d in coefficients)
    by_y = sum(b * (c * x + d * y) + d * (a * x + b * y) for a, b, c, d in coefficients)
    value = sum((a * x + b * y) * (c * x + d * y) for a, b, c, d in coefficients)
    # six terms, 16 products each below 4^3 times the radius: less than 1e-35 wide
    enclosures = [as_scalar(x) for x in (found.value, found.by[0], found.by[1])]
    for enclosure, truth in zip(enclosures, (value, by_x, by_y), strict=True):
        assert enclosure.contains(truth)
        assert not enclosure.contains(truth + Fraction(1, 10**35))


def test_a_zero_that_is_certain_is_told_from_one_that_is_possible() -> None:
    hidden = exact(2).sqrt() * exact(3).sqrt() - exact(6).sqrt()
    for zero in (ball(0), exact(0), hidden):
        assert zero.vanishes()
        assert zero.is_zero() is True
    for number in (enclosed(Fraction(0)), exact(Fraction(1, 10**99)), ball(Fraction(1, 10**99))):
        assert not number.vanishes()
        assert number.is_zero() is not True


@LAWS
@given(st.integers(-(10**9), 10**9), st.integers(0, 10**9))
def test_the_short_way_for_rationals_reads_what_the_grammar_reads(n: int, d: int) -> None:
    assert parse(str(n)) == n
    if d == 0:
        refused(DataError, "division by zero", parse, f"{n}/0")
        return
    assert parse(f"{n}/{d}") == parse(f"({n})/({d})") == Fraction(n, d)
    assert parse(f"{n}/{d}") != Fraction(n + 1, d)
