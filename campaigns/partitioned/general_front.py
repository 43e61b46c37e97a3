"""Pairs for any Hamiltonian on the front of constant, residues, separation and interval.

    python -m campaigns.partitioned.general_front data/measurements/nonseparable.json

Both halves of an explicit method have residues that sum to -1 over the roots but 1. A root -1 takes
most of that sum alone; a pair of roots beside -1 shares it, so that a half without the root -1 has
less than half of the largest residue at the same error constant. The roots of :data:`FOUND` are of
such pairs. They were found by differential evolution (Storn, Price 1997) of the angles: the least
constant with bounds on the largest residue, on the separation of the roots of both halves, and on
the interval below. With ``weighted-8`` the separation of two roots of a half is taken over the sum
of their residues, that of roots of both halves over twice the root of the product: at such rates
parasitic parts mix. All are measured beside the shipped methods, on problems not held out;
``multistep-general-8c`` is one of them, with residues up to 1.6, roots 8 degrees apart, and the
intervals 0.25 and 0.12.

*Interval.* The largest h up to which ``q' = p + i Omega q, p' = -q + i Omega p``, an oscillator in
axes that turn, is stable.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, complete
from campaigns.partitioned.long_runs import three_digits
from campaigns.partitioned.nonseparable import LOST, METHODS
from campaigns.partitioned.semi_separable import interval, long_run, on_plane, step_of
from glmref.catalogue.reader import load_document
from glmref.derive.general_multistep import general_document
from glmref.derive.halves import GeneralHalf
from glmref.derive.recipes.general_multistep import SHIPPED, Shipped, halves_of
from glmref.method import Method
from glmref.problems import problem

#: The roots of q and p that the search found, by the bound that distinguishes them.
FOUND = {
    "constant-8": Shipped("51/100 9/25 -4/25 -49/50", "29/100 -23/100 -99/100"),
    "interval-8": Shipped("19/25 23/50 1/25 -99/100", "27/50 13/100 -49/50"),
    "separation-8": Shipped("17/20 7/20 -11/100 -47/50", "13/25 1/10 -17/20"),
    "weighted-8": Shipped("129/200 61/200 -41/200 -971/1000", "77/200 -13/200 -927/1000"),
    "interval-10": Shipped("43/50 4/5 1/2 1/20 -47/50", "17/25 3/5 -11/100 -89/100"),
}
#: Problems of the long runs that are not held out.
PROBLEMS = (
    "charge-in-gauge", "double-pendulum", "elastic-pendulum", "heavy-top", "magnetic-trap",
    "nonseparable-chain", "point-vortices", "restricted-three-body", "shear",
)  # fmt: skip
#: Steps of a long run, by the steps between renewals.
_LONG = {0: 1_000_000, 1000: 1_000_000}


def turning(omega: float) -> np.ndarray:
    """Return the matrix (4, 4) of the oscillator in axes that turn."""
    return on_plane(np.array([[1j * omega, 1], [-1, 1j * omega]]))


def separation(q: GeneralHalf, p: GeneralHalf) -> float:
    """Return the least angle between two roots but 1, in degrees, conjugate ones included."""
    angles = sorted(math.degrees(math.acos(float(c))) for x in (q, p) for c in x.cosines)
    if q.minus_one or p.minus_one:
        return min(b - a for a, b in pairwise([*angles, 180.0]))
    return min(*(b - a for a, b in pairwise(angles)), 2 * (180.0 - angles[-1]))


def method_of(name: str) -> tuple[Method, GeneralHalf, GeneralHalf]:
    """Return a method with its start, without proofs, and its halves."""
    q, p = halves_of(FOUND.get(name) or SHIPPED[name])
    document = general_document("found", q, p, title="found")
    source = {"citation": "-", "where": "-", "status": "derived"}
    return load_document({**document, "source": source, "claims": {"order": q.order}}), q, p


def row(name: str) -> dict[str, Any]:
    """Return what is measured of one method."""
    method, q, p = method_of(name)
    counts, kept = {}, dict.fromkeys(_LONG, 0)
    for x in PROBLEMS:
        one = problem(x)
        if (found := step_of(method, one)) is None:
            continue
        h, counts[x] = found
        for renew, steps in _LONG.items():
            energy = long_run(method, one, h, steps, renew)["energy"]
            kept[renew] += energy is not None and energy < LOST
    return {
        "method": name,
        "order": q.order,
        "q": [str(c) for c in (*q.cosines, *[-1] * q.minus_one)],
        "p": [str(c) for c in p.cosines],
        "error_constant": three_digits(float(q.error_constant)),
        "residue": three_digits(max(abs(float(x)) for half in (q, p) for x in half.residues)),
        "separation": three_digits(separation(q, p)),
        "interval": [interval(q, p, [turning(omega)]) for omega in (0.0, 1.0)],
        "evaluations": counts,
        "kept": list(kept.values()),
    }


def over(one: Mapping[str, Any], other: Mapping[str, Any]) -> float:
    """Return the mean ratio of the evaluations of two rows, on the problems that both reach."""
    a, b = one["evaluations"], other["evaluations"]
    return math.exp(float(np.mean([math.log(a[x] / b[x]) for x in a.keys() & b.keys()])))


def main(path: Path) -> None:
    """Measure the methods of the front beside those shipped, and write both into the record."""
    record = json.loads(path.read_text(encoding="utf-8"))
    record["front"] = [row(name) for name in (*METHODS, *FOUND)]
    complete(path, record)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
