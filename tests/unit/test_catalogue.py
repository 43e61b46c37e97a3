"""catalogue.py: names and paths find files, near misses are named, nothing else is opened."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from glmref.catalogue.lookup import data_root, document, load, names, path_of
from glmref.catalogue.strict_json import read_json
from glmref.errors import DataError, UsageError


def test_names_are_the_stems_of_the_files_and_the_two_folders_share_none() -> None:
    stems = {p.stem for p in data_root().glob("methods/*/*.json")}
    assert set(names("methods")) == stems
    assert set(names()) == set(names("methods")) | set(names("broken"))
    assert not set(names("methods")) & set(names("broken"))
    assert names() == sorted(names())
    for name in names():
        assert document(name)["name"] == name == path_of(name).stem


def test_broken_files_say_what_must_fail_and_why_and_the_others_do_not() -> None:
    for name in names("broken"):
        assert {"claim", "why", "flag", "found"} == document(name)["broken"].keys(), name
    assert not [name for name in names("methods") if "broken" in document(name)]


def test_a_path_is_read_like_a_name(tmp_path: Path) -> None:
    file = tmp_path / "mine.json"
    file.write_text(json.dumps(document("rk4")))
    assert load(file).name == load(str(file)).name == "rk4"


def test_a_shipped_name_wins_over_a_file_of_that_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "rk4").write_text("{}")
    monkeypatch.chdir(tmp_path)
    assert path_of("rk4").name == "rk4.json"
    assert path_of("./rk4") == Path("rk4")


def test_a_near_miss_names_what_was_meant() -> None:
    with pytest.raises(UsageError, match="did you mean gauss-2"):
        load("gaus-2")
    with pytest.raises(UsageError, match="see `glmref list`"):
        load("completely-different")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("no/such/file", "does not exist"),
        ("nothing.json", "does not exist"),
        (".", "is a folder"),
        ("", "there is no method named"),
        ("/dev/null", "is not a regular file"),
        ("a" * 3000 + ".json", "cannot be read"),
        ("a\0b", "there is no method named|cannot be read"),
    ],
)
def test_what_is_no_file_is_a_usage_error(name: str, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        path_of(name)


def test_a_file_without_an_object_is_a_data_error(tmp_path: Path) -> None:
    file = tmp_path / "list.json"
    file.write_text("[]")
    with pytest.raises(DataError, match=r"list.json: a method file must hold one JSON object"):
        document(file)


def test_documents_are_the_files_byte_for_byte() -> None:
    for name in names():
        path = path_of(name)
        assert document(name) == read_json(path) == json.loads(path.read_bytes())
