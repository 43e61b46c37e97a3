"""What an enclosure implies: the judge's answers about the one method within the digits of a file.

A file with an ``enclosure`` names as many equations as it has unknowns; the judge encloses their
root (:func:`.enclosure.root_of`) and says what the equations, the form of the file and its symmetry
give there (``docs/certificates.md``, section 6). Orders are asked for up to what a file claims; of
Runge-Kutta and Rosenbrock methods up to the first that the equations do not give. What follows of a
start or a finish is :mod:`.starting`.

There is no implication for claims that fail, and none for upper bounds: those are proved by balls
that exclude zero.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..catalogue.claims import (
    CLAIMS,
    EFFECTIVE_ORDER,
    NYSTROM_ORDER,
    NYSTROM_STARTING_ORDER,
    ORDER,
    ORDER_IDENTITY,
    PARASITISM_FREE,
    STAGE_ORDER,
    STARTING_ORDER,
    W_ORDER,
)
from ..errors import DataError, ExactnessError
from ..exact.judging import consulted
from ..theory.trees import MAX_ORDER
from .enclosure import Enclosure, Root, equations_of, prove, root_of
from .starting import Blocks, prove_blocks, target_of

#: Classes whose equations have a meaning.
ONE_STEP = frozenset({"rk", "rosenbrock"})
ENCLOSED = ONE_STEP | {"sweep", "pair-sweep", "splitting"}


@dataclass(frozen=True)
class Implied:
    """What is true of the one true method within the digits of a file.

    Attributes
    ----------
    true : frozenset[str]
        Claims that are true.
    at_least : Mapping[str, int]
        Claim -> a lower bound of an order.
    growth_zeros : int or None
        How many growth parameters there are, all of them zero; ``None``: unknown.
    rows : Mapping[str, int]
        Embedded row -> a lower bound of its order.
    root : Root or None
        Their root; ``None`` where only the start of the file is enclosed.
    blocks : Blocks
        The interval tests of start and finish.
    """

    true: frozenset[str] = frozenset()
    at_least: Mapping[str, int] = field(default_factory=dict)
    growth_zeros: int | None = None
    rows: Mapping[str, int] = field(default_factory=dict)
    root: Root | None = None
    blocks: Blocks = field(default_factory=Blocks)

    def of_row(self, name: str) -> Implied:
        """Return what is true of the method with the weights of an embedded row."""
        return Implied(at_least={ORDER.key: self.rows.get(name, 0)})


def implied_by(document: Mapping[str, Any] | None, method: Any) -> Implied | None:
    """Return what a file implies about its true method; ``None`` where nothing but balls is known.

    Raises
    ------
    DataError
        When the file asks for more than its equations give.
    ExactnessError
        When the judge does not find exactly one root near the digits.
    """
    if document is None:
        return None
    if "enclosure" not in document:
        return _by_start(document, method)
    kind = document.get("class")
    if kind not in ENCLOSED:
        raise DataError(
            f"`enclosure` has a meaning in files of class {', '.join(sorted(ENCLOSED))}, and this "
            f"one has class {kind!r}; take it out"
        )
    claims = document.get("claims", {})
    if not any(claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key, NYSTROM_ORDER.key)):
        raise DataError(
            "a file with an `enclosure` must claim an order of at least 1: it says which equations "
            "are needed"
        )
    return _enclosed_runge_kutta(document) if kind in ONE_STEP else _enclosed(document)


def _enclosed_runge_kutta(document: Mapping[str, Any]) -> Implied:
    equations = equations_of(document, {})
    p = order_given(equations)
    if not p:
        raise DataError("the equations of the file do not give the condition of the single vertex")
    root = root_of(document, equations)
    rows = {row: order_given(equations, row) for row in equations.rows if row}
    if document["class"] == "rosenbrock":
        at_least = {ORDER.key: p, W_ORDER.key: order_given(equations, claim=W_ORDER.key)}
    else:
        at_least = dict.fromkeys((ORDER.key, ORDER_IDENTITY.key, EFFECTIVE_ORDER.key), p)
        at_least[STAGE_ORDER.key] = equations.s if equations.gauss else 1
    return Implied(_true(root), at_least, rows=rows, root=root)


def order_given(equations: Any, row: str | None = None, claim: str = ORDER.key) -> int:
    """Return the largest order all of whose conditions the equations give, with b or a row."""
    most = 2 * equations.s if equations.gauss and row is None else MAX_ORDER
    method = equations.at(equations.published).for_claim(claim)  # of it only the trees are asked
    p = 0
    while p < most and equations.gives_order(p + 1, False, row, method):
        p += 1
    return p


def _true(root: Root) -> frozenset[str]:
    """Return the claims without a value that hold at a root."""
    return frozenset(x for x, spec in CLAIMS.items()
                     if spec.type is bool and root.enclosed.implies(x))  # fmt: skip


def _enclosed(document: Mapping[str, Any]) -> Implied:
    record = prove(document)  # of the theorem, covered, one root: or an error
    found = record.root.enclosed
    with consulted():
        zeros, true = found.zero_growths(), _true(record.root)
        at_least = {**_orders(record), **record.blocks.orders}
        if record.is_partitioned and "starting" not in document:
            for claim, base, nystrom in (
                (STARTING_ORDER.key, ORDER_IDENTITY.key, False),
                (NYSTROM_STARTING_ORDER.key, NYSTROM_ORDER.key, True),
            ):
                orders = range(at_least.get(base, 0), 0, -1)
                at_least[claim] = next((q for q in orders if found.zero_start_holds(q, nystrom)), 0)
    return Implied(
        true if zeros is None else true | {PARASITISM_FREE.key}, at_least, zeros,
        root=record.root, blocks=record.blocks,
    )  # fmt: skip


def _orders(record: Enclosure) -> dict[str, int]:
    """Return lower bounds of the orders that the equations give."""
    found: dict[str, int] = {}
    enclosed = record.root.enclosed
    for order, nystrom in record.orders:
        identity = enclosed.principal_is_zero(order, True, nystrom)
        if not nystrom:
            found |= {ORDER.key: order, EFFECTIVE_ORDER.key: order}
            if identity:
                found[ORDER_IDENTITY.key] = order
        if identity and record.is_partitioned:
            found[NYSTROM_ORDER.key] = max(order, found.get(NYSTROM_ORDER.key, 0))
    if not record.is_partitioned:
        found[STAGE_ORDER.key] = min(enclosed.q, record.order)
    return found


def _by_start(document: Mapping[str, Any], method: Any) -> Implied | None:
    """Return a start in decimals of a method that is exact: the interval test on its conditions."""
    if len(method.components) > 1 or not method.is_exact or method.starting is None:
        return None
    if method.starting.is_exact:
        return None
    try:
        blocks = prove_blocks(target_of(document, method))
    except (DataError, ExactnessError):
        return None
    return Implied(at_least=blocks.orders, blocks=blocks)
