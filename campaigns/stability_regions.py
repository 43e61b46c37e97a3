"""Stability regions of all methods as polygons: ``data/measurements/stability.json``.

    python -m campaigns.stability_regions data/measurements/stability.json

measures what the file lacks: a method that is new, or whose coefficients have changed. Regions are
those of :func:`glmref.measure.stability.region`. For a pair the moduli of the eigenvalues are kept
instead, on the oscillator q' = omega p, p' = -omega q.
"""

import json
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, fingerprint
from glmref.catalogue.lookup import document, load, names
from glmref.measure import stability
from glmref.measure.timing import circumstances
from glmref.method import GLM, PartitionedGLM
from glmref.theory.stability import oscillator

#: Classes that have no region of one variable, or whose linear form is a method of its own.
WITHOUT = ("additive", "rosenbrock")

FORMAT = "glmref-stability-1"
#: A polygon is as near to the boundary as this part of the half side of the box.
NEARNESS = 1 / 400
FAR = 64.0  # how far an axis is looked at


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
        reach = stability.rounded_up(min(max(1.4 * end, 1.0), stability.MOST))
        return {
            "reach": reach,
            "moduli": [
                _text(simplified(piece, 2 * NEARNESS))
                for piece in stability.moduli(whole, 1.0, reach)
                if len(piece) > 1
            ],
            "oscillation": _short(end),
        }
    found = stability.region(method)
    rings = [simplified(ring, found.reach * NEARNESS) for ring in found.rings]
    return {
        "reach": found.reach,
        "rings": [_text(ring) for ring in rings if len(ring) > 3],
        "imaginary": _short(_end(method, 1j)),
        "real": _short(_end(method, -1)),
    }


def _end(method: GLM, direction: complex) -> float:
    """End of the stable part of a ray; 0 where growth is there from the start.

    :func:`.interval` sees growth from 1e-7 on: of ``1 + c y^k`` a stretch is left over that is not
    stable at all. In the middle of it growth is 1e-7/2^k, above 1e-11 for k up to 13; where the
    method is stable, rounding is all there is: a few 1e-15.
    """
    end = stability.interval(method, direction, most=FAR)
    inside = stability.radius(method, direction * np.linspace(0.0, end, 65)[1:]) - 1
    return end if float(np.median(inside)) < 1e-11 else 0.0


def _short(value: float) -> float:
    return float(f"{value:.4g}")


def _text(points: Iterable[stability.Point]) -> str:
    return " ".join(f"{x:.4g},{y:.4g}" for x, y in points)


def simplified(points: list[stability.Point], near: float) -> list[stability.Point]:
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
        "measured": "Where no eigenvalue of M(z) is larger than one by 1e-7, on "
        f"{stability.GRID} x {stability.GRID} points of a box with half side `reach`; polygons are "
        f"right to {NEARNESS:g} of it, and what is thinner than a cell is not seen. Axes are "
        f"looked at up to {FAR:g}.",
        "where": circumstances() if measured else file.get("where"),
        "methods": rows,
    }
    complete(path, document)
    return measured


if __name__ == "__main__":
    sys.stdout.write(f"measured {main(Path(arguments(sys.argv[1:])[0]))}\n")
