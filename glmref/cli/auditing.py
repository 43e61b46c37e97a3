"""``glmref audit`` and ``check``: tableaux in sources, and one from a file or a pipe."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any, TextIO

import click

from ..catalogue import canonical
from ..errors import BudgetError, GlmrefError, UsageError
from ..findings import Finding, Verdict
from ..views.tables import counted, findings_json, one_line, plain
from .linting import LINES, by_lines
from .output import (
    BAD_INPUT,
    FAILED,
    HOLDS,
    INTERNAL,
    Word,
    complain,
    complete_method,
    count_option,
    file_option,
    format_option,
    on_option,
    say,
)

#: Repeated from :data:`glmref.audit.readers.FORMATS`, so that ``--help`` loads nothing.
READ = (
    *("json", "csv", "petsc", "julia"),
    *("constants", "principia", "odeint"),
)


class Notation(Word):
    """A notation of :data:`READ`; those that were named once are read like any other."""

    def convert(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> str | None:
        """Return the word, or ``None`` where none is needed any more."""
        once = ("python", "gsl", "kpp", "matlode", "weights")
        return None if value in once else super().convert(value, param, ctx)


order_option = count_option(
    "--order", 100, "Of a plain tableau: the order to check; default: its key."
)
digits_option = count_option(
    "--digits", 150, "Of a plain tableau: digits after the point to which its decimals are known."
)


@click.command(short_help="Check a plain tableau: JSON or TOML from a file or a pipe.")
@click.argument("file", metavar="NAME|FILE|-", shell_complete=complete_method)
@order_option
@digits_option
@format_option(("table", "json"))
def check(file: str, order: int | None, digits: int | None, form: str) -> int:
    """Check a tableau against its claimed orders, as `glmref verify` does, in words.

    FILE holds {"A": .., "b": .., "order": ..} in JSON or TOML, - stands for the standard input; the
    documentation lists the other keys (c, embedded, parts, b_prime, alpha, gamma, dense, ..). A
    decimal of up to 11 digits is exact; with more it is a rounded number, known to its digits.
    """
    return check_plain(file, order, digits, form)


def check_plain(file: str, order: int | None, digits: int | None, form: str) -> int:
    """Check one tableau, say what holds in sentences or JSON, and return the exit code."""
    from ..audit.check import sentence

    more = {
        key: value for key, value in (("order", order), ("digits", digits)) if value is not None
    }
    try:
        findings = findings_of(file, more)
    except BudgetError as error:
        complain(f"{file}: {error}, and nothing was decided")
        return INTERNAL
    if form == "json":
        say(findings_json(findings))
    else:
        for x in findings:
            say(one_line(sentence(x), limit=2000))
    verdicts = {x.verdict for x in findings}
    if Verdict.FAILS in verdicts:
        return FAILED
    return INTERNAL if Verdict.OPEN in verdicts else HOLDS


def is_in_words(name: str, form: str) -> bool:
    """Return whether what is found is said in sentences: of a pipe, and of a plain tableau.

    The JSON of a tableau in a file is that of all files, with its name.
    """
    from ..catalogue.files import document
    from ..catalogue.keys import is_plain

    path = Path(name)
    try:
        if name == "-" or (path.is_fifo() and not path.resolve().is_fifo()):
            return True
        if form != "table" or not path.is_file():
            return False
        given = document(name)
        return is_plain(given) and any("order" in x for x in (given, given.get("claims", ())))
    except (GlmrefError, OSError, TypeError, ValueError):
        return False  # what is wrong with it is said where it is read


def _stream(file: str) -> TextIO | None:
    """Return the standard input or a pipe of the shell, ``None`` for a file, or what is none.

    A pipe of the shell has no name; one that has may have no writer, and opening it waits.
    """
    if file == "-":
        return sys.stdin
    path = Path(file)
    if path.is_file() or path.is_dir() or not path.exists() or path.resolve().is_fifo():
        return None
    return path.open(encoding="utf-8", errors="replace")


def findings_of(file: str, more: Mapping[str, Any] = MappingProxyType({})) -> list[Finding]:
    """Return findings about a file or a pipe, decided in a process of its own."""
    from ..audit.check import examine
    from ..catalogue.files import document, plain_document
    from ..catalogue.keys import is_plain
    from ..catalogue.strict_json import MAX_BYTES
    from ..prove.verifier import verify_file
    from ..system.budget import PROVING, limited
    from ..system.process import Say, apart

    name = "the standard input" if file == "-" else Path(file).name
    stream = _stream(file)
    given = document(file) if stream is None else plain_document(stream.read(MAX_BYTES + 1), name)
    plain = is_plain(given)
    if more and not plain:
        raise UsageError(f"--{next(iter(more))} is for a plain tableau, and {name} has a format")
    if not plain and stream is not None:
        raise UsageError("a method file is read by its name; the standard input is for a tableau")

    def program(tell: Say) -> None:
        with limited(PROVING):
            found = examine({**given, **more}, name) if plain else verify_file(file)
            tell([x.as_json() for x in found], None)

    said = apart(program, PROVING)
    if not said.messages:
        raise said.error(PROVING)
    return [Finding.from_json(x) for x in said.messages[0]]


@click.command(short_help="Check all tableaux in the sources of a code.")
@click.argument("sources", type=click.Path(path_type=Path), metavar="[PATH]...", nargs=-1)
@click.option(
    "--from",
    "notation",
    type=Notation(READ),
    help="Package in whose notation the tables are written; by default any notation.",
)
@click.option("--all", "every", is_flag=True, help="Show the tables that are right, too.")
@click.option("--fast", is_flag=True, help="Do not look for the entry that is wrong.")
@click.option(
    "--strict", is_flag=True, help="Exit with 1 when a table is unread, too; see --lines."
)
@on_option
@click.option(
    "--lines", is_flag=True,
    help="Check method files and plain tableaux (JSON, TOML) as well, and say what is wrong by "
    "file and line, by default below this folder.",
)  # fmt: skip
@format_option(LINES, "With --lines: the format of the output; table by default.", None)
@click.option(
    "--since", metavar="COMMIT", help="With --lines: only tables with lines changed since COMMIT."
)
@file_option("--sarif", "With --lines: write SARIF, too.")
@file_option("--badge", "With --lines: write the JSON of a shields.io endpoint, too.")
@click.option("--allow-empty", is_flag=True, help="With --lines: exit with 0 without a table.")
def audit(
    sources: tuple[Path, ...],
    notation: str | None,
    every: bool,
    fast: bool,
    strict: bool,
    on: str | None,
    lines: bool,
    **more: Any,
) -> int:
    """Check every tableau in files or checkouts: one line of JSON each, then a count.

    C, C++, C#, CUDA, Fortran, Go, Java, JavaScript, Julia, Kotlin, MATLAB, Python, R, Rust, Scala,
    Swift, notebooks, JSON, TOML and YAML are read. Nothing in the sources is executed. A table that
    is not understood is listed as unread, with its line, and the audit goes on. Exit code 1 when a
    table is wrong, 2 when no table can be read.

    With --lines an error is a claim that fails; a warning is a question, or a claim that is not
    decided; with --strict a note is what looks like a table and could not be read, and any of them
    gives exit code 1. Where no table is read it is 2 (0 with --since and --allow-empty).
    """
    if lines:
        if notation or every or fast or on:
            raise UsageError("--lines reads any notation; leave --from, --all, --fast, --on away")
        return by_lines(sources, findings_of, strict=strict, **more)
    if any(more.values()):
        raise UsageError("--format, --since, --sarif, --badge and --allow-empty are for --lines")
    if not sources:
        raise UsageError("name the files or folders to audit; . is this folder")
    from ..audit.sources import LINE
    from ..audit.sources import audit as examine
    from ..audit.table_verdicts import summary
    from ..compute import executor

    records = []
    with executor(on) as where:
        for source in sources:
            for record in examine(source, notation or "", search=not fast, on=where):
                records.append(record)
                if every or record["status"] not in ("right", "found", "digits"):
                    say(canonical.one_line({"format": LINE, **plain(record)}))
    counts = summary(records)
    if records:
        tables = counted(len(records), "table")
        complain(f"{tables}: " + ", ".join(f"{n} {x}" for x, n in counts.items()))
    unread = counts.get("unread", 0)
    if unread == len(records):
        what = "is understood" if records else "is found"
        name = ", ".join(map(str, sources))
        read = f" read as {notation}; name another --from, or none" if notation else ""
        hint = "" if notation else "; a table can be given as JSON, too (docs/check.md)"
        if not notation and not records and any(x.is_dir() for x in sources):
            hint = f"; a file given by its name is searched more closely{hint}"
        complain(f"no table {what} in {name}{read}{hint}")
        return FAILED if strict and records else BAD_INPUT
    return FAILED if counts.get("wrong") or (strict and unread) else HOLDS
