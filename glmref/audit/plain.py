"""Tables in plain JSON and CSV, with the keys of :mod:`~.check`."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping
from typing import Any

from ..catalogue.strict_json import unique
from ..errors import DataError, GlmrefError
from ..exact import Exact
from ..exact.expression import parse
from .check import KEYS
from .numbers import Double, rational_text
from .table import Rows, Table
from .values import Number, Unread, literal


def from_json(text: str) -> Iterator[Table]:
    """Tables of a JSON text: one object, a list of them, or an object of them by name.

    Parameters
    ----------
    text : str
        JSON. A number with a point is the decimal that is written.

    Yields
    ------
    Table
        What is no table is unread, with the reason.
    """
    try:
        document = json.loads(text, parse_float=Double, object_pairs_hook=unique)
    except (ValueError, RecursionError, DataError) as error:
        where = getattr(error, "lineno", 1)
        yield Table("", where, unread=f"the file is no JSON ({str(error).splitlines()[0]})")
        return
    if isinstance(document, dict) and not document.keys() & KEYS - {"name"}:
        given = [{"name": name, **x} if isinstance(x, dict) else x for name, x in document.items()]
    else:
        given = document if isinstance(document, list) else [document]
    at, line = 0, 1
    for k, x in enumerate(given, 1):
        named = isinstance(x, dict) and "name" in x
        name = str(x["name"]) if named else f"table {k}"
        found = text.find(json.dumps(name, ensure_ascii=False), at) if named else -1
        if found >= 0:
            line += text.count("\n", at, found)
            at = found
        yield _table(x, name, line if found >= 0 else 1)


def from_csv(text: str) -> Iterator[Table]:
    """Tables of a CSV text: the first row holds the keys, each other one a table.

    Parameters
    ----------
    text : str
        A matrix is written ``0 0; 1/2 0``, a vector ``0 1``; what begins with a bracket is JSON.

    Yields
    ------
    Table
        What is no table is unread, with the reason.
    """
    rows = csv.reader(io.StringIO(text))
    try:
        yield from _tables_of(rows)
    except csv.Error as error:
        yield Table("", rows.line_num, unread=f"the file is no CSV ({error})")


def _tables_of(rows: Any) -> Iterator[Table]:
    keys = [x.strip() for x in next(rows, [])]
    for row in rows:
        if not any(x.strip() for x in row):
            continue
        cells = {key: x.strip() for key, x in zip(keys, row, strict=False) if x.strip()}
        name = cells.get("name", f"line {rows.line_num}")
        try:
            document = {key: _cell(key, x) for key, x in cells.items()}
        except (ValueError, RecursionError) as error:
            yield Table(name, rows.line_num, unread=f"a cell is not understood: {error}")
            continue
        yield _table(document, name, rows.line_num)


def _cell(key: str, text: str) -> Any:
    if key == "name":
        return text
    if text[:1] in "[{":
        return json.loads(text, parse_float=Double)
    if key.endswith("order") or key == "digits":
        return int(text)
    rows = [row.split() for row in text.split(";")]
    return rows if key in ("A", "A_prime", "alpha", "gamma") else rows[0]


def _table(document: Any, name: str, line: int) -> Table:
    """The table of a document, or an unread one."""
    try:
        if not isinstance(document, Mapping):
            raise Unread("an object with A and b is expected")
        return _read(document, name, line)
    except (Unread, GlmrefError) as error:
        return Table(name, line, unread=str(error))


def _read(document: Mapping[str, Any], name: str, line: int) -> Table:
    unknown = [x for x in document if x not in KEYS]
    if unknown:
        raise Unread(f"the key {unknown[0]!r} is not known")
    for key in ("dense", "w_order"):
        if key in document:
            raise Unread(f"the key {key!r} is read by `glmref check` only")
    table = Table(name, line, order=_whole(document.get("order")))
    if "parts" in document:
        parts = document["parts"]
        if not (isinstance(parts, list) and parts and all(isinstance(x, dict) for x in parts)):
            raise Unread("`parts` must be a list of methods with A and b")
        table.kind = "additive"
    elif "alpha" in document or "gamma" in document:
        table.kind, parts = "rosenbrock", [{**document, "A": document.get("alpha")}]
    else:
        table.kind, parts = "nystrom" if "b_prime" in document else "rk", [document]
    s = 0
    for k, part in enumerate(parts):
        b = _vector(part, "b", s)
        s = len(b)
        table.A.append(_square(part, "A", s))
        table.b.append(b)
        c = part if "c" in part else document
        table.c.append(_vector(c, "c", s) if "c" in c else None)
        if table.kind == "additive" and "order" in part:
            raise Unread(f"the order of part {k + 1} is read by `glmref check` only")
    if table.kind == "rosenbrock":
        table.A.append(_square(document, "gamma", s))
    if table.kind == "nystrom":
        table.b.append(_vector(document, "b_prime", s))
        if "A_prime" in document:
            table.A.append(_square(document, "A_prime", s))
        if table.c == [None]:
            raise Unread("a Nystrom method needs c")
        if "embedded" in document:
            raise Unread("embedded rows of a Nystrom method are read by `glmref check` only")
    _embedded(document.get("embedded"), table)
    return table


def _embedded(given: Any, table: Table) -> None:
    if given is None:
        return
    if not isinstance(given, list) or (len(given) == 2 and isinstance(given[1], int)):
        given = [given]
    s = len(table.b[0])
    for k, x in enumerate(given, 1):
        if isinstance(x, list) and len(x) == 2 and isinstance(x[0], list):
            x = {"b": x[0], "order": x[1]}
        if not isinstance(x, dict) or ("b" in x) == ("error" in x):
            raise Unread(f"embedded[{k}] needs either b or error, and an order")
        row = _vector(x, "b" if "b" in x else "error", s)
        if "error" in x:
            table.errors.append(row)
            row = [p.of(p.value - q.value, q) for p, q in zip(table.b[0], row, strict=True)]
        table.rows.append((f"embedded[{k}]", row, _whole(x.get("order"))))


def _whole(x: Any) -> int | None:
    if x is not None and (not isinstance(x, int) or isinstance(x, bool) or not 1 <= x <= 100):
        raise Unread(f"an order must be a whole number from 1 to 100, got {str(x)[:40]!r}")
    return x


def _vector(document: Mapping[str, Any], key: str, s: int = 0) -> list[Number]:
    given = document.get(key)
    if not isinstance(given, list) or not given:
        raise Unread(f"`{key}` must be a list of numbers")
    row = [_number(x, key) for x in given]
    if s and len(row) != s:
        raise Unread(f"`{key}` has {len(row)} entries, and {s} are expected")
    return row


def _square(document: Mapping[str, Any], key: str, s: int) -> Rows:
    given = document.get(key)
    if not isinstance(given, list) or len(given) != s:
        raise Unread(f"`{key}` must have {s} rows, as b has {s} entries")
    return [_vector({key: row}, key, s) for row in given]


def _number(x: Any, key: str) -> Number:
    """An entry: a number as it is written, or an expression in a string."""
    if isinstance(x, Double):
        return literal(x.text)
    if isinstance(x, int) and not isinstance(x, bool):
        return Number(Exact(x))
    if not isinstance(x, str):
        raise Unread(f"`{key}` holds {str(x)[:40]!r}, which is no number")
    try:
        return literal(x.strip())
    except Unread:
        value = parse(rational_text(x))
    if not isinstance(value, Exact):
        raise Unread(f"`{key}` holds {x[:40]!r}, which is no exact number")
    return Number(value)
