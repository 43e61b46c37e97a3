"""The checkers without dependencies give the proved orders: in C++, JavaScript and Julia."""

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from glmref.catalogue.files import data_root, document, names
from glmref.catalogue.lookup import load
from glmref.exchange.feed import CHECKERS, tableau_text

SOME = (
    "gauss-2", "dormand-prince-5-4", "dormand-prince-sign", "gauss-2-seven-digits",
    "feagin-14-printed",
)  # fmt: skip
Checker = Callable[[list[Path]], list[dict[str, Any]]]
MOST = 8

#: A text, and what is wrong with it.
WRONG = [
    ("0 0\n1 0\nb: 1/2\n", "b has 1 entries and must have 2"),
    ("0\n", "the row `b: ...` is missing"),
    ("b: 1\n", "A must have 1 to 60 rows, got 0"),
    ("1/0\nb: 1\n", "row 1 of A, entry 1: a division by zero"),
    ("sqrt(0-2)\nb: 1\n", "row 1 of A, entry 1: a root of a negative number"),
    ("digits: 9\n0.5\nb: 1\n", "row 1 of A, entry 1: '0.5' has fewer than 9 digits"),
    ("0\nd: 1\nb: 1\n", "'d' is none of b, c, b_hat NAME, digits"),
    ("1/2x\nb: 1\n", "row 1 of A, entry 1: 'x' behind the end of a number"),
]  # fmt: skip


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    compiler = shutil.which("c++")
    if not compiler:
        pytest.skip("there is no C++ compiler")
    made = tmp_path_factory.mktemp("checker") / "check"
    flags = "-std=c++17 -O1 -Wall -Wextra -Werror -DGLMREF_CHECK_MAIN -x c++".split()
    command = [compiler, *flags, str(CHECKERS / "check.hpp"), "-o", str(made)]
    subprocess.run(command, check=True, timeout=300)
    return made


@pytest.fixture(
    params=[pytest.param("c++", marks=[pytest.mark.compiler, pytest.mark.slow]), "node", "julia"]
)
def checker(request: pytest.FixtureRequest) -> Checker:
    if request.param == "c++":
        words = [str(request.getfixturevalue("program"))]
    elif not shutil.which(request.param):
        pytest.skip(f"{request.param} is absent")
    else:
        words = [
            request.param,
            str(CHECKERS / ("check.js" if request.param == "node" else "check.jl")),
        ]

    def run(paths: list[Path]) -> list[dict[str, Any]]:
        done = subprocess.run(
            [*words, *map(str, paths)], capture_output=True, text=True, timeout=300
        )
        found = [json.loads(line) for line in done.stdout.splitlines()]
        assert done.returncode == (2 if any("error" in x for x in found) else 0), done.stderr
        return found

    return run


@cache
def proved() -> dict[str, dict[str, Any]]:
    """The values of the claims of each shipped file, the refuted ones included."""
    found: dict[str, dict[str, Any]] = {}
    rows = json.loads((data_root() / "measurements" / "verification.json").read_bytes())["findings"]
    for row in rows:
        found.setdefault(row["method"], {})[row["claim"].removeprefix("refutes ")] = row["value"]
    return found


def written(folder: Path, listed: list[str]) -> list[Path]:
    paths = []
    for name in listed:
        paths.append(folder / f"{name}.txt")
        paths[-1].write_text(tableau_text(load(name)), encoding="utf-8")
    return paths


def agrees(name: str, report: dict[str, Any]) -> None:
    """What is proved of a method is what a checker says, through order 8."""
    known, rows = proved()[name], report["rows"]
    orders = {"b": known.get("order"), **(known.get("embedded-order") or {})}
    for row, order in orders.items():
        if order is not None:
            expected = min(order, MOST)
            assert rows[row]["order"] == expected <= rows[row]["near"], (name, row)
            assert rows[row]["capped"] is (order >= MOST) is (rows[row]["tree"] is None)
    for row, (order, _) in (known.get("order-to-digits") or {}).items():
        assert rows[row]["order"] == 0 and rows[row]["near"] == min(order, MOST)
    if "row-sums" in known:
        assert report["row_sums"] is known["row-sums"]


