"""Sphinx settings of the documentation; built with warnings as errors."""

from __future__ import annotations

from glmref import __version__

project = "glmref"
author = "the glmref authors"
project_copyright = "the glmref authors"
release = __version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 3
nitpicky = False
exclude_patterns = ["_build"]

autodoc_member_order = "bysource"
autodoc_typehints = "description"
napoleon_use_rtype = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = "glmref"
html_static_path: list[str] = []
