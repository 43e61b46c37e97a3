"""Stability regions of all methods as polygons: ``data/measurements/stability.json``.

    python -m campaigns.stability_regions data/measurements/stability.json

measures what the file lacks: a method that is new, or whose coefficients have changed. For
y' = lambda y the region is where no eigenvalue of M(z), z = h lambda, leaves the unit disc. It is
looked for on a grid, none of whose points lies on an axis: a symplectic method keeps a piece of the
imaginary axis and has no area there. Where two neighbours of the grid differ, the boundary is found
between them by bisection. For a pair the moduli of the eigenvalues are kept instead, on the
oscillator q' = omega p, p' = -omega q.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, fingerprint
from glmref.catalogue.lookup import document, load, names
from glmref.measure.stability import bounded, interval, locus, moduli, radius
from glmref.measure.timing import circumstances
from glmref.method import GLM, PartitionedGLM
from glmref.theory.stability import oscillator

#: Classes that have no region of one variable, or whose linear form is a method of its own.
WITHOUT = ("additive", "rosenbrock")

FORMAT = "glmref-stability-1"
#: Points of the grid along a side: even, so that none lies on an axis.
GRID = 120
#: A polygon is as near to the boundary as this part of the half side of the box.
NEARNESS = 1 / 400
MOST = 12.0  # half side of the largest box
FAR = 64.0  # how far an axis is looked at
_BISECTIONS = 12

Point = tuple[float, float]


def row(method: Any) -> dict[str, Any]:
    """Return the stability of one method, in short numbers.

    Polygons are texts "x,y x,y .." as SVG has them. ``reach`` is half the side of the box,
    ``rings`` are polygons in it, ``imaginary`` and ``real`` ends of the stable parts of the
    imaginary and the negative real axis, :data:`FAR` where none was seen. Of a pair there are
    ``reach``, ``moduli``, curves of moduli against h omega, and ``oscillation``, the end of the
    stable part.
    """
    if isinstance(method, PartitionedGLM):
        whole = oscillator(method)
        end = _end(whole, 1.0)
        reach = _rounded_up(min(max(1.4 * end, 1.0), MOST))
        return {
            "reach": reach,
            "moduli": [
                _text(simplified(piece, 2 * NEARNESS))
                for piece in moduli(whole, 1.0, reach)
                if len(piece) > 1
            ],
            "oscillation": _short(end),
        }
    reach = _rounded_up(_reach(method))
    rings = [simplified(ring, reach * NEARNESS) for ring in _rings(method, reach)]
    return {
        "reach": reach,
        "rings": [_text(ring) for ring in rings if len(ring) > 3],
        "imaginary": _short(_end(method, 1j)),
        "real": _short(_end(method, -1)),
    }


def _reach(method: GLM) -> float:
    """Return the half side of a box around most of the boundary."""
    boundary = locus(method)
    edge = np.abs(boundary.z[boundary.edge & np.isfinite(boundary.z)])
    size = float(np.sort(edge)[int(0.9 * (len(edge) - 1))]) if len(edge) else MOST
    return min(max(1.15 * size, 1.0), MOST)


def _end(method: GLM, direction: complex) -> float:
    """End of the stable part of a ray; 0 where growth is there from the start.

    :func:`.interval` sees growth from 1e-7 on: of ``1 + c y^k`` a stretch is left over that is not
    stable at all. In the middle of it growth is 1e-7/2^k, above 1e-11 for k up to 13; where the
    method is stable, rounding is all there is: a few 1e-15.
    """
    end = interval(method, direction, most=FAR)
    inside = radius(method, direction * np.linspace(0.0, end, 65)[1:]) - 1
    return end if float(np.median(inside)) < 1e-11 else 0.0


def _rounded_up(value: float) -> float:
    return float(np.ceil(value * 10) / 10)


def _short(value: float) -> float:
    return float(f"{value:.4g}")


def _text(points: Iterable[Point]) -> str:
    return " ".join(f"{x:.4g},{y:.4g}" for x, y in points)


# --- polygons -------------------------------------------------------------------------------------


def _rings(method: GLM, reach: float) -> list[list[Point]]:
    """Return closed polygons around the stable part of a box, cut at its sides."""
    step = 2 * reach / GRID
    marks = -reach + (np.arange(GRID) + 0.5) * step
    inside = np.zeros((GRID + 2, GRID + 2), dtype=bool)
    inside[1:-1, 1:-1] = bounded(method, marks[:, None] + 1j * marks[None, :])
    edges = _crossings(inside)
    places = _placed(method, edges, marks, reach)
    return _joined(_links(inside), places)


Edge = tuple[int, int, int, int]


def _crossings(inside: np.ndarray) -> list[Edge]:
    """Return neighbours (i, j) inside and (k, l) outside."""
    found: list[Edge] = []
    for di, dj in ((1, 0), (0, 1)):
        a, b = inside[: -di or None, : -dj or None], inside[di:, dj:]
        for i, j in np.argwhere(a != b).tolist():
            pair = ((i, j), (i + di, j + dj))
            first, second = pair if inside[i, j] else pair[::-1]
            found.append((*first, *second))
    return found


def _placed(
    method: GLM, edges: list[Edge], marks: np.ndarray, reach: float
) -> dict[frozenset[tuple[int, int]], Point]:
    """Return where the boundary crosses each of them."""
    if not edges:
        return {}
    table = np.array(edges)
    padded = np.concatenate([[-reach], marks, [reach]])
    good = padded[table[:, 0]] + 1j * padded[table[:, 1]]
    bad = padded[table[:, 2]] + 1j * padded[table[:, 3]]
    # what lies outside of the box is not looked at: the polygon ends there
    within = np.all((table[:, 2:] > 0) & (table[:, 2:] <= GRID), axis=1)
    for _ in range(_BISECTIONS):
        middle = (good[within] + bad[within]) / 2
        stays = bounded(method, middle)
        good[within] = np.where(stays, middle, good[within])
        bad[within] = np.where(stays, bad[within], middle)
    keys = (frozenset(((i, j), (k, m))) for i, j, k, m in edges)
    return {key: (z.real, z.imag) for key, z in zip(keys, bad.tolist(), strict=True)}


def _links(inside: np.ndarray) -> list[tuple[frozenset[tuple[int, int]], ...]]:
    """Return pieces of the boundary in each square of four neighbours: pairs of crossed edges."""
    found = []
    mixed = inside[:-1, :-1].astype(int) + inside[1:, :-1] + inside[:-1, 1:] + inside[1:, 1:]
    for i, j in np.argwhere((mixed > 0) & (mixed < 4)).tolist():
        corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]
        crossed = [
            frozenset((corners[k], corners[(k + 1) % 4]))
            for k in range(4)
            if inside[corners[k]] != inside[corners[(k + 1) % 4]]
        ]
        if len(crossed) == 4 and not inside[corners[0]]:
            # a saddle: the two corners inside are kept apart
            crossed = [*crossed[1:], crossed[0]]
        if len(crossed) == 4:
            found.append((crossed[3], crossed[0]))
            found.append((crossed[1], crossed[2]))
        else:
            found.append((crossed[0], crossed[1]))
    return found


def _joined(
    links: list[tuple[frozenset[tuple[int, int]], ...]],
    places: Mapping[frozenset[tuple[int, int]], Point],
) -> list[list[Point]]:
    """Follow the pieces round: every crossed edge belongs to two of them."""
    beside: dict[frozenset[tuple[int, int]], list[frozenset[tuple[int, int]]]] = {}
    for a, b in links:
        beside.setdefault(a, []).append(b)
        beside.setdefault(b, []).append(a)
    rings = []
    while beside:
        start = here = next(iter(beside))
        ring = []
        while True:
            ring.append(places[here])
            onward = beside.pop(here)
            here = next((x for x in onward if x in beside), start)
            if here == start:
                break
        rings.append([*ring, ring[0]])
    return rings


def simplified(points: list[Point], near: float) -> list[Point]:
    """Leave out points of a line that are nearer to what is left than that (Douglas, Peucker)."""
    line = np.array(points)
    keep = np.zeros(len(line), dtype=bool)
    keep[[0, -1]] = True
    # a closed line is opened at the point farthest from its start
    far = int(np.argmax(np.hypot(*(line - line[0]).T)))
    keep[far] = True
    stack = [(0, far), (far, len(line) - 1)]
    while stack:
        a, b = stack.pop()
        if b - a < 2:
            continue
        along, away = line[b] - line[a], line[a + 1 : b] - line[a]
        length = float(np.hypot(*along))
        distance = (
            np.abs(along[0] * away[:, 1] - along[1] * away[:, 0]) / length
            if length
            else np.hypot(*away.T)
        )
        k = int(np.argmax(distance))
        if distance[k] > near:
            keep[a + 1 + k] = True
            stack += [(a, a + 1 + k), (a + 1 + k, b)]
    return [(float(x), float(y)) for x, y in line[keep]]


def names_with_region() -> list[str]:
    """Return methods whose stability depends on one z: one of k parts has z_1, ..., z_k."""
    return [name for name in names("methods") if document(name)["class"] not in WITHOUT]


def row_of(case: Mapping[str, Any]) -> dict[str, Any]:
    """Return the row of a method by its name."""
    return row(load(case["method"]))


def main(path: Path) -> int:
    """Bring the file up to date and return how many methods were measured."""
    file: Mapping[str, Any] = {}
    if path.is_file():
        file = json.loads(path.read_text(encoding="utf-8"))
    stored = file.get("methods", {})
    marks = {name: fingerprint(name) for name in names_with_region()}
    missing = [x for x, mark in marks.items() if stored.get(x, {}).get("fingerprint") != mark]
    found = carried_out(row_of, ({"method": x} for x in missing), beside=path)
    new = dict(zip(missing, found, strict=True))
    rows = {
        name: {"fingerprint": mark, **new[name]} if name in new else stored[name]
        for name, mark in marks.items()
    }
    measured = len(missing)
    document = {
        "format": FORMAT,
        "name": "stability",
        "title": "Stability regions",
        "how": "python -m campaigns.stability_regions FILE",
        "measured": f"Where no eigenvalue of M(z) is larger than one by 1e-7, on {GRID} x {GRID} "
        f"points of a box with half side `reach`; polygons are right to {NEARNESS:g} of it, and "
        f"what is thinner than a cell is not seen. Axes are looked at up to {FAR:g}.",
        "where": circumstances() if measured else file.get("where"),
        "methods": rows,
    }
    complete(path, document)
    return measured


if __name__ == "__main__":
    sys.stdout.write(f"measured {main(Path(arguments(sys.argv[1:])[0]))}\n")
