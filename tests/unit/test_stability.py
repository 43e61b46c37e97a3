"""Linear stability decided exactly, and intervals of stability with the numbers of the literature."""

import math
from fractions import Fraction
from itertools import combinations_with_replacement
from time import process_time

import pytest

import glmref
from glmref.errors import BudgetError
from glmref.exact import exact
from glmref.exact.judging import asked
from glmref.method import GLM
from glmref.method.families import composition, runge_kutta, splitting
from glmref.prove.facts import facts_of
from glmref.system.budget import limited
from glmref.theory import polynomials as poly
from glmref.theory import stability_interval
from glmref.theory.stability import (
    divided,
    leading_part,
    oscillator,
    seems_a_stable,
    stability_matrix,
    stability_polynomial,
    vanishes_at_inverse,
    why_not_a_stable,
    without_content,
)
from glmref.theory.stability_interval import Interval, imaginary_interval, real_interval
from tests.shipped import tableau

differences = asked("rules_stability.differences")


def sdirk(gamma):
    return runge_kutta([[gamma, "0"], [f"1-2*{gamma}", gamma]], ["1/2", "1/2"])


def stability_function(m):
    """Return R = N/D of a method that carries one value, without a common factor, D(0) = 1."""
    numerator, denominator = without_content(m, stability_polynomial(m))
    unit = 1 / denominator[0]
    return poly.scale(-unit, numerator), poly.scale(unit, denominator)


def test_stability_function_of_gauss_2_is_the_pade_approximation():
    N, D = stability_function(runge_kutta(*tableau("gauss-2")))
    assert N == (1, Fraction(1, 2), Fraction(1, 12))
    assert D == (1, Fraction(-1, 2), Fraction(1, 12))


@pytest.mark.parametrize("m", [
    "gsymplectic-n", "s4-symmetric", "g4123", "ab-6", "bdf-5", "gauss-3", "gsymplectic-n-pair",
    composition(sdirk("(3+sqrt(3))/6"), ["1/3", "2/5"]),
])  # fmt: skip
def test_stability_polynomial_is_the_determinant_at_any_point(m):
    m = glmref.load(m) if isinstance(m, str) else m
    m = oscillator(m) if m.parts == 2 else m
    z = Fraction(3, 7)
    at_z = poly.trim([poly.evaluate(p, z) for p in stability_polynomial(m)])
    characteristic = poly.characteristic(stability_matrix(m, z))
    assert poly.scale(1 / at_z[-1], at_z) == characteristic


def test_behaviour_at_infinity_of_the_midpoint_rule():
    leading, unbounded = leading_part(stability_polynomial(runge_kutta(*tableau("gauss-1"))))
    assert poly.monic(leading) == P(1, 1) and unbounded == 0  # M tends to -1


def test_oscillator_matches_the_step_by_hand():
    m = oscillator(splitting(["1"], ["1"], first="q"))  # symplectic Euler
    y = exact(Fraction(1, 3))
    M = stability_matrix(m, y)
    # q+ = q + y p, p+ = p - y q+
    assert M == ((1, y), (-y, 1 - y * y))


def shuffled(m, order):
    """The same method with its stages in another order."""
    A = [[m.A[i][j] for j in order] for i in order]
    return GLM(
        A=A, U=[m.U[i] for i in order], B=[[row[j] for j in order] for row in m.B], V=m.V
    )  # fmt: skip


def test_the_polynomial_is_the_same_whatever_the_order_of_the_stages():
    halves = [f"{k}/28" for k in range(1, 8)], [f"{k}/21" for k in range(1, 7)]  # both sum to 1
    m = oscillator(splitting(*halves))
    assert m.s == 13
    other = shuffled(m, [*range(1, 13, 2), *range(12, -1, -2)])
    assert stability_polynomial(other) == stability_polynomial(m)
    # near miss: one stage that needs itself, or two that need each other
    assert other.is_explicit
    itself = [[*row] for row in other.A]
    itself[3][3] = exact(1)
    each = [[*row] for row in other.A]
    i, j = next((i, j) for i in range(13) for j in range(13) if not other.A[i][j].is_zero())
    each[j][i] = exact(1)
    assert not other.bare(A=itself).is_explicit
    assert not other.bare(A=each).is_explicit


@pytest.mark.slow
def test_published_decimals_keep_their_digits_through_49_stages():
    m = oscillator(glmref.load("pair-8-24"))
    assert m.s == 49
    radii = [x.ball().radius() for p in stability_polynomial(m) for x in p]
    # 75 digits, amplified by at most 1e15 in products of matrices with entries below 100
    assert max(radii) < 1e-60


def P(*coefficients):
    return poly.trim([exact(x) for x in coefficients])


def test_the_reduction_of_schur_and_cohn_decides_like_the_roots():
    values = [exact(0), exact(1), exact(-1), exact(Fraction(1, 2)), exact(3)]
    for roots in [*combinations_with_replacement(values, 3), (exact(2), exact(1) / 2, exact(1))]:
        q = tuple((x,) for x in poly.from_roots(roots))
        inside = all(d is not None and (not d or d[0].sign() >= 0) for d in differences(q))
        assert inside is all((x * x - 1).sign() <= 0 for x in roots)


