"""The stability region of a method, or the moduli of a pair, drawn from the stored polygons."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from .markup import escape, number
from .store import Record, is_number

__all__ = ["stability"]

_POINT = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?,-?\d+(?:\.\d+)?(?:e-?\d+)?")
_SIDE, _LEFT, _TOP, _BELOW = 320, 46, 10, 42  # px
_FAR = 64.0  # an axis on which no end was seen up to there
Point = tuple[float, float]


@dataclass(frozen=True)
class _Panel:
    """A square with a range on each axis."""

    x: Point
    y: Point

    def at(self, x: float, y: float) -> Point:
        u = (x - self.x[0]) / (self.x[1] - self.x[0])
        v = (y - self.y[0]) / (self.y[1] - self.y[0])
        return _LEFT + u * _SIDE, _TOP + (1 - v) * _SIDE

    def path(self, points: Sequence[Point]) -> str:
        return "M" + "L".join("{:.1f} {:.1f}".format(*self.at(x, y)) for x, y in points)

    def svg(self, label: str, inner: str, words: tuple[str, str]) -> str:
        """Frame, ticks and words around some shapes."""
        across, up = "", ""
        for x in _ticks(*self.x):
            u, v = self.at(x, self.y[0])
            across += f'<text x="{u:.1f}" y="{v + 16:.1f}" text-anchor="middle">{x:.6g}</text>'
        for y in _ticks(*self.y):
            u, v = self.at(self.x[0], y)
            up += f'<text x="{u - 6:.1f}" y="{v + 4:.1f}" text-anchor="end">{y:.6g}</text>'
        wide, high = _LEFT + _SIDE + 12, _TOP + _SIDE + _BELOW
        frame = f'x="{_LEFT}" y="{_TOP}" width="{_SIDE}" height="{_SIDE}"'
        turned = f'transform="translate(12 {_TOP + _SIDE / 2:.0f}) rotate(-90)"'
        return (
            f'<svg class="chart region" width="{wide}" height="{high}" viewBox="0 0 {wide} {high}" '
            f'role="img" aria-label="{escape(label)}">{inner}<rect class="frame" {frame}/>'
            f'{across}{up}<text x="{_LEFT + _SIDE / 2:.0f}" y="{high - 6}" text-anchor="middle">'
            f"{escape(words[0])}</text>"
            f'<text {turned} text-anchor="middle">{escape(words[1])}</text></svg>'
        )


def _ticks(low: float, high: float) -> list[float]:
    """Round numbers of a range, five or fewer."""
    rough = (high - low) / 5
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough)
    return [k * step for k in range(math.ceil(low / step), math.floor(high / step) + 1)]


def stability(name: str, record: Record | None) -> str:
    """Return the part of a page, ``""`` where nothing is stored that can be drawn."""
    reach = (record or {}).get("reach")
    if record is None or not is_number(reach) or not 0 < reach < 1e6:
        return ""
    if "moduli" in record:
        return _pair(name, record, float(reach))
    return _region(name, record, float(reach))


def _region(name: str, record: Record, reach: float) -> str:
    panel = _Panel((-reach, reach), (-reach, reach))
    rings = [found for text in _texts(record.get("rings")) if (found := _points(text))]
    zero = panel.at(0, 0)
    inner = f'<path class="grid" d="M{_LEFT} {zero[1]:.1f}h{_SIDE}M{zero[0]:.1f} {_TOP}v{_SIDE}"/>'
    if rings:
        path = "".join(panel.path(ring) + "z" for ring in rings)
        inner = f'<path class="area" fill-rule="evenodd" d="{path}"/>{inner}'
    end = record.get("imaginary")
    if is_number(end) and end > 0:
        kept = min(float(end), reach)
        inner += f'<path class="kept" d="{panel.path([(0, -kept), (0, kept)])}"/>'
    said = "no area that is stable was seen" if not rings else "stable where it is shaded"
    rows = [
        ("imaginary axis, to", _end(end)),
        ("negative real axis, to", _end(record.get("real"))),
    ]
    svg = panel.svg(f"stability region of {name}", inner, ("Re z, z = h lambda", "Im z"))
    return _part(svg, f"For y' = lambda y: {said}, and on the thick part of the axis.", rows)


def _pair(name: str, record: Record, reach: float) -> str:
    panel = _Panel((0, reach), (0, 2))
    one = panel.at(0, 1)
    inner = f'<path class="grid" d="M{_LEFT} {one[1]:.1f}h{_SIDE}"/>'
    for text in _texts(record.get("moduli")):
        if points := _points(text):
            inner += f'<path class="line c0" d="{panel.path(points)}"/>'
    svg = panel.svg(f"moduli of eigenvalues of {name}", inner, ("h omega", "moduli"))
    said = "For q' = omega p, p' = -omega q: moduli of the eigenvalues of a step."
    return _part(svg, said, [("no modulus above 1, to h omega", _end(record.get("oscillation")))])


def _part(svg: str, said: str, rows: Sequence[tuple[str, str]]) -> str:
    listed = "".join(f"<dt>{escape(key)}<dd>{value}" for key, value in rows)
    return (
        f'<h2>Stability</h2><figure class="regions">{svg}<figcaption>{escape(said)} Measured, see '
        f"{_STORED}.<dl>{listed}</dl></figcaption></figure>"
    )


_STORED = "<code>data/measurements/stability.json</code>"


def _end(value: Any) -> str:
    if not is_number(value):
        return number(None)
    return f"no end up to {number(value)}" if value >= _FAR else number(value)


def _texts(value: Any) -> list[str]:
    return [x for x in value if isinstance(x, str)] if isinstance(value, list) else []


def _points(text: str) -> list[Point]:
    """Points of "x,y x,y .."; none where it is anything else."""
    pairs = text.split()
    if len(pairs) < 2 or not all(_POINT.fullmatch(pair) for pair in pairs):
        return []
    return [(float(x), float(y)) for x, y in (pair.split(",") for pair in pairs)]
