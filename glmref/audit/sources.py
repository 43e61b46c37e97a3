"""An audit: every table of a checkout, one record each; nothing stops it."""

from __future__ import annotations

import itertools
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

from ..compute import Executor, in_order
from ..compute.executors import Here
from ..errors import DataError, GlmrefError, UsageError
from ..system.budget import PROVING, limited, rarely_collected
from ..system.files import named_in
from .constants import constants_of, may_hold_constants
from .data_files import FORMS, as_source
from .entries import OF_FLOWS, of_subject
from .known import may_hold_known, records
from .lexer import ENDINGS, FIXED, LANGUAGES, ROWS, Language, language_of
from .literals import mended
from .nearest_method import Library
from .readers import FORMATS, SUFFIXES, completed_entries, declared_orders, read
from .recognising import key_of, may_hold, tables
from .table import STEP, Table
from .table_verdicts import judge
from .values import Unread, accident

FORMAT = "glmref-audit-1"
#: Of one line of the output.
LINE = "glmref-audited-table-1"
#: A file without any of these holds no table of the format.
_MARKS: Mapping[str, str] = {
    "json": r'"(?:A|alpha|parts)"',
    "csv": r"\bb\b",
    "constants": r"\b[ab]21\b",
    "petsc": "TSRKRegister|TSDIRKRegister|TSARKIMEXRegister|TSRosWRegister|TSGLEERegister",
    "julia": "Tableau|Butcher|ConstantCache",
    "principia": "FixedVector<double",
    "odeint": "class",
}
#: Languages that are not read; a file that may hold tables is said to be unread.
_OTHERS = frozenset(".adb .d .dart .fs .hs .lua .ml .nb .nim .pas .php .pl .rb .wl .zig".split())
_MOST = 60_000_000  # characters of a file

#: Lines from the head of a test to a table in it, and from there to what is expected.
_BEFORE, _AFTER = 9, 24
_BEGINS = re.compile(r"\s*(?:pub |async |static )*(?:fn|def|function|func|void|TEST\w*)\b")
_EXPECTS = re.compile(
    r"is_err\(|unwrap_err\(|expect_err\(|should_panic|\b(?:assertR|assert_r|r)aises\b"
    r"|toThrow|test_throws|_THROW\b|assertThrows"
)


def marks(form: str, text: str) -> bool:
    """Return whether a file may hold tables of a format."""
    return re.search(_MARKS[form], text) is not None


def files(source: Path, form: str) -> list[Path]:
    """Return files of a checkout that may hold tables of a format, in the order of their paths.

    Raises
    ------
    UsageError
        Where there is nothing to read.
    """
    if source.is_file():
        return [source]
    if not source.is_dir():
        raise UsageError(f"{source} is no file and no folder; give a file or a checkout")
    endings = SUFFIXES[form] if form else (*ENDINGS, *ROWS, *_OTHERS)
    hidden = len(source.parts)
    found = [
        x for x in sorted(source.rglob("*"))
        if x.suffix in endings and x.is_file()
        and (form or may_be_source(x))
        and (form or not any(part.startswith(".") for part in x.parts[hidden:]))
    ]  # fmt: skip
    if not found:
        if not form:
            raise UsageError(f"{source} holds no source file in a language that is read")
        raise UsageError(f"{source} holds no file {' or '.join(endings)} to read as {form}")
    return found


def may_be_source(path: Path) -> bool:
    """Return whether a file of this name may hold tables: one of rows of numbers must say so."""
    return path.suffix not in ROWS or of_subject(path.name)


def read_source(path: Path, form: str = "") -> str | None:
    """Return the text of a file, or ``None`` where it cannot be read or is too long.

    A file of data is a source of a language, but where its format is given.
    """
    try:
        if path.stat().st_size > _MOST:
            return None
        text = path.read_text(encoding="utf-8", errors="replace")
        return as_source(path, text) if path.suffix in FORMS and not form else text
    except OSError:
        return None


def _leads_out(root: Path, path: Path) -> bool:
    """Return whether a file of a checkout is a link to one elsewhere, or is reached by one."""
    try:
        named_in(root, path.relative_to(root), "SOURCE")
    except UsageError:
        return True
    return False


