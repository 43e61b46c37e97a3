"""What is stored is read and shown: measurements, errata, entries as MathML, and what cannot be read."""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest

from glmref.catalogue.files import data_root
from glmref.errors import UsageError
from glmref.report import read
from glmref.report.measurements import measurement_pages
from glmref.report.store import Results
from glmref.report.typeset import typeset

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


# -- measurements and errata on the pages: what is stored, and pictures where they fit


def measured(**doc: Any) -> str:
    (page,) = measurement_pages(
        Results(measurements={"it": {"format": "glmref-measurement-1", **doc}})
    )
    return page.body


ROWS = [
    {"name": "a", "problem": "one", "error": 1.25e-3, "evaluations": 100, "outcome": "completed"},
    {"name": "b", "problem": "one", "error": float("nan"), "evaluations": 200, "outcome": "lost"},
    {"name": "a", "problem": "two", "error": None, "evaluations": 300, "outcome": "completed"},
]


def test_errors_against_costs_are_drawn_one_picture_a_problem() -> None:
    body = measured(rows=ROWS)
    assert body.count("<figure") == 1 and 'data-table="m-it-rows-0"' in body
    assert 'data-x="evaluations" data-y="error"' in body and 'data-series="name"' in body
    assert body.count("<h3>") == 2 and "0.00125" in body and "NaN" in body
    # nothing to draw without an error
    assert "<figure" not in measured(rows=[{"name": "a", "evaluations": 1}])


def test_lists_of_equal_length_are_a_curve_with_its_numbers_beside_it() -> None:
    rows = [
        {"variant": "plain", "method": "rk4", "steps": [10, 20], "rms": [1e-16, 2e-16]},
        {"variant": "sums", "method": "rk4", "steps": [10, 20], "rms": [3e-16, 4e-16]},
    ]
    body = measured(rows=rows)
    assert 'data-table="m-it-rows-0-curves" data-series="line" data-x="steps" data-y="rms"' in body
    for cells in ("plain, rk4<td>10<td>1e-16", "sums, rk4<td>20<td>4e-16"):
        assert f"<tr><td>{cells}" in body
    rows[1]["rms"] = [3e-16]
    assert "-curves" not in measured(rows=rows)


def test_an_object_with_a_list_inside_is_opened_and_other_values_are_written_out() -> None:
    body = measured(h=[0.2, 0.1], losses={"problem": {"q0": "23/10"}, "runs": [{"lost": 7.25}]})
    assert "<dt>h<dd>0.2, 0.1" in body and "<dd>q0: 23/10" in body
    assert "<h2>losses</h2>" in body and "<tr><td>7.25" in body


def test_cases_are_opened_and_their_runs_are_rows_under_the_method_they_belong_to() -> None:
    runs = [
        {"steps": 10, "error": 1e-3, "seconds": 0.5},
        {"steps": 20, "error": 2e-5, "seconds": 1.5},
    ]
    tracks = [{"method": "g6245", "solver": "newton", "runs": runs, "at": {"1e-06": 3}}]
    body = measured(cases=[{"case": "kepler-0.6", "t_end": 6.5, "tracks": tracks}])
    assert "<h2>kepler-0.6</h2>" in body and "<dt>t_end<dd>6.5" in body
    assert "<tr><td>g6245, newton<td>g6245<td>newton<td>10<td>0.001<td>0.5" in body
    assert 'data-x="seconds steps" data-y="error"' in body
    assert "<td>1e-06: 3" in body  # what belongs to the track and to none of its runs


@pytest.mark.parametrize("value", [[], {}, [1, {}], {"a": []}, "text", None, 3, [[1, 2], [3]]])
def test_a_value_of_any_shape_breaks_nothing(value: Any) -> None:
    assert "<dt>odd" in measured(odd=value) or value == {}


# -- entries as MathML: every entry of every data file is read, and nothing else becomes markup


MATRICES = ("A", "U", "B", "V", "G", "A_hat", "B_hat", "X", "b", "b_hat", "D", "c", "alpha", "beta")


def texts(value: Any) -> Iterator[str]:
    if isinstance(value, str):
        yield value
    elif isinstance(value, list):
        for x in value:
            yield from texts(x)


@pytest.mark.slow
def test_every_entry_of_every_method_file_follows_the_grammar() -> None:
    count = 0
    for path in (data_root() / "methods").glob("*/*.json"):
        document = json.loads(path.read_text(encoding="utf-8"))
        for key in MATRICES:
            for text in texts(document.get(key)):
                found = typeset(text)
                assert found.startswith("<math"), (path.name, text)
                ElementTree.fromstring(found.replace("&#x2062;", ""))
                count += 1
    assert count > 3000


@pytest.mark.parametrize("text", ["1/", "<b>", "(1", "1 2", "a(b)", "sqrt", "1;2", "&amp;"])
def test_what_follows_no_grammar_is_shown_as_it_is_and_escaped(text: str) -> None:
    found = typeset(text)
    assert found.startswith(("<code>", "<math")) and "<b>" not in found
    ElementTree.fromstring(found)
