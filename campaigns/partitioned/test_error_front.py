"""Error constants of symmetric multistep methods: against their series, their bound, the record."""

import math
from fractions import Fraction

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned.error_front import (
    PAIRS,
    angles_of,
    cowell,
    end,
    error_constant,
    gap,
    least,
    share,
    table,
)
from glmref.catalogue.lookup import load
from glmref.derive.halves import even_odd, pair_series, quotient
from glmref.derive.multistep import Half
from glmref.derive.recipes.multistep import SHIPPED
from glmref.theory.periodicity import periodicity

RECORD = measured("error-front")


def test_the_coefficients_are_those_of_cowell():
    # Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I (1993), III.10
    assert cowell(4) == (1, Fraction(1, 12), Fraction(-1, 240), Fraction(31, 60480))


@pytest.mark.parametrize("name", ["multistep-rkn-8", "multistep-rkn-10", "multistep-rkn-12"])
def test_the_error_constant_is_what_the_weights_leave(name):
    cosines = SHIPPED[name].p
    half, m = Half(tuple(cosines), second=True), len(cosines)
    # the drift of the formula and of the solution, both in forces exp(x t), times x
    x = 0.05
    drift = 1 / (2 * math.sinh(x / 2))
    for alpha, c in zip(half.stage[1::2], cosines, strict=True):
        drift += float(alpha) * 2 * math.sinh(x / 2) / (2 * math.cosh(x) - 2 * float(c))
    exact = 2 * math.sinh(x / 2) / x**2
    left = (exact / drift - 1) / x ** (2 * m + 2)
    assert m > 3 or left == pytest.approx(error_constant(angles_of(name)), rel=0.02)
    # exactly, from the series
    n = 2 * m + 4
    target, one = even_odd(Fraction(1, 2), n + 1, 1)[1:], [Fraction(1), *[Fraction(0)] * (n - 1)]
    series = quotient(one, target)[2 * m + 2] + sum(
        a * quotient(even_odd(Fraction(1, 2), n, 1), pair_series(c, n))[2 * m + 1]
        for a, c in zip(half.stage[1::2], cosines, strict=True)
    )
    constant = target[2 * m + 2] - series
    assert float(constant) == pytest.approx(error_constant(angles_of(name)), rel=1e-9)


def test_the_slopes_are_the_constants_of_the_other_roots_and_the_bound_is_below():
    angles = np.array([1.2, 1.9, 2.7])
    first = 1 / (2 - 2 * math.cos(1.2))
    moved = np.array([math.acos(1 - 1 / (2 * (first + 1e-3))), 1.9, 2.7])
    slope = (error_constant(moved) - error_constant(angles)) / 1e-3
    assert slope == pytest.approx(error_constant(angles[1:]), rel=1e-6)
    assert [least(m) for m in range(3)] == [Fraction(1, 12), Fraction(1, 60), Fraction(11, 3024)]
    assert all(least(m) > 0 for m in range(8))
    near = np.array([3.1, 3.12, 3.13])
    assert float(least(3)) < error_constant(near) < error_constant(angles)
    assert error_constant(near) == pytest.approx(float(least(3)), rel=2e-3)


@pytest.mark.parametrize("name", ["multistep-rkn-8", "multistep-rkn-10", "quinlan-8b"])
def test_the_interval_is_the_proved_one(name):
    assert end(angles_of(name)) == pytest.approx(periodicity(load(name)).value, abs=0.006)


def test_the_record_is_of_these_methods_and_tasks():
    assert RECORD["least"] == {str(2 * m + 2): str(least(m)) for m in PAIRS}
    for x in RECORD["methods"]:
        angles = angles_of(x["method"])
        assert x["constant"] == pytest.approx(error_constant(angles), rel=1e-3)
        assert x["end"] == pytest.approx(end(angles)) and x["apart"] == round(gap(angles), 1)
    for x in RECORD["descents"]:
        if x["constant"] is not None:
            angles = np.radians(x["angles"])
            assert x["constant"] == pytest.approx(error_constant(angles), rel=3e-3)
            assert gap(angles) >= x["apart"] - 0.02


def test_the_table_shows_the_share():
    (line,) = (x for x in table(RECORD).splitlines() if "`quinlan-8b`" in x)
    assert f"| {share(error_constant(angles_of('quinlan-8b')), 3):.2f} |" in line
    assert "1.21" in line
