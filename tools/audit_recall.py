"""What the reader of any source sees of the tables that the readers of one package see.

``python -m tools.audit_recall CHECKOUTS [CODE ...]`` reads the files that ``data/audits`` names, in
the folder CHECKOUTS/CODE of each code, with the reader that was made for them and with the general
one alone, and compares the Runge-Kutta, additive and splitting methods: a line for each that the
general reader does not see alike, with the reason, and a count of the reasons.
"""

from __future__ import annotations

import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

from glmref.audit.lexer import FIXED, language_of
from glmref.audit.readers import FORMATS, SUFFIXES, declared_orders, read
from glmref.audit.recognising import numbers_of, tables
from glmref.audit.sources import files, marks, read_source
from glmref.audit.table import Table
from glmref.catalogue.audits import audited_codes
from glmref.errors import DataError, GlmrefError

#: Kinds that are compared.
KINDS = ("rk", "additive", "splitting", "composition")
#: So many lines from a table an unread one is about it.
NEAR = 60


class Seen(StrEnum):
    """How the general reader sees a table of a special one."""

    ALIKE = "same numbers and order"
    NO_ORDER = "no declared order"
    OTHER_ORDER = "another declared order"
    MORE = "an order that the special reader does not see"
    SAID = "said to be unread"
    OTHER = "other numbers"
    SILENT = "nothing said"


@dataclass(frozen=True)
class Compared:
    """A table of a special reader, and how the general one sees it."""

    code: str
    path: str
    form: str
    name: str
    line: int
    order: int | None
    seen: Seen

    def __str__(self) -> str:
        order = "" if self.order is None else f", order {self.order}"
        return f"{self.code} {self.path}:{self.line}: {self.name}{order}: {self.seen} ({self.form})"


def compared(special: Sequence[Table], general: Sequence[Table]) -> Iterator[tuple[Table, Seen]]:
    """Yield each method that a special reader has read, and how the general one sees it."""
    for x in special:
        if x.unread or x.kind not in KINDS:
            continue
        near = sorted(general, key=lambda y: abs(y.line - x.line))
        same = [y for y in near if not y.unread and numbers_of(y) == numbers_of(x)]
        beside = [y for y in near if abs(y.line - x.line) <= NEAR and y.name.find(x.name) >= 0]
        if any(y.order == x.order for y in same):
            yield x, Seen.ALIKE
        elif same and x.order is None:
            yield x, Seen.MORE
        elif same:
            yield x, Seen.NO_ORDER if same[0].order is None else Seen.OTHER_ORDER
        elif beside:
            yield x, Seen.SAID if beside[0].unread else Seen.OTHER
        else:
            said = any(y.unread and abs(y.line - x.line) <= NEAR for y in near)
            yield x, Seen.SAID if said else Seen.SILENT


def of_file(
    path: Path, text: str, declared: Mapping[str, int]
) -> Iterator[tuple[str, Table, Seen]]:
    """Yield the methods of one file, each with the special reader that reads it."""
    language = language_of(path)
    forms = [x for x in FORMATS if path.suffix in SUFFIXES[x] and marks(x, text)]
    general: list[Table] | None = None
    for form in forms:
        special: list[Table] = []
        with suppress(DataError):  # a file in another dialect
            special.extend(read(text, form, declared))
        if special and general is None and language is not None:
            general = tables(text, language, fixed=path.suffix in FIXED, declared=declared,
                             where=path.name)  # fmt: skip
        for table, seen in compared(special, general or []):
            yield form, table, seen


def of_code(code: str, root: Path) -> Iterator[Compared]:
    """Yield the methods of a checkout in the files that its record names."""
    declared: dict[str, int] = {}
    for path in files(root, ""):
        declared |= declared_orders(read_source(path) or "")
    for name in sorted({x["path"] for x in audited_codes()[code]["tables"]}):
        text = read_source(root / name)
        if text is None:
            continue
        for form, x, seen in of_file(root / name, text, declared):
            yield Compared(code, name, form, x.name, x.line, x.order, seen)


def main(arguments: list[str]) -> None:
    """Print what differs, and the counts as JSON."""
    folder, *wanted = arguments
    total: Counter[str] = Counter()
    for code in wanted or audited_codes():
        root = Path(folder) / code
        if not root.is_dir():
            sys.stderr.write(f"{code}: there is no folder {root}\n")
            continue
        try:
            for x in of_code(code, root):
                total[x.seen] += 1
                if x.seen != Seen.ALIKE:
                    sys.stdout.write(f"{x}\n")
        except GlmrefError as error:
            sys.stderr.write(f"{code}: {error}\n")
    sys.stdout.write(json.dumps({"methods": total.total(), **total}) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
