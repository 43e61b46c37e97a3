"""A file that holds a tableau and nothing else: every command but ``verify`` and ``cite`` reads it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

import glmref
from glmref.catalogue.keys import BLOCKS, FORMATS, SECOND, completed, of_second
from glmref.catalogue.lookup import document
from glmref.cli import main

HEUN = {"A": [["0", "0"], ["1", "0"]], "b": ["1/2", "1/2"]}
SAID = ("format", "name", "class", "claims", "source", "title", "notes", "$schema")


def write(folder: Path, content: Any, name: str = "mine.json") -> Path:
    path = folder / name
    path.write_text(json.dumps(content), encoding="utf-8")
    return path


@pytest.mark.sampled(4, besides=("g6245",), whole=6)
@pytest.mark.parametrize(
    "name",
    ["gsymplectic-n", "rk4", "ab-2", "bdf-2-one-leg", "suzuki-verlet-4", "g6245-w3", "pair-4-4",
     "ros34pw2", "ars-2-3-2", "nystrom-5"],
)  # fmt: skip
def test_the_class_is_told_from_the_keys(name: str, tmp_path: Path) -> None:
    whole = document(name)
    bare = {k: x for k, x in whole.items() if k not in SAID}
    path = write(tmp_path, bare, "My Method (2).json")
    method = glmref.load(path)
    assert method.document is not None
    wanted = "lmm" if set(bare) == {"alpha", "beta"} else whole["class"]
    assert method.document["class"] == wanted
    assert method.name == "my-method-2-"
    assert not method.claims and not method.source
    if wanted == whole["class"] and "enclosure" not in bare and name != "suzuki-verlet-4":
        record = glmref.analyze(method).as_json() | {"method": name}
        assert record == glmref.analyze(glmref.load(name)).as_json()


def test_every_class_is_told_from_the_keys_it_needs() -> None:
    from glmref.catalogue.keys import class_of_keys, needed_keys

    for kind in BLOCKS:
        keys = needed_keys(kind)
        assert class_of_keys(dict.fromkeys(keys)) == ("lmm" if kind == "one-leg" else kind)
    assert class_of_keys(dict.fromkeys(["alpha", "beta", "G"])) == "one-leg"
    assert class_of_keys({"a": [], "b": []}) == ""


@pytest.mark.sampled(1)
@pytest.mark.parametrize(
    "content",
    [
        HEUN,
        {**HEUN, "claims": {}},
        {**HEUN, "format": "glmref-method-1", "name": "heun"},
        {"A": HEUN["A"], "U": [["1"], ["1"]], "B": [["1/2", "1/2"]], "V": [["1"]]},
    ],
)
def test_analyze_and_show_read_it_and_verify_and_cite_say_what_is_missing(
    content: dict[str, Any], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = str(write(tmp_path, content))
    assert main(["analyze", file]) == 0
    assert "order with the identity" in capsys.readouterr().out
    assert main(["analyze", file, "--format", "json"]) == 0
    assert json.loads(capsys.readouterr().out)["order"] == 2
    assert main(["show", file]) == 0
    assert "1/2" in capsys.readouterr().out
    assert main(["verify", file]) == 2
    out, err = capsys.readouterr()
    assert out == "" and err == (
        "glmref: mine.json: there is nothing to verify, since the file makes no claims; "
        "`glmref analyze mine.json` says what the method is\n"
    )
    assert main(["cite", file]) == 2
    out, err = capsys.readouterr()
    assert out == "" and "has no source to cite; add `source`" in err


def test_it_is_solved_with(tmp_path: Path) -> None:
    found = glmref.solve("kepler", str(write(tmp_path, HEUN)), h=0.01, steps=10)
    assert found.y == pytest.approx(glmref.solve("kepler", "heun-2", h=0.01, steps=10).y, abs=1e-15)


def test_a_name_made_of_a_long_file_name_is_cut_at_a_hundred_characters(tmp_path: Path) -> None:
    path = tmp_path / ("Long Name " + "x" * 150 + ".json")
    path.write_text(json.dumps({"A": [["0"]], "b": ["1"]}))
    assert glmref.load(path).name == "long-name-" + "x" * 90


@pytest.mark.parametrize("digits", [True, "75", 7.5, [], 0, 151])
def test_digits_are_a_whole_number(tmp_path: Path, digits: Any) -> None:
    path = tmp_path / "x.json"
    path.write_text(json.dumps({"A": [["0"]], "b": ["1"], "digits": digits}))
    with pytest.raises(glmref.DataError, match=r"`digits` must|not exact|is no exact|exact string"):
        glmref.load(path)


def test_a_starting_method_may_have_one_stage(tmp_path: Path) -> None:
    path = tmp_path / "x.json"
    start = {"A": [["0"]], "B": [["0"], ["1"]], "u": ["1", "0"], "order": 1}
    path.write_text(json.dumps({"A": [["0"]], "U": [["1", "0"]], "B": [["1"], ["1"]],
                                "V": [["1", "0"], ["0", "0"]], "starting": start}))  # fmt: skip
    assert len(glmref.load(path).starting.A) == 1


@pytest.mark.parametrize("name", ["ros34pw2", "nystrom-5", "ars-2-3-2", "rk4", "gauss-2"])
def test_the_format_is_the_first_that_has_the_class(name: str) -> None:
    blocks = {k: x for k, x in document(name).items() if k not in (*SAID, "embedded", "dense")}
    found = completed(blocks, "it.json")
    assert found["class"] == document(name)["class"]
    assert found["format"] == FORMATS[found["class"] in SECOND]
    assert not of_second(found) or found["format"] == FORMATS[1]
