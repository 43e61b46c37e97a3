"""asv result files become pairs of error and time; `glmref bench` runs asv as it wants."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from glmref.cli import main
from glmref.errors import DataError
from glmref.report.asv_results import read_results
from tests.build import refused

COLUMNS = ["result", "params", "version", "started_at", "duration", "stats_ci_99_a"]
COLUMNS += ["stats_ci_99_b", "stats_q_25", "stats_q_75"]
PARAMS = [["'gauss-2'", "'rk4'"], ["500", "2000"]]
TIMES = [[1.0, 2.0, 3.0, None], PARAMS, "1", 0, 1.0, [0.5] * 4, [4.0] * 4]
TIMES += [[0.9, 1.9, 2.9, None], [1.1, 2.1, 3.1, None]]
ERRORS = [[1e-3, 1e-5, float("nan"), float("inf")], PARAMS, "1", 0, 1.0]


def store(folder: Path, **changes: Any) -> Path:
    """A folder of results as asv 0.6 writes it, one file."""
    document = {
        "version": 2,
        "commit_hash": "0123456789abcdef",
        "date": 1_700_000_000_000,
        "python": "3.11",
        "params": {"machine": "vm"},
        "result_columns": COLUMNS,
        "results": {"b.Work.time_run": TIMES, "b.Work.track_error": ERRORS, "b.alone": [[7.0], []]},
        **changes,
    }
    listed = {"version": 2, "b.Work.time_run": {"param_names": ["method", "steps"]}}
    (folder / "vm").mkdir(parents=True)
    (folder / "benchmarks.json").write_text(json.dumps(listed))
    (folder / "vm" / "machine.json").write_text("{}")
    (folder / "vm" / "01234567-env.json").write_text(json.dumps(document))
    return folder


def test_the_functions_of_a_class_are_joined_cell_by_cell(tmp_path: Path) -> None:
    cells = read_results(store(tmp_path / "results"))
    assert [c.benchmark for c in cells] == ["b.Work"] * 4 + ["b"]
    second = cells[1]
    assert second.parameters == {"method": "gauss-2", "steps": "2000"}
    assert second.values == {"time_run": 2.0, "track_error": 1e-5}
    assert second.quartiles == {"time_run": (1.9, 2.1)}
    assert (second.commit, second.machine) == ("0123456789abcdef", "vm")
    assert second.date == "2023-11-14T22:13:20+00:00"


def test_what_is_missing_or_not_finite_is_none(tmp_path: Path) -> None:
    cells = read_results(store(tmp_path / "results"))
    assert cells[2].values == {"time_run": 3.0, "track_error": None}
    assert cells[3].values == {"time_run": None, "track_error": None}
    assert cells[3].quartiles == {}
    assert cells[4].parameters == {} and cells[4].values == {"alone": 7.0}


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"version": 3}, "format 3 of asv's result files is unknown"),
        ({"results": {"b.x": 1}}, "not what asv writes"),
        ({"date": "yesterday"}, "not what asv writes"),
        ({"params": {}}, "not what asv writes"),
    ],
)
def test_a_file_of_another_kind_is_named(tmp_path, changes, words):
    caught = refused(DataError, words, read_results, store(tmp_path / "results", **changes))
    assert caught.startswith("01234567-env.json: ")


def test_a_torn_file_is_named(tmp_path: Path) -> None:
    folder = store(tmp_path / "results")
    (folder / "vm" / "torn.json").write_text('{"version": 2, "resu')
    refused(DataError, r"^torn.json: no result file of asv", read_results, folder)


def test_stored_results_are_shown(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, cli) -> None:
    store(tmp_path / ".asv" / "results")
    monkeypatch.chdir(tmp_path)
    lines = cli("bench", "--stored", "--format", "csv").out.splitlines()
    assert lines[0] == "benchmark,commit,method,steps,time_run,track_error"
    assert lines[2] == "b.Work,01234567,gauss-2,2000,2 (1.9 to 2.1),1e-05"
    assert len(json.loads(cli("bench", "--stored", "--format", "json").out)["cells"]) == 5
    assert "gauss-2" in cli("bench", "--stored").out


ASV = """
import json, pathlib, sys
pathlib.Path("calls").open("a").write(json.dumps(sys.argv[1:]) + chr(10))
print("num_cpu [2]:" if sys.argv[1] == "machine" else "", sys.stdin.read(1))
sys.exit(CODES.get(sys.argv[1], 0))
"""


@pytest.mark.parametrize(
    ("codes", "code", "words"),
    [
        ({}, 0, ""),
        ({"run": 2}, 1, "a benchmark failed"),
        ({"run": 1}, 2, "`asv run HEAD^!` failed with exit code 1"),
        ({"machine": 1}, 2, "`asv machine --yes` failed"),
        ({"publish": 1}, 0, "could not write its own pages"),
    ],
)
def test_asv_is_called_as_it_wants(tmp_path, monkeypatch, capfd, codes, code, words):
    store(tmp_path / ".asv" / "results")
    (tmp_path / "asv.py").write_text(f"CODES = {codes}\n{ASV}")
    (tmp_path / "asv.conf.json").write_text("{}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.syspath_prepend(str(tmp_path))
    assert main(["bench", "--quick", "--bench", "Work"]) == code
    err = capfd.readouterr().err
    assert words in err and ("num_cpu" in err) == ("machine" in codes)
    calls = [json.loads(line) for line in (tmp_path / "calls").read_text().splitlines()]
    assert calls[0] == ["machine", "--yes"]
    if "machine" not in codes:
        assert calls[1] == ["run", "HEAD^!", "--quick", "--bench", "Work"]


def test_outside_a_checkout_one_sentence(tmp_path, monkeypatch, cli):
    monkeypatch.chdir(tmp_path)
    assert "there is no asv.conf.json here" in cli("bench", code=2).err
    assert main(["bench", "--stored"]) == 2
