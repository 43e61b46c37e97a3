"""Change any one digit of any coefficient of any shipped method: some claim fails.

Every digit of every coefficient, constant, form, start and finish of every file in
``data/methods`` is replaced by the next one in turn. A change that the loader refuses, or that
makes the enclosure's proof fail, is caught too.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import Any

import pytest

from glmref.catalogue.lookup import document, names
from glmref.catalogue.reader import load_document
from glmref.errors import GlmrefError
from glmref.findings import Verdict
from glmref.verification.verifier import claims_of, facts_for

pytestmark = pytest.mark.slow

NOT_COEFFICIENTS = {"format", "name", "title", "class", "field", "claims", "source", "notes"}
NOT_COEFFICIENTS |= {"digits", "enclosure", "base", "first", "separable", "$schema"}
#: Claims that are cheap to check come first: most changes break one of them.
CHEAP_FIRST = ("abscissae", "preconsistent", "consistent", "starting-order", "order")


def places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Paths of all strings below a value that hold coefficients."""
    if isinstance(value, str):
        yield path
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from places(item, (*path, i))
    elif isinstance(value, dict):
        for key, item in value.items():
            if key not in ("kind", "name", "order"):
                yield from places(item, (*path, key))


def changes(doc: dict[str, Any]) -> Iterator[tuple[dict[str, Any], str]]:
    """Every document that differs from the given one in one digit of one coefficient."""
    coefficients = {k: v for k, v in doc.items() if k not in NOT_COEFFICIENTS}
    for path in places(coefficients):
        holder: Any = coefficients
        for step in path[:-1]:
            holder = holder[step]
        text = holder[path[-1]]
        for i, character in enumerate(text):
            if not character.isdigit() or _is_part_of_a_name(text, i):
                continue
            changed = copy.deepcopy(doc)
            target: Any = changed
            for step in path[:-1]:
                target = target[step]
            digit = str((int(character) + 1) % 10)
            target[path[-1]] = text[:i] + digit + text[i + 1 :]
            yield changed, f"{path} {text!r} digit {i + 1} -> {digit}"


def _is_part_of_a_name(text: str, i: int) -> bool:
    """Whether the digit belongs to a constant's name, such as w2."""
    while i > 0 and (text[i - 1].isalnum() or text[i - 1] == "_"):
        i -= 1
    return text[i].isalpha() or text[i] == "_"


def caught(doc: dict[str, Any]) -> bool:
    """Whether loading fails or a claim fails."""
    try:
        method = load_document(doc)
        facts = facts_for(method)
        claims = claims_of(method)
        for claim in sorted(claims, key=lambda c: (c not in CHEAP_FIRST, c)):
            if facts.judge(claim, claims[claim]).verdict is Verdict.FAILS:
                return True
    except GlmrefError:
        return True
    return False


def exact_part(doc: dict[str, Any]) -> dict[str, Any] | None:
    """The document without a start in decimals; ``None`` where other decimals remain.

    A file of published decimals has thousands of digits, and each change costs an interval test.
    """
    if "digits" not in doc:
        return doc
    if "unknowns" in doc or "starting" not in doc:
        return None
    left_out = ("digits", "starting", "finishing")
    claims = {k: v for k, v in doc["claims"].items() if k != "starting-order"}
    part = {**{k: v for k, v in doc.items() if k not in left_out}, "claims": claims}
    try:
        load_document(part)
    except GlmrefError:  # decimals, and no digits given for them
        return None
    return part


EXACT = [name for name in names("methods") if exact_part(document(name)) is not None]


def test_a_start_in_decimals_takes_no_file_out_of_the_law() -> None:
    assert {"g6245", "g6245-w3", "c2-3-10-w3", "gsymplectic-n"} <= set(EXACT)
    assert not {"s3-w3", "order8-s5-w3", "yoshida-6-midpoint"} & set(EXACT)


@pytest.mark.parametrize("name", EXACT)
def test_any_changed_digit_is_caught(name: str) -> None:
    doc = exact_part(document(name))
    assert doc is not None
    missed = [what for changed, what in changes(doc) if not caught(changed)]
    assert not missed, f"{name}: {len(missed)} changes pass unnoticed, first {missed[:3]}"
