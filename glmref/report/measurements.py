"""One page for each document of measurements: its sentences, its lists as tables and pictures.

A document of format ``glmref-measurement-1`` says in its own words what was measured and how, and
holds lists of objects. What can be drawn is drawn: errors against costs, one picture a problem, and
numbers that a row keeps as lists of equal length, such as a deviation after growing numbers of
steps.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from .markup import Column, Figure, Page, Table, counted, flat, number, render, wrapped
from .store import Record, Results, is_number

_COSTS = ("seconds", "evaluations", "matrices", "steps", "h", "tolerance")
_NAMES = ("variant", "method", "name", "solver", "start", "integrator")
_FEW = 3  # objects that are shown one below the other; more are folded
_LINE = "line"  # key of the column that names a line of a picture
_FIRST = ("steps", "t", "times", "h")  # what a curve is drawn against
#: What the two numbers of a point are, by the key of the curve.
_AXES = {"curve": ("force evaluations", "error")}
_TITLES = ("title", "question", "what", "name")

#: What the template of these pages is given: the kind of a part (or the tag of a heading), and it.
Part = tuple[str, Any]


def measurement_pages(results: Results) -> list[Page]:
    """Return pages of all documents, by the names of their files."""
    return [_page(name, doc) for name, doc in sorted(results.measurements.items())]


def _page(name: str, doc: Record) -> Page:
    parts = _body(name, doc)
    flat_parts = [x for kind, one in parts for x in (one[1] if kind == "part" else [(kind, one)])]
    tables = {x.id: x for _, x in flat_parts if isinstance(x, Table)}
    pictures = tuple(x.lines_of(tables[x.table]) for _, x in flat_parts if isinstance(x, Figure))
    body = render("measurement.html", parts=parts)
    title = title_of(name, doc)
    return Page(f"measured-{name}", title, body, name, "measurements", pictures=pictures)


def title_of(name: str, doc: Record) -> str:
    """Return the title of a document: what it calls itself, or the name of its file."""
    found = str(doc.get(_title_key(doc), name))
    return found[:1].upper() + found[1:]


def _title_key(doc: Record) -> str:
    return next((key for key in _TITLES if isinstance(doc.get(key), str)), "")


def _body(name: str, doc: Record, *, inner: bool = False) -> list[Part]:
    """Return sentences first, then every list of objects.

    An object that holds such a list is opened.
    """
    plain: list[tuple[str, list[str]]] = []
    lists: list[Part] = []
    said = () if inner else ("format", "name", _title_key(doc))
    for key, value in doc.items():
        if key in said:
            continue
        if _is_listing(value):
            lists += _listing(f"{name}-{key}", key, value)
        elif isinstance(value, Mapping) and value and all(map(_is_object, value.values())):
            rows = [{"name": inner, **x} for inner, x in value.items()]
            lists += _listing(f"{name}-{key}", key, rows)
        elif isinstance(value, Mapping) and any(map(_is_listing, value.values())):
            lists += [("h2", key), *_body(f"{name}-{key}", value, inner=True)]
        else:
            plain.append((key, _told(value)))
    return [*([("sentences", plain)] if plain else []), *lists]


def _told(value: Any) -> list[str]:
    """Return a value in words; sentences one below the other."""
    texts = value if isinstance(value, list) else []
    if any(isinstance(x, str) and " " in x for x in texts):
        return [flat(x) for x in texts]
    return [flat(value)]


def _is_listing(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(map(_is_object, value))


def _is_object(value: Any) -> bool:
    return isinstance(value, Mapping)


def _listing(id_: str, key: str, rows: Sequence[Record]) -> list[Part]:
    """Return a list of objects: opened one by one where they hold lists of objects in turn."""
    deeper = [k for k in rows[0] if _is_listing(rows[0][k])]
    leaves = {k for k in deeper if not any(map(_has_lists, rows[0][k]))}
    if set(deeper) - leaves:
        if len(rows) > _FEW:
            return [
                ("part", (_heading(key, row), _body(f"{id_}-{n}", row, inner=True)))
                for n, row in enumerate(rows)
            ]
        return [
            part
            for n, row in enumerate(rows)
            for part in (("h2", _heading(key, row)), *_body(f"{id_}-{n}", row, inner=True))
        ]
    found: list[Part] = [("h2", key)]
    for inner in sorted(leaves):
        flattened = [
            {**{k: x for k, x in row.items() if not isinstance(x, list | Mapping)}, **leaf}
            for row in rows
            for leaf in (row[inner] if _is_listing(row.get(inner)) else ())
        ]
        found += _by_problem(f"{id_}-{inner}", inner, flattened)
    rest = [{k: x for k, x in row.items() if k not in leaves} for row in rows]
    return [*found, *_by_problem(id_, key, rest)]


def _has_lists(row: Record) -> bool:
    """Return whether an object holds a list of objects, or points of a curve."""
    return any(_is_listing(x) or _is_points(x) for x in row.values())


def _heading(key: str, row: Record) -> str:
    """Return the name of an object: its first text."""
    return next((x for x in row.values() if isinstance(x, str)), key)


def _by_problem(id_: str, what: str, rows: Sequence[Record]) -> list[Part]:
    """Return tables and pictures of rows, split by problem where there are several."""
    found: list[Part] = []
    groups: dict[str, list[Record]] = {}
    for row in rows:
        groups.setdefault(flat(row.get("problem", "")), []).append(row)
    for n, (problem, mine) in enumerate(groups.items()):
        if len(groups) > 1 and problem:
            found.append(("h3", problem))
        found += _group(f"m-{id_}-{n}", what, mine)
    return found


def _group(id_: str, what: str, rows: Sequence[Record]) -> list[Part]:
    keys = list(dict.fromkeys(k for row in rows for k in row))
    names = [k for k in _NAMES if any(isinstance(row.get(k), str) for row in rows)]
    parts, curved = _curves(id_, what, rows, keys, names)
    # one name is shown by its own column, several together by one more
    together = len(names) > 1
    shown = [k for k in keys if k not in curved]
    columns = [Column(_LINE, "line")] if together else []
    columns += [Column(k, k) for k in shown]
    cells = [
        ([_line(row, names)] if together else []) + [_cell(row.get(k)) for k in shown]
        for row in rows
    ]
    table = Table(id_, f"{counted(len(rows), 'measurement')}: {what}", columns, cells)
    numeric = [k for k in shown if any(is_number(row.get(k)) for row in rows)]
    costs = [k for k in _COSTS if k in numeric]
    errors = [k for k in numeric if "error" in k or "drift" in k]
    if names and costs and errors:
        caption = f"{what}: errors against costs, rows joined in the order of the file."
        series = _LINE if together else names[0]
        drawn = Figure(table.id, costs, errors, f"error, {what}", caption, series)
        parts.append(("figure", drawn))
    return [*parts, ("table", table)]


def _cell(value: Any) -> str:
    """Return a value as a cell; what is long wraps in it."""
    return wrapped(flat(value))


def _line(row: Record, names: Sequence[str]) -> str:
    return ", ".join(flat(row[k]) for k in names if row.get(k) is not None)


def _curves(
    id_: str, what: str, rows: Sequence[Record], keys: Sequence[str], names: Sequence[str]
) -> tuple[list[Part], set[str]]:
    """Return pictures of the lists of numbers that rows hold, with these numbers.

    The keys that are drawn come second.
    """
    lists = [k for k in keys if any(_is_list(row.get(k)) for row in rows)]
    across = next((k for k in _FIRST if k in lists), None)
    up = [k for k in lists if k != across and all(_fits(row, across, k) for row in rows)]
    parts: list[Part] = []
    if not names:
        return parts, set()
    if across is not None and up:
        cells = [
            [_line(row, names), *(number(row[k][n]) for k in (across, *up))]
            for row in rows
            if _is_list(row.get(across))
            for n in range(len(row[across]))
        ]
        parts += _curve(f"{id_}-curves", what, [Column(k, k) for k in (across, *up)], cells)
    pairs = [k for k in keys if any(_is_points(row.get(k)) for row in rows)]
    for key in pairs:
        first, second = _AXES.get(key, (f"{key}, first number", "second number"))
        columns = [Column("first", first), Column("second", second)]
        cells = [
            [_line(row, names), number(x), number(y)]
            for row in rows
            if _is_points(row.get(key))
            for x, y in row[key]
        ]
        parts += _curve(f"{id_}-{key}", what, columns, cells)
    drawn = {across, *up} if across is not None and up else set()
    return parts, {x for x in drawn if x is not None} | set(pairs)


def _curve(
    id_: str, what: str, columns: Sequence[Column], cells: Sequence[Sequence[str]]
) -> list[Part]:
    """Draw the columns after the first one against it, the numbers folded."""
    first, *others = columns
    caption = f"{what}: {', '.join(x.title for x in others)} against {first.title}"
    table = Table(id_, caption, [Column(_LINE, "line"), *columns], cells)
    drawn = Figure(id_, [first.key], [x.key for x in others], caption, caption, _LINE)
    return [("figure", drawn), ("numbers", table)]


def _is_points(value: Any) -> bool:
    """Return whether a value is a list of pairs of numbers."""
    return (
        isinstance(value, list)
        and len(value) > 1
        and all(isinstance(x, list) and len(x) == 2 and all(map(is_number, x)) for x in value)
    )


def _is_list(value: Any) -> bool:
    return isinstance(value, list) and len(value) > 1 and all(is_number(x) for x in value)


def _fits(row: Record, across: str | None, key: str) -> bool:
    """Return whether a row has as many numbers as places, or neither."""
    if across is None:
        return False
    x, y = row.get(across), row.get(key)
    if x is None and y is None:
        return True
    return isinstance(x, list) and isinstance(y, list) and _is_list(y) and len(x) == len(y)
