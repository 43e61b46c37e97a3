"""Starts and finishes in decimals: the judge's conditions, and the root that is proposed to it.

A Runge-Kutta-like start has *parity* when its stages are y0 and pairs that are exchanged by h ->
-h: with the permutation sigma of the pairs, ``A_(sigma i)(sigma j) = -A_ij`` and ``B_(k)(sigma j) =
-(L B)_kj``, for each component. Then S(-h) = L S(h), as for the starting series of a symmetric
method, so that in eigenvectors of L each value has conditions at the even trees or at the odd ones
only: 25 or 12 of the 37 up to order 6. The first value needs the even trees below the order only,
because the principal part is free at the order itself. A finish with parity, b_(sigma j) = -b_j,
undoes an even series by an even one: 25 conditions.

The start of a pair is explicit, its first values are the solution itself, and L = L^ = 1: the
series are even. Conditions are left at 5 + 5 of 16 trees up to order 4 and 25 + 25 of 74 up to
order 6, for one value carried beyond the first; on second-order systems at 9 + 14 up to order 6 and
29 + 50 up to order 8.

In a file the decimals of ``starting`` (and of ``finishing``) are the unknowns, as many as
conditions; the other entries are rational. The judge checks the parity for all values of the
unknowns, and encloses their root (:mod:`glmref.judge.parity`): here it is only found.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from copy import copy
from dataclasses import dataclass, field
from typing import Any, TypeVar

from ..catalogue.claims import (
    FINISHING_ORDER,
    NYSTROM_ORDER,
    NYSTROM_STARTING_ORDER,
    ORDER,
    ORDER_IDENTITY,
    STARTING_ORDER,
)
from ..errors import DataError, ExactnessError
from ..exact.expression import to_text
from ..exact.judging import consulted, newton, rational_of
from ..judge.refusals import Refused
from ..method import Method
from ..method.stage_order import reached
from ..theory.order import order_of
from ..theory.symmetry import symmetry
from .field import about, field_of_decimals, texts_of_decimals

#: Decimals of a start that are unknowns.
DECIMAL = re.compile(r"\d+\.\d{20,}")
#: Significant digits of a centre and of an approximate inverse.
CENTRE, INVERSE = 110, 14
RADIUS = "1e-60"

T = TypeVar("T")


@dataclass(frozen=True)
class Target:
    """What a start is to agree with: the starting series of a method in a record of the judge.

    Attributes
    ----------
    record : Any
        The judge's record of the document of the method.
    order : int
        Of the start on all trees.
    nystrom : int or None
        Of the start of a pair, its order on second-order systems, 0 where it claims none.
    exact : tuple or None
        (L, starting series) of a method in exact numbers, as the judge has them.
    """

    record: Any
    order: int
    nystrom: int | None = None
    exact: tuple[list, Any] | None = None

    @classmethod
    def of(cls, document: Mapping[str, Any], record: Any) -> Target:
        """Return the target of a file with an enclosure, from the record of its root.

        The start of one component has the order of the method. A pair claims orders of its start
        (or the block ``"starting"`` names one), on all trees and on those of second-order systems.

        Raises
        ------
        DataError
            Where the start of a pair claims a higher order than the pair.
        """
        claims = document.get("claims", {})
        if set(record.method.parts) == {"o"}:
            order = max(claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key))
            return cls(record, order)
        own = document.get("starting", {}).get("order", 0)
        order = claims.get(STARTING_ORDER.key, own)
        nystrom = claims.get(NYSTROM_STARTING_ORDER.key, 0)
        most = max(claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key))
        if order > most or nystrom > max(most, claims.get(NYSTROM_ORDER.key, 0)):
            raise DataError("a start has no higher order than the pair; claim less")
        return cls(record, order, nystrom)

    def of_document(self, document: Mapping[str, Any]) -> Target:
        """Return the target of the same method in a document with another start."""
        other = copy(self.record)
        other.document, other.memory = document, {}
        return type(self)(other, self.order, self.nystrom, self.exact)

    @property
    def start(self) -> Any:
        """The judge's conditions of the start.

        Raises
        ------
        Refused
            Where the start has not the form that is described above.
        """
        if self.exact is not None:
            return self.record.exact_start(self.order, *self.exact)
        if self.nystrom is not None:
            return self.record.even_start(self.order, self.nystrom)
        return self.record.odd_start(self.order)


def target_of(document: Mapping[str, Any], method: Method) -> Target:
    """Return the target of an exact symmetric method whose first value is the solution itself.

    Raises
    ------
    DataError
        When the method is not symmetric.
    """
    found, L = order_of(method, principal="identity"), symmetry(method).L
    if L is None or found.eta is None:
        raise DataError("only a symmetric method has a start with parity")
    radicals = texts_of_decimals(document, exact=True).radicals
    with consulted() as judge:
        text = json.dumps([about(document), None, field_of_decimals("enclosure", radicals), None])
        record = judge.proof.record_of(text)
        series = record.series(record.method.for_claim(ORDER.key), False, False)
        series.advance(found.order)
        series.fill()
        involution = record.exact.matrix([[to_text(x) for x in row] for row in L], {})
    return Target(record, found.order, exact=(involution, series))


@dataclass(frozen=True)
class Blocks:
    """What the judge found about the start and the finish of a document.

    Attributes
    ----------
    orders : Mapping[str, int]
        Claim -> the order that follows.
    proofs : Mapping[str, Mapping[str, Any]]
        The proofs of the blocks that need one, as certificates hold them.
    """

    orders: Mapping[str, int] = field(default_factory=dict)
    proofs: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


def prove_blocks(target: Target) -> Blocks:
    """Let the judge prove the start and the finish; name the claims that follow, with their order.

    Blocks without long decimals are exact and are left to exact arithmetic.

    Raises
    ------
    DataError, ExactnessError
        See :func:`made`, :func:`proposed` and :func:`accepted`.
    """
    record, order = target.record, target.order
    opening, closing = (record.document.get(x) for x in ("starting", "finishing"))
    if opening is None or not has_unknowns(opening):
        return Blocks()
    with consulted():
        start = made("starting", lambda: target.start)
        proof = proposed("starting", start)
        found, proofs = {STARTING_ORDER.key: order}, {"starting": proof}
        if target.nystrom is not None:
            proof["orders"] = [order, target.nystrom]
            found[NYSTROM_STARTING_ORDER.key] = max(order, target.nystrom)
        accepted("starting", start, proof)
        if closing is None:
            return Blocks(found, proofs)
        if not made("finishing", record.undoes):
            if not has_unknowns(closing):
                return Blocks(found, proofs)
            finish = made("finishing", lambda: record.finish(start, proof, order))
            proofs["finishing"] = proposed("finishing", finish)
            accepted("finishing", finish, proofs["finishing"])
        return Blocks({**found, FINISHING_ORDER.key: order}, proofs)


def has_unknowns(block: Mapping[str, Any]) -> bool:
    """Return whether decimals of a start or finish are unknowns."""
    return DECIMAL.search(json.dumps(block)) is not None


def made(key: str, make: Callable[[], T]) -> T:
    """Return the conditions of a block.

    Raises
    ------
    DataError
        Where the judge refuses its form.
    """
    try:
        return make()
    except Refused as error:
        raise DataError(f"`{key}`: {error}") from error


def conditions_of(key: str, block: Any) -> list[Any]:
    """Return the conditions that determine a block.

    Conditions of a first value that hold for all unknowns (a start from y0 itself where the
    principal part is the identity) are left out.

    Raises
    ------
    DataError
        When they are not as many as the unknowns.
    """
    with consulted() as judge:
        over = block.over_box(block.wanted, RADIUS)
        found = [x for x, gap in zip(block.wanted, over, strict=True)
                 if not (block.may_lack(x) and judge.numbers.is_nil(gap))]  # fmt: skip
    if len(found) != len(block.unknowns):
        raise DataError(f"`{key}` has {len(found)} conditions in {len(block.unknowns)} unknowns")
    return found


def texts_of(centre: Sequence[Any], inverse: Any) -> dict[str, Any]:
    """Return what :func:`~glmref.exact.judging.newton` found as proofs hold it."""

    def text(x: Any, digits: int) -> str:
        return x.str(digits, radius=False).replace("e+", "e")

    rows = [[text(x, INVERSE) for x in row] for row in inverse.tolist()]
    return {"centre": [text(x.ball, CENTRE) for x in centre], "inverse": rows}


def proposed(key: str, block: Any) -> dict[str, Any]:
    """Return the proof that is proposed for a block: a centre, an inverse, the conditions.

    Raises
    ------
    DataError
        See :func:`conditions_of`.
    ExactnessError
        When the Jacobian is singular, or there is no root within the digits.
    """
    found, radius = conditions_of(key, block), rational_of(RADIUS)
    with consulted() as judge:
        over = block.over_box(found, RADIUS)
        try:
            root = newton(lambda x: block.gaps(found, x), block.published, over)
        except ZeroDivisionError as error:
            raise ExactnessError(f"`{key}`: the Jacobian is singular near the digits") from error
        if not all(abs(x.ball - y) < radius for x, y in zip(root[0], block.published, strict=True)):
            raise ExactnessError(f"`{key}`: the conditions have no root within the digits")
        return {
            "radius": RADIUS,
            **texts_of(*root),
            "conditions": [[k, judge.trees.show(t)] for k, t in found],
        }


def accepted(key: str, conditions: Any, proof: Mapping[str, Any]) -> None:
    """Let the judge enclose the root of the conditions.

    Raises
    ------
    ExactnessError
        When it does not find exactly one root whose rounding the digits are.
    """
    try:
        conditions.root(proof)
    except Refused as error:
        raise ExactnessError(f"`{key}`: {error}") from error


# -- the finish that undoes the first value of a start, with the digits of the start


def inverse_block(opening: Mapping[str, Any]) -> dict[str, Any]:
    """Return the finish that undoes the first value of a start exactly, with the same digits.

    Solving ``y_1 = y + h b f(Y)``, ``Y = y + h A f(Y)`` for y gives ``Y = y_1 + h (A - 1 b^T)
    f(Y)`` and ``y = y_1 - h b f(Y)``, on the stages that b depends on.
    """

    def read(row: Sequence[str]) -> list[int]:
        return [j for j, x in enumerate(row) if x != "0"]

    b = opening["B"][0]
    stages = sorted(reached(read(b), lambda i: read(opening["A"][i])))
    rows = [[_difference(opening["A"][i][j], b[j]) for j in stages] for i in stages]
    return {
        "name": f"inverse of the start in the first value, {len(stages)} stages",
        "kind": "runge-kutta",
        "A": rows,
        "b": [_difference("0", b[j]) for j in stages],
    }


def _difference(left: str, right: str) -> str:
    minus = "" if right == "0" else right[1:] if right.startswith("-") else f"-{right}"
    if left == "0" or not minus:
        return minus or left
    return f"{left}{minus}" if minus.startswith("-") else f"{left}+{minus}"
