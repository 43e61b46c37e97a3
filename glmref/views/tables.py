"""Findings and lists as text: plain terminal tables, JSON, CSV and JUnit XML.

Nothing here computes; no numerics are imported. What a terminal cannot show is not sent to it:
colour only to a terminal and never against ``NO_COLOR``, line-drawing characters only where the
stream's encoding has them, control characters of foreign files never.
"""

from __future__ import annotations

import csv
import io
import json
import math
import os
import re
import shutil
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TextIO
from xml.etree import ElementTree

from ..findings import Finding, Proof, Verdict, summarize
from ..system.terminal import escaped

FORMATS = ("table", "json", "csv", "junit")
FIELDS = ("method", "claim", "declared", "verdict", "value", "proof", "residual", "witness")
_COLORS = {"red": "31", "green": "32", "yellow": "33", "bold": "1", "dim": "2"}
_VERDICT_COLOR = {Verdict.HOLDS: "green", Verdict.FAILS: "red", Verdict.OPEN: "yellow"}
_RULES = "─│┼"
_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: How a cell begins that a spreadsheet carries out, full-width forms included.
_FORMULA = ("=", "+", "-", "@", "\t", "\r", "\n", "\uff1d", "\uff0b", "\uff0d", "\uff20")
#: What begins so and is harmless: a number, or an expression in numbers.
_ARITHMETIC = re.compile(
    r"[-+](?:[0-9.,*/^()+\- ]|[eE](?=[-+0-9])|sqrt|root|sin|cos|tan|exp|log|pi|inf|nan|i\b)*"
)
MAX_LINE = 700  # characters of one line; longer messages hold somebody's data


@dataclass(frozen=True, slots=True)
class Style:
    """What a stream can show."""

    unicode: bool = False  #: Whether line-drawing characters can be encoded.
    color: bool = False  #: Whether ANSI colours are wanted.
    width: int = 100  #: Columns to wrap prose at.

    @classmethod
    def of(cls, stream: TextIO, environ: Mapping[str, str] | None = None) -> Style:
        """Find out what a stream can show. See https://no-color.org for ``NO_COLOR``."""
        environ = os.environ if environ is None else environ
        try:
            _RULES.encode(getattr(stream, "encoding", None) or "ascii")
            able = True
        except (UnicodeEncodeError, LookupError):
            able = False
        terminal = stream.isatty()
        quiet = environ.get("NO_COLOR") or environ.get("TERM") == "dumb"
        width = shutil.get_terminal_size((100, 24)).columns if terminal else 100
        return cls(unicode=able, color=terminal and not quiet, width=max(width, 40))

    def paint(self, text: str, color: str) -> str:
        """Colour a text where colours are wanted."""
        return f"\x1b[{_COLORS[color]}m{text}\x1b[0m" if self.color else text

    @property
    def rules(self) -> tuple[str, str, str]:
        """Horizontal rule, vertical rule and crossing."""
        return ("─", "│", "┼") if self.unicode else ("-", "|", "+")


def one_line(text: object, *, limit: int = MAX_LINE) -> str:
    """Return any text as one printable line: line ends become spaces, controls are escaped."""
    joined = re.sub(r"[ \t\r\n]+", " ", str(text)).strip()
    safe = escaped(joined)
    return safe if len(safe) <= limit else safe[: limit - 3] + "..."


def counted(n: int, what: str) -> str:
    """Return a number and its noun, whose plural has an s."""
    return f"{n} {what}" if n == 1 else f"{n} {what}s"


def columns(rows: Iterable[Sequence[str]], *, style: Style, head: Sequence[str] = ()) -> str:
    """Align rows into columns, two spaces apart, the last column as long as it is.

    The style decides the rule under the head.
    """
    cells = [[one_line(x) for x in row] for row in rows]
    everything = [list(head), *cells] if head else cells
    if not everything:
        return ""
    widths = [max(len(row[j]) for row in everything) for j in range(len(everything[0]))]

    def line(row: Sequence[str]) -> str:
        return "  ".join(x.ljust(w) for x, w in zip(row, widths, strict=True)).rstrip()

    lines = [line(row) for row in cells]
    if head:
        rule = "  ".join(style.rules[0] * w for w in widths)[: style.width]
        lines = [style.paint(line(head), "bold"), style.paint(rule, "dim"), *lines]
    return "\n".join(lines)


