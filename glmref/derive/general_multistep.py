r"""Explicit symmetric partitioned multistep methods for systems that are not separable, exactly.

For q' = f(q, p), p' = k(q, p) each half is a linear multistep formula,

    rho_q(E) q_n = h sigma_q(E) f(q_n, p_n),    rho_p(E) p_n = h sigma_p(E) k(q_n, p_n),

with rho(z) = (z - 1) prod_j (z^2 - 2 c_j z + 1), times z + 1 in one half at most, and sigma
palindromic with sigma(0) = 0. f and k are evaluated once a step, at the solution (q_n, p_n) itself.
The two rho have the root 1 in common and no other.

*Residues.* With simple roots on the unit circle, ``sigma/rho = sum mu_zeta zeta/(z - zeta)``. The
formula is symmetric where mu_zeta is real and equal at conjugate roots, and explicit where the
value at z = 0, which is -sum mu_zeta, vanishes; mu_1 = 1. So the sum over the other roots is -1.
mu_zeta is also the growth parameter of the half at zeta: a component zeta^n a(t) of q obeys
a' = mu_zeta f_q a + O(h), of p b' = mu_zeta k_p b + O(h).

*Values.* s <- s + h f for the root 1; v_j <- 2 c_j v_j - v'_j + h f, v'_j <- v_j for each pair of
roots; x <- -(x + h f) for the root -1. The stage, and the solution, is
``s + sum 2 mu_j (c_j v_j - v'_j) + mu_{-1} x``.

*Order.* With z = exp(x) the residues are determined by

    coth(x/2)/2 + sum mu_j sinh x/(cosh x - c_j) + mu_{-1} tanh(x/2)/2 = 1/x + C x^{p-1} + ..,

    sum mu_j + mu_{-1}/2 = -1/2.

m pairs have order p = 2 m, and with the root -1 order 2 m + 2. Because the stages are the solution,
the conditions of quadrature are those of all trees of two colours.

*Error constant.* With w = 2 cosh x - 2, u_j = 1/(2 - 2 c_j) and n = p/2, C is the coefficient of
w^n in ``-prod (1 + u_j w) G``, with G = 2 tanh(x/2)/x, or sinh(x)/x where -1 is a root: ``rho
G/(z - 1)`` is, but for a factor, the series that sigma breaks off. C is affine in each u_j, so that
one cosine can be chosen with C_q = C_p, exactly, by one division. Then the drift of the energy
begins two powers of h later.

*Semi-separable systems*, q' = f(p), p' = k(q, p). p_n is known before f is evaluated there, so that
the half of q may contain f(p_n) itself: the row ``sum mu = -1`` falls away, and with the same roots
the order is two higher. The residues of q have no part in the growth, because f_q = 0. The values
of both halves are then those in the middle of an update (:class:`EndedHalf`), ``V y + h f/2``, from
which the solution is read without an evaluation: s + h f/2; (2 c v - v' + h f/2, v); -(x + h f/2).
The step begins and ends at the solution, q_n = w y with ``w = (1, 2 mu_j, -2 mu_j c_j, ..,
-mu_{-1})``, so that its two points are one evaluation, and it reads the same backwards.

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
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

from ..errors import ExactnessError, UsageError
from .multistep import (
    Series,
    dot,
    even_odd,
    exponential,
    integrals,
    pair_series,
    partitioned,
    quotient,
    ring_points,
    solve,
    turning,
    value_weights,
)

_ZERO, _ONE, _HALF = Fraction(0), Fraction(1), Fraction(1, 2)
#: Of the points of the last level of a start.
_SPACING = Fraction(3, 4)


@dataclass(frozen=True)
class GeneralHalf:
    """One half: a linear multistep formula given by its roots.

    Raises
    ------
    UsageError
        For cosines that are equal or out of range, or none.
    """

    cosines: tuple[Fraction, ...]  #: c_1, .., c_m of the pairs of roots, different, in (-1, 1).
    minus_one: bool = False  #: Whether -1 is a root.

    def __post_init__(self) -> None:
        c = self.cosines
        if not c or len(set(c)) < len(c) or any(not -1 < x < 1 for x in c):
            raise UsageError("the cosines of a half must be different and lie between -1 and 1")

    @property
    def order(self) -> int:
        """The order p."""
        return 2 * len(self.cosines) + 2 * self.minus_one

    @cached_property
    def _columns(self) -> list[Series]:
        """Series in x of what each residue is multiplied by: (m or m + 1) rows."""
        n = self.order + 2
        sinh, cosh = even_odd(_ONE, n, 1), even_odd(_ONE, n, 0)
        columns = []
        for c in self.cosines:
            columns.append(quotient(sinh, [cosh[0] - 2 * c, *cosh[1:]]))
        if self.minus_one:
            tanh = quotient(even_odd(_HALF, n, 1), even_odd(_HALF, n, 0))
            columns.append([x / 2 for x in tanh])
        return columns

    @cached_property
    def _principal(self) -> Series:
        """coth(x/2)/2 - 1/x as a series in x."""
        n = self.order + 3
        sinh, cosh = even_odd(_HALF, n, 1), even_odd(_HALF, n, 0)
        return quotient(cosh[:-1], [2 * x for x in sinh[1:]])[1:]

    @cached_property
    def residues(self) -> tuple[Fraction, ...]:
        """mu_1, .., mu_m of the pairs, and mu of the root -1 at the end if there is one."""
        columns, principal = self._columns, self._principal
        weights = [_ONE] * len(self.cosines) + [_HALF] * self.minus_one
        powers = range(1, self.order - 1, 2)
        rows = [[column[k] for column in columns] for k in powers]
        right = [-principal[k] for k in powers]
        if len(rows) < len(columns):  # explicit
            rows, right = [weights, *rows], [-_HALF, *right]
        try:
            return tuple(solve(rows, right))
        except ExactnessError:
            raise UsageError("these cosines determine no method: the equations are singular") from (
                None
            )

    @property
    def error_constant(self) -> Fraction:
        """C, the first coefficient of sigma/rho - 1/x that does not vanish."""
        k = self.order - 1
        terms = zip(self.residues, self._columns, strict=True)
        return self._principal[k] + sum((mu * column[k] for mu, column in terms), _ZERO)

    @property
    def V(self) -> list[list[Fraction]]:
        """(r, r), r = 2 m + 1, or 2 m + 2 with the root -1."""
        V = turning(self.cosines)
        if self.minus_one:
            V = [[*row, _ZERO] for row in V] + [[_ZERO] * len(V) + [-_ONE]]
        return V

    @property
    def U(self) -> list[Fraction]:
        """The stage, and the solution, from the values: (r,)."""
        row = [_ONE]
        for c, mu in zip(self.cosines, self.residues, strict=False):
            row += [2 * mu * c, -2 * mu]
        return row + [self.residues[-1]] * self.minus_one

    @property
    def entry(self) -> list[Fraction]:
        """What an evaluation is added to: (r,)."""
        return [_ONE, *[_ONE, _ZERO] * len(self.cosines)] + [-_ONE] * self.minus_one

    def values(self, length: int) -> list[Series]:
        """Return the values but the first as series in x = h D, times h y'."""
        rows, one = [], [_ONE, *[_ZERO] * (length - 1)]
        for c in self.cosines:
            pair = pair_series(c, length)
            rows += [quotient(one, pair), quotient(exponential(-_ONE, length), pair)]
        if self.minus_one:
            step = exponential(_ONE, length)
            rows.append(quotient([-_ONE, *[_ZERO] * (length - 1)], [step[0] + 1, *step[1:]]))
        return rows

    def block(self) -> dict[str, Any]:
        """Return A, U, B, V and the output."""
        return {
            "A": [[_ZERO]],
            "U": [self.U],
            "B": [[x] for x in self.entry],
            "V": self.V,
            "output": self.U,
        }


