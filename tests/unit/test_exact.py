"""Exact numbers: zero is decided, floats never enter, balls keep their radius."""

import copy
import pickle
from fractions import Fraction
from math import isqrt
from time import thread_time

import mpmath
import pytest

from glmref.errors import ExactnessError
from glmref.exact import Ball, Exact, ball, exact, root_of_unity
from tests.build import refused

BETA = ((exact(330).sqrt() * 65274 - 347009) / 1265902).sqrt()  # of the order-6 method


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6, 7, 8, 9, 12, 16])
def test_roots_of_unity_have_their_order(n: int) -> None:
    z = root_of_unity(1, n)
    assert z**n == 1
    assert all(z**k != 1 for k in range(1, n))
    assert z * z.conjugate() == 1
    assert root_of_unity(-1, n) == z.conjugate()


def test_a_number_of_real_roots_is_its_own_conjugate() -> None:
    """FLINT computed it anew, which took minutes for polynomials in several nested roots."""
    inner = exact(2).root(5) + exact(7).sqrt()
    for real in (exact(2).sqrt(), exact(3).root(7), (exact(3).sqrt() + 2).sqrt(), BETA,
                 1 / (inner.sqrt() + 1)):  # fmt: skip
        assert real.conjugate() is real.real is real
        assert real.imag == 0


def test_a_real_number_of_square_roots_below_zero_is_its_own_conjugate() -> None:
    """Its ball does not show it; flint would ask its minimal polynomial."""
    for real in (
        exact(-2).sqrt() * exact(-3).sqrt(),
        root_of_unity(1, 3) * 2 + exact(-3).sqrt() * -1,
    ):
        assert real.conjugate() is real.real is real and real.sign() == -1
        turned = real * exact(-1).sqrt()
        assert turned.real == 0 and (turned + real).conjugate() == real - turned


def test_a_real_number_of_complex_roots_is_equal_to_its_conjugate() -> None:
    """The imaginary part of its ball is not exactly zero, but surrounds zero."""
    i = exact(-1).sqrt()
    for real, size in (((i + 2).sqrt() * (2 - i).sqrt(), 5), ((1 - exact(2).sqrt()).sqrt() * i, 0)):
        assert real.is_real() and real.conjugate() == real == real.real
        assert not size or real**2 == size
    imaginary = (1 - exact(2).sqrt()).sqrt()  # its argument is real, its ball has no real part
    assert imaginary.conjugate() == -imaginary and imaginary.real == 0 and not imaginary.is_real()
    assert (imaginary + 3).real == 3 and (imaginary + 3).conjugate() == 3 - imaginary


def test_a_quotient_of_great_cancellation_has_a_size() -> None:
    """At 4096 bits, beyond which flint does not go by itself, its denominator may be zero."""
    root = exact(2).sqrt() + exact(3).sqrt()
    near = Fraction(isqrt(2 * 10**4000) + isqrt(3 * 10**4000), 10**2000)  # below it
    quotient = Exact._wrap(1 / (root - near)._element)
    assert quotient.conjugate() is quotient
    assert quotient.sign() == 1
    assert (quotient.ball() - 10**1998).sign() == 1


def test_powers_of_a_root_are_reduced_by_its_minimal_polynomial() -> None:
    x = exact(3).root(7)
    assert x**7 == 3 and exact(4).root(4) == exact(2).sqrt() and exact(32).root(5) == 2
    y = 1 / (1 + 1 / (1 + x))
    for _ in range(4):
        y = y * y + y / (1 + y)
    # a power of degree 7 * 6 or more had hundreds of terms, and dividing by it took seconds
    assert y.description().count("^") <= 6  # five powers and the polynomial
    assert y * (1 / y) == 1


def test_a_long_number_is_not_divided_by_through_its_minimal_polynomial() -> None:
    """flint takes hours to find that the degree, here 1568, is beyond what it converts."""
    x = exact(1)
    for root in (exact(2).root(7), exact(5).root(7), (exact(2).sqrt() + 3).sqrt(), exact(7).sqrt()):
        x = x * (sum((root**k * (k + 2) for k in range(7)), exact(1)))
    assert len(x.description()) > 2000
    begun = thread_time()
    assert x * (1 / x) == 1
    assert thread_time() - begun < 1


def test_complex_numbers_have_no_sign_and_no_float() -> None:
    i = exact(-1).sqrt()
    assert i * i == -1
    assert not i.is_real()
    assert (i * i).is_real()
    refused(ExactnessError, "only a real number has a sign", i.sign)
    refused(ExactnessError, "no float value", float, i)
    assert complex(i) == 1j


