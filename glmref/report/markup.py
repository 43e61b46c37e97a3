"""What pages are made of: numbers, tables, figures and pages; HTML stands in the templates.

Only what is a :class:`~markupsafe.Markup` counts as HTML; a template escapes all other texts.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any
from urllib.parse import quote

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from ..views.tables import counted

#: Digits of a number on a page; the stored number agrees to all that are shown.
DIGITS = 6
_LONG = 300  # rows after which a table is folded: laying it out takes most of the time of a load
_WIDE = 40  # characters of a cell that does not wrap
#: Name of the page on which methods and verdicts are searched.
SEARCH = "search"
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
    return flat(value) if isinstance(value, list | tuple) else str(value)


def flat(value: Any) -> str:
    """Return a value of any kind, lists and objects included, as the text of a cell."""
    if isinstance(value, Mapping):
        return "; ".join(f"{k}: {flat(x)}" for k, x in value.items())
    if isinstance(value, list | tuple):
        return ", ".join(flat(x) for x in value)
    return number(value)


def wrapped(text: str) -> str:
    """Return the content of a cell; what is long wraps in it."""
    return Markup('<div class="cell">{}</div>').format(text) if len(text) > _WIDE else text


@cache
def _templates() -> Environment:
    environment = Environment(
        loader=PackageLoader("glmref.report"),
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        undefined=StrictUndefined,
    )
    environment.filters |= {"counted": counted, "flat": flat, "json": json.dumps, "number": number}
    return environment


def render(template: str, **values: Any) -> Markup:
    """Return the HTML that a template of this package gives for some values."""
    return Markup(_templates().get_template(template).render(values))


@dataclass(frozen=True)
class Column:
    """A column of a table."""

    key: str  #: What the script knows it by.
    title: str  #: What is shown.
    unit: str = ""  #: Behind the title.
    linear: bool = False  #: Whether a picture shows it on a linear axis.


@dataclass(frozen=True)
class Table:
    """A table of texts and HTML. The script finds it by its id and draws from it."""

    id: str
    caption: str
    columns: Sequence[Column]
    cells: Sequence[Sequence[str]]
    sortable: bool = False
    found: bool = False  #: Whether the script shows only the rows that a search finds.

    @property
    def is_long(self) -> bool:
        """Whether it is folded."""
        return len(self.cells) > _LONG and not self.found


@dataclass(frozen=True)
class Figure:
    """A picture that the script draws from a table."""

    table: str  #: Id of the table.
    #: Keys of columns to choose from.
    across: Sequence[str]
    up: Sequence[str]
    #: For who listens, and for all.
    label: str
    caption: str
    series: str = "method"  #: Key of the column that names a line.
    marks: bool = True  #: Whether every point has one.
    bars: bool = True  #: Whether quartiles of run times are drawn.
    #: Equal axes, points that are not joined; names of runs that do not set the range.
    plane: Sequence[str] | None = None

    def lines_of(self, table: Table) -> tuple[str, ...]:
        """Return the names of the lines of a table, as they stand in it."""
        at = [column.key for column in table.columns].index(self.series)
        cells = (row[at] for row in table.cells)
        texts = (x.striptags() if isinstance(x, Markup) else x.strip() for x in cells)
        return tuple(dict.fromkeys(texts))


@dataclass(frozen=True)
class Page:
    """One page, and where its link stands."""

    name: str  #: Stem of its file.
    #: What it shows.
    title: str
    body: Markup
    tab: str  #: The word for it in the bar.
    group: str = ""  #: The menu it stands in, ``""`` for the bar itself.
    kind: str = ""  #: The heading in the menu.
    pictures: tuple[tuple[str, ...], ...] = ()  #: Names of the lines of each of its pictures.


@dataclass(frozen=True)
class Site:
    """Where pages are: files beside each other, or sections of one file."""

    single: bool = False  #: Whether they are sections.
    docs: str = ""  #: Where the documentation lies.
    #: Number of the colour and mark of each line, one for all pictures.
    looks: Mapping[str, int] = field(default_factory=dict)

    def href(self, page: str) -> str:
        """Return where a page is found."""
        return f"#{quote(page)}" if self.single else f"{quote(page)}.html"

    def link(self, page: str, text: str) -> Markup:
        """Return a link to a page."""
        return Markup('<a href="{}">{}</a>').format(self.href(page), text)

    def document(self, title: str, pages: Sequence[Page], every: Sequence[Page]) -> str:
        """Return one HTML file with some pages, under links to every page.

        Some of these links stand in the bar at once, the others in menus that open without a
        script.
        """
        menus: dict[str, dict[str, list[Page]]] = {}
        for page in every:
            if page.group:
                menus.setdefault(page.group, {}).setdefault(page.kind, []).append(page)
        style, script = asset("style.css"), asset("script.js")
        return render(
            "page.html", site=self, title=title, pages=pages, menus=menus,
            looks={x: self.looks[x] for page in pages for lines in page.pictures for x in lines
                   if x in self.looks},
            bar=[page for page in every if not page.group],
            search=self.href(SEARCH) if any(page.name == SEARCH for page in every) else "",
            style=Markup(style), style_hash=_hash(style),
            script=Markup(script), script_hash=_hash(script),
        )  # fmt: skip


@cache
def asset(name: str) -> str:
    """Return style sheet or script that comes with the package."""
    return files("glmref.report").joinpath(name).read_text(encoding="utf-8")


def _hash(text: str) -> str:
    """Return its hash as a content security policy writes it."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
