"""tables.py: what a stream cannot show is not sent to it; every format is well formed."""

from __future__ import annotations

import csv
import io
import json
from xml.etree import ElementTree

import pytest

from glmref.findings import Finding, Proof, Verdict
from glmref.views.tables import (
    Style,
    columns,
    csv_text,
    findings_csv,
    findings_junit,
    findings_table,
    json_text,
    one_line,
    plain,
    shown_value,
)

GOOD = Finding("m", "order", 4, Verdict.HOLDS, 4)
BAD = Finding("m", "symmetric", True, Verdict.FAILS, False, Proof.ENCLOSED, 0.5, "entry (1, 2)")
OPEN = Finding("n", "a-stable", True, Verdict.OPEN, None, Proof.MEASURED, float("inf"))
REFUTED = Finding("b", "refutes order", 5, Verdict.HOLDS, 1, witness="tree [o] of order 2")
ALL = [GOOD, BAD, OPEN, REFUTED]


class Stream(io.StringIO):
    """A stream with an encoding that may be a terminal."""

    def __init__(self, encoding: str, *, terminal: bool) -> None:
        super().__init__()
        self.kind, self.terminal = encoding, terminal

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return self.kind

    def isatty(self) -> bool:
        return self.terminal


def test_colour_is_for_terminals_and_never_against_no_color() -> None:
    terminal, pipe = Stream("utf-8", terminal=True), Stream("utf-8", terminal=False)
    assert Style.of(terminal, {}).color
    assert not Style.of(pipe, {}).color
    assert not Style.of(terminal, {"NO_COLOR": "1"}).color
    assert Style.of(terminal, {"NO_COLOR": ""}).color  # empty is not set, says no-color.org
    assert not Style.of(terminal, {"TERM": "dumb"}).color
    assert Style(color=True).paint("x", "red") == "\x1b[31mx\x1b[0m"
    assert Style().paint("x", "red") == "x"


def test_columns_are_aligned_and_the_last_is_free() -> None:
    text = columns([["a", "1", "x y"], ["bbb", "22", ""]], style=Style(), head=["h", "n", "t"])
    assert text.splitlines() == ["h    n   t", "---  --  ---", "a    1   x y", "bbb  22"]
    assert columns([["a", "1"], ["b", "22"]], style=Style(), right="1") == "a   1\nb  22"
    assert columns([], style=Style()) == ""


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("a\nb\r\n c", "a b c"),
        ("\x1b[31mred", "\\u001b[31mred"),
        ("a\u202eb", "a\\u202eb"),
        ("a\x00", "a\\u0000"),
        ("\ud800", "\\ud800"),
        ("Nørsett ü", "Nørsett ü"),
        (3, "3"),
    ],
)
def test_any_text_becomes_one_printable_line(text: object, line: str) -> None:
    assert one_line(text) == line
    assert one_line(text).isprintable()


def test_json_is_strict_and_ascii() -> None:
    text = json_text({"a": [float("nan"), float("inf"), 1.5], "b": ("ü",), 3: Verdict.HOLDS})
    assert json.loads(text) == {"a": [None, None, 1.5], "b": ["ü"], "3": "holds"}
    assert text.isascii()
    assert plain((1, "a", None, True)) == [1, "a", None, True]


def test_csv_reads_back_row_by_row() -> None:
    awkward = Finding("m", "growth", ["1/2", "0"], Verdict.FAILS, [], witness='say "no", \n then')
    rows = list(csv.DictReader(io.StringIO(findings_csv([*ALL, awkward]))))
    assert len(rows) == 5
    assert rows[0]["declared"] == "4"
    assert rows[1]["declared"] == "true"
    assert rows[2]["value"] == "null"
    assert rows[4]["declared"] == '["1/2", "0"]'
    assert rows[4]["witness"] == 'say "no", \n then'
    assert findings_csv(ALL, head=False).count("\n") == 3
    assert csv_text([["a", 1]]) == "a,1"


def test_junit_counts_failures_and_errors_by_suite() -> None:
    text = findings_junit(ALL, [("bad\x00file.json", "it <is> & was\x1b")])
    root = ElementTree.fromstring(text)
    assert root.attrib == {"name": "glmref verify", "tests": "5", "failures": "1", "errors": "2"}
    suites = {s.get("name"): s for s in root}
    assert set(suites) == {"m", "n", "b", "bad?file.json"}
    assert (suites["m"].get("tests"), suites["m"].get("failures")) == ("2", "1")
    assert suites["n"].get("errors") == "1"
    (failure,) = suites["m"].iter("failure")
    assert failure.get("message") == "declared yes, found no; entry (1, 2)"
    assert text.isascii()


def test_table_with_a_line_for_each_claim_says_verdict_proof_and_witness() -> None:
    assert findings_table([GOOD, BAD], style=Style()).splitlines() == [
        "m",
        "  holds  exact     order      4",
        "  FAILS  enclosed  symmetric  declared yes, found no; entry (1, 2)",
    ]
    assert findings_table([], style=Style()) == ""


def test_table_with_a_line_for_each_method_shows_what_does_not_hold() -> None:
    assert findings_table([GOOD, BAD], style=Style(), every=False, width=4).splitlines() == [
        "  FAILS  enclosed  m     2 claims",
        "    FAILS  enclosed  symmetric  declared yes, found no; entry (1, 2)",
    ]
    good = findings_table([GOOD, GOOD], style=Style(), every=False)
    assert good == "  holds  exact     m  2 claims"
    one = findings_table([REFUTED], style=Style(), every=False)
    assert one == ("  holds  exact     b  refutes order: declared 5, found 1; tree [o] of order 2")


def test_orders_by_name_are_written_out() -> None:
    assert shown_value({"b": [10, "2.7e-85"], "low": [8, "1.0e-9"]}) == (
        "b 10 to 2.7e-85, low 8 to 1.0e-9"
    )
    assert shown_value({"third": 3, "other": None}) == "third 3, other not decided"


def test_what_was_not_judged_is_skipped_in_a_conformance_report() -> None:
    text = findings_junit(ALL, program="glmref conformance", undecided="skipped")
    root = ElementTree.fromstring(text)
    opened = sum(x.verdict is Verdict.OPEN for x in ALL)
    assert root.get("name") == "glmref conformance" and root.get("errors") == "0"
    assert opened and root.get("skipped") == str(opened) == str(len(root.findall(".//skipped")))
