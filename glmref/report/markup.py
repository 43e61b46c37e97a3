"""HTML as strings: numbers, tables, pages. Whatever comes from a file is escaped here."""

from __future__ import annotations

import base64
import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from html import escape
from importlib.resources import files
from typing import Any
from urllib.parse import quote

__all__ = [
    "Column",
    "Page",
    "Site",
    "Table",
    "counted",
    "escape",
    "flat",
    "number",
    "rows_of",
    "scrolling",
    "wrapped",
]

#: Digits of a number on a page; the stored number agrees to all that are shown.
DIGITS = 6
_LONG = 300  # rows after which a table is folded: laying it out takes most of the time of a load
_WIDE = 40  # characters of a cell that does not wrap
NONE = "–"  # what stands where a record has no number


def number(value: Any) -> str:
    """Return a stored value as the text of a cell.

    >>> number(1.23456789e-10), number(88387), number(float("nan")), number(None), number(True)
    ('1.23457e-10', '88387', 'NaN', '–', 'yes')
    """
    if value is None:
        return NONE
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        if math.isnan(value):
            return "NaN"
        if math.isinf(value):
            return "infinite" if value > 0 else "-infinite"
        return f"{value:.{DIGITS}g}"
    return flat(value) if isinstance(value, list | tuple) else escape(str(value))


def counted(n: int, what: str) -> str:
    """A number and its noun, whose plural has an s."""
    return f"{n} {what}" if n == 1 else f"{n} {what}s"


