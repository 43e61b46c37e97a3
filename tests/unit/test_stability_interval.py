"""Stability intervals: numbers of the literature, and what floating point sees."""

from __future__ import annotations

import math
from fractions import Fraction
from time import process_time

import pytest

import glmref
from glmref.errors import BudgetError
from glmref.exact import exact
from glmref.system.budget import limited
from glmref.theory import polynomials as poly
from glmref.theory import stability_interval
from glmref.theory.stability_interval import Interval, imaginary_interval, real_interval

INF = math.inf


def end_of(q):
    """Return the interval of roots w of a polynomial in w and x; P(w, z) has x = -z."""
    P = tuple(tuple(-c if k % 2 else c for k, c in enumerate(p)) for p in q)
    return stability_interval._end(P, real=True)


@pytest.mark.parametrize(
    ("name", "real", "imaginary"),
    [
        # Hairer and Wanner (1996), section IV.2; Lambert (1991), sections 3.8 and 5.12
        ("heun-2", 2, 0),
        ("kutta-3", 2.5127453266183286, math.sqrt(3)),
        ("rk4", 2.785293563405282, math.sqrt(8)),
        ("ab-2", 1, 0),
        ("ab-3", 6 / 11, 0.7236272269866327),
        ("ab-4", 0.3, 0.429987079909256),
        ("am-2", 6, 0),
        ("am-3", 3, 0),
        ("leapfrog", 0, 1),
        ("bdf-2", INF, INF),
        ("bdf-3", INF, 0),
        ("gauss-2", INF, INF),
        ("gsymplectic-n", 0, 2.0604321400961436),
    ],
)
def test_the_intervals_are_those_of_the_literature(name, real, imaginary):
    method = glmref.load(name)
    assert isinstance(method, glmref.GLM)
    assert real_interval(method).end == pytest.approx(real, rel=1e-14)
    assert imaginary_interval(method).end == pytest.approx(imaginary, rel=1e-14)


def test_a_rational_end_is_itself() -> None:
    method = glmref.load("leapfrog")
    assert isinstance(method, glmref.GLM)
    assert imaginary_interval(method).end == 1.0
    assert real_interval(glmref.from_rk([[0]], [1])).end == 2.0


def test_an_eigenvalue_of_v_outside_leaves_nothing() -> None:
    method = glmref.GLM(A=[[0]], U=[[1, 0]], B=[[1], [0]], V=[[1, 0], [0, 2]])
    assert real_interval(method).end == imaginary_interval(method).end == 0


def test_published_digits_are_left_open() -> None:
    method = glmref.load("gauss-2-seven-digits")
    assert isinstance(method, glmref.GLM)
    assert real_interval(method).end is None


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
