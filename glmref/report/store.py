"""Read what is stored: records, findings, portraits, measurements.

A report is made of what is there. A line that is torn, a record of a version that is not known, a
file that is something else: each is kept with the reason, shown on the page that says how things
were measured, and breaks nothing.
"""

from __future__ import annotations

import json
import os
import re
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any, TypeGuard
from xml.etree import ElementTree

from ..catalogue.files import names as shipped_names
from ..catalogue.keys import FORMAT as METHOD
from ..catalogue.keys import class_of_keys
from ..catalogue.lookup import read_method
from ..compute.records import SUFFIX, Records, lines_of
from ..errors import DataError, UsageError
from ..system.arguments import shown
from ..system.files import read_text
from ..system.shown import DARK
from ..views.tables import counted

#: Formats of the findings and of stability regions that are understood.
FINDINGS, REGIONS = "glmref-findings-1", "glmref-stability-1"
#: Format of what `glmref run` says of a scene, and the end of the name of that file.
ABOUT, ABOUT_SUFFIX = "glmref-run-1", ".run"
#: Names of the documents with the orders that runs show, and with error constants.
ORDERS, CONSTANTS = "observed-orders", "error-constants"
#: File by which a folder of pages is known: only such a folder, or an empty one, is written over.
MARK = "glmref-report.txt"
Record = Mapping[str, Any]
#: Bytes of a record file or a document, and of a portrait, that are read at the most.
MAX_BYTES, MAX_DRAWING = 1 << 30, 5_000_000
_SVG = "{http://www.w3.org/2000/svg}"
_SHAPES = frozenset("svg title desc g path rect circle line polyline polygon text tspan".split())


@dataclass(frozen=True)
class RunFile:
    """The records of one file of `glmref run`."""

    name: str  #: Stem of the file: the scene's name, with ``-quick`` for a quick run.
    records: tuple[Record, ...]  #: In the order of the file.
    #: What `glmref run` wrote of the scene: title, question, answer, the error it judges by.
    about: Record = field(default_factory=dict)

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return self.name.removesuffix("-quick")


