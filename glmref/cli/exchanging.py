"""``glmref convert``: methods as files of other people, and back."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from ..errors import UsageError
from ..system.files import one_name, read_text, write_text
from ..views.tables import one_line
from .output import HOLDS, Word, complain, complete_method, count_option, file_option, say

#: Repeated from :data:`glmref.exchange.export.TARGETS` and
#: :data:`glmref.exchange.import_tables.READ`, so that ``--help`` loads neither; a test compares
#: them.
TARGETS = (
    *("c", "c++", "fortran", "julia", "rust", "python", "jax"),
    *("latex", "sundials", "petsc", "diffrax", "ordinarydiffeq", "rungekutta.jl", "json", "csv"),
)
READ = ("json", "csv", "sundials", "petsc", "diffrax", "ordinarydiffeq", "rungekutta.jl")


class _Target(Word):
    """A target by any of its names, in capitals or not."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the target."""
        from ..exchange.export import ALIASES

        word = str(value).lower()
        return super().convert(ALIASES.get(word, word), param, ctx)


@click.command(short_help="Write a method as source code or as another package's table, and back.")
@click.argument("name", metavar="NAME|FILE", shell_complete=complete_method)
@click.option("--from", "form", type=Word(READ), help="Whose table FILE is; else a method file.")
@click.option("--to", "target", type=_Target(TARGETS), help="What to write; else a method file.")
@count_option("--digits", 150, "Decimals with N digits; by default what the target holds best.")
@file_option("--output", "Write to this file instead of stdout.")
def convert(
    name: str, form: str | None, target: str | None, digits: int | None, output: Path | None
) -> int:
    """Write a method as a stepper without dependencies, or in the syntax of another package.

    The languages give functions start, step, finish and integrate; pairs and splittings take the
    two halves of the right-hand side separately. A format that cannot hold the method says so, and
    what is left out is said on stderr. With --from, FILE is a table of another package; its method
    file claims the order and the abscissae that the table states, `glmref verify` checks them, and
    nothing in the table is executed.
    """
    if form is None and target is None:
        raise UsageError("say what to write with --to, or whose table it is with --from")
    if target is None:
        if digits is not None:
            raise UsageError("--digits is for --to; a method file keeps what the table says")
        return _read(Path(name), str(form), output)
    if form is None:
        return _written(name, name, target, digits, output)
    from ..catalogue.reader import load_document

    method = load_document(_table(Path(name), form))
    return _written(method, method.name, target, digits, output)


def _written(method: Any, name: str, target: str, digits: int | None, output: Path | None) -> int:
    """Write a method, given or named, to a target, and say what is left out."""
    from ..catalogue.lookup import method_of
    from ..exchange.export import export as write
    from ..exchange.header import left_out

    _write(write(method, to=target, digits=digits), output)
    absent = left_out(method_of(method), target)
    if absent:
        complain(f"{name}: left out of what is written: {', '.join(absent)}")
    return HOLDS


def _table(file: Path, form: str) -> dict[str, Any]:
    """Read a table of another package as a document."""
    from ..catalogue.strict_json import MAX_BYTES
    from ..exchange.import_tables import read_table

    return read_table(read_text(file, MAX_BYTES), form, name=file.stem, where=one_name(file))


def _read(file: Path, form: str, output: Path | None) -> int:
    from ..catalogue.canonical import canonical

    _write(canonical(_table(file, form)), output)
    return HOLDS


def _write(text: str, output: Path | None) -> None:
    if output is None:
        say(text.removesuffix("\n"))
        return
    write_text(output, text)
    say(f"wrote {one_line(output)}")
