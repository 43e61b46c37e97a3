"""Formulas, and Jacobians derived from them."""

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from glmref.errors import UsageError
from glmref.problems import names, problem
from glmref.problems.derivative import differentiated
from glmref.problems.formula import Formula, exact_number
from tests.build import high, refused

DERIVED = [
    name
    for name in names()
    if not name.startswith("fault")
    and (problem(name, **({"sites": 9, "mode": 2} if name == "long-chain" else {}))).jacobian
]


def central_differences(f, y, context, step):
    """df/dy by central differences; error |f'''| step**2/6 plus 10**-dps |f| / step."""
    columns = []
    for j in range(len(y)):
        shift = np.array([context.mpf(0)] * len(y), dtype=object)
        shift[j] = step
        columns.append((f(context.mpf(1), y + shift) - f(context.mpf(1), y - shift)) / (2 * step))
    return np.array(columns).T


@pytest.mark.sampled(8)
@pytest.mark.parametrize("name", DERIVED)
def test_jacobian_agrees_with_differences_at_60_digits(name):
    context = mpmath.MPContext()
    context.dps = 60
    small = {"nonseparable-chain": {"sites": 4}, "fput": {"sites": 4}}
    high = problem(name, **small.get(name, {})).on(context)
    y = high.y0 + np.array([context.mpf(i + 1) / 97 for i in range(len(high.y0))], dtype=object)
    jacobian = high.jacobian(context.mpf(1), y)
    step = context.mpf(10) ** -20
    difference = jacobian - central_differences(high.f, y, context, step)
    # step**2 = 1e-40 times third derivatives, which the stiff ones scale by up to 1e11
    size = 1 + max(abs(x) for x in jacobian.flat)
    assert max(abs(x) for x in difference.flat) < 1e-30 * size


@pytest.mark.parametrize(
    ("text", "slope"),
    [
        ("y[0]**3", lambda x: 3 * x**2),
        ("y[0]**2.3", lambda x: 2.3 * x**1.3),
        ("2**y[0]", lambda x: np.log(2) * 2**x),
        ("y[0]**y[0]", lambda x: x**x * (1 + np.log(x))),
        ("1/(1 + y[0])", lambda x: -1 / (1 + x) ** 2),
        ("tan(y[0])", lambda x: 1 / np.cos(x) ** 2),
        ("log(y[0])", lambda x: 1 / x),
        ("sqrt(y[0])", lambda x: 0.5 / np.sqrt(x)),
        ("exp(-y[0])", lambda x: -np.exp(-x)),
        ("atan2(y[0], 2)", lambda x: 2 / (4 + x * x)),
        ("atan2(2, y[0])", lambda x: -2 / (4 + x * x)),
        ("cos(y[0]*t)", lambda x: -1.5 * np.sin(1.5 * x)),
        ("t - 3", lambda x: 0.0),
        ("-(y[0] - t)", lambda x: -1.0),
    ],
)
def test_every_rule_of_differentiation(text, slope):
    derivative = differentiated(Formula((text,)), 1)
    # some ten roundings
    assert derivative(1.5, [0.7])[0, 0] == pytest.approx(slope(0.7), rel=1e-14)


def test_a_wrong_derivative_is_noticed():
    # near miss: the comparison of the first test at work on a Jacobian off by 1e-12
    context = mpmath.MPContext()
    context.dps = 60
    high = problem("pendulum").on(context)
    wrong = high.jacobian(0, high.y0) * (1 + context.mpf("1e-12"))
    right = central_differences(high.f, high.y0, context, context.mpf(10) ** -20)
    assert max(abs(x) for x in (wrong - right).flat) > 1e-13


# --- formulas -------------------------------------------------------------------------------------


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
