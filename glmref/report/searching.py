"""The page on which methods and verdicts are searched: a row for each that can be found."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..catalogue.audits import audited_codes, named
from .markup import SEARCH, Column, Page, Site, Table, flat, number, render, wrapped
from .methods import claimed
from .side_pages import AUDITS, status_of
from .store import Results

_COLUMNS = tuple(Column(x, x) for x in ("name", "verdict", "says", "what", "proof"))


def search_page(site: Site, results: Results, methods: Sequence[str], *, catalogue: bool) -> Page:
    """Return the page: of every method its claims, and of every audited code its tables."""
    rows = [*_claims(site, results, methods), *(_tables(site) if catalogue else ())]
    caption = f"{len(rows)} claims" + " and audited tables" * catalogue
    table = Table("found", caption, _COLUMNS, rows, found=True)
    return Page(SEARCH, "Search", render("search.html", table=table), "search")


def _claims(site: Site, results: Results, methods: Sequence[str]) -> Iterator[list[str]]:
    for name in methods:
        link = site.link(f"method-{name}", name)
        for claim, declared, verdict, proof in claimed(results, name):
            yield [link, verdict, wrapped(f"{claim}: {flat(declared)}"), "claim", proof]


def _tables(site: Site) -> Iterator[list[str]]:
    for code, record in audited_codes().items():
        for table in record["tables"]:
            said = named(table).replace("`", "")
            order = f"order {number(table.get('declared'))}, found {number(table.get('found'))}"
            name = site.link(AUDITS, f"{code}, {table['name']}")
            says = wrapped(f"{order}; {said}" if said else order)
            yield [name, status_of(table), says, "audited table", ""]
