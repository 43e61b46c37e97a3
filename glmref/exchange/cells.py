"""A method file as a table of cells, for spreadsheets and statistics programs, and back.

A cell is a line ``block,row,column,value`` of CSV; the block is the path of keys in the file, such
as ``A`` or ``embedded.1.b``. A vector has no rows, and what is neither vector nor matrix no columns
either. A text that could be taken for JSON is quoted; other values are JSON.
"""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

from ..catalogue.strict_json import shown
from ..errors import DataError
from ..views.tables import csv_text, csv_value

HEAD = ("block", "row", "column", "value")
Cell = tuple[str, Any, Any, Any]


def to_cells(document: Mapping[str, Any]) -> str:
    """Return a method document as CSV."""
    return csv_text([HEAD, *_cells("", document)]) + "\n"


def _cells(block: str, value: Any) -> Iterator[Cell]:
    inside = f"{block}." if block else ""
    if isinstance(value, Mapping) and value:
        for key, x in value.items():
            yield from _cells(f"{inside}{key}", x)
    elif isinstance(value, list) and value and all(isinstance(x, str) for x in value):
        yield from ((block, "", j, x) for j, x in enumerate(value, 1))
    elif isinstance(value, list) and value and all(isinstance(x, list) and x for x in value):
        for i, row in enumerate(value, 1):
            yield from ((block, i, j, x) for j, x in enumerate(row, 1))
    elif isinstance(value, list) and value and all(isinstance(x, Mapping) for x in value):
        for k, x in enumerate(value, 1):
            yield from _cells(f"{inside}{k}", x)
    elif isinstance(value, str):
        yield block, "", "", json.dumps(value) if _scalar(value) != value else value
    else:
        yield block, "", "", json.dumps(value)


def _scalar(text: str) -> Any:
    try:
        return json.loads(text)
    except (ValueError, RecursionError):
        return text


def from_cells(text: str) -> dict[str, Any]:
    """Return the document of a table that :func:`to_cells` wrote.

    Raises
    ------
    DataError
        For anything else, naming the line.
    """
    try:
        lines = list(csv.reader(io.StringIO(text)))
    except csv.Error as error:
        raise DataError(f"the file is no CSV ({error})") from None
    blocks: dict[str, dict[tuple[int, int], str]] = {}
    for number, row in enumerate(lines, 1):
        if not row or tuple(row) == HEAD:
            continue
        if len(row) != len(HEAD):
            raise DataError(f"line {number} must have the columns block, row, column and value")
        block, i, j, value = row
        if not all(re.fullmatch("([1-9][0-9]{0,3})?", x, re.ASCII) for x in (i, j)):
            raise DataError(f"line {number} must have whole numbers in row and column")
        place, cells = (int(i or 0), int(j or 0)), blocks.setdefault(block, {})
        if place in cells:
            raise DataError(f"line {number}: the entry {place} of {shown(block)} occurs twice")
        cells[place] = csv_value(value)
    document: dict[str, Any] = {}
    for block, cells in blocks.items():
        *outer, key = block.split(".")
        inside = document
        for name in outer:
            inside = inside.setdefault(name, {})
            if not isinstance(inside, dict):
                break
        if not isinstance(inside, dict) or key in inside:
            raise DataError(f"{shown(block)} is said in two ways; keep one")
        inside[key] = _value(block, cells)
    return {key: _listed(value) for key, value in document.items()}


def _value(block: str, cells: Mapping[tuple[int, int], str]) -> Any:
    """Return the value, the vector or the matrix of a block."""
    rows, columns = (max(place[k] for place in cells) for k in (0, 1))
    wanted = [
        (i, j) for i in range(bool(rows), rows + 1) for j in range(bool(columns), columns + 1)
    ]
    missing = next((place for place in wanted if place not in cells), None)
    if missing is not None or len(cells) != len(wanted):
        raise DataError(f"the entry {missing} of the block {shown(block)} is missing")
    if not columns:
        return _scalar(cells[0, 0])
    found = [[cells[i, j] for j in range(1, columns + 1)] for i in range(bool(rows), rows + 1)]
    return found if rows else found[0]


def _listed(value: Any) -> Any:
    """Return an object whose keys are 1, 2, .. as a list."""
    if not isinstance(value, dict):
        return value
    found = {key: _listed(x) for key, x in value.items()}
    if found and list(found) == [str(k) for k in range(1, len(found) + 1)]:
        return list(found.values())
    return found
