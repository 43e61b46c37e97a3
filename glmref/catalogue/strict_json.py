"""Strict JSON: every problem of a file is one sentence that names the place and the remedy.

No float, no NaN, no duplicate key, no deep nesting, no file of unreasonable size; nothing is ever
evaluated as code.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Any

from ..errors import DataError
from ..system import arguments
from ..system.files import read_text

MAX_BYTES = 4_000_000  # a method file has some kilobytes; the largest vectors some hundred
MAX_NESTING = 40

# a string without its closing quote counts as one too: else its search would be quadratic
_STRING = re.compile(r'"(?:[^"\\]++|\\.)*+"?', re.DOTALL)
_BRACKET = re.compile(r"[\[\]{}]")


class Double(float):
    """A number with a point from JSON or TOML, which remembers how it was written."""

    text: str

    def __new__(cls, text: str) -> Double:
        """Read the text as Python does."""
        self = super().__new__(cls, text)
        self.text = text
        return self


def read_json(path: Path) -> Any:
    """Read a JSON file strictly: UTF-8, no float, no NaN, no duplicate key, no deep nesting.

    Raises
    ------
    DataError
        Naming the file, the place and the remedy.
    """
    return parse_json(read_text(path, MAX_BYTES), path.name)


def parse_json(text: str, name: str, parse_float: Callable[[str], Any] | None = None) -> Any:
    """Parse JSON as :func:`read_json` does, from a text that messages call ``name``.

    ``parse_float`` makes a value of a number with a point; without it such a number is refused.
    """
    if text.startswith("\ufeff"):
        raise DataError(f"{name}: the file begins with a byte order mark; save it as UTF-8 without")
    if _too_deep(text):
        raise DataError(f"{name}: brackets are nested deeper than {MAX_NESTING}; flatten the file")
    try:
        return json.loads(
            text,
            parse_float=parse_float
            or (lambda x: _refuse(name, f"the number {shown(x)[1:-1]} is a float", x)),
            parse_constant=lambda x: _refuse(name, f"{x} is not a number JSON allows", "0"),
            parse_int=lambda x: _integer(name, x),
            object_pairs_hook=lambda pairs: unique(pairs, f"{name}: "),
        )
    except json.JSONDecodeError as caught:
        error = same_on_all_pythons(caught)
        raise DataError(
            f"{name}: line {error.lineno}, column {error.colno} is not JSON ({error.msg})"
        ) from None


def same_on_all_pythons(error: json.JSONDecodeError) -> json.JSONDecodeError:
    """Return the error as Python 3.13 and later raise it: a trailing comma is called one.

    Before, the error was at the bracket behind the comma, where a value or a key was expected.
    """
    before = error.doc[: error.pos].rstrip(" \t\n\r")
    expected = (error.msg.split(" enclosed")[0], error.doc[error.pos : error.pos + 1])
    end = {("Expecting value", "]"): "array", ("Expecting property name", "}"): "object"}
    if not before.endswith(",") or expected not in end:
        return error
    message = f"Illegal trailing comma before end of {end[expected]}"
    return json.JSONDecodeError(message, error.doc, len(before) - 1)


def _too_deep(text: str) -> bool:
    """Return whether brackets outside strings are nested too deep, without recursion."""
    depth = 0
    # without escaped quotes every other piece between quotes is outside strings
    outside = _STRING.sub("", text) if "\\" in text else "".join(text.split('"')[::2])
    for match in _BRACKET.finditer(outside):
        if match[0] in "[{":
            depth += 1
            if depth > MAX_NESTING:
                return True
        else:
            depth -= 1
    return False


def _refuse(name: str, what: str, value: str) -> Any:
    raise DataError(f"{name}: {what}; write an exact string such as {_fraction_hint(value)!r}")


def _fraction_hint(text: str) -> str:
    if len(text) > 20 or "e" in text.lower():
        return "1/4"
    return str(Fraction(text))


def _integer(name: str, text: str) -> int:
    if len(text) > 20:
        raise DataError(f"{name}: the integer {text[:12]}... is too long; write it as a string")
    return int(text)


def unique(pairs: Sequence[tuple[str, Any]], where: str = "") -> dict[str, Any]:
    """Return an object of JSON; of two values with one key only the last would be seen.

    Raises
    ------
    DataError
        Naming a key that occurs twice, after ``where``.
    """
    result: dict[str, Any] = {}
    for key, value in pairs:
        if key in result:
            raise DataError(f"{where}the key {key!r} occurs twice; keep one of them")
        result[key] = value
    return result


def shown(value: object) -> str:
    """Return a value as JSON, shortened for a message."""
    return arguments.shown(value, lambda x: json.dumps(x, default=repr))
