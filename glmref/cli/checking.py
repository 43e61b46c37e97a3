"""``glmref verify``: recompute every claim of data files."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ..catalogue.claims import CLAIMS
from ..errors import UsageError
from ..findings import Finding, Verdict
from ..system.process import INTERRUPTED
from ..views.tables import FORMATS, Style
from .auditing import check_plain, digits_option, is_in_words, order_option
from .certifying import write_lines
from .output import (
    BAD_INPUT,
    FAILED,
    HOLDS,
    INTERNAL,
    Progress,
    Word,
    complain,
    complete_method,
    format_option,
    on_option,
    say,
)

if TYPE_CHECKING:
    from .parallel import Checked


@click.command(short_help="Recompute every claim, with the kind of proof.")
@click.argument("names", nargs=-1, metavar="[NAME|FILE]...", shell_complete=complete_method)
@format_option(FORMATS)
@click.option(
    "--only",
    multiple=True,
    type=Word(sorted(CLAIMS)),
    metavar="CLAIM",
    help="Check this claim only; may be given several times.",
)
@click.option(
    "--certificates",
    type=click.Path(file_okay=False),
    metavar="DIR|-",
    help="Write the certificate of every claim that has one, a file each; -: those of one method "
    "to stdout, one line of JSON each.",
)
@order_option
@digits_option
@click.option(
    "--budget",
    type=click.FloatRange(min=0, min_open=True),
    metavar="SECONDS",
    help="Processor time for the proofs of each file; 60 for your own, else no limit.",
)
@on_option
@click.option(
    "--no-cache",
    is_flag=True,
    help="Compute everything, and keep nothing for the next time.",
)
def verify(
    names: tuple[str, ...],
    form: str,
    only: tuple[str, ...],
    certificates: str | None,
    order: int | None,
    digits: int | None,
    budget: float | None,
    on: str | None,
    no_cache: bool,
) -> int:
    """Recompute every claim of the methods named, and say how each was proved.

    Without a name all shipped methods are checked, and all files that are wrong on purpose are
    refuted, one line a file. A NAME is one of `glmref list`; a FILE is your own method file, or a
    tableau {"A": .., "b": .., "order": ..} in JSON or TOML, - the standard input. What was decided
    for the same bytes by the same program is not computed again.
    """
    given = order is not None or digits is not None
    others = only or certificates or budget or on or form not in ("table", "json")
    if given and (others or len(names) != 1):
        raise UsageError("--order and --digits are for one plain tableau")
    if given or (len(names) == 1 and not others and is_in_words(names[0], form)):
        return check_plain(names[0], order, digits, form)
    if certificates == "-":
        if len(names) != 1:
            raise UsageError("--certificates - is for one method; give a folder for several")
        return write_lines(names[0])
    from ..catalogue.lookup import names as shipped

    asked = list(dict.fromkeys(names)) or shipped("all")
    report = _Report(form, every=bool(names), width=max(map(len, asked), default=0))
    try:
        with Progress(len(asked) if len(asked) > 8 else 0, "", "file") as progress:
            _check(asked, only, report, progress, budget, on, certificates, keep=not no_cache)
    except KeyboardInterrupt:
        report.finish(len(asked), interrupted=True)
        return INTERRUPTED
    report.finish(len(asked))
    if certificates is not None:
        _count(report.findings, Path(certificates))
    if only and not report.findings and not report.errors:
        raise UsageError(f"none of the files asked for claims {' or '.join(map(repr, only))}")
    return report.code()


def _count(findings: Sequence[Finding], folder: Path) -> None:
    """Say how many certificates were written."""
    names = [f"{x.method}.{x.claim.removeprefix('refutes ')}.json" for x in findings]
    count = sum((folder / x).is_file() for x in names)
    complain(f"{count} certificates written to {folder}, none for {len(names) - count} claims")


def _check(
    names: Sequence[str],
    only: Sequence[str],
    report: _Report,
    progress: Progress,
    budget: float | None,
    on: str | None,
    certificates: str | None,
    *,
    keep: bool,
) -> None:
    from .parallel import check_all

    for checked in check_all(
        names, only, budget=budget, on=on, keep=keep, certificates=certificates
    ):
        with progress.aside():
            report.add(checked)


class _Report:
    """Collects what was found; a table and CSV are written as they grow, the others at the end."""

    def __init__(self, form: str, *, every: bool, width: int) -> None:
        self.form, self.every, self.width = form, every, width
        self.style = Style.of(sys.stdout)
        self.findings: list[Finding] = []
        self.errors: list[tuple[str, str]] = []
        self.bad = self.internal = False
        self.files = 0

    def add(self, checked: Checked) -> None:
        """Take in one file, and write what can be written now."""
        from ..views import tables

        if checked.error:
            self.errors.append((checked.name, checked.error))
            self.internal |= checked.internal
            self.bad |= not checked.internal
            if checked.trace and os.environ.get("GLMREF_DEBUG"):
                click.echo(checked.trace, err=True)
            complain(checked.error)
            return
        first = not self.findings
        self.findings += checked.findings
        self.files += bool(checked.findings)
        if not checked.findings:
            return
        if self.form == "csv":
            say(tables.findings_csv(checked.findings, head=first))
        elif self.form == "table":
            say(
                tables.findings_table(
                    checked.findings, style=self.style, every=self.every, width=self.width
                )
            )

    def finish(self, asked: int, *, interrupted: bool = False) -> None:
        """Write the end of the report: everything that was found so far, complete in itself."""
        from ..views import tables

        if interrupted:
            complain(f"interrupted after {self.files + len(self.errors)} of {asked} files")
        if self.form == "json":
            say(tables.findings_json(self.findings))
        elif self.form == "junit":
            say(tables.findings_junit(self.findings, self.errors))
        elif self.form == "csv" and not self.findings:
            say(tables.findings_csv([]))
        elif self.form == "table" and self.findings:
            say("\n" + tables.tally(self.findings, self.files))

    def code(self) -> int:
        """Return the exit code: bad input before failures before what stayed open."""
        verdicts = {f.verdict for f in self.findings}
        if self.bad:
            return BAD_INPUT
        if Verdict.FAILS in verdicts:
            return FAILED
        return INTERNAL if self.internal or Verdict.OPEN in verdicts else HOLDS
