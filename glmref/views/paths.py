"""Paths in a plane without a plotting library: one panel a method, equal axes, the same range.

Points are not joined: they are far apart in time. The range is that of the paths which were
followed to their end and are not much larger than the others; what leaves it is counted under its
panel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import median
from textwrap import shorten

from .axes import COLORS, Axes, document, round_ticks, text

Point = tuple[float, float]
Box = tuple[float, float, float, float]
_ACROSS = 3  # panels in a row
_PANEL, _GAP = 250.0, 60.0  # px
_LEFT, _TOP = 62.0, 66.0
_LARGE = 3.0  # times the median size: a path that flies away
_WORDS = 60  # characters under a panel


@dataclass(frozen=True)
class Cloud:
    """Points of one run."""

    name: str  #: Of the method.
    points: tuple[Point, ...]  #: (x, y), finite.
    ended: str | None = None  #: Why they stop before the run does, or nothing.
    h: float | None = None  #: Step size, where it is to be told.

    @property
    def title(self) -> str:
        """Name with the step size."""
        return self.name if self.h is None else f"{self.name}, h = {self.h:.4g}"


def one_each(clouds: Sequence[Cloud]) -> list[Cloud]:
    """Return a path a name: of the largest step followed to its end, else of the smallest.

    At smaller steps a path looks the same; at larger ones there is none.
    """
    groups: dict[str, list[Cloud]] = {}
    for cloud in clouds:
        groups.setdefault(cloud.name, []).append(cloud)
    found = []
    for group in groups.values():
        ordered = sorted(group, key=lambda one: -(one.h or 0.0))
        found.append(next((one for one in ordered if not one.ended), ordered[-1]))
    return found


def ranging(clouds: Sequence[Cloud]) -> list[Cloud]:
    """Return paths that set the range: those that were followed to their end.

    One that is more than three times as large as their median has flown away and does not count.
    """
    whole = [one for one in clouds if one.points and not one.ended]
    if not whole:
        return list(clouds)
    sizes = [max(max(v) - min(v) for v in zip(*one.points, strict=True)) for one in whole]
    most = _LARGE * median(sizes)
    return [one for one, size in zip(whole, sizes, strict=True) if size <= most]


def box_of(clouds: Sequence[Cloud]) -> Box:
    """Return the low and high x, low and high y of the paths that set the range, with a margin."""
    whole = [p for one in ranging(clouds) for p in one.points]
    points = whole or [p for one in clouds for p in one.points] or [(0.0, 0.0)]
    xs, ys = [x for x, _ in points], [y for _, y in points]
    middle = ((min(xs) + max(xs)) / 2, (min(ys) + max(ys)) / 2)
    size = max(max(xs) - min(xs), max(ys) - min(ys)) or max(map(abs, middle)) or 1.0
    wide, high = (max(max(v) - min(v), size / 3) * 0.54 for v in (xs, ys))
    return middle[0] - wide, middle[0] + wide, middle[1] - high, middle[1] + high


def _notes(cloud: Cloud, box: Box) -> list[str]:
    """Return what a panel does not show."""
    notes = [cloud.ended] if cloud.ended else []
    outside = sum(not _inside(point, box) for point in cloud.points)
    if outside:
        notes.append(f"{outside} of {len(cloud.points)} points outside")
    return notes


def _inside(point: Point, box: Box) -> bool:
    return box[0] <= point[0] <= box[1] and box[2] <= point[1] <= box[3]


def svg(clouds: Sequence[Cloud], *, title: str, x_label: str, y_label: str) -> str:
    """Return a complete SVG document, readable without any style sheet or script."""
    box = box_of(clouds)
    scale = _PANEL / max(box[1] - box[0], box[3] - box[2])
    wide, high = (box[1] - box[0]) * scale, (box[3] - box[2]) * scale
    across = min(_ACROSS, max(len(clouds), 1))
    rows = math.ceil(len(clouds) / across)
    noted = any(_notes(one, box) for one in clouds)
    pitch = (_PANEL + _GAP, high + _GAP + (22 if noted else 6))
    parts: list[str] = []
    for k, cloud in enumerate(clouds):
        left = _LEFT + (k % across) * pitch[0] + (_PANEL - wide) / 2
        top = _TOP + (k // across) * pitch[1]
        axes = Axes(left, top, wide, high, box[:2], box[2:])
        ticks = round_ticks(*axes.x), round_ticks(*axes.y)
        parts += [
            text(left, top - 8, cloud.title),
            *axes.frame(*ticks, (x_label, y_label), size=10),
            axes.dots(cloud.points, COLORS[k % len(COLORS)], 2.4),
        ]
        notes = shorten("; ".join(_notes(cloud, box)), _WORDS, placeholder=" …")
        parts.append(text(left, axes.bottom + 45, notes, size=10, fill="#555") if notes else "")
    width = _LEFT + across * pitch[0] - _GAP + 20
    return document(title, width, _TOP + rows * pitch[1] + 8, parts, left=_LEFT)
