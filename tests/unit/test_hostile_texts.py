"""Names, titles, notes and citations of others: escaped or refused by everything that writes them."""

import csv
import io
import json
import re
from html.parser import HTMLParser
from pathlib import Path
from typing import Any
from urllib.parse import quote
from xml.etree import ElementTree

import pytest

from glmref.catalogue.lookup import document
from glmref.catalogue.reader import load_document
from glmref.cli import main
from glmref.exchange.export import TARGETS, export
from glmref.findings import Finding, Verdict
from glmref.report import build, read
from glmref.report.store import is_number
from glmref.system.shown import DARK
from glmref.system.terminal import escaped
from glmref.views import chart, paths
from glmref.views.bibtex import source_entry
from glmref.views.tables import csv_text, findings_csv, findings_junit
from tests.build import scene_text

#: Markup of every kind, an escape of terminals, a mark that turns a line round, what XML lacks.
HOSTILE = (
    "</title></script><script>alert(1)</script><img src=x onerror=alert(1)>\"'"
    "]]>\x1b]0;title\x07\x1b[2J\u202e\x00\x85\ud800&amp;{}\\input{x}%"
)
CONTROLS = re.compile("[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]")


class Seen(HTMLParser):
    """Elements and attributes of a page."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.attributes: set[str] = set()
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.attributes |= {name for name, _ in attrs}


# --- pictures -------------------------------------------------------------------------------------


def drawn(text: str) -> None:
    """Assert that a drawing is XML with shapes and texts only."""
    root = ElementTree.fromstring(text)
    tags = {str(node.tag).rpartition("}")[2] for node in root.iter()}
    assert tags <= set("svg title desc g path rect circle line polyline polygon text tspan".split())
    assert not any(key.startswith("on") for node in root.iter() for key in node.attrib)
    text.encode("utf-8")


def test_texts_in_a_chart_are_no_markup() -> None:
    series = [chart.Series(HOSTILE, ((1.0, 1.0), (2.0, 0.5)), (HOSTILE, HOSTILE))]
    drawn(chart.svg(series, title=HOSTILE, x_label=HOSTILE, y_label=HOSTILE))
    drawn(chart.svg([chart.Series(HOSTILE, ())], title=HOSTILE, x_label="x", y_label="y"))


@pytest.mark.parametrize("value", [10**400, -(10**400), float("nan"), True, None])
def test_a_number_beyond_doubles_is_none_that_is_shown(value: Any) -> None:
    assert not is_number(value) and is_number(1) and is_number(-1.5)


def test_texts_in_orbits_are_no_markup() -> None:
    cloud = paths.Cloud(HOSTILE, ((0.0, 0.0), (1.0, 1.0)), ended=HOSTILE)
    drawn(paths.svg([cloud], title=HOSTILE, x_label=HOSTILE, y_label=HOSTILE))


# --- pages ----------------------------------------------------------------------------------------


def hostile_record(n: int) -> dict[str, Any]:
    return {
        "format": "glmref-record-1",
        "key": f"{n}{HOSTILE}",
        "task": {
            "kind": "method", "method": HOSTILE, "h": HOSTILE, "problem": HOSTILE, "ask": [HOSTILE],
            "parameters": {HOSTILE: HOSTILE}, "t_end": HOSTILE, "start": HOSTILE,
        },
        "outcome": HOSTILE, "message": HOSTILE, "steps": HOSTILE, "state_error": HOSTILE,
        "kernel": HOSTILE, "notices": [HOSTILE], "lost": HOSTILE, "reason": HOSTILE,
        "series": [[HOSTILE, HOSTILE]], "drifts": [{"kind": HOSTILE, "largest": HOSTILE}],
        "orbit": {"axes": [HOSTILE, HOSTILE], "paths": [[[HOSTILE] * 3]], "ended": HOSTILE},
        "law": {"quantity": HOSTILE, "law": HOSTILE}, "where": {HOSTILE: HOSTILE},
        "reference": HOSTILE, "seconds": {"median": HOSTILE},
    }  # fmt: skip


@pytest.mark.parametrize("single", [False, True])
def test_texts_in_a_report_are_no_markup(tmp_path: Path, single: bool) -> None:
    source = tmp_path / "in"
    source.mkdir()
    name = "a <script>'&\" b #1%"
    lines = "".join(json.dumps(hostile_record(n)) + "\n" for n in range(3))
    (source / f"{name}.jsonl").write_text(lines, encoding="utf-8")
    finding = {"method": "rk4", "claim": HOSTILE, "verdict": HOSTILE, "witness": HOSTILE,
               "declared": HOSTILE, "value": HOSTILE, "proof": HOSTILE, "residual": HOSTILE}  # fmt: skip
    measured = {"title": HOSTILE, "rows": [{HOSTILE: HOSTILE}], "b": {HOSTILE: {"c": HOSTILE}}}
    documents = {
        "findings": {"format": "glmref-findings-1", "findings": [finding]},
        "<b>x": {"format": "glmref-measurement-1", **measured, HOSTILE: [{HOSTILE: HOSTILE}]},
        "odd": {"format": HOSTILE},
    }
    for stem, content in documents.items():
        (source / f"{stem}.json").write_text(json.dumps(content), encoding="utf-8")
    found = read([source], ["rk4"])
    for path in build(
        found, tmp_path / ("x.html" if single else "site"), single=single, methods=["rk4"]
    ):
        seen = Seen(path.read_text(encoding="utf-8"))
        assert seen.tags.count("script") == 1 and seen.tags.count("style") == 1
        assert not {"img", "iframe", "object", "embed", "form", "base"} & set(seen.tags)
        assert not [key for key in seen.attributes if key.startswith("on")]
    if not single:
        index = (tmp_path / "site" / "index.html").read_text(encoding="utf-8")
        assert f'href="run-{quote(name)}.html"' in index


# --- terminals ------------------------------------------------------------------------------------


@pytest.fixture
def hostile_method(tmp_path: Path) -> Path:
    """A method file with hostile texts wherever a text is free."""
    text = HOSTILE.replace("\ud800", "")
    doc = {**document("rk4"), "name": "mine", "title": text, "notes": [text]}
    doc["source"] = {"citation": text, "where": text, "status": "derived", "doi": text}
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(doc), encoding="utf-8")
    return path


@pytest.mark.parametrize(
    "command",
    [
        ["show"], ["cite"], ["analyze"], ["verify"], ["verify", "--format", "csv"],
        ["verify", "--format", "json"], ["verify", "--format", "junit"],
        ["analyze", "--format", "json"],
    ],
    ids=" ".join,
)  # fmt: skip
def test_a_terminal_gets_no_control_character_of_a_file(hostile_method, command, capsys):
    assert main([*command, str(hostile_method)]) in (0, 1, 2, 3)
    captured = capsys.readouterr()
    assert captured.out and not CONTROLS.search(captured.out + captured.err)


def test_names_of_files_are_shown_without_control_characters(tmp_path: Path, cli) -> None:
    name = str(tmp_path / "a\x1b]0;x\x07\u202eb")
    for command in (["run", f"{name}.toml"], ["verify", f"{name}.json"], ["report", name]):
        captured = cli(*command, code=2)
        assert captured.err.count("\n") == 1 and not CONTROLS.search(captured.err)


@pytest.mark.slow
def test_texts_of_a_scene_reach_no_terminal_and_no_picture(tmp_path: Path, cli) -> None:
    path, text = tmp_path / "tiny.toml", HOSTILE.replace("\ud800", "")
    keys = {"methods": ["rk4"], "steps": [20], "t_end": 1, "ask": ["state", "picture"]}
    path.write_text(scene_text("tiny", title=text, question=text, **keys), encoding="utf-8")
    captured = cli("run", path, "--output", tmp_path / "out")
    assert not CONTROLS.search(captured.out + captured.err)
    for picture in (tmp_path / "out").glob("*.svg"):
        drawn(picture.read_text(encoding="utf-8").replace(DARK, "", 1))  # the one style


# --- exports --------------------------------------------------------------------------------------

#: Texts that would end a comment, continue it on the next line, or be seen as another text.
ENDS = (
    *(
        "*/ int evil; /*", "a\nevil()", "a\revil()", "a\x85evil()", "=# evil() #=",
        '"""\nevil()\n"""',
    ),
    *(
        "*\\ int evil; /\\*", "a\\", "??/", "\x1b[2J", "\u202e", "\u200b", "\ud800", "=cmd()",
        "@SUM(1)", "\x00",
    ),
)  # fmt: skip


@pytest.mark.sampled(60)
@pytest.mark.parametrize("evil", ENDS)
@pytest.mark.parametrize("target", TARGETS)
def test_texts_of_a_file_stay_in_the_comments_of_an_export(target: str, evil: str) -> None:
    given: dict[str, Any] = {
        "A": [["0", "0"], ["1", "0"]],
        "b": ["1/2", "1/2"],
        "class": "rk",
        "title": "text",
        "format": "glmref-method-2",
        "name": "heun",
        "claims": {"order": 2},
        "embedded": [{"name": "first", "b": ["1", "0"]}, {"name": "second", "b": ["0", "1"]}],
        "source": {"citation": "text", "where": "text", "doi": "text", "status": "derived"},
    }

    def lines(text: str) -> list[str]:
        document = json.loads(json.dumps(given).replace('"text"', json.dumps(text)))
        document["embedded"][1]["name"] = text
        return export(load_document(document), to=target).split("\n")

    written, usual = lines(evil), lines("usual")
    assert all(escaped(line) == line for line in written)
    if target not in ("json", "csv"):  # of code, only comments differ, and none ends early
        assert len(written) == len(usual)
        for line, other in zip(written, usual, strict=True):
            assert line == other or not re.search(r"\*/|/\*|=#|#=|\\\\$", line.strip())
    if target == "csv":
        cells = [x for row in csv.reader(io.StringIO("\n".join(written))) for x in row]
        assert not any(x.startswith(("=", "@")) for x in cells)


# --- tables, JUnit and BibTeX ---------------------------------------------------------------------


@pytest.mark.parametrize(
    "text",
    ["=1+1", "@SUM(A1)", "+cmd|' /C calc'!A0", "-2+3+cmd|' /C calc'!A0", "\t=1", "\r=1", "  =1",
     "=HYPERLINK(\"http://x\",\"y\")", "-HYPERLINK(1)", "\uff1d1+1"],
)  # fmt: skip
def test_a_formula_in_a_table_becomes_a_text(text: str) -> None:
    ((cell,),) = csv.reader(io.StringIO(csv_text([[text]])))
    assert cell == f"'{text}".replace("\r", "\n")


@pytest.mark.parametrize("text", ["-1/2", "-sqrt(3)/6", "-5e-16", "+2", "-inf", "-exp(2*pi*i/3)"])
def test_a_number_in_a_table_stays_a_number(text: str) -> None:
    ((cell,),) = csv.reader(io.StringIO(csv_text([[text]])))
    assert cell == text


def test_a_table_has_no_escapes_of_terminals() -> None:
    text = csv_text([[HOSTILE, "two\nlines\tand \x1b[2J"]])
    assert not CONTROLS.search(text) and "\\u001b[2J" in text and "\ud800" not in text
    assert next(csv.reader(io.StringIO(text)))[1] == "two\nlines\tand \\u001b[2J"


def test_a_table_of_findings_has_no_formula() -> None:
    finding = Finding("=1+1", "@x", "=2+2", Verdict.FAILS, "=3+3", witness="=4+4")
    for row in csv.reader(io.StringIO(findings_csv([finding], head=False))):
        assert not [cell for cell in row if cell.startswith(("=", "@"))]


def test_junit_is_xml_whatever_a_file_says() -> None:
    finding = Finding(HOSTILE, HOSTILE, HOSTILE, Verdict.FAILS, HOSTILE, witness=HOSTILE)
    root = ElementTree.fromstring(findings_junit([finding], [(HOSTILE, HOSTILE)]))
    assert {node.tag for node in root.iter()} == {
        "testsuites", "testsuite", "testcase", "failure", "error", "system-out"
    }  # fmt: skip


def test_an_entry_made_of_a_citation_is_one_entry() -> None:
    source = {"citation": HOSTILE, "where": HOSTILE, "status": "derived", "doi": HOSTILE}
    entry = source_entry({"name": "mine", "source": source})
    assert not CONTROLS.search(entry) and "\\input" not in entry
    depth = 0
    for brace in re.findall(r"(?<!\\)[{}]", entry):
        depth += 1 if brace == "{" else -1
        assert depth >= 0
    assert depth == 0 and entry.count("@misc") == 1
