"""glmref.catalogue.errata: the records, their selection, and bad files."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.errata import Erratum, erratum, find_errata, load_errata
from glmref.errors import DataError, UsageError
from tests.build import refused

GOOD: dict[str, Any] = {
    "id": "2.1-example",
    "where": "section 2.1",
    "printed": "1 + 1 = 3.",
    "verdict": "wrong",
    "right": "1 + 1 = 2.",
    "proof": "exact",
    "method": ["rk4"],
    "test": "tests/literature/test_x.py::test_y",
}


def write(folder: Path, *records: Any, **changes: Any) -> Path:
    """An errata file with the given records."""
    path = folder / "errata.json"
    document = {"format": "glmref-errata-1", "errata": list(records)} | changes
    path.write_text(json.dumps(document), encoding="utf-8")
    return path


def test_record_by_id() -> None:
    found = erratum("3.3-a21")
    assert found.verdict == "wrong"
    assert "-11/172" in found.right


def test_unknown_id_names_the_nearest() -> None:
    refused(UsageError, r"did you mean 3\.3-a21", erratum, "3.3-a12")
    refused(UsageError, "glmref list --errata", erratum, "zzzz")


def test_selection_by_text_verdict_proof_and_method() -> None:
    assert all("(3.8)" in str(r.as_json()) for r in find_errata("(3.8)"))
    assert {r.verdict for r in find_errata(verdict="false")} == {"false"}
    assert {r.proof for r in find_errata(proof="reading")} == {"reading"}
    by_method = find_errata(method="thesis-3-8")
    assert by_method and all("thesis-3-8" in r.method for r in by_method)
    assert find_errata() == load_errata()
    assert find_errata("no such words") == ()
    assert find_errata("GAUSS") == find_errata("gauss")


@pytest.mark.parametrize("key", ["verdict", "proof"])
def test_selection_refuses_a_word_that_does_not_exist(key: str) -> None:
    refused(UsageError, f"`{key}` must be one of", find_errata, **{key: "maybe"})


BAD: dict[str, tuple[Callable[[dict[str, Any]], Any], str]] = {
    "not an object": (lambda r: "x", "must be an object"),
    "unknown key": (lambda r: r | {"page": "3"}, "'page' is unknown"),
    "missing text": (lambda r: {k: r[k] for k in r if k != "right"}, "`right` must be a sentence"),
    "empty text": (lambda r: r | {"printed": " "}, "`printed` must be a sentence"),
    "verdict": (lambda r: r | {"verdict": "maybe"}, "`verdict` must be one of"),
    "proof": (lambda r: r | {"proof": "sympy"}, "`proof` must be one of"),
    "no test": (lambda r: r | {"test": None}, "needs its `test`"),
    "test number": (lambda r: r | {"test": 3}, "`test` must be a sentence"),
    "method text": (lambda r: r | {"method": "rk4"}, "`method` must be a list"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_record_is_one_sentence(case: str, tmp_path: Path) -> None:
    change, message = BAD[case]
    caught = refused(DataError, message, load_errata, write(tmp_path, GOOD, change(dict(GOOD))))
    assert "record 2" in caught
    assert "\n" not in caught


def test_bad_documents(tmp_path: Path) -> None:
    refused(DataError, "occurs twice", load_errata, write(tmp_path, GOOD, GOOD))
    for k, (changes, message) in enumerate(
        (
            ({"format": "glmref-errata-2"}, "`format` must be"),
            ({"errata": []}, "must be a list of records"),
        )
    ):
        folder = tmp_path / str(k)
        folder.mkdir()
        refused(DataError, message, load_errata, write(folder, **changes))


def test_reading_needs_no_test(tmp_path: Path) -> None:
    (record,) = load_errata(write(tmp_path, GOOD | {"proof": "reading", "test": None}))
    assert record.test is None


def test_records_are_frozen() -> None:
    record = Erratum("1-x", "here", "a", "right", "b", "reading")
    with pytest.raises(AttributeError):
        record.verdict = "wrong"
