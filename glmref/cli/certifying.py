"""``glmref certify``: certificates that others can check."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import click

from ..catalogue.canonical import one_line
from ..errors import UsageError
from ..system.files import make_folder, write_text
from .output import BAD_INPUT, HOLDS, complain, complete_method, say


@click.command(short_help="Write certificates that others can check.")
@click.argument("name", metavar="NAME|FILE", shell_complete=complete_method)
@click.option("--output", type=click.Path(file_okay=False), help="Folder for one file a claim.")
def certify(name: str, output: str | None) -> int:
    """Write what was proved about the claims of a method, with all that a check of it needs.

    Without --output the certificates go to stdout, one line of JSON each; a claim
    without a certificate is named on stderr, with the reason. docs/certificates.md specifies the
    format.
    """
    written = 0
    for claim, found in _certificates(name):
        if isinstance(found, str):
            complain(f"{claim}: no certificate: {found}")
            continue
        written += 1
        if output is None:
            say(one_line(found))
        else:
            _write(Path(output), found)
    if not written:
        raise UsageError(f"no claim of {name!r} has a certificate")
    return HOLDS if written else BAD_INPUT


def _certificates(name: str) -> Iterator[tuple[str, dict[str, Any] | str]]:
    from ..catalogue.lookup import path_of, read_method
    from ..prove.certificate import certificates_of
    from ..prove.verifier import budget_of, claims_of, facts_for
    from ..system.budget import limited

    path = path_of(name)
    doc, method = read_method(path)
    with limited(budget_of(path)):
        facts = facts_for(method)
    claims = claims_of(method)
    broken = doc.get("broken")
    if broken is not None:
        claims = {broken["claim"]: claims[broken["claim"]]}
    with limited(budget_of(path)):
        statements = {
            claim: (declared, facts.judge(claim, declared)) for claim, declared in claims.items()
        }
        found = list(certificates_of(facts, statements))
    yield from found


def _write(folder: Path, certificate: dict[str, Any]) -> None:
    make_folder(folder)
    statement = certificate["statement"]
    path = folder / f"{statement['method']}.{statement['claim']}.json"
    write_text(path, one_line(certificate) + "\n")


def write_certificates(names: list[str], folder: Path) -> tuple[int, list[str]]:
    """Write the certificates of many files: how many, and what has none, with the reason."""
    count, missing = 0, []
    for name in names:
        for claim, found in _certificates(name):
            if isinstance(found, str):
                missing.append(f"{name} {claim}: {found}")
            else:
                _write(folder, found)
                count += 1
    return count, missing
