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
from .classes import Family
from .enclosure import CENTRE, INVERSE
from .krawczyk import Krawczyk
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


def _test(found: Krawczyk) -> Block:
    """Return the centre and the approximate inverse of an interval test."""
    if found.inverse is None:
        raise ExactnessError(f"the interval test gives {found.outcome!s}")
    return {
        "centre": [x.real.midpoint().decimal_text(CENTRE) for x in found.box],
        "inverse": [[ball(x).decimal_text(INVERSE) for x in row] for row in found.inverse.rows()],
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
