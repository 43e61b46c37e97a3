"""Tables of a page: each stands between ``<!-- table: NAME -->`` and ``<!-- end of table -->``."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from pathlib import Path


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
