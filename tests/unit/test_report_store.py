"""What is stored is read, and what cannot be read is named and breaks nothing."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from glmref.errors import UsageError
from glmref.report import read
from glmref.report.store import Results

GOOD: dict[str, Any] = {
    "format": "glmref-record-1", "key": "k", "task": {"kind": "method", "method": "rk4", "h": 0.1},
    "outcome": "completed", "steps": 10,
}  # fmt: skip


SVG = '<svg xmlns="http://www.w3.org/2000/svg" {}>{}</svg>'
DRAWING = SVG.format('width="9"', '<path d="M0 0"/>')


def reading(folder: Path, name: str, text: str) -> Results:
    (folder / name).write_text(text, encoding="utf-8")
    return read([folder], ["rk4"])


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ('{"format": "glmref-record-1", "ta', "stopped while it was written"),
        ("hello\n", "not JSON"),
        ("[1]\n", "not a record"),
        (json.dumps({**GOOD, "format": "glmref-record-9"}) + "\n", "format is 'glmref-record-9'"),
        (json.dumps({**GOOD, "task": {"kind": "method"}}) + "\n", "does not say what was run"),
        (json.dumps({**GOOD, "task": None}) + "\n", "does not say what was run"),
        ("[" * 100_000 + "\n", "not JSON"),
        (json.dumps({**GOOD, "steps": 9}) + "\n", "second record of the same task"),
        (json.dumps({**GOOD, "key": "other", "sha256": "0" * 64}) + "\n", "its checksum"),
    ],
)
def test_a_line_that_is_no_record_is_named_and_the_others_are_kept(tmp_path, line, why):
    found = reading(tmp_path, "x.jsonl", json.dumps(GOOD) + "\n" + line)
    assert len(found.runs[0].records) == 1
    (odd,) = found.odd
    assert odd[0] == "x.jsonl, line 2" and why in odd[1]


def test_findings_portraits_and_measurements_are_told_apart(tmp_path: Path) -> None:
    finding = {"method": "rk4", "claim": "order", "verdict": "holds"}
    documents = {
        "found.json": {"format": "glmref-findings-1", "findings": [finding, 7]},
        "stiff.json": {"format": "glmref-measurement-1", "rows": []},
        "other.json": {"format": "glmref-findings-2", "findings": []},
        "list.json": [1],
    }
    for name, document in documents.items():
        (tmp_path / name).write_text(json.dumps(document), encoding="utf-8")
    for name in ("rk4.svg", "chart.svg"):
        (tmp_path / name).write_text(DRAWING, encoding="utf-8")
    (tmp_path / "bytes.json").write_bytes(b"\xff\xfe")
    found = read([tmp_path], ["rk4"])
    assert found.findings == {"rk4": [finding]}
    assert set(found.measurements) == {"stiff"} and set(found.portraits) == {"rk4"}
    assert {where for where, _ in found.odd} == {"other.json", "list.json", "bytes.json"}


def test_what_is_read_first_wins_claim_by_claim(tmp_path: Path) -> None:
    mine = {"method": "rk4", "claim": "order", "verdict": "fails"}
    theirs = [
        {"method": "rk4", "claim": "order", "verdict": "holds"},
        {"method": "rk4", "claim": "explicit", "verdict": "holds"},
    ]
    paths = []
    for name, findings in (("mine", [mine]), ("shipped", theirs)):
        path = tmp_path / f"{name}.json"
        document = {"format": "glmref-findings-1", "findings": findings}
        path.write_text(json.dumps(document), encoding="utf-8")
        paths.append(path)
    assert read(paths).findings == {"rk4": [mine, theirs[1]]}
    assert read(paths[::-1]).findings == {"rk4": theirs}


def test_stability_regions_and_orders_seen_are_found_by_method(tmp_path: Path) -> None:
    row = {"method": "rk4", "claim": "order", "observed": 3.99}
    documents = {
        "stability": {"format": "glmref-stability-1", "methods": {"rk4": {"reach": 3}, "x": 7}},
        "observed-orders": {
            "format": "glmref-measurement-1",
            "orders": [row, 7, {**row, "claim": "effective-order", "observed": None}],
        },
    }
    for name, document in documents.items():
        (tmp_path / f"{name}.json").write_text(json.dumps(document), encoding="utf-8")
    found = read([tmp_path])
    assert found.regions == {"rk4": {"reach": 3}} and found.odd == []
    assert found.observed("rk4") == {"order": row} and found.observed("euler") == {}
    assert set(found.measurements) == {"observed-orders"} and found.constants("rk4") == {}
    constants = {"error-constants": {"methods": [7, {"method": "rk4", "order": 4}]}}
    assert Results(measurements=constants).constants("rk4")["order"] == 4
    assert Results(measurements={"error-constants": {"methods": 7}}).constants("rk4") == {}
    assert Results(measurements={"observed-orders": {"orders": 7}}).observed("rk4") == {}


@pytest.mark.parametrize(
    ("drawing", "why"),
    [
        ("<svg><script>alert(1)</script></svg>", "'script'"),
        ('<svg onload="alert(1)"></svg>', "'onload'"),
        ('<svg><a href="javascript:alert(1)"><text>x</text></a></svg>', "'a'"),
        ('<svg style="display:none"></svg>', "'style'"),
        ("<svg><path></svg>", "no SVG"),
        ("<html></html>", "'html'"),
        (SVG.format('ONLOAD="alert(1)"', ""), "and this one 'ONLOAD'"),  # a page ignores case
        (SVG.format("", '<rect STYLE="x"/>'), "and this one 'STYLE'"),
        (SVG.format("", '<rect fill="Url(http://x/y)"/>'), "and this one 'fill'"),
        (SVG.format("", "<g>" * 50_000 + "</g>" * 50_000), "nested too deep"),
    ],
)
def test_a_portrait_that_is_more_than_a_drawing_is_not_shown(tmp_path, drawing, why):
    found = reading(tmp_path, "rk4.svg", drawing)
    assert found.portraits == {} and why in found.odd[0][1]


def test_results_of_asv_are_read_as_one_and_a_broken_file_is_named(tmp_path: Path) -> None:
    machine = tmp_path / "results" / "machine"
    machine.mkdir(parents=True)
    (machine / "machine.json").write_text("{}", encoding="utf-8")
    assert read([tmp_path]).files == [("results", "0 cells of benchmarks")]
    (machine / "abc-env.json").write_text("[]", encoding="utf-8")
    (odd,) = read([tmp_path]).odd
    assert odd[0] == "results" and "abc-env.json" in odd[1]


def test_a_file_named_twice_counts_once_and_pages_of_a_report_are_passed_over(tmp_path):
    (tmp_path / "a.jsonl").write_text(json.dumps(GOOD) + "\n", encoding="utf-8")
    pages = tmp_path / "pages" / "data"
    pages.mkdir(parents=True)
    (tmp_path / "pages" / "glmref-report.txt").write_text("", encoding="utf-8")
    (pages / "rk4.json").write_text("{}", encoding="utf-8")
    found = read([tmp_path, tmp_path / "a.jsonl"])
    assert len(found.runs) == 1 and found.odd == []


def test_a_path_that_is_not_there_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no file or folder"):
        read([tmp_path / "nothing"])
