"""Entries as MathML: every entry of every data file is read, and nothing else becomes markup."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import pytest

from glmref.catalogue.files import data_root
from glmref.report.markup import number
from glmref.report.typeset import typeset, typeset_table

MATRICES = ("A", "U", "B", "V", "G", "A_hat", "B_hat", "X", "b", "b_hat", "D", "c", "alpha", "beta")


def plain(text: str) -> str:
    """MathML without its attribute and outer tag."""
    return re.sub(r"^<math[^>]*>|</math>$", "", typeset(text))


@pytest.mark.parametrize(
    ("text", "mathml"),
    [
        ("-1", "<mo>−</mo><mn>1</mn>"),
        ("1/2", "<mfrac><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></mfrac>"),
        (
            "(3-sqrt(3))/6",
            ("<mfrac><mrow><mn>3</mn><mo>−</mo><msqrt><mn>3</mn></msqrt></mrow>"
            "<mrow><mn>6</mn></mrow></mfrac>"),
        ),
        ("2*3", "<mn>2</mn><mo>·</mo><mn>3</mn>"),
        ("2*(1+i)", "<mn>2</mn><mo>&#x2062;</mo><mrow><mo>(</mo><mn>1</mn><mo>+</mo><mi>i</mi><mo>)</mo></mrow>"),
        ("root(2,3)", "<mroot><mrow><mn>2</mn></mrow><mn>3</mn></mroot>"),
        ("beta1", "<msub><mi>β</mi><mn>1</mn></msub>"),
    ],
)  # fmt: skip
def test_an_entry_is_set_as_mathematics(text: str, mathml: str) -> None:
    assert plain(text) == mathml


def test_multiplication_and_division_bind_from_left_to_right() -> None:
    """2*sqrt(5)/5*x is ((2 sqrt(5))/5) x, as the contract says."""
    root = ElementTree.fromstring(typeset("2*sqrt(5)/5*x"))
    fraction, times, x = list(root)
    assert fraction.tag == "mfrac" and times.text == "\u2062" and x.text == "x"
    above, below = fraction
    assert [e.tag for e in above] == ["mn", "mo", "msqrt"] and below[0].text == "5"


def texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, list):
        for x in value:
            yield from texts(x)


@pytest.mark.slow
def test_every_entry_of_every_method_file_follows_the_grammar() -> None:
    count = 0
    for path in (data_root() / "methods").glob("*/*.json"):
        document = json.loads(path.read_text(encoding="utf-8"))
        for key in MATRICES:
            for text in texts(document.get(key)):
                found = typeset(text)
                assert found.startswith("<math"), (path.name, text)
                ElementTree.fromstring(found.replace("&#x2062;", ""))
                count += 1
    assert count > 3000


@pytest.mark.parametrize("text", ["1/", "<b>", "(1", "1 2", "a(b)", "sqrt", "1;2", "&amp;"])
def test_what_follows_no_grammar_is_shown_as_it_is_and_escaped(text: str) -> None:
    found = typeset(text)
    assert found.startswith(("<code>", "<math")) and "<b>" not in found
    ElementTree.fromstring(found)


def test_a_tableau_has_rules_between_its_blocks_and_a_large_one_is_folded() -> None:
    block = [["1", "2"]]
    found = typeset_table([[block, block], [block, block]])
    assert found.count("<tr") == 2 and found.count("class=top") == 1
    assert found.count("class=left") == 2
    large = typeset_table([[[["1"] * 20 for _ in range(20)]]])
    assert large.startswith("<details><summary>a tableau of 20 rows")


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (1.23456789e-10, "1.23457e-10"), (0.1, "0.1"), (88387, "88387"), (True, "yes"),
        (None, "–"), (float("nan"), "NaN"), (float("-inf"), "-infinite"), ("<b>", "<b>"),
        ([1, None], "1, –"),
    ],
)  # fmt: skip
def test_a_stored_value_is_shown_to_six_digits_or_named(value: Any, text: str) -> None:
    assert number(value) == text
