"""``glmref feed``: everything as static files that others read without glmref."""

from __future__ import annotations

from pathlib import Path

import click

from ..errors import UsageError
from ..views.tables import one_line
from .certifying import write_certificates
from .output import FAILED, HOLDS, complain, complete_method, say


@click.command(short_help="Write methods, verdicts, audits and problems as static files.")
@click.option(
    "--output",
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
@click.option(
    "--diff",
    nargs=2,
    type=click.Path(path_type=Path, file_okay=False),
    metavar="OLD NEW",
    help="Print what changed between two feeds.",
)
def feed(output: Path | None, chosen: tuple[str, ...], diff: tuple[Path, Path] | None) -> int:
    """Write the feed, or compare two.

    The feed has one JSON file a method, certificates, audits, vectors and problems, each with its
    schema; docs/feed.md describes it. With --diff the exit code is 1 where the new feed breaks the
    promise of that page.
    """
    from ..exchange.feed import output_folder, write_feed
    from ..exchange.feed_changes import changes

    if (output is None) == (diff is None):
        raise UsageError("give either --output DIR or --diff OLD NEW")
    if diff is not None:
        if chosen:
            raise UsageError("--methods goes with --output, not with --diff")
        found = changes(*diff)
        for line in (*found.allowed, *(f"breaks the promise: {x}" for x in found.broken)):
            say(one_line(line))
        say(f"{len(found.allowed)} allowed, {len(found.broken)} not")
        return FAILED if found.broken else HOLDS
    from ..catalogue.files import names

    assert output is not None
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
