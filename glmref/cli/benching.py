"""``glmref bench``: what asv needs in one command, with error and time side by side."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import click

from ..errors import UsageError
from ..views.tables import Style, columns, csv_text, json_text
from .output import FAILED, HOLDS, complain, format_option, say

RESULTS = Path(".asv", "results")
_BENCHMARK_FAILED = 2  # exit code of `asv run` when it ran, but not every benchmark did


@click.command(short_help="Run the benchmarks with asv: error beside time.")
@click.option("--bench", "pattern", metavar="REGEX", help="Benchmarks whose name matches.")
@click.option("--commits", default="HEAD^!", metavar="RANGE", help="Commits; the last by default.")
@click.option("--quick", is_flag=True, help="Run each benchmark once: no quartiles.")
@click.option("--stored", is_flag=True, help="Run nothing; show what is stored.")
@format_option()
def bench(pattern: str | None, commits: str, quick: bool, stored: bool, form: str) -> int:
    """Measure commits with asv, in a checkout, and print errors and run times side by side.

    Results stay in .asv/results, where `glmref report` finds them. asv's own pages, in .asv/html,
    load scripts from the network; the report does not.
    """
    from ..report.asv_results import read_results

    code = HOLDS
    if not stored:
        code = _measure(pattern, commits, quick=quick)
    if not RESULTS.is_dir():
        raise UsageError(f"there is no {RESULTS}; run `glmref bench` without --stored first")
    cells = [cell.as_json() for cell in read_results(RESULTS)]
    if form == "json":
        say(json_text({"format": "glmref-bench-1", "cells": cells}))
    else:
        _print_cells(cells, form)
    return code


def _measure(pattern: str | None, commits: str, *, quick: bool) -> int:
    if not Path("asv.conf.json").is_file():
        raise UsageError("there is no asv.conf.json here; go to the top of a checkout of glmref")
    if find_spec("asv") is None:
        raise UsageError("asv is not installed; pip install 'glmref[bench]'")
    chosen = [*(["--quick"] if quick else []), *(["--bench", pattern] if pattern else [])]
    _describe_machine()
    code = _asv("run", commits, *chosen)
    if code not in (0, _BENCHMARK_FAILED):
        raise UsageError(f"`asv run {commits}` failed with exit code {code}; see its words above")
    if code == _BENCHMARK_FAILED:
        complain("a benchmark failed; asv names it above, the others are kept")
    if _asv("publish"):
        complain("asv could not write its own pages; the results are kept and shown below")
    return FAILED if code else HOLDS


def _asv(*arguments: str) -> int:
    """Run asv, which can ask nothing, with its output on stderr: stdout has only the results."""
    command = [sys.executable, "-m", "asv", *arguments]
    return subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=sys.stderr, check=False
    ).returncode


def _describe_machine() -> None:
    """Let asv note what it finds of this machine; the questions that it prints are answered so.

    Raises
    ------
    UsageError
        Where asv fails; what it printed is on stderr then.
    """
    command = [sys.executable, "-m", "asv", "machine", "--yes"]
    done = subprocess.run(
        command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        text=True, errors="replace", check=False,
    )  # fmt: skip
    if done.returncode:
        sys.stderr.write(done.stdout)
        raise UsageError("`asv machine --yes` failed; its message is above")


def _print_cells(cells: Sequence[dict[str, Any]], form: str) -> None:
    """Print one table for each class of benchmarks: parameters, then one column a function."""
    style = Style.of(sys.stdout)
    for home in dict.fromkeys(cell["benchmark"] for cell in cells):
        mine = [cell for cell in cells if cell["benchmark"] == home]
        functions = list(dict.fromkeys(f for cell in mine for f in cell["values"]))
        titles = list(dict.fromkeys(name for cell in mine for name in cell["parameters"]))
        head = ["commit", *titles, *functions]
        rows = [
            [
                cell["commit"][:8],
                *(cell["parameters"].get(name, "") for name in titles),
                *(_shown(cell, function) for function in functions),
            ]
            for cell in mine
        ]
        if form == "csv":
            say(csv_text([["benchmark", *head], *([home, *row] for row in rows)]))
        else:
            say(style.paint(home, "bold"))
            say(columns(rows, style=style, head=head) + "\n")


def _shown(cell: dict[str, Any], function: str) -> str:
    value = cell["values"].get(function)
    if value is None:
        return "-"
    pair = cell["quartiles"].get(function)
    spread = f" ({pair[0]:.3g} to {pair[1]:.3g})" if pair else ""
    return f"{value:.4g}{spread}"