@dataclass(frozen=True)
class EndedHalf(GeneralHalf):
    """One half with values in the middle of an update, so that a step ends at the solution."""

    explicit: bool = True  #: Whether q_n, or p_n, does not contain the slope at the same time.

    @property
    def order(self) -> int:
        """The order p."""
        return super().order + 2 * (not self.explicit)

    @property
    def U(self) -> list[Fraction]:
        """The solution from the values: (r,)."""
        row = [_ONE]
        for c, mu in zip(self.cosines, self.residues, strict=False):
            row += [2 * mu, -2 * mu * c]
        return row + [-self.residues[-1]] * self.minus_one

    def values(self, length: int) -> list[Series]:
        """Return the values but the first as series in x = h D, times h y'."""
        rows, one = [], [_ONE, *[_ZERO] * (length - 1)]
        for c in self.cosines:
            pair = pair_series(c, length)
            later = [x / 2 for x in even_odd(_ONE, length, 1)]
            later[0] += c
            rows += [quotient(later, pair), quotient(one, pair)]
        if self.minus_one:
            tanh = quotient(even_odd(_HALF, length, 1), even_odd(_HALF, length, 0))
            rows.append([-x / 2 for x in tanh])
        return rows

    def block(self) -> dict[str, Any]:
        """Return A, U, B, V and the output."""
        w, ending = self.U, [x / 2 for x in self.entry]
        beginning = [dot(row, ending) for row in self.V]
        return {
            "A": [[_ZERO, _ZERO], [dot(w, beginning), dot(w, ending)]],
            "U": [w, [dot(w, column) for column in zip(*self.V, strict=True)]],
            "B": [list(pair) for pair in zip(beginning, ending, strict=True)],
            "V": self.V,
            "output": w,
        }


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


def picard_start(q: GeneralHalf, p: GeneralHalf, order: int) -> dict[str, Any]:
    """Return a start of an even order: Picard iteration, whose stages serve both halves."""
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
    start = picard_start(q, p, q.order)
    return partitioned(name, title, q.block(), p.block(), start, q.order)
