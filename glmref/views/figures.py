"""Figures of matplotlib, where it is installed: PNG, and PDF beside it."""

from __future__ import annotations

import re
import warnings
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

from ..system.files import write_bytes

#: The notice where requested figures cannot be drawn.
NO_FIGURES = "no PNG and PDF: matplotlib is not installed; pip install 'glmref[plots]'"

#: Characters that no font has.
_CONTROL = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069\ud800-\udfff]")


def blank_figure(width: float, height: float) -> Any:
    """Return an empty figure of matplotlib, inches wide and high; ``None`` where it is missing."""
    try:
        agg = import_module("matplotlib.backends.backend_agg")
        figures = import_module("matplotlib.figure")
    except ImportError:
        return None
    figure = figures.Figure(figsize=(width, height), dpi=120, layout="constrained")
    agg.FigureCanvasAgg(figure)
    return figure


def plain_texts(figure: Any) -> None:
    """Have every text of a figure shown as it stands: a `$` begins no formula of TeX."""
    texts = import_module("matplotlib.text")
    for text in figure.findobj(texts.Text):
        text.set_parse_math(False)
        if "$" in text.get_text():
            text.set_wrap(False)  # where lines are broken, formulas are looked for all the same
        text.set_text(_CONTROL.sub("?", text.get_text()))


def svg_text(figure: Any) -> str:
    """Return a figure as the text of an SVG document, the same every time."""
    plain_texts(figure)
    content = BytesIO()
    with import_module("matplotlib").rc_context({"svg.hashsalt": "glmref"}):
        figure.savefig(content, format="svg", metadata={"Date": None})
    text = content.getvalue().decode("utf-8")
    return text[text.index("<svg") :]


def save_figure(figure: Any, path: Path) -> None:
    """Write a figure as PNG, and as PDF beside it; both come out the same every time.

    Raises
    ------
    UsageError
        Where a file cannot be written.
    """
    plain_texts(figure)
    kinds: dict[str, dict[str, None]] = {"png": {"Software": None}, "pdf": {"CreationDate": None}}
    for kind, metadata in kinds.items():
        content = BytesIO()
        with warnings.catch_warnings():
            # a font need not have every sign, and a long text need not fit
            warnings.simplefilter("ignore", UserWarning)
            figure.savefig(content, format=kind, metadata=metadata)
        write_bytes(path.with_suffix(f".{kind}"), content.getvalue())