def test_the_differences_of_the_reduction_are_polynomials_along_the_axis():
    # w^2 + z w - 4 z^2 at z = i y: 1 - 16 y^4, then what is left of (1 - 4 y^2)^2
    first, second = differences((P(0, 0, -4), P(0, 1), P(1)))
    assert first == P(1, 0, 0, 0, -16)
    for y in (Fraction(1, 3), Fraction(1), Fraction(2, 5)):
        assert poly.evaluate(second, y) == (1 - 16 * y**4) ** 2 - (y * (1 + 4 * y**2)) ** 2
    assert differences((P(2), P(1))) == (P(-3),) and differences((P(-1), P(1))) == ((),)
    assert differences((P(1), P(1, 2), P(-1)))[-1] is None


def test_what_divides_all_coefficients_is_divided_out():
    a, b, factor = P(1, 2), P(-3, 0, 1), P(1, 1)
    q = (poly.mul(a, factor), poly.mul(b, factor))
    assert divided(q, factor) == (a, b)
    assert divided(q, P(2, 1)) == q and divided(q, P(7)) == q
    assert vanishes_at_inverse(P(-1, 2), exact(2)) and not vanishes_at_inverse(P(-1, 2), exact(1))
    leading, unbounded = leading_part((P(1, 0, 5), P(3), P(0, 0, 2), P(1, 1)))
    assert leading == P(5, 0, 2) and unbounded == 1


def test_a_pole_that_cancels_leaves_the_stability_function_of_what_is_left():
    lower = glmref.from_rk([["1/2", 0], [0, "1/3"]], [1, 0])
    full = glmref.from_rk([["1/2", 0, 0], [0, "1/3", "1/7"], [0, "1/5", "1/3"]], [1, 0, 0])
    for m in (lower, full):
        numerator, denominator = stability_function(m)
        assert (numerator, denominator) == (P(1, Fraction(1, 2)), P(1, Fraction(-1, 2)))


def test_the_guess_is_that_of_the_judge_for_shipped_methods():
    for name in ("gauss-3", "radau-iia-2", "rk4", "bdf-2", "bdf-3", "gsymplectic-n"):
        method = glmref.load(name)
        assert seems_a_stable(method) == facts_of(method).truth("a-stable"), name


def test_a_double_eigenvalue_on_the_circle_is_not_said_to_be_outside():
    """M(iy) has the double eigenvalue (2 + iy) / (2 - iy), which doubles see beyond 1."""
    for r in (2, 3):
        U = [[Fraction(int(j in (i, i + 1))) for j in range(r)] for i in range(r)]
        unit = [[Fraction(int(i == j)) for j in range(r)] for i in range(r)]
        method = GLM(A=[[x / 2 for x in row] for row in unit], U=U, B=unit, V=unit)
        assert why_not_a_stable(method, {"y": "1"}) == "M(z) is not power-bounded at z = 1 i"


def test_a_guess_about_large_numbers_ends():
    """The second entry and the square of the first are beyond doubles."""
    for large in (17 * 10**307, 10**400):
        assert not seems_a_stable(GLM(A=[[-large]], U=[[large]], B=[[large]], V=[[1]]))


# --- intervals ------------------------------------------------------------------------------------


INF = math.inf


def end_of(q):
    """Return the interval of roots w of a polynomial in w and x; P(w, z) has x = -z."""
    P = tuple(tuple(-c if k % 2 else c for k, c in enumerate(p)) for p in q)
    return stability_interval._end(P, real=True)


def test_the_interval_ends_at_the_least_of_all_ends() -> None:
    # (w - 2x)(w - 1/2): the product of the roots leaves the disc at x = 1, the first root at 1/2
    half = exact(Fraction(1, 2))
    q = ((exact(0), exact(1)), (-half, exact(-2)), (exact(1),))
    assert end_of(q) == Interval(0.5, "an eigenvalue leaves the closed unit disc")


def test_an_eigenvalue_that_comes_back_at_once_has_left() -> None:
    # w = 1 - x (1 - x) (1 + 1e-30 - x) (3 - x) / 10 is above 1 between 1 and 1 + 1e-30
    w = (exact(0), exact(Fraction(-1, 10)))
    for root in (1, 1 + Fraction(1, 10**30), 3):
        w = poly.mul(w, (exact(root), exact(-1)))
    q = (poly.sub((), poly.add(w, (exact(1),))), (exact(1),))
    assert end_of(q).end == 1


def test_irrational_coefficients_are_reduced_up_to_the_largest_degree(monkeypatch) -> None:
    gamma = "(3+sqrt(3))/6"
    sdirk = glmref.from_rk([[gamma, 0], ["-sqrt(3)/3", gamma]], ["1/2", "1/2"])
    monkeypatch.setattr(stability_interval, "MOST", 2)
    assert imaginary_interval(sdirk).end == INF
    monkeypatch.setattr(stability_interval, "MOST", 1)
    assert imaginary_interval(sdirk) == Interval(None, "too large for roots among the coefficients")


def test_methods_of_many_values_have_their_interval_in_time() -> None:
    method = glmref.load("ab-6")
    assert isinstance(method, glmref.GLM)
    with limited(20):  # 0.3 s on a free machine; without the division of what is shared, minutes
        assert real_interval(method).end == pytest.approx(5 / 57, rel=1e-14)


def test_an_interval_that_takes_long_ends_with_its_budget() -> None:
    method = glmref.load("feagin-10-printed")
    assert isinstance(method, glmref.GLM)
    begun = process_time()
    with pytest.raises(BudgetError), limited(0.3):
        real_interval(method)
    assert process_time() - begun < 3
