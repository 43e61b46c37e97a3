"""How small the error constant of a symmetric multistep method can be at a periodicity interval.

The search behind ``data/measurements/error-front.json`` is closed; its script is in the commit
that the record names.

With w = 2 cosh x - 2 and a_j = 2 - 2 cos(theta_j), the explicit symmetric method with one force for
q'' = g(q) and the roots exp(+-i theta_j) is P(w) = prod_j (1 + w / a_j) and the polynomial S of
degree m that agrees with P G to w^m, G = w / x^2 = 1 + w/12 - w^2/240 + ..: the numerical solution
satisfies w P q = h^2 S g. So (1 + C x^{2 m + 2} + ..) q'' = g with the error constant

    C = coefficient of w^{m+1} in P G,

which is affine in each 1 / a_j with the error constant of the other m - 1 roots as its slope.
Beginning with 1/12 for no roots all these slopes are positive, since every 1 / a_j > 1/4 and the
constants with 1 / a_j = 1/4 throughout are (:func:`least`). So C falls as any angle grows, and is
larger than these constants, to which it tends where all roots go to -1.

The step is stable at (h omega)^2 = y where all zeros of w P + y S are simple and in (-4, 0). To
first order the evaluations needed for a small error are as C^{1/(2 m + 2)}.
"""

import math
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np

from campaigns.pages import markdown
from glmref.catalogue.lookup import load
from glmref.method import PartitionedGLM

#: Published symmetric multistep methods.
SYMMETRIC = (
    *("quinlan-tremaine-8", "quinlan-tremaine-10", "quinlan-tremaine-12"),
    *("quinlan-tremaine-14", "quinlan-8a", "quinlan-8b"),
)
#: Numbers of pairs of roots in the record.
PAIRS = (3, 4, 5, 6)
#: Distance of the step sizes that are looked at.
GRID = 0.005


def angles_of(name: str) -> np.ndarray:
    """Return the angles of the roots of V of a symmetric multistep method of the catalogue."""
    method = load(name)
    assert isinstance(method, PartitionedGLM)
    V = np.array([[float(x) for x in row] for row in method.V_hat])
    found = np.angle(np.linalg.eigvals(V))
    return np.sort(found[found > 1e-3])


@cache
def cowell(length: int) -> tuple[Fraction, ...]:
    """Return coefficients of w / x^2 in w = 2 cosh x - 2."""
    square = [  # x^2 / w
        Fraction((-1) ** k * 2, (k + 1) ** 2 * math.comb(2 * k + 2, k + 1)) for k in range(length)
    ]
    found: list[Fraction] = []
    for k in range(length):
        rest = sum((found[i] * square[k - i] for i in range(k)), Fraction(0))
        found.append(int(k == 0) - rest)
    return tuple(found)


def least(pairs: int) -> Fraction:
    """Return the bound of the error constant: all roots at -1, where the method is not stable."""
    G = cowell(pairs + 2)
    return sum(
        (Fraction(math.comb(pairs, k), 4**k) * G[pairs + 1 - k] for k in range(pairs + 1)),
        Fraction(0),
    )


def _polynomials(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return P, and P G to one power more: coefficients of 1, w, w^2, .. ."""
    P = np.ones(1)
    for theta in angles:
        P = np.convolve(P, [1.0, 1 / (2 - 2 * math.cos(theta))])
    m = len(angles)
    return P, np.convolve(P, np.array(cowell(m + 2), dtype=float))[: m + 2]


def error_constant(angles: np.ndarray) -> float:
    """Return C of the method with these angles, in radians."""
    return float(_polynomials(angles)[1][-1])


def end(angles: np.ndarray, most: float = 2.0) -> float:
    """Return the end of the periodicity interval on a grid, not proved; ``most`` is enough."""
    P, product = _polynomials(angles)
    wP, S = np.append(0.0, P)[::-1], np.append(product[:-1], 0.0)[::-1]
    for k in range(1, math.ceil(most / GRID) + 1):
        zeros = np.roots(wP + (k * GRID) ** 2 * S)
        if np.abs(zeros.imag).max() > 1e-9 or zeros.real.min() < -4 or zeros.real.max() > 0:
            return (k - 1) * GRID
    return most


def share(constant: float, pairs: int) -> float:
    """Return evaluations over those with the bound of the constant, to first order."""
    return (constant / float(least(pairs))) ** (1 / (2 * pairs + 2))


def table(document: Mapping[str, Any]) -> str:
    """Tabulate evaluations over the first-order bound, those on training problems, and growth."""
    heads = "order, method, interval, degrees apart, over the bound, $10^{-6}$, $10^{-9}$, growth"
    rows = []
    for m in PAIRS:
        for x in (*document["methods"], *document["descents"]):
            if x["pairs"] != m:
                continue
            name = f"`{x['method']}`" if "method" in x else "least found"
            cells = [str(2 * m + 2), name, f"{x['end']:g}", f"{x['apart']:g}"]
            if x["constant"] is None:
                cells += ["none found", *"---"]
            else:
                counts = [f"{n:,}" for n in x["evaluations"]]
                cells += [f"{share(x['constant'], m):.2f}", *counts, f"{x['growth']:g}"]
            rows.append(cells)
    return markdown(heads.split(", "), rows)
