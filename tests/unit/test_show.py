"""show.py and tableau_text.py: the tableau in a terminal is the tableau of the paper."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from fractions import Fraction

import pytest

from glmref.catalogue.lookup import load, names
from glmref.exact import ball, exact
from glmref.exact.expression import parse
from glmref.method import GLM
from glmref.views.show import show
from glmref.views.tableau_text import decimal_text, tableau
from glmref.views.tables import Style

UNICODE = Style(unicode=True, width=100)


def body(name: str, style: Style = UNICODE, decimal: int | None = None) -> str:
    """The tableau alone: the second paragraph."""
    return show(load(name), style=style, decimal=decimal).split("\n\n")[1]


def test_rk4_looks_like_the_tableau_of_the_textbooks() -> None:
    assert body("rk4") == (
        "    0 │   0    0    0    0\n"
        "  1/2 │ 1/2    0    0    0\n"
        "  1/2 │   0  1/2    0    0\n"
        "    1 │   0    0    1    0\n"
        " ─────┼───────────────────\n"
        "      │ 1/6  1/3  1/3  1/6"
    )


def test_a_general_linear_method_is_partitioned_into_its_four_blocks() -> None:
    lines = body("gsymplectic-n", Style()).splitlines()
    assert [line.count("|") for line in lines] == [2, 2, 0, 2, 2]
    assert lines[2].count("+") == 2
    assert re.fullmatch(r" [-+]+", lines[2])
    bars = [[m.start() for m in re.finditer(r"[|+]", x)] for x in lines if "sqrt" not in x]
    assert len({tuple(b) for b in bars}) == 1  # rules and bars stand in the same columns
    assert lines[0].split("|")[1].split() == ["(3-sqrt(3))/6", "0"]


def test_names_of_long_entries_never_clash_with_constants() -> None:
    long = "1+sqrt(2)+sqrt(3)+sqrt(5)+sqrt(7)+sqrt(11)"
    document = {
        "format": "glmref-method-1",
        "name": "it",
        "class": "rk",
        "constants": {"x1": "1/3"},
        "A": [["x1", long], ["0", long]],
        "b": ["1/2", "1/2"],
        "claims": {"order": 1},
        "source": {"citation": "c", "where": "w", "status": "derived"},
    }
    from glmref.catalogue.reader import load_document

    text = show(load_document(document))
    assert f"= {long}" in text
    assert text.count(long) == 1
    assert re.search(r"x1 +│?\|? *", text)
    assert re.search(r"^  x1 +=  ?1/3$|^  x1 = 1/3$", text, re.MULTILINE)


def test_a_pair_shows_both_methods() -> None:
    text = show(load("gsymplectic-n-pair"), style=UNICODE)
    assert "q:  Q = h A f(P) + U q" in text
    assert "p:  P = h A^ k(Q) + U^ p" in text
    assert text.count("┼") == 4 + 2  # two methods, each in four blocks; a start, for q and for p
    assert "and for p:  P = h A^ k(Q) + p0" in text
    assert "D_P =" in text
    assert "D_Q =" in text


def test_published_digits_are_shown_in_place_and_said_to_be_rounded() -> None:
    text = show(load("s5t-w3"))
    assert "0.1077081816" in text
    assert "Decimals are rounded to 10 digits; --decimal N shows more." in text
    more = show(load("s5t-w3"), decimal=30)
    assert re.search(r"0\.10770818161718\d{16}\b", more)


@pytest.mark.slow
@pytest.mark.parametrize("decimal", [None, 4])
def test_every_shipped_method_can_be_shown_and_its_rules_line_up(decimal: int | None) -> None:
    wide = replace(UNICODE, width=100_000)  # in one piece
    for name in names("all"):
        text = show(load(name), decimal=decimal, style=wide)
        for part in text.split("\n\n"):
            rules = [line for line in part.splitlines() if line.startswith(" ─")]
            bars = [line for line in part.splitlines() if "│" in line]
            places = {tuple(m.start() for m in re.finditer("[│┼]", x)) for x in (*rules, *bars)}
            assert len(places) <= 1 or "starting" in part, name


def test_every_exact_entry_shown_stands_for_the_entry_itself() -> None:
    method = load("gauss-3")
    assert isinstance(method, GLM)
    rows = body("gauss-3").splitlines()[:3]
    for row, shown in zip(method.A, rows, strict=True):
        cells = shown.split("│")[1].split()
        assert [parse(x) for x in cells] == list(row)


@pytest.mark.parametrize(
    ("x", "digits", "text"),
    [
        (Fraction(1, 4), 5, "0.25"),
        (Fraction(1, 3), 5, "0.33333"),
        (Fraction(2, 3), 1, "0.7"),
        (Fraction(-7), 5, "-7"),
        (Fraction(0), 5, "0"),
        (Fraction(123456), 3, "123000"),
        (Fraction(1, 10**20), 3, "1e-20"),
        (Fraction(1, 8), 2, "0.12"),
    ],
)
def test_rational_number_in_decimals(x: Fraction, digits: int, text: str) -> None:
    assert decimal_text(exact(x), digits) == text


def test_complex_numbers_show_both_parts() -> None:
    assert decimal_text(parse("1/2-i*sqrt(3)/2"), 4) == "0.5-0.8660i"
    assert decimal_text(parse("i/3"), 4) == "0.3333i"
    assert decimal_text(parse("2*i"), 4) == "2i"


def test_a_ball_around_zero_has_no_digit() -> None:
    root = ball(exact(2).sqrt())
    around = root * root - 2
    assert around.is_zero() is None
    assert decimal_text(around, 5) == "0"
    assert decimal_text(around + Fraction(1, 10**20), 5) == "1.0000e-20"


def test_one_hundred_digits_are_right() -> None:
    digits = decimal_text(exact(2).sqrt(), 100)
    assert abs(Fraction(digits) ** 2 - 2) < Fraction(3, 10**99)
    assert len(digits) == 101


def test_a_hundred_columns_are_drawn_in_parts_at_once() -> None:
    block = [["0.25"] * 100] * 100
    begun = time.thread_time()
    lines = tableau([[block]], Style(width=80))
    assert len(lines) > 600 and lines[0] == "  columns 1 to 13 of 100:"
    assert time.thread_time() - begun < 2  # it took 16 s
