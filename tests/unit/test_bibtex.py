"""bibtex.py: entries that BibTeX reads, each source once, the file by its hash."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from glmref.catalogue.lookup import document, names
from glmref.errors import DataError, UsageError
from glmref.views.bibtex import entries, escape, file_entry, source_entry
from tests.build import refused


def keys(texts: list[str]) -> list[str]:
    return [match[1] for text in texts for match in re.finditer(r"^@\w+\{([^,]+),", text, re.M)]


def balanced(text: str) -> bool:
    """Whether the braces that TeX counts are balanced (escaped ones are not counted)."""
    depth = 0
    for brace in re.findall(r"(?<!\\)[{}]", text):
        depth += 1 if brace == "{" else -1
        if depth < 0:
            return False
    return depth == 0


def test_without_an_entry_one_is_made_of_the_citation() -> None:
    citation = "Nobody, N., 50% of A & B, Journal #1 (1987), 5_6"
    source = {"citation": citation, "where": "eq. (3)", "status": "derived", "doi": "10.1000/a_b"}
    assert source_entry({"name": "it", "source": source}) == (
        "@misc{it-source,\n"
        r"  note = {Nobody, N., 50\% of A \& B, Journal \#1 (1987), 5\_6}," + "\n"
        "  howpublished = {eq. (3)},\n  year = {1987},\n  doi = {10.1000/a_b},\n}"
    )


def test_an_own_file_is_not_called_a_file_of_the_project(tmp_path: Path) -> None:
    file = tmp_path / "mine_1.json"
    file.write_text(json.dumps(document("rk4")))
    entry = file_entry(file)
    assert r"mine\_1.json" in entry
    assert "The glmref authors" not in entry
    assert str(tmp_path) not in entry


def test_different_sources_with_one_key_get_two_keys(tmp_path: Path) -> None:
    other = {**document("gauss-2"), "name": "mine"}
    other["source"] = {**other["source"], "bibtex": "@misc{butcher1964a,\n  note = {other},\n}"}
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(other))
    found = keys(entries(["gauss-2", file]))
    assert found == ["butcher1964a", "glmref-gauss-2", "butcher1964a-mine", "glmref-mine"]


@pytest.mark.slow
def test_every_shipped_entry_is_balanced_has_a_unique_key_and_some_author() -> None:
    texts = entries(names("methods"))
    assert all(balanced(text) for text in texts)
    assert len(keys(texts)) == len(set(keys(texts))) == len(texts)
    assert not balanced("@misc{a, note = {}")
    assert len([x for x in keys(texts) if x.startswith("glmref-")]) == len(names("methods"))


def test_tex_characters_are_escaped() -> None:
    assert escape(r"a_b {c} 10% \x ~ ^ $ & #") == (
        r"a\_b \{c\} 10\% \textbackslash{}x \textasciitilde{} \textasciicircum{} \$ \& \#"
    )
    assert escape("two\nlines") == "two lines"


def test_what_is_no_method_is_not_cited(tmp_path: Path) -> None:
    file = tmp_path / "no.json"
    file.write_text("{}")
    refused(DataError, "", entries, [file])
    refused(UsageError, "", entries, ["nobody-1900"])
