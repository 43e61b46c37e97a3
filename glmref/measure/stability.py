"""Stability as it is measured: regions, intervals and thresholds.

For y' = lambda y, z = h lambda, one step multiplies the r values by ``M(z) = V + z B (I - z A)^-1
U``. Here M is formed in double precision from the rounded tableau; what is proved about it is in
:mod:`glmref.theory.stability`, which shares nothing with this module but the tableau.

The boundary of the region is traced, not searched: w is an eigenvalue of M(z) exactly where 1/z is
an eigenvalue of ``A + U (w I - V)^-1 B``, so that a walk of w around the unit circle gives every
point at which an eigenvalue has modulus one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from ..method import GLM
from ..method.rounding import FloatGLM

#: Modulus of an eigenvalue, less one, that counts as growth. Where two eigenvalues meet, rounding
#: moves them by the root of 2^-53 times the condition of M: about 1e-8, a tenth of this.
GROWTH = 1e-7
_SAMPLES = 480  # of a curve of moduli
#: Points of the grid along a side: even, so that none lies on an axis.
GRID = 120
MOST = 12.0  # half side of the largest square in which a region is looked for
_BISECTIONS = 12

Point = tuple[float, float]
Edge = tuple[int, int, int, int]


@lru_cache(maxsize=8)
def _rounded(method: GLM) -> FloatGLM:
    """Return the tableau in double precision, rounded once for the many z of a bisection."""
    return method.to_float()


def amplification(method: GLM, z: Any) -> np.ndarray:
    """Return the stability matrix M(z) in double precision, (..., r, r).

    It is infinite where ``I - z A`` is singular.
    """
    rounded = _rounded(method)
    points = np.asarray(z, dtype=complex)
    flat = points.reshape(-1, 1, 1)
    eye = np.eye(method.s)
    result = np.full((flat.size, method.r, method.r), np.inf, dtype=complex)
    with np.errstate(all="ignore"):
        inner = eye - flat * rounded.A
        regular = np.abs(np.linalg.det(inner)) > 0 if method.s else np.ones(flat.size, dtype=bool)
        stages = np.linalg.solve(
            inner[regular], np.broadcast_to(rounded.U, inner.shape[:1] + rounded.U.shape)[regular]
        )
        result[regular] = rounded.V + flat[regular] * (rounded.B @ stages)
    return result.reshape(*points.shape, method.r, method.r)


def _eigenvalues(matrices: np.ndarray) -> np.ndarray:
    """Return eigenvalues (..., r); infinite for a matrix that is not finite."""
    finite = np.isfinite(matrices).all(axis=(-1, -2))
    values = np.full(matrices.shape[:-1], np.inf, dtype=complex)
    values[finite] = np.linalg.eigvals(matrices[finite])
    return values


def radius(method: GLM, z: Any) -> np.ndarray:
    """Return the spectral radius of M(z), shape of z; infinite at a pole."""
    return np.max(np.abs(_eigenvalues(amplification(method, z))), axis=-1)


def moduli(method: GLM, direction: complex, reach: float) -> list[list[tuple[float, float]]]:
    """Return curves of the moduli up to 2 of the eigenvalues of M, by size, at 0 .. reach.

    Points are (x, modulus at ``x direction``); a curve ends where it passes 2.
    """
    marks = np.linspace(0, reach, _SAMPLES + 1)
    sizes = np.sort(np.abs(_eigenvalues(amplification(method, direction * marks))), axis=1)
    pieces: list[list[tuple[float, float]]] = []
    for column in sizes.T:
        pieces.append([])
        for x, y in zip(marks.tolist(), column.tolist(), strict=True):
            if y <= 2:
                pieces[-1].append((x, y))
            elif pieces[-1]:
                pieces.append([])
    return [piece for piece in pieces if piece]


def bounded(method: GLM, z: Any) -> np.ndarray:
    """Return whether no eigenvalue of M(z) is larger than one by :data:`GROWTH`; shape of z."""
    return radius(method, z) <= 1 + GROWTH


def interval(
    method: GLM, direction: complex = 1j, *, most: float = 64.0, samples: int = 4096
) -> float:
    """Return the length of a ray, from 0 on, on which no eigenvalue of M leaves the unit disc.

    Parameters
    ----------
    direction : complex
        Of the ray: 1j the imaginary axis, -1 the negative real axis.
    most : float
        Where to stop.
    samples : int
        Points first looked at; a shorter escape is not seen. There are short ones: of ``g6245`` the
        eigenvalues are off the circle from y = 1.829 to 1.851, and then on it again to 2.504.

    Returns
    -------
    float
        The end; ``most`` where no eigenvalue leaves. It is late by the way on which an eigenvalue
        grows by :data:`GROWTH`: 1e-14 where two eigenvalues meet and part, 1e-7 where one crosses
        the circle, but more where it only grazes it: ``|w| = 1 + c y^k`` is seen from about
        ``(1e-7/c)^(1/k)`` on.
    """
    unit = direction / abs(direction)
    marks = np.linspace(0.0, most, samples + 1)[1:]
    stays = bounded(method, marks * unit)
    if stays.all():
        return most
    first = int(np.argmin(stays))
    low, high = (float(marks[first - 1]) if first else 0.0), float(marks[first])
    while True:
        middle = (low + high) / 2
        if not low < middle < high:
            return low
        if bool(bounded(method, middle * unit)):
            low = middle
        else:
            high = middle


@dataclass(frozen=True, eq=False)
class Locus:
    """Points at which some eigenvalue of M(z) has modulus one."""

    z: np.ndarray  #: (m,) points.
    w: np.ndarray  #: (m,) that eigenvalue.
    #: (m,) whether all other eigenvalues lie in the closed disc: the boundary of the region.
    edge: np.ndarray


def locus(method: GLM, *, turns: int = 720) -> Locus:
    """Trace the boundary of the stability region.

    The eigenvalues x of ``A + U (w I - V)^-1 B`` are the 1/z with w an eigenvalue of M(z), and
    there are no others: every point of the boundary that belongs to the points w is found. These
    are so many on the unit circle, halfway between multiples of ``2 pi/turns``, so that none is an
    eigenvalue of V of small order.
    """
    rounded = _rounded(method)
    angles = (np.arange(turns) + 0.5) * (2 * math.pi / turns)
    found_z, found_w = [], []
    for w in np.exp(1j * angles):
        feed = np.linalg.solve(w * np.eye(method.r) - rounded.V, rounded.B)
        inverse = np.linalg.eigvals(rounded.A + rounded.U @ feed)
        # a zero of x is a point at infinity
        inverse = inverse[np.abs(inverse) > 1e-12]
        found_z += list(1 / inverse)
        found_w += [w] * len(inverse)
    z, w = np.array(found_z, dtype=complex), np.array(found_w, dtype=complex)
    return Locus(z, w, bounded(method, z))


@dataclass(frozen=True, eq=False)
class Region:
    """The stable part of a square of the z plane around 0."""

    reach: float  #: Half the side of the square.
    rings: list[list[Point]]  #: Closed polygons around it, and around its holes.


def region(method: GLM) -> Region:
    """Find the stability region in a square that holds most of its boundary.

    It is looked for on a grid, none of whose points lies on an axis: a symplectic method keeps a
    piece of the imaginary axis and has no area there. Where two neighbours of the grid differ, the
    boundary is found between them by bisection; what is thinner than a cell is not seen. Polygons
    end at the sides of the square.
    """
    boundary = locus(method)
    edge = np.abs(boundary.z[boundary.edge & np.isfinite(boundary.z)])
    size = float(np.sort(edge)[int(0.9 * (len(edge) - 1))]) if len(edge) else MOST
    reach = rounded_up(min(max(1.15 * size, 1.0), MOST))
    step = 2 * reach / GRID
    marks = -reach + (np.arange(GRID) + 0.5) * step
    inside = np.zeros((GRID + 2, GRID + 2), dtype=bool)
    inside[1:-1, 1:-1] = bounded(method, marks[:, None] + 1j * marks[None, :])
    edges = _crossings(inside)
    return Region(reach, _joined(_links(inside), _placed(method, edges, marks, reach)))


def rounded_up(value: float) -> float:
    """Round up to a tenth."""
    return math.ceil(value * 10) / 10


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
