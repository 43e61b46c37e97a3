"""Formulas: one definition for numpy, for any precision and for kernels."""

from fractions import Fraction

import numpy as np
import pytest

from glmref.errors import UsageError
from glmref.problems.formula import Formula, exact_number
from tests.build import high


def test_formula_evaluates_a_state_and_states_in_columns():
    f = Formula(("y[1]", "-a*sin(y[0]) + t"), parameters={"a": 2})
    one = f(0.5, np.array([0.1, 0.2]))
    assert one == pytest.approx([0.2, -2 * np.sin(0.1) + 0.5], abs=1e-16)
    columns = f(0.5, np.array([[0.1, 7.0], [0.2, 8.0]]))
    assert columns.shape == (2, 2) and (columns[:, 0] == one).all()


def test_constant_output_fills_all_columns():
    assert Formula(("1", "0"))(0.0, np.zeros((2, 3))).tolist() == [[1] * 3, [0] * 3]


def test_common_subexpressions_may_use_those_before():
    f = Formula(("b + a",), common=(("a", "y[0]*y[0]"), ("b", "2*a")))
    assert f(0.0, [3.0]) == [27.0]


def test_scalar_formula_returns_a_number():
    assert Formula(("y[0]*y[1]",), variables=("y",), shape=())([3.0, 4.0]) == 12.0


def test_decimal_literals_are_decimals_at_every_precision():
    context = high()
    value = Formula(("0.1*y[0] + 1/3",)).on(context)(0, [context.mpf(1)])[0]
    assert abs(value - (context.mpf(1) / 10 + context.mpf(1) / 3)) < 1e-39
    # near miss: the double 0.1 differs from 1/10 by 5.6e-18
    assert abs(value - (context.mpf(0.1) + context.mpf(1) / 3)) > 1e-18


def test_parameters_are_exact():
    context = high()
    third = Formula(("a*y[0]",), parameters={"a": "1/3"}).on(context)(0, [context.mpf(3)])[0]
    assert abs(third - 1) < 1e-39
    double = Formula(("a*y[0]",), parameters={"a": 0.1}).on(context)(0, [context.mpf(1)])[0]
    assert double == context.mpf(0.1)


def test_complex_states_are_kept_complex():
    step = 1e-200
    slope = Formula(("exp(y[0])",))(0.0, np.array([1 + 1j * step]))[0].imag / step
    assert slope == pytest.approx(np.e, rel=1e-15)


def test_substitution_shifts_components():
    f = Formula(("q[0]*c",), common=(("c", "sin(q[1])"),), variables=("q",))
    shifted = f.substituted("q", "y", 3)
    assert shifted.outputs == ("y[3] * c",) and shifted.common == (("c", "sin(y[4])"),)
    assert shifted.indices == {3, 4}


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("__import__('os')", "calls __import__"),
        ("y.real", "contains Attribute"),
        ("y[0] if t else 1", "contains IfExp"),
        ("z + 1", "unknown name 'z'"),
        ("y[i]", "components as y[0]"),
        ("y + 1", "components as y[0]"),
        ("y[-1]", "components as y[0]"),
        ("t[0]", "components as y[0]"),
        ("'a'", "not a number"),
        ("True", "not a number"),
        ("1j", "not a number"),
        ("abs(y[0])", "known are sqrt"),
        ("sin(y[0]", "cannot be read"),
        ("lambda: 1", "contains Lambda"),
        ("(1, 2)", "contains Tuple"),
        ("sin(*y)", "contains Starred"),
        ("sin", "unknown name 'sin'"),
        ("sin(y[0], y[1])", "takes 1"),
        ("9**9**9**9", "exponent"),
        ("(-1)**0.5", "the part '(-1) ** 0.5' of the expression '(-1)**0.5' has no real value"),
        ("sqrt((1-pi)**(1/2))", "has no real value"),
        ("exp(" + "9" * 500 + ")", "has no real value in the range of double precision"),
        ("exp(10**200*10**200)", "has no real value"),
        ("10.0**999", "has no real value"),
        ("1e400", "has no real value"),
    ],
)
def test_expressions_are_arithmetic_and_nothing_else(text, says):
    with pytest.raises(UsageError, match=r".") as error:
        Formula((text,))(0.0, [1.0, 2.0])
    assert says in str(error.value)


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("text", ["(t-1)**0.5", "(-a)**1.5", "sqrt((t-a)**-0.5)", "(-y[0])**(1/3)"])
def test_a_negative_number_has_no_power_that_is_not_whole(text):
    f = Formula((text, "t"), parameters={"a": 2})
    assert np.isnan(f(0.25, np.array([1.0, 2.0]))[0])
    assert np.isnan(f(0.25, np.ones((2, 3)))[0]).all()


def test_powers_that_are_real_stay_what_they_are():
    f = Formula(("(t-1)**2", "(t-1)**-3", "a**-0.5", "y[0]**1.5"), parameters={"a": 4})
    assert f(0.5, np.array([2.0])).tolist() == [0.25, -8.0, 0.5, 2.0**1.5]
    step = 1e-200
    slope = Formula(("y[0]**1.5",))(0.0, np.array([-1 + 1j * step]))[0]
    assert np.iscomplexobj(slope)


def test_common_name_must_be_new():
    with pytest.raises(UsageError, match="needs a name of its own"):
        Formula(("1",), common=(("y", "t"),))(0.0, [1.0])


@pytest.mark.parametrize("value", [True, "abc", "1/0", float("nan"), float("inf"), None, [1], 1j])
def test_numbers_that_are_none_are_refused(value):
    with pytest.raises(UsageError, match="`mu` must be a finite number"):
        exact_number(value, "mu")


@pytest.mark.parametrize(
    "value",
    ["1e999", "1e-999", "1e999999999", 10**400, 10**5000, Fraction(1, 10**400), "9" * 400],
    ids=["large", "small", "huge", "whole", "unprintable", "tiny", "digits"],
)
def test_numbers_without_a_double_are_refused_at_once(value):
    with pytest.raises(UsageError, match="in the range of double precision"):
        exact_number(value, "mu")


@pytest.mark.parametrize(
    ("value", "exact"),
    [("3/5", Fraction(3, 5)), ("1e-3", Fraction(1, 1000)), (np.float64(0.5), 0.5), (7, 7)],
)
def test_numbers_are_read_exactly(value, exact):
    assert exact_number(value, "x") == exact
