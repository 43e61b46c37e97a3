"""A true solution near the digits of a file, proved, and everything that follows from it.

The judge reads the equations of a file with an ``enclosure`` (``docs/certificates.md``, section 6)
and encloses their root (:func:`root_of`); what is found here is the centre and the inverse that its
interval test needs. :func:`prove` does so for the sweep form, of one component or two (the classes
``sweep``, ``pair-sweep`` and ``splitting``), and adds the start and the finish (:mod:`.starting`).
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any

from ..catalogue.claims import NYSTROM_ORDER, ORDER, ORDER_IDENTITY
from ..catalogue.strict_json import shown
from ..errors import DataError, ExactnessError
from ..exact import Ball, Exact, ball, linalg
from ..exact.judging import Fraction as rational
from ..exact.judging import Interval, as_scalar, consulted, newton, over_scalars
from ..exact.linalg import Matrix
from ..judge.refusals import Refused, Undecided
from ..method import as_matrix
from ..theory.trees import parse_tree
from .equations import free_trees, one_of_each, representatives
from .field import about, field_of_decimals, texts_of_decimals
from .starting import Blocks, Target, prove_blocks, texts_of

_RADIUS = re.compile(r"\d{1,99}(\.\d{1,99})?(e-\d{1,3})?")


@dataclass(frozen=True)
class Enclosure:
    """A proof record: what was proved about the method of a file, and by what.

    Attributes
    ----------
    values : Mapping[str, Ball]
        Enclosing ball of every unknown, by name.
    radius : Fraction
        Half-width of the box in which the root is unique.
    root : Root
        The root of the equations.
    orders : tuple[tuple[int, bool], ...]
        The orders proved, each with whether it is that on second-order systems (lower bounds; see
        ``next_order`` for the upper one).
    signs : tuple[tuple[int, ...], ...] or None
        Diagonal of E = V L, the symmetry of the values, by component; ``None`` for a product of
        flows that is not symmetric.
    blocks : Blocks
        What was proved about the start and the finish.
    """

    values: Mapping[str, Ball]
    radius: Fraction
    root: Root
    orders: tuple[tuple[int, bool], ...]
    signs: tuple[tuple[int, ...], ...] | None
    blocks: Blocks = field(default_factory=Blocks)

    @property
    def is_partitioned(self) -> bool:
        """Whether there are two components."""
        return len(self.root.enclosed.halves) == 2

    @property
    def order(self) -> int:
        """The order proved on all trees, 0 where none is claimed."""
        return max((order for order, nystrom in self.orders if not nystrom), default=0)

    @property
    def nystrom_order(self) -> int:
        """The order on second-order systems; ``order`` for one component."""
        return max(order for order, _ in self.orders)

    @property
    def involution(self) -> Matrix:
        """L = V^-1 E of the first component, which reverses a symmetric method."""
        assert self.signs is not None
        V = as_matrix(self.root.record.document["V"], "V")
        E = linalg.diagonal(list(map(Exact, self.signs[0])))
        return linalg.matmul(linalg.inverse(V), E)

    @cached_property
    def identity(self) -> bool:
        """Whether the first values are the solution itself, to the orders claimed."""
        found = self.root.enclosed
        return all(found.principal_is_zero(order, True, nystrom) for order, nystrom in self.orders)

    @cached_property
    def next_order(self) -> float:
        """Lower bound of a condition one order higher, 0.0 where none is refuted.

        The starting series is the only one through the order (:mod:`..theory.starting_series`), so
        that one condition which excludes zero excludes the order, whatever the start is.
        """
        record, n = self.root.record, self.order + 1
        with consulted():
            series = record.series(record.method.for_claim(ORDER.key), False, False)
            series.advance(n)
            gaps = [as_scalar(x) for t in series.pool(n) for x in series.condition(t)]
            return max(ball(x).lower_magnitude() for x in gaps)


def prove(document: Mapping[str, Any]) -> Enclosure:
    """Prove what a file with an ``"enclosure"`` claims, from the file alone.

    Parameters
    ----------
    document : Mapping[str, Any]
        The parsed JSON object, of class ``sweep``, ``pair-sweep`` or ``splitting``.

    Raises
    ------
    DataError
        When the file asks for more than its equations give.
    ExactnessError
        When the interval test does not find exactly one root near the digits.
    """
    orders = _claimed(document)
    if not orders:
        raise DataError("a file with an `enclosure` must claim an order of at least 1")
    equations = equations_of(document, members_of(document))
    if not equations.is_of_the_theorem(False, False, None):
        pair = document["class"] != "sweep"
        names = "`b`, `c`, `w`, `v` and `stages`" if pair else "`D` and `X`"
        raise DataError(
            f"{names} must be palindromic up to a sign for each row of X, with V and G to match: "
            f"only then do the even orders follow"
        )
    _check_orders(orders, equations)
    try:
        equations.published  # noqa: B018
    except Refused as error:
        raise DataError(
            "with an `enclosure` all `unknowns` are decimals with `digits` digits after the point"
        ) from error
    root, signs = root_of(document, equations), equations.signs
    return Enclosure(
        values=dict(zip(equations.unknowns, root.box, strict=True)),
        radius=radius_of(document),
        root=root,
        orders=orders,
        signs=None if signs is None else tuple(map(tuple, signs.values())),
        blocks=prove_blocks(Target.of(document, root.record))
        if "starting" in document
        else Blocks(),
    )


def _claimed(document: Mapping[str, Any]) -> tuple[tuple[int, bool], ...]:
    """Return the orders that a file claims, each with whether it is on second-order systems."""
    claims = document.get("claims", {})
    order = max(claims.get(x, 0) for x in (ORDER.key, ORDER_IDENTITY.key))
    nystrom = 0 if document["class"] == "sweep" else claims.get(NYSTROM_ORDER.key, 0)
    return tuple(x for x in ((order, False), (nystrom, True)) if x[0])


def members_of(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the trees that a proof of the method names: those that count, or the free ones.

    Raises
    ------
    DataError
        Where the file names a principal part that is not free.
    """
    orders = sorted(_claimed(document), key=lambda x: x[0], reverse=True)
    if document["class"] != "sweep":
        return {"trees": "nystrom" if orders and orders[0][1] else "all"}
    given: dict[int, tuple[str, ...]] = {}
    for t in map(parse_tree, document.get("enclosure", {}).get("xi", {})):
        given[t.order] = (*given.get(t.order, ()), str(t))
    named = {"free": {str(n): list(texts) for n, texts in given.items()}}
    found = _read(document, named)  # its stage order says what is free
    orders_of = range(2, max([found.order, *(order + 1 for order, _ in orders)]) + 1, 2)
    free = {n: free_trees(n, found.q, given.get(n, ())) for n in orders_of}
    return {"free": {str(n): list(texts) for n, texts in free.items() if texts}}


