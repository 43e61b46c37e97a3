"""The canonical layout: equal documents are equal bytes, and the lists of hashes are exact."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref.catalogue.canonical import IN_ORDER, canonical, refresh
from tests.build import refused

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


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_json_does_not_have_is_refused(value):
    refused(ValueError, "JSON compliant", canonical, {"x": value})


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
