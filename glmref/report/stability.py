"""The stability region of a method, or the moduli of a pair, drawn from the stored polygons."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any
from xml.sax.saxutils import quoteattr

from markupsafe import Markup

from ..views.axes import Axes, round_ticks
from .markup import number, render
from .store import Record, is_number

_POINT = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?,-?\d+(?:\.\d+)?(?:e-?\d+)?")
_SIDE, _LEFT, _TOP, _BELOW = 320, 46, 10, 42  # px
_FAR = 64.0  # an axis on which no end was seen up to there
Point = tuple[float, float]


def _svg(axes: Axes, label: str, inner: str, labels: tuple[str, str]) -> str:
    """Return some shapes with their axes."""
    wide, high = _LEFT + _SIDE + 12, _TOP + _SIDE + _BELOW
    frame = axes.frame(round_ticks(*axes.x), round_ticks(*axes.y), labels, grid=False, aside=34)
    return (
        f'<svg class="chart region" width="{wide}" height="{high}" viewBox="0 0 {wide} {high}" '
        f'role="img" aria-label={quoteattr(label)}>{inner}{"".join(frame)}</svg>'
    )


def stability(name: str, record: Record | None) -> Markup:
    """Return the part of a page, ``""`` where nothing is stored that can be drawn."""
    reach = (record or {}).get("reach")
    if record is None or not is_number(reach) or not 0 < reach < 1e6:
        return Markup()
    if "moduli" in record:
        return _pair(name, record, float(reach))
    return _region(name, record, float(reach))


def _region(name: str, record: Record, reach: float) -> Markup:
    axes = Axes(_LEFT, _TOP, _SIDE, _SIDE, (-reach, reach), (-reach, reach))
    rings = [found for text in _texts(record.get("rings")) if (found := _points(text))]
    inner = axes.cross(0, 0)
    if rings:
        path = "".join(f"M{axes.line(ring)}z" for ring in rings)
        inner = f'<path class="area" fill-rule="evenodd" d="{path}"/>{inner}'
    end = record.get("imaginary")
    if is_number(end) and end > 0:
        kept = min(float(end), reach)
        inner += f'<path class="kept" d="M{axes.line([(0, -kept), (0, kept)])}"/>'
    said = "no area that is stable was seen" if not rings else "stable where it is shaded"
    rows = [
        ("imaginary axis, to", _end(end)),
        ("negative real axis, to", _end(record.get("real"))),
    ]
    svg = _svg(axes, f"stability region of {name}", inner, ("Re z, z = h lambda", "Im z"))
    return _part(svg, f"For y' = lambda y: {said}, and on the thick part of the axis.", rows)


def _pair(name: str, record: Record, reach: float) -> Markup:
    axes = Axes(_LEFT, _TOP, _SIDE, _SIDE, (0, reach), (0, 2))
    inner = axes.cross(None, 1)
    for text in _texts(record.get("moduli")):
        if points := _points(text):
            inner += f'<path class="line c0" d="M{axes.line(points)}"/>'
    svg = _svg(axes, f"moduli of eigenvalues of {name}", inner, ("h omega", "moduli"))
    said = "For q' = omega p, p' = -omega q: moduli of the eigenvalues of a step."
    return _part(svg, said, [("no modulus above 1, to h omega", _end(record.get("oscillation")))])


def _part(svg: str, said: str, rows: Sequence[tuple[str, str]]) -> Markup:
    return render("stability.html", svg=Markup(svg), said=said, rows=rows)


def _end(value: Any) -> str:
    if not is_number(value):
        return number(None)
    return f"no end up to {number(value)}" if value >= _FAR else number(value)


def _texts(value: Any) -> list[str]:
    return [x for x in value if isinstance(x, str)] if isinstance(value, list) else []


def _points(text: str) -> list[Point]:
    """Return points of "x,y x,y .."; none where it is anything else."""
    pairs = text.split()
    if len(pairs) < 2 or not all(_POINT.fullmatch(pair) for pair in pairs):
        return []
    return [(float(x), float(y)) for x, y in (pair.split(",") for pair in pairs)]
