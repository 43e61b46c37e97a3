"""All tableaux of a repository, in method files and in sources, as remarks about lines."""

from __future__ import annotations

import re
import subprocess
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..catalogue.files import document
from ..catalogue.keys import is_plain
from ..errors import BudgetError, DataError, GlmrefError, UsageError
from ..findings import Finding, Verdict
from ..views.sarif import Level, Remark
from .check import sentence
from .lexer import ENDINGS
from .sources import audit, may_be_source, read_source

#: Files that hold one tableau each.
_TABLEAUX = (".json", ".toml")
#: Keys that only a tableau has together.
_KEYS = (("A", "b"), ("A", "B"), ("A_hat", "b"), ("alpha", "beta"), ("alpha", "gamma"), ("parts",))
_ENTRY = re.compile(r"\b(\w+)((?:\[\d+\])+) is (\S+) and should be")
#: A statement that hands arrays to what uses them, and is no head of a table.
_CALL = re.compile(
    r"\s*(?!ARK_BUTCHER_TABLE)(?:PetscCall|TS\w*Register|[\w.]+\s*=|[\w.]*[a-z_]\w*\()"
)
_PLACE = re.compile(r"\bline (\d+)\b")
_LEVELS = {"wrong": Level.ERROR, "question": Level.WARNING, "unread": Level.NOTE}

#: Lines of a file, as half-open ranges.
Lines = Sequence[tuple[int, int]]


@dataclass
class Linted:
    """What was found in a repository.

    Attributes
    ----------
    tables : int
        How many tables were judged.
    remarks : list of Remark
        In the order of files and lines.
    """

    tables: int = 0
    remarks: list[Remark] = field(default_factory=list)


def lint(
    places: Sequence[Path],
    root: Path,
    examine: Callable[[str], list[Finding]],
    changed: Mapping[str, Lines] | None = None,
    *,
    notes: bool = False,
) -> Linted:
    """Check all tableaux in files and folders.

    Parameters
    ----------
    places : Sequence of Path
        Files and folders. In a folder, what begins with a dot is left out.
    root : Path
        Paths of remarks are seen from here.
    examine : callable
        Findings about a file that holds one tableau.
    changed : Mapping, optional
        Lines that were changed, by path from the root: only tables that have some are judged.
    notes : bool
        Whether a table that could not be read gives a remark; a class may only look like one.

    Returns
    -------
    Linted

    Raises
    ------
    UsageError
        For a place that is not there.
    """
    found = Linted()
    for place in places:
        files = [x for x in _files(place) if changed is None or _name(x, root) in changed]
        own = [x for x in files if x.suffix in _TABLEAUX and _is_tableau(x)]
        for path in own:
            found.tables += 1
            found.remarks += _of_file(path, _name(path, root), examine)
        mine = [x for x in files if x.suffix in ENDINGS and may_be_source(x) and x not in own]
        if mine:
            _of_sources(place, mine, root, changed, found)
    unique = {(x.path, x.line, x.message): x for x in found.remarks}
    read = {(x.path, x.line) for x in found.remarks if x.level is not Level.NOTE}
    found.remarks = sorted(
        (
            x
            for x in unique.values()
            if x.level is not Level.NOTE or (notes and (x.path, x.line) not in read)
        ),
        key=lambda x: (x.path, x.line),
    )
    return found


def _files(place: Path) -> list[Path]:
    """Return a file, or the files of a folder without those of hidden folders."""
    if place.is_file():
        return [place]
    if not place.is_dir():
        raise UsageError(f"{place} is no file and no folder; give files or folders to check")
    return [
        x
        for x in sorted(place.rglob("*"))
        if not any(part.startswith(".") for part in x.relative_to(place).parts)
        and not x.is_symlink()
        and x.is_file()
    ]


def _name(path: Path, root: Path) -> str:
    """Return a path as it is seen from the root."""
    whole, base = path.resolve(), root.resolve()
    return (whole.relative_to(base) if whole.is_relative_to(base) else path).as_posix()


def _is_tableau(path: Path) -> bool:
    """Return whether a JSON or TOML file is a method file, or has the keys of a plain tableau."""
    try:
        given = document(str(path))
    except DataError:
        text = read_source(path, "json") or ""
        keys = any(len(x) > 1 and all(f'"{key}"' in text for key in x) for x in _KEYS)
        return text.lstrip().startswith("{") and (keys or '"glmref-method-' in text)
    if not is_plain(given):
        return str(given.get("format", "")).startswith("glmref-method-")
    return any(all(isinstance(given.get(key), list) for key in keys) for keys in _KEYS)


def _of_file(path: Path, name: str, examine: Callable[[str], list[Finding]]) -> Iterator[Remark]:
    """Check one tableau; what holds gives no remark."""
    text = read_source(path, path.suffix) or ""
    try:
        findings = examine(str(path))
    except GlmrefError as error:
        said = str(error)
        unsure = isinstance(error, BudgetError) or "nothing is said" in said
        level = Level.WARNING if unsure else Level.ERROR
        place = _PLACE.search(said)
        yield Remark(name, int(place[1]) if place else 1, level, "file", said)
        return
    for x in findings:
        if x.verdict is not Verdict.HOLDS:
            level = Level.ERROR if x.verdict is Verdict.FAILS else Level.WARNING
            line = _line_of(text, x.witness) or _line_of_claim(text, x.claim)
            yield Remark(name, line, level, x.claim.partition(" ")[0], sentence(x))


