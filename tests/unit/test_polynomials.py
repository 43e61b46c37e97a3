"""Polynomials: decisions by signs, each with a near miss."""

from fractions import Fraction

import pytest

from glmref.exact import Exact, exact, root_of_unity
from glmref.judge.polynomials import nowhere_negative
from glmref.theory import polynomials as poly
from glmref.theory.root_location import (
    first_root,
    in_closed_disc,
    is_schur,
    real_roots,
    unimodular_roots,
)

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


def test_characteristic_polynomial_of_a_companion_matrix():
    companion = ((exact(0), exact(1)), (exact(-6), exact(5)))
    assert poly.characteristic_polynomial(companion) == (6, -5, 1)
    zero = poly.evaluate_matrix(poly.characteristic_polynomial(companion), companion)
    assert all(x == 0 for row in zero for x in row)


def test_faddeev_leverrier_gives_the_adjugate():
    m = ((exact(1), exact(2)), (exact(3), SQRT2))
    p, terms = poly.faddeev_leverrier(m)
    w = 7  # adj(w I - M) (w I - M) = p(w) I
    adjugate = tuple(tuple(terms[0][i][j] + w * terms[1][i][j] for j in range(2)) for i in range(2))
    shifted = tuple(tuple(w * int(i == j) - m[i][j] for j in range(2)) for i in range(2))
    product = sum((adjugate[0][k] * shifted[k][0] for k in range(2)), Exact(0))
    assert product == poly.evaluate(p, w)


def test_moebius_transformation():
    p = P(2, 3, 1)  # (x + 1)(x + 2) at (x + 1)/(x - 1), times (x - 1)^2
    assert poly.compose_moebius(p, 1, 1, 1, -1) == poly.mul(P(0, 2), P(-1, 3))


def test_sturm_counts_real_roots():
    p = poly.from_roots([exact(1), exact(1), exact(3), SQRT2])
    assert real_roots(p) == 3
    assert real_roots(P(1, 0, 1)) == 0


@pytest.mark.parametrize(
    ("p", "expected"),
    [
        (P(1, -2, 1), True),  # a double root does no harm
        (P(Fraction(99, 100), -2, 1), False),
        (P(0, 0, 1, 0, -2, 0, 1), True),  # y^2 (y^2 - 1)^2
        (P(0, 0, 1, 0, -3, 0, 1), False),
        (P(0, 1), False),
        (P(1, 0, -1), False),
    ],
)
def test_nonnegative_polynomials(p, expected):
    assert nowhere_negative([x.as_fraction() for x in p]) is expected


@pytest.mark.parametrize(
    ("roots", "schur", "closed", "on_circle"),
    [
        ([exact(Fraction(1, 2)), root_of_unity(1, 3) / 2], True, True, 0),
        ([exact(1), exact(Fraction(1, 2))], False, True, 1),
        ([exact(1), exact(1), root_of_unity(1, 8)], False, True, 2),
        ([exact(2), exact(Fraction(1, 2))], False, False, 0),  # mirrored in the circle
        ([exact(0), exact(0)], True, True, 0),
        ([exact(Fraction(1001, 1000)), exact(0)], False, False, 0),
        ([root_of_unity(k, 5) for k in range(5)], False, True, 5),
    ],
)
def test_roots_and_the_unit_circle(roots, schur, closed, on_circle):
    p = poly.from_roots(roots)
    assert is_schur(p) is schur
    assert in_closed_disc(p) is closed
    assert unimodular_roots(p) == on_circle


def test_approximate_roots_are_close():
    p = poly.from_roots([exact(1), exact(-2), SQRT2])
    found = sorted(x.real for x in poly.approximate_roots(p))
    assert found == pytest.approx([-2, 1, 2**0.5])


def test_a_first_root_that_is_a_short_fraction_is_found_itself():
    third, half = exact(Fraction(1, 3)), exact(Fraction(1, 2))
    p = poly.mul((-third, exact(1)), (-half, exact(1)))
    assert first_root(p, Fraction(0), Fraction(1), Fraction(1, 10**6)) == Fraction(1, 3)
    assert first_root(p, Fraction(1, 2), Fraction(1), Fraction(1, 10**6)) is None


def test_answers_about_roots_are_true_or_false():
    x2 = P(0, 0, 1)
    cases = [
        (lambda p: nowhere_negative([x.as_fraction() for x in p]),
         [P(3), x2, P(1, 0, 1), P(4, -4, 1), P(0, 0, 4, -4, 1), P(1, 0, -2, 0, 1)],
         [P(-1), P(0, 1), P(0, 0, -1), P(-1, 0, 1), P(0, 0, 0, 1, 1), P(0, 1, 1), P(2, 0, -3, 0, 1)]),
        (is_schur, [P(5), P(0, 1), P(1, 2), P(0, 1, 2), P(1, 0, 0, 2)],
         [P(1, 1), P(2, 1), P(-1, 0, 1), P(0, 2, 1), P(-1, 1, 2)]),
        (in_closed_disc, [P(5), P(1, 1), P(0, 1, 1), P(1, 0, 2, 0, 1), P(-1, 1, 2)],
         [P(2, 1), P(1, 3, 1), P(0, 1, 3, 1), P(-1, 2)[::-1], P(-1, 0, 1, 1, 1)]),
        (poly.is_self_reciprocal, [P(1, 3, 1), P(-1, 3, -3, 1), P(2)], [P(0, 1), P(1, 2), P(1, 2, 3, 1)]),
    ]  # fmt: skip
    for question, holds, fails in cases:
        assert [question(p) for p in holds] == [True] * len(holds), question
        assert [question(p) for p in fails] == [False] * len(fails), question


def test_roots_are_counted_where_they_are():
    p = poly.from_roots([exact(x) for x in (-2, 0, 1, 1, 3)])
    assert real_roots(p) == 4
    assert [real_roots(q) for q in (P(7), P(1, 0, 1), P(-2, 0, 1))] == [0, 0, 2]
    circle = poly.mul(poly.from_roots([exact(x) for x in (-1, -1, 1, 0)]), P(1, 0, 1))
    assert unimodular_roots(circle) == 4
    assert [unimodular_roots(q) for q in (P(3), P(0, 1), P(1, 1), P(1, 3, 1), P(1, 2))] == [
        0, 0, 1, 0, 0,
    ]  # fmt: skip


def test_a_first_root_is_enclosed_from_above():
    width = Fraction(1, 10**6)
    p = poly.mul(P(-2, 0, 1), P(-5, 1))  # sqrt(2), -sqrt(2), 5
    found = first_root(p, Fraction(0), Fraction(10), width)
    assert 0 <= float(found) - float(SQRT2) <= float(width) * 1.5
    assert first_root(p, Fraction(2), Fraction(10), width) == 5
    assert first_root(p, Fraction(0), Fraction(1), width) is None
    assert first_root(P(4), Fraction(0), Fraction(1), width) is None


def test_newton_s_form_and_the_derivative():
    points = [3, -1, 0, 7]
    for p in (P(1, -2, 0, SQRT2), P(1, -2, 0, 5)):
        assert poly.interpolate(points, [poly.evaluate(p, x) for x in points]) == p
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
