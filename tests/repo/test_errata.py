"""The errata file: its schema, its tests and the data files it names exist."""

import ast
import json
import re
from functools import cache
from pathlib import Path

import pytest

from glmref.catalogue.errata import Erratum, load_errata
from glmref.catalogue.lookup import data_root, names

ROOT = Path(__file__).resolve().parents[2]
ERRATA = load_errata()


@cache
def functions_of(path: Path) -> frozenset[str]:
    """Names of the test functions of a file."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return frozenset(
        node.name
        for node in tree.body
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_")
    )


@pytest.mark.parametrize("record", [r for r in ERRATA if r.test], ids=lambda r: r.id)
def test_the_named_test_exists(record: Erratum) -> None:
    path, _, function = record.test.partition("::")
    assert (ROOT / path).is_file(), path
    assert function in functions_of(ROOT / path)


def test_ids_are_unique_and_only_typing_slips_are_without_a_test() -> None:
    assert len({r.id for r in ERRATA}) == len(ERRATA)
    assert [r.id for r in ERRATA if r.test is None] == ["3.0.5-reference"]


def test_every_named_method_is_a_data_file() -> None:
    known = names("all")
    if not known:
        pytest.skip("no data files yet")
    named = {name for r in ERRATA for name in r.method}
    assert named <= set(known), sorted(named - set(known))


def test_every_broken_file_of_the_thesis_belongs_to_an_erratum() -> None:
    named = {name for r in ERRATA for name in r.method}
    thesis = {name for name in names("broken") if name.startswith("thesis-")}
    assert thesis <= named, sorted(thesis - named)


def test_texts_are_plain_sentences() -> None:
    for r in ERRATA:
        for text in (r.where, r.printed, r.right):
            assert text.isascii() and text == text.strip() and "  " not in text
        assert r.right.endswith(".")
        assert len(r.printed) <= 260 and len(r.right) <= 260, r.id


def test_records_stand_in_the_order_of_the_thesis() -> None:
    def section(record: Erratum) -> tuple[int, ...]:
        match = re.match(r"[0-9.]+", record.id)
        return tuple(int(x) for x in match[0].strip(".").split("."))

    chapters = [section(r)[:2] for r in ERRATA]
    assert chapters == sorted(chapters)


def test_file_follows_its_schema() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    schema = json.loads((data_root() / "schema/glmref-errata-1.schema.json").read_text())
    document = json.loads((data_root() / "errata.json").read_text())
    check = jsonschema.Draft202012Validator(schema)
    check.check_schema(schema)
    assert not list(check.iter_errors(document))
    document["errata"][0]["verdict"] = "maybe"
    assert list(check.iter_errors(document))
