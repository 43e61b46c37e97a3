"""What ``glmref verify`` decided, kept for the next time, so that the same question costs nothing.

An entry answers one question: these bytes, under this name, these claims, this budget, asked of
this code with these libraries. It is taken only where all of that is the same, where every file
that was read for it still has the bytes that were read, and where its own checksum holds; anything
else is computed again. What is open is not kept: more time may decide it.
"""

from __future__ import annotations

import hashlib
import json
import platform
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

from ..catalogue.lookup import is_shipped, path_of
from ..errors import GlmrefError
from ..exact import LIBRARY
from ..findings import Finding, Verdict
from ..system.cache import private_folder, read_value, sources, write_value
from ..system.files import read_bytes

FORMAT = "glmref-kept-findings-1"
#: What a verdict is computed by: subpackages and modules of the package.
SUBPACKAGES = (
    "judge",
    "errors.py",
    "findings.py",
    "system",
    "exact",
    "method",
    "catalogue",
    "theory",
    "prove",
    "views/tables.py",
)
MOST = 1 << 22  # bytes of a file that is looked at


class Question(NamedTuple):
    """What is asked, as it is written into the entry; and the path of the file."""

    asked: Mapping[str, Any]
    path: Path

    @property
    def entry(self) -> Path | None:
        """The file of the answer. Another version of the program writes over it."""
        folder = private_folder("verdicts")
        own = {k: v for k, v in self.asked.items() if k not in ("code", "versions")}
        name = hashlib.sha256(json.dumps(own, sort_keys=True).encode()).hexdigest()[:32]
        return None if folder is None else folder / f"{name}.json"


def question(name: str | Path, only: Sequence[str], budget: float | None) -> Question | None:
    """Return what is asked of a file; ``None`` for one that cannot be read.

    Parameters
    ----------
    name : str or Path
        A shipped name or a path.
    only : sequence of str
        Keys of the claims to check; all where it is empty.
    budget : float or None
        Seconds of processor time, as requested.
    """
    try:
        path = path_of(name)
        asked = {
            "name": path.name,
            "sha256": _digest(path),
            "only": sorted(set(only)),
            "budget": budget,
            "shipped": is_shipped(path),  # without a budget unless asked for
            "code": sources(*SUBPACKAGES),
            "versions": [LIBRARY, sys.version, sys.platform, platform.machine()],
        }
    except (GlmrefError, OSError):  # said in a sentence by who reads it next
        return None
    return Question(asked, path)


def _digest(path: Path) -> str:
    return hashlib.sha256(read_bytes(path, MOST)).hexdigest()


def look_up(question: Question) -> list[Finding] | None:
    """Return the findings that were kept for a question.

    The result is ``None`` where they have to be computed.
    """
    path = question.entry
    if path is None:
        return None
    try:
        entry = read_value(path)
        if entry["format"] != FORMAT or entry["asked"] != question.asked:
            return None
        if any(_digest(Path(name)) != seen for name, seen in entry["read"].items()):
            return None
        found = [Finding.from_json(row) for row in entry["findings"]]
    except (GlmrefError, OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError):
        return None
    return None if any(x.verdict is Verdict.OPEN for x in found) else found


def keep_findings(question: Question, read: Mapping[str, str], findings: list[Finding]) -> None:
    """Keep what was decided, where there is a folder for it.

    Parameters
    ----------
    question : Question
        What was asked.
    read : mapping
        Path -> checksum of every file that was read to answer it.
    findings : list of Finding
        The answer, in plain values.
    """
    if read.get(str(question.path)) != question.asked["sha256"]:
        return  # the file has changed since the question was asked
    if any(x.verdict is Verdict.OPEN for x in findings):
        return
    path = question.entry
    if path is None:
        return
    others = {name: seen for name, seen in read.items() if name != str(question.path)}
    rows = [x.as_json() for x in findings]
    entry = {"format": FORMAT, "asked": question.asked, "read": others, "findings": rows}
    with suppress(TypeError, ValueError, KeyError):
        if [Finding.from_json(row) for row in json.loads(json.dumps(rows))] == findings:
            write_value(path, entry)
