"""``glmref analyze``, and ``list --errata``: what a method is, and what the thesis prints."""

from __future__ import annotations

import sys
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from ..errors import BudgetError, UsageError
from ..system.terminal import saying
from ..views.facts import consistent_to_digits
from ..views.tables import Style, columns, csv_text, json_text, one_line
from .output import HOLDS, INTERNAL, Word, complain, complete_method, format_option, say

if TYPE_CHECKING:
    from ..catalogue.errata import Erratum

_VERDICTS = ("right", "wrong", "misprint", "incomplete", "false")


@click.command(short_help="Compute the properties of a method.")
@click.argument("name", metavar="NAME|FILE", shell_complete=complete_method)
@click.option("--modified", is_flag=True, help="The modified equation through order 6, too.")
@format_option()
def analyze(name: str, modified: bool, form: str) -> int:
    """Compute order, error, forms, symmetry and stability of a method, whatever its claims.

    Exit code 3 when something could not be decided.
    """
    from ..prove.analysis import plain_ends, record_of

    try:
        with saying(f"analyzing {one_line(name)} ..."):
            record, further = record_of(name, _with_modified if modified else _measured)
    except BudgetError as error:
        complain(f"{name}: {error}, and what the method is was not decided")
        return INTERNAL
    measured = further
    if modified:
        measured, record["modified"] = further or [{}, {"why": "not found within the budget"}]
    if measured and form != "table":
        record["stability_measured"] = plain_ends(measured)
    if form == "json":
        say(json_text(record))
    elif form == "csv":
        say(csv_text([("fact", "value"), *record.items()]))
    else:
        say(_page(record, measured, Style.of(sys.stdout)))
    decisions = [record[k]["holds"] for k in ("g_symplectic", "symmetric") if k in record]
    decisions += [
        record[k]
        for k in ("explicit", "preconsistent", "consistent", "zero_stable", "parasitism_free")
        if k in record and not (k == "consistent" and consistent_to_digits(record))
    ]
    return INTERNAL if None in decisions else HOLDS


def _page(record: Mapping[str, Any], measured: Mapping[str, float] | None, style: Style) -> str:
    """Return an analysis as lines of name and value."""
    from ..views.facts import analysis_rows

    name = style.paint(one_line(record["method"]) or "(unnamed)", "bold")
    rows = [
        (title if i == 0 else "", line)
        for title, text in analysis_rows(record, measured or {})
        for i, line in enumerate(textwrap.wrap(text, max(style.width - 45, 30)) or [""])
    ]
    return "\n".join([name, columns(rows, style=style)])


def _with_modified(method: Any, record: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return ends of the stability intervals, and the modified equation or why there is none."""
    from ..errors import GlmrefError
    from ..scenes.modified import modified

    try:
        found = modified(method).as_json()
    except GlmrefError as error:
        found = {"why": str(error)}
    return [_measured(method, record), found]


def _measured(method: Any, record: Mapping[str, Any]) -> dict[str, float]:
    """Return ends of the stability intervals that are not proved, in floating point."""
    from ..measure.stability import interval
    from ..prove.facts import facts_of

    rays = {"real": -1 + 0j, "imaginary": 1j}
    stability = record["stability"]
    open_ = [key for key in rays if key in stability and stability[key] is None]
    return {key: interval(facts_of(method).linear, rays[key]) for key in open_}


verdict_option = click.option("--verdict", type=Word(_VERDICTS), help="Errata of this kind only.")
method_option = click.option("--method", metavar="NAME", help="Errata about this data file only.")


def list_errata(text: str, verdict: str | None, method: str | None, form: str) -> int:
    """List errata: one ID, or all that mention a text, of a verdict, about a method."""
    from ..catalogue.errata import erratum, find_errata, load_errata

    known = {record.id for record in load_errata()}
    found = find_errata("" if text in known else text, verdict=verdict, method=method)
    if text in known:
        found = tuple(record for record in found if record.id == text)
    if not found:
        if text and not (verdict or method):
            erratum(text)  # names the nearest ids
        if method:
            from ..catalogue.lookup import path_of

            path_of(method)  # names the nearest methods
        raise UsageError("no erratum is like that; see `glmref list --errata`")
    if form == "json":
        say(json_text({"format": "glmref-errata-1", "errata": [r.as_json() for r in found]}))
    elif form == "csv":
        keys = list(found[0].as_json())
        say(csv_text([keys, *([r.as_json()[k] for k in keys] for r in found)]))
    else:
        style = Style.of(sys.stdout)
        say("\n\n".join(_record(record, style) for record in found))
        if not text:
            say(f"\n{len(found)} records; right or wrong, each names the test that proves it")
    return HOLDS


def _record(record: Erratum, style: Style) -> str:
    color = "green" if record.verdict == "right" else "red"
    head = f"{style.paint(record.id, 'bold')}  {style.paint(record.verdict, color)}, {record.proof}"
    rows = {
        "where": record.where,
        "printed": record.printed,
        "right": record.right,
        "method": ", ".join(record.method),
        "test": record.test or "",
    }
    lines = [f"{head}"]
    for key, text in rows.items():
        if text:
            margin = f"  {key:<8}"
            lines += textwrap.wrap(
                one_line(text),
                style.width,
                initial_indent=margin,
                subsequent_indent=" " * len(margin),
                break_long_words=False,
                break_on_hyphens=False,
            )
    return "\n".join(lines)
