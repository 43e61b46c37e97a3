"""``glmref feed``: everything as static files that others read without glmref."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import UsageError
from ..views.tables import one_line
from .certifying import write_certificates
from .output import HOLDS, complain, complete_method, say


@click.command(short_help="Write methods, verdicts, audits and problems as static files.")
@click.option(
    "--output",
    required=True,
    type=click.Path(path_type=Path, file_okay=False),
    metavar="DIR",
    help="Folder in which the folder v1 is made.",
)
@click.option(
    "--methods",
    "chosen",
    multiple=True,
    metavar="NAME",
    shell_complete=complete_method,
    help="These methods only (may be repeated).",
)
def feed(output: Path, chosen: tuple[str, ...]) -> int:
    """Write the feed: one JSON file a method, certificates, audits, vectors and problems.

    Each has its schema; docs/feed.md describes it.
    """
    from ..catalogue.files import names
    from ..exchange.feed import output_folder, write_feed

    known = names("all")
    unknown = [name for name in chosen if name not in known]
    if unknown:
        raise UsageError(f"`--methods {one_line(unknown[0])}`: the feed has shipped methods only")
    root = output_folder(output)
    count, missing = write_certificates(list(chosen) or known, root / "certificates")
    for line in missing:
        complain(f"no certificate: {line}")
    say(f"{write_feed(root, chosen)} methods, {count} certificates: {one_line(output)}")
    return HOLDS
