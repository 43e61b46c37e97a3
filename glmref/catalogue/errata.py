"""What the thesis of Khan (2018) prints, whether it is right, and the test that proves it.

The records are data (``data/errata.json``, format ``glmref-errata-1``); each one that can be
computed names its test. Nothing is recomputed here: ``pytest`` does that.
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from functools import cache

from ..system.arguments import no_such
from .files import data_root
from .strict_json import read_json

#: ``right``: as printed. ``wrong``: a formula or number is not what it must be. ``misprint``: a
#: slip the context corrects. ``incomplete``: true, with a condition that is missing. ``false``: a
#: statement that a counterexample refutes.
VERDICTS = ("right", "wrong", "misprint", "incomplete", "false")


@dataclass(frozen=True, slots=True)
class Erratum:
    """One statement of the thesis and what became of it."""

    id: str  #: The record's name, unique, beginning with the section.
    where: str  #: Section, and equation number where there is one.
    printed: str  #: What is printed, in words or plain formulas.
    verdict: str  #: One of :data:`VERDICTS`.
    right: str  #: What holds instead, or under which condition; why it is right where it is.
    #: How the verdict was reached: one of :class:`~glmref.findings.Proof`, or ``reading`` where
    #: there is nothing to compute.
    proof: str
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


@cache
def load_errata() -> tuple[Erratum, ...]:
    """Return all records of the shipped file, in the order of the thesis."""
    rows = read_json(data_root() / "errata.json")["errata"]
    return tuple(Erratum(**{**row, "method": tuple(row.get("method", ()))}) for row in rows)


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
    text: str = "", *, verdict: str | None = None, method: str | None = None
) -> tuple[Erratum, ...]:
    """Select records by a text, a verdict and the name of a data file.

    The text is found, without regard to case, in the id, the place, the printed or the right text;
    ``"3.8"`` finds what concerns equation (3.8).
    """
    sought = text.casefold()
    return tuple(
        record
        for record in load_errata()
        if sought in "\n".join((record.id, record.where, record.printed, record.right)).casefold()
        and verdict in (None, record.verdict)
        and (method is None or method in record.method)
    )
