"""Statements of a source in C or Julia, as Python statements with their lines."""

from __future__ import annotations

from collections.abc import Iterator

from ..errors import DataError
from .code import Statement, bare, c_statements
from .julia import julia_statements

_MOST = 60_000_000  # characters of a source


def statements(text: str, language: str) -> Iterator[Statement]:
    """Split a source into statements; comments are left out, lines are kept."""
    if len(text) > _MOST:
        raise DataError(f"the file has {len(text)} characters; at most {_MOST} are read")
    text = bare(text, language)
    if language == "c":
        yield from c_statements(text)
    else:
        yield from julia_statements(text)