def audit(
    source: Path,
    form: str = "",
    *,
    search: bool = True,
    compare: bool = True,
    on: Executor | None = None,
    wanted: Collection[Path] | None = None,
) -> Iterator[dict[str, Any]]:
    """Read and judge all tables of a checkout.

    Parameters
    ----------
    source : Path
        A file or a folder.
    form : str, optional
        One of :data:`~.readers.FORMATS`; without it, tables of any kind in any language.
    search : bool
        Whether wrong entries are looked for.
    compare : bool
        Whether the catalogue is compared with.
    on : Executor, optional
        Where tables are judged; in this process by default. Others read the sources themselves.
    wanted : Collection of Path, optional
        Files whose tables are judged, by default all; the others are read for declared orders.

    Yields
    ------
    dict
        The record of :func:`~.judge.judge` with its ``path``. A file or table that is not
        understood has the status ``unread`` and says where.
    """
    if form and form not in FORMATS:
        raise UsageError(f"there is no reader for {form!r}; one of {', '.join(FORMATS)}")
    paths = files(source, form)
    programs = [x for x in paths if x.suffix not in FORMS] or paths
    alone = programs[0] if len(programs) == 1 else None
    root = source if source.is_dir() else source.parent
    outside = {path for path in paths if source.is_dir() and _leads_out(root, path)}
    declared: dict[str, int] = {}
    completed: dict[str, str] = {}
    texts: dict[str, str] = {}
    for path in paths:
        text = None if path in outside else read_source(path, form)
        declared |= declared_orders(text) if text else {}
        if text and not form and may_hold_constants(text):
            texts[str(path.relative_to(root))] = text
        for name, (entry, line) in completed_entries(text or "").items():
            place = f"{path.relative_to(root)}:{line}"
            completed[name] = f"completed at run time: a step assigns to {entry} ({place})"
    beyond = constants_of(texts)
    if wanted is not None:
        chosen = set(wanted)
        paths = [path for path in paths if path in chosen]
    inside = [path for path in paths if path not in outside]
    rows = list(
        _rows(
            inside,
            form,
            declared,
            completed,
            source.is_file(),
            alone=alone,
            compare=compare,
            beyond=beyond,
        )
    )
    remark = "a link that leads out of the checkout; it is not followed"
    rows += [(path, _unread(1, path.name, remark)) for path in paths if path in outside]
    tasks = [{**task, "search": search, "compare": compare} for _, task in rows if "number" in task]
    judged = in_order((on or Here()).run(judge_table, tasks), tasks)
    said: set[tuple[str, int]] = set()  # paths and lines of corrections
    for path, row in rows:
        name = str(path.relative_to(root))
        if "number" not in row:
            left = [x for x in row.get("correction", ()) if (name, x["line"]) not in said]
            said |= {(name, line) for line in _lines_of(row)}
            if left or "correction" not in row:
                yield {"path": name, **row, **({"correction": left} if left else {})}
            continue
        _, done = next(judged)
        if not done.failure:
            said |= {(name, line) for line in _lines_of(done.value)}
            said |= {(name, x.get("line", 0)) for x in done.value.get("correction", ())}
            yield {"path": name, **done.value}
        else:
            remark = f"the table is not understood: {done.message}"
            yield {"path": name, **_unread(row["line"], row["name"], remark)}


def _lines_of(record: Mapping[str, Any]) -> set[int]:
    """Return the lines that the remarks of a record name."""
    return {int(x) for x in re.findall(r"\bline (\d+)\)", " ".join(record["remarks"]))}


def _rows(
    paths: Sequence[Path],
    form: str,
    declared: Mapping[str, int],
    completed: Mapping[str, str],
    given: bool,
    *,
    alone: Path | None,
    compare: bool,
    beyond: Mapping[str, str],
) -> Iterator[tuple[Path, dict[str, Any]]]:
    """Yield each file with the tasks of its tables, and with records of what cannot be read.

    The only program of a folder is read whether it has the words of the subject or not.
    """
    for path in paths:
        text = read_source(path, form)
        if text is None:
            yield path, _unread(1, path.name, "the file cannot be read")
            continue
        recognised: list[Table] = []
        if marks(form, text) if form else (
            path == alone or may_hold(text, path.name)
            or (beyond and _uses(text, beyond))):  # fmt: skip
            task = {"kind": "audit", "file": str(path.absolute()), "form": form,
                    "declared": declared, "given": given, "beyond": beyond}  # fmt: skip
            for row in _of_file(path, text, task, completed, recognised):
                yield path, row
        if compare and not form and may_hold_known(text):
            yield from ((path, row) for row in _known(path, text, recognised))


