"""Entries as MathML: every entry of every data file is read, and nothing else becomes markup."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any
from xml.etree import ElementTree

import pytest

from glmref.catalogue.files import data_root
from glmref.report.markup import number
from glmref.report.typeset import typeset

MATRICES = ("A", "U", "B", "V", "G", "A_hat", "B_hat", "X", "b", "b_hat", "D", "c", "alpha", "beta")


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