@pytest.mark.sampled(1)
def test_the_orders_are_the_proved_ones(checker: Checker, tmp_path: Path) -> None:
    for name, report in zip(SOME, checker(written(tmp_path, list(SOME))), strict=True):
        if name != "gauss-2-seven-digits":
            agrees(name, report)
    seven = report_of(checker, tmp_path, tableau_text(load("gauss-2-seven-digits")))
    assert (seven["exact"], seven["rows"]["b"]["order"], seven["rows"]["b"]["near"]) == (
        False,
        2,
        2,
    )


def report_of(checker: Checker, folder: Path, text: str) -> dict[str, Any]:
    (folder / "one.txt").write_text(text, encoding="utf-8")
    (found,) = checker([folder / "one.txt"])
    return found


@pytest.mark.sampled(1)
def test_abscissae_apart_trees_and_entries(checker: Checker, tmp_path: Path) -> None:
    rk4 = "0 0 0 0; 1/2, 0 0 0; 0 1/2 0 0; 0 0 1 0".replace("; ", "\n") + "\nb: 1/6 1/3 1/3 1/6\n"
    plain, timed = (report_of(checker, tmp_path, x) for x in (rk4, rk4 + "c: 0 1/2 1/2 1/1\n"))
    assert plain["row_sums"] is None and timed["row_sums"] is True
    assert plain["rows"] == timed["rows"]
    row = plain["rows"]["b"]
    assert (row["order"], row["failing"], row["tree"]) == (4, 9, "[oooo]")
    assert float(row["residual"]) == pytest.approx(1 / 120, rel=5e-3)
    wrong = report_of(checker, tmp_path, rk4 + "c: 0 1/2 1/3 1\n")
    assert wrong["row_sums"] is False and wrong["rows"]["b"]["tree"] == "[t]"
    entries = "(1/2-sqrt(4)/4)*3 # 0\nb: root(8,3)/2\nb_hat 2: .5 + 0.5\n"
    assert report_of(checker, tmp_path, entries.replace(" + ", "+"))["rows"]["b"]["order"] == 1
    # the midpoint rule to five digits: its order is not proved, and not refuted
    vague = report_of(checker, tmp_path, "digits: 5\n0.50000\nb: 1\n")
    assert not vague["exact"] and vague["rows"]["b"]["order"] == 2
    assert float(vague["rows"]["b"]["within"]) == pytest.approx(1e-5, rel=0.02)


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("text", "said"), WRONG)
def test_what_is_no_tableau_is_one_sentence(checker, tmp_path, text, said):
    assert report_of(checker, tmp_path, text) == {"error": said}


@pytest.mark.slow
def test_every_runge_kutta_method_of_the_feed(checker, tmp_path, request):
    """The checker in JavaScript reads all of them, the slower ones each fourth."""
    listed = [name for name in names("all") if document(name)["class"] == "rk"]
    assert len(listed) > 150
    kind = request.node.callspec.params["checker"]
    if kind != "node" and "GLMREF_LONG" not in os.environ:
        listed = listed[::4]
    for name, report in zip(listed, checker(written(tmp_path, listed)), strict=True):
        agrees(name, report)


def test_the_julia_file_is_parsed() -> None:
    tree_sitter = pytest.importorskip("tree_sitter")
    grammar = pytest.importorskip("tree_sitter_julia")
    parser = tree_sitter.Parser(tree_sitter.Language(grammar.language()))
    assert not parser.parse((CHECKERS / "check.jl").read_bytes()).root_node.has_error
    assert parser.parse(b"function f(x\n  1 +\nend end").root_node.has_error
