"""What is stored of the engine's speed: complete, and the tables of the page are computed from it."""

import importlib.util
import json
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
RECORD = ROOT / "data" / "measurements" / "engine.json"
PAGE = ROOT / "docs" / "engine.md"


def tables():
    """The module that writes the tables, read from its file: it needs nothing but Python."""
    spec = importlib.util.spec_from_file_location(
        "engine_tables", ROOT / "benchmarks" / "engine_tables.py"
    )
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def rows():
    return json.loads(RECORD.read_text(encoding="utf-8"))["rows"]


def test_the_page_shows_what_is_stored(rows):
    page = PAGE.read_text(encoding="utf-8")
    assert tables().filled(page, rows) == page, "run python -m benchmarks.measure_engine --write"
    other = [dict(row, gain=99.0) if row["comparison"] == "lanes" else row for row in rows]
    assert tables().filled(page, other) != page


def test_a_page_without_a_place_for_a_table_is_refused(rows):
    with pytest.raises(ValueError, match="0 places for the table steps"):
        tables().filled("", rows)


def test_c_and_engine_did_the_same_arithmetic(rows):
    compared = [row for row in rows if row["comparison"] == "c"]
    assert len(compared) == 12
    assert all(row["same_bits"] for row in compared)


def test_the_record_says_where_and_how_it_was_measured():
    record = json.loads(RECORD.read_text(encoding="utf-8"))
    assert record["format"] == "glmref-measurement-1"
    assert {"processor", "cores", "versions", "compiler", "flags"} <= record["where"].keys()
    assert {"python", "numpy", "llvmlite", "heyoka", "scipy"} <= record["where"]["versions"].keys()
    assert "-O3 -march=native" in record["where"]["flags"]
