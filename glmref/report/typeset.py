"""Entries of a tableau as mathematics (MathML): fractions, roots and powers as a paper has them.

Entries follow the grammar of the data contract. A text that does not is shown as it is.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from .markup import escape, scrolling

__all__ = ["typeset", "typeset_table"]

_TOKEN = re.compile(r"\s*(?:(\d+(?:\.\d+)?(?:e[-+]?\d+)?)|([A-Za-z_]\w*)|([-+*/(),]))")
_MOST_ENTRIES = 150  # of a tableau that is shown at once
_SHOWN = 12  # digits of a decimal before it is cut


@dataclass(frozen=True)
class _Node:
    """MathML, and whether it is a sum in brackets that a fraction or a root makes needless."""

    text: str
    inner: str = ""

    @property
    def bare(self) -> str:
        return self.inner or self.text


class _Reader:
    """Recursive descent over the tokens of one entry."""

    def __init__(self, text: str) -> None:
        self.tokens: list[str] = []
        at = 0
        while at < len(text.rstrip()):
            match = _TOKEN.match(text, at)
            if match is None:
                raise ValueError(text)
            self.tokens.append(match[0].strip())
            at = match.end()
        self.at = 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self, expected: str = "") -> str:
        token = self.peek()
        if not token or (expected and token != expected):
            raise ValueError(token)
        self.at += 1
        return token

    def sum(self) -> str:
        parts = [self.product()]
        while self.peek() in ("+", "-"):
            parts.append(f"<mo>{'−' if self.take() == '-' else '+'}</mo>")
            parts.append(self.product())
        return "".join(parts)

    def product(self) -> str:
        signs = ""
        while self.peek() in ("+", "-"):
            signs += "<mo>−</mo>" if self.take() == "-" else ""
        left, number = self.atom()
        while self.peek() in ("*", "/"):
            if self.take() == "/":
                below, _ = self.factor()
                left = _Node(f"<mfrac><mrow>{left.bare}</mrow><mrow>{below.bare}</mrow></mfrac>")
                number = False
            else:
                right, digit = self.factor()
                dot = "<mo>·</mo>" if digit else "<mo>&#x2062;</mo>"
                left, number = _Node(f"{left.text}{dot}{right.text}"), number and digit
        return signs + left.text

    def factor(self) -> tuple[_Node, bool]:
        sign = ""
        while self.peek() in ("+", "-"):
            sign += "<mo>−</mo>" if self.take() == "-" else ""
        node, digit = self.atom()
        return (_Node(f"<mrow>{sign}{node.text}</mrow>"), digit) if sign else (node, digit)

    def atom(self) -> tuple[_Node, bool]:
        token = self.take()
        if token[0].isdigit():
            long = len(token) > _SHOWN + 2
            return _Node(f"<mn>{token[: _SHOWN + 2] + '…' if long else token}</mn>"), True
        if token == "(":
            inner = self.sum()
            self.take(")")
            return _Node(f"<mrow><mo>(</mo>{inner}<mo>)</mo></mrow>", inner), False
        if self.peek() == "(" and token in ("sqrt", "root", "exp"):
            return self.function(token), False
        if not (token[0].isalpha() or token[0] == "_"):
            raise ValueError(token)
        return _Node(_name(token)), False

    def function(self, name: str) -> _Node:
        self.take("(")
        inner = self.sum()
        if name == "root":
            self.take(",")
            degree = self.take()
            self.take(")")
            return _Node(f"<mroot><mrow>{inner}</mrow><mn>{degree}</mn></mroot>")
        self.take(")")
        if name == "sqrt":
            return _Node(f"<msqrt>{inner}</msqrt>")
        return _Node(f"<msup><mi>e</mi><mrow>{inner}</mrow></msup>")


def _name(token: str) -> str:
    if token == "pi":
        return "<mi>π</mi>"
    match = re.fullmatch(r"([A-Za-z]+)_?(\d+)", token)
    if match:
        return f"<msub><mi>{_letter(match[1])}</mi><mn>{match[2]}</mn></msub>"
    return f"<mi>{escape(_letter(token))}</mi>"


def _letter(name: str) -> str:
    greek = {"alpha": "α", "beta": "β", "gamma": "γ", "delta": "δ", "theta": "θ", "omega": "ω"}
    return greek.get(name, name)


def typeset(text: str) -> str:
    """Return an entry as MathML, or as it is where it follows no grammar.

    >>> typeset("1/2")
    '<math displaystyle="true"><mfrac><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></mfrac></math>'
    """
    text = text.strip()
    if not text:
        return ""
    try:
        reader = _Reader(text)
        found = reader.sum()
        if reader.peek():
            raise ValueError(text)
    except (ValueError, RecursionError):
        return f"<code>{escape(text)}</code>"
    return f'<math displaystyle="true">{found}</math>'


def typeset_table(grid: list[list[list[list[str]]]]) -> str:
    """A partitioned matrix: blocks with rules between them.

    Args:
        grid: rows of blocks, each a list of rows of entries.
    """
    lines = []
    for i, row in enumerate(grid):
        for k in range(len(row[0])):
            cells = "".join(
                f"<td{' class=left' if j and n == 0 else ''}>{typeset(entry)}"
                for j, block in enumerate(row)
                for n, entry in enumerate(block[k])
            )
            lines.append(f"<tr{' class=top' if i and k == 0 else ''}>{cells}")
    body = "".join(lines)
    table = scrolling(f'<table class="tableau"><tbody>{body}</tbody></table>', "tableau")
    if body.count("<td") <= _MOST_ENTRIES:
        return table
    return f"<details><summary>a tableau of {len(lines)} rows</summary>{table}</details>"
