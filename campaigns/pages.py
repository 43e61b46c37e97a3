"""Tables of pages: each stands between ``<!-- table: NAME -->`` and ``<!-- end of table -->``.

    python -m campaigns.pages

computes all of them anew from the files in data.
"""

import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
#: Page -> name of a table -> what writes it.
Pages = Mapping[Path, Mapping[str, Callable[[], str]]]
#: Modules with :data:`Pages` of their own, called ``PAGES``, of this package and others.
WRITERS = (
    *(
        "tools.measure.engine_tables",
        ".audited_codes",
        ".audited_orders",
        ".gallery",
        ".long_survey",
    ),
    *(".parasitic_losses", ".scene_results", ".order6.tables"),
    *(".partitioned.tables", ".partitioned.multistep_tables", ".partitioned.nonseparable"),
    ".partitioned.strong",
)


def measured(name: str) -> dict[str, Any]:
    """Return a file of data/measurements."""
    path = ROOT / "data" / "measurements" / f"{name}.json"
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return found


def row(*cells: object) -> str:
    """Return a row of a table in Markdown."""
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def table(head: Sequence[object], rows: Iterable[str]) -> str:
    """Return a table in Markdown."""
    return "\n".join([row(*head), "|" + "---|" * len(head), *rows])


def markdown(head: Sequence[object], rows: Iterable[Iterable[object]]) -> str:
    """Return a table in Markdown from the cells of its head and of its rows."""
    return table(head, (row(*cells) for cells in rows))


def filled(text: str, tables: Mapping[str, Callable[[], str]]) -> str:
    """Return a page in Markdown with its tables computed anew, by their names.

    Raises
    ------
    ValueError
        If a table has no place in the page, or more than one.
    """
    for name, write in tables.items():
        pattern = rf"(<!-- table: {name} -->\n)(?:(?!<!--).)*(<!-- end of table -->)"
        table = write()
        text, count = re.subn(
            pattern, lambda found, table=table: f"{found[1]}{table}\n{found[2]}", text, flags=re.S
        )
        if count != 1:
            raise ValueError(f"the page has {count} places for the table {name}, not one")
    return text


def all_pages() -> dict[Path, dict[str, Callable[[], str]]]:
    """Return the tables of all pages, from all :data:`WRITERS`."""
    found: dict[Path, dict[str, Callable[[], str]]] = {}
    for module in WRITERS:
        pages: Pages = import_module(module, "campaigns").PAGES
        for page, tables in pages.items():
            found[page] = {**found.get(page, {}), **tables}
    return found


def write(pages: Pages) -> None:
    """Put tables into their pages."""
    for page, tables in pages.items():
        page.write_text(filled(page.read_text(encoding="utf-8"), tables), encoding="utf-8")


if __name__ == "__main__":
    write(all_pages())
