r"""Explicit symmetric partitioned multistep methods for systems that are not separable, exactly.

For q' = f(q, p), p' = k(q, p) each half is a linear multistep formula,

    rho_q(E) q_n = h sigma_q(E) f(q_n, p_n),    rho_p(E) p_n = h sigma_p(E) k(q_n, p_n),

with rho(z) = (z - 1) prod_j (z^2 - 2 c_j z + 1), times z + 1 in one half at most, and sigma
palindromic with sigma(0) = 0. f and k are evaluated once a step, at the solution (q_n, p_n) itself.
The two rho have the root 1 in common and no other. See :mod:`.halves`.

*Error constant.* With w = 2 cosh x - 2, u_j = 1/(2 - 2 c_j) and n = p/2, C is the coefficient of
w^n in ``-prod (1 + u_j w) G``, with G = 2 tanh(x/2)/x, or sinh(x)/x where -1 is a root: ``rho
G/(z - 1)`` is, but for a factor, the series that sigma breaks off. C is affine in each u_j, so that
one cosine can be chosen with C_q = C_p, exactly, by one division. Then the drift of the energy
begins two powers of h later.

*Start.* The values are functionals ``g(h D) h y'`` of the solution, evaluated on points ``t + c h``
that Picard iteration finds: each level interpolates the slopes of the one before, integrates, and
gains one order. A formula with the nodes 0, x_1, .., x_n, which has degree n, gains another one at
the point c where ``t prod (t - x_i)`` has the integral 0 from 0 to c. This makes x_n a mean of t
over (0, c) where the other nodes lie outside. The first point of a level is of this kind, so that
it is one of the nodes for all the others: level l needs l - 1 points, the last one p - 1. A start
of order p takes 13, 24, 39 and 58 evaluations for p = 6, 8, 10, 12.

References
----------
    Dahlquist, Math. Scand. 4 (1956), 33-53; Hairer, Lubich, Wanner, "Geometric Numerical
    Integration" (2006), chapter XV; Console and Hairer, "Long-term stability of symmetric
    partitioned linear multistep methods", Lecture Notes in Mathematics 2082 (2014), 1-37.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Protocol

from ..errors import UsageError
from .halves import GeneralHalf, Series, integrals, ring_points, value_weights
from .multistep import partitioned

_ZERO, _ONE = Fraction(0), Fraction(1)
#: Of the points of the last level of a start.
_SPACING = Fraction(3, 4)


def matching_cosine(
    half: GeneralHalf, others: Sequence[Fraction], *, minus_one: bool = False
) -> Fraction:
    """Return the cosine that, with the others, makes a half with the error constant of ``half``.

    The error constant C is affine in u = 1/(2 - 2 c): two values of it give the line. ``minus_one``
    says whether -1 is one of the roots.

    Raises
    ------
    UsageError
        When the cosine that has this error constant is not in (-1, 1).
    """

    def constant(u: Fraction) -> Fraction:
        return GeneralHalf((*others, 1 - 1 / (2 * u)), minus_one).error_constant

    free = (Fraction(n, 7) for n in range(2, 9 + len(others)))  # cosines -3/4, -1/6, 1/8, ..
    first, second = [u for u in free if 1 - 1 / (2 * u) not in others][:2]
    low, high = constant(first), constant(second)
    u = first + (half.error_constant - low) * (second - first) / (high - low)
    cosine = 1 - 1 / (2 * u) if u else _ONE
    if not -1 < cosine < 1:
        raise UsageError("no real pair of roots gives the two halves the same error constant")
    return cosine


def gaining(nodes: Sequence[Fraction], point: Fraction) -> Fraction:
    """Return the node that, with 0 and the others, gains the integral up to the point an order.

    It is the mean of t over (0, ``point``) with the weight ``t prod (t - x)``, and lies between
    where no other node does.
    """
    weight = [_ZERO, _ONE]
    for x in nodes:
        weight = [a - x * b for a, b in zip([_ZERO, *weight], [*weight, _ZERO], strict=True)]
    first, second = (
        sum((a * point ** (k + n) / (k + n) for k, a in enumerate(weight)), _ZERO) for n in (1, 2)
    )
    return second / first


def start_levels(order: int) -> list[list[Fraction]]:
    """Return the points but 0 of each level of a start of an even order.

    The first ones, on either side of 0 in turn, grow to 1: the lowest levels have the largest part
    in the error. The others are multiples of it from 2 on, and a node that gains the next level its
    order, between which and 0 none of them lies. Wider last points make the error larger, closer
    ones the weights, which multiply rounding.
    """

    def first(level: int) -> Fraction:
        return Fraction(min(level, 6), 6 if level % 2 else -6)

    levels = [[first(order - 1), *ring_points(order // 2, _SPACING)[2:]]]
    for level in reversed(range(1, order - 1)):
        one = first(level)
        given = [one, *ring_points(level, one)[2:]][: max(level, 2) - 2]
        levels.insert(0, [*given, gaining(given, levels[0][0])])
    return levels


class Formula(Protocol):
    """What a start needs of a linear multistep formula."""

    @property
    def U(self) -> list[Fraction]:
        """The solution from the values."""
        ...

    def values(self, length: int) -> list[Series]:
        """Return the values but the first as series in x = h D, times h y'."""
        ...


def picard_start(q: Formula, p: Formula | None = None, *, order: int) -> dict[str, Any]:
    """Return a start of an even order: Picard iteration, whose stages serve both halves.

    Without ``p`` there is one formula for the whole system.
    """
    points: list[Fraction] = [_ZERO]
    rows: list[dict[int, Fraction]] = [{}]
    nodes = [0]
    levels = start_levels(order)
    for level in levels:
        first = len(points)
        for c in level:
            known = nodes if len(points) == first else [*nodes, first]
            points.append(c)
            weights = integrals([points[i] for i in known], c)
            rows.append(dict(zip(known, weights, strict=True)))
        nodes = [0, *range(first, len(points))]
    n = len(points)
    A = [[row.get(j, _ZERO) for j in range(n)] for row in rows]
    found: dict[str, Any] = {
        "name": f"Picard iteration, {len(levels)} levels, {n} points",
        "kind": "runge-kutta",
    }
    for hat, half in (("", q), ("_hat", p)):
        if half is None:
            continue
        u, B = value_weights(half.values(len(nodes)), half.U, points, nodes)
        found |= {f"A{hat}": A, f"B{hat}": B, f"u{hat}": u}
    return found


def general_document(
    name: str, q: GeneralHalf, p: GeneralHalf, *, title: str = ""
) -> dict[str, Any]:
    """Build a method and its start of the same order, exact, without claims and source.

    Raises
    ------
    UsageError
        For halves of different orders, or with another common root than 1.
    """
    if q.order != p.order:
        raise UsageError(f"the halves have the orders {q.order} and {p.order}: give equal ones")
    if set(q.cosines) & set(p.cosines) or (q.minus_one and p.minus_one):
        raise UsageError("the halves must have no root but 1 in common")
    start = picard_start(q, p, order=q.order)
    return partitioned(name, title, q.block(), p.block(), start, q.order)
