"""Periodicity intervals, enclosed."""

import cmath
from fractions import Fraction

import pytest

import glmref
from glmref.exact import Ball, ball, exact
from glmref.method.families import linear_multistep, runge_kutta
from glmref.theory import polynomials as poly
from glmref.theory.periodicity import (
    _March,
    _mirrored,
    _never_both_zero,
    _opposite,
    _separators,
    _taylor,
    periodicity,
)
from tests.shipped import tableau


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


@pytest.mark.parametrize("s", [1, 2, 3])
def test_gauss_methods_are_periodic_on_the_whole_axis(s):
    found = periodicity(runge_kutta(*tableau(f"gauss-{s}")))
    assert found.infinite and found.value == float("inf")


@pytest.mark.parametrize("m", [runge_kutta(*tableau("radau-iia-2")), runge_kutta([["0"]], ["1"])])
def test_dissipative_and_growing_methods_have_no_interval(m):
    found = periodicity(m)
    assert found.end.is_zero() is True and found.value == 0


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


def test_the_coefficients_about_another_point():
    found = _taylor([ball(x) for x in (1, -2, 0, 5)], Fraction(1, 2))
    # 1 - 2 (x + 1/2) + 5 (x + 1/2)^3
    for x, truth in zip(found, (Fraction(5, 8), Fraction(7, 4), Fraction(15, 2), 5), strict=True):
        assert x.contains(truth) and x.radius() < 1e-100


def test_separators_lie_between_the_roots():
    roots = [cmath.exp(1j * x) for x in (0.3, 1.9, -2.0)]
    rho, parameters = _separators(roots)
    points = [complex(rho) * (1 + 1j * float(t)) / (1 - 1j * float(t)) for t in parameters]
    assert parameters == sorted(parameters) and len(points) == 3
    angles = sorted(cmath.phase(w) for w in points)
    assert angles == pytest.approx([-0.85, 1.1, (1.9 + 2 * cmath.pi - 2.0) / 2])
    assert _separators([1j, 1j, -1]) == (None, [])


def test_signs_are_compared_where_they_are_sure():
    i, wide = exact(-1).sqrt(), Ball.decimal("0.0", 1)
    assert _opposite(ball(2), ball(-3)) and _opposite(ball(2) * i, ball(-3) * i)
    assert not _opposite(ball(2), ball(3)) and not _opposite(ball(2), wide)


def test_mirrored_polynomials_are_told_from_others():
    def P(*rows):
        return [tuple(exact(x) for x in row) for row in rows]

    assert _mirrored(P((1,), (0, 3), (1,))) is True
    assert _mirrored(P((1,), (0, 3), (2,))) is False
    assert _mirrored(P((1,), (0, 3), (5,), (0, 3), (1,))) is True
    assert _mirrored(P((1,), (0, 3), (5,), (0, 4), (1,))) is False
    x, y = (exact(0), exact(1)), (exact(-1), exact(1))
    assert _never_both_zero((x, y)) and not _never_both_zero((poly.mul(x, y), y))
    assert not _never_both_zero(((Ball.decimal("1.0", 1),), y))


def test_a_root_off_the_circle_is_proved_and_one_on_it_is_not():
    def march(*coefficients):
        return _March(tuple(tuple(map(exact, p)) for p in coefficients), Fraction(1, 1000))

    assert march((1,), (), (1,))._off_circle(Fraction(0)) is False
    assert march((2,), (), (1,))._off_circle(Fraction(0)) is True
    # w^2 - 2 (1 - y^2) w + 1: on the circle up to y^2 = 2
    verlet = march((1,), (-2, 0, 2), (1,))
    for y, off in ((Fraction(1), False), (Fraction(3, 2), True)):
        assert verlet._off_circle(y) is off
    assert verlet._alternates(Fraction(1), Fraction(1, 8)) is True
    assert verlet._alternates(Fraction(3, 2), Fraction(1, 8)) is False
    assert verlet._alternates(Fraction(1), Fraction(1)) is False


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    ("alpha", "beta"),
    [(["-1", "0", "1"], ["0", "2", "0"]), (["-1", "0", "1"], ["1/3", "4/3", "1/3"])],
)
def test_a_method_on_every_other_point_has_half_the_interval(alpha, beta):
    def spread(values, factor):
        found = []
        for x in values:
            found += ["0"] if found else []
            found.append(str(factor * Fraction(x)))
        return found

    once = periodicity(linear_multistep(alpha, beta))
    # every other coefficient of the characteristic polynomial is 0 for every y
    other = periodicity(linear_multistep(spread(alpha, 1), spread(beta, 2)))
    assert once.value is not None and other.value == pytest.approx(once.value / 2, rel=1e-9)


@pytest.mark.slow
def test_eigenvalues_that_cross_are_not_decided():
    # the leapfrog method, whose eigenvalues move, beside a value that turns by a sixth of a circle
    m = linear_multistep(["-1", "0", "1"], ["0", "2", "0"])
    turn = ((exact(0), exact(-1)), (exact(1), exact(1)))
    none = (exact(0),) * 2
    beside = m.bare(
        U=tuple((*row, *none) for row in m.U),
        B=(*m.B, *(((exact(0),) * m.s,) * 2)),
        V=(*((*row, *none) for row in m.V), *((*((exact(0),) * m.r), *row) for row in turn)),
    )
    found = periodicity(beside)
    assert found.end is None and not found.infinite and found.value is None
    assert 0 < found.proven < 1 and "what they do there is not decided" in found.witness
