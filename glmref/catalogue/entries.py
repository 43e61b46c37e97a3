"""The entries of a method document: numbers, vectors and matrices, each named in its errors."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from ..errors import DataError, ExactnessError
from ..exact import Ball, Exact, Scalar
from ..exact.expression import Weight, parse, rational, weigh
from ..exact.linalg import Matrix, Vector
from ..judge.grammar import NAME, RESERVED, may_be_declared
from ..system.arguments import whole
from ..system.budget import spend
from .keys import MAX_SIZE
from .strict_json import shown

#: Keys whose strings are prose or name other things: a constant is not used there.
_PROSE = frozenset({"name", "title", "source", "notes", "broken"})


def _strings(value: object) -> Iterator[str]:
    """Yield every string in the expressions of a document; those of a list as one."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for key, inner in value.items():
            if key not in _PROSE:
                yield from _strings(inner)
    elif isinstance(value, list):
        yield " ".join(x for x in value if isinstance(x, str))
        for inner in value:
            if not isinstance(inner, str):
                yield from _strings(inner)


class Entries:
    """Reads entries of one document, with the constants and digits it declares.

    Messages call it ``where``, the name of its file.
    """

    def __init__(self, doc: Mapping[str, Any], where: str) -> None:
        self.doc, self.where = doc, where
        self.constants: dict[str, Scalar] = {}
        self.weights: dict[str, Weight] = {}
        self.digits: int | None = None
        #: Numbers by their text, which stand for the same wherever they stand.
        self.known: dict[str, Scalar] = {}

    def error(self, what: str) -> DataError:
        """Return an error that names the file."""
        return DataError(f"{self.where}: {what}")

    def text(self, key: str, pattern: str = "") -> str:
        """Return a string of the document."""
        value = self.doc.get(key)
        if not isinstance(value, str) or (pattern and not re.fullmatch(pattern, value)):
            kind = f"a string matching {pattern}" if pattern else "a string"
            raise self.error(f"`{key}` must be {kind}, got {shown(value)}")
        return value

    def read_constants(self) -> None:
        """Read the declared digits, then the unknowns and constants, each using those above it."""
        digits = self.doc.get("digits")
        self.digits = None if digits is None else whole("digits", digits, 1, 150, self.error)
        for key in ("unknowns", "constants"):
            block = self.doc.get(key, {})
            if not isinstance(block, dict):
                raise self.error(f"`{key}` must be an object of names and expressions")
            for name, text in block.items():
                if not may_be_declared(name):
                    raise self.error(
                        f"`{key}` has the name {shown(name)}, which cannot be used; take letters, "
                        f"digits and _, but none of {', '.join(sorted(RESERVED))}"
                    )
                if name in self.constants:
                    raise self.error(f"the constant {name!r} occurs twice; keep one of them")
                value = self.scalar(text, f"{key}.{name}")
                self.weights[name] = weigh(text, self.weights)
                self.constants[name] = value

    def check_constants_used(self) -> None:
        """Refuse a constant that stands nowhere: the name where it should stand is wrong."""
        if not self.constants:
            return
        used = set(re.findall(NAME, " ".join(_strings(self.doc))))
        for name in self.constants:
            if name not in used:
                raise self.error(
                    f"the constant {name!r} is never used; take it out, or correct the name "
                    f"where it is meant"
                )

    def scalar(self, text: object, where: str) -> Scalar:
        """Read one entry; one that is a number already is of a document made in Python."""
        if isinstance(text, Exact | Ball):
            return text
        if not isinstance(text, str):
            raise self.error(
                f"`{where}` must be a string such as '1/2', got {shown(text)}; quote the number"
            )
        spend()
        number = rational(text)
        if number is None:
            number = self.known.get(text)
        if number is not None:
            return number
        try:
            weigh(text, self.weights)
            number = parse(text, constants=self.constants, digits=self.digits)
        except (DataError, ExactnessError) as error:
            raise self.error(f"`{where}`: {error}") from None
        self.known[text] = number
        return number

    def _listed(self, values: object, where: str, what: str) -> list[Any]:
        if not isinstance(values, list) or not values:
            raise self.error(f"`{where}` must be a list of {what}, got {shown(values)}")
        if len(values) > MAX_SIZE:
            raise self.error(f"`{where}` has {len(values)} entries and at most {MAX_SIZE} are read")
        return values

    def vector(self, values: object, where: str) -> Vector:
        """Read a list of entries."""
        values = self._listed(values, where, "strings")
        # fractions first, without the name of their place: a start has up to 10,000 of them
        spend()
        known = [rational(x) if isinstance(x, str) else None for x in values]
        return tuple(
            self.scalar(x, f"{where}[{i + 1}]") if number is None else number
            for i, (x, number) in enumerate(zip(values, known, strict=True))
        )

    def matrix(self, rows: object, where: str) -> Matrix:
        """Read a list of rows of equal length."""
        listed = self._listed(rows, where, "rows")
        result = tuple(self.vector(row, f"{where}[{i + 1}]") for i, row in enumerate(listed))
        for i, row in enumerate(result):
            if len(row) != len(result[0]):
                raise self.error(
                    f"`{where}` is ragged: row {i + 1} is {len(row)} long and row 1 is "
                    f"{len(result[0])} long"
                )
        return result

    def square(
        self, block: Mapping[str, Any], letters: Iterable[str], where: str = ""
    ) -> dict[str, Matrix]:
        """Read the named matrices of a block."""
        missing = [x for x in letters if x not in block]
        if missing:
            raise self.error(f"`{where}{missing[0]}` is missing; give all of {', '.join(letters)}")
        return {x: self.matrix(block[x], where + x) for x in letters}
