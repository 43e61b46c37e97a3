"""How far the search for order 8 went: for each ansatz its conditions and what random starts gave.

``python -m campaigns.order8_search FILE`` searches and writes ``FILE`` (the one shipped is
``data/measurements/order8-search.json``). A start counts as solved when all residuals fall below
:data:`SOLVED` in double precision with no unknown above :data:`LARGEST`; what is solved may belong
to a family that contains other solutions. That nothing was found is no proof.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete, record_of
from glmref.derive.ansatz import Ansatz, Value
from glmref.derive.search import search
from glmref.exact.judging import over_scalars
from glmref.prove.enclosure import conditions_of

SOLVED, LARGEST = 1e-11, 10.0
STARTS, SCALE, SEED = 128, 0.7, 1

_W3, _I = Value("exp(2*pi*i/3)"), Value("i")
_EVEN, _ODD = Value("-1", 1, 1), Value("-1", 1, -1)
#: The same with the other signs in G.
_W3P, _MINUS = Value("exp(2*pi*i/3)", 1), Value("-1", -1, -1)

#: Stages, values, stage order, explicit stages.
ANSATZES: Sequence[tuple[int, Sequence[Value], int, Sequence[int]]] = (
    (3, (_W3, _EVEN), 3, ()),
    (3, (_W3, _I), 3, ()),
    (3, (_W3, _I, _EVEN), 2, ()),
    (3, (_W3, _I, _EVEN), 3, ()),
    (3, (_W3, _I, _EVEN), 3, (1,)),
    (4, (_W3, _EVEN), 2, ()),
    (4, (_W3, _ODD), 2, ()),
    (4, (_W3, _EVEN), 3, ()),
    (4, (_W3, _I, _EVEN), 2, ()),
    (4, (_W3, _I, _EVEN), 2, (1,)),
    (4, (_W3, _I, _EVEN), 3, (1,)),
    (4, (_W3P, _I, _MINUS), 3, (1,)),
    (5, (_W3, _EVEN), 1, ()),
    (5, (_W3, _EVEN), 2, ()),
    (5, (_W3, _ODD), 2, ()),
    (5, (_W3, _EVEN), 2, (1, 2)),
    (5, (_W3, _EVEN), 3, ()),
)


Task = Callable[[Mapping[str, Any]], dict[str, Any]]


def start_of(size: int) -> Callable[[np.random.Generator], np.ndarray]:
    """Return what draws a start of so many unknowns."""
    return lambda generator: generator.normal(size=size) * SCALE


def told(values: Sequence[Value]) -> dict[str, Any]:
    """Return what a record says of the values carried beside the solution."""
    return {
        "eigenvalues": [x.eigenvalue for x in values],
        "signs": [x.sign for x in values],
        "parity": [x.parity for x in values if not x.is_pair],
    }


def attempt(
    stages: int, values: Sequence[Value], stage_order: int, explicit: Sequence[int]
) -> dict[str, Any]:
    """Search one ansatz of order 8 and say what came out."""
    ansatz = Ansatz("x", stages, 8, values, stage_order=stage_order, explicit=explicit)
    equations = conditions_of(ansatz.document())
    size = len(equations.unknowns)
    ends = list(search(over_scalars(equations.residuals), start_of(size), seed=SEED, starts=STARTS))
    good = [x for x in ends if max(abs(v) for v in x.point) < LARGEST]
    return {
        "stages": stages,
        "values": len(equations.G),
        **told(values),
        "stage_order": stage_order,
        "explicit": list(explicit),
        "unknowns": size,
        "conditions": len(equations.equations),
        "starts": len(ends),
        "solved": sum(x.residual < SOLVED for x in good),
        "smallest_residual": float(f"{min((x.residual for x in good), default=np.inf):.2g}"),
    }


def attempt_case(case: Mapping[str, Any]) -> dict[str, Any]:
    """Search the ansatz of a number."""
    return attempt(*ANSATZES[case["ansatz"]])


def store(path: Path, name: str, title: str, task: Task, number: int) -> None:
    """Search the ansatzes 0, 1, .. below a number and write the record of a name."""
    found = carried_out(task, ({"ansatz": k} for k in range(number)), beside=path)
    about = {"seed": SEED, "scale": SCALE, "solved_below": SOLVED}
    complete(path, record_of(name.replace("-", "_"), name, title, **about, ansatzes=found))


def main(path: Path) -> None:
    """Search every ansatz and write the file."""
    title = "Order 8: conditions and what random starts gave"
    store(path, "order8-search", title, attempt_case, len(ANSATZES))


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
