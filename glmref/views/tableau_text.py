"""Blocks of cells with rules between them, and numbers as decimals: the letters of a tableau."""

from __future__ import annotations

import re
from collections.abc import Sequence

from ..exact import Ball, Scalar, rounded_decimal
from ..method import Method, RosenbrockGLM
from .tables import Style, counted

Cells = list[list[str]]

_GAP = "  "
_DECIMAL = re.compile(r"(-?\d+(\.\d*)?)?$")


def decimal_text(x: Scalar, digits: int) -> str:
    """Return a number in decimals: as it is where it ends within them, else rounded to them.

    A ball that contains zero has no significant digit and is ``0``. The significant digits are
    those of each of the two parts of a complex number.
    """
    if x.is_real():
        return _real_text(x, digits)
    real, imaginary = _real_text(x.real, digits), _real_text(x.imag, digits)
    sign = "" if imaginary.startswith("-") else "+"
    return f"{imaginary}i" if real == "0" else f"{real}{sign}{imaginary}i"


def _real_text(x: Scalar, digits: int) -> str:
    if isinstance(x, Ball) and x.is_zero() is None:
        return "0"
    value = rounded_decimal(x, digits)
    if value and not -15 <= value.adjusted() <= 20:
        return f"{value:e}"
    return f"{value:f}"


def tableau(grid: Sequence[Sequence[Cells]], style: Style) -> list[str]:
    """Draw a partitioned matrix; one that is wider than the terminal in parts, columns by columns.

    The grid has rows of blocks. Blocks side by side have as many rows, those above each other as
    many columns.
    """
    places = [(j, k) for j, block in enumerate(grid[0]) for k in range(len(block[0]))]
    aligned = _on_the_point(grid)
    sizes = [max(len(cells[k]) for row in aligned for cells in row[j])
             for j, k in places]  # fmt: skip
    parts: list[list[tuple[int, int]]] = [[]]
    used = 0
    for place, size in zip(places, sizes, strict=True):
        used += size + len(_GAP) + (1 if parts[-1] and parts[-1][-1][0] != place[0] else 0)
        if parts[-1] and used > style.width:
            parts.append([])
            used = size + len(_GAP)
        parts[-1].append(place)
    if len(parts) == 1:
        return _drawn(grid, style)
    lines: list[str] = []
    for part in parts:
        first, last = places.index(part[0]) + 1, places.index(part[-1]) + 1
        which = f"column {first}" if first == last else f"columns {first} to {last}"
        lines.append(f"  {which} of {len(places)}:")
        lines += _drawn(_columns(grid, part), style)
    return lines


def _columns(grid: Sequence[Sequence[Cells]], part: list[tuple[int, int]]) -> list[list[Cells]]:
    """Return the grid with some of its columns only."""
    blocks = dict.fromkeys(j for j, _ in part)
    return [
        [[[cells[k] for i, k in part if i == j] for cells in row[j]] for j in blocks]
        for row in grid
    ]


def _drawn(grid: Sequence[Sequence[Cells]], style: Style) -> list[str]:
    flat, bar, cross = style.rules
    aligned = _on_the_point(grid)
    widths = [
        [
            max(map(len, column))
            for column in zip(*(line for row in aligned for line in row[j]), strict=True)
        ]
        for j in range(len(grid[0]))
    ]
    spans = [sum(w) + len(_GAP) * (len(w) - 1) for w in widths]
    lines: list[str] = []
    for i, row in enumerate(aligned):
        if i:
            rule = cross.join(flat * (w + 2) for w in spans)
            lines.append(" " + style.paint(rule[:-1], "dim"))
        for pieces in zip(*row, strict=True):
            parts = (
                _GAP.join(x.rjust(w) for x, w in zip(cells, width, strict=True))
                for cells, width in zip(pieces, widths, strict=True)
            )
            lines.append(("  " + f" {style.paint(bar, 'dim')} ".join(parts)).rstrip())
    return lines


def _on_the_point(grid: Sequence[Sequence[Cells]]) -> list[list[Cells]]:
    """Pad decimals on the right, so that the points of a column stand below each other."""
    result = [[[list(cells) for cells in block] for block in row] for row in grid]
    for j in range(len(grid[0])):
        stacked = [cells for row in result for cells in row[j]]
        for k in range(len(stacked[0])):
            column = [cells[k] for cells in stacked]
            if not any("." in x for x in column) or not all(_DECIMAL.match(x) for x in column):
                continue
            tails = [len(x) - len(x.partition(".")[0]) for x in column]
            for cells, x, tail in zip(stacked, column, tails, strict=True):
                cells[k] = x + " " * (max(tails) - tail)
    return result


def size_of(method: Method) -> str:
    """Return the numbers of stages and of values of a method, in words."""
    first, last = method.carriers[0], method.carriers[-1]
    stages, values = counted(len(first.A), "stage"), counted(len(first.V), "value")
    if method.parts == 2:
        return f"{stages} Q and {len(last.A)} P, {values} of q and {len(last.V)} of p"
    if isinstance(method, RosenbrockGLM):
        stages = counted(len(method.b), "stage")
    elif method.additive:
        stages = f"{len(method.components)} parts on {stages}"
    return f"{stages}, {values}"
