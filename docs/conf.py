"""Sphinx settings of the documentation; built with warnings as errors, read without a network."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert

from glmref import __version__

project = "glmref"
author = "the glmref authors"
project_copyright = "the glmref authors"
release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "audit/*", "campaigns/*", "nonseparable/*"]

autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints = "description"
autodoc_type_aliases = {"Matrix": "Matrix", "Vector": "Vector"}
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "glmref"
html_static_path = ["_static"]
html_css_files = ["pictures.css"]
html_math_renderer = "mathml"

PUNCTUATION = re.compile(r"[.,;:!?)]+")
NUMBER = re.compile(r"(\b\d[\d.]*e-\d+)")


#: A prime in MathML is a script, which fonts without a table of mathematics draw tiny, and the same
#: fonts have no tall brackets: a prime becomes a character, brackets become borders of the table.
PRIME = re.compile(r"<msup>(<mi>[^<]*</mi>)<mi>(&#x0203[2-4];)</mi></msup>")
BRACKETS = re.compile(
    r"<mo>&#x00028;</mo><mtable>((?:(?!<mtable>).)*?</mtable>)<mo>&#x00029;</mo>", re.S
)
#: A bar behind a letter would be set as a relation, with spaces around it.
BAR = re.compile(r"<mo(?: stretchy=\"false\")?>&#x0007C;</mo>")
#: Browsers know no variants of a letter: the complex numbers are a character, bold is a style.
COMPLEX = '<mi mathvariant="double-struck">C</mi>'


def mathml(text: str, display: str = "inline") -> str:
    """Return a formula in LaTeX as MathML that looks right with every font."""
    found = PRIME.sub(
        r'<mrow>\1<mo lspace="0" rspace="0">\2</mo></mrow>', convert(text, display=display)
    )
    found = BAR.sub('<mo stretchy="false" lspace="0" rspace="0">&#x0007C;</mo>', found)
    found = found.replace(COMPLEX, '<mi mathvariant="normal">&#x02102;</mi>')
    return BRACKETS.sub(r'<mtable class="matrix">\1', found)


def _inline(translator: Any, node: nodes.Element) -> None:
    after = node.get("after", "")
    formula = f"{mathml(node.astext())}{after}"
    translator.body.append(f'<span class="formula">{formula}</span>' if after else formula)
    raise nodes.SkipNode


def _punctuated(app: Any, doctree: nodes.document, name: str) -> None:
    """Give formulas within the text the punctuation behind them: no line begins with it."""
    for node in list(doctree.findall(nodes.math)):
        place = node.parent.index(node) + 1
        behind = node.parent[place] if place < len(node.parent) else None
        if isinstance(behind, nodes.Text) and (mark := PUNCTUATION.match(behind.astext())):
            node["after"] = mark[0]
            node.parent[place] = nodes.Text(behind.astext()[mark.end() :])


def _unbroken(app: Any, doctree: nodes.document, name: str) -> None:
    """Keep numbers such as 1.2e-13 in one line: a browser may break a line behind a hyphen."""
    for node in list(doctree.findall(nodes.Text)):
        parts = NUMBER.split(node.astext())
        if len(parts) == 1 or isinstance(node.parent, nodes.FixedTextElement | nodes.literal):
            continue
        place = node.parent.index(node)
        node.parent[place : place + 1] = [
            nodes.inline(part, part, classes=["number"]) if k % 2 else nodes.Text(part)
            for k, part in enumerate(parts)
            if part
        ]


def _display(translator: Any, node: nodes.Element) -> None:
    translator.body.append(f"<div>{mathml(node.astext(), 'block')}</div>")
    raise nodes.SkipNode


def _sections(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Give sections underlined with dashes whose text is indented the form that ends in a colon."""
    for k in range(len(lines) - 2, 0, -1):
        underlined = lines[k].strip() and not lines[k].strip("- ")
        if underlined and lines[k - 1].strip().istitle() and lines[k + 1].startswith(" "):
            lines[k - 1 : k + 1] = [f"{lines[k - 1].rstrip()}:"]


NAMES = re.compile(r"(\s*)(\w+(?:, \w+)+)( : .*)?")


def _attributes(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Give attributes that share a line an entry each: napoleon takes one for the type."""
    place = next((k for k in range(1, len(lines)) if lines[k - 1] == "Attributes"), None)
    place = None if place is None else place + 1
    while place is not None and place < len(lines):
        if lines[place].strip() and not lines[place].strip(" -"):  # the next section begins
            return
        if found := NAMES.fullmatch(lines[place]):
            end = place + 1
            while end < len(lines) and lines[end].startswith(f"{found[1]} "):
                end += 1
            text = lines[place + 1 : end]
            entries = [[f"{found[1]}{x}{found[3] or ''}", *text] for x in found[2].split(", ")]
            lines[place:end] = [line for entry in entries for line in entry]
            place += sum(map(len, entries)) - 1
        place += 1


def setup(app: Any) -> None:
    """Write formulas as MathML, which browsers show without a script from elsewhere."""
    app.connect("autodoc-process-docstring", _sections, priority=100)
    app.connect("autodoc-process-docstring", _attributes, priority=110)
    app.connect("doctree-resolved", _punctuated)
    app.connect("doctree-resolved", _unbroken)
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
