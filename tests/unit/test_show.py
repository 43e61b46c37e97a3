"""Tables and tableaux in a terminal: every format is well formed, what a stream cannot show is not sent."""

import csv
import io
import json
import re
import time
from dataclasses import replace
from xml.etree import ElementTree

import pytest

from glmref.catalogue.lookup import load, names
from glmref.exact.expression import parse
from glmref.findings import Finding, Proof, Verdict
from glmref.method import GLM
from glmref.views.show import show
from glmref.views.tableau_text import tableau
from glmref.views.tables import (
    Style,
    csv_text,
    findings_csv,
    findings_junit,
    findings_table,
    json_text,
    plain,
)

UNICODE = Style(unicode=True, width=100)


def body(name: str, style: Style = UNICODE, decimal: int | None = None) -> str:
    """The tableau alone: the second paragraph."""
    return show(load(name), style=style, decimal=decimal).split("\n\n")[1]


def test_rk4_looks_like_the_tableau_of_the_textbooks() -> None:
    assert body("rk4") == (
        "    0 │   0    0    0    0\n"
        "  1/2 │ 1/2    0    0    0\n"
        "  1/2 │   0  1/2    0    0\n"
        "    1 │   0    0    1    0\n"
        " ─────┼───────────────────\n"
        "      │ 1/6  1/3  1/3  1/6"
    )


def test_a_general_linear_method_is_partitioned_into_its_four_blocks() -> None:
    lines = body("gsymplectic-n", Style()).splitlines()
    assert [line.count("|") for line in lines] == [2, 2, 0, 2, 2]
    assert lines[2].count("+") == 2
    assert re.fullmatch(r" [-+]+", lines[2])
    bars = [[m.start() for m in re.finditer(r"[|+]", x)] for x in lines if "sqrt" not in x]
    assert len({tuple(b) for b in bars}) == 1  # rules and bars stand in the same columns
    assert lines[0].split("|")[1].split() == ["(3-sqrt(3))/6", "0"]


def test_names_of_long_entries_never_clash_with_constants() -> None:
    long = "1+sqrt(2)+sqrt(3)+sqrt(5)+sqrt(7)+sqrt(11)"
    document = {
        "format": "glmref-method-1",
        "name": "it",
        "class": "rk",
        "constants": {"x1": "1/3"},
        "A": [["x1", long], ["0", long]],
        "b": ["1/2", "1/2"],
        "claims": {"order": 1},
        "source": {"citation": "c", "where": "w", "status": "derived"},
    }
    from glmref.catalogue.reader import load_document

    text = show(load_document(document))
    assert f"= {long}" in text
    assert text.count(long) == 1
    assert re.search(r"x1 +│?\|? *", text)
    assert re.search(r"^  x1 +=  ?1/3$|^  x1 = 1/3$", text, re.MULTILINE)


def test_a_pair_shows_both_methods() -> None:
    text = show(load("gsymplectic-n-pair"), style=UNICODE)
    assert "q:  Q = h A f(P) + U q" in text
    assert "p:  P = h A^ k(Q) + U^ p" in text
    assert text.count("┼") == 4 + 2  # two methods, each in four blocks; a start, for q and for p
    assert "and for p:  P = h A^ k(Q) + p0" in text
    assert "D_P =" in text
    assert "D_Q =" in text


@pytest.mark.slow
@pytest.mark.parametrize("decimal", [None, 4])
def test_every_shipped_method_can_be_shown_and_its_rules_line_up(decimal: int | None) -> None:
    wide = replace(UNICODE, width=100_000)  # in one piece
    for name in names("all"):
        text = show(load(name), decimal=decimal, style=wide)
        for part in text.split("\n\n"):
            rules = [line for line in part.splitlines() if line.startswith(" ─")]
            bars = [line for line in part.splitlines() if "│" in line]
            places = {tuple(m.start() for m in re.finditer("[│┼]", x)) for x in (*rules, *bars)}
            assert len(places) <= 1 or "starting" in part, name


def test_every_exact_entry_shown_stands_for_the_entry_itself() -> None:
    method = load("gauss-3")
    assert isinstance(method, GLM)
    rows = body("gauss-3").splitlines()[:3]
    for row, shown in zip(method.A, rows, strict=True):
        cells = shown.split("│")[1].split()
        assert [parse(x) for x in cells] == list(row)


def test_a_hundred_columns_are_drawn_in_parts_at_once() -> None:
    block = [["0.25"] * 100] * 100
    begun = time.thread_time()
    lines = tableau([[block]], Style(width=80))
    assert len(lines) > 600 and lines[0] == "  columns 1 to 13 of 100:"
    assert time.thread_time() - begun < 2  # it took 16 s


# -- tables.py: what a stream cannot show is not sent to it; every format is well formed


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


def test_what_was_not_judged_is_skipped_in_a_conformance_report() -> None:
    text = findings_junit(ALL, program="glmref conformance", undecided="skipped")
    root = ElementTree.fromstring(text)
    opened = sum(x.verdict is Verdict.OPEN for x in ALL)
    assert root.get("name") == "glmref conformance" and root.get("errors") == "0"
    assert opened and root.get("skipped") == str(opened) == str(len(root.findall(".//skipped")))
