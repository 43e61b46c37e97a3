"""Entries of a tableau as mathematics (MathML): fractions, roots and powers as a paper has them.

Entries follow the grammar of the data contract. A text that does not is shown as it is.
"""

from __future__ import annotations

import re

from markupsafe import Markup, escape

from ..errors import DataError
from ..exact.expression import (
    Exponential,
    Name,
    Negative,
    Node,
    Number,
    Product,
    Root,
    Sum,
    syntax_tree,
)
from .markup import render

_MOST_ENTRIES = 150  # of a tableau that is shown at once
_SHOWN = 12  # digits of a decimal before it is cut


def _written(node: Node) -> str:
    match node:
        case Number(text):
            shown = text if len(text) <= _SHOWN + 2 else text[: _SHOWN + 2] + "…"
            return f"<mn>{shown}</mn>"
        case Name(name):
            return _name(name)
        case Negative(operand):
            return f"<mo>−</mo>{_factor(operand)}"
        case Sum(terms):
            (_, first), *others = terms
            signs = {"+": "<mo>+</mo>", "-": "<mo>−</mo>"}
            return _written(first) + "".join(signs[sign] + _factor(x) for sign, x in others)
        case Product(factors):
            return _product(factors)
        case Root(radicand, 2):
            return f"<msqrt>{_written(radicand)}</msqrt>"
        case Root(radicand, degree):
            return f"<mroot><mrow>{_written(radicand)}</mrow><mn>{degree}</mn></mroot>"
        case Exponential(angle):
            return f"<msup><mi>e</mi><mrow>{_written(angle)}</mrow></msup>"
    raise AssertionError(node)


def _product(factors: tuple[tuple[str, Node], ...]) -> str:
    """Write factors from the left; the sign of the first stands before all of them."""
    (_, first), *others = factors
    sign, first = ("<mo>−</mo>", first.operand) if isinstance(first, Negative) else ("", first)
    written = _written(first) if others[0][0] == "/" else _factor(first)
    for operator, factor in others:
        if operator == "/":
            below = _written(factor)
            written = f"<mfrac><mrow>{written}</mrow><mrow>{below}</mrow></mfrac>"
        else:
            # a dot where two numbers, or a number and a fraction, would be read as one
            apart = isinstance(factor, Number | Product)
            dot = "<mo>·</mo>" if apart else "<mo>&#x2062;</mo>"
            written = f"{written}{dot}{_factor(factor)}"
    return sign + written


def _factor(node: Node) -> str:
    if isinstance(node, Sum | Negative):
        return f"<mrow><mo>(</mo>{_written(node)}<mo>)</mo></mrow>"
    return _written(node)


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


def typeset(text: str) -> Markup:
    """Return an entry as MathML, or as it is where it follows no grammar.

    >>> typeset("1/2")
    '<math displaystyle="true"><mfrac><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></mfrac></math>'
    """
    text = text.strip()
    if not text:
        return Markup()
    try:
        found = _written(syntax_tree(text, exponents=True))
    except DataError:
        return Markup("<code>{}</code>").format(text)
    return Markup(f'<math displaystyle="true">{found}</math>')


def typeset_table(grid: list[list[list[list[str]]]]) -> Markup:
    """A partitioned matrix: blocks with rules between them.

    Parameters
    ----------
    grid : list[list[list[list[str]]]]
        Rows of blocks, each a list of rows of entries.
    """
    rows = [
        (
            bool(i and k == 0),
            [
                (bool(j and n == 0), typeset(entry))
                for j, block in enumerate(row)
                for n, entry in enumerate(block[k])
            ],
        )
        for i, row in enumerate(grid)
        for k in range(len(row[0]))
    ]
    entries = sum(len(cells) for _, cells in rows)
    return render("tableau.html", rows=rows, folded=entries > _MOST_ENTRIES)
