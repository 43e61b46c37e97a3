"""A map in colours over two axes, as SVG: one rectangle for each pair of values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from xml.sax.saxutils import escape

from .axes import Axes, Ticks, document, text

#: Colours from small to large, told apart by lightness alone (after the scale "cividis").
_SCALE = ("#00224e", "#35456c", "#666970", "#948e77", "#c8b866", "#fee838")
_MISSING = "#f4f4f4"
#: What was not completed, and so has no number.
_INFINITE = "#b3261e"
_INCOMPLETE = "incomplete"
_MOST_TEXTS = 8


def heat_map(
    cells: Mapping[tuple[float | str, float | str], float],
    *,
    title: str,
    x_label: str,
    y_label: str,
    value_label: str,
    limits: tuple[float, float] | None = None,
) -> str:
    """Return a complete SVG document of the values of cells (x, y).

    Every x that occurs has a column and every y a row, in their order; a pair without a value stays
    blank, and infinity stands for what was not completed. ``limits`` are the values of the first
    and the last colour, so that several maps agree; those that occur by default. Where both are
    positive and a factor of a thousand apart, colours go with the logarithm.
    """
    width, height = 560, 360
    xs, ys = (sorted({pair[k] for pair in cells}, key=_place) for k in (0, 1))
    axes = Axes(74, 40, width - 184, height - 96, (0, len(xs)), (0, len(ys)))
    if not cells:
        return document(title, width, height, [text(axes.left, axes.top + 20, "nothing to draw")])
    finite = [x for x in cells.values() if math.isfinite(x)] or [0.0]
    scale = Scale(limits or (min(finite), max(finite)))
    frame = f'x="{axes.left}" y="{axes.top}" width="{axes.width}" height="{axes.height}"'
    parts = [f'<rect {frame} fill="{_MISSING}"/>']
    size = f'width="{axes.width / len(xs) + 0.3:.1f}" height="{axes.height / len(ys) + 0.3:.1f}"'
    columns, rows = ({x: k for k, x in enumerate(values)} for values in (xs, ys))
    for (x, y), value in cells.items():
        u, v = axes.at(columns[x], rows[y] + 1)
        words = f"{value:.4g}" if math.isfinite(value) else _INCOMPLETE
        said = f"<title>{escape(f'{_shown(x)}, {_shown(y)}: {words}')}</title>"
        place = f'x="{u:.1f}" y="{v:.1f}" {size}'
        parts.append(f'<rect {place} fill="{scale.color(value)}">{said}</rect>')
    parts += axes.frame(_ticks(xs), _ticks(ys), (x_label, y_label), grid=False, aside=54)
    parts += _legend(scale, axes.right + 16, axes.top, value_label, lost=len(finite) < len(cells))
    return document(title, width, height, parts)


class Scale:
    """Colours of values between two limits, linear or logarithmic."""

    def __init__(self, limits: tuple[float, float]) -> None:
        low, high = limits
        self.limits = limits
        self.log = low > 0 and high > 1e3 * low
        self.ends = (math.log10(low), math.log10(high)) if self.log else (low, high)

    def color(self, value: float) -> str:
        """Return the colour of a value; beyond the limits it is that of the limit."""
        if not math.isfinite(value):
            return _INFINITE
        low, high = self.ends
        at = math.log10(value) if self.log and value > 0 else (low if self.log else value)
        share = (at - low) / (high - low) if high > low else 0.0
        return _SCALE[min(len(_SCALE) - 1, max(0, int(share * len(_SCALE))))]

    def bounds(self) -> list[float]:
        """Return values at which colours change, and both limits."""
        low, high = self.ends
        marks = [low + (high - low) * k / len(_SCALE) for k in range(len(_SCALE) + 1)]
        return [10**x for x in marks] if self.log else marks


def _legend(scale: Scale, left: float, top: float, label: str, *, lost: bool) -> list[str]:
    parts = [text(left, top - 14, label)]  # the uppermost number stands below it
    for k, mark in enumerate(scale.bounds()):
        v = top + (len(_SCALE) - k) * 22
        parts.append(text(left + 22, v + 4, f"{mark:.3g}"))
        if k < len(_SCALE):
            parts.append(
                f'<rect x="{left:.0f}" y="{v - 22:.0f}" width="16" height="22" fill="{_SCALE[k]}"/>'
            )
    if lost:
        v = top + (len(_SCALE) + 1) * 22
        parts.append(
            f'<rect x="{left:.0f}" y="{v:.0f}" width="16" height="16" fill="{_INFINITE}"/>'
        )
        parts.append(text(left + 22, v + 12, _INCOMPLETE))
    return parts


def _place(value: float | str) -> tuple[bool, float | str]:
    return isinstance(value, str), value


def _shown(value: float | str) -> str:
    return value if isinstance(value, str) else f"{value:.4g}"


def _ticks(values: Sequence[float | str]) -> Ticks:
    """Return the middles of about eight of the rows or columns, with their values."""
    shown = range(0, len(values), max(1, math.ceil(len(values) / _MOST_TEXTS)))
    return Ticks(tuple(k + 0.5 for k in shown), tuple(_shown(values[k]) for k in shown))
