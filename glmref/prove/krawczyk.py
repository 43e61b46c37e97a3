"""The interval test of Krawczyk: a box holds exactly one root of a square system, none, or open.

The system is any function of its unknowns written over jets.

References
----------
    Krawczyk, "Newton-Algorithmen zur Bestimmung von Nullstellen mit Fehlerschranken", Computing 4
    (1969), 187-201; Moore, Kearfott, Cloud, "Introduction to Interval Analysis" (2009), theorem
    8.2.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from typing import Any

from ..errors import DataError, ExactnessError
from ..exact import Ball, BallMatrix, ball, jets, lift, linalg


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
    outcome : Outcome
        One root in the box (proved), none (proved), or undecided.
    box : tuple[Ball, ...]
        (n,) balls. With one root: an enclosure of it, far smaller than the box tested.
    contraction : float
        Largest row sum of ``|1 - Y J(box)|``; below 1 where a root was proved.
    witness : str
        One sentence on what decided.
    inverse : BallMatrix or None
        (n, n) approximate inverse of the Jacobian; ``None`` where no root was proved.
    """

    outcome: Outcome
    box: tuple[Ball, ...]
    contraction: float
    witness: str
    inverse: BallMatrix | None = None


def krawczyk(
    function: Callable[[Sequence[Any]], Sequence[Any]],
    centre: Sequence[Ball],
    radius: Fraction,
) -> Krawczyk:
    """Test the box of half-width ``radius`` around a point for a root of a square system.

    With X the box, x its centre and Y an approximate inverse of the Jacobian there, let
    ``K = x - Y f(x) + (1 - Y f'(X)) (X - x)``. If K lies in the interior of X there is exactly
    one root in X, and it lies in K. If K and X are disjoint, or a component of f(X) excludes
    zero, there is none. Otherwise nothing is said.

    Parameters
    ----------
    function : Callable[[Sequence[Any]], Sequence[Any]]
        n values of n unknowns, over jets.
    centre : Sequence[Ball]
        (n,) balls; their midpoints are the centre.
    radius : Fraction
        Half-width, positive.

    Raises
    ------
    DataError
        When the system is not square.
    """
    point = tuple(x.real.midpoint() for x in centre)
    size = len(point)
    if not size:
        raise DataError("a file with an `enclosure` must have `unknowns`, and it has none")
    box = tuple(Ball.around(x, radius) for x in point)
    over_box = [lift(x, size) for x in function(jets(box))]
    if len(over_box) != size:
        raise DataError(
            f"the system must be square, got {len(over_box)} equations in {size} unknowns"
        )
    for k, value in enumerate(over_box):
        if value.value.is_zero() is False:
            sentence = f"equation {k + 1} excludes zero on the box"
            return Krawczyk(Outcome.NONE, box, float("nan"), sentence)
    jacobian = BallMatrix([x.gradient for x in over_box])
    try:
        inverse = jacobian.midpoint().inverse().midpoint()
    except ExactnessError:
        sentence = "the Jacobian at the centre is singular"
        return Krawczyk(Outcome.UNDECIDED, box, float("inf"), sentence)
    slack = (BallMatrix.identity(size) - inverse @ jacobian).rows()
    contraction = max(sum(x.magnitude() for x in row) for row in slack)
    newton = linalg.matvec(inverse.rows(), tuple(ball(x) for x in function(point)))
    spread = linalg.matvec(slack, tuple(x - y for x, y in zip(box, point, strict=True)))
    image = tuple(ball(x - y + z).real for x, y, z in zip(point, newton, spread, strict=True))
    return replace(_compared(box, image, contraction), inverse=inverse)


def _compared(box: tuple[Ball, ...], image: tuple[Ball, ...], contraction: float) -> Krawczyk:
    """Return what follows from where the image K lies."""
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


def is_rounding(published: Ball, exact: Ball, digits: int) -> bool:
    """Return whether digits are those of a number, rounded to nearest, and not of one beside it."""
    return Ball.around(published.midpoint(), Fraction(1, 2 * 10**digits)).contains(exact)
