"""TOML in bounded time: Python's parser takes minutes for a key of thousands of parts."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from typing import Any

#: Parts of a dotted key; no file of this package has more than four.
MOST_PARTS = 100
_PART = r"(?:[A-Za-z0-9_-]++|\"[^\"]*+\"|'[^']*+')[ \t]*+\.[ \t]*+"
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-])(?:{_PART}){{{MOST_PARTS}}}")


def loads(text: str, *, parse_float: Callable[[str], Any] = float) -> dict[str, Any]:
    """Parse TOML.

    Raises
    ------
    tomllib.TOMLDecodeError
        For what is not TOML, and for a key of more than :data:`MOST_PARTS` parts.
    ValueError
        For a value beyond Python's limits.
    RecursionError
        For brackets nested too deep.
    """
    for number, line in enumerate(text.split("\n"), start=1):
        if line.count(".") > MOST_PARTS and _LONG_KEY.search(line):
            raise tomllib.TOMLDecodeError(f"line {number}: a key has more than {MOST_PARTS} parts")
    return tomllib.loads(text, parse_float=parse_float)
