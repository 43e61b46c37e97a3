"""Pictures as PNG and PDF: the shapes of an SVG document of this package, drawn by matplotlib."""

from __future__ import annotations

import re
import warnings
from collections.abc import Iterator, Mapping
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np

from ..system.files import write_bytes

#: The notice where requested figures cannot be drawn.
NO_FIGURES = "no PNG and PDF: matplotlib is not installed; pip install 'glmref[plots]'"
#: Points of matplotlib to a px of a picture that is 100 px an inch, and of its letters: those of
#: matplotlib's font are wider than those the picture was made for.
_POINT, _LETTER = 0.72, 0.63
_ANCHORS = {"start": "left", "middle": "center", "end": "right"}
#: Characters that no font has.
_CONTROL = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def write_figures(path: Path, svg: str) -> str | None:
    """Write a picture as PNG, and as PDF beside it; both come out the same every time.

    Returns a notice where matplotlib is not installed.

    Raises
    ------
    UsageError
        Where a file cannot be written.
    """
    try:
        figures = import_module("matplotlib.figure")
    except ImportError:
        return NO_FIGURES
    root = ElementTree.fromstring(svg)
    wide, high = (float(root.attrib[key]) for key in ("width", "height"))
    figure = figures.Figure(figsize=(wide / 100, high / 100), dpi=200)
    axes = figure.add_axes((0, 0, 1, 1), xlim=(0, wide), ylim=(high, 0))
    axes.set_axis_off()
    for node in root.iter():
        _draw(axes, str(node.tag).rpartition("}")[2], node.attrib, node.text or "")
    kinds: dict[str, dict[str, None]] = {"png": {"Software": None}, "pdf": {"CreationDate": None}}
    for kind, metadata in kinds.items():
        content = BytesIO()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # a font need not have every sign
            figure.savefig(content, format=kind, metadata=metadata)
        write_bytes(path.with_suffix(f".{kind}"), content.getvalue())
    return None


def _draw(axes: Any, shape: str, given: Mapping[str, str], text: str) -> None:
    """Draw one element of a picture."""
    patches = import_module("matplotlib.patches")
    width = float(given.get("stroke-width", 1)) * _POINT
    dashes = [float(x) * _POINT for x in given.get("stroke-dasharray", "").split()]
    look = {
        "facecolor": given.get("fill", "none"), "edgecolor": given.get("stroke", "none"),
        "alpha": float(given.get("stroke-opacity", 1)), "linewidth": width,
        "linestyle": (0, dashes) if dashes else "-",
    }  # fmt: skip

    def numbers(*keys: str) -> list[float]:
        return [float(given.get(key, 0)) for key in keys]

    if shape == "text":
        (x, y), turned = numbers("x", "y"), re.findall(r"[-\d.]+", given.get("transform", ""))
        axes.text(
            *((x, y) if not turned else map(float, turned[:2])), _CONTROL.sub("?", text),
            size=float(given.get("font-size", 12)) * _LETTER, color=given["fill"],
            ha=_ANCHORS[given.get("text-anchor", "start")], va="baseline", parse_math=False,
            weight=given.get("font-weight", "normal"), rotation=90 if turned else 0,
            rotation_mode="anchor",
        )  # fmt: skip
    elif shape == "rect":
        x, y, wide, high = numbers("x", "y", "width", "height")
        axes.add_patch(patches.Rectangle((x, y), wide, high, **look))
    elif shape == "circle":
        x, y, radius = numbers("cx", "cy", "r")
        axes.add_patch(patches.Circle((x, y), radius, **look))
    elif shape in ("polygon", "polyline"):
        points = np.array(re.findall(r"[-\d.]+", given["points"]), dtype=float).reshape(-1, 2)
        axes.add_patch(patches.Polygon(points, closed=shape == "polygon", **look))
    elif shape == "path" and "round" in given.values():
        places = np.array([line[0] for line, _ in _lines(given["d"])])
        axes.plot(*places.T, ".", color=given["stroke"], markersize=2 * width, mew=0)
    elif shape == "path":
        paths = import_module("matplotlib.path")
        parts = [paths.Path(line, closed=closed) for line, closed in _lines(given["d"])]
        axes.add_patch(patches.PathPatch(paths.Path.make_compound_path(*parts), **look))


def _lines(d: str) -> Iterator[tuple[list[tuple[float, float]], bool]]:
    """Yield the lines of a path, the points of each and whether it is closed."""
    for part in d.split("M")[1:]:
        line: list[tuple[float, float]] = []
        for word, rest in re.findall(r"([LhvV]?)([^LhvVz]+)", part):
            values = [float(x) for x in re.findall(r"[-\d.]+", rest)]
            if word == "h":
                line.append((line[-1][0] + values[0], line[-1][1]))
            elif word in ("v", "V"):
                line.append((line[-1][0], values[0] + (line[-1][1] if word == "v" else 0)))
            else:
                line += zip(values[::2], values[1::2], strict=True)
        closed = part.rstrip().endswith("z")
        yield [*line, line[0]] if closed else line, closed
