"""Figures of matplotlib, where it is installed: PNG, and PDF beside it."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

__all__ = ["NO_FIGURES", "blank_figure", "save_figure"]

#: The notice where figures were asked for and cannot be drawn.
NO_FIGURES = "no PNG and PDF: matplotlib is not installed; pip install 'glmref[plots]'"


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


def save_figure(figure: Any, path: Path) -> None:
    """Write a figure as PNG, and as PDF beside it; both come out the same every time."""
    figure.savefig(path, format="png", metadata={"Software": None})
    figure.savefig(path.with_suffix(".pdf"), format="pdf", metadata={"CreationDate": None})
