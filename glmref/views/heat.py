"""A map in colours over two axes, as SVG: one rectangle for each pair of values."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from xml.sax.saxutils import escape

from .axes import document, text

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
    left, top, right, bottom = 74.0, 40.0, width - 110.0, height - 56.0
    if not cells:
        return document(title, width, height, [text(left, top + 20, "nothing to draw")])
    finite = [x for x in cells.values() if math.isfinite(x)] or [0.0]
    scale = Scale(limits or (min(finite), max(finite)))
    wide, high = (right - left) / len(xs), (bottom - top) / len(ys)
    frame = f'x="{left}" y="{top}" width="{right - left}" height="{bottom - top}"'
    parts = [f'<rect {frame} fill="{_MISSING}" stroke="#555"/>']
    columns, rows = ({x: k for k, x in enumerate(values)} for values in (xs, ys))
    for (x, y), value in cells.items():
        u, v = left + columns[x] * wide, bottom - (rows[y] + 1) * high
        place = f'x="{u:.1f}" y="{v:.1f}" width="{wide + 0.3:.1f}" height="{high + 0.3:.1f}"'
        words = f"{value:.4g}" if math.isfinite(value) else _INCOMPLETE
        said = f"<title>{escape(f'{_shown(x)}, {_shown(y)}: {words}')}</title>"
        parts.append(f'<rect {place} fill="{scale.color(value)}">{said}</rect>')
    for k in _thinned(len(xs)):
        parts.append(text(left + (k + 0.5) * wide, bottom + 16, _shown(xs[k]), "middle"))
    for k in _thinned(len(ys)):
        parts.append(text(left - 6, bottom - (k + 0.5) * high + 4, _shown(ys[k]), "end"))
    parts.append(text((left + right) / 2, bottom + 38, x_label, "middle"))
    parts.append(
        f'<text transform="translate(20 {(top + bottom) / 2:.0f}) rotate(-90)" '
        f'text-anchor="middle" fill="#111">{escape(y_label)}</text>'
    )
    parts += _legend(scale, right + 16, top, value_label, lost=len(finite) < len(cells))
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


def _thinned(count: int) -> Sequence[int]:
    """Return indices of about eight of so many values."""
    return range(0, count, max(1, math.ceil(count / _MOST_TEXTS)))