def plain(value: Any) -> Any:
    """Return a value with nothing in it that strict JSON lacks: no NaN, no infinity, no tuple."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    if isinstance(value, Mapping):
        return {str(key): plain(x) for key, x in value.items()}
    if isinstance(value, list | tuple):
        return [plain(x) for x in value]
    return str(value) if isinstance(value, str) else value


def json_text(document: object) -> str:
    """Write a document as strict JSON, in ASCII, so that every stream and parser takes it."""
    return json.dumps(plain(document), indent=2, allow_nan=False)


def shown_value(value: object) -> str:
    """Return a declared or found value as a person writes it."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if value is None:
        return "not decided"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(shown_value(x) for x in value) + "]"
    if isinstance(value, Mapping):
        return ", ".join(f"{one_line(name)} {_order(x)}" for name, x in value.items())
    return one_line(value)


def _order(value: object) -> str:
    """Return an order by name, with the residual's size where there is one."""
    if isinstance(value, list | tuple) and len(value) == 2:
        return " to ".join(map(shown_value, value))
    return shown_value(value)


def tally(findings: Sequence[Finding], files: int) -> str:
    """Return the last line of a table: how many hold, fail and are open, and by which proof."""
    counts = summarize(list(findings))
    proofs = ", ".join(f"{sum(f.proof is p for f in findings)} {p}" for p in Proof)
    what = f"{counts['holds']} hold, {counts['fails']} fail, {counts['open']} open"
    return f"{counted(len(findings), 'claim')} of {counted(files, 'file')}: {what} ({proofs})"


def _sentence(finding: Finding) -> str:
    """Return claim, values and witness of one finding as one phrase."""
    declared, found = shown_value(finding.declared), shown_value(finding.value)
    if finding.verdict is Verdict.HOLDS and not finding.claim.startswith("refutes "):
        return declared
    more = finding.witness not in ("", f"found {found}")
    because = f"; {finding.witness}" if more else ""
    if finding.value is None and finding.verdict is not Verdict.OPEN and because:
        return one_line(f"declared {declared}{because}")  # the reason says what was found
    return one_line(f"declared {declared}, found {found}{because}")


def _marks(verdict: Verdict, proof: str, style: Style) -> str:
    word = str(verdict) if verdict is Verdict.HOLDS else str(verdict).upper()
    return f"  {style.paint(word.ljust(5), _VERDICT_COLOR[verdict])}  {proof:<8}"


def finding_rows(findings: Sequence[Finding], *, style: Style, indent: int = 0) -> list[str]:
    """Return one line for each finding: verdict, proof, claim, and the value or what is wrong."""
    width = max((len(f.claim) for f in findings), default=0)
    return [
        f"{' ' * indent}{_marks(f.verdict, str(f.proof), style)}  "
        f"{one_line(f.claim):<{width}}  {_sentence(f)}"
        for f in findings
    ]


def findings_table(
    findings: Sequence[Finding], *, style: Style, every: bool = True, width: int = 0
) -> str:
    """Return the findings of one method.

    With ``every`` a line for each claim under the method's name; else one line for the method, with
    its name in so many columns, while all hold, and below it those that do not.
    """
    if not findings:
        return ""
    name = one_line(findings[0].method)
    if every:
        return "\n".join([style.paint(name, "bold"), *finding_rows(findings, style=style)])
    wrong = [f for f in findings if f.verdict is not Verdict.HOLDS]
    if len(findings) == 1:
        only = findings[0]
        marks = _marks(only.verdict, str(only.proof), style)
        return f"{marks}  {name:<{width}}  {one_line(only.claim)}: {_sentence(only)}"
    worst = max(
        (f.verdict for f in findings), key=[Verdict.HOLDS, Verdict.OPEN, Verdict.FAILS].index
    )
    proofs = [p for p in Proof if any(f.proof is p for f in findings)]
    head = f"{_marks(worst, str(proofs[-1]), style)}  {name:<{width}}  {len(findings)} claims"
    return "\n".join([head, *finding_rows(wrong, style=style, indent=2)])


