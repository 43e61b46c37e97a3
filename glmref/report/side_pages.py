"""Pages beside methods and runs: errata, audited codes, how it was measured."""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Mapping
from typing import Any

from markupsafe import Markup

from ..catalogue.audits import STATUSES, audited_codes, named
from ..catalogue.errata import VERDICTS, load_errata
from .markup import SEARCH, Column, Page, Site, Table, number, render, wrapped
from .store import Results


def errata_page(site: Site, names: frozenset[str]) -> Page:
    """Return what the thesis prints beside what is right."""
    records = load_errata()
    counts = ", ".join(f"{sum(x.verdict == v for x in records)} {v}" for v in VERDICTS)
    cells = [
        [
            x.where, x.printed, x.right,
            Markup('<span class="{0}">{0}</span>').format(x.verdict), x.proof,
            Markup(", ").join(site.link(f"method-{m}", m) if m in names else m for m in x.method),
        ]
        for x in records
    ]  # fmt: skip
    titles = ("where", "printed", "right", "verdict", "proof", "data")
    table = Table("errata", f"{len(cells)} statements", [Column(x, x) for x in titles], cells, True)
    body = render("errata.html", counts=counts, table=table)
    return Page("errata", "Errata of the thesis", body, "errata")


# --- audited codes ------------------------------------------------------------------------------

#: Page of the audited codes; classes of the style sheet by status.
AUDITS, _LOOKS = (
    "audits",
    {"right": "holds", "digits": "open", "wrong": "fails", "question": "open"},
)
_ODD = ("wrong", "question", "digits")


def audits_page(site: Site) -> Page:
    """Return who ships a table and whether it is right: counts by code, and what is wrong."""
    records = audited_codes()
    total = Counter(x["status"] for record in records.values() for x in record["tables"])
    odd = [
        [
            code, x["name"], status_of(x), number(x.get("declared")), number(x.get("found")),
            _marked(named(x)),
            _linked(record, f"/{x['path']}#L{x['line']}", f"line {x['line']}"),
        ]
        for status in _ODD
        for code, record in records.items()
        for x in record["tables"]
        if x["status"] == status
    ]  # fmt: skip
    heads = ("code", "table", "status", "order declared", "found", "what is wrong", "where")
    every = [
        [_linked(record, "", code), record["source"]["date"], str(len(record["tables"]))]
        + [number(record["counts"].get(x, 0)) for x in STATUSES]
        for code, record in records.items()
    ]
    columns = [Column(x, x) for x in ("code", "commit of", "tables", *STATUSES)]
    body = render(
        "audits.html",
        tables=total.total(), codes=len(records), counts={x: total[x] for x in STATUSES},
        odd=Table("odd", f"{len(odd)} tables that are not right", [Column(x, x) for x in heads],
                  odd, True),
        every=Table("codes", f"{len(every)} codes", columns, every, True),
        search=site.href(SEARCH), docs=site.docs,
    )  # fmt: skip
    return Page(AUDITS, "Who ships it, is it right?", body, "audited codes")


def status_of(table: Mapping[str, Any]) -> str:
    """Return the status of an audited table, in the colour of its verdict."""
    word = str(table["status"])
    if word not in _LOOKS:
        return word
    return Markup('<span class="{}">{}</span>').format(_LOOKS[word], word)


def _linked(record: Mapping[str, Any], path: str, words: str) -> Markup:
    """Return the link to a place in the sources of a code, of the commit that was read."""
    source = record["source"]
    kind = "blob" if path else "tree"
    address = f"{source['page']}/{kind}/{source['commit']}{path}"
    return Markup('<a href="{}">{}</a>').format(address, words)


def _marked(text: str) -> str:
    """Return a sentence whose names in backquotes are set as code."""
    parts = re.split(r"`([^`]*)`", text)
    marked = [Markup("<code>{}</code>").format(x) if k % 2 else x for k, x in enumerate(parts)]
    return wrapped(Markup("").join(marked))


# --- how it was measured ------------------------------------------------------------------------


def measured_page(results: Results, version: str) -> Page:
    """Write machines, versions, files, and what could not be shown."""
    places: dict[str, int] = {}
    for record in results.records:
        where = record.get("where")
        said = json.dumps(where if isinstance(where, Mapping) else {}, sort_keys=True)
        places[said] = places.get(said, 0) + 1
    body = render(
        "measured.html",
        version=version,
        machines=[(json.loads(text), count) for text, count in places.items()],
        files=results.files,
        odd=results.odd,
    )
    return Page("measured", "How it was measured", body, "how measured")
