"""Log-log charts without a plotting library: SVG for files, characters for a terminal.

A series has its marker, dash *and* colour (Okabe and Ito's palette), and is named at the right
margin beside its last point, with a thin leader; names never overlap.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape

from .axes import COLORS, Axes, decades, document, log_ticks
from .axes import text as label

DASHES = ("", "7 3", "2 3", "9 3 2 3", "14 4")
#: Names of the marker shapes; text charts use the letters of the alphabet instead.
MARKERS = ("circle", "square", "up", "diamond", "down", "cross", "plus", "ring")
_LETTERS = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
_CHARACTER = 6.7  # width of a character of the label font at 12 px, in px
_SPACING = 15.0  # least distance of two labels, in px
_ROW = 18  # height of a row of names below a chart, in px
#: Width of a picture that a phone of 360 px shows with letters of 9 px and more.
NARROW = 400

Point = tuple[float, float]


@dataclass(frozen=True)
class Series:
    """A named line through points with positive coordinates; others are not drawn."""

    name: str  #: Shown beside the line.
    points: tuple[Point, ...]  #: (x, y) in the order in which they are joined.
    notes: tuple[str, ...] = ()  #: One text per point for the reader who points at it, or none.
    #: Runs that failed, (x, what is to be said): crosses at the upper end of the chart.
    failures: tuple[tuple[float, str], ...] = ()
    limit: float | None = (
        None  #: An x at which a dotted vertical line stands, such as a prediction.
    )

    @property
    def across(self) -> tuple[float, ...]:
        """Return all x that stand on a logarithmic axis."""
        xs = (*(x for x, *_ in self.drawn), *(x for x, _ in self.failures), self.limit or 0.0)
        return tuple(x for x in xs if 0 < x < math.inf)

    @property
    def drawn(self) -> tuple[tuple[float, float, str], ...]:
        """Points that a logarithmic chart can show, with their notes."""
        notes = self.notes if len(self.notes) == len(self.points) else ("",) * len(self.points)
        return tuple(
            (x, y, note)
            for (x, y), note in zip(self.points, notes, strict=True)
            if 0 < x < math.inf and 0 < y < math.inf
        )


def place_labels(wanted: Sequence[float], low: float, high: float) -> list[float]:
    """Move label positions (px) apart to at least the line spacing, keeping their order.

    They should stay within the limits; where there is no room for all, the last ones pass ``high``.
    """
    order = sorted(range(len(wanted)), key=lambda i: wanted[i])
    placed = [0.0] * len(wanted)
    # clusters of labels that touch share the mean of what they wanted
    clusters: list[list[int]] = []
    tops: list[float] = []
    for i in order:
        clusters.append([i])
        tops.append(min(max(wanted[i], low), high))
        while len(clusters) > 1 and tops[-1] < tops[-2] + _SPACING * len(clusters[-2]):
            merged = clusters[-2] + clusters[-1]
            clusters[-2:] = [merged]
            ideal = sum(wanted[j] - _SPACING * n for n, j in enumerate(merged)) / len(merged)
            most = high - _SPACING * (len(merged) - 1)
            tops[-2:] = [max(low, min(ideal, most))]
    for cluster, top in zip(clusters, tops, strict=True):
        for n, i in enumerate(cluster):
            placed[i] = top + n * _SPACING
    return placed


def svg(
    series: Sequence[Series],
    *,
    title: str,
    x_label: str,
    y_label: str,
    width: int = 820,
    height: int = 460,
    narrow: bool = False,
) -> str:
    """Return a complete SVG document, readable without any style sheet or script.

    Series without a point that can be drawn are named in a line below the chart. A ``narrow``
    picture is :data:`NARROW` px wide, which a phone shows with letters that can be read; the series
    are then named below the chart instead of at its right.
    """
    shown = [one for one in series if one.drawn or one.across]
    empty = [one.name for one in series if not one.drawn and not one.across]
    longest = max((len(one.name) for one in shown), default=0)
    margin = 14 if narrow else 30 + _CHARACTER * longest
    names = _below(shown) if narrow else []
    height = max(height, 0 if narrow else round(110 + _SPACING * len(shown)))
    width = NARROW if narrow else max(width, round(70 + margin + 420))
    listed = textwrap.wrap(
        f"not drawn, without a positive value: {', '.join(empty)}" if empty else "",
        int((width - 90) / _CHARACTER),
        break_on_hyphens=False,
    )
    height += 16 * max(len(listed) - 1, 0) + _ROW * len(names)
    parts = [] if shown else [label(70, 60, "nothing to draw")]
    if shown:
        bottom = height - 58 - 16 * max(len(listed) - 1, 0) - _ROW * len(names)
        axes = Axes(70, 40, width - margin - 70, bottom - 40, *_limits(shown))
        labels = (x_label, y_label)
        parts += axes.frame(log_ticks(*axes.x), log_ticks(*axes.y), labels, aside=54)
        lines, ends = _lines(axes, shown)
        parts += lines
        if not narrow:
            parts += _aside(axes, shown, ends)
        for k, row in enumerate(names):
            for x, number, name in row:
                y = bottom + 54 + _ROW * k
                mark = _marker(MARKERS[number % len(MARKERS)], x, y - 4, _color(number))
                parts += [mark, label(x + 9, y, name)]
    told = ["crosses at the top: runs that failed"] * any(one.failures for one in shown)
    told += ["dotted: the step size to which stability is predicted"] * any(
        one.limit for one in shown
    )
    if told:
        listed.append("; ".join(told))
        height += 16
    for k, line in enumerate(reversed(listed)):
        parts.append(label(70, height - 8 - 16 * k, line, fill="#555"))
    return document(title, width, height, parts, 12 if narrow else 70)


def _below(shown: Sequence[Series]) -> list[list[tuple[float, int, str]]]:
    """Return rows of names below a narrow chart: where each begins, its number, and the name."""
    rows: list[list[tuple[float, int, str]]] = []
    end = math.inf
    for number, one in enumerate(shown):
        wide = 26 + _CHARACTER * len(one.name)
        if end + wide > NARROW - 8:
            rows.append([])
            end = 16.0
        rows[-1].append((end, number, one.name))
        end += wide
    return rows


def _color(number: int) -> str:
    return COLORS[number % len(COLORS)]


def _limits(shown: Sequence[Series]) -> tuple[Point, Point]:
    """Return decades that hold all points."""
    xs = [x for one in shown for x in one.across]
    ys = [y for one in shown for _, y, _ in one.drawn] or [1.0]
    return decades(xs), decades(ys)


def _lines(axes: Axes, shown: Sequence[Series]) -> tuple[list[str], list[tuple[float, float, str]]]:
    """Return lines and markers of the series, and where each line ends, in its colour."""
    parts: list[str] = []
    ends = []
    for number, one in enumerate(shown):
        color = _color(number)
        dash = DASHES[(number // len(COLORS)) % len(DASHES)]
        points = [(*axes.at(math.log10(x), math.log10(y)), x, y, n) for x, y, n in one.drawn]
        parts += _failed(axes, one, color, number)
        if not points:
            ends.append((axes.right, axes.top + 6, color))
            continue
        path = axes.line((math.log10(x), math.log10(y)) for x, y, _ in one.drawn)
        dashed = f' stroke-dasharray="{dash}"' if dash else ""
        parts.append(
            f'<polyline points="{path}" fill="none" stroke="{color}" stroke-width="1.6"{dashed}/>'
        )
        # markers at every point where there are few, at about sixteen where there are many
        each = max(1, len(points) // 16)
        for k, (u, v, x, y, note) in enumerate(points):
            if k % each and k != len(points) - 1:
                continue
            said = f"{one.name}: {x:.4g}, {y:.4g}" + (f"; {note}" if note else "")
            parts.append(
                f"<g>{_marker(MARKERS[number % len(MARKERS)], u, v, color)}"
                f"<title>{escape(said)}</title></g>"
            )
        end = max(points, key=lambda point: point[0])
        ends.append((end[0], end[1], color))
    return parts, ends


def _aside(
    axes: Axes, shown: Sequence[Series], ends: Sequence[tuple[float, float, str]]
) -> list[str]:
    """Return the names of the series at the right, each with a thin leader from its line."""
    parts = []
    rows = place_labels([v for _, v, _ in ends], axes.top + 6, axes.bottom - 2)
    for one, (u, v, color), row in zip(shown, ends, rows, strict=True):
        x = axes.right + 20
        parts.append(
            f'<polyline points="{u + 5:.1f},{v:.1f} {axes.right + 5:.1f},{row:.1f} '
            f'{x - 3:.1f},{row:.1f}" fill="none" stroke="{color}" stroke-width="0.6" '
            f'stroke-opacity="0.7"/>'
            f"{label(x, row + 4, one.name)}"
        )
    return parts


def _failed(axes: Axes, one: Series, color: str, number: int) -> list[str]:
    """Return crosses of runs that failed, in a row for each series, and the line of the limit."""
    parts, v = [], axes.top + 8 + 7 * (number % 8)
    if one.limit is not None and 0 < one.limit < math.inf:
        u = axes.at(math.log10(one.limit), 0)[0]
        said = escape(f"{one.name}: stability is predicted up to {one.limit:.4g}")
        parts.append(
            f'<path d="M{u:.1f} {axes.top:.1f}V{axes.bottom:.1f}" stroke="{color}" fill="none" '
            f'stroke-width="1.6" stroke-dasharray="1.5 4"><title>{said}</title></path>'
        )
    for x, why in one.failures:
        if 0 < x < math.inf:
            u = axes.at(math.log10(x), 0)[0]
            said = escape(f"{one.name}: {why}")
            parts.append(f"<g>{_marker('cross', u, v, color)}<title>{said}</title></g>")
    return parts


def _marker(shape: str, x: float, y: float, color: str) -> str:
    """Return one marker of about 8 px."""
    filled, hollow = f'fill="{color}"', f'fill="#fff" stroke="{color}" stroke-width="1.6"'
    stroke = f'fill="none" stroke="{color}" stroke-width="1.8"'

    def at(*offsets: tuple[float, float]) -> str:
        return " ".join(f"{x + dx:.1f},{y + dy:.1f}" for dx, dy in offsets)

    shapes = {
        "circle": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.6" {filled}/>',
        "ring": f'<circle cx="{x:.1f}" cy="{y:.1f}" r="3.4" {hollow}/>',
        "square": f'<rect x="{x - 3.3:.1f}" y="{y - 3.3:.1f}" width="6.6" height="6.6" {filled}/>',
        "up": f'<polygon points="{at((-4, 3), (4, 3), (0, -4.5))}" {filled}/>',
        "down": f'<polygon points="{at((-4, -3), (4, -3), (0, 4.5))}" {hollow}/>',
        "diamond": f'<polygon points="{at((-4.4, 0), (0, -4.4), (4.4, 0), (0, 4.4))}" {filled}/>',
        "cross": f'<path d="M{at((-3.4, -3.4))} L{at((3.4, 3.4))} M{at((-3.4, 3.4))} '
        f'L{at((3.4, -3.4))}" {stroke}/>',
        "plus": f'<path d="M{at((-4.4, 0))} L{at((4.4, 0))} M{at((0, -4.4))} '
        f'L{at((0, 4.4))}" {stroke}/>',
    }
    return shapes[shape]


def text(
    series: Sequence[Series], *, x_label: str, y_label: str, width: int = 72, height: int = 18
) -> str:
    """Return the chart as lines of characters: one letter for each series, ``*`` where two meet."""
    shown = [one for one in series if one.drawn]
    if not shown:
        return "nothing to draw"
    axes = Axes(0, 0, width - 1, height - 1, *_limits(shown))
    grid = [[" "] * width for _ in range(height)]
    for number, one in enumerate(shown):
        letter = _LETTERS[number % len(_LETTERS)]
        for x, y, _ in one.drawn:
            u, v = axes.at(math.log10(x), math.log10(y))
            column, row = round(u), round(v)
            taken = grid[row][column] not in (" ", letter)
            grid[row][column] = "*" if taken else letter
    ticks = log_ticks(*axes.y, most=6)
    rows = {round(axes.at(0, log)[1]): shown for log, shown in zip(*ticks, strict=True)}
    margin = max(map(len, ticks.texts))
    lines = [y_label]
    lines += [f"{rows.get(k, ''):>{margin}} |{''.join(row)}" for k, row in enumerate(grid)]
    lines.append(f"{'':{margin}} +{'-' * width}")
    lines.append(f"{'':{margin}}  {_tick_line(axes, width)}")
    lines.append(f"{'':{margin}}  {x_label}")
    names = [f"{_LETTERS[n % len(_LETTERS)]} {one.name}" for n, one in enumerate(shown)]
    return "\n".join(line.rstrip() for line in [*lines, *_wrapped(names, margin + 2 + width)])


def _tick_line(axes: Axes, width: int) -> str:
    """Return the values along the x axis; one that would touch its neighbour is left out."""
    line = ""
    for log, shown in zip(*log_ticks(*axes.x), strict=True):
        column = max(0, min(width - len(shown), round(axes.at(log, 0)[0]) - len(shown) // 2))
        if column > len(line) or not line:
            line = line.ljust(column) + shown
    return line


def _wrapped(names: Sequence[str], width: int) -> list[str]:
    lines = [""]
    for name in names:
        if lines[-1] and len(lines[-1]) + 3 + len(name) > width:
            lines.append("")
        lines[-1] += f"   {name}" if lines[-1] else name
    return lines
