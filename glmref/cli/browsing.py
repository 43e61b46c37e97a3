"""``glmref list`` and ``show``: what the catalogue holds, and what the thesis prints."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import click

from ..catalogue.claims import meant_order
from ..catalogue.keys import BLOCKS
from ..errors import UsageError
from ..system.shown import Drawing
from ..views.tables import Style, json_text, one_line
from .describing import list_errata, method_option, verdict_option
from .output import HOLDS, Word, complete_method, count_option, format_option, say, say_rows

_METHODS = ("name", "class", "order", "status", "title")
_BROKEN = ("name", "class", "refutes", "flag", "title")


@click.command("list", short_help="List the shipped methods, or the errata of the thesis.")
@click.argument("text", default="", metavar="[ID|TEXT]")
@click.option("--class", "kind", type=Word(sorted(BLOCKS)), help="This class only.")
@click.option("--broken", is_flag=True, help="The files that are wrong on purpose.")
@click.option(
    "--errata",
    "printed",
    is_flag=True,
    help="What the thesis prints, and what is right: one ID, or all that mention TEXT.",
)
@verdict_option
@method_option
@format_option()
def list_(
    text: str,
    kind: str | None,
    broken: bool,
    printed: bool,
    verdict: str | None,
    method: str | None,
    form: str,
) -> int:
    """List the shipped methods: name, class, order claimed, status of the source, title."""
    from ..catalogue.lookup import document, names

    if printed:
        if kind or broken:
            raise UsageError("--errata lists no methods; leave --class and --broken away")
        return list_errata(text, verdict, method, form)
    if text or verdict or method:
        raise UsageError("ID, TEXT, --verdict and --method choose among --errata")

    rows = [_row(document(name)) for name in names("broken" if broken else "methods")]
    rows = [row for row in rows if kind in (None, row["class"])]
    keys = _BROKEN if broken else _METHODS
    cells = [["" if row[k] is None else str(row[k]) for k in keys] for row in rows]
    if form == "json":
        say(json_text({"format": "glmref-list-1", "methods": rows}))
    else:
        say_rows(form, keys, cells)
    return HOLDS


def _row(doc: Mapping[str, Any]) -> dict[str, Any]:
    broken = doc.get("broken", {})
    return {
        "name": doc["name"],
        "class": doc["class"],
        "title": doc.get("title", ""),
        "order": meant_order(doc["claims"]),
        "status": doc["source"]["status"],
        "citation": doc["source"]["citation"],
        "where": doc["source"]["where"],
        "refutes": broken.get("claim"),
        "flag": broken.get("flag"),
        "why": broken.get("why"),
    }


@click.command(short_help="Show a tableau as in a paper.")
@click.argument(
    "names", nargs=-1, required=True, metavar="NAME|FILE...", shell_complete=complete_method
)
@click.option("--bibtex", is_flag=True, help="BibTeX of the sources and of the files instead.")
@count_option("--decimal", 150, "Decimals with N significant digits instead of exact expressions.")
@click.option(
    "--plot",
    type=click.Path(dir_okay=False, writable=True, path_type=Path),
    metavar="FILE.svg",
    help="Draw stability region, eigenvalues and sparsity into this file.",
)
def show(names: tuple[str, ...], bibtex: bool, decimal: int | None, plot: Path | None) -> int:
    """Show methods' tableaux as one reads them in a paper, with their sources."""
    if bibtex:
        if decimal is not None or plot is not None:
            raise UsageError("--bibtex writes no tableau; leave --decimal and --plot away")
        from ..views.bibtex import entries

        say("\n\n".join(entries(dict.fromkeys(names))))
        return HOLDS
    if plot is not None and len(names) > 1:
        raise UsageError("--plot draws one method; name one")
    for number, name in enumerate(dict.fromkeys(names)):
        if number:
            say("")
        _show(name, decimal, plot)
    return HOLDS


def _show(name: str, decimal: int | None, plot: Path | None) -> None:
    from ..catalogue.lookup import load, path_of
    from ..prove.verifier import budget_of
    from ..system.budget import limited
    from ..views.show import show as page

    if plot is not None and plot.suffix != ".svg":
        raise UsageError(f"--plot writes SVG; give a name such as {plot.stem}.svg")
    method = load(name)
    with limited(budget_of(path_of(name))):
        text = page(method, decimal=decimal, style=Style.of(sys.stdout))
    say(text)
    if plot is not None:
        from ..views.portrait import portrait

        Drawing(portrait(method)).save(plot)
        say(f"\nwrote {one_line(plot)}")
