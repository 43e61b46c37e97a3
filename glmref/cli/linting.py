"""``glmref audit --lines``: the tableaux of a repository, for code hosts and hooks."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from ..findings import Finding
from ..views import sarif as formats
from ..views.sarif import Level
from ..views.tables import counted
from .output import BAD_INPUT, FAILED, HOLDS, complain, say

LINES = {"table": formats.text, "github": formats.github, "sarif": formats.sarif}


def by_lines(
    places: tuple[Path, ...],
    examine: Callable[[str], list[Finding]],
    *,
    strict: bool,
    form: str | None,
    since: str | None,
    sarif: Path | None,
    badge: Path | None,
    allow_empty: bool,
) -> int:
    """Say what is wrong with the tableaux in files and folders, and return the exit code."""
    from ..audit.lint import changed_since
    from ..audit.lint import lint as find

    root = Path.cwd()
    changed = None if since is None else changed_since(root, since)
    found = find(places or (Path(),), root, examine, changed, notes=strict)
    if found.remarks or form == "sarif":
        say(LINES[form or "table"](found.remarks))
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
