"""Polynomials: decisions by signs, each with a near miss."""

from fractions import Fraction

import pytest

from glmref.exact import exact
from glmref.exact.judging import asked
from glmref.judge.arithmetic import Interval
from glmref.judge.numbers import is_nil
from glmref.judge.polynomials import is_schur, multiply, nowhere_negative
from glmref.theory import polynomials as poly
from glmref.theory.stability_interval import FARTHEST, WIDTH, first_root

real_roots = asked("polynomials.real_roots")
SQRT2 = exact(2).sqrt()
F12 = Fraction(1, 2)


def P(*coefficients):
    return poly.trim([exact(x) if isinstance(x, int | Fraction) else x for x in coefficients])


def test_division_and_gcd():
    p = poly.from_roots([exact(1), exact(2), SQRT2])
    q = poly.from_roots([SQRT2, exact(5)])
    assert poly.gcd(p, q) == (-SQRT2, 1)
    quotient, rest = poly.divide(p, q)
    assert poly.add(poly.mul(quotient, q), rest) == p


def test_an_interval_around_0_is_a_coefficient_like_others_and_an_exact_0_stays_one():
    near, one, zero = Interval.ends(Fraction(-1, 9), Fraction(1, 9)), Fraction(1), Fraction(0)
    assert is_schur([near, one])
    assert is_nil(multiply([zero, one], [near, one])[0])
    assert is_nil(multiply([near, one], [zero, one])[0])


def test_approximate_roots_are_close():
    p = poly.from_roots([exact(1), exact(-2), SQRT2])
    found = sorted(x.real for x in poly.approximate_roots(p))
    assert found == pytest.approx([-2, 1, 2**0.5])
    assert sorted(x.real for x in poly.approximate_roots(P(0, 0, 4, -4, 1))) == [0, 0, 2, 2]
    assert poly.approximate_roots(P(3)) == []


def test_answers_about_roots_are_true_or_false():
    x2 = P(0, 0, 1)
    cases = [
        (lambda p: nowhere_negative([x.as_fraction() for x in p]),
         [P(3), x2, P(1, 0, 1), P(4, -4, 1), P(0, 0, 4, -4, 1), P(1, 0, -2, 0, 1),
          P(0, 0, 1, 0, -2, 0, 1)],
         [P(-1), P(0, 1), P(Fraction(99, 100), -2, 1), P(0, 0, -1), P(-1, 0, 1), P(0, 0, 0, 1, 1), P(0, 1, 1), P(2, 0, -3, 0, 1)]),
        (poly.is_schur, [P(5), P(0, 1), P(1, 2), P(0, 1, 2), P(1, 0, 0, 2)],
         [P(1, 1), P(2, 1), P(-1, 0, 1), P(0, 2, 1), P(-1, 1, 2)]),
        (poly.in_disc, [P(5), P(1, 1), P(0, 1, 1), P(1, 0, 2, 0, 1), P(-1, 1, 2)],
         [P(2, 1), P(1, 3, 1), P(0, 1, 3, 1), P(-1, 2)[::-1], P(-1, 0, 1, 1, 1)]),
    ]  # fmt: skip
    for question, holds, fails in cases:
        assert [question(p) for p in holds] == [True] * len(holds), question
        assert [question(p) for p in fails] == [False] * len(fails), question


def test_a_first_root_is_enclosed_from_above():
    found = first_root(poly.mul(P(-2, 0, 1), P(-5, 1)))  # sqrt(2), -sqrt(2), 5
    assert 0 <= (found - SQRT2).sign() and (found - 2 * WIDTH - SQRT2).sign() < 0
    assert first_root(P(-5, 1)) == 5 and first_root(P(2, 3, 1)) is None
    assert first_root(P(FARTHEST, 1)) is None and first_root(P(-2 * FARTHEST, 1)) is None


def test_the_derivative_and_what_it_tells_of_roots():
    p = P(1, -2, 0, 5)
    assert poly.derivative(p) == P(-2, 0, 15)
    assert poly.squarefree(poly.mul(p, p)) == poly.monic(p) and poly.squarefree(P(2, 4)) == P(
        F12, 1
    )
    assert poly.share_only_one(P(-1, 0, 1), P(-1, 1)) and not poly.share_only_one(
        P(-1, 0, 1), P(1, 1)
    )
    assert not poly.share_only_one(P(-1, 0, 1), P(-1, 0, 1))
    assert not poly.share_only_one(P(1, -2, 1), P(-1, 1))


def test_a_product_with_nothing_is_nothing():
    for p in (P(), P(3), P(1, 2, 3)):
        assert poly.mul(p, ()) == poly.mul((), p) == ()
        assert poly.mul(p, P(1)) == p


@pytest.mark.parametrize("zeros", [1, 3])
@pytest.mark.parametrize("roots", [[], [1], [1, 2], [0, 1, 1], [2, 2, 2, SQRT2]])
@pytest.mark.parametrize("others", [[], [1], [2, 5], [0, 1, SQRT2]])
def test_zeros_at_the_end_change_no_common_divisor(roots, others, zeros):
    p, q = (poly.from_roots([x * exact(1) for x in of]) for of in (roots, others))
    padded = [(*x, *(exact(0),) * zeros) for x in (p, q)]
    common = {*map(str, roots)} & {*map(str, others)}
    assert len(poly.gcd(p, q)) == 1 + len(common)
    assert poly.gcd(*padded) == poly.gcd(p, q) == poly.gcd(q, p)
    assert poly.squarefree(padded[0]) == poly.squarefree(p)
    assert len(poly.squarefree(p)) == 1 + len({*map(str, roots)})
