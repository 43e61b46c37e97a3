"""Closed forms are found where they exist and nowhere else."""

from __future__ import annotations

from fractions import Fraction

import pytest

from glmref.derive.recognise import exact_text, minimal_polynomial, surd, surds
from glmref.exact import Exact, ball
from glmref.exact.expression import parse


@pytest.mark.parametrize(
    "text", ["3/7", "-5", "sqrt(5)/6", "-4*sqrt(5)/27", "1/2-sqrt(15)/30", "sqrt(5/8+sqrt(5)/8)"]
)
def test_surds_are_recognised_from_their_digits(text: str) -> None:
    value = parse(text)
    found = surd(ball(value))
    assert found is not None
    assert parse(found) == value


def test_a_number_without_such_a_form_is_left_alone() -> None:
    # A root of x^5 - x - 1, which is not solvable by radicals, found by bisection.
    low, high = Fraction(1), Fraction(2)
    for _ in range(400):
        middle = (low + high) / 2
        low, high = (middle, high) if middle**5 - middle - 1 < 0 else (low, middle)
    value = ball(low)
    assert surd(value) is None
    assert minimal_polynomial(value, degree=5, height=1000) == [1, 0, 0, 0, -1, -1]
    assert surds({"x": value, "y": ball(Fraction(1, 3))}) == {"y": "1/3"}


def test_polynomials_by_chance_are_not_looked_for() -> None:
    # Three coefficients of ten digits fit any 30 digits: the search stops before.
    assert minimal_polynomial(ball(2).sqrt().sqrt(), degree=8, digits=30) is None


def test_roots_are_written_without_square_factors() -> None:
    assert exact_text(Exact(Fraction(80, 121)).sqrt()) == "4*sqrt(5)/11"
    assert exact_text(-Exact(12).sqrt()) == "-2*sqrt(3)"
    assert exact_text(Exact(Fraction(1, 4)).sqrt()) == "1/2"