def findings_json(findings: Sequence[Finding]) -> str:
    """Return the ``glmref-findings-1`` document."""
    return json_text(
        {
            "format": "glmref-findings-1",
            "findings": [f.as_json() for f in findings],
            "summary": summarize(list(findings)),
        }
    )


def findings_csv(findings: Sequence[Finding], *, head: bool = True) -> str:
    """Return rows of comma-separated values; lists are JSON texts, true and false as in JSON."""
    rows = [plain(finding.as_json()) for finding in findings]
    return csv_text([*([FIELDS] if head else []), *([row[k] for k in FIELDS] for row in rows)])


def csv_text(rows: Iterable[Sequence[object]]) -> str:
    """Return rows as comma-separated values; what is no text is written as JSON writes it.

    A text that a spreadsheet would carry out as a formula gets an apostrophe before it, which
    makes it a text there; a number, and an expression in numbers such as ``-sqrt(3)/6``, has none.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    for row in rows:
        writer.writerow([_cell(x) if isinstance(x, str) else json.dumps(plain(x)) for x in row])
    return stream.getvalue().rstrip("\n")


def _cell(text: str) -> str:
    """Return a text as a cell of a spreadsheet: one kind of line ends, controls escaped."""
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    text = "".join(x if x in "\n\t" else escaped(x) for x in re.split("([\n\t])", text))
    if text.lstrip(" ").startswith(_FORMULA) and not _ARITHMETIC.fullmatch(text):
        return f"'{text}"
    return text


def csv_value(cell: str) -> str:
    """Return the text that :func:`csv_text` wrote as a cell."""
    return cell[1:] if cell[:1] == "'" and cell[1:].lstrip(" ").startswith(_FORMULA) else cell


def findings_junit(
    findings: Sequence[Finding],
    errors: Sequence[tuple[str, str]] = (),
    *,
    program: str = "glmref verify",
    undecided: str = "error",
) -> str:
    """Return JUnit XML: a suite for each method, a case for each claim.

    What fails becomes a ``failure``, what is open what ``undecided`` says: ``"error"`` where every
    claim should be decided, ``"skipped"`` for what was not judged. ``errors`` are (file, sentence)
    for each file that could not be checked: an ``error`` too.
    """
    root = ElementTree.Element("testsuites", name=program)
    suites: dict[str, list[Finding]] = {}
    for finding in findings:
        suites.setdefault(finding.method, []).append(finding)
    for method, rows in suites.items():
        suite = _suite(root, method, len(rows))
        for finding in rows:
            _case(suite, finding, undecided)
    for file, sentence in errors:
        suite = _suite(root, file, 1)
        case = ElementTree.SubElement(suite, "testcase", classname=_xml(file), name="load")
        ElementTree.SubElement(case, "error", message=_xml(sentence))
    counted = [("failure", "failures"), ("error", "errors")]
    counted += [("skipped", "skipped")] * (undecided == "skipped")
    for element in (*root, root):
        for kind, key in counted:
            element.set(key, str(len(list(element.iter(kind)))))
    root.set("tests", str(len(list(root.iter("testcase")))))
    ElementTree.indent(root)
    return (
        '<?xml version="1.0" encoding="utf-8"?>\n' + ElementTree.tostring(root, "us-ascii").decode()
    )


def _suite(root: ElementTree.Element, name: str, tests: int) -> ElementTree.Element:
    return ElementTree.SubElement(root, "testsuite", name=_xml(name), tests=str(tests))


def _case(suite: ElementTree.Element, finding: Finding, undecided: str) -> None:
    case = ElementTree.SubElement(
        suite, "testcase", classname=_xml(finding.method), name=_xml(finding.claim)
    )
    if finding.verdict is not Verdict.HOLDS:
        kind = "failure" if finding.verdict is Verdict.FAILS else undecided
        wrong = ElementTree.SubElement(case, kind, message=_xml(_sentence(finding)))
        if kind != "skipped":  # which has no type
            wrong.set("type", str(finding.verdict))
    ElementTree.SubElement(case, "system-out").text = _xml(
        f"proof: {finding.proof}; residual: {finding.residual:g}"
    )


def _xml(text: str) -> str:
    """Drop what XML 1.0 cannot hold."""
    return _NOT_XML.sub("?", text)
