"""A method as a person expects to see it: the partitioned tableau, in plain text.

A one-step method is shown as its Butcher tableau, c | A over b; any other as c | A | U over B | V;
a pair as the tableaux of its two halves. Entries are the expressions of the file, or decimals. What
is too long for a tableau is named in it and written out below.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from ..catalogue.claims import ABSCISSAE, stated_orders
from ..catalogue.lookup import method_of
from ..errors import UsageError
from ..exact import Ball, Exact, Scalar
from ..exact.expression import shown_number
from ..exact.linalg import Matrix, Vector
from ..method import GLM, AdditiveGLM, PartitionedGLM, RosenbrockGLM
from ..prove.facts import Facts, facts_of
from ..system.arguments import shown, whole
from .tableau_text import Cells, decimal_text, size_of, tableau
from .tables import Style, one_line

#: Draws a partitioned matrix, rows of blocks of cells, as lines.
Draw = Callable[[Sequence[Sequence[Cells]]], list[str]]

DIGITS = 10  # of a published decimal that is too long for a tableau
_LONG = (32, 24, 16, 12)  # an entry longer than this is named; the first that fits is taken
_MOST_DIGITS = 10_000
_ENDLESS = 10**6  # columns of a terminal on which nothing is broken
_WORD = re.compile(r"[A-Za-z_]\w*")
#: What defines a class, where that is not its tableau.
_DEFINED_BY: Mapping[str, tuple[str, ...]] = {
    "lmm": ("alpha", "beta"),
    "one-leg": ("alpha", "beta"),
    "splitting": ("a", "b"),
    "composition": ("gamma",),
}


class Text(str):
    """A text of several lines that an interpreter and a notebook show as it stands."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


def show(
    method: GLM | PartitionedGLM | AdditiveGLM | str | Path,
    *,
    decimal: int | None = None,
    style: Style | None = None,
) -> str:
    """Return a method as text: title, tableau, legend, forms, starting method, source.

    Parameters
    ----------
    method : GLM or PartitionedGLM or AdditiveGLM or str or Path
        A loaded or computed method, its name or its file.
    decimal : int or None
        Significant digits of decimals; exact expressions by default.
    style : Style or None
        What the terminal shows. What is wider than it is wrapped.

    Returns
    -------
    str
        The text, which an interpreter shows as it stands.
    """
    method = method_of(method)
    if decimal is not None:
        whole("decimal", decimal, 1, _MOST_DIGITS)
    style = Style() if style is None else style
    if not isinstance(style, Style):
        raise UsageError(f"`style` must be a Style, got {shown(style)}")
    unbroken = replace(style, width=_ENDLESS)
    for long in _LONG if decimal is None else _LONG[-1:]:
        page = _Page(method, decimal, unbroken, long)
        if page.width <= style.width:
            page.style = style
            break
    else:
        page = _Page(method, decimal, style, _LONG[0])
    return Text(page.text())


@dataclass(frozen=True)
class Parts:
    """What a method's page is made of."""

    #: (heading, lines that were drawn), the tableau first.
    blocks: tuple[tuple[str, tuple[str, ...]], ...]
    legend: Mapping[str, str]  #: Name in a tableau -> what it stands for.
    rounded: bool  #: Whether published decimals were rounded.


def parts(method: GLM | PartitionedGLM | AdditiveGLM, draw: Draw) -> Parts:
    """Return the blocks of a method, each drawn by ``draw``; long entries are named."""
    page = _Page(method, None, Style(), _LONG[0], draw)
    blocks = tuple((heading, tuple(lines)) for heading, lines in page.body)
    return Parts(blocks, page.names_used(), page.rounded)


