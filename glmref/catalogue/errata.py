"""What the thesis of Khan (2018) prints, whether it is right, and the test that proves it.

The records are data (``data/errata.json``, format ``glmref-errata-1``); each one that can be
computed names its test. Nothing is recomputed here: ``pytest`` does that.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path
from typing import Any

from ..errors import DataError
from ..system.arguments import no_such, one_of, unknown_key
from .files import data_root
from .strict_json import read_json, shown

FORMAT = "glmref-errata-1"

#: ``right``: as printed. ``wrong``: a formula or number is not what it must be. ``misprint``: a
#: slip the context corrects. ``incomplete``: true, with a condition that is missing. ``false``: a
#: statement that a counterexample refutes.
VERDICTS = ("right", "wrong", "misprint", "incomplete", "false")

#: How the verdict was reached: the three proofs of :class:`~glmref.findings.Proof`, or ``reading``
#: where there is nothing to compute.
PROOFS = ("exact", "enclosed", "measured", "reading")


@dataclass(frozen=True, slots=True)
class Erratum:
    """One statement of the thesis and what became of it."""

    id: str  #: The record's name, unique, beginning with the section.
    where: str  #: Section, and equation number where there is one.
    printed: str  #: What is printed, in words or plain formulas.
    verdict: str  #: One of :data:`VERDICTS`.
    right: str  #: What holds instead, or under which condition; why it is right where it is.
    proof: str  #: One of :data:`PROOFS`.
    #: Names of the data files that carry the printed or the corrected form.
    method: tuple[str, ...] = ()
    #: The test that proves it, ``"tests/literature/test_x.py::test_y"``, or ``None`` where there is
    #: nothing to compute.
    test: str | None = None

    def as_json(self) -> dict[str, object]:
        """Return the record as its file has it."""
        record: dict[str, object] = {f.name: getattr(self, f.name) for f in fields(self)}
        record["method"] = list(self.method)
        return record


def load_errata(path: Path | None = None) -> tuple[Erratum, ...]:
    """Read all records of the shipped file, or of another one, in the order of the thesis.

    Raises
    ------
    DataError
        For a file that is not what the format asks, naming the record.
    """
    return _load(data_root() / "errata.json" if path is None else path)


@cache
def _load(path: Path) -> tuple[Erratum, ...]:
    document = read_json(path)
    if not isinstance(document, dict) or document.get("format") != FORMAT:
        raise DataError(f"{path.name}: `format` must be {FORMAT!r}, got {shown(document)}")
    rows = document.get("errata")
    if not isinstance(rows, list) or not rows:
        raise DataError(f"{path.name}: `errata` must be a list of records, got {shown(rows)}")
    records = tuple(_record(row, f"{path.name}: record {i + 1}") for i, row in enumerate(rows))
    seen: set[str] = set()
    for record in records:
        if record.id in seen:
            raise DataError(f"{path.name}: the id {record.id!r} occurs twice; rename one record")
        seen.add(record.id)
    return records


def _record(row: object, where: str) -> Erratum:
    if not isinstance(row, Mapping):
        raise DataError(f"{where} must be an object, got {shown(row)}")
    names = [f.name for f in fields(Erratum)]
    if fault := unknown_key(row, names):
        raise DataError(f"{where}: {fault}")
    for key in names[:6]:
        _text(row, key, where)
    for key, allowed in (("verdict", VERDICTS), ("proof", PROOFS)):
        one_of(key, row[key], allowed, lambda said: DataError(f"{where}: {said}"))
    test, method = row.get("test"), row.get("method", [])
    if test is not None:
        _text(row, "test", where)
    elif row["proof"] != "reading":
        raise DataError(f"{where}: a verdict by {row['proof']} needs its `test`; name it")
    if not isinstance(method, list) or not all(isinstance(x, str) and x for x in method):
        raise DataError(f"{where}: `method` must be a list of file names, got {shown(method)}")
    values: dict[str, Any] = {key: row[key] for key in names[:6]}
    return Erratum(**values, method=tuple(method), test=test)


def _text(row: Mapping[str, object], key: str, where: str) -> None:
    value = row.get(key)
    if not isinstance(value, str) or not value.strip():
        raise DataError(f"{where}: `{key}` must be a sentence, got {shown(value)}")


def erratum(name: str) -> Erratum:
    """Return the record of this id.

    Raises
    ------
    UsageError
        When there is none, naming the nearest ids.
    """
    known = {record.id: record for record in load_errata()}
    if name in known:
        return known[name]
    raise no_such("erratum", name, known, "see `glmref list --errata`")


def find_errata(
    text: str = "",
    *,
    verdict: str | None = None,
    proof: str | None = None,
    method: str | None = None,
) -> tuple[Erratum, ...]:
    """Select records by a text, a verdict, a kind of proof and the name of a data file.

    The text is found, without regard to case, in the id, the place, the printed or the right text;
    ``"3.8"`` finds what concerns equation (3.8).

    Raises
    ------
    UsageError
        For a verdict or proof that does not exist.
    """
    for key, value, allowed in (("verdict", verdict, VERDICTS), ("proof", proof, PROOFS)):
        if value is not None:
            one_of(key, value, allowed)
    sought = text.casefold()
    return tuple(
        record
        for record in load_errata()
        if sought in "\n".join((record.id, record.where, record.printed, record.right)).casefold()
        and verdict in (None, record.verdict)
        and proof in (None, record.proof)
        and (method is None or method in record.method)
    )