def conditions_of(document: Mapping[str, Any]) -> Any:
    """Return the equations of a file as the judge reads them, as many as there may be.

    Raises
    ------
    DataError
        Where they have no meaning, or are not what the theorems suppose.
    """
    return _read(document, members_of(document))


def gaps_of(document: Mapping[str, Any]) -> Callable[[Sequence[Any]], list[Any]]:
    """Return left minus right of each equation of a file, a function over any scalars."""
    return over_scalars(conditions_of(document).residuals)


def _check_orders(orders: Sequence[tuple[int, bool]], equations: Any) -> None:
    """Check that the equations give all conditions up to the orders that the file claims.

    Raises
    ------
    DataError
        Where equations are missing.
    """
    pair, q = len(equations.halves) == 2, getattr(equations, "q", 1)
    for order, nystrom in orders:
        for n in range(1, order + 1):
            if not equations.gives_order(n, nystrom, None, None):
                wanted = one_of_each(n, nystrom=nystrom) if pair else representatives(n, q)
                raise DataError(
                    f"the equations of the file do not give the conditions of order {n}; those of "
                    f"{', '.join(wanted)} would (at stage order {q})"
                )


def _radius_text(document: Mapping[str, Any]) -> Any:
    return document.get("enclosure", {}).get("radius", "1e-60")


