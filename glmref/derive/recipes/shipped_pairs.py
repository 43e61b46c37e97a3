"""The shipped pairs: an ansatz with its free parameters fixed, and a start for the other unknowns.

The numbers were found by searches (see campaigns/partitioned/README.md); four digits of the free
parameters were kept and everything else follows from the equations.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from ..partitioned import PairAnsatz
from .sources import stored


@dataclass(frozen=True)
class Shipped:
    """An ansatz with as many unknowns as equations, and a dozen digits of each unknown."""

    ansatz: PairAnsatz
    start: str  #: In the order of the document.
    notes: Sequence[str] = ()  #: For the file.


#: Notes of the files, by their names in ``rough.json``. `tests/unit/test_pairs.py` compares the
#: first with the sign and size of the curvature, `campaigns/partitioned/test_work.py` the second
#: and `campaigns/partitioned/test_starts.py` the others with the measurements that they name.
_LABELS = {
    "leaves": "On q'' = -omega^2 q its parasitic eigenvalues leave the unit circle at once, "
    "|w| - 1 = {} (h omega)^3, although its growth parameters are 0: errors of the carried values "
    "grow, see docs/pairs.md.",
    "grows": "Over ten million steps from zero values its energy error or its carried values grow "
    "on {}, see data/measurements/pairs-long.json.",
    "stays": "Over as many steps from the starting method of this file they stay bounded, see "
    "data/measurements/pairs-starts.json.",
    "later": "Over a hundred million steps from the starting method of this file its energy error "
    "or its carried values grow on {}, see data/measurements/pairs-starts.json.",
}

SHIPPED: Mapping[str, Shipped] = {
    name: Shipped(
        PairAnsatz(name=name, **row["ansatz"]),
        row["start"],
        notes=[_LABELS[label].format(*of) for label, *of in row.get("notes", [])],
    )
    for name, row in stored("rough.json")["pairs"].items()
}