def test_to_mpf_is_right_to_100_digits() -> None:
    with mpmath.workdps(100):
        assert (
            abs(
                BETA.to_mpf()
                - mpmath.sqrt((65274 * mpmath.sqrt(330) - 347009) / mpmath.mpf(1265902))
            )
            < mpmath.mpf(10) ** -98
        )


def test_zero_of_a_ball_is_three_valued() -> None:
    assert Ball.decimal("0.5", 3).is_zero() is False
    assert Ball.decimal("0.000", 3).is_zero() is None
    assert ball(0).is_zero() is True
    assert [ball(x).sign() for x in (0, 2, -2)] == [0, 1, -1]
    refused(ExactnessError, "its sign is not known", Ball.decimal("0.000", 3).sign)


def test_a_rational_that_was_enclosed_is_copied_and_sent_and_others_say_why_not() -> None:
    third, root = exact(Fraction(1, 3)), exact(2).sqrt()
    for x in (third, root):
        assert x.ball() is x.ball()  # computed once
        assert copy.deepcopy(x) is copy.copy(x) is x
    assert pickle.loads(pickle.dumps(third)) == third
    refused(TypeError, "cannot leave its process", pickle.dumps, root)


def test_a_number_is_false_where_it_is_zero_and_plus_leaves_it_alone() -> None:
    assert exact(1) and not exact(0) and not exact(2).sqrt() * exact(8).sqrt() - 4
    for x in (exact(3), ball(3)):
        assert (+x - 3).is_zero() is True


def test_a_ball_around_another_has_its_midpoint_and_the_radius_that_was_asked() -> None:
    x = Ball.around(Ball.decimal("1.5", 1), Fraction(1, 4))
    assert x.contains(Fraction(5, 4)) and x.contains(Fraction(7, 4))
    assert not x.contains(Fraction(124, 100)) and not x.contains(Fraction(176, 100))
    assert float(x) == 1.5 and x.radius() == pytest.approx(0.25)
    assert x.lower_magnitude() <= 1.25 and x.magnitude() >= 1.75
    assert x.decimal_text(3) == "1.50"


def test_numbers_and_balls_of_complex_value_keep_both_parts() -> None:
    i = exact(-1).sqrt()
    x = ball(2 + 3 * i)
    assert complex(x) == complex(2 + 3 * i) == 2 + 3j
    assert complex(x.conjugate()) == complex((2 + 3 * i).conjugate()) == 2 - 3j
    assert float(x.real) == 2 and float(x.imag) == 3 and not x.is_real()
    assert complex(x.midpoint()) == 2 + 3j
    wide = Ball.decimal("1.0", 1) + Ball.decimal("1.000", 3) * i
    assert wide.radius() == pytest.approx(0.1, rel=1e-3)
    assert (wide * i).radius() == pytest.approx(0.1, rel=1e-3)
    assert complex(x.to_mpf()) == 2 + 3j and float(ball(3).to_mpf()) == 3
    for number in (x, 2 + 3 * i):
        refused(ExactnessError, "complex", float, number)
    assert (exact(3) + 4 * i).magnitude() == 5


@pytest.mark.parametrize("n", [2, 3, 5])
def test_signs_of_numbers_that_are_nearly_zero_are_right(n: int) -> None:
    p, q = {2: (1, 1), 3: (2, 1), 5: (2, 1)}[n]
    root = exact(n).sqrt()
    for _ in range(12):  # Newton's iteration: from above, with twice as many digits each time
        p, q = p * p + n * q * q, 2 * p * q
        difference = Fraction(p, q) - root
        assert difference.sign() == 1
        assert (-difference).sign() == -1


def test_a_ball_does_not_depend_on_what_was_asked_before() -> None:
    for n in (2, 3, 7):
        root = exact(n).sqrt()
        asked, plain = root * root / 3, exact(Fraction(n, 3))
        asked.ball()
        assert asked.as_fraction() == Fraction(n, 3)
        assert repr(asked.ball()) == repr(plain.ball())
        assert asked.ball().magnitude() == plain.ball().magnitude()


@pytest.mark.parametrize("text", ["0.0025", "2.5e-3", "25E-4"])
def test_a_decimal_is_its_value_with_a_unit_of_its_last_place(text: str) -> None:
    error = Ball.decimal(text, 4) - Fraction(1, 400)
    assert (error - Fraction(99, 10**6)).is_zero() is None
    assert (error - Fraction(101, 10**6)).is_zero() is False


def test_a_number_of_roots_of_unity_names_their_order_and_another_none() -> None:
    found = (exact(2).sqrt() * root_of_unity(1, 5) + 1).cyclotomic_order
    assert found is not None and found % 5 == 0
    assert BETA.cyclotomic_order is None
