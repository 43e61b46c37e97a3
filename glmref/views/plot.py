"""``plot(what)``: a method as its portrait, a solution against time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ..catalogue.lookup import method_of
from ..engine.outcome import Solution
from ..errors import UsageError
from ..method import GLM, AdditiveGLM, PartitionedGLM
from ..system.arguments import listed, whole
from ..system.shown import Drawing
from .axes import COLORS, Axes, document, round_ticks, text
from .chart import DASHES, place_labels
from .portrait import portrait

_MOST = 6  # components drawn where none are named
_POINTS = 2000  # of a line; more cannot be told apart


def plot(
    what: GLM | PartitionedGLM | AdditiveGLM | Solution | str | Path,
    *,
    components: Sequence[int] | None = None,
) -> Drawing:
    """Draw a method (stability region, eigenvalues, sparsity), or a solution against time.

    Parameters
    ----------
    what : GLM or PartitionedGLM or AdditiveGLM or Solution or str or Path
        A method, its name or its file, or a solution.
    components : Sequence[int] or None
        Of a solution: numbers from 0; the first six by default.

    Returns
    -------
    Drawing
        A picture in SVG: a notebook shows it, and ``save(path)`` writes it.

    Raises
    ------
    UsageError
        For anything else, and for a solution with fewer than two rows.
    """
    if not isinstance(what, Solution):
        return Drawing(portrait(method_of(what)))
    times, rows = np.asarray(what.t, dtype=float), np.asarray(what.y, dtype=float)
    if len(times) < 2:
        raise UsageError(
            "there is one point to draw; keep more of the run with solve(.., every=k) or times=.."
        )
    d = rows.shape[1]
    given = range(min(d, _MOST)) if components is None else listed("components", components)
    chosen = [whole("components", k, 0, d - 1) for k in given]
    if not chosen:
        raise UsageError("`components` must name one at least")
    kept = np.unique(np.linspace(0, len(times) - 1, _POINTS).astype(int))
    lines = {f"y[{k}]": rows[kept, k] for k in chosen}
    title = f"{what.problem}, {what.method}, h = {what.h:g}"
    return Drawing(_lines(times[kept], lines, title))


def _lines(times: np.ndarray, lines: Mapping[str, np.ndarray], title: str) -> str:
    """Lines over a linear time axis, each named at its end."""
    finite = np.concatenate([y[np.isfinite(y)] for y in lines.values()])
    low, high = (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    margin = 0.04 * (high - low) or 0.5 * max(abs(high), 1.0)
    axes = Axes(
        70, 44, 570, 272, (float(times.min()), float(times.max())), (low - margin, high + margin)
    )
    parts = axes.frame(round_ticks(*axes.x, most=8), round_ticks(*axes.y), ("t", ""))
    ends = [float(values[np.isfinite(values)][-1:].sum()) for values in lines.values()]
    wanted = [axes.at(axes.x[1], end)[1] for end in ends]
    labels = place_labels(wanted, axes.top + 6, axes.bottom)
    for k, ((name, values), label) in enumerate(zip(lines.items(), labels, strict=True)):
        color, dash = COLORS[k % len(COLORS)], DASHES[k % len(DASHES)]
        points = axes.line((a, b) for a, b in zip(times, values, strict=True) if np.isfinite(b))
        parts.append(
            f'<polyline points="{points}" fill="none" stroke="{color}" stroke-width="1.5" '
            f'stroke-dasharray="{dash}"/>'
        )
        parts.append(text(axes.right + 8, label + 4, name, fill=color))
    return document(title, 720, 360, parts)
