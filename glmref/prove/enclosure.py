"""A true solution near the digits of a file, proved, and everything that follows from it.

The judge reads the equations of a file with an ``enclosure`` (``docs/certificates.md``, section 6)
and encloses their root (:func:`root_of`); what is found here is the centre and the inverse that its
interval test needs. :func:`prove` does so for the sweep form, of one component or two (the classes
``sweep``, ``pair-sweep`` and ``splitting``), and adds the start and the finish (:mod:`.starting`).

Redundant to all this, and evaluated on request, every one of the residuals up to the
order is a ball around zero, of width below :data:`WIDTH`, over the enclosure of the root.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache, cached_property
from typing import Any

from ..catalogue.strict_json import shown
from ..errors import DataError, ExactnessError
from ..exact import Ball, Exact, ball, linalg
from ..exact.judging import Fraction as rational
from ..exact.judging import Interval, consulted, newton
from ..exact.linalg import Matrix
from ..judge.refusals import Refused, Undecided
from ..method.sweep import SweepForm
from ..theory.error_constants import commutator_row
from ..theory.trees import Tree, trees
from .classes import Family, plan, representatives
from .equations import Series
from .field import about, field_of_decimals, texts_of_decimals
from .starting import Blocks, Target, prove_blocks, texts_of
from .system import SweepSystem

#: Redundant identities are enclosed in balls around zero no wider than this.
WIDTH = 1e-50
_RADIUS = re.compile(r"\d{1,99}(\.\d{1,99})?(e-\d{1,3})?")


@dataclass(frozen=True)
class Enclosure:
    """A proof record: what was proved about the method of a file, and by what.

    Attributes
    ----------
    values : Mapping[str, Ball]
        Enclosing ball of every unknown, by name; every identity is evaluated with them.
    radius : Fraction
        Half-width of the box in which the root is unique.
    root : Root
        The root of the equations.
    order : int
        The order proved (a lower bound; see ``next_order`` for the upper one).
    nystrom_order : int
        The same on second-order systems; ``order`` for one component.
    blocks : Blocks
        What was proved about the start and the finish.
    signs : tuple[tuple[int, ...], ...] or None
        Diagonal of E = V L, the symmetry of the values, by component; ``None`` for a product of
        flows that is not symmetric.
    system : SweepSystem
        The equations.
    form : SweepForm
        The numbers of the sweep form.
    principal : Mapping[Tree, Any]
        The principal parts that are unknowns.
    """

    values: Mapping[str, Ball]
    radius: Fraction
    root: Root
    order: int
    nystrom_order: int
    signs: tuple[tuple[int, ...], ...] | None
    system: SweepSystem = field(repr=False)
    form: SweepForm = field(repr=False)
    principal: Mapping[Tree, Any] = field(repr=False)
    blocks: Blocks = field(default_factory=Blocks)

    @cached_property
    def series(self) -> tuple[Series, ...]:
        """For each order claimed, in the order of :attr:`~.system.SweepSystem.families`."""
        return tuple(
            self.system.series(self.form, self.principal, order, family=family)
            for order, family in self.system.families
        )

    @cached_property
    def identity(self) -> bool:
        """Whether the first values are the solution itself, to the orders claimed."""
        return all(
            self.root.enclosed.principal_is_zero(order, True, family is Family.SECOND_ORDER)
            for order, family in self.system.families
        )

    @cached_property
    def width(self) -> float:
        """Largest magnitude over all residuals up to the order, growth parameters included.

        Raises
        ------
        ExactnessError
            Where one of them does not vanish.
        """
        return _checked_width(self.system, self.form, self.series)

    @cached_property
    def next_order(self) -> float:
        """Lower bound of what no starting method can remove one order higher (one component).

        Positive, it proves that the order is not higher: see :func:`obstruction`.
        """
        further = self.system.series(self.form, self.principal, self.order + 1)
        return obstruction(further, self.order)


def prove(document: Mapping[str, Any]) -> Enclosure:
    """Prove what a file with an ``"enclosure"`` claims, from the file alone.

    Parameters
    ----------
    document : Mapping[str, Any]
        The parsed JSON object, of a class that :mod:`glmref.prove.system` reads.

    Raises
    ------
    DataError
        When the file asks for more than its equations give.
    ExactnessError
        When the interval test does not find exactly one root near the digits.
    """
    system = SweepSystem(document)
    if not system.families:
        raise DataError("a file with an `enclosure` must claim an order of at least 1")
    if system.signs() is None and not (system.is_partitioned and system.is_one_step):
        names = "`b`, `c`, `w`, `v` and `stages`" if system.is_partitioned else "`D` and `X`"
        raise DataError(
            f"{names} must be palindromic up to a sign for each row of X, with V and G to match: "
            f"only then do the even orders follow"
        )
    equations = equations_of(document, _members(system))
    _check_orders(system, equations)
    root = root_of(document, equations)
    values = dict(zip(system.unknowns, root.box, strict=True))
    form, principal = system.read(values)
    form = replace(form, explicit=system.explicit)
    signs = equations.signs
    record = Enclosure(
        values=values,
        radius=radius_of(document),
        root=root,
        order=system.claimed,
        nystrom_order=max(system.claimed, system.claimed_second_order),
        signs=None if signs is None else tuple(map(tuple, signs.values())),
        system=system,
        form=form,
        principal=principal,
    )
    if "starting" in document:  # not by `replace`, which would drop the series
        blocks = prove_blocks(Target.of(document, root.record))
        object.__setattr__(record, "blocks", blocks)
    return record


def _members(system: SweepSystem) -> dict[str, Any]:
    """Return the trees that a proof of the method names: those that count, or the free ones."""
    if system.is_partitioned:
        return {"trees": "nystrom" if system.family is Family.SECOND_ORDER else "all"}
    free = {}
    for n in range(2, max(system.claimed + 1, system.order) + 1, 2):
        given = tuple(t for t in system.principal if t.order == n)
        found = plan(n, system.stage_order, given).free
        if found:
            free[str(n)] = [str(t) for t in found]
    return {"free": free}


def _check_orders(system: SweepSystem, equations: Any) -> None:
    """Check that the equations give all conditions up to the orders that the file claims.

    Raises
    ------
    DataError
        Where equations are missing.
    """
    for order, family in system.families:
        nystrom = family is Family.SECOND_ORDER
        fine = equations.is_of_the_theorem(False, nystrom, None)
        for n in range(1, order + 1):
            if not (fine and equations.gives_order(n, nystrom, None, None)):
                trees_of = representatives(n, system.stage_order, family)
                raise DataError(
                    f"the equations of the file do not give the conditions of order {n}; those of "
                    f"{', '.join(map(str, trees_of))} would (at stage order {system.stage_order})"
                )


def _checked_width(system: SweepSystem, form: SweepForm, series: Sequence[Series]) -> float:
    """Return the largest magnitude of what the theorems say vanishes.

    Raises
    ------
    ExactnessError
        When it does not.
    """
    small: list[Any] = [
        x
        for (order, _), found in zip(system.families, series, strict=True)
        for t, x in found.residual.items()
        if t.order <= order
    ]
    small += [system.growth(e, form) for e in system.equations if e.kind == "growth"]
    small += [row[0] - 1 for c in form.blocks for row in c.U]  # U u = 1
    width = max(ball(x).magnitude() for x in small)
    # one by one: the largest of numbers that are no numbers may be any of the others
    if not all(ball(x).contains_zero() and ball(x).magnitude() < WIDTH for x in small):
        raise ExactnessError(
            f"a redundant condition is not enclosed: the largest residual is {width:.3g}, "
            f"and it must be a ball around zero below {WIDTH}"
        )
    return width


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


def shift_matrix(order: int) -> Matrix:
    """Return how residuals of ``order + 1`` change with zeta_1 of ``order``: (trees, trees).

    A change delta of zeta_1 at the trees of one order adds ``delta(t)`` to R([t]) and takes
    ``ways * delta(kept)`` from R(t') for each way to cut one leaf off t'.
    """
    place = {t: j for j, t in enumerate(trees(order))}
    rows = (commutator_row(t, place) for t in trees(order + 1))
    return tuple(tuple(Exact(row.get(j, 0)) for j in range(len(place))) for row in rows)


def obstruction(series: Series, order: int) -> float:
    """Return a lower bound of what no starting method can remove at ``order + 1``.

    Let S' be any starting method with which the method has order ``order + 1``. It gives order
    ``order`` too, and composing it with the flow over a multiple of h makes its principal part
    agree with ours at the single node. The matrices of :func:`shift_matrix` for the orders 2 to
    ``order - 1`` have full column rank, so it agrees there as well, order by order. At ``order``
    they may differ, by delta; then R + (shift matrix) delta = 0. So n R = 0 for every row n with
    n (shift matrix) = 0, and a ball n R that excludes zero refutes it.

    Returns
    -------
    float
        The largest lower bound of ``|n R|`` over a rational basis of such rows n, each scaled to
        largest entry 1; 0.0 when nothing was refuted.
    """
    best = 0.0
    residuals = [ball(series.residual[t]) for t in trees(order + 1)]
    for row, size in _annihilators(order):
        best = max(best, ball(linalg.dot(row, residuals)).lower_magnitude() / size)
    return best


@cache
def _annihilators(order: int) -> list[tuple[linalg.Vector, float]]:
    """Return a rational basis of the n with n (shift matrix) = 0, each with its largest entry.

    It is the same for every method of the order.

    Raises
    ------
    ExactnessError
        When a shift matrix below the order has not full column rank.
    """
    for n in range(2, order):
        if linalg.rank(shift_matrix(n)) < len(trees(n)):  # pragma: no cover - a theorem
            raise ExactnessError(f"the starting series is not unique at order {n}")
    basis = linalg.nullspace(linalg.transpose(shift_matrix(order)))
    return [(row, max(x.magnitude() for x in row)) for row in basis]