def _uses(text: str, beyond: Mapping[str, str]) -> bool:
    """Return whether a text about flows has names of numbers of other files."""
    return OF_FLOWS.search(text) and len(beyond.keys() & {*re.findall(r"\w+", text)}) > 1


def _known(path: Path, text: str, recognised: Sequence[Table]) -> Iterator[dict[str, Any]]:
    """Yield records of the known methods of a file, see :func:`~.known.records`."""
    language = language_of(path) or LANGUAGES["c"]
    try:
        with limited(PROVING):
            yield from list(records(text, language, recognised, fixed=path.suffix in FIXED))
    except (GlmrefError, ArithmeticError, LookupError, ValueError) as error:
        said = error if isinstance(error, GlmrefError) else accident(error)
        yield _unread(1, path.name, f"numbers of known methods were not looked for: {said}")


def _of_file(
    path: Path,
    text: str,
    task: Mapping[str, Any],
    completed: Mapping[str, str],
    recognised: list[Table],
) -> list[dict[str, Any]]:
    """Return the tasks of the tables of a file, which are added to those recognised."""
    if path.suffix in _OTHERS and not (task["form"] or task["given"]):
        remark = f"there may be tables, and the language of a file {path.suffix} is not read"
        return [_unread(1, path.name, remark)] if of_subject(text) else []
    rows: list[dict[str, Any]] = []
    try:
        with limited(PROVING), rarely_collected():
            for table in _read(path, text, task["form"], task["declared"], task["given"],
                               task["beyond"]):  # fmt: skip
                if table.name in completed:
                    rows.append(_unread(table.line, table.name, completed[table.name]))
                elif _to_be_refused(text, table.line):
                    rows.append(_unread(table.line, table.name, "a test expects an error of it"))
                elif table.unread:  # said at once: elsewhere the file would be read again
                    rows.append(judge(table))
                else:
                    rows.append({**task, "number": len(recognised), "name": table.name,
                                 "line": table.line})  # fmt: skip
                recognised.append(table)
    except (GlmrefError, Unread, ValueError, KeyError, IndexError, TypeError, AttributeError,
            RecursionError) as error:  # fmt: skip
        said = error if isinstance(error, GlmrefError | Unread) else accident(error)
        remark = f"the rest of the file is not understood: {said}"
        rows.append(_unread(1, path.name, remark))
    return rows


def _to_be_refused(text: str, line: int) -> bool:
    """Return whether a table on a line of a test is one of which the test expects an error."""
    rows = text.split("\n")
    before, after = rows[max(0, line - _BEFORE) : line], rows[line : line + _AFTER]
    own = itertools.takewhile(lambda x: not _BEGINS.match(x), after)
    return any("test" in x.lower() for x in before) and any(map(_EXPECTS.search, own))


def _unread(line: int, name: str, remark: str) -> dict[str, Any]:
    return {"line": line, "name": name, "status": "unread", "remarks": [remark]}


def judge_table(task: Mapping[str, Any]) -> dict[str, Any]:
    """Judge one table, which is the one of this number in its file."""
    file = Path(task["file"])
    state = file.stat()
    written = (state.st_mtime_ns, state.st_size)
    orders, beyond = (tuple(task[x].items()) for x in ("declared", "beyond"))
    tables = _tables(file, written, task["form"], orders, task["given"], beyond)
    library, table = _library() if task["compare"] else None, tables[task["number"]]
    record = judge(table, library, search=task["search"])
    language = language_of(file)
    low = record.get("found", 0) < (record.get("declared") or 0)
    if table.kind == "splitting" and record.get("found") == 2 and len(table.b[0]) > 3 and (
            table.order is None and table.general):  # fmt: skip
        table, low = replace(table, order=4), True  # which no number has by chance
    if low and task["search"] and language and table.general and not record.get("correction"):
        _search(record, table, task, language)
    return record


