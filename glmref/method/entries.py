"""Entries of tableaux, however they are given: read as exact numbers, or refused by their name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from typing import Any

from ..errors import DataError
from ..exact import Ball, Exact, Scalar, exact
from ..exact.expression import parse, writable
from ..exact.linalg import Matrix, Vector
from ..system.arguments import shown
from .base import Array, as_list, of_float

Entry = str | int | float | complex | Fraction | Scalar | Array
#: What constructors take for a vector and for a matrix and turn into one.
Entries = Sequence[Entry] | Array
Rows = Sequence[Sequence[Entry]] | Array


def _as_scalar(value: Entry, where: str) -> Scalar:
    if isinstance(value, Exact | Ball):
        return value
    if isinstance(value, str):
        return parse(value)
    value = as_list(value)
    if isinstance(value, int | Fraction) and not isinstance(value, bool):
        if writable(value):
            return exact(value)
        raise DataError(f"{where} has too many digits to compute with; shorten it")
    if isinstance(value, float | complex):
        return of_float(value, where)
    raise DataError(
        f"{where} must be a number or a string such as '1/4', got {shown(value)}; correct the entry"
    )


def as_vector(values: Entries, name: str) -> Vector:
    """Convert a sequence of strings, numbers or scalars, or an array, to a vector.

    A floating point number is the shortest decimal that stands for it, see :func:`.base.of_float`.

    Raises
    ------
    DataError
        Naming the entry that cannot be read.
    """
    values = as_list(values)
    if isinstance(values, str) or not isinstance(values, Sequence):
        raise DataError(f"`{name}` must be a list of entries, got {shown(values)}")
    return tuple(_as_scalar(x, f"`{name}[{i + 1}]`") for i, x in enumerate(values))


def as_matrix(rows: Rows, name: str) -> Matrix:
    """Convert rows of entries as :func:`as_vector` takes them, or an array, to a matrix.

    Raises
    ------
    DataError
        For an empty or ragged matrix, naming the row.
    """
    rows = as_list(rows)
    if isinstance(rows, str) or not isinstance(rows, Sequence) or not rows:
        raise DataError(f"`{name}` must be a list of rows, got {shown(rows)}")
    matrix = tuple(as_vector(row, f"{name}[{i + 1}]") for i, row in enumerate(rows))
    for i, row in enumerate(matrix):
        if len(row) != len(matrix[0]) or not row:
            raise DataError(
                f"`{name}` must be rectangular, but row {i + 1} is {len(row)} long "
                f"and row 1 is {len(matrix[0])} long"
            )
    return matrix


def check_shape(name: str, value: Matrix, rows: int, columns: int, meaning: str) -> None:
    """Refuse a matrix that does not have the shape its method requires."""
    if (len(value), len(value[0])) != (rows, columns):
        raise DataError(
            f"`{name}` must have shape {meaning} = ({rows}, {columns}), "
            f"got ({len(value)}, {len(value[0])})"
        )


def as_rows(record: Any, name: str, rows: int | None = None, columns: int | None = None) -> Matrix:
    """Convert a matrix of a record, which may be empty, and keep it there.

    Raises
    ------
    DataError
        For what is no matrix, or does not have the required rows and columns.
    """
    given = as_list(getattr(record, name))
    if isinstance(given, str) or not isinstance(given, Sequence):
        raise DataError(f"`{name}` must be a list of rows, got {shown(given)}")
    found = tuple(as_vector(row, f"{name}[{i + 1}]") for i, row in enumerate(given))
    wrong = rows not in (None, len(found))
    if wrong or (columns is not None and any(len(row) != columns for row in found)):
        sizes = ", ".join(str(len(row)) for row in found[:4])
        raise DataError(
            f"`{name}` must have {rows} rows of {columns} entries, got {len(found)} of {sizes}"
        )
    object.__setattr__(record, name, found)
    return found


#: What a record holds besides its coefficients.
_FIELDS: Mapping[str, type] = {
    "name": str,
    "claims": Mapping,
    "source": Mapping,
    "document": Mapping,
}
_WORDS = {str: "a text", bool: "True or False", Mapping: "a mapping"}


def check_fields(record: Any, **more: type) -> None:
    """Refuse what a record holds besides its coefficients where it is of another type.

    Fields that are ``None`` by default may be ``None``; ``more`` are types of further fields.

    Raises
    ------
    DataError
        Naming the field.
    """
    defaults = {x.name: x.default for x in fields(record)}
    for name, kind in {**_FIELDS, **more}.items():
        if name not in defaults:
            continue
        value = getattr(record, name)
        if not isinstance(value, kind) and not (value is None and defaults[name] is None):
            words = _WORDS.get(kind, f"a {kind.__name__}")
            raise DataError(f"`{name}` must be {words}, got {shown(value)}")
