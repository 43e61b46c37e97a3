"""Resonances: step sizes at which waves of the solution drive a parasitic component.

The eigenvalue zeta of V from which a parasitic component starts moves with h along the unit circle,
and so do the waves ``exp(i h omega)`` of the solution. Where they meet, the component is driven at
its own pace: by one wave already in a linear problem, by the product of two through the quadratic
terms of a nonlinear one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np

from ..method import GLM
from .stability import paths

__all__ = ["Resonance", "resonances"]

#: Distance between two eigenvalues below which they count as one.
TOGETHER = 1e-6


@dataclass(frozen=True)
class Resonance:
    """A step size at which solution components excite a parasitic one.

    Attributes
    ----------
    h : float
        The step size.
    zeta : complex
        The eigenvalue of V from which the parasitic one starts.
    frequency : float
        Of the parasitic component.
    waves : tuple[float, ...]
        Frequencies, with signs, whose product excites it: one (first order) or two.
    """

    h: float
    zeta: complex
    frequency: float
    waves: tuple[float, ...]

    @property
    def order(self) -> int:
        """1 where the linear problem resonates, 2 where a quadratic term is needed."""
        return len(self.waves)


def resonances(
    method: GLM, frequencies: Sequence[float], *, most: float, samples: int = 4000, order: int = 2
) -> list[Resonance]:
    """Step sizes at which a parasitic eigenvalue meets a wave, or a product of two waves.

    Waves are ``exp(i h omega)``, omega = 0 (a constant) or plus or minus one of the frequencies;
    parasitic components of frequency omega have the eigenvalues of ``M(i h omega)`` that start at
    the eigenvalues zeta != 1 of V on the unit circle. A term of the equations that is quadratic in
    the solution forces the component where both agree.

    Parameters
    ----------
    frequencies : Sequence[float]
        Angular frequencies of the problem's linear part.
    most : float
        Largest step size looked at.
    samples : int
        Step sizes at which signs are compared.
    order : int
        1 or 2, how many waves.

    References: Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006), section XV.5.
    """
    h = np.linspace(0.0, most, samples + 1)[1:]
    signed = sorted({0.0, *frequencies, *(-x for x in frequencies)})
    found: list[Resonance] = []
    for omega in signed:
        if omega < 0:
            continue
        for zeta, path in _parasitic_paths(method, omega, h):
            for count in range(1, order + 1):
                for waves in combinations_with_replacement(signed, count):
                    turn = path * np.exp(-1j * h * sum(waves))
                    found += [Resonance(x, zeta, omega, waves) for x in _crossings(h, turn)]
    return _distinct(found)


def _parasitic_paths(method: GLM, omega: float, h: np.ndarray) -> list[tuple[complex, np.ndarray]]:
    start = np.concatenate([[h[0] * 1e-3], h])
    followed = paths(method, start * omega)
    first = np.linalg.eigvals(method.to_float().V)
    result = []
    for k in range(method.r):
        zeta = first[np.argmin(np.abs(first - followed[0, k]))]
        if abs(abs(zeta) - 1) < TOGETHER and abs(zeta - 1) > TOGETHER:
            result.append((complex(np.round(zeta, 12)), followed[1:, k]))
    return result


def _crossings(h: np.ndarray, turn: np.ndarray) -> list[float]:
    """Where a path on the unit circle passes through one."""
    angle, near = np.angle(turn), np.abs(np.abs(turn) - 1) < 1e-3
    found = []
    for k in range(len(h) - 1):
        a, b = angle[k], angle[k + 1]
        if near[k] and near[k + 1] and a * b <= 0 and abs(a - b) < 1.0 and a != b:
            found.append(float(h[k] + (h[k + 1] - h[k]) * a / (a - b)))
    return found


def _distinct(found: list[Resonance]) -> list[Resonance]:
    """Sort by h, lower orders first; one of those that coincide is enough."""
    kept: list[Resonance] = []
    for one in sorted(found, key=lambda r: (r.order, r.h)):
        if all(abs(one.h - other.h) > 1e-6 * one.h for other in kept):
            kept.append(one)
    return sorted(kept, key=lambda r: r.h)
