"""Remarks about lines of files, as code hosts read them: workflow commands, SARIF, a badge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any
from urllib.parse import quote

from .. import __version__
from .tables import counted, json_text, one_line

_SARIF = "https://json.schemastore.org/sarif-2.1.0.json"


class Level(StrEnum):
    """How serious a remark is; the words are those of SARIF."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


@dataclass(frozen=True, slots=True)
class Remark:
    """What is to be said about a line of a file."""

    path: str  #: File, seen from the root of the repository, with ``/`` between folders.
    line: int  #: Line, counted from 1.
    #: An error is a claim that fails, a warning a question or what is open, a note what could not
    #: be read.
    level: Level
    rule: str  #: What was checked: ``order``, ``embedded``, ``table``, ..
    message: str  #: One sentence.


def text(remarks: Sequence[Remark]) -> str:
    """Write remarks as compilers do, one on each line."""
    return "\n".join(f"{x.path}:{x.line}: {x.level}: {one_line(x.message)}" for x in remarks)


def github(remarks: Sequence[Remark]) -> str:
    """Write remarks as workflow commands of GitHub, which annotate the lines."""
    return "\n".join(
        f"::{'notice' if x.level is Level.NOTE else x.level} file={_property(x.path)},"
        f"line={x.line},title=glmref {_property(x.rule)}::{_data(one_line(x.message))}"
        for x in remarks
    )


def _data(value: str) -> str:
    return value.replace("%", "%25").replace("\r", "%0D").replace("\n", "%0A")


def _property(value: str) -> str:
    return _data(value).replace(":", "%3A").replace(",", "%2C")


def sarif(remarks: Sequence[Remark]) -> str:
    """Write remarks as a log of SARIF 2.1.0."""
    rules = sorted({x.rule for x in remarks})
    results: list[dict[str, Any]] = [
        {
            "ruleId": x.rule,
            "ruleIndex": rules.index(x.rule),
            "level": str(x.level),
            "message": {"text": one_line(x.message)},
            "locations": [
                {
                    "physicalLocation": {
                        "artifactLocation": {"uri": quote(x.path), "uriBaseId": "%SRCROOT%"},
                        "region": {"startLine": x.line},
                    }
                }
            ],
        }
        for x in remarks
    ]
    driver = {
        "name": "glmref",
        "version": __version__,
        "rules": [
            {"id": x, "shortDescription": {"text": f"{x} of a tableau, checked exactly"}}
            for x in rules
        ],
    }
    run = {"tool": {"driver": driver}, "columnKind": "unicodeCodePoints", "results": results}
    return json_text({"$schema": _SARIF, "version": "2.1.0", "runs": [run]})


def badge(tables: int, remarks: Sequence[Remark]) -> str:
    """Write the answer of a shields.io endpoint: tables that were judged and what was found."""
    wrong = {(x.path, x.line) for x in remarks if x.level is Level.ERROR}
    unsure = {(x.path, x.line) for x in remarks if x.level is not Level.ERROR}
    if wrong:
        message, color = f"{len(wrong)} wrong", "red"
    elif unsure:
        message, color = f"{len(unsure)} undecided", "yellow"
    elif tables:
        message, color = f"{counted(tables, 'table')} checked", "brightgreen"
    else:
        message, color = "no table", "lightgrey"
    return json_text({"schemaVersion": 1, "label": "tableaux", "message": message, "color": color})
