"""Interval tests as a certificate holds them: nothing is left for a checker to look for.

The tests are made by the finders (:mod:`.enclosure`, :mod:`.starting`).
Written down is what repeating them needs: a centre with more digits than the file has, an
approximate inverse of the Jacobian, the trees at which the principal part is free, and the
conditions of a start in their order. Section 6 of ``docs/certificates.md`` says what is checked.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..errors import ExactnessError
from ..exact import Ball, BallMatrix, ball, jets, lift
from ..exact.expression import parse
from .classes import Family, plan
from .enclosure import prove, radius_of
from .krawczyk import Outcome, krawczyk
from .simplifying import RungeKuttaSystem
from .starting import (
    RADIUS,
    Target,
    even_trees,
    finishing_function,
    finishing_system,
    first_value,
    is_inverse,
    known_stage_order,
    start_orders,
    starting_function,
    starting_system,
    target_of,
)
from .system import SweepSystem

Block = dict[str, Any]

#: Significant digits of a centre and of an approximate inverse.
_CENTRE, _INVERSE = 110, 14


def method_proof(document: Mapping[str, Any], order: int) -> Block:
    """The test of the method itself.

    Parameters
    ----------
    document : Mapping[str, Any]
        With an ``enclosure``.
    order : int
        Through which series are needed.

    Raises
    ------
    ExactnessError
        When the test does not succeed.
    """
    one_step = document.get("class") in ("rk", "rosenbrock")
    system = RungeKuttaSystem(document) if one_step else SweepSystem(document)
    texts = [document["unknowns"][name] for name in system.unknowns]
    published = [ball(parse(x, digits=document.get("digits", 75))) for x in texts]
    radius = document["enclosure"].get("radius", "1e-60")
    block = {"radius": radius, **_test(system.residuals, published, radius_of(document))}
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


def _test(function: Callable[[Sequence[Any]], Sequence[Any]], published: Sequence[Ball],
          radius: Any) -> Block:  # fmt: skip
    """Centre and approximate inverse of an interval test."""
    found = krawczyk(function, published, radius)
    if found.outcome is not Outcome.UNIQUE:
        raise ExactnessError(f"the interval test gives {found.outcome!s}")
    centre = [x.real.midpoint() for x in found.box]
    values = [lift(x, len(centre)) for x in function(jets(centre))]
    inverse = BallMatrix([x.gradient for x in values]).midpoint().inverse().midpoint()
    return {
        "centre": [x.decimal_text(_CENTRE) for x in centre],
        "inverse": [[ball(x).decimal_text(_INVERSE) for x in row] for row in inverse.rows()],
    }


def start_proofs(document: Mapping[str, Any], method: Any) -> dict[str, Block]:
    """The tests of the start and of the finish of a file, those that it needs.

    Raises
    ------
    ExactnessError
        When a test does not succeed.
    """
    opening, closing = document.get("starting"), document.get("finishing")
    if opening is None:
        return {}
    if not starting_system(opening).unknowns:
        return {}
    orders = ()
    if "enclosure" in document:
        record = prove(document)
        target = Target.of(document, record.system, record.series)
        orders = start_orders(document, record.system)
    elif len(method.components) == 1:
        target = target_of(method)
    else:
        return {}
    system, function = starting_system(opening), starting_function(opening, target)
    digits = document.get("digits", 75)
    published = system.published(digits)
    found = {"starting": {"radius": _text(RADIUS), **_test(function, published, RADIUS)}}
    box = krawczyk(function, published, RADIUS).box
    found["starting"]["conditions"] = _conditions(opening, target, len(function(box)))
    if len(target.L) > 1:
        claimed = {family: n for n, family in orders}
        families = (Family.SEPARABLE, Family.SECOND_ORDER)
        found["starting"]["orders"] = [claimed.get(x, 0) for x in families]
    if closing is None or is_inverse(opening, closing) or not finishing_system(closing).unknowns:
        return found
    base = first_value(opening, box, target.order)
    ending = finishing_function(closing, base, target.order)
    published = finishing_system(closing).published(digits)
    found["finishing"] = {"radius": _text(RADIUS), **_test(ending, published, RADIUS)}
    found["finishing"]["conditions"] = [[0, str(t)] for t in even_trees(target.order)]
    return found


def _text(radius: Any) -> str:
    return f"1e-{len(str(radius.denominator)) - 1}"


def _conditions(block: Mapping[str, Any], target: Target, count: int) -> list[list[Any]]:
    """The conditions of a start, in the order of :meth:`.starting.Target.conditions`."""
    listed = target.conditions(known_stage_order(block, target))
    rest = [(k, t) for k, _, t in listed if k > 0]
    if count == len(rest):  # the first value starts from y itself
        return [[k, str(t)] for k, t in rest]
    if count != len(listed):
        raise ExactnessError("the conditions of the start are not written out")
    return [[k, str(t)] for k, _, t in listed]


def equation_numbers(document: Mapping[str, Any]) -> list[str]:
    """Numbers that stand in the names of equations: eigenvalues and abscissae."""
    found = []
    for text in document.get("enclosure", {}).get("equations", ()):
        kind, _, rest = text.partition(" ")
        if kind == "growth":
            found.append(rest.removeprefix("q ").removeprefix("p "))
    return found
