"""Formulas: one definition for numpy, for any precision and for kernels."""

from fractions import Fraction

import numpy as np
import pytest

from glmref.errors import UsageError
from glmref.problems.formula import Formula, exact_number
from tests.build import high, refused


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


@pytest.mark.filterwarnings("ignore:invalid value")
@pytest.mark.parametrize("text", ["(t-1)**0.5", "(-a)**1.5", "sqrt((t-a)**-0.5)", "(-y[0])**(1/3)"])
def test_a_negative_number_has_no_power_that_is_not_whole(text):
    f = Formula((text, "t"), parameters={"a": 2})
    assert np.isnan(f(0.25, np.array([1.0, 2.0]))[0])
    assert np.isnan(f(0.25, np.ones((2, 3)))[0]).all()


def test_common_name_must_be_new():
    with pytest.raises(UsageError, match="needs a name of its own"):
        Formula(("1",), common=(("y", "t"),))(0.0, [1.0])


@pytest.mark.parametrize("value", [True, "abc", "1/0", float("nan"), float("inf"), None, [1], 1j])
def test_numbers_that_are_none_are_refused(value):
    refused(UsageError, "`mu` must be a finite number", exact_number, value, "mu")


@pytest.mark.parametrize(
    "value",
    ["1e999", "1e-999", "1e999999999", 10**400, 10**5000, Fraction(1, 10**400), "9" * 400],
    ids=["large", "small", "huge", "whole", "unprintable", "tiny", "digits"],
)
def test_numbers_without_a_double_are_refused_at_once(value):
    refused(UsageError, "in the range of double precision", exact_number, value, "mu")