@dataclass
class Results:
    """Everything that was found."""

    runs: list[RunFile] = field(default_factory=list)  #: Record files.
    abouts: dict[str, Record] = field(default_factory=dict)  #: Name of a run -> what it answers.
    #: Method -> findings of `glmref verify`; of two about one claim the one that was read first.
    findings: dict[str, list[Record]] = field(default_factory=dict)
    #: Name -> document with a format of its own.
    measurements: dict[str, Record] = field(default_factory=dict)
    regions: dict[str, Record] = field(default_factory=dict)  #: Method -> its stability.
    #: Name -> method file of the user, checked.
    own: dict[str, Record] = field(default_factory=dict)
    portraits: dict[str, str] = field(default_factory=dict)  #: Method -> SVG.
    odd: list[tuple[str, str]] = field(default_factory=list)  #: (place, why it is not shown).
    files: list[tuple[str, str]] = field(default_factory=list)  #: (path, what it holds).

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to show."""
        shown = (self.runs, self.findings, self.measurements, self.regions)
        return not any((*shown, self.own, self.portraits))

    def of_others(self) -> list[str]:
        """Return methods of the user: those whose file was given, and those with findings."""
        return sorted({*self.own, *self.findings} - set(shipped_names("all")))

    @property
    def records(self) -> Iterator[Record]:
        """Records of all files."""
        return (record for run in self.runs for record in run.records)

    def observed(self, method: str) -> dict[str, Record]:
        """Return orders that runs of a method show: claim -> row."""
        return self._orders.get(method, {})

    def constants(self, method: str) -> Record:
        """Return error constants of a method, an empty record where none are stored."""
        return self._constants.get(method, {})

    @cached_property
    def _constants(self) -> dict[str, Record]:
        rows = self.measurements.get(CONSTANTS, {}).get("methods")
        return {
            str(row.get("method")): row
            for row in (rows if isinstance(rows, list) else ())
            if isinstance(row, Mapping)
        }

    @cached_property
    def _orders(self) -> dict[str, dict[str, Record]]:
        found: dict[str, dict[str, Record]] = {}
        rows = self.measurements.get(ORDERS, {}).get("orders")
        for row in rows if isinstance(rows, list) else ():
            if isinstance(row, Mapping) and is_number(row.get("observed")):
                found.setdefault(str(row.get("method")), {})[str(row.get("claim"))] = row
        return found


def read(paths: Iterable[Path], methods: Iterable[str] = ()) -> Results:
    """Read files, and folders to any depth.

    An SVG file ``NAME.svg`` of one of the ``methods`` is a portrait.

    Raises
    ------
    UsageError
        For a path that does not exist.
    """
    found, known, seen = Results(), frozenset(methods), set()
    drawn: list[Path] = []
    for path in paths:
        if not path.exists():
            raise UsageError(
                f"there is no file or folder {str(path)!r}; give what `glmref run` wrote"
            )
        for one in _files(path):
            key = os.path.realpath(one)  # unlike Path.resolve, also of a link to itself
            if key not in seen:
                seen.add(key)
                _take(found, one, known)
                drawn += [one] if one.suffix == ".svg" and one.stem not in known else []
    for one in drawn:  # of a method of the user, which may be read after its portrait
        _take(found, one, frozenset(found.of_others()))
    found.runs = [replace(run, about=found.abouts.get(run.name, {})) for run in found.runs]
    found.runs.sort(key=lambda run: run.name)
    return found


def _files(path: Path, above: tuple[str, ...] = ()) -> Iterator[Path]:
    """Yield files of a folder in order."""
    if not path.is_dir():
        yield path
        return
    place = os.path.realpath(path)
    if place in above:  # a link to a folder that this one lies in
        return
    for inner in sorted(path.iterdir()):
        # pages of an earlier report lie in a folder with this mark, hidden folders are not ours
        if not inner.name.startswith(".") and not (inner / MARK).is_file():
            yield from _files(inner, (*above, place))


def _take(found: Results, path: Path, methods: frozenset[str]) -> None:
    """Read one file by its kind."""
    try:
        if path.suffix in (SUFFIX, ".jsonl"):
            _take_records(found, path)
        elif path.suffix == ".json":
            _take_document(found, path, methods)
        elif not path.is_file():
            raise DataError("it is neither a file nor a folder")
        elif path.suffix == ".svg" and path.stem in methods:
            found.portraits[path.stem] = _drawing(path)
            found.files.append((path.name, "a portrait"))
    except (DataError, OSError, UnicodeDecodeError) as error:
        found.odd.append((path.name, str(error)))


def _drawing(path: Path) -> str:
    """Return an SVG file of shapes and texts, to stand in a page as it is.

    Raises
    ------
    DataError
        For anything else, such as a script, a link or a style.
    """
    text = read_text(path, MAX_DRAWING).replace(DARK, "", 1)  # a page has a style of its own
    try:
        root = ElementTree.fromstring(text)
    except ElementTree.ParseError as error:
        raise DataError(f"it is no SVG ({error})") from None
    for node in root.iter():
        name = str(node.tag).removeprefix(_SVG)
        if name not in _SHAPES:
            raise DataError(f"a portrait has shapes and texts only, and this one a {name!r}")
        bad = [
            key
            for key, value in node.attrib.items()
            # in a page, names of attributes may be written in capitals
            if re.match("on|style$|.*href", key.lower()) or "url(" in value.lower()
        ]
        if bad:
            raise DataError(f"a portrait has shapes and texts only, and this one {bad[0]!r}")
    ElementTree.register_namespace("", _SVG.strip("{}"))
    try:
        return ElementTree.tostring(root, encoding="unicode")
    except RecursionError:
        raise DataError("its shapes are nested too deep") from None


def _take_records(found: Results, path: Path) -> None:
    """Read the records of a run, from the file that it writes or from lines of JSON."""
    if path.suffix != SUFFIX and path.with_suffix(SUFFIX).is_file():
        return  # that file has taken them over
    records: dict[str, Record] = {}
    for where, record, why in _stored(path):
        if record is not None and not isinstance(
            record["task"].get("method", record["task"].get("peer")), str
        ):
            why = "it does not say what was run"
        elif record is not None and str(record.get("key")) in records:
            why = "it is a second record of the same task, and the first is shown"
        if why:
            found.odd.append((where, why))
        elif record is not None:
            records[str(record.get("key"))] = record
    found.runs.append(RunFile(path.stem, tuple(records.values())))
    found.files.append((path.name, counted(len(records), "record")))


def _stored(path: Path) -> Iterator[tuple[str, Record | None, str]]:
    """Yield place, record and what is wrong of each record of a file."""
    if path.suffix == SUFFIX:
        store = Records(path)
        yield from ((path.name, record, "") for record in store)
        yield from ((path.name, None, notice) for notice in store.notices)
    else:
        yield from ((f"{path.name}, line {n}", record, why) for n, record, why in lines_of(path))


def _take_document(found: Results, path: Path, methods: frozenset[str]) -> None:
    try:
        document = json.loads(read_text(path, MAX_BYTES))
    except (ValueError, RecursionError):
        found.odd.append((path.name, "it is not JSON"))
        return
    form = document.get("format") if isinstance(document, dict) else None
    if form == METHOD or (isinstance(document, dict) and not form and class_of_keys(document)):
        _take_method(found, path, methods)
    elif form == FINDINGS and isinstance(document.get("findings"), list):
        rows = [x for x in document["findings"] if isinstance(x, dict) and "method" in x]
        known = {(name, str(x.get("claim"))) for name, mine in found.findings.items() for x in mine}
        for row in rows:
            if (str(row["method"]), str(row.get("claim"))) not in known:
                found.findings.setdefault(str(row["method"]), []).append(row)
        found.files.append((path.name, counted(len(rows), "finding")))
    elif form == REGIONS and isinstance(document.get("methods"), dict):
        for method, region in document["methods"].items():
            if isinstance(region, dict):
                found.regions.setdefault(method, region)
        found.files.append((path.name, counted(len(document["methods"]), "stability region")))
    elif form == ABOUT:
        texts = {k: x for k, x in document.items() if isinstance(x, str)}
        found.abouts[path.stem.removesuffix(ABOUT_SUFFIX)] = texts
    elif (
        isinstance(form, str) and form.startswith("glmref-") and not form.startswith(FINDINGS[:-1])
    ):
        found.measurements[path.stem] = document
        found.files.append((path.name, f"a document of format {form}"))
    else:
        found.odd.append(
            (path.name, f"its format is {shown(form)}, which this version does not read")
        )


def _take_method(found: Results, path: Path, methods: frozenset[str]) -> None:
    """Read a method file of the user, which gets a page; a shipped name stays that of the data."""
    document, method = read_method(path)
    name = method.name
    if name in methods:
        why = f"{name} is the name of a shipped method; give yours another one"
        found.odd.append((path.name, why))
        return
    found.own[name] = document
    found.files.append((path.name, f"the method {name}"))


def method_of(record: Record) -> str:
    """Return method or peer of a record."""
    task = record["task"]
    return str(task["peer"] if "peer" in task else task["method"])


def is_number(value: Any) -> TypeGuard[float]:
    """Return whether a value is a finite number."""
    if not isinstance(value, int | float) or isinstance(value, bool):
        return False
    return abs(value) <= sys.float_info.max  # also of a whole number beyond doubles


def path_in(record: Any, keys: Sequence[str]) -> Any:
    """Return the value at a path of keys, ``None`` where the path ends early."""
    for key in keys:
        record = record.get(key) if isinstance(record, Mapping) else None
    return record
