"""Entries of a tableau as mathematics (MathML): fractions, roots and powers as a paper has them.

Entries follow the grammar of the data contract. A text that does not is shown as it is.
"""

from __future__ import annotations

import re

from markupsafe import Markup, escape

from ..errors import DataError
from ..views.notation import Notation
from .markup import render

_MOST_ENTRIES = 150  # of a tableau that is shown at once
_SHOWN = 12  # digits of a decimal before it is cut


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


def _number(text: str) -> str:
    return f"<mn>{text if len(text) <= _SHOWN + 2 else text[: _SHOWN + 2] + '…'}</mn>"


_MATHML = Notation(
    number=_number,
    name=_name,
    plus="<mo>+</mo>",
    minus="<mo>−</mo>",
    dot="<mo>·</mo>",
    times="<mo>&#x2062;</mo>",
    group="<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
    fraction="<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>",
    square_root="<msqrt>{}</msqrt>",
    root="<mroot><mrow>{}</mrow><mn>{}</mn></mroot>",
    exponential="<msup><mi>e</mi><mrow>{}</mrow></msup>",
)


def typeset(text: str) -> Markup:
    """Return an entry as MathML, or as it is where it follows no grammar.

    >>> print(typeset("1/2"))
    <math displaystyle="true"><mfrac><mrow><mn>1</mn></mrow><mrow><mn>2</mn></mrow></mfrac></math>
    """
    text = text.strip()
    if not text:
        return Markup()
    try:
        found = _MATHML.of(text)
    except DataError:
        return Markup("<code>{}</code>").format(text)
    return Markup(f'<math displaystyle="true">{found}</math>')


def typeset_table(grid: list[list[list[list[str]]]]) -> Markup:
    """Return a partitioned matrix with rules between its blocks, each a list of rows of entries."""
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
