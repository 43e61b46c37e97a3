"""Interval tests as a certificate holds them: nothing is left for a checker to look for.

The tests are made by the finders (:mod:`.enclosure`, :mod:`.starting`), once for a file.
Written down is what repeating them needs: a centre with more digits than the file has, an
approximate inverse of the Jacobian, the trees at which the principal part is free, and the
conditions of a start in their order. Section 6 of ``docs/certificates.md`` says what is checked.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..errors import ExactnessError
from ..exact import ball
from .classes import Family, plan
from .krawczyk import Krawczyk
from .simplifying import RungeKuttaSystem
from .starting import (
    RADIUS,
    Blocks,
    Target,
    even_trees,
    known_stage_order,
    start_orders,
)
from .system import SweepSystem

Block = dict[str, Any]

#: Significant digits of a centre and of an approximate inverse.
_CENTRE, _INVERSE = 110, 14


def method_proof(system: SweepSystem | RungeKuttaSystem, root: Krawczyk, order: int) -> Block:
    """Return the test of the method itself.

    Parameters
    ----------
    system : SweepSystem or RungeKuttaSystem
        The equations of the file.
    root : Krawczyk
        Their interval test.
    order : int
        Through which series are needed.
    """
    radius = system.document["enclosure"].get("radius", "1e-60")
    block = {"radius": radius, **_test(root)}
    if isinstance(system, RungeKuttaSystem):
        return block
    if system.is_partitioned:
        return block | {"trees": "nystrom" if system.family is Family.SECOND_ORDER else "all"}
    free = {}
    for n in range(2, max(order, system.order) + 1, 2):
        given = tuple(t for t in system.principal if t.order == n)
        found = plan(n, system.stage_order, given).free
        if found:
            free[str(n)] = [str(t) for t in found]
    return block | {"free": free}


def _test(found: Krawczyk) -> Block:
    """Return the centre and the approximate inverse of an interval test."""
    if found.inverse is None:
        raise ExactnessError(f"the interval test gives {found.outcome!s}")
    return {
        "centre": [x.real.midpoint().decimal_text(_CENTRE) for x in found.box],
        "inverse": [[ball(x).decimal_text(_INVERSE) for x in row] for row in found.inverse.rows()],
    }


def start_proofs(
    document: Mapping[str, Any], blocks: Blocks, system: SweepSystem | None
) -> dict[str, Block]:
    """Return the tests of the start and of the finish of a file, those that it needs."""
    target = blocks.target
    if target is None or blocks.start is None:
        return {}
    start: Block = {"radius": _text(RADIUS), **_test(blocks.start)}
    start["conditions"] = _conditions(document["starting"], target, len(blocks.start.box))
    if len(target.L) > 1 and system is not None:
        claimed = {family: n for n, family in start_orders(document, system)}
        families = (Family.SEPARABLE, Family.SECOND_ORDER)
        start["orders"] = [claimed.get(x, 0) for x in families]
    if blocks.finish is None:
        return {"starting": start}
    finish: Block = {"radius": _text(RADIUS), **_test(blocks.finish)}
    finish["conditions"] = [[0, str(t)] for t in even_trees(target.order)]
    return {"starting": start, "finishing": finish}


def _text(radius: Any) -> str:
    return f"1e-{len(str(radius.denominator)) - 1}"


def _conditions(block: Mapping[str, Any], target: Target, count: int) -> list[list[Any]]:
    """Return the conditions of a start, in the order of :meth:`.starting.Target.conditions`."""
    listed = target.conditions(known_stage_order(block, target))
    rest = [(k, t) for k, _, t in listed if k > 0]
    if count == len(rest):  # the first value starts from y itself
        return [[k, str(t)] for k, t in rest]
    if count != len(listed):
        raise ExactnessError("the conditions of the start are not written out")
    return [[k, str(t)] for k, _, t in listed]


def equation_numbers(document: Mapping[str, Any]) -> list[str]:
    """Return numbers that stand in the names of equations: eigenvalues and abscissae."""
    found = []
    for text in document.get("enclosure", {}).get("equations", ()):
        kind, _, rest = text.partition(" ")
        if kind == "growth":
            found.append(rest.removeprefix("q ").removeprefix("p "))
    return found
