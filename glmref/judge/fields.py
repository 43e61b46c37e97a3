"""The field of a certificate: it reads entries and checks radicals (section 2)."""

import cmath
import re
from copy import copy

from .arithmetic import Fraction, rational_of
from .grammar import DIGITS, parse, plain
from .linalg import diagonal
from .numbers import Element, conj, enclose, real, upper, vanishes
from .refusals import SIZE, as_object, keys, require, whole
from .towers import DIMENSION, Tower


class Numbers:
    """The field of a certificate: reads entries and checks radicals (2)."""

    def __init__(self, field):
        kind = field.get("kind") if isinstance(field, dict) else None
        more = {"rational": "", "tower": "generators radicals", "balls": "generators radicals",
                "enclosure": "generators radicals"}  # fmt: skip
        require(isinstance(kind, str) and kind in more, "no field is of this kind")
        keys(field, "kind " + more[kind], "", "field")
        self.tower, self.memory, self.radicals = Tower(field.get("generators", ())), {}, {}
        self.entries = {}
        self.unknowns, self.decimal, self.explicit = {}, None, None
        texts = field.get("radicals", {})
        require(isinstance(texts, dict) and len(texts) <= 100, "radicals are an object")
        self.radicals = {text: self.tower.parse(value) for text, value in texts.items()}
        for text, value in self.radicals.items():
            self.check_radical(text, value)

    def changed(self, **more):
        """Return the same numbers with other unknowns, or another meaning of decimals."""
        other = copy(self)
        other.memory, other.entries = {}, {}
        for key, value in more.items():
            setattr(other, key, value)
        return other

    def radical(self, text):
        """Return what a radical is said to be."""
        require(text in self.radicals, f"the radical {text[:60]} is not in the field")
        return self.radicals[text]

    def check_radical(self, text, x):
        """Refuse a value that is not the radical."""
        wrong = f"{text[:60]} is another number"
        if text == "i":
            require(x * x == -1 and upper(x), wrong)
            return
        found = re.fullmatch(r"(sqrt|root|exp)\((.*)\)", text)
        require(found, f"{text[:60]!r} is no radical")
        kind, inner = found.groups()
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
    def check_root_of_unity(inner, x, wrong):
        """Refuse x unless x^n = 1 and x is nearer to the angle than other roots are."""
        turns = parse(inner, {"pi": Fraction(1, 2)}.get, lambda text: Fraction(1))
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

    def name(self, document, name):
        """Return the value of a constant or unknown of the document."""
        memory = self.memory.setdefault(id(document), (document, {}))[1]  # keeps the object
        if name not in memory:
            memory[name] = None  # a constant that uses itself finds nothing
            own = document.get("constants", {})
            require(isinstance(own, dict), "constants are an object")
            if name in document.get("unknowns", {}):
                require(name in self.unknowns and name not in own, "an unknown")
                memory[name] = self.unknowns[name]
            elif name in own:
                above = {*list(own)[: list(own).index(name)], *document.get("unknowns", {})}
                memory[name] = self.entry(own[name], document, above)
        return memory[name]

    def entry(self, text, document, allowed=None):
        """Return the number of an entry of a document."""
        memory = self.entries.setdefault(id(document), (document, {}))[1]  # keeps the object
        if allowed is None and isinstance(text, str) and text in memory:
            return memory[text]
        found = self.read(text, document, allowed)
        if allowed is None:
            memory[text] = found
        return found

    def read(self, text, document, allowed):
        """Return the number of an entry that was not read before."""
        own = as_object(document.get("constants", {}))
        constants = {x: own[x] for x in own if allowed is None or x in allowed}

        def known(name):
            return self.name(document, name) if allowed is None or name in allowed else None

        def written_out(text):
            require(isinstance(text, str), "a constant is no text")
            text = re.sub(r"[A-Za-z_][A-Za-z_0-9]*", lambda m: f"({written_out(constants[m[0]])})"
                          if m[0] in constants else m[0], plain(text))  # fmt: skip
            require(len(text) <= DIGITS, "beyond the limits of this checker")
            return text

        def decimal(number):
            if not rational_of(number):
                return Fraction(0)  # 0.000 of a table is 0
            require(self.decimal is not None, "a decimal is no exact number")
            return self.decimal(number, whole(document["digits"], 1, 400))

        return parse(text, known, self.radical, written_out,
                     decimal if "digits" in document else None)  # fmt: skip

    def vector(self, texts, document=None):
        """Return a list of entries of the document, or of a witness."""
        require(isinstance(texts, list) and 0 < len(texts) <= SIZE, "a list of numbers is missing")
        if document is None:
            return [self.number(text) for text in texts]
        found = [self.entry(text, document) for text in texts]
        if document.get("field") != "complex" and not all(self.tower.real):
            real_ = all(not isinstance(x, Element) or conj(x) == x for x in found)
            require(real_, "an entry of a real method is not real")
        return found

    def matrix(self, rows, document=None):
        """Return a matrix of the document, or of a witness."""
        require(isinstance(rows, list) and 0 < len(rows) <= SIZE, "a matrix is missing")
        rows = [self.vector(row, document) for row in rows]
        require(len({len(row) for row in rows}) == 1, "rows of a matrix have other lengths")
        return rows

    def form(self, value, document):
        """Return a matrix of the document that may be written as its diagonal."""
        flat = isinstance(value, list) and value and isinstance(value[0], str)
        return diagonal(self.vector(value, document)) if flat else self.matrix(value, document)

    def number(self, text):
        """Return a number of a witness."""
        return self.tower.parse(text, self.radical)