class _Page:
    """One method, laid out with entries of at most ``long`` characters."""

    def __init__(
        self, method: GLM | PartitionedGLM | AdditiveGLM, decimal: int | None, style: Style,
        long: int, draw: Draw | None = None,
    ) -> None:  # fmt: skip
        self.method, self.decimal, self.style, self.long = method, decimal, style, long
        self.draw: Draw = draw or (lambda grid: tableau(grid, style))
        self.document: Mapping[str, Any] = method.document or {}
        unknowns, constants = self.document.get("unknowns", {}), self.document.get("constants", {})
        self.constants: dict[str, str] = {**unknowns, **constants}
        self.names: dict[str, str] = {}  # long text -> name
        self.texts: set[str] = set()
        self.rounded = False
        facts = facts_of(method)
        kind = self.document.get("class")
        if method.rosenbrock:
            self.body = self._rosenbrock()
        elif kind == "nystrom":
            self.body = self._nystrom()
        else:
            self.body = self._pair(facts) if not facts.is_single else self._glm(facts)
        self.body += self._beside(self._embedded_slices(kind))

    @property
    def width(self) -> int:
        """Columns the tableaux need, colours not counted."""
        lines = "\n".join(line for _, lines in self.body for line in lines)
        return max((len(x) for x in re.sub("\x1b\\[\\d*m", "", lines).split("\n")), default=0)

    def text(self) -> str:
        parts = ["\n".join(self._title())]
        for heading, lines in self.body:
            parts.append("\n".join([*self.wrapped(heading), *lines]))
        legend = self._legend()
        if legend:
            parts.append("\n".join(["with", *legend]))
        parts.append("\n".join(self._source()))
        return "\n\n".join(part for part in parts if part)

    def wrapped(self, text: str) -> list[str]:
        """Return a sentence as lines that fit."""
        return textwrap.wrap(text, max(self.style.width, 40))

    # numbers ------------------------------------------------------------------------------------

    def cell(self, x: Scalar, text: object = None) -> str:
        """Return an entry: the text of the file where there is one, a name where it is long."""
        if self.decimal is not None:
            return decimal_text(x, self.decimal)
        written = text if isinstance(text, str) else ""
        if isinstance(x, Ball) and not 0 < len(written) <= self.long:
            self.rounded = True
            return decimal_text(x, DIGITS)
        return self.entry(written or shown_number(x))

    def entry(self, text: str) -> str:
        """Return an expression, or its name where it is long."""
        text = one_line(re.sub(r"\s+", "", text), limit=4000)
        self.texts.add(text)
        if len(text) <= self.long:
            return text
        if text not in self.names:
            taken = {*self.constants, *self.names.values()}
            numbers = (f"x{k}" for k in range(1, len(taken) + 2))
            self.names[text] = next(name for name in numbers if name not in taken)
        return self.names[text]

    def matrix(self, rows: Matrix, texts: object = None) -> Cells:
        """Return the cells of a matrix, from the texts of the file if they have its shape."""
        known: Any = texts if _same_shape(texts, rows) else None
        return [
            [self.cell(x, known[i][j] if known else None) for j, x in enumerate(row)]
            for i, row in enumerate(rows)
        ]

    def vector(self, values: Vector, texts: object = None) -> Cells:
        """Return the cells of a vector, as one row."""
        return self.matrix((tuple(values),), [texts])

    def abscissae(self, values: Vector | None, count: int) -> Cells:
        """Return the column c as the file writes it, if it does; empty where there is none."""
        if values is None:
            return [[""]] * count
        texts: Any = self.method.claims.get(ABSCISSAE.key, ())
        if len(texts) != len(values) or any(
            (x - text.value).is_zero() is not True for x, text in zip(values, texts, strict=True)
        ):
            texts = [None] * len(values)
        return [[self.cell(x, text)] for x, text in zip(values, texts, strict=True)]

    # parts --------------------------------------------------------------------------------------

    def _title(self) -> list[str]:
        method, document = self.method, self.document
        name = one_line(method.name or "(unnamed)")
        title = one_line(document.get("title", ""))
        size = f"pair with {size_of(method)}" if method.parts == 2 else size_of(method)
        if method.parts == 1 and method.is_explicit:
            size += ", explicit"
        lines: list[str] = self.wrapped(f"{name}  {title}" if title else name)
        lines[0] = self.style.paint(name, "bold") + lines[0].removeprefix(name)
        lines += self.wrapped(f"class {document.get('class', 'glm')}: {size}")
        if "base" in document:
            lines += self.wrapped(f"{document['base']} composed with itself, in steps gamma h")
        if "first" in document:
            lines += self.wrapped(
                f"updates in turn, {document['first']} first: q += a h f(p), p += b h k(q)"
            )
        return lines

    def _lists(self) -> list[tuple[str, list[str]]]:
        """Return the lists that define the class, one row each."""
        keys = _DEFINED_BY.get(str(self.document.get("class")), ())
        if not keys or self.decimal is not None:
            return []
        cells = [[key, *map(self.entry, self.document[key])] for key in keys]
        longest = max(map(len, cells))
        cells = [row + [""] * (longest - len(row)) for row in cells]
        grid = [[[row[:1] for row in cells], [row[1:] for row in cells]]]
        return [("", self.draw(grid))]

    def _glm(self, facts: Facts) -> list[tuple[str, list[str]]]:
        method, doc = facts.method, self.document
        own = doc if doc.get("class") in ("glm", "rk") else {}
        body = self._lists()
        body.append(("", self._half(method, own, method.abscissae_given or facts.abscissae)))
        for letter in "GD":
            values = getattr(method, letter)
            if values is not None:
                rows = values if letter == "G" else (values,)
                texts = [own.get(letter)] if letter == "D" else own.get(letter)
                body.append((f"{letter} =", self.draw([[self.matrix(rows, texts)]])))
        return body + self._start_and_finish()

    def _half(self, half: Any, texts: Mapping[str, Any], c: Vector | None) -> list[str]:
        """Draw one method: Butcher's tableau for one-step methods, else the partitioned one."""
        column = self.abscissae(c, len(half.A))
        A = self.matrix(half.A, texts.get("A"))
        if _is_one_step(half):
            b = [texts["b"]] if "b" in texts else texts.get("B")
            return self.draw([[column, A], [[[""]], self.matrix(half.B, b)]])
        U, B, V = (self.matrix(getattr(half, x), texts.get(x)) for x in "UBV")
        return self.draw([[column, A, U], [[[""]] * len(B), B, V]])

    def _rosenbrock(self) -> list[tuple[str, list[str]]]:
        """Draw alpha and gamma side by side, b below."""
        m, doc = self.method, self.document
        assert isinstance(m, RosenbrockGLM)
        alpha, gamma = (self.matrix(getattr(m, x), doc.get(x)) for x in ("alpha", "gamma"))
        grid = [[alpha, gamma], [self.vector(m.b, doc.get("b")), [[""] * len(m.b)]]]
        return [("alpha | gamma, with b below:", self.draw(grid))]

    def _nystrom(self) -> list[tuple[str, list[str]]]:
        """Draw c and A with b and b' below, and A' where there is one."""
        pair: Any = self.method
        doc = self.document
        s = len(doc["c"])
        b, b_prime = self._embedded_slices("nystrom")
        stages = pair.A[-s:]
        c = [[x] for x in self.vector(tuple(sum(x, Exact(0)) for x in stages), doc["c"])[0]]
        empty = [[""]]
        grid = [
            [c, self.matrix(tuple(x[b] for x in stages), doc["A"])],
            [empty, self.vector(pair.B[0][b], doc["b"])],
            [empty, self.vector(pair.B_hat[0][b_prime], doc["b_prime"])],
        ]
        body = [("c | A, with b and b' below:", self.draw(grid))]
        if "A_prime" in doc:
            rows = tuple(x[b_prime] for x in pair.A_hat[-s:])
            body.append(("A' =", self.draw([[self.matrix(rows, doc["A_prime"])]])))
        return body

    def _embedded_slices(self, kind: object) -> tuple[slice, ...]:
        """Return which weights of each component a file of a class writes."""
        m = self.method
        if isinstance(m, RosenbrockGLM):
            return slice(len(m.b)), slice(0)
        if kind == "nystrom":
            s = len(self.document["c"])
            return slice(1, s + 1), slice(-s, None)
        return (slice(None),) * len(m.components)

    def _beside(self, slices: tuple[slice, ...]) -> list[tuple[str, list[str]]]:
        """Draw embedded rows and the coefficients of the dense output."""
        method, texts = self.method, self.document.get("embedded", [])
        body = []
        for n, row in enumerate(method.embedded):
            own = texts[n] if n < len(texts) else {}
            cells: Cells = []
            for k, (weights, part) in enumerate(zip(row.weights, slices, strict=True)):
                given = own.get("b", own.get("error"))
                if k and self.document.get("class") == "nystrom":
                    given = own.get("b_prime")
                elif method.additive and not method.rosenbrock and given:
                    given = given[k]
                cells += self.vector(weights[part], given) if weights[part] else []
            grid = [[cells]]
            if row.values is not None:
                grid = [[cells, self.vector(row.values, own.get("v"))]]
            what = "error estimate" if row.difference else "embedded row"
            body.append((f"{what} {one_line(row.name)}:", self.draw(grid)))
        dense = getattr(method, "dense", None)
        if dense is not None:
            grid = [[self.matrix(dense, self.document.get("dense"))]]
            body.append(("b(theta), by powers of theta from 1:", self.draw(grid)))
        return body

    def _start_and_finish(self) -> list[tuple[str, list[str]]]:
        body = []
        start, finish = self.method.starting, self.method.finishing
        if start is not None:
            block = self.document.get("starting", {})
            ones = [["1"]] * len(start.A)
            u = [[x] for x in self.vector(start.u, block.get("u"))[0]]
            grid = [
                [self.matrix(start.A, block.get("A")), ones],
                [self.matrix(start.B, block.get("B")), u],
            ]
            body.append((_named("starting method", start), self.draw(grid)))
        if finish is not None:
            block = self.document.get("finishing", {})
            grid = [
                [self.matrix(finish.A, block.get("A")), [["1"]] * len(finish.A)],
                [self.vector(finish.b, block.get("b")), [["1"]]],
            ]
            body.append((_named("finishing method", finish), self.draw(grid)))
        return body

    def _pair(self, facts: Facts) -> list[tuple[str, list[str]]]:

        doc, pair = self.document, facts.method
        if pair.additive:
            parts = doc.get("parts", [{}] * len(pair.components))
            return [
                (f"part {c.colour}:", self._half(c, own, known.c))
                for c, own, known in zip(pair.components, parts, facts.consistencies, strict=True)
            ]
        texts: tuple[Mapping[str, Any], Mapping[str, Any]] = (
            {x: doc[x] for x in ("A", "b") if x in doc and doc["class"] == "partitioned-rk"},
            {x: doc[f"{x}_hat"] for x in ("A", "b") if f"{x}_hat" in doc},
        )
        if doc.get("class") == "partitioned":
            texts = doc["q"], doc["p"]
        body = self._lists()
        headings = ("q:  Q = h A f(P) + U q", "p:  P = h A^ k(Q) + U^ p")
        for heading, half, own, known in zip(
            headings, pair.components, texts, facts.consistencies, strict=True
        ):
            body.append((heading, self._half(half, own, known.c)))
        if pair.G is not None:
            body.append(("G =", self.draw([[self.matrix(pair.G, doc.get("G"))]])))
        for letter in ("D_P", "D_Q"):
            values = getattr(pair, letter)
            if values is not None:
                cells = self.vector(values, doc.get(letter))
                body.append((f"{letter} =", self.draw([[cells]])))
        return body + self._pair_start()

    def _pair_start(self) -> list[tuple[str, list[str]]]:
        """Draw the start of a pair: for q and for p the stages above the values, u at the right."""
        start, block = self.method.starting, self.document.get("starting", {})
        if start is None:
            return []
        body, named = [], _named("starting method", start, "Q = h A f(P) + q0")
        headings = (named, "  and for p:  P = h A^ k(Q) + p0")
        for heading, c in zip(headings, start.components, strict=True):
            hat = start.LETTERS[c.colour]
            u = tuple(x for (x,) in c.V)
            right = [[x] for x in self.vector(u, block.get(f"u{hat}"))[0]]
            grid = [
                [self.matrix(c.A, block.get(f"A{hat}")), [["1"]] * len(c.A)],
                [self.matrix(c.B, block.get(f"B{hat}")), right],
            ]
            body.append((heading, self.draw(grid)))
        return body

    def _legend(self) -> list[str]:
        """Return the lines that say what the names in the tableau stand for."""
        names = {} if self.decimal is not None else self.names_used()
        width = max(map(len, names), default=0)
        margin = " " * (width + 5)
        return [
            line
            for name, text in names.items()
            for line in textwrap.wrap(
                f"  {name:<{width}} = {text}", max(self.style.width, 40), subsequent_indent=margin
            )
        ]

    def names_used(self) -> dict[str, str]:
        """Return what the names in the tableau stand for."""
        wanted: set[str] = set()
        words = _words(self.texts)
        while words - wanted:
            wanted |= words
            words = _words(text for name, text in self.constants.items() if name in wanted)
        found = {name: text for text, name in self.names.items()}
        return found | {
            k: one_line(x, limit=4000) for k, x in self.constants.items() if k in wanted
        }

    def _source(self) -> list[str]:
        source = self.method.source
        sentences = (
            [f"{source['citation']}, {source['where']} ({source['status']})"] if source else []
        )
        sentences += source.get("errata", [])
        if "broken" in self.document:
            sentences.append(f"Wrong on purpose: {self.document['broken']['why']}")
        if self.rounded:
            sentences.append(f"Decimals are rounded to {DIGITS} digits; --decimal N shows more.")
        return [line for x in sentences for line in self.wrapped(one_line(x, limit=4000))]


def _same_shape(texts: object, rows: Matrix) -> bool:
    """Return whether texts of the file are the rows of this matrix."""
    if not isinstance(texts, list) or len(texts) != len(rows):
        return False
    return all(isinstance(t, list) and len(t) == len(r) for t, r in zip(texts, rows, strict=True))


def _is_one_step(half: Any) -> bool:
    """Return whether one value is carried, as it is: U and V hold ones only."""
    entries = [x for row in (*half.U, *half.V) for x in row]
    return len(half.V) == 1 and all((x - 1).is_zero() is True for x in entries)


def _words(texts: Iterable[str]) -> set[str]:
    return {word for text in texts for word in _WORD.findall(text)}


def _named(kind: str, method: Any, stages: str = "Y = h A f(Y) + y0") -> str:
    stated = stated_orders(method.claims).get("b")
    order = "" if stated is None else f", order {stated}"
    name = f" ({one_line(method.name)})" if method.name else ""
    return f"{kind}{name}{order}:  {stages}"
