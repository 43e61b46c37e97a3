"""``glmref conformance --board``: integrator by property, each cell with its run, and the wrong one red."""

import json
import re
import shutil
from html import unescape
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest

from glmref.cli import main
from glmref.conformance import board as suite
from glmref.conformance.adapter import SHIPPED
from glmref.conformance.board import CLAIMS, PLANTED, Row, Run, board, recipe
from glmref.findings import Finding, Proof, Verdict
from glmref.report.board import build_board


def finding(claim: str, verdict: Verdict, witness: str = "", method: str = "rk4") -> Finding:
    return Finding(method, claim, None, verdict, None, Proof.MEASURED, 0.0, witness)


COMPILERS = ("gcc", "g++", "gfortran", "rustc")
#: Adapters whose library is no package of Python.
SYSTEM = ("gsl", "odeint", "rklib", "sundials")
#: Methods of others that miss the order that they declare (docs/audit/tables.md).
WRONG_UPSTREAM = {"rklib": {"rks5", "rk8_10"}}

RIGHT = Row(
    "rk4", (finding("step/rk4/cubic", Verdict.HOLDS), finding("order4/rk4/kepler", Verdict.HOLDS))
)
WRONG = Row(
    "rk4",
    (
        finding("step/rk4/linear", Verdict.HOLDS),
        finding(
            "step/rk4/cubic",
            Verdict.FAILS,
            "y is 1 and must be 2 (off by 1, rounding explains 1e-16); A[2][1] is <b>",
        ),
        finding("order4/rk4/kepler", Verdict.OPEN, "not judged: it rests on step"),
    ),
)


def test_a_cell_is_as_good_as_the_worst_of_its_checks() -> None:
    cells = WRONG.cells
    assert (cells["step"].verdict, cells["step"].said) == (Verdict.FAILS, "A[2][1] is <b>")
    assert (cells["order"].verdict, cells["order"].said) == (
        Verdict.OPEN,
        "not judged: it rests on step",
    )
    assert cells["start"].verdict is None and set(cells) == set(CLAIMS)
    assert RIGHT.cells["step"].verdict is Verdict.HOLDS
    mixed = Row(
        "rk4", (finding("step/rk4/a", Verdict.HOLDS), finding("step/rk4/b", Verdict.OPEN, "why"))
    )
    assert mixed.cells["step"].verdict is Verdict.OPEN


def test_every_cell_leads_to_its_checks(tmp_path: Path) -> None:
    absent = Run("heyoka", "", "glmref conformance heyoka", reason="heyoka is not installed")
    runs = [Run("scipy", "scipy 1", "c", (RIGHT,)), Run(PLANTED, "", "c", (WRONG,)), absent]
    page = build_board(runs, tmp_path / "board", "2026-11-24").read_text(encoding="utf-8")
    ids = set(re.findall(r'id="([^"]+)"', page))
    links = re.findall(r'<a href="#([^"]+)"', page)
    assert len(links) >= 5 and set(links) <= ids
    assert page.count('class="cell-fails"><a') == 1 and "A[2][1] is &lt;b&gt;" in page
    assert "did not run" in page and "heyoka is not installed" in unescape(page)
    for path in re.findall(r'href="((?:runs|recipes)/[^"]+)"', page):
        assert (tmp_path / "board" / path).is_file()
    stored = json.loads((tmp_path / "board" / "runs" / "1-planted.json").read_text())
    assert stored["summary"] == {"holds": 1, "fails": 1, "open": 1}


@pytest.mark.parametrize(
    ("name", "rows", "code"),
    [("scipy", RIGHT, 0), ("scipy", WRONG, 1), (PLANTED, WRONG, 0), (PLANTED, RIGHT, 1)],
)
def test_the_exit_code_is_that_of_an_unexpected_verdict(
    name: str, rows: Row, code: int, tmp_path: Path, monkeypatch: Any, capsys: Any
) -> None:
    monkeypatch.setattr(suite, "board", lambda *_: iter([Run(name, "", "c", (rows,))]))
    assert main(["conformance", "--board", "--output", str(tmp_path / "b")]) == code
    assert "1 method of 1 integrator, 0 did not run" in capsys.readouterr().out


def test_a_recipe_names_what_the_line_of_the_list_names(cli) -> None:
    for name, needs in SHIPPED.items():
        text = recipe(name)
        assert all(
            word in text.split() for word in (*needs.packages.split(), *needs.system.split())
        )
        assert text.startswith("FROM python:") and f'"{name}"' in text
    assert "scipy" in cli("conformance", "--recipe", "scipi", code=2).err


def test_a_name_that_is_no_adapter_is_refused(tmp_path: Path, capsys: Any) -> None:
    assert (
        main(["conformance", "--board", "--output", str(tmp_path / "board"), "exported-pyton"]) == 2
    )
    assert "there is no adapter named 'exported-pyton'" in capsys.readouterr().err


@pytest.mark.slow
def test_what_is_not_there_is_grey_with_the_reason_and_the_planted_one_is_red() -> None:
    nothing, planted = board(["nothing.here:Adapter", PLANTED])
    assert "cannot be imported" in nothing.reason and not nothing.rows
    (row,) = planted.rows
    assert (
        row.cells["step"].verdict is Verdict.FAILS and "B[1][3] is 0.3334" in row.cells["step"].said
    )
    assert planted.as_it_should_be
    (late,) = board([PLANTED], seconds=1e-3)
    assert late.reason == "not done in 0.001 s"


@pytest.mark.slow
@pytest.mark.peers
@pytest.mark.parametrize(
    "name", [x for x, y in SHIPPED.items() if x not in ("reference", "compiled", PLANTED)]
)
def test_every_integrator_of_the_board_passes(name: str) -> None:
    (run,) = board([name])
    needs = SHIPPED[name]
    compiler = next((x for x in needs.system.split() if x in COMPILERS), "")
    if run.reason:
        library = {"assimulo": "assimulo"}.get(name, needs.packages.partition(" ")[0])
        known = (compiler and not shutil.which(compiler)) or name in SYSTEM
        assert known or find_spec(library) is None, run.reason
        pytest.skip(run.reason)
    red = {row.method for row in run.rows for x in row.findings if x.verdict is Verdict.FAILS}
    assert red == WRONG_UPSTREAM.get(name, set()), [
        x for row in run.rows for x in row.findings if x.verdict is Verdict.FAILS
    ]
    assert run.as_it_should_be == (not red)
    assert name != "exported-python" or len(run.rows) == 3
