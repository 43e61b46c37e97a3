"""A search from random starts as tasks in JSON: parcels of starts, which any process can take.

Start k depends on the seed and on k alone, and a parcel holds the same starts wherever it is
carried out, so that a search gives the same numbers on one core and on a thousand.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from ..prove.enclosure import gaps_of
from .ansatz import Ansatz
from .partitioned import PairAnsatz, search_pairs
from .search import Found, search

#: Starts of a parcel: they are iterated side by side.
PARCEL = 32


def tasks_of(
    ansatz: Ansatz | PairAnsatz, *, seed: int, starts: int, scale: float = 0.7
) -> Iterator[dict[str, Any]]:
    """Yield tasks of a search, one for each :data:`PARCEL` of starts.

    ``scale`` is the spread of the starts of an :class:`~.ansatz.Ansatz`.
    """
    table = asdict(ansatz)
    pair = isinstance(ansatz, PairAnsatz)
    if not pair:
        table["abscissae"] = {str(k): x for k, x in ansatz.abscissae.items()}
    for first in range(0, starts, PARCEL):
        yield {
            "kind": "search",
            "class": "pair" if pair else "sweep",
            "ansatz": table,
            "seed": seed,
            "first": first,
            "starts": min(PARCEL, starts - first),
            **({} if pair else {"scale": scale}),
        }


def carry_out(task: Mapping[str, Any]) -> dict[str, Any]:
    """Run the starts of a parcel: number, residual and point of each as ``ends``.

    Of one that led nowhere the residual is ``None`` and the point empty.
    """
    return {
        "outcome": "completed",
        "ends": [
            {"number": x.number, "residual": x.residual, "point": list(x.point)}
            if math.isfinite(x.residual) and all(map(math.isfinite, x.point))
            else {"number": x.number, "residual": None, "point": []}
            for x in _search(task)
        ],
    }


def ends_of(record: Mapping[str, Any]) -> list[Found]:
    """Return where the starts of a parcel ended, from its record."""
    return [
        Found(x["number"], tuple(x["point"]), math.inf if x["residual"] is None else x["residual"])
        for x in record["ends"]
    ]


def _search(task: Mapping[str, Any]) -> Iterator[Found]:
    part = {"seed": task["seed"], "starts": task["starts"], "first": task["first"]}
    if task["class"] == "pair":
        return search_pairs(PairAnsatz(**task["ansatz"]), **part)
    document = Ansatz.from_table(task["ansatz"], task["ansatz"]["name"]).document()
    size = len(document["unknowns"])

    def draw(generator: np.random.Generator) -> np.ndarray:
        return generator.normal(size=size) * task["scale"]

    return search(gaps_of(document), draw, **part)
