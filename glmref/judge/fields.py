"""The field of a certificate: it reads entries and checks radicals (section 2)."""

from __future__ import annotations

import cmath
import re
from collections.abc import Callable, Container, Mapping
from copy import copy
from typing import cast

from .arithmetic import Fraction, Number, rational_of
from .grammar import parse
from .linalg import diagonal
from .numbers import Element, conj, enclose, real, upper, vanishes
from .refusals import (
    SIZE,
    Document,
    as_list,
    as_object,
    keys,
    matched,
    require,
    shown,
    whole,
)
from .towers import DIMENSION, Tower


def some(value: object, why: str) -> list:
    """Return a list of 1 to SIZE values."""
    found = as_list(value, why)
    require(0 < len(found) <= SIZE, why)
    return found


class Numbers:
    """The field of a certificate: reads entries and checks radicals (2)."""

    def __init__(self, field: Document) -> None:
        kind, more = field.get("kind"), "generators radicals"
        require(kind in ("rational", "tower", "balls", "enclosure"), "no field is of this kind")
        keys(field, "kind" if kind == "rational" else "kind " + more, "", "field")
        self.tower = Tower(as_list(field.get("generators", []), "generators are a list"))
        self.memory, self.entries, self.radicals = {}, {}, {}
        self.unknowns: Mapping[str, Number] = {}
        self.decimal: Callable[[str, int], Number] | None = None
        self.explicit: frozenset[int] | None = None
        texts = as_object(field.get("radicals", {}), "radicals are an object")
        require(len(texts) <= 100, "radicals are an object")
        self.radicals = {text: self.tower.parse(value) for text, value in texts.items()}
        for text, value in self.radicals.items():
            self.check_radical(text, value)

    def changed(self, **more: object) -> Numbers:
        """Return the same numbers with other unknowns, or another meaning of decimals."""
        other = copy(self)
        other.memory, other.entries = {}, {}
        for key, value in more.items():
            setattr(other, key, value)
        return other

    def radical(self, text: str) -> Number:
        """Return what a radical is said to be."""
        require(text in self.radicals, f"the radical {text[:60]} is not in the field")
        return self.radicals[text]

    def check_radical(self, text: str, x: Number) -> None:
        """Refuse a value that is not the radical."""
        wrong = f"{text[:60]} is another number"
        if text == "i":
            require(x * x == -1 and upper(x), wrong)
            return
        why = f"{text[:60]!r} is no radical"
        kind, inner = matched(r"(sqrt|root|exp)\((.*)\)", text, why).groups()
        if kind == "exp":
            self.check_root_of_unity(inner, x, wrong)
            return
        power = 2
        if kind == "root":
            inner, _, last = inner.rpartition(",")
            require(last.isdigit() and 1 <= int(last) <= DIMENSION, wrong)
            power = int(last)
        require(x**power == parse(inner, lambda name: None, self.radical), wrong)
        if not x:
            return
        half = vanishes(real(x)) and upper(x) if kind == "sqrt" else False
        require(half or (enclose(x).re.positive() and (kind == "sqrt" or conj(x) == x)), wrong)

    @staticmethod
    def check_root_of_unity(inner: str, x: Number, wrong: str) -> None:
        """Refuse x unless x^n = 1 and x is nearer to the angle than other roots are."""
        read = parse(inner, {"pi": Fraction(1, 2)}.get, lambda text: Fraction(1))
        turns = cast("Fraction", read)  # of rational numbers
        factors = sorted(re.findall("[a-z]+", inner)) if turns else ["i", "pi"]
        fine = factors == ["i", "pi"] and not re.search(r"/\D|[\w)][-+]", inner)  # no sum
        require(fine, f"not covered: the angle {inner[:40]}")
        n, box = int(turns.denominator), enclose(x)
        require(n <= 100 and x**n == 1, wrong)
        # the n-th roots are 4/n apart at least, so that floating-point numbers tell which one it is
        middle = complex(float(box.re), float(box.im))
        require(
            abs(middle - cmath.exp(2j * cmath.pi * int(turns.numerator % n) / n)) * n < 1, wrong
        )

    def name(self, document: Document, name: str) -> Number | None:
        """Return the value of a constant or unknown of the document."""
        memory = self.memory.setdefault(id(document), (document, {}))[1]  # keeps the object
        if name not in memory:
            found = None
            own = as_object(document.get("constants", {}), "constants are an object")
            unknowns = as_object(document.get("unknowns", {}))
            if name in unknowns:
                require(name in self.unknowns, "an unknown")
                found = self.unknowns[name]
            elif name in own:  # it uses constants above it, never itself
                above = {*list(own)[: list(own).index(name)], *unknowns}
                found = self.entry(own[name], document, above)
            memory[name] = found
        return memory[name]

    def entry(
        self, text: object, document: Document, allowed: Container[str] | None = None
    ) -> Number:
        """Return the number of an entry of a document."""
        memory = self.entries.setdefault(id(document), (document, {}))[1]  # keeps the object
        if allowed is None and isinstance(text, str) and text in memory:
            return memory[text]
        found = self.read(text, document, allowed)
        if allowed is None:
            memory[text] = found
        return found

    def read(self, text: object, document: Document, allowed: Container[str] | None) -> Number:
        """Return the number of an entry that was not read before."""
        own = as_object(document.get("constants", {}))
        constants = {x: own[x] for x in own if allowed is None or x in allowed}

        def known(name: str) -> Number | None:
            return self.name(document, name) if allowed is None or name in allowed else None

        def decimal(number: str) -> Number:
            if not rational_of(number):
                return Fraction(0)  # 0.000 of a table is 0
            read = shown(self.decimal, "a decimal is no exact number")
            return read(number, whole(document["digits"], 1, 400))

        return parse(text, known, self.radical, constants,
                     decimal if "digits" in document else None)  # fmt: skip

    def vector(self, texts: object, document: Document | None = None) -> list:
        """Return a list of entries of the document, or of a witness."""
        given = some(texts, "a list of numbers is missing")
        if document is None:
            return [self.number(text) for text in given]
        found = [self.entry(text, document) for text in given]
        if document.get("field") != "complex" and not all(self.tower.real):
            real_ = all(not isinstance(x, Element) or conj(x) == x for x in found)
            require(real_, "an entry of a real method is not real")
        return found

    def matrix(self, rows: object, document: Document | None = None) -> list:
        """Return a matrix of the document, or of a witness."""
        found = [self.vector(row, document) for row in some(rows, "a matrix is missing")]
        require(len({len(row) for row in found}) == 1, "rows of a matrix have other lengths")
        return found

    def form(self, value: object, document: Document) -> list:
        """Return a matrix of the document that may be written as its diagonal."""
        flat = isinstance(value, list) and value and isinstance(value[0], str)
        return diagonal(self.vector(value, document)) if flat else self.matrix(value, document)

    def number(self, text: object) -> Number:
        """Return a number of a witness."""
        return self.tower.parse(text, self.radical)
