"""Tables of a page: each stands between ``<!-- table: NAME -->`` and ``<!-- end of table -->``."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from glmref.catalogue.lookup import data_root


def measured(name: str) -> dict[str, Any]:
    """Return a file of data/measurements."""
    path = data_root() / "measurements" / f"{name}.json"
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def row(*cells: object) -> str:
    """Return a row of a table in Markdown."""
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def table(head: Sequence[str], rows: Sequence[str]) -> str:
    """Return a table in Markdown."""
    return "\n".join([row(*head), "|" + "---|" * len(head), *rows])


def filled(text: str, tables: Mapping[str, Callable[[], str]]) -> str:
    """Return a page with its tables computed anew.

    Parameters
    ----------
    text
        The page, in Markdown.
    tables
        Name of a table -> what writes it. Every name must have exactly one place in the page.

    Raises
    ------
    ValueError
        If a table has no place in the page, or more than one.
    """
    for name, write in tables.items():
        pattern = rf"(<!-- table: {name} -->\n)(?:(?!<!--).)*(<!-- end of table -->)"
        table = write().rstrip("\n")
        text, count = re.subn(
            pattern, lambda found, table=table: f"{found[1]}{table}\n{found[2]}", text, flags=re.S
        )
        if count != 1:
            raise ValueError(f"the page has {count} places for the table {name}, not one")
    return text


def write(pages: Mapping[Path, Mapping[str, Callable[[], str]]]) -> None:
    """Put tables into their pages: page -> name of a table -> what writes it."""
    for page, tables in pages.items():
        page.write_text(filled(page.read_text(encoding="utf-8"), tables), encoding="utf-8")
