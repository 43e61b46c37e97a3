"""``glmref verify --certificates``: certificates that others can check."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, nullcontext
from pathlib import Path
from typing import Any

import click

from ..catalogue.canonical import one_line
from ..errors import BudgetError, UsageError
from ..system.files import make_folder, write_text
from .output import BAD_INPUT, HOLDS, INTERNAL, complain, complete_method, say


@click.command(short_help="Write certificates that others can check.")
@click.argument("name", metavar="NAME|FILE", shell_complete=complete_method)
@click.option("--output", type=click.Path(file_okay=False), help="Folder for one file a claim.")
def certify(name: str, output: str | None) -> int:
    """Write what was proved about the claims of a method, with all that a check of it needs.

    Without --output the certificates go to stdout, one line of JSON each; a claim
    without a certificate is named on stderr, with the reason. docs/certificates.md specifies the
    format.
    """
    return write_lines(name, output)


def write_lines(name: str, output: str | None = None) -> int:
    """Write the certificates of a method to stdout, or into a folder; return the exit code."""
    written = 0
    try:
        certificates = _certificates(name)
    except BudgetError as error:
        complain(f"{name}: {error}, and no certificate was written")
        return INTERNAL
    for claim, found in certificates:
        if isinstance(found, str):
            complain(f"{claim}: no certificate: {found}")
            continue
        written += 1
        if output is None:
            say(one_line(found))
        else:
            write_certificate(Path(output), found)
    if not written:
        raise UsageError(f"no claim of {name!r} has a certificate")
    return HOLDS if written else BAD_INPUT


#: A claim, and its certificate or the reason why it has none.
_Found = tuple[str, Mapping[str, Any] | str]


def _certificates(name: str) -> list[_Found]:
    """Return certificates of a file; those with a budget are made apart and lost if that is ended.

    Raises
    ------
    BudgetError
        Where the budget is spent.
    """
    from ..catalogue.lookup import path_of, unread
    from ..prove.verifier import budget_of
    from ..system.budget import READING, limited
    from ..system.process import Say, apart

    path = path_of(name)
    seconds = budget_of(path)
    if seconds is None:
        return list(_made(path, nullcontext))

    def program(say: Say) -> None:
        def proofs() -> AbstractContextManager[None]:
            say(None, seconds)
            return limited(seconds)

        for claim, found in _made(path, proofs):
            say([claim, found], None)

    said = apart(program, READING)
    if said.ended:
        raise said.error(seconds) if said.messages else unread(path, said)
    return [(claim, found) for claim, found in said.messages[1:]]


def _made(path: Path, proofs: Callable[[], AbstractContextManager[None]]) -> Iterator[_Found]:
    """Make the certificates of a file; what surrounds the proofs is entered once it is read."""
    from ..catalogue.lookup import read_method
    from ..prove.verifier import asked_of, facts_for

    doc, method = read_method(path)
    claims = asked_of(method, doc.get("broken"))
    with proofs():
        facts = facts_for(method)
        for claim, declared in claims.items():
            yield claim, facts.judge(claim, declared).certificate


def write_certificate(folder: Path, certificate: Mapping[str, Any]) -> None:
    """Write a certificate into a folder, as a file with the names of the method and the claim."""
    make_folder(folder)
    statement = certificate["statement"]
    path = folder / f"{statement['method']}.{statement['claim']}.json"
    write_text(path, one_line(certificate) + "\n", sync=False)


def write_certificates(names: list[str], folder: Path) -> tuple[int, list[str]]:
    """Write the certificates of many files: how many, and what has none, with the reason.

    A file whose proofs exceed its budget costs no other one its certificates.
    """
    count, missing = 0, []
    for name in names:
        try:
            certificates = _certificates(name)
        except BudgetError as error:
            missing.append(f"{name}: {error}")
            complain(f"{missing[-1]}, and no certificate of it was written")
            continue
        for claim, found in certificates:
            if isinstance(found, str):
                missing.append(f"{name} {claim}: {found}")
            else:
                write_certificate(folder, found)
                count += 1
    return count, missing
