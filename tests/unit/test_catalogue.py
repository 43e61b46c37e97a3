"""The catalogue: names, paths, records of errors, BibTeX entries, and the canonical layout."""

import json
import re
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

import glmref
from glmref.catalogue.canonical import IN_ORDER, canonical, refresh
from glmref.catalogue.errata import Erratum
from glmref.catalogue.lookup import document, load, names, path_of
from glmref.catalogue.strict_json import read_json
from glmref.engine.ensemble import solve_ensemble
from glmref.errors import DataError, UsageError
from glmref.views.bibtex import entries, file_entry, source_entry
from tests.build import refused


def test_a_shipped_name_wins_over_a_file_of_that_name(tmp_path, monkeypatch):
    (tmp_path / "rk4").write_text("{}")
    monkeypatch.chdir(tmp_path)
    assert path_of("rk4").name == "rk4.json"
    assert path_of("./rk4") == Path("rk4")


def test_a_file_without_an_object_is_a_data_error(tmp_path: Path) -> None:
    file = tmp_path / "list.json"
    file.write_text("[]")
    refused(DataError, r"list.json: a method file must hold one JSON object", document, file)


@pytest.mark.slow
def test_documents_are_the_files_byte_for_byte() -> None:
    for name in names("all"):
        path = path_of(name)
        assert document(name) == read_json(path) == json.loads(path.read_bytes())


def test_what_is_wrong_on_purpose_is_named_only_where_it_is_asked_for() -> None:
    wrong = set(names("broken"))
    assert "yoshida-4-sign" in wrong and not wrong & set(glmref.names())
    with pytest.raises(UsageError, match=r"no method named 'yoshida-4-sgin'; .*") as refusal:
        load("yoshida-4-sgin")
    assert "yoshida-4-sign" not in str(refusal.value)
    for name in wrong:  # one letter less: no file that is wrong on purpose is proposed
        with pytest.raises(UsageError) as refusal:
            path_of(name[:-1] + "_")
        told = re.findall(r"[a-z0-9.-]+(?= or |\?)", str(refusal.value))
        assert not wrong & set(told)
    refused(UsageError, "did you mean broken", names, "brokn")


def test_a_method_that_is_wrong_on_purpose_is_refused_by_name_and_runs_as_an_object() -> None:
    with pytest.raises(
        UsageError, match=r"wrong on purpose; .* give glmref.load\('yoshida-4-sign'\)"
    ):
        glmref.solve("kepler", "yoshida-4-sign", h=0.01, steps=2)
    found = glmref.solve("kepler", load("yoshida-4-sign"), h=0.01, steps=2)
    why = document("yoshida-4-sign")["broken"]["why"]
    assert found.notices == (f"yoshida-4-sign is wrong on purpose: {why}",)
    assert glmref.solve("kepler", "yoshida-4", h=0.01, steps=2).notices == ()


@pytest.mark.slow
def test_an_ensemble_says_so_too() -> None:
    initial = [glmref.problem("kepler").y0] * 3
    with pytest.raises(UsageError, match="wrong on purpose"):
        solve_ensemble("kepler", "yoshida-4-sign", initial, h=0.01, steps=2)
    found = solve_ensemble("kepler", load("yoshida-4-sign"), initial, h=0.01, steps=2)
    assert found.notices[0].startswith("yoshida-4-sign is wrong on purpose: ")
    assert solve_ensemble("kepler", "yoshida-4", initial, h=0.01, steps=2).notices == ()


# -- glmref.catalogue.errata: the records and their selection


def test_records_are_frozen() -> None:
    record = Erratum("1-x", "here", "a", "right", "b", "reading")
    with pytest.raises(AttributeError):
        record.verdict = "wrong"


# -- bibtex.py: entries that BibTeX reads, each source once, the file by its hash


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


def test_what_is_no_method_is_not_cited(tmp_path: Path) -> None:
    file = tmp_path / "no.json"
    file.write_text("{}")
    refused(DataError, "", entries, [file])
    refused(UsageError, "", entries, ["nobody-1900"])


# -- the canonical layout: equal documents are equal bytes, and the lists of hashes are exact


DOCUMENT = {
    "source": {"where": "here", "citation": "Nyström", "errata": ["one", "two"]},
    "claims": {"symmetric": True, "order": 4, "abscissae": ["0", "1"]},
    "b": ["1/2", "1/2"],
    "A": [["0", "0"], ["1", "0"]],
    "constants": {"z": "sqrt(2)", "a": "z/2"},
    "name": "m",
    "format": "glmref-method-1",
}

TEXT = """{
  "format": "glmref-method-1",
  "name": "m",
  "constants": {
    "z": "sqrt(2)",
    "a": "z/2"
  },
  "A": [
    ["0", "0"],
    ["1", "0"]
  ],
  "b": ["1/2", "1/2"],
  "claims": {
    "order": 4,
    "abscissae": ["0", "1"],
    "symmetric": true
  },
  "source": {
    "citation": "Nyström",
    "where": "here",
    "errata": [
      "one",
      "two"
    ]
  }
}
"""

values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=6), inner, max_size=4)
    ),
    max_leaves=12,
)
documents = st.dictionaries(st.text(max_size=6), values, max_size=6)


def test_a_matrix_has_one_row_a_line_and_keys_have_their_order():
    assert canonical(DOCUMENT) == TEXT


@pytest.mark.slow
@given(documents, st.randoms(use_true_random=False))
def test_the_text_reads_back_as_the_document_and_the_order_of_keys_leaves_no_trace(
    document, numbers
):
    def shuffled(value, name=""):
        if isinstance(value, dict):
            keys = list(value)
            if name not in IN_ORDER:
                numbers.shuffle(keys)
            return {key: shuffled(value[key], key) for key in keys}
        return [shuffled(x) for x in value] if isinstance(value, list) else value

    text = canonical(document)
    assert json.loads(text) == document
    assert canonical(json.loads(text)) == canonical(shuffled(document)) == text


def test_constants_keep_their_order_because_one_may_use_those_above_it():
    turned = {**DOCUMENT, "constants": {"a": "1", "z": "a/2"}}
    assert canonical(turned) != canonical(DOCUMENT)
    assert canonical(turned).index('"a"') < canonical(turned).index('"z"')


@pytest.fixture
def folder(tmp_path):
    (tmp_path / "methods" / "rk").mkdir(parents=True)
    (tmp_path / "broken").mkdir()
    (tmp_path / "methods" / "rk" / "m.json").write_text(json.dumps(DOCUMENT), encoding="utf-8")
    (tmp_path / "README.md").write_text("text\n", encoding="utf-8")
    (tmp_path / ".hidden").write_text("no\n", encoding="utf-8")
    (tmp_path / "datapackage.json").write_text('{"name": "data"}', encoding="utf-8")
    return tmp_path


def test_refresh_writes_what_differs_and_then_nothing(folder):
    written = {path.name for path in refresh(folder)}
    assert written == {"m.json", "datapackage.json", "SHA256SUMS"}
    assert (folder / "methods" / "rk" / "m.json").read_text(encoding="utf-8") == TEXT
    assert refresh(folder) == []


def test_refresh_notices_a_changed_byte(folder):
    refresh(folder)
    (folder / "README.md").write_text("test\n", encoding="utf-8")
    assert {path.name for path in refresh(folder)} == {"datapackage.json", "SHA256SUMS"}


def test_refresh_needs_the_head_of_the_datapackage(folder):
    (folder / "datapackage.json").unlink()
    refused(FileNotFoundError, r"datapackage\.json", refresh, folder)
