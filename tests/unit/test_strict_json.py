"""strict_json.py: what is no exact JSON is refused by place, quickly, without recursion."""

from __future__ import annotations

import json
import time
from pathlib import Path

import pytest

from glmref.catalogue.strict_json import MAX_BYTES, MAX_NESTING, read_json, write_json
from glmref.errors import DataError
from tests.build import refused


@pytest.fixture
def reading(tmp_path: Path):
    def read(content: str | bytes) -> object:
        path = tmp_path / "file.json"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return read_json(path)

    return read


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"\xff\xfe", "byte 0 is not UTF-8"),
        (b"\xef\xbb\xbf{}", "begins with a byte order mark"),
        ("[" * (MAX_NESTING + 1) + "]" * (MAX_NESTING + 1), "nested deeper than 40"),
        ('{"a":' * (MAX_NESTING + 1) + "1" + "}" * (MAX_NESTING + 1), "nested deeper than 40"),
    ],
)
def test_what_is_no_exact_json_is_refused(reading, content: str, message: str) -> None:
    caught = refused(DataError, "", reading, content)
    assert caught.startswith("file.json: ")
    assert message in caught


def test_brackets_inside_strings_are_not_nesting(reading) -> None:
    text = "[" * 500
    assert reading(f'["{text}", "\\"[[[[", "\\\\"]') == [text, '"[[[[', "\\"]
    assert reading("[" * MAX_NESTING + "]" * MAX_NESTING)


def test_numbers_inside_strings_are_not_numbers(reading) -> None:
    assert reading('["0.25", "NaN"]') == ["0.25", "NaN"]


@pytest.mark.parametrize("piece", ['\\"', "[", '{"', "\\", '"\\', '["'])
def test_a_file_of_the_largest_size_is_refused_within_a_second(reading, piece: str) -> None:
    content = (piece * MAX_BYTES)[: MAX_BYTES - 1]
    started = time.process_time()
    refused(DataError, "", reading, content)
    assert time.process_time() - started < 1.0  # about 0.1 s; quadratic searches take minutes


def test_a_file_above_the_largest_size_is_not_read(reading) -> None:
    with pytest.raises(DataError, match=f"{MAX_BYTES + 1} bytes and at most {MAX_BYTES}"):
        reading(b" " * (MAX_BYTES + 1))


def test_a_missing_file_is_a_data_error(tmp_path: Path) -> None:
    with pytest.raises(DataError, match=r"nothing.json: the file cannot be read \(No such file"):
        read_json(tmp_path / "nothing.json")


def test_a_document_is_written_where_there_is_no_folder_yet(tmp_path: Path) -> None:
    path = tmp_path / "new" / "it.json"
    write_json(path, {"name": "Hénon", "rows": [0.5]})
    assert path.read_bytes() == '{"name": "Hénon", "rows": [0.5]}\n'.encode()


def test_a_long_document_has_a_row_on_each_line(tmp_path: Path) -> None:
    path, row = tmp_path / "it.json", {"h": 0.5, "marks": [10, 100], "verdict": "bounded"}
    document = {"name": "Hénon", "rows": [row] * 9, "none": [], "long": "x" * 300}
    write_json(path, document)
    text = path.read_text(encoding="utf-8")
    assert json.loads(text) == document
    assert text.count('\n  {"h": 0.5, "marks": [10, 100], "verdict": "bounded"}') == 9
    assert max(map(len, text.splitlines()[:-2])) < 200


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_json_has_not_is_not_written_and_the_old_file_stays(tmp_path, value):
    path = tmp_path / "it.json"
    path.write_text("old")
    refused(ValueError, "not JSON compliant", write_json, path, [value])
    assert path.read_text() == "old"


def test_brackets_that_were_closed_do_not_count(reading) -> None:
    many = ", ".join(["[[]]"] * 60)
    deep = "[" * (MAX_NESTING + 5) + "]" * (MAX_NESTING + 5)
    assert len(reading('{"x": [' + many + "]}")["x"]) == 60
    refused(DataError, "nested", reading, '{"x": [' + many + ", " + deep + "]}")


@pytest.mark.parametrize("zeros", [0, 16, 17])
def test_a_short_float_is_told_as_the_fraction_it_is(reading, zeros: int) -> None:
    text = f"0.5{'0' * zeros}"
    refused(DataError, "exact string such as '1/2'", reading, f"[{text}]")
    refused(DataError, "exact string such as '1/4'", reading, f"[0.5{'0' * 18}]")


def test_integers_are_read_up_to_20_digits(reading) -> None:
    assert reading(f"[{'9' * 20}]") == [10**20 - 1]
    refused(DataError, r"999999999999\.\.\. is too long", reading, f"[{'9' * 21}]")
