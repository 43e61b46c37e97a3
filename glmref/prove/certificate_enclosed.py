"""Interval tests as a certificate holds them: nothing is left for a checker to look for.

The tests are made by the finders (:mod:`.enclosure`, :mod:`.starting`, and what belongs to pairs).
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
from ..method import GLM
from .classes import plan
from .enclosure import Outcome, krawczyk, prove, radius_of
from .inverse_finish import is_inverse
from .partitioned_starting import pair_target, start_function, start_orders, start_system
from .partitioned_system import PairSystem
from .starting import (
    RADIUS,
    StartingSystem,
    Target,
    finishing_function,
    finishing_system,
    first_value,
    functionals,
    starting_function,
    starting_system,
    target_of,
)
from .system import SweepSystem
from .tableau_series import stage_order

__all__ = ["equation_numbers", "method_proof", "start_proofs"]

Block = dict[str, Any]

#: Significant digits of a centre and of an approximate inverse.
_CENTRE, _INVERSE = 110, 14


def method_proof(document: Mapping[str, Any], order: int) -> Block:
    """The test of the method itself.

    Args:
        document: with an ``enclosure``. order: through which series are needed.

    Raises
    ------
        ExactnessError: when the test does not succeed.
    """
    pair = document["class"] != "sweep"
    system: Any = PairSystem(document) if pair else SweepSystem(document)
    texts = [document["unknowns"][name] for name in system.unknowns]
    published = [ball(parse(x, digits=document.get("digits", 75))) for x in texts]
    radius = document["enclosure"].get("radius", "1e-60")
    block = {"radius": radius, **_test(system.residuals, published, radius_of(document))}
    if pair:
        return block | {"trees": "nystrom" if system.nystrom else "all"}
    free = {}
    for n in range(2, max(order, system.order) + 1, 2):
        given = tuple(t for t in _principal(system) if t.order == n)
        found = plan(n, system.stage_order, given).free
        if found:
            free[str(n)] = [str(t) for t in found]
    return block | {"free": free}


def _principal(system: SweepSystem) -> Sequence[Any]:
    from ..theory.trees import parse_tree

    return [parse_tree(t) for t in system.principal]


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
        ExactnessError: when a test does not succeed.
    """
    opening, closing = document.get("starting"), document.get("finishing")
    if opening is None:
        return {}
    if "A_hat" in opening:
        if not start_system(opening).unknowns:
            return {}
        return {"starting": _pair_start(document)}
    if not starting_system(opening).unknowns:
        return {}
    target = (
        Target.of(document, prove(document)) if "enclosure" in document
        else target_of(method) if isinstance(method, GLM) else None
    )  # fmt: skip
    if target is None:
        return {}
    system, function = starting_system(opening), starting_function(opening, target)
    digits = document.get("digits", 75)
    published = system.published(digits)
    found = {"starting": {"radius": _text(RADIUS), **_test(function, published, RADIUS)}}
    box = krawczyk(function, published, RADIUS).box
    found["starting"]["conditions"] = _conditions(opening, target, len(function(box)))
    if closing is None or is_inverse(opening, closing) or not finishing_system(closing).unknowns:
        return found
    base = first_value(opening, box, target.order)
    ending = finishing_function(closing, base, target.order)
    published = finishing_system(closing).published(digits)
    found["finishing"] = {"radius": _text(RADIUS), **_test(ending, published, RADIUS)}
    found["finishing"]["conditions"] = [[0, str(t)] for t in _even(target.order)]
    return found


def _text(radius: Any) -> str:
    return f"1e-{len(str(radius.denominator)) - 1}"


def _even(order: int) -> list[Any]:
    from .starting import _signed_trees

    return _signed_trees(1, order)


def _conditions(block: Mapping[str, Any], target: Target, count: int) -> list[list[Any]]:
    """The conditions of a start, in the order of :func:`.starting.starting_conditions`."""
    from .starting import _signed_trees

    stages, q = StartingSystem(block["A"]), 1
    if not stages.unknowns:
        q = stage_order(stages.read([]), most=target.stage_order)
    first, rest = [], []
    for k, (_, sign) in enumerate(functionals(target.L)):
        for t in _signed_trees(sign, target.order - 1 if k == 0 else target.order, q):
            (first if k == 0 else rest).append([k, str(t)])
    if count == len(rest):  # the first value starts from y itself
        return rest
    if count != len(first) + len(rest):
        raise ExactnessError("the conditions of the start are not written out")
    return first + rest


def _pair_start(document: Mapping[str, Any]) -> Block:
    block, system = document["starting"], PairSystem(document)
    orders = start_orders(document["claims"], block)
    texts = [document["unknowns"][name] for name in system.unknowns]
    published = [ball(parse(x, digits=document.get("digits", 75))) for x in texts]
    root = krawczyk(system.residuals, published, radius_of(document)).box
    numbers, principal = system.read(dict(zip(system.unknowns, root, strict=True)))
    series = [
        system.series(numbers, principal, order, nystrom=nystrom, starts=True)
        for order, nystrom in zip(orders, (False, True), strict=True)
        if order
    ]
    target = pair_target(system, series, orders)
    digits = start_system(block).published(document.get("digits", 75))
    found = {"radius": _text(RADIUS), **_test(start_function(block, target), digits, RADIUS)}
    conditions = [[k, str(t)] for t, x in target.zeta.items() for k in range(1, len(x))]
    return {**found, "conditions": conditions, "orders": list(orders)}


def equation_numbers(document: Mapping[str, Any]) -> list[str]:
    """Numbers that stand in the names of equations: eigenvalues and abscissae."""
    found = []
    for text in document.get("enclosure", {}).get("equations", ()):
        kind, _, rest = text.partition(" ")
        if kind == "growth":
            found.append(rest.removeprefix("q ").removeprefix("p "))
    return found
