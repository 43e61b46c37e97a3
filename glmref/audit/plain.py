"""Tables in plain JSON and CSV, in the plain dialect of :mod:`glmref.catalogue.plain`."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Iterator, Mapping
from typing import Any

from ..catalogue.claims import EMBEDDED_ORDER, ORDER, PlainClaims
from ..catalogue.keys import BLOCKS
from ..catalogue.reader import load_document
from ..catalogue.strict_json import Double, unique
from ..errors import DataError, GlmrefError
from ..exact import Exact
from ..prove.wrong_entry import entry_of, tableau
from .table import Table
from .values import Number, Unread

#: One of these makes an object a table.
_KEYS = frozenset().union(*BLOCKS.values(), ["order", "digits"])


def from_json(text: str) -> Iterator[Table]:
    """Yield tables of a JSON text: one object, a list of them, or an object of them by name.

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
    if isinstance(document, dict) and not document.keys() & _KEYS:
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
    """Yield tables of a CSV text: the first row holds the keys, each other one a table.

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
    """Return the table of a document, or an unread one."""
    try:
        if not isinstance(document, Mapping):
            raise Unread("an object with A and b is expected")
        return _read(document, name, line)
    except (Unread, GlmrefError) as error:
        said = str(error).removeprefix("tableau: ")
        return Table(name, line, unread=said)


def _read(document: Mapping[str, Any], name: str, line: int) -> Table:
    """Read a document in the plain dialect; its decimals are taken as they are written."""
    method = load_document({k: x for k, x in document.items() if k != "digits"}, where="tableau")
    for key in ("dense", "w_order"):
        if key in document:
            raise Unread(f"the key {key!r} is read by `glmref verify` only")
    claims = method.claims
    assert isinstance(claims, PlainClaims)
    if any(x.claim == "part" for x in claims.said):
        raise Unread("the order of a part is read by `glmref verify` only")
    orders = {(x.claim, x.number): x.order for x in claims.said}
    found = tableau(method, orders.get((ORDER.key, 0)), claims.times)
    if found is None:
        kind = (method.document or {}).get("class")
        raise Unread(f"a table of class {kind!r} is read by `glmref verify` only")
    if found.kind == "nystrom" and method.embedded:
        raise Unread("embedded rows of a Nystrom method are read by `glmref verify` only")
    table = Table(name, line, found.kind, _numbers(found.A), _numbers(found.b), _numbers(found.c),
                  found.order)  # fmt: skip
    s = len(table.b[0])
    for k, row in enumerate(method.embedded, 1):
        weights = _numbers([entry_of(_exact(x)) for x in row.weights[0][:s]])
        if row.difference:
            table.errors.append(weights)
            weights = [p.of(p.value - q.value, q) for p, q in zip(table.b[0], weights, strict=True)]
        table.rows.append((f"embedded[{k}]", weights, orders.get((EMBEDDED_ORDER.key, k))))
    return table


def _exact(x: Any) -> Exact:
    if not isinstance(x, Exact):
        raise Unread("an entry is no exact number")
    return x


def _numbers(value: Any) -> Any:
    if isinstance(value, list):
        return [_numbers(x) for x in value]
    return value and Number(value.value, value.places)