def radius_of(document: Mapping[str, Any]) -> Fraction:
    """Return the radius of the box of the interval test of a file.

    Raises
    ------
    DataError
        For anything but a decimal from 1e-999 to 1e-60.
    """
    text = _radius_text(document)
    if not isinstance(text, str) or not _RADIUS.fullmatch(text):
        raise DataError(f"`enclosure.radius` must be a number such as '1e-60', got {shown(text)}")
    radius = Fraction(text)
    if not 0 < radius <= Fraction(1, 10**60):
        raise DataError(f"`enclosure.radius` must be positive and at most 1e-60, got {shown(text)}")
    return radius


@dataclass(frozen=True)
class Root:
    """The one root of the equations of a file, as the judge encloses it.

    Attributes
    ----------
    enclosed : Any
        The judge's equations with their root; what they imply is asked of them.
    record : Any
        The judge's record of the root, with its method there.
    box : tuple[Ball, ...]
        (n,) balls around the unknowns.
    proof : Mapping[str, Any]
        The proof of the method, as a certificate holds it.
    """

    enclosed: Any
    record: Any
    box: tuple[Ball, ...]
    proof: Mapping[str, Any]


def equations_of(document: Mapping[str, Any], members: Mapping[str, Any]) -> Any:
    """Return the equations of a document as the judge reads them, not solved yet.

    Parameters
    ----------
    document : Mapping[str, Any]
        With an ``enclosure``.
    members : Mapping[str, Any]
        What the proof of the method has besides centre and inverse.

    Raises
    ------
    DataError
        Where they have no meaning, are not as many as the unknowns, or are not what the theorems
        suppose.
    """
    radius_of(document)
    texts, unknowns = document["enclosure"].get("equations", ()), document.get("unknowns", {})
    if not unknowns:
        raise DataError("a file with an `enclosure` must have `unknowns`, and it has none")
    if len(texts) != len(unknowns):
        raise DataError(
            f"`enclosure.equations` must be as many as the unknowns ({len(unknowns)}), "
            f"got {len(texts)}"
        )
    return _read(document, members)


def _read(document: Mapping[str, Any], members: Mapping[str, Any]) -> Any:
    """Return the equations of a document as the judge reads them."""
    proof = {"radius": _radius_text(document), **members}
    with consulted() as judge:
        try:
            return judge.proof.equations_of(json.dumps([about(document), _field(document), proof]))
        except Refused as error:
            raise DataError(f"{document.get('name', 'the file')}: {error}") from error


def _field(document: Mapping[str, Any]) -> dict[str, Any]:
    """Return the field of statements about the root, without the proof of the method."""
    return field_of_decimals("enclosure", texts_of_decimals(document, exact=False).radicals)


def root_of(document: Mapping[str, Any], equations: Any) -> Root:
    """Let the judge enclose the root of the equations near the digits of a file.

    Proposed are a centre with more digits than the file has, and the inverse of the Jacobian.

    Raises
    ------
    ExactnessError
        Where the judge does not find exactly one root within the digits.
    """
    name = document.get("name", "the file")
    with consulted() as judge:
        try:
            found = newton(equations.residuals, equations.published, equations.over_box)
        except (ZeroDivisionError, Undecided) as error:
            _check_satisfied(name, equations)
            raise ExactnessError(f"{name}: the Jacobian is singular near the digits") from error
        proof = {
            "radius": equations.proof["radius"],
            **texts_of(*found),
            **{k: x for k, x in equations.proof.items() if k != "radius"},
        }
        try:
            record = judge.proof.record_of(
                json.dumps([about(document), None, _field(document), proof])
            )
        except Refused as error:
            _check_satisfied(name, equations)
            raise ExactnessError(f"{name}: the root is not enclosed: {error}") from error
        found = record.root
        return Root(found, record, tuple(x.as_ball() for x in found.root), proof)


def _check_satisfied(name: str, equations: Any) -> None:
    """Name the equation that has no solution within the digits, where there is one."""
    half = rational(1, 2 * 10**equations.digits)
    box = [Interval.ends(x - half, x + half) for x in equations.published]
    try:
        residuals = equations.residuals(box)
    except Undecided:  # a number that they divide by may be 0
        return
    for text, x in zip(equations.texts, residuals, strict=True):
        if isinstance(x, Interval) and not x.holds_zero():
            raise ExactnessError(
                f"{name}: the equation {text!r} is not satisfied within the published digits"
            )
