"""The shipped pairs: an ansatz with its free parameters fixed, and a start for the other unknowns.

The numbers were found by searches (see docs/pairs.md); four digits of the free parameters were kept
and everything else follows from the equations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..pairs import PairAnsatz

__all__ = ["SHIPPED", "Shipped"]


@dataclass(frozen=True)
class Shipped:
    """An ansatz with as many unknowns as equations, and a dozen digits of each unknown.

    Attributes
    ----------
        start: in the order of the document. claims: besides the usual ones. notes: for the file.
    """

    ansatz: PairAnsatz
    start: str
    claims: Mapping[str, Any] = field(default_factory=dict)
    notes: Sequence[str] = ()


_FOUR = "Explicit G-symplectic pair of order 4 with {} force evaluations, for separable systems"
_SIX = "Explicit G-symplectic pair of order 6 with {} force evaluations, for separable systems"

SHIPPED: Mapping[str, Shipped] = {
    "pair-4-4": Shipped(
        PairAnsatz(
            "pair-4-4", 4, 4, title=_FOUR.format("four"),
            fixed={"w2": "5031/10000", "c1": "-31/200", "v1": "-226/625"},
        ),
        "0.292538003158 -0.0800950647859 -0.26324858746 -0.175903151702",
    ),
    "pair-4-5": Shipped(
        PairAnsatz(
            "pair-4-5", 5, 4, title=_FOUR.format("five"),
            fixed={
                "b1": "-787/5000", "w1": "-1851/1250", "w2": "-8653/10000", "c1": "-971/5000",
                "v1": "13329/10000",
            },
        ),
        "0.33746925348 0.537597926807 0.474413887059 0.852792719724",
    ),
    "pair-4-6": Shipped(
        PairAnsatz(
            "pair-4-6", 6, 4, title=_FOUR.format("six"),
            fixed={
                "b2": "3273/10000", "w1": "-3119/5000", "w2": "281/1250", "w3": "1413/1250",
                "v1": "-501/1250", "v2": "-453/1000", "v3": "359/2500",
            },
        ),
        "0.0673605816682 -0.0334573194165 0.200983455503 -0.208313166578",
    ),
    "pair-6-7": Shipped(
        PairAnsatz(
            "pair-6-7", 7, 6, starts="q", title=_SIX.format("seven"),
            fixed={"w4": "-3839/625", "v2": "447/1000"},
        ),
        "0.0731280525908 0.220315238955 0.209908313854 0.118433510039 -0.466290361378 "
        "0.607722904279 0.155114360527 0.205100688002 -0.0160361492084 -0.741979426964 "
        "-2.80726432963",
    ),
    "pair-6-10": Shipped(
        PairAnsatz(
            "pair-6-10", 10, 6, starts="q", title=_SIX.format("ten"),
            fixed={
                "b2": "-109/625", "b5": "-383/10000", "w5": "409/1250", "c4": "-731/2500",
                "v1": "-10711/10000", "v2": "-643/5000", "v3": "384/625", "v4": "-3331/10000",
            },
        ),
        "0.251090885793 0.280911879666 0.0405045113845 0.487998301098 0.813267657402 "
        "0.169709559807 1.12828447308 -0.0758723903025 0.240865316 0.160207480514 -0.34319691946",
    ),
}  # fmt: skip
