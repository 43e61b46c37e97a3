"""``glmref check``: a tableau from a file or a pipe; nothing but its numbers is needed."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

import click

from ..catalogue import canonical
from ..errors import BudgetError, DataError, UsageError
from ..findings import Verdict
from ..views.tables import counted, json_text, one_line, plain
from .output import FAILED, HOLDS, INTERNAL, Word, complain, format_option, on_option, say

#: Repeated from :data:`glmref.audit.readers.FORMATS`, so that ``--help`` loads nothing.
READ = (
    *("json", "csv", "sundials", "petsc", "julia", "python"),
    *("openmodelica", "eigen", "rklib", "kpp", "matlode", "constants", "java", "rust"),
    *("principia", "gsl", "odeint"),
)

_EXAMPLE = 'write {"A": [[0, 0], [1, 0]], "b": ["1/2", "1/2"], "order": 2}'
_MOST_TEXT = 20_000_000  # characters of a document


@click.command(short_help="Check a plain tableau: JSON or TOML from a file or a pipe.")
@click.argument("file", metavar="FILE|-")
@click.option(
    "--order",
    type=click.IntRange(1, 100),
    metavar="N",
    help="The order to check; default: its key.",
)
@click.option(
    "--digits",
    type=click.IntRange(1, 300),
    metavar="N",
    help="Digits after the point to which its decimals are known; default: its key.",
)
@format_option(("table", "json"))
def check(file: str, order: int | None, digits: int | None, form: str) -> int:
    """Check a tableau against its claimed orders.

    FILE holds {"A": .., "b": .., "order": ..} in JSON or TOML, - stands for the standard input; the
    documentation lists the other keys (c, embedded, parts, b_prime, alpha, gamma, dense). A number
    with a point is the binary fraction that a program takes it for; "1/10" is exact.
    """
    from ..audit.check import examine, sentence
    from ..findings import Finding
    from ..system.budget import PROVING, limited
    from ..system.process import Say, apart

    document = _document(file)
    document |= {
        key: value for key, value in (("order", order), ("digits", digits)) if value is not None
    }

    def program(tell: Say) -> None:
        with limited(PROVING):
            tell([x.as_json() for x in examine(document)], None)

    try:
        said = apart(program, PROVING)
        if not said.messages:
            raise said.error(PROVING)
    except BudgetError as error:
        complain(f"{file}: {error}, and nothing was decided")
        return INTERNAL
    findings = [Finding.from_json(x) for x in said.messages[0]]
    if form == "json":
        say(json_text([x.as_json() for x in findings]))
    else:
        for x in findings:
            say(one_line(sentence(x), limit=2000))
    verdicts = {x.verdict for x in findings}
    if Verdict.FAILS in verdicts:
        return FAILED
    return INTERNAL if Verdict.OPEN in verdicts else HOLDS


def _text(file: str) -> str:
    try:
        if file == "-":
            return sys.stdin.read(_MOST_TEXT + 1)
        # a pipe of the shell has no name; one that has may have no writer, and opening it waits
        if Path(os.path.realpath(file)).is_fifo():
            raise UsageError(f"{file} is a named pipe; give a file, or - for the standard input")
        with Path(file).open(encoding="utf-8") as source:
            return source.read(_MOST_TEXT + 1)
    except UnicodeDecodeError:
        raise UsageError(f"{file} is not UTF-8 text, which a tableau is") from None
    except OSError as error:
        raise UsageError(f"{file} cannot be read ({error.strerror})") from None


def _parsed(text: str) -> Any:
    """JSON, or TOML where it is none; what begins as an object of JSON is meant as one."""
    import json

    from ..audit.numbers import Double
    from ..catalogue.strict_json import unique
    from ..catalogue.strict_toml import loads

    try:
        return json.loads(text, parse_float=Double, object_pairs_hook=unique)
    except ValueError:
        if text.lstrip().startswith("{"):
            raise
    return loads(text, parse_float=Double)


def _document(file: str) -> dict[str, Any]:
    text = _text(file).removeprefix("\ufeff")  # a mark that some shells and editors write first
    where = "the standard input" if file == "-" else file
    if not text.strip():
        raise DataError(f"{where} is empty; {_EXAMPLE}")
    if len(text) > _MOST_TEXT:
        raise DataError(f"{where} has more than {_MOST_TEXT} characters, which no tableau has")
    try:
        document = _parsed(text)
    except (ValueError, RecursionError) as error:
        shown = str(error).splitlines()[0] if str(error) else "brackets nested too deep"
        raise DataError(
            f"{where} is neither a JSON object nor TOML ({shown}); {_EXAMPLE}"
        ) from None
    if not isinstance(document, dict):
        raise DataError(f"{where} must hold one object with A and b")
    return document


@click.command(short_help="Check all tableaux in the sources of a code.")
@click.argument("source", type=click.Path(path_type=Path), metavar="SOURCE")
@click.option(
    "--format",
    "form",
    type=Word(READ),
    required=True,
    help="Language or package in whose notation SOURCE writes its tables.",
)
@click.option("--all", "every", is_flag=True, help="Show the tables that are right, too.")
@click.option("--fast", is_flag=True, help="Do not look for the entry that is wrong.")
@on_option
def audit(source: Path, form: str, every: bool, fast: bool, on: str | None) -> int:
    """Check every tableau in a file or checkout: one line of JSON each, then a count.

    Nothing in the sources is executed. A table that is not understood is listed as unread, with its
    line, and the audit goes on. Exit code 1 when a table is wrong.
    """
    from ..audit.judge import summary
    from ..audit.sources import audit as examine
    from ..compute import executor

    records = []
    with executor(on) as where:
        for record in examine(source, form, search=not fast, on=where):
            records.append(record)
            if every or record["status"] not in ("right", "found", "digits"):
                say(canonical.one_line(plain(record)))
    counts = summary(records)
    tables = counted(len(records), "table")
    complain(f"{tables}: " + ", ".join(f"{n} {x}" for x, n in counts.items()))
    return FAILED if counts.get("wrong") else HOLDS