def flat(value: Any) -> str:
    """A value of any kind, lists and objects included, as the text of a cell."""
    if isinstance(value, Mapping):
        return "; ".join(f"{escape(str(k))}: {flat(x)}" for k, x in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(flat(x) for x in value)
    return number(value)


def wrapped(text: str) -> str:
    """HTML of a cell; one that is long wraps in it."""
    return f'<div class="cell">{text}</div>' if len(text) > _WIDE else text


def scrolling(html: str, label: str) -> str:
    """HTML in a frame that scrolls where a page is narrower, with the keyboard too."""
    told = f'role="region" aria-label="{escape(label)}"'
    return f'<div class="tabled" tabindex="0" {told}>{html}</div>'


@dataclass(frozen=True)
class Column:
    """A column of a table.

    Attributes
    ----------
        key: what the script knows it by. title: what is shown. unit: behind the title.
        linear: whether a picture shows it on a linear axis.
    """

    key: str
    title: str
    unit: str = ""
    linear: bool = False

    @property
    def head(self) -> str:
        """Its cell in the head of the table."""
        unit = f" <small>{escape(self.unit)}</small>" if self.unit else ""
        scale = ' data-scale="linear"' if self.linear else ""
        return f'<th scope=col data-key="{escape(self.key)}"{scale}>{escape(self.title)}{unit}'


@dataclass(frozen=True)
class Table:
    """A table; cells are HTML already. The script finds it by its id and draws from it."""

    id: str
    caption: str
    columns: Sequence[Column]
    cells: Sequence[Sequence[str]]
    sortable: bool = False

    def html(self) -> str:
        """Return it in a frame that scrolls, so that a narrow page does not; a long one folded."""
        if len(self.cells) <= _LONG:
            return self.frame()
        return f"<details><summary>{escape(self.caption)}</summary>{self.frame()}</details>"

    def frame(self) -> str:
        """Return it in its frame, unfolded."""
        # closing tags of rows and cells may be left out in HTML; a page of 5,000 rows is as small
        # as it can be
        head = "".join(column.head for column in self.columns)
        body = "\n".join(rows_of(self.cells))
        kind = ' class="sortable"' if self.sortable else ""
        return (
            f'<div class="scroll" tabindex="0" role="region" aria-label="{escape(self.caption)}">'
            f'<table id="{escape(self.id)}"{kind}><caption>{escape(self.caption)}</caption>'
            f"<thead><tr>{head}</thead><tbody>\n{body}\n</tbody></table></div>"
        )


def figure(
    table: str, across: Sequence[str], up: Sequence[str], label: str, caption: str,
    series: str = "method", *, marks: bool = True, plane: Sequence[str] | None = None,
) -> str:  # fmt: skip
    """A picture that the script draws from a table.

    Args:
        table: id of the table. across, up: keys of columns to choose from.
        label, caption: for who listens, and for all. series: key of the column that names a line.
        marks: whether every point has one.
        plane: equal axes, points that are not joined; names of runs that do not set the range.
    """
    partial = "" if plane is None else f' data-plane="{escape(json.dumps(list(plane)))}"'
    return (
        f'<figure class="plot" data-table="{escape(table)}" data-series="{series}" '
        f'data-x="{" ".join(across)}" data-y="{" ".join(up)}" data-label="{escape(label)}"'
        f"{'' if marks else ' data-marks=no'}{partial}>"
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def rows_of(cells: Sequence[Sequence[str]]) -> list[str]:
    """Rows of a table."""
    return ["<tr><td>" + "<td>".join(row) for row in cells]


@dataclass(frozen=True)
class Page:
    """One page, and where its link stands.

    Attributes
    ----------
        name: stem of its file. title, body: what it shows; the body is HTML.
        tab: the word for it in the bar. group: the menu it stands in, ``""`` for the bar itself.
        kind: the heading in the menu.
    """

    name: str
    title: str
    body: str
    tab: str
    group: str = ""
    kind: str = ""


@dataclass(frozen=True)
class Site:
    """Where pages are: files beside each other, or sections of one file."""

    single: bool = False

    def href(self, page: str) -> str:
        """Where a page is found."""
        return f"#{quote(page)}" if self.single else f"{quote(page)}.html"

    def link(self, page: str, text: str) -> str:
        """Link to a page."""
        return f'<a href="{escape(self.href(page))}">{escape(text)}</a>'

    def bar(self, pages: Sequence[Page]) -> str:
        """Links to all pages: some at once, the others in menus that open without a script."""
        parts = [self.link(page.name, page.tab) for page in pages if not page.group]
        for group in dict.fromkeys(page.group for page in pages if page.group):
            mine = [page for page in pages if page.group == group]
            lists = []
            for kind in dict.fromkeys(page.kind for page in mine):
                links = "".join(
                    f"<li>{self.link(page.name, page.tab)}" for page in mine if page.kind == kind
                )
                head = f"<p>{escape(kind)}</p>" if kind else ""
                lists.append(f"{head}<ul>{links}</ul>")
            parts.append(
                f'<details name="menu"><summary>{escape(group)} <small>{len(mine)}</small>'
                f'</summary><div class="menu">{"".join(lists)}</div></details>'
            )
        return "".join(parts)

    def document(self, title: str, pages: Sequence[Page], bar: str, foot: str) -> str:
        """Return one HTML file with some pages, under what :meth:`bar` gave."""
        if len(pages) == 1:
            here = f'<a href="{escape(self.href(pages[0].name))}"'
            bar = bar.replace(f"{here}>", f"{here} aria-current=page>")
        if self.single:
            main = "".join(
                f'<section id="{escape(page.name)}" class="page"><h1>{escape(page.title)}</h1>'
                f"{page.body}</section>\n"
                for page in pages
            )
        else:
            main = f"<h1>{escape(pages[0].title)}</h1>{pages[0].body}"
        style, script = asset("style.css"), asset("script.js")
        policy = (
            f"default-src 'none'; style-src '{_hash(style)}'; script-src '{_hash(script)}'; "
            f"img-src data:; base-uri 'none'; form-action 'none'"
        )
        return (
            '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">\n'
            f'<meta http-equiv="Content-Security-Policy" content="{policy}">\n'
            '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
            '<meta name="color-scheme" content="light dark"><link rel="icon" href="data:,">\n'
            f"<title>{escape(title)}</title>\n<style>{style}</style></head>\n"
            f'<body><a class="skip" href="#main">To the page</a>\n'
            f'<header><strong>glmref</strong><nav aria-label="pages">{bar}</nav></header>\n'
            f'<main id="main">{main}</main>\n<footer>{foot}</footer>\n'
            f"<script>{script}</script></body></html>\n"
        )


@cache
def asset(name: str) -> str:
    """Style sheet or script that comes with the package."""
    return files("glmref.report").joinpath(name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """Its hash as a content security policy writes it."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
