"""Periodicity intervals, enclosed."""

from fractions import Fraction

import pytest

import glmref
from glmref.exact import Ball, ball, exact
from glmref.method.families import gauss, linear_multistep, radau_iia, runge_kutta, splitting
from glmref.theory.periodicity import periodicity


def test_leapfrog_is_periodic_up_to_1():
    found = periodicity(linear_multistep(["-1", "0", "1"], ["0", "2", "0"]))
    assert found.end.contains(1) and found.end.radius() < 1e-9
    assert found.proven < 1 and "leave the circle" in found.witness


def test_milne_simpson_is_periodic_up_to_the_square_root_of_3():
    # w^2 (1 - z/3) - (4 z/3) w - (1 + z/3): the discriminant vanishes at y^2 = 3
    found = periodicity(linear_multistep(["-1", "0", "1"], ["1/3", "4/3", "1/3"]))
    assert found.end.contains(exact(3).sqrt())


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("name", "expected"),
    # six digits of an independent search in double precision
    [("g6245", 1.82905), ("g6245-w3", 1.91426), ("c2-3-10-w3", 1.83087)],
)
def test_order_6_methods_are_periodic_as_far_as_measured(name, expected):
    found = periodicity(glmref.load(name))
    assert found.value == pytest.approx(expected, abs=6e-6)  # six digits are given
    assert found.end.radius() < 1e-9 and found.start == 0


def test_s5t_leaves_the_circle_before_the_end_that_a_coarse_search_sees():
    # two eigenvalues of opposite sign meet at 2.0760 and are back on the circle at 2.0790
    found = periodicity(glmref.load("s5t-w3"), conserving=True)
    assert found.value == pytest.approx(2.07596, abs=6e-6)


def test_published_decimals_are_open_unless_conservation_is_granted():
    found = periodicity(glmref.load("s3-w3"))
    assert found.end is None and not found.infinite and "published decimals" in found.witness


@pytest.mark.parametrize("s", [1, 2, 3])
def test_gauss_methods_are_periodic_on_the_whole_axis(s):
    found = periodicity(runge_kutta(*gauss(s)))
    assert found.infinite and found.value == float("inf")


def test_p_is_periodic_on_the_whole_axis_and_n_is_not():
    assert periodicity(glmref.load("gsymplectic-p")).infinite
    found = periodicity(glmref.load("gsymplectic-n"))
    assert not found.infinite and 2.06 < found.value < 2.061


@pytest.mark.parametrize("m", [runge_kutta(*radau_iia(2)), runge_kutta([["0"]], ["1"])])
def test_dissipative_and_growing_methods_have_no_interval(m):
    found = periodicity(m)
    assert found.end.is_zero() is True and found.value == 0


def test_verlet_is_periodic_up_to_2():
    found = periodicity(splitting(["1/2", "1/2"], ["1"]))
    assert found.end.contains(2)
    assert found.start == Fraction(1, 64)  # q and p share the eigenvalue 1 at y = 0


def test_the_end_is_a_root_of_the_discriminant():
    # N: V = diag(1, -1); P(w, iy) = a w^2 + b w + c, the two meet where b^2 = 4 a c
    from glmref.theory import polynomials as poly
    from glmref.theory.stability import axis_polynomial

    c, b, a = axis_polynomial(glmref.load("gsymplectic-n"))
    discriminant = poly.sub(poly.mul(b, b), poly.scale(4, poly.mul(a, c)))
    end = periodicity(glmref.load("gsymplectic-n")).end
    assert isinstance(end, Ball)
    assert poly.evaluate(tuple(x.ball() for x in discriminant), end).ball().contains_zero()
    near = ball(Fraction(205, 100))
    assert not poly.evaluate(tuple(x.ball() for x in discriminant), near).ball().contains_zero()
