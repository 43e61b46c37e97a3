"""``glmref audit`` with no format: tables in eleven languages, and traps that are no tables."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from glmref.audit.lexer import ENDINGS, LANGUAGES, language_of
from glmref.audit.readers import read
from glmref.audit.recognising import size, tables
from glmref.audit.sources import audit
from glmref.cli import main
from tests.build import source

CLASSES = """
# Runge-Kutta methods
class Heun3(Solver):
    order = 3
    A = np.array([[0, 0, 0], [1 / 3, 0, 0], [0, 2 / 3, 0]])
    b = np.array([1 / 4, 0, 3 / 4])
    c = np.array([0, 1 / 3, 2 / 3])
"""


def test_every_ending_has_a_language() -> None:
    assert set(ENDINGS.values()) == set(LANGUAGES)
    assert language_of(Path("a.unknown")) is None


def test_the_command_needs_no_format(tmp_path: Path, cli) -> None:
    """Several paths, one with a wrong table; without any table nothing is green."""
    right, wrong = tmp_path / "right.py", tmp_path / "wrong.py"
    right.write_text(CLASSES, "utf-8")
    wrong.write_text(CLASSES.replace("[0, 2 / 3, 0]]", "[0, 2 / 5, 0]]"), "utf-8")
    assert json.loads(cli("audit", right, "--all").out)["status"] == "right"
    (record,) = map(json.loads, cli("audit", right, wrong, code=1).out.splitlines())
    assert (record["path"], record["name"]) == ("wrong.py", "Heun3")
    other = tmp_path / "other"
    other.mkdir()
    (other / "nothing.py").write_text("x = 1\n", "utf-8")
    assert main(["audit", str(other)]) == 2
    assert list(audit(other)) == []


#: Samples of the formats, with their language and the tables that both readers see.
SAMPLES = [
    (source("petsc.c"), "petsc", "c", 1),
    (source("julia.jl"), "julia", "julia", 3),
    (source("named-b.cpp"), "constants", "c", 1),
]


@pytest.mark.parametrize(("text", "form", "language", "count"), SAMPLES)
def test_both_readers_see_the_same_numbers(text: str, form: str, language: str, count: int) -> None:
    """The reader of a format and the one of all sources, where both read a table."""

    def numbers(found: Any) -> set[tuple[float, ...]]:
        kinds = ("rk", "additive")
        return {
            tuple(float(f"{size(x):.9g}") for row in (*A, b) for x in row)
            for table in found
            if table.kind in kinds
            for A, b in zip(table.A, table.b, strict=True)
        }

    remark = {"python": "#", "julia": "#", "matlab": "%"}.get(language, "//")
    general = tables(f"{remark} Runge-Kutta\n{text}", LANGUAGES[language])
    assert len(numbers(read(text, form, {})) & numbers(general)) >= count


_RK3 = '"A": [[0, 0, 0], [1/2, 0, 0], [-1, 2, 0]], "order": 3, "b": [1/6, 2/3,'


@pytest.mark.parametrize(
    ("name", "text", "states"),
    [
        ("own.c", "double A[2][2] = {{0, 0}, {0.5, 0}}, b[2] = {0, 1}, c[2] = {0, 0.5};", ["found"]),
        ("own.jl", "A = [0 0 0; 1//2 0 0; -1 2 0]\nb = [1//6, 2//3, 1//6]", ["found"]),
        ("own.jl", "A = [0 0 0; 1//2 0 0; -1 2 0]\nb = [1//6, 2//3, 1//3]", ["wrong"]),
        ("own.py", f"RK3 = {{{_RK3} 1/6]}}\nBAD = {{{_RK3} 1/3]}}", ["right", "wrong"]),
    ],
)  # fmt: skip
def test_a_file_that_is_given_needs_no_word_of_the_subject(tmp_path, name, text, states):
    """A file of two arrays was no table, and weights with another sum were passed over."""
    (tmp_path / name).write_text(text)
    assert [x["status"] for x in audit(tmp_path / name)] == states
    (tmp_path / "A.jl").write_text(
        "A = [0 1//2; 1//3 1//7]\nb = [1//6, 2//3]"
    )  # of another subject
    assert [x["path"] for x in audit(tmp_path) if x["path"] == "A.jl"] == []
