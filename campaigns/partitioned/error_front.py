"""How small the error constant of a symmetric multistep method can be at a periodicity interval.

    python -m campaigns.partitioned.error_front data/measurements/error-front.json

With w = 2 cosh x - 2 and a_j = 2 - 2 cos(theta_j), the explicit symmetric method with one force for
q'' = g(q) and the roots exp(+-i theta_j) is P(w) = prod_j (1 + w / a_j) and the polynomial S of
degree m that agrees with P G to w^m, G = w / x^2 = 1 + w/12 - w^2/240 + ..: the numerical solution
satisfies w P q = h^2 S g. So (1 + C x^{2 m + 2} + ..) q'' = g with the error constant

    C = coefficient of w^{m+1} in P G,

which is affine in each 1 / a_j with the error constant of the other m - 1 roots as its slope.
Beginning with 1/12 for no roots all these slopes are positive, since every 1 / a_j > 1/4 and the
constants with 1 / a_j = 1/4 throughout are (:func:`least`). So C falls as any angle grows, and is
larger than these constants, to which it tends where all roots go to -1.

The step is stable at (h omega)^2 = y where all zeros of w P + y S are simple and in (-4, 0). For
each order a random descent looks for the least C with a given periodicity interval and roots that
are so far apart. To first order the evaluations needed for a small error are as C^{1/(2 m + 2)}.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from campaigns.pages import markdown
from campaigns.partitioned.stages_search import SCANNED, Stages, evaluations, gap, growth, of_file

METHODS = (*SCANNED, "quinlan-8a", "quinlan-8b")
PAIRS = (3, 4, 5, 6)
#: End of the periodicity interval and least distance of two roots, in degrees, that are asked for.
ASKED = ((0.1, 0), (0.2, 0), (0.3, 0), (0.2, 6), (0.2, 12), (0.2, 18), (0.2, 24))
#: Distance of the step sizes that are looked at.
GRID = 0.005
SEEDS, TRIES = 4, 1500
NOTE = (
    "constant: C in (1 + C x^p + ..) q'' = g, p = 2 pairs + 2. least: bound for all stable "
    "methods with so many pairs, exact. descents: the least C that was found with an interval up "
    f"to this end, on a grid of {GRID} in h omega, and roots at least so many degrees apart; with "
    "the evaluations and the growth that it has on the training problems of stages_search."
)


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


def descend(task: Mapping[str, Any]) -> dict[str, Any]:
    """Return the least C found among methods with an interval up to an end and roots apart."""
    pairs, wanted, apart = task["pairs"], task["end"], task["apart"]
    best, found = math.inf, np.empty(0)
    for seed in range(SEEDS):
        generator = np.random.default_rng(seed)
        # evenly spread roots, as of an explicit method with the largest interval
        angles, width = np.pi * np.arange(1, pairs + 1) / (pairs + 1), 0.1
        value = error_constant(angles) if end(angles, wanted) >= wanted else math.inf
        for _ in range(TRIES):
            new = angles + width * generator.normal(size=pairs)
            if not (new.min() > 0.2 and new.max() < np.pi and gap(new) >= apart):
                continue
            constant = error_constant(new)
            if constant < value and end(new, wanted) >= wanted:
                angles, value, width = new, constant, 1.5 * width
            else:
                width = max(1e-5, 0.97 * width)
        if value < best:
            best, found = value, angles
    row = {**task, "constant": None, "angles": np.sort(np.degrees(found)).round(2).tolist()}
    return row if math.isinf(best) else row | _measured(found, best)


def _measured(angles: np.ndarray, constant: float) -> dict[str, Any]:
    """Return the constant, and evaluations and growth on the training problems."""
    method = Stages(angles, np.zeros(1), np.ones((1, len(angles)), dtype=complex))
    counts = evaluations(method)
    return {
        "constant": float(f"{constant:.4g}"),
        "evaluations": np.exp(np.log(counts).mean(axis=0)).round().astype(int).tolist(),
        "growth": round(growth(method, counts), 1),
    }


def method_row(name: str) -> dict[str, Any]:
    """Return the error constant of a method of the catalogue."""
    angles = of_file(name).angles
    return {
        "method": name,
        "pairs": len(angles),
        "end": round(end(angles), 3),
        "apart": round(gap(angles), 1),
        **_measured(angles, error_constant(angles)),
    }


def main(path: Path) -> None:
    """Look for all ends and write the file."""
    tasks = ({"pairs": m, "end": x, "apart": y} for m in PAIRS for x, y in ASKED)
    title = "Error constants of symmetric multistep methods and periodicity intervals"
    record = record_of("partitioned.error_front", "error-front", title, NOTE)
    record["least"] = {str(2 * m + 2): str(least(m)) for m in PAIRS}
    record["methods"] = [method_row(name) for name in METHODS]
    complete(path, record | {"descents": carried_out(descend, tasks, beside=path)})


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


if __name__ == "__main__":
    given: Sequence[str] = arguments(sys.argv[1:])
    main(Path(given[0]))