def _of_sources(
    place: Path,
    mine: Collection[Path],
    root: Path,
    changed: Mapping[str, Lines] | None,
    found: Linted,
) -> None:
    """Judge the tables of sources, as `glmref audit` without a format does."""
    base = place if place.is_dir() else place.parent
    rows = [
        (base / x["path"], x)
        for x in audit(place, wanted=mine)
        if not (x["status"] == "unread" and x["line"] == 1)  # a file that holds none
    ]
    for path, record in rows:
        name, lines = _name(path, root), (read_source(path) or "").splitlines()
        others = [x["line"] for other, x in rows if other == path]
        begin, end = _extent(lines, record["line"], others)
        if changed is not None and not any(a < end and begin < b for a, b in changed[name]):
            continue
        found.tables += record["status"] != "unread"
        level = _LEVELS.get(record["status"])
        if level is None:
            continue
        said = described(record)
        at = _line_of("\n".join(lines[begin - 1 : end - 1]), said)
        line = record["line"] if at is None else begin - 1 + at
        found.remarks.append(Remark(name, line, level, "table", said))


def _extent(lines: Sequence[str], line: int, others: Sequence[int]) -> tuple[int, int]:
    """Return the lines that a table may stand on, as a half-open range.

    A reader gives the line of the head of a table, or of the call that uses its arrays. Behind a
    head all lines to the next table are its own; arrays stand before the call, from the table
    before it on.
    """
    end = min((x for x in others if x > line), default=len(lines) + 1)
    if not _CALL.match(lines[line - 1]):
        return line, end
    begin = max((x + 1 for x in others if x < line), default=1)
    ends = line + lines[line - 1].count("(") - lines[line - 1].count(")")
    return begin, line + 1 if ends <= line else end


def described(record: Mapping[str, Any]) -> str:
    """Say what is wrong with a table, from its record."""
    parts = []
    if record.get("declared") is not None and record.get("found") is not None:
        parts.append(f"order {record['found']}, declared is {record['declared']}")
    parts += [
        f"{x['entry']} is {x['is']} and should be {x['should be']}"
        for x in record.get("correction", ())
    ]
    parts += record.get("remarks", ())
    return f"{record['name']}: " + "; ".join(parts or [str(record["status"])])


def _line_of(text: str, said: str) -> int | None:
    """Return the line of the entry that a sentence calls wrong, or ``None``."""
    entry = _ENTRY.search(said)
    if entry is None:
        return None
    indices = [int(x) - 1 for x in re.findall(r"\d+", entry[2])]
    for key in dict.fromkeys((entry[1], entry[1].upper())):
        for start in re.finditer(rf"(?<!\w){key}\b(?:\[[^\]]*\])*[\"']?\s*[:=]", text):
            at = _position(text, start.end(), indices)
            if at is not None:
                return text.count("\n", 0, at) + 1
    value = re.escape(entry[3].rstrip(","))
    lines = [
        number
        for number, line in enumerate(text.splitlines(), 1)
        if re.search(rf"(?<![\w./-]){value}(?![\w./])", line)
    ]
    return lines[0] if len(lines) == 1 else None


def _position(text: str, start: int, indices: Sequence[int]) -> int | None:
    """Return where the element with these indices stands in the brackets that follow a place."""
    counts: list[int] = []
    opened = False
    for at in range(start, len(text)):
        c = text[at]
        if c in "[{":
            counts.append(0)
            opened = True
        elif c in "]}":
            counts.pop()
        elif c == "," and counts:
            counts[-1] += 1
        elif opened and counts == list(indices) and not c.isspace():
            return at
        elif not opened and c in "\n;":
            return None
        if opened and not counts:
            return None
    return None


def _line_of_claim(text: str, claim: str) -> int:
    """Return the line of the key of a claim, or that of ``claims``, or 1."""
    words = (claim, claim.rpartition(" of ")[0], "embedded" if "embedded" in claim else "order")
    for key in (*filter(None, words), "claims"):
        found = re.search(rf"(?m)^[^\n]*?(?<!\w){re.escape(key)}\b[\"']?\s*[:=]", text)
        if found:
            return text.count("\n", 0, found.end()) + 1
    return 1


def changed_since(root: Path, commit: str) -> dict[str, Lines]:
    """Return the lines that differ from a commit, by path.

    Parameters
    ----------
    root : Path
        A folder of the checkout.
    commit : str
        A name of a commit. Lines are compared with it as they stand in the working tree.

    Raises
    ------
    UsageError
        Where git is missing, the folder is no checkout, or the commit is unknown.
    """
    known = _git(root, "rev-parse", "--verify", "--quiet", "--end-of-options", commit + "^{commit}")
    if not known.strip():
        raise UsageError(f"--since {commit}: no such commit here; fetch it first (`git fetch`)")
    shown = _git(
        root, "-c", "core.quotepath=off", "diff", "--unified=0", "--no-color", "--no-ext-diff",
        "--no-renames", "--relative", "--no-prefix", known.strip(), "--", ".",
    )  # fmt: skip
    found: dict[str, Lines] = {}
    here: list[tuple[int, int]] = []
    for line in shown.splitlines():
        if line.startswith("+++ "):
            here = []
            if line != "+++ /dev/null":
                found[line[4:].rstrip("\t").strip('"')] = here
        elif hunk := re.match(r"@@ -\S+ \+(\d+)(?:,(\d+))? @@", line):
            first, count = int(hunk[1]), int(hunk[2] or 1)
            # where lines are only taken out, the two beside the gap are changed
            here.append((first, first + (count or 2)))
    return found


def _git(root: Path, *words: str) -> str:
    """Run git in a folder; nothing where the answer is no."""
    with suppress(FileNotFoundError):
        done = subprocess.run(
            ["git", *words], cwd=root, capture_output=True, text=True, check=False,
            encoding="utf-8", errors="replace",
        )  # fmt: skip
        if done.returncode == 128:
            raise UsageError(f"--since: git cannot answer here ({done.stderr.strip()})")
        return done.stdout
    raise UsageError("--since needs git, which is not installed")
