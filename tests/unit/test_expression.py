"""expression.py: the grammar, its limits, and texts that parse back."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.errors import DataError
from glmref.exact import Ball, Exact, exact
from glmref.exact.expression import parse, syntax_tree, weigh
from glmref.exact.relations import box
from tests.build import refused


def test_decimals_are_balls_where_digits_are_declared_and_errors_elsewhere() -> None:
    value = parse("0.3333", digits=4)
    assert isinstance(value, Ball)
    assert value.contains(Fraction(1, 3))
    assert not value.contains(Fraction(34, 100))
    assert parse(".5", digits=1).contains(Fraction(1, 2))
    assert parse("1/3", digits=4) == Fraction(1, 3)  # no decimal, no ball
    refused(DataError, "write a fraction", parse, "0.3333")


def test_weights_count_what_constants_stand_for() -> None:
    weights = {"c": weigh("sqrt(2)+1", {})}
    assert weights["c"][:3] == (9, 1, 1) and weights["c"].degree == 2
    found = weigh("sqrt(c)*c", weights)
    assert found[:3] == (4 + 3 + 18, 3, 2) and found.degree == 4
    weights["d"] = weigh("sqrt(sqrt(c))", weights)
    with pytest.raises(DataError, match="nested 5 deep when its constants are written out"):
        weigh("sqrt(sqrt(d))", weights)


@pytest.mark.parametrize(
    "text", ["0.5", "-.25", "-0.0", "7.", "1.0625", "-0." + "3" * 75, "1.23456"]
)
@pytest.mark.parametrize("digits", [None, 2, 75])
def test_a_single_decimal_is_read_as_any_expression(text: str, digits: int | None) -> None:
    """Tables of decimals take a short way: number, size and refusal are those of the long one."""

    def read(entry: str) -> str:
        try:
            return repr(parse(entry, digits=digits))
        except DataError as error:
            return str(error).partition(" in the entry ")[0]

    assert read(text) == read(f" {text}")
    assert weigh(text, {}) == weigh(f" {text}", {})


FRACTIONS = st.fractions(-50, 50, max_denominator=60)


@given(FRACTIONS, FRACTIONS, st.integers(-30, 30))
def test_a_box_encloses_both_parts_and_a_real_number_has_no_other(a, b, n) -> None:
    value = parse(f"{a}+({b})*sqrt({n})")
    assert isinstance(value, Exact)
    real, imaginary = box(value)
    for (low, high), part in ((real, value.real), (imaginary, value.imag)):
        assert (part - low).sign() >= 0 and (exact(high) - part).sign() >= 0
        assert high - low <= Fraction(3, 2**40)
    assert (imaginary == [0, 0]) == value.is_real()


@given(st.integers(0, 8), st.booleans())
def test_zeros_of_any_length_are_exact(places, signed) -> None:
    text = "0." + "0" * places
    assert parse("-" * signed + text, digits=8) == 0


@pytest.mark.parametrize(
    ("text", "digits", "value"),
    [(".5", 1, 0.5), ("5.", 0, 5), ("-.25", 2, -0.25), ("10.50", 2, 10.5)],
)
def test_decimals_need_no_digit_on_one_side_of_the_point(text, digits, value):
    found = parse(text, digits=digits)
    assert isinstance(found, Ball) and float(found) == value
    assert found.radius() == pytest.approx(10.0**-digits)


@pytest.mark.parametrize("length", [1, 57, 59, 60, 61, 62, 400])
def test_a_message_shows_an_entry_whole_or_sixty_letters_of_it(length):
    entry = "1" * (length - 1) + "?"
    said = refused(DataError, "", parse, entry)
    shown = said.partition(" in the entry '")[2].partition("'")[0]
    assert len(shown) == min(length, 60)
    assert shown == entry if length <= 60 else shown == entry[:57] + "..."


@pytest.mark.parametrize("before", ["", "(1)+", "sqrt(4)+", "root(8,3)+", "-1+", "exp(2*pi*i/3)+"])
def test_what_was_read_before_leaves_the_allowed_depth_as_it_is(before):
    for count in (1, 12):
        for depth in (40, 41):
            entry = before * count + "(" * depth + "1" + ")" * depth
            if depth <= 40:
                parse(entry)
            else:
                refused(DataError, "nested", parse, entry)


@pytest.mark.parametrize("entry", ["1e5", "(1e5)", "1.5e-8", "2E+3*sqrt(2)", "-1e0", "1/2e1"])
def test_entries_of_files_have_no_exponents_and_shown_numbers_may(entry):
    for digits in (None, 10):
        refused(DataError, "", parse, entry, digits=digits)
    refused(DataError, "", syntax_tree, entry)
    syntax_tree(entry, exponents=True)
