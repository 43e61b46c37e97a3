"""One picture of a method: stability region, eigenvalues on the imaginary axis, tableau sparsity.

For y' = lambda y the region is where no eigenvalue of M(z), z = h lambda, leaves the unit disc; a
symplectic method keeps a piece of the imaginary axis and no area. A pair is shown on the
oscillator q' = omega p, p' = -omega q alone. Numbers are measured, see
:mod:`glmref.measure.stability`; what is proved is printed by ``glmref verify`` and ``analyze``.
"""

from __future__ import annotations

import numpy as np

from ..errors import UsageError
from ..exact.linalg import Matrix
from ..measure.stability import MOST, interval, locus, moduli, region
from ..method import GLM, AdditiveGLM, PartitionedGLM, RosenbrockGLM
from ..theory.stability import oscillator
from .axes import Axes, document, round_ticks, text

_WIDTH, _HEIGHT = 870, 430
_FILL, _LINE = "#9ecae9", "#0072b2"


def _panel(axes: Axes, title: str, labels: tuple[str, str]) -> list[str]:
    """Border, ticks, labels of the axes, and the lines of a title one below the other."""
    lines = enumerate(reversed(title.split("\n")))
    return [
        *(text(axes.left, axes.top - 9 - 15 * k, line) for k, line in lines),
        *axes.frame(
            round_ticks(*axes.x, most=6),
            round_ticks(*axes.y, most=6),
            labels,
            grid=False,
            size=11,
            aside=32,
        ),
    ]


def portrait(method: GLM | PartitionedGLM | AdditiveGLM) -> str:
    """Draw a method as a complete SVG document, readable without any style sheet or script."""
    name = method.name or "method"
    if isinstance(method, RosenbrockGLM):
        method = method.linear_form
    if isinstance(method, AdditiveGLM):
        raise UsageError(
            f"{name} is additive and has no stability region of one variable; draw one of its "
            f"parts, glmref.plot(glmref.load({name!r}).part(1))"
        )
    parts: list[str] = []
    blocks = [c.matrices for c in method.components]
    if isinstance(method, PartitionedGLM):
        # M(y) of the oscillator at real y is what M(i y) is for one method
        parts += _moduli(oscillator(method), 1.0, "h omega", (50, 64, 330, 300))
        parts += _sparsity(("q: A U / B V", *blocks[0]), (450, 64, 150))
        parts += _sparsity(("p: A^ U^ / B^ V^", *blocks[1]), (640, 64, 150))
    else:
        parts += _region(method)
        parts += _moduli(method, 1j, "Im z", (470, 64, 320, 120))
        parts += _sparsity(("tableau A U / B V", *blocks[0]), (470, 254, 150))
    return document(name, _WIDTH, _HEIGHT, parts, left=40)


def _region(method: GLM) -> list[str]:
    """Return the region, its traced boundary, and the two axes."""
    found = region(method)
    square = (-found.reach, found.reach)
    box = Axes(50, 64, 330, 330, square, square)
    boundary = locus(method)
    edge = boundary.z[boundary.edge & np.isfinite(boundary.z)]
    path = "".join(f"M{box.line(ring)}z" for ring in found.rings)
    return [
        f'<path d="{path}" fill="{_FILL}" fill-rule="evenodd"/>' if path else "",
        box.cross(0, 0),
        box.dots(((z.real, z.imag) for z in edge), _LINE, 2),
        *_panel(box, "stability region, z = h lambda", ("Re z", "Im z")),
    ]


def _moduli(
    method: GLM, direction: complex, axis: str, place: tuple[float, float, float, float]
) -> list[str]:
    """Return the moduli of the eigenvalues of M along the axis of oscillations."""
    end = interval(method, direction, most=MOST)
    reach = min(max(1.4 * end, 1.0), MOST)
    axes = Axes(*place, (0, reach), (0, 2))
    parts = [
        f'<polyline points="{axes.line(piece)}" fill="none" stroke="{_LINE}" stroke-width="1.4"/>'
        for piece in moduli(method, direction, reach)
    ]
    kept = "throughout" if end >= MOST else f"up to {end:.4g}"
    # two lines: beside the digits of a bound, one would leave the picture
    title = f"moduli of eigenvalues against {axis}\ngrowth below 1e-7 {kept}"
    return [*parts, *_panel(axes, title, (axis, "|w|"))]


def _sparsity(
    block: tuple[str, Matrix, Matrix, Matrix, Matrix], place: tuple[float, float, float]
) -> list[str]:
    """Draw nonzero entries of a tableau as squares; diagonal ones of A are equations to solve."""
    title, A, U, B, V = block
    left, top, size = place
    rows = [(*a, *u) for a, u in zip(A, U, strict=True)] + [
        (*b, *v) for b, v in zip(B, V, strict=True)
    ]
    high, wide = len(rows), len(rows[0])
    cell = size / max(high, wide)
    square, orange = len(A) == len(A[0]), False
    parts = [text(left, top - 9, title)]
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
        said = "orange: on or above A's diagonal"
        parts.append(text(left, top + high * cell + 16, said, size=11, fill="#333"))
    return parts
