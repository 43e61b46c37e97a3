"""Numbers made of roots of unity and of real roots of rationals: zero is decided at once."""

import cmath
import random
from fractions import Fraction

import pytest

from glmref.errors import ExactnessError
from glmref.exact import Exact, root_of_unity
from glmref.exact.expression import parse, to_text
from glmref.exact.roots import Roots

ATOMS = (
    *("exp(2*pi*i/7)", "exp(6*pi*i/7)", "exp(2*pi*i/5)", "exp(2*pi*i/9)", "root(2,3)", "root(12,4)"),
    *("root(6,3)", "root(3/2,5)", "sqrt(5)", "sqrt(2)", "sqrt(3)", "sqrt(7)", "i", "1/3", "2"),
    "1/(2+sqrt(6))",
)  # fmt: skip


def number(text: str) -> Exact:
    value = parse(text)
    assert isinstance(value, Exact)
    return value


def drawn(seed: int) -> tuple[Exact, complex]:
    """A random number of two to four atoms, and the same in floating point."""
    chance = random.Random(seed)
    text = chance.choice(ATOMS)
    value, size = number(text), complex(number(text))
    for _ in range(chance.randint(1, 3)):
        other, sign = number(chance.choice(ATOMS)), chance.choice("+-*")
        value = value + other if sign == "+" else value - other if sign == "-" else value * other
        near = complex(other)
        size = size + near if sign == "+" else size - near if sign == "-" else size * near
    return value, size


@pytest.mark.parametrize("seed", range(40))
def test_sums_and_products_have_their_size_and_what_is_zero_is_decided(seed: int) -> None:
    value, size = drawn(seed)
    assert abs(complex(value) - size) < 1e-12 * max(1, abs(size))
    assert value.is_zero() is (abs(size) < 1e-9)
    square = value * value.conjugate()
    assert square.is_real()
    assert square.sign() == (not value.is_zero())
    assert value.real + value.imag * Exact(-1).sqrt() == value
    assert value.real.is_real()


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("exp(2*pi*i/5)*exp(6*pi*i/7)+exp(2*pi*i/9)*exp(6*pi*i/7)",) * 2,
        ("exp(2*pi*i/7)*sqrt(2)", "sqrt(2)*exp(2*pi*i/7)"),
        ("-exp(2*pi*i/7)*3/5", "-3*exp(2*pi*i/7)/5"),
        ("exp(2*pi*i/7)*(1+sqrt(6))*root(2,3)", "((1+sqrt(6))*exp(2*pi*i/7))*root(2,3)"),
        ("exp(2*pi*i/7)*exp(12*pi*i/7)*(sqrt(3)-i)/2", "(sqrt(3)-i)/2"),
        ("(exp(2*pi*i/7)+sqrt(3))*exp(4*pi*i/7)-exp(6*pi*i/7)", "sqrt(3)*exp(4*pi*i/7)"),
    ],
)
def test_the_text_of_such_a_number(text: str, printed: str) -> None:
    value = number(text)
    assert to_text(value) == printed
    assert number(printed) == value


def test_many_digits_of_a_small_difference() -> None:
    """cos(2 pi / 7) and a rational that agrees with it in 300 digits."""
    real = number("exp(2*pi*i/7)").real
    digits = real.ball(2000).decimal_text(400)
    near = Fraction(digits[:302])  # 0. and 300 digits
    assert (real - near).sign() == 1
    assert (real - near - Fraction(1, 10**300)).sign() == -1
    assert abs(complex(real - near)) < 1e-299
    assert cmath.isclose(complex(real), cmath.cos(2 * cmath.pi / 7))


@pytest.mark.parametrize("factor", ["1", "1+2*i", "2+i", "3+exp(2*pi*i/5)", "exp(4*pi*i/5)/9"])
def test_a_ball_is_narrow_beside_its_number_where_its_terms_cancel(factor: str) -> None:
    """(root(2,3) - 1)^100 is 3e-59, made of terms of 10^29; a ball of 53 bits decides its size."""
    power = number(factor)
    for _ in range(100):
        power = power * (number("root(2,3)") - 1)
    roots = power._as_roots()
    found = roots.enclosed(53)
    assert (found.real.rad() + found.imag.rad()) * 2**53 < found.abs_lower()


def test_positive_roots_of_rationals_meet_without_an_open_zero() -> None:
    """Each is kept by its minimal polynomial, of which flint alone cannot decide so much."""
    x = number("root(6,12)+root(2/9,3)*root(9/5,2)")
    y = number("root(3/4,4)")
    assert ((x + y) * (x + y) - x * x - 2 * x * y - y * y).is_zero()
    x, y = number("root(5/2,5)+root(27/2,6)-root(8/9,9)"), number("root(3,4)")
    assert ((x + y) * (x - y) - x * x + y * y).is_zero()


def test_a_sum_with_very_long_numbers_is_not_divided_by():
    x = parse("exp(2*pi*i/29)+exp(-2*pi*i/29)") * (10**500 + 1) + parse("exp(4*pi*i/29)")
    with pytest.raises(ExactnessError, match=r"with numbers of \d+ bits is not divided by"):
        Exact(1) / x
    assert not x.is_zero()


@pytest.mark.parametrize("turn", [4, 8, 12, 24])
def test_flint_gets_square_roots_for_what_they_are(turn: int) -> None:
    """Of a root of unity and its conjugate it knows no relation: verdicts took hours."""
    value = Exact._made(Roots.of_unity(Fraction(1, turn)))
    assert "Pow" not in repr(value._element) and value == root_of_unity(1, turn)
    real = Exact._wrap(value._element) + Exact._wrap(value._element).conjugate()
    assert real.conjugate() is real and (real - 2 * value.real).is_zero()


def test_a_root_of_unity_is_spelled_alike_whatever_was_found_out_about_another() -> None:
    spelled = to_text(root_of_unity(1, 3))
    assert root_of_unity(1, 3).cyclotomic_order == 12  # finds it to be made of roots: kept with it
    assert to_text(root_of_unity(1, 3)) == spelled == "(sqrt(3)*i-1)/2"
