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
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise, product
from typing import Any

import numpy as np

from ..method import GLM
from ..method.rounding import FloatGLM

#: Modulus of an eigenvalue, less one, that counts as growth. Where two eigenvalues meet, rounding
#: moves them by the root of 2^-53 times the condition of M: about 1e-8, a tenth of this.
GROWTH = 1e-7
_SAMPLES = 480  # of a curve of moduli


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
    """A rectangle of the z plane, sampled adaptively."""

    area: float  #: Area of the part in which M(z) is power-bounded.
    #: Area of the cells that the boundary may cross: a bound, where no cell hides a hole.
    error: float
    cells: np.ndarray  #: (m, 4) cells wholly inside: real and imaginary parts of two corners.
    evaluations: int  #: Points looked at.


def region(
    method: GLM, box: tuple[complex, complex], *, coarse: int = 16, depth: int = 5
) -> Region:
    """Sample a rectangle, with more points near the boundary.

    A cell is split in four where its corners and its middle do not agree.

    Parameters
    ----------
    box : tuple[complex, complex]
        Lower left and upper right corner.
    coarse : int
        Cells along each side at the start.
    depth : int
        How often a cell may be split.
    """
    low, high = box
    xs = np.linspace(low.real, high.real, coarse + 1)
    ys = np.linspace(low.imag, high.imag, coarse + 1)
    pairs = product(pairwise(xs), pairwise(ys))
    cells = np.array([[a, b, c, d] for (a, c), (b, d) in pairs])
    kept, area, count, mixed = [], 0.0, 0, cells
    for level in range(depth + 1):
        inside, agree = _corners(method, mixed)
        count += 5 * len(mixed)
        whole = mixed[agree & inside]
        kept.append(whole)
        area += float(_areas(whole).sum())
        mixed = mixed[~agree]
        if level < depth:
            mixed = _quartered(mixed)
    edge = float(_areas(mixed).sum())
    return Region(area + edge / 2, edge / 2, np.concatenate(kept), count)


def _corners(method: GLM, cells: np.ndarray) -> tuple[Any, Any]:
    a, b, c, d = cells.T
    points = np.stack([a + 1j * b, c + 1j * b, a + 1j * d, c + 1j * d, (a + c + 1j * (b + d)) / 2])
    stays = bounded(method, points)
    inside = np.all(stays, axis=0)
    return inside, inside | ~np.any(stays, axis=0)


def _areas(cells: np.ndarray) -> np.ndarray:
    return (cells[:, 2] - cells[:, 0]) * (cells[:, 3] - cells[:, 1])


def _quartered(cells: np.ndarray) -> np.ndarray:
    a, b, c, d = cells.T
    x, y = (a + c) / 2, (b + d) / 2
    parts = ((a, b, x, y), (x, b, c, y), (a, y, x, d), (x, y, c, d))
    return np.concatenate([np.stack(part, axis=1) for part in parts])
