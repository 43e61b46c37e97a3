"""Sphinx settings of the documentation; built with warnings as errors, read without a network."""

from __future__ import annotations

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
exclude_patterns = ["_build", "audit/*"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_type_aliases = {"Matrix": "Matrix", "Vector": "Vector"}
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "glmref"
html_static_path = ["_static"]
html_css_files = ["pictures.css"]
html_math_renderer = "mathml"


def _inline(translator: Any, node: nodes.Element) -> None:
    translator.body.append(convert(node.astext()))
    raise nodes.SkipNode


def _display(translator: Any, node: nodes.Element) -> None:
    translator.body.append(f"<div>{convert(node.astext(), display='block')}</div>")
    raise nodes.SkipNode


def _sections(app: Any, what: str, name: str, obj: Any, options: Any, lines: list[str]) -> None:
    """Give sections underlined with dashes whose text is indented the form that ends in a colon."""
    for k in range(len(lines) - 2, 0, -1):
        underlined = lines[k].strip() and not lines[k].strip("- ")
        if underlined and lines[k - 1].strip().istitle() and lines[k + 1].startswith(" "):
            lines[k - 1 : k + 1] = [f"{lines[k - 1].rstrip()}:"]


def setup(app: Any) -> None:
    """Write formulas as MathML, which browsers show without a script from elsewhere."""
    app.connect("autodoc-process-docstring", _sections, priority=100)
    app.add_html_math_renderer("mathml", (_inline, None), (_display, None))
