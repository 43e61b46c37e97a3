"""``glmref lint``: the tableaux of a repository, for code hosts and hooks."""

from __future__ import annotations

from pathlib import Path

import click

from ..views import sarif as formats
from ..views.sarif import Level
from ..views.tables import counted
from .output import BAD_INPUT, FAILED, HOLDS, complain, file_option, format_option, say

_FORMATS = {"table": formats.text, "github": formats.github, "sarif": formats.sarif}


@click.command(short_help="Check the tableaux of a repository, line by line.")
@click.argument("places", nargs=-1, type=click.Path(path_type=Path), metavar="[FILE|FOLDER]...")
@click.option("--since", metavar="COMMIT", help="Only tables with lines changed since COMMIT.")
@click.option("--strict", is_flag=True, help="Show notes; exit with 1 for them and for warnings.")
@format_option(tuple(_FORMATS))
@file_option("--sarif", "Write SARIF, too.")
@file_option("--badge", "Write the JSON of a shields.io endpoint, too.")
@click.option("--allow-empty", is_flag=True, help="Exit with 0 where no table is read.")
def lint(
    places: tuple[Path, ...],
    since: str | None,
    strict: bool,
    form: str,
    sarif: Path | None,
    badge: Path | None,
    allow_empty: bool,
) -> int:
    """Check all tableaux in files and folders, by default the folder where this runs.

    Method files and plain tableaux (JSON, TOML) are checked as by `glmref verify`, sources in the
    formats that their ending and words suggest as by `glmref audit`; other files are left out. An
    error is a claim that fails; a warning is a question, or a claim that is not decided; a note is
    what looks like a table and could not be read. Exit code 1 for errors, 2 when no table is read
    (0 with --since and --allow-empty).
    """
    from ..audit.lint import changed_since
    from ..audit.lint import lint as find
    from .auditing import findings_of

    root = Path.cwd()
    changed = None if since is None else changed_since(root, since)
    found = find(places or (Path(),), root, findings_of, changed, notes=strict)
    if found.remarks or form == "sarif":
        say(_FORMATS[form](found.remarks))
    if sarif is not None:
        sarif.write_text(formats.sarif(found.remarks) + "\n", encoding="utf-8")
    if badge is not None:
        badge.write_text(formats.badge(found.tables, found.remarks) + "\n", encoding="utf-8")
    levels = [x.level for x in found.remarks]
    counts = ", ".join(counted(levels.count(x), str(x)) for x in Level)
    complain(f"{counted(found.tables, 'table')}: {counts}")
    if Level.ERROR in levels or (strict and levels):
        return FAILED
    if found.tables or allow_empty or since is not None:
        return HOLDS
    where = ", ".join(map(str, places)) or "this folder"
    more = "" if strict else "; --strict lists what looks like a table and could not be read"
    complain(f"no table is found in {where}{more}; --allow-empty accepts that")
    return BAD_INPUT
