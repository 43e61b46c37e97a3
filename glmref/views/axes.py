"""Axes of pictures in SVG: where a point stands, ticks of linear and logarithmic ranges, frames.

All pictures of the package are drawn with these: log-log charts (:mod:`.chart`), paths in a plane
(:mod:`.paths`), portraits (:mod:`.portrait`), and stability regions on the pages of the report.
Elements carry their colours; their classes let the style sheet of a page choose others.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import NamedTuple
from xml.sax.saxutils import escape, quoteattr

#: Okabe and Ito's palette: told apart by every eye.
COLORS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#3b3b3b")
_BOLD = 8.4  # width of a character of a title, bold and 14 px, in px
_CHARACTERS_NOT_IN_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")

Point = tuple[float, float]


class Ticks(NamedTuple):
    """Positions on an axis, and the text beside each."""

    at: tuple[float, ...]
    texts: tuple[str, ...]


def round_ticks(low: float, high: float, most: int = 5) -> Ticks:
    """Return the multiples of 1, 2 or 5 times a power of ten in a range, about ``most`` of them."""
    rough = (high - low) / most
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough * (1 - 1e-12))
    first, last = math.ceil(low / step - 1e-9), math.floor(high / step + 1e-9)
    at = tuple(k * step for k in range(first, last + 1))
    return Ticks(at, tuple(f"{x:.6g}" for x in at))


def decades(values: Sequence[float]) -> Point:
    """Return log10 limits that hold all values with a margin, at least half a decade apart."""
    logs = [math.log10(v) for v in values]
    low, high = min(logs), max(logs)
    margin = max(0.06 * (high - low), 0.08)
    low, high = low - margin, high + margin
    if high - low < 0.5:
        middle = (low + high) / 2
        low, high = middle - 0.25, middle + 0.25
    return low, high


def log_ticks(low: float, high: float, most: int = 8) -> Ticks:
    """Return ticks at powers of ten, thinned; in a short range at 1, 2, 5 or 1 to 9 times these."""
    whole = range(math.ceil(low - 1e-9), math.floor(high + 1e-9) + 1)
    at = [float(k) for k in whole if k % max(1, math.ceil(len(whole) / most)) == 0]
    if len(whole) < 3:
        at = _multiples(low, high, (1, 2, 5))
        at = at if len(at) >= 2 else _multiples(low, high, range(1, 10))
    return Ticks(tuple(at), tuple(tick_texts(at)))


def _multiples(low: float, high: float, factors: Iterable[int]) -> list[float]:
    """Return the logs between two limits of these factors times powers of ten."""
    powers = range(math.floor(low) - 1, math.ceil(high) + 1)
    logs = (k + math.log10(m) for k, m in product(powers, factors))
    return [x for x in logs if low <= x <= high]


def tick_texts(logs: Sequence[float]) -> list[str]:
    """Return the values of ticks as short texts, all of one kind: 0.01, 1, 100 or 1e-9, 1, 1e3."""
    plain = all(-2.01 < log < 3.5 for log in logs)
    texts = []
    for log in logs:
        if plain:
            texts.append(f"{10**log:.4g}")
            continue
        power = math.floor(log + 1e-9)
        mantissa = f"{10 ** (log - power):.2g}"
        texts.append(f"{mantissa}e{power}" if power else mantissa)
    return texts


@dataclass(frozen=True)
class Axes:
    """A rectangle of a picture, in px, and the ranges that it shows."""

    #: The rectangle.
    left: float
    top: float
    width: float
    height: float
    #: Limits; of logarithmic axes their log10.
    x: Point
    y: Point

    @property
    def right(self) -> float:
        """Right end, in px."""
        return self.left + self.width

    @property
    def bottom(self) -> float:
        """Lower end, in px."""
        return self.top + self.height

    def at(self, x: float, y: float) -> Point:
        """Return the place of a point, in px."""
        u = (x - self.x[0]) / (self.x[1] - self.x[0])
        v = (y - self.y[0]) / (self.y[1] - self.y[0])
        return self.left + u * self.width, self.bottom - v * self.height

    def holds(self, x: float, y: float) -> bool:
        """Return whether a point lies inside."""
        return self.x[0] <= x <= self.x[1] and self.y[0] <= y <= self.y[1]

    def line(self, points: Iterable[Point]) -> str:
        """Return places of points as a polyline has them; after an M they are a path."""
        return " ".join("{:.1f},{:.1f}".format(*self.at(x, y)) for x, y in points)

    def dots(self, points: Iterable[Point], color: str, size: float) -> str:
        """Round dots at the points that lie inside; nothing where there are none."""
        places = "".join(
            "M{:.1f} {:.1f}h0".format(*self.at(x, y)) for x, y in points if self.holds(x, y)
        )
        return (
            f'<path d="{places}" stroke="{color}" stroke-width="{size}" stroke-linecap="round"/>'
            if places
            else ""
        )

    def cross(self, x: float | None, y: float | None) -> str:
        """Return lines through the whole rectangle at a value of x and at one of y."""
        across = "" if y is None else f"M{self.left} {self.at(0, y)[1]:.1f}h{self.width}"
        up = "" if x is None else f"M{self.at(x, 0)[0]:.1f} {self.top}v{self.height}"
        return f'<path class="grid" d="{across}{up}" stroke="#d9d9d9"/>'

    def frame(
        self,
        across: Ticks,
        up: Ticks,
        labels: tuple[str, str] = ("", ""),
        *,
        grid: bool = True,
        size: int = 12,
        aside: float = 42,
    ) -> list[str]:
        """Return the border, ticks with their texts (``size`` px high), and the labels of the axes.

        With ``grid`` a tick is a line through the rectangle, otherwise a mark outside; ``aside`` is
        the distance of the label of the vertical axis from it, in px.
        """
        parts = []
        for x, shown in zip(*across, strict=True):
            u = self.at(x, self.y[0])[0]
            start = self.top if grid else self.bottom
            parts.append(_tick((u, start), f"v{self.height:.1f}" if grid else "v4", grid))
            parts.append(text(u, self.bottom + size + 4, shown, "middle", size=size, fill="#333"))
        for y, shown in zip(*up, strict=True):
            v = self.at(self.x[0], y)[1]
            parts.append(_tick((self.left, v), f"h{self.width:.1f}" if grid else "h-4", grid))
            parts.append(text(self.left - 7, v + 4, shown, "end", size=size, fill="#333"))
        parts.append(
            f'<rect class="frame" x="{self.left:.1f}" y="{self.top:.1f}" width="{self.width:.1f}" '
            f'height="{self.height:.1f}" fill="none" stroke="#555"/>'
        )
        if labels[0]:
            center = (self.left + self.right) / 2
            parts.append(text(center, self.bottom + 2 * size + 10, labels[0], "middle"))
        if labels[1]:
            turned = f"translate({self.left - aside:.1f} {(self.top + self.bottom) / 2:.1f})"
            parts.append(
                f'<text transform="{turned} rotate(-90)" text-anchor="middle" fill="#111">'
                f"{escape(labels[1])}</text>"
            )
        return parts


def _tick(at: Point, stroke: str, grid: bool) -> str:
    look = 'class="grid" stroke="#e3e3e3"' if grid else 'stroke="#555"'
    return f'<path {look} d="M{at[0]:.1f} {at[1]:.1f}{stroke}"/>'


def text(
    x: float, y: float, words: str, anchor: str = "start", *, size: int = 12, fill: str = "#111"
) -> str:
    """Return a text; it begins, has its middle or ends at x, and stands on y."""
    anchored = f' text-anchor="{anchor}"' if anchor != "start" else ""
    sized = f' font-size="{size}"' if size != 12 else ""
    return f'<text x="{x:.1f}" y="{y:.1f}"{anchored}{sized} fill="{fill}">{escape(words)}</text>'


def document(
    title: str, width: float, height: float, parts: Iterable[str], left: float = 70
) -> str:
    """Return a complete SVG document, readable without any style sheet or script.

    The title stands in bold at the top from ``left`` on; the picture is made wider (than ``width``
    px) where it needs more room. Empty parts are left out.
    """
    wide, high = round(max(width, left + 20 + _BOLD * len(title))), round(height)
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {wide} {high}" width="{wide}" '
        f'height="{high}" role="img" aria-label={quoteattr(title)} '
        f'font-family="Helvetica, Arial, sans-serif" font-size="12">'
    )
    bold = f'<text x="{left:.0f}" y="24" font-size="14" font-weight="bold" fill="#111">'
    lines = [
        head,
        f"<title>{escape(title)}</title>",
        f'<rect width="{wide}" height="{high}" fill="#ffffff"/>',
        f"{bold}{escape(title)}</text>",
        *filter(None, parts),
        "</svg>",
    ]
    return well_formed("\n".join(lines) + "\n")


def well_formed(content: str) -> str:
    """Return a document of escaped texts with what XML cannot hold replaced by a question mark."""
    return _CHARACTERS_NOT_IN_XML.sub("?", content)
