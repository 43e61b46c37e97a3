"""One picture of a method: stability region, eigenvalues on the imaginary axis, tableau sparsity.

For y' = lambda y the region is where no eigenvalue of M(z), z = h lambda, leaves the unit disc; a
symplectic method keeps a piece of the imaginary axis and no area. A pair is shown on the
oscillator q' = omega p, p' = -omega q alone. Numbers are measured, see
:mod:`glmref.measure.stability`; what is proved is printed by ``glmref verify`` and ``analyze``.

Public names::

    portrait(method) -> str            a complete SVG document
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from xml.sax.saxutils import escape, quoteattr

import numpy as np

from ..exact.linalg import Matrix
from ..measure.stability import amplification, interval, locus, region
from ..method import GLM, PartitionedGLM
from ..theory.stability import oscillator
from .figures import well_formed

__all__ = ["portrait"]

_WIDTH, _HEIGHT = 870, 430
_INK, _FAINT, _FILL, _LINE = "#111", "#d9d9d9", "#9ecae9", "#0072b2"
_REACH = 12.0  # a region that goes on is cut here
_SAMPLES = 480


@dataclass(frozen=True)
class _Panel:
    """A rectangle of the picture and the linear ranges that it shows."""

    left: float
    top: float
    width: float
    height: float
    x: tuple[float, float]
    y: tuple[float, float]

    def at(self, x: float, y: float) -> tuple[float, float]:
        u = (x - self.x[0]) / (self.x[1] - self.x[0])
        v = (y - self.y[0]) / (self.y[1] - self.y[0])
        return self.left + u * self.width, self.top + (1 - v) * self.height

    def frame(self, title: str) -> list[str]:
        """Border, title, one line of it below the other, and ticks."""
        lines = title.split("\n")
        parts = [
            *(
                f'<text x="{self.left}" y="{self.top - 9 - 15 * k}" fill="{_INK}">{escape(line)}'
                f"</text>"
                for k, line in enumerate(reversed(lines))
            ),
            (
                f'<rect x="{self.left}" y="{self.top}" width="{self.width}" height="{self.height}" '
                f'fill="none" stroke="#555"/>'
            ),
        ]
        for value in _ticks(*self.x):
            u, v = self.at(value, self.y[0])
            parts.append(f'<path d="M{u:.1f} {v:.1f}v4" stroke="#555"/>')
            parts.append(_label(u, v + 16, _short(value), "middle"))
        for value in _ticks(*self.y):
            u, v = self.at(self.x[0], value)
            parts.append(f'<path d="M{u:.1f} {v:.1f}h-4" stroke="#555"/>')
            parts.append(_label(u - 7, v + 4, _short(value), "end"))
        return parts


def _label(x: float, y: float, text: str, anchor: str) -> str:
    return (
        f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}" font-size="11" fill="#333">'
        f"{escape(text)}</text>"
    )


def _short(value: float) -> str:
    return f"{value:.10g}"


def _ticks(low: float, high: float) -> list[float]:
    """Four to eight round numbers of a range."""
    rough = (high - low) / 6
    power = 10.0 ** math.floor(math.log10(rough))
    step = next(m * power for m in (1, 2, 5, 10) if m * power >= rough)
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


def portrait(method: GLM | PartitionedGLM) -> str:
    """Draw a method.

    Returns
    -------
        A complete SVG document, readable without any style sheet or script.
    """
    name = method.name or "method"
    parts = [
        (
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_WIDTH} {_HEIGHT}" '
            f'width="{_WIDTH}" height="{_HEIGHT}" role="img" aria-label={quoteattr(name)} '
            f'font-family="Helvetica, Arial, sans-serif" font-size="12">'
        ),
        f"<title>{escape(name)}</title>",
        f'<rect width="{_WIDTH}" height="{_HEIGHT}" fill="#ffffff"/>',
        (
            f'<text x="40" y="20" font-size="15" font-weight="bold" fill="{_INK}">'
            f"{escape(name)}</text>"
        ),
    ]
    if isinstance(method, PartitionedGLM):
        # M(y) of the oscillator at real y is what M(i y) is for one method
        parts += _moduli(oscillator(method), 1.0, "h omega", (50, 64, 330, 300))
        blocks = [("q: A U / B V", method.A, method.U, method.B, method.V)]
        hats = (method.A_hat, method.U_hat, method.B_hat, method.V_hat)
        blocks.append(("p: A^ U^ / B^ V^", *hats))
        parts += _sparsity(blocks[0], (450, 64, 150)) + _sparsity(blocks[1], (640, 64, 150))
    else:
        parts += _region(method)
        parts += _moduli(method, 1j, "Im z", (470, 64, 320, 120))
        block = ("tableau A U / B V", method.A, method.U, method.B, method.V)
        parts += _sparsity(block, (470, 254, 150))
    return well_formed("\n".join([*parts, "</svg>"]) + "\n")


def _region(method: GLM) -> list[str]:
    """Cells inside the region, its traced boundary, and the two axes."""
    boundary = locus(method)
    edge = boundary.z[boundary.edge & np.isfinite(boundary.z)]
    sizes = np.sort(np.abs(edge))
    reach = float(sizes[int(0.9 * (len(sizes) - 1))]) if len(sizes) else _REACH
    reach = min(max(1.15 * reach, 1.0), _REACH)
    box = _Panel(50, 64, 330, 330, (-reach, reach), (-reach, reach))
    # an odd number of cells across: no line of corners lies on the imaginary axis, where the
    # eigenvalues of a symplectic method have modulus one
    found = region(method, (complex(-reach, -reach), complex(reach, reach)), coarse=25, depth=4)
    path = "".join(_cell(box, cell) for cell in found.cells)
    zero = box.at(0, 0)
    parts = [
        f'<path d="{path}" fill="{_FILL}" shape-rendering="crispEdges"/>' if path else "",
        (
            f'<path d="M{box.left} {zero[1]:.1f}h{box.width}M{zero[0]:.1f} {box.top}v{box.height}" '
            f'stroke="{_FAINT}"/>'
        ),
    ]
    dots = "".join(
        f"M{u:.1f} {v:.1f}h0"
        for u, v in (box.at(z.real, z.imag) for z in edge)
        if box.left <= u <= box.left + box.width and box.top <= v <= box.top + box.height
    )
    parts.append(
        f'<path d="{dots}" stroke="{_LINE}" stroke-width="2" stroke-linecap="round"/>'
        if dots
        else ""
    )
    return [*(p for p in parts if p), *box.frame("stability region, z = h lambda")]


def _cell(box: _Panel, cell: Sequence[float]) -> str:
    (u, v), (x, y) = box.at(cell[0], cell[3]), box.at(cell[2], cell[1])
    return f"M{u:.1f} {v:.1f}H{x:.1f}V{y:.1f}H{u:.1f}z"


def _moduli(
    method: GLM, direction: complex, axis: str, place: tuple[float, float, float, float]
) -> list[str]:
    """Moduli of the eigenvalues of M along the axis of oscillations."""
    end = interval(method, direction, most=_REACH)
    reach = min(max(1.4 * end, 1.0), _REACH)
    marks = np.linspace(0, reach, _SAMPLES + 1)
    matrices = amplification(method, direction * marks)
    finite = np.all(np.isfinite(matrices), axis=(1, 2))
    sizes = np.full((len(marks), method.r), np.nan)
    sizes[finite] = np.sort(np.abs(np.linalg.eigvals(matrices[finite])), axis=1)
    panel = _Panel(*place, (0, reach), (0, 2))
    parts = []
    for column in sizes.T:
        for piece in _pieces(marks, column):
            points = " ".join("{:.1f},{:.1f}".format(*panel.at(x, y)) for x, y in piece)
            parts.append(
                f'<polyline points="{points}" fill="none" stroke="{_LINE}" stroke-width="1.4"/>'
            )
    kept = "throughout" if end >= _REACH else f"up to {end:.4g}"
    # two lines: beside the digits of a bound, one would leave the picture
    title = f"moduli of eigenvalues against {axis}\ngrowth below 1e-7 {kept}"
    return [*parts, *panel.frame(title)]


def _pieces(xs: np.ndarray, ys: np.ndarray) -> Iterable[list[tuple[float, float]]]:
    """Parts of a curve that lie inside the panel."""
    piece: list[tuple[float, float]] = []
    for x, y in zip(xs, ys, strict=True):
        if np.isfinite(y) and 0 <= y <= 2:
            piece.append((float(x), float(y)))
        elif piece:
            yield piece
            piece = []
    if piece:
        yield piece


def _sparsity(
    block: tuple[str, Matrix, Matrix, Matrix, Matrix], place: tuple[float, float, float]
) -> list[str]:
    """Nonzero entries of a tableau as squares; a diagonal entry of A is an equation to solve."""
    title, A, U, B, V = block
    left, top, size = place
    rows = [(*a, *u) for a, u in zip(A, U, strict=True)] + [
        (*b, *v) for b, v in zip(B, V, strict=True)
    ]
    high, wide = len(rows), len(rows[0])
    cell = size / max(high, wide)
    square, orange = len(A) == len(A[0]), False
    parts = [f'<text x="{left}" y="{top - 9}" fill="{_INK}">{escape(title)}</text>']
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            if entry.is_zero() is True:
                continue
            implicit = square and i <= j < len(A)
            orange |= implicit
            color = "#d55e00" if implicit else _LINE
            parts.append(
                f'<rect x="{left + j * cell + 0.5:.1f}" y="{top + i * cell + 0.5:.1f}" '
                f'width="{cell - 1:.1f}" height="{cell - 1:.1f}" fill="{color}"/>'
            )
    x, y = left + len(A[0]) * cell, top + len(A) * cell
    parts.append(
        f'<path d="M{left} {y:.1f}h{wide * cell:.1f}M{x:.1f} {top}v{high * cell:.1f}" '
        f'stroke="#555"/>'
        f'<rect x="{left}" y="{top}" width="{wide * cell:.1f}" height="{high * cell:.1f}" '
        f'fill="none" stroke="#555"/>'
    )
    if orange:
        parts.append(
            _label(left, top + high * cell + 16, "orange: on or above A's diagonal", "start")
        )
    return parts
