"""The interval test: a true solution near the digits, proved, and everything that follows from it.

:func:`krawczyk` is the test itself, for any square system written over jets. :func:`prove`
applies it to a method file of class ``"sweep"`` and says what follows:

1. *The solution.* The system of the file has exactly one root within ``radius`` of its digits, and
   the root lies within one unit of their last place.
2. *G-symplectic*: holds for every value of the unknowns (theorem in :mod:`glmref.method.sweep`);
   V^T G V = G is exact arithmetic.
3. *Symmetric*: holds for every value of the unknowns, since D and X are palindromic as affine
   expressions (same module); the sign pattern, G and V are exact arithmetic.
4. *Order*: the equations of the file vanish at the root, and with 2 and 3 the theorems of
   :mod:`glmref.prove.equations` carry a few trees of odd order to all trees. Whether the
   equations are enough is decided by :mod:`glmref.prove.order_conditions`.
5. *Parasitism-free*: the growth parameter of every eigenvalue of V but 1 is an equation of the
   file.
6. *Explicit stages*: their diagonal entry is an equation of the file.
7. *Start and finish*: :mod:`glmref.prove.starting`.

Redundant to all this, every one of the residuals up to the order is a ball around zero, of width
below :data:`WIDTH`, over the enclosure of the root.

References
----------
    Krawczyk, "Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken", Computing 4
    (1969), 187-201; Moore, Kearfott, Cloud, "Introduction to Interval Analysis" (2009), theorem
    8.2.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from fractions import Fraction
from functools import cache
from typing import Any

from ..catalogue.claims import ORDER, ORDER_IDENTITY
from ..catalogue.strict_json import shown
from ..errors import DataError, ExactnessError
from ..exact import Ball, BallMatrix, Exact, ball, jets, lift, linalg
from ..exact.expression import parse
from ..exact.linalg import Matrix
from ..theory.error_constants import commutator_row
from ..theory.trees import trees
from .classes import representatives
from .equations import Blocks, Series, starting_series
from .order_conditions import covered
from .system import SweepSystem

__all__ = ["Enclosure", "Krawczyk", "Outcome", "is_rounding", "krawczyk", "prove", "radius_of"]

#: Redundant identities are enclosed in balls around zero no wider than this.
WIDTH = 1e-50
_RADIUS = re.compile(r"\d{1,99}(\.\d{1,99})?(e-\d{1,3})?")


class Outcome(StrEnum):
    """What an interval test found in a box."""

    UNIQUE = "one root"
    NONE = "no root"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Krawczyk:
    """Result of the interval test.

    Attributes
    ----------
        outcome: one root in the box (proved), none (proved), or undecided.
        box: (n,) balls. With one root: an enclosure of it, far smaller than the box tested.
        contraction: largest row sum of ``|1 - Y J(box)|``; below 1 where a root was proved.
        witness: one sentence on what decided.
    """

    outcome: Outcome
    box: tuple[Ball, ...]
    contraction: float
    witness: str


def krawczyk(
    function: Callable[[Sequence[Any]], Sequence[Any]],
    centre: Sequence[Ball],
    radius: Fraction,
) -> Krawczyk:
    """Test the box of half-width ``radius`` around a point for a root of a square system.

    With X the box, x its centre and Y an approximate inverse of the Jacobian at x, let
    ``K = x - Y f(x) + (1 - Y f'(X)) (X - x)``. If K lies in the interior of X there is exactly
    one root in X, and it lies in K. If K and X are disjoint, or a component of f(X) excludes
    zero, there is none. Otherwise nothing is said.

    Args:
        function: n values of n unknowns, over jets.
        centre: (n,) balls; their midpoints are the centre.
        radius: half-width, positive.

    Raises
    ------
        DataError: when the system is not square.
    """
    point = [x.real.midpoint() for x in centre]
    size = len(point)
    if not size:
        raise DataError("a file with an `enclosure` must have `unknowns`, and it has none")
    box = tuple(Ball.around(x, radius) for x in point)
    at_point = [lift(x, size) for x in function(jets(point))]
    over_box = [lift(x, size) for x in function(jets(box))]
    if len(at_point) != size:
        raise DataError(
            f"the system must be square, got {len(at_point)} equations in {size} unknowns"
        )
    for k, value in enumerate(over_box):
        if value.value.is_zero() is False:
            sentence = f"equation {k + 1} excludes zero on the box"
            return Krawczyk(Outcome.NONE, box, float("nan"), sentence)
    try:
        at_centre = BallMatrix([x.gradient for x in at_point]).midpoint()
        inverse = at_centre.inverse().midpoint()
    except ExactnessError:
        sentence = "the Jacobian at the centre is singular"
        return Krawczyk(Outcome.UNDECIDED, box, float("inf"), sentence)
    jacobian = BallMatrix([x.gradient for x in over_box])
    slack = (BallMatrix.identity(size) - inverse @ jacobian).rows()
    contraction = max(sum(x.magnitude() for x in row) for row in slack)
    newton = linalg.matvec(inverse.rows(), tuple(x.value for x in at_point))
    spread = linalg.matvec(slack, tuple(x - y for x, y in zip(box, point, strict=True)))
    image = tuple(ball(x - y + z).real for x, y, z in zip(point, newton, spread, strict=True))
    return _compared(box, image, contraction)


def _compared(box: tuple[Ball, ...], image: tuple[Ball, ...], contraction: float) -> Krawczyk:
    """What follows from where the image K lies."""
    for k, (x, y) in enumerate(zip(box, image, strict=True)):
        if not x.overlaps(y):
            sentence = f"the image misses the box in unknown {k + 1}"
            return Krawczyk(Outcome.NONE, box, contraction, sentence)
    for k, (x, y) in enumerate(zip(box, image, strict=True)):
        if not x.contains_interior(y):
            sentence = f"the image is not inside the box in unknown {k + 1}"
            return Krawczyk(Outcome.UNDECIDED, box, contraction, sentence)
    sentence = "the image lies in the interior of the box"
    return Krawczyk(Outcome.UNIQUE, image, contraction, sentence)


@dataclass(frozen=True)
class Enclosure:
    """A proof record: what was proved about the method of a file, and by what.

    Attributes
    ----------
        values: enclosing ball of every unknown, by name; every identity is evaluated with them.
        radius: half-width of the box in which the root is unique.
        contraction: see :class:`Krawczyk`.
        order: the order proved (a lower bound; see ``next_order`` for the upper one).
        started: the claims about the start and the finish that were proved.
        explicit: stages (from 1) whose diagonal entry is zero.
        signs: diagonal of E = V L, the symmetry of the values.
        width: largest magnitude over all residuals up to the order, growth parameters included.
        next_order: largest lower bound of a combination of residuals of the next order that no
            choice of starting method can remove: positive proves that the order is not higher.
    """

    values: Mapping[str, Ball]
    radius: Fraction
    contraction: float
    order: int
    explicit: frozenset[int]
    signs: tuple[int, ...]
    width: float
    next_order: float
    series: Series = field(repr=False)
    blocks: Blocks = field(repr=False)
    started: tuple[str, ...] = ()


def prove(document: Mapping[str, Any]) -> Enclosure:
    """Prove what a file of class ``"sweep"`` with an ``"enclosure"`` claims, from the file alone.

    Args:
        document: the parsed JSON object.

    Raises
    ------
        DataError: when the file asks for more than its equations give.
        ExactnessError: when the interval test does not find exactly one root near the digits.
    """
    system = SweepSystem(document)
    claims = document.get("claims", {})
    order = max(claims.get(ORDER.key, 0), claims.get(ORDER_IDENTITY.key, 0))
    if order < 1:
        raise DataError("a file with an `enclosure` must claim an order of at least 1")
    signs = _checked_signs(system, order)
    root = _root(document, system)
    values = dict(zip(system.unknowns, root.box, strict=True))
    D, X, principal = system.read(values)
    for i, x in enumerate(D):
        if x.is_zero() is not False:
            raise ExactnessError(f"d_{i + 1} may be zero: {x!r}")
    blocks = system.blocks(D, X, explicit=system.explicit)
    series = starting_series(blocks, order + 1, principal, stage_order=system.stage_order)
    growths = [system.growth(e.what, D, X) for e in system.equations if e.kind == "growth"]
    small = [x for t, x in series.residual.items() if t.order <= order] + growths
    small += [row[0] - 1 for row in blocks.U]  # U u = 1
    width = max(ball(x).magnitude() for x in small)
    # one by one: the largest of numbers that are no numbers may be any of the others
    if not all(ball(x).contains_zero() and ball(x).magnitude() < WIDTH for x in small):
        raise ExactnessError(
            f"a redundant condition is not enclosed: the largest residual is {width:.3g}, "
            f"and it must be a ball around zero below {WIDTH}"
        )
    record = Enclosure(
        values=values,
        radius=radius_of(document),
        contraction=root.contraction,
        order=order,
        explicit=system.explicit,
        signs=signs,
        width=width,
        next_order=obstruction(series, order),
        series=series,
        blocks=blocks,
    )
    if "starting" not in document:
        return record
    from .starting import Target, prove_blocks

    return replace(record, started=tuple(prove_blocks(document, Target.of(document, record))))


def _checked_signs(system: SweepSystem, order: int) -> tuple[int, ...]:
    """Diagonal of E = V L of a system whose equations give all conditions up to the order.

    Raises
    ------
        DataError: where it is not symmetric, or equations are missing.
    """
    signs = system.signs()
    if signs is None or signs[0] != 1:
        raise DataError(
            "`D` and `X` must be palindromic up to a sign for each row of X, with V and G to "
            "match: only then do the even orders follow"
        )
    missing = [n for n in range(1, order + 1, 2) if not covered(system, n)]
    if missing:
        raise DataError(
            f"the equations of the file do not give the conditions of order {missing[0]}: at stage "
            f"order {system.stage_order} those of "
            f"{', '.join(map(str, representatives(missing[0], system.stage_order)))} would"
        )
    return signs


def radius_of(document: Mapping[str, Any]) -> Fraction:
    """Radius of the box of the interval test of a file.

    Raises
    ------
        DataError: for anything but a decimal from 1e-999 to 1e-60.
    """
    text = document.get("enclosure", {}).get("radius", "1e-60")
    if not isinstance(text, str) or not _RADIUS.fullmatch(text):
        raise DataError(f"`enclosure.radius` must be a number such as '1e-60', got {shown(text)}")
    radius = Fraction(text)
    if not 0 < radius <= Fraction(1, 10**60):
        raise DataError(f"`enclosure.radius` must be positive and at most 1e-60, got {shown(text)}")
    return radius


def is_rounding(published: Ball, exact: Ball, digits: int) -> bool:
    """Whether digits are those of a number, rounded to nearest, and not of one beside it.

    Args:
        published: ball around the digits. exact: encloses the number. digits: behind the point.
    """
    return Ball.around(published.midpoint(), Fraction(1, 2 * 10**digits)).contains(exact)


def _root(document: Mapping[str, Any], system: SweepSystem) -> Krawczyk:
    """Run the interval test around the digits of the file."""
    digits = document.get("digits", 75)
    texts = [document["unknowns"][name] for name in system.unknowns]
    published = [ball(parse(x, digits=digits)) for x in texts]
    if len(system.equations) != len(texts):
        raise DataError(
            f"`enclosure.equations` must be as many as the unknowns ({len(texts)}), "
            f"got {len(system.equations)}"
        )
    result = krawczyk(system.residuals, published, radius_of(document))
    if result.outcome is not Outcome.UNIQUE:
        raise ExactnessError(
            f"{document.get('name', 'the file')}: the interval test gives {result.outcome!s} "
            f"within {document['enclosure'].get('radius')} of the digits ({result.witness})"
        )
    for name, x, y in zip(system.unknowns, published, result.box, strict=True):
        if not is_rounding(x, y, digits):
            raise ExactnessError(
                f"the root lies further than half a unit of the last digit from `unknowns.{name}`"
            )
    return result


def shift_matrix(order: int) -> Matrix:
    """How residuals at ``order + 1`` change with zeta_1 at ``order``: (trees, trees) rationals.

    A change delta of zeta_1 at the trees of one order adds ``delta(t)`` to R([t]) and takes
    ``ways * delta(kept)`` from R(t') for each way to cut one leaf off t'.
    """
    place = {t: j for j, t in enumerate(trees(order))}
    rows = (commutator_row(t, place) for t in trees(order + 1))
    return tuple(tuple(Exact(row.get(j, 0)) for j in range(len(place))) for row in rows)


def obstruction(series: Series, order: int) -> float:
    """Bound from below what no starting method can remove at ``order + 1``.

    Let S' be any starting method with which the method has order ``order + 1``. It gives order
    ``order`` too, and composing it with the flow over a multiple of h makes its principal part
    agree with ours at the single node. The matrices of :func:`shift_matrix` for the orders 2 to
    ``order - 1`` have full column rank, so it agrees there as well, order by order. At ``order``
    they may differ, by delta; then R + (shift matrix) delta = 0. So n R = 0 for every row n with
    n (shift matrix) = 0, and a ball n R that excludes zero refutes it.

    Returns
    -------
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
    """Rational basis of the rows n with n (shift matrix) = 0, each with its largest entry.

    It is the same for every method of the order.

    Raises
    ------
        ExactnessError: when a shift matrix below the order has not full column rank.
    """
    for n in range(2, order):
        if linalg.rank(shift_matrix(n)) < len(trees(n)):  # pragma: no cover - a theorem
            raise ExactnessError(f"the starting series is not unique at order {n}")
    basis = linalg.nullspace(linalg.transpose(shift_matrix(order)))
    return [(row, max(x.magnitude() for x in row)) for row in basis]