def _search(
    record: dict[str, Any], table: Table, task: Mapping[str, Any], language: Language
) -> None:
    """Look for the one number of the source with which a table has its order; then it is asked."""
    file = Path(task["file"])

    def form(x: Table) -> tuple[int, str, int, int, bool]:
        kind = "splitting" if x.kind == "composition" else x.kind  # the right number says which
        return x.line, kind, len(x.rows), len(x.errors), x.guessed

    def again(text: str, beyond: Mapping[str, str] = task["beyond"]) -> Table | None:
        with suppress(GlmrefError, Unread, ValueError, LookupError, TypeError, AttributeError):
            for found in _read(file, text, task["form"], task["declared"], given, beyond):
                if form(found) == form(table):
                    return replace(found, order=table.order)
        return None

    text, given, block = read_source(file, task["form"]) or "", True, table.block
    lines = text.split("\n")
    if block is not None and block.parent is not None:  # the function alone is read in less time
        lines = [x if block.line <= k <= block.last else "" for k, x in enumerate(lines, 1)]
    found = mended("\n".join(lines), language, table, again, task["beyond"])
    if not found:
        given = task["given"]
        found = mended(text, language, table, again, task["beyond"])
    if found and record["status"] in ("question", "unread", "wrong", "found"):
        unsure = record["status"] in ("unread", "found")
        record["status"] = "question" if unsure else record["status"]
        record["correction"] = found
        record["remarks"].append(f"with this number the order is {table.order}")


@lru_cache(maxsize=4)
def _tables(
    file: Path,
    written: tuple[int, int],
    form: str,
    declared: tuple[tuple[str, int], ...],
    given: bool,
    beyond: tuple[tuple[str, str], ...],
) -> list[Table]:
    """Return tables of a file, last written then, as far as it is understood."""
    found: list[Table] = []
    # the client has read as far, and says what is wrong
    with suppress(Exception), limited(PROVING):
        found.extend(
            _read(file, read_source(file, form) or "", form, dict(declared), given, dict(beyond))
        )
    return found


#: Readers that see more in the sources for which they were made than :mod:`.recognising` does.
_MORE = ("petsc", "julia", "principia", "odeint", "constants")


def _read(
    path: Path, text: str, form: str, declared: Mapping[str, int], given: bool,
    beyond: Mapping[str, str],
) -> Iterator[Table]:  # fmt: skip
    """Yield the tables of one file, in a format or of any kind.

    A file that is given by its name is about tables; one of a checkout must say so.
    """
    if form:
        yield from read(text, form, declared)
        return
    language = language_of(path)
    if language is None or (path.suffix in ROWS and not text):
        which = path.suffix or "without an ending"
        more = f"; --from {which[1:]} reads it" if which[1:] in FORMATS else ""
        raise DataError(f"the language of a file {which} is not known{more}")
    found = tables(
        text,
        language,
        fixed=path.suffix in FIXED,
        about=given,
        declared=declared,
        where=path.name,
        beyond=beyond,
    )
    forms = [x for x in _MORE if path.suffix in SUFFIXES[x] and marks(x, text)]
    special = [x for form in forms for x in read(text, form, declared)]
    lines = [*sorted(x.line for x in special if x.line > 1), len(text)]
    read_at = [x.line for x in found if not x.unread]
    for x in special:
        end = next((n for n in lines if n > x.line), len(text))
        if not (x.unread and any(x.line <= n < end for n in read_at)):
            yield x
    known = {key_of(A) for x in special for A in x.A}
    weights = {key_of(x.b) for x in special if not x.unread}
    names = {x.name.lower() for x in special if not x.unread}
    for x in found:
        again = ({key_of(A) for A in x.A} | {x.key}) & known
        again = again or (x.source == STEP and key_of(x.b) in weights)
        if (
            not again
            and x.name.rpartition(".")[0].lower() not in names
            and (x.name.lower() not in names)
        ):
            yield x


@cache
def _library() -> Library:
    return Library()
