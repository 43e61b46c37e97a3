"""What a record does for a person: shown in a notebook, drawn, saved.

Methods, analyses and solutions lie below the subpackages that draw and write them. They ask those
by name, here and nowhere else, and only when a person asks them.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

from ..errors import UsageError
from .arguments import place, shown
from .files import write_text

#: Style of a picture in a file of its own: its colours are turned over on a dark desktop. Within a
#: page nothing matches, since the picture is not the root of the document there.
DARK = (
    "<style>@media (prefers-color-scheme: dark) { svg:root { "
    "filter: invert(.91) hue-rotate(180deg); background: #171717 } }</style>"
)

#: What records ask of the subpackages above: module and function.
ABOVE = (
    ("report.notebook", "html"),
    ("views.plot", "plot_solution"),
    ("engine.between", "at"),
    ("scenes.modified", "modified_energy"),
    ("exchange.export", "save"),
    ("exchange.documents", "method_document"),
)


def above(module: str, function: str) -> Callable[..., Any]:
    """Return a function of :data:`ABOVE`."""
    assert (module, function) in ABOVE
    return getattr(import_module(f"glmref.{module}"), function)


class Shown:
    """A record that a notebook shows as HTML."""

    __slots__ = ()

    def _repr_html_(self) -> str:
        return above("report.notebook", "html")(self)


class ShownList(list[Any], Shown):
    """A list of records that a notebook shows as one table."""

    __slots__ = ()


class Drawing(str):
    """A picture as the text of an SVG document."""

    __slots__ = ()

    def __repr__(self) -> str:
        return f"<Drawing in SVG, {len(self)} characters; .save(path) writes it>"

    def _repr_svg_(self) -> str:
        # A picture wider than the cell is made smaller instead of being cut off.
        return self.replace("<svg ", '<svg style="max-width:100%;height:auto" ', 1)

    def save(self, path: str | Path) -> Path:
        """Write the picture, which follows the dark mode of the desktop then.

        Raises
        ------
        UsageError
            Where the file cannot be written, or is not called ``.svg``.
        """
        file = place("path", path)
        if file.suffix != ".svg":
            stem = shown(file.stem, str)
            raise UsageError(f"a picture is written as SVG; give a name such as {stem}.svg")
        head, bracket, rest = self.partition(">")
        write_text(file, f"{head}{bracket}{DARK}{rest}")
        return file
