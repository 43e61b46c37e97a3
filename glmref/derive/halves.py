r"""Halves of symmetric multistep methods in one-step form: roots, weights and values, exactly.

A half is a linear multistep formula ``rho(E) y_n = h sigma(E) f_n``, with

    rho(z) = (z - 1) prod_j (z^2 - 2 c_j z + 1), times z + 1 where -1 is a root,

and sigma palindromic.

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

*Semi-separable systems*, q' = f(p), p' = k(q, p). p_n is known before f is evaluated there, so that
the half of q may contain f(p_n) itself: the row ``sum mu = -1`` falls away, and with the same roots
the order is two higher. The residues of q have no part in the growth, because f_q = 0. The values
of both halves are then those in the middle of an update (:class:`EndedHalf`), ``V y + h f/2``, from
which the solution is read without an evaluation: s + h f/2; (2 c v - v' + h f/2, v); -(x + h f/2).
The step begins and ends at the solution, q_n = w y with ``w = (1, 2 mu_j, -2 mu_j c_j, ..,
-mu_{-1})``, so that its two points are one evaluation, and it reads the same backwards.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import factorial
from typing import Any, ClassVar

from ..errors import ExactnessError, UsageError
from ..exact import Exact, linalg

Series = list[Fraction]

_ZERO, _ONE, _HALF = Fraction(0), Fraction(1), Fraction(1, 2)


def series_product(a: Series, b: Series) -> Series:
    """Return the series a b, of the length of a."""
    return [sum((a[i] * b[k - i] for i in range(k + 1)), Fraction(0)) for k in range(len(a))]


def quotient(a: Series, b: Series) -> Series:
    """Return the series a/b, with b[0] not 0, of the length of a."""
    out: Series = []
    for k, x in enumerate(a):
        out.append((x - sum((out[i] * b[k - i] for i in range(k)), Fraction(0))) / b[0])
    return out


def exponential(rate: Fraction, length: int) -> Series:
    """Return exp(rate x)."""
    return [rate**k / factorial(k) for k in range(length)]


def even_odd(rate: Fraction, length: int, parity: int) -> Series:
    """Return 2 cosh(rate x) or 2 sinh(rate x)."""
    return [
        2 * x if k % 2 == parity else Fraction(0) for k, x in enumerate(exponential(rate, length))
    ]


def pair_series(c: Fraction, length: int) -> Series:
    """Return 2 cosh(x) - 2 c, which a pair of roots of the cosine c divides by."""
    first, *rest = even_odd(Fraction(1), length, 0)
    return [first - 2 * c, *rest]


def solve(rows: list[list[Fraction]], right: list[Fraction]) -> list[Fraction]:
    """Solve a square system of rational equations.

    Raises
    ------
    UsageError
        When it is singular.
    """
    left = tuple(tuple(Exact(x) for x in row) for row in rows)
    try:
        exact = linalg.solve(left, tuple((Exact(x),) for x in right)) if rows else ()
    except ExactnessError:
        raise UsageError("these numbers determine no method: equations are singular") from None
    return [_fraction(row[0]) for row in exact]


def _fraction(x: Any) -> Fraction:
    found = x.as_fraction()
    assert found is not None  # rational equations have rational solutions
    return found


def check_cosines(cosines: Sequence[Fraction], *, least: int = 1) -> None:
    """Refuse cosines of pairs of roots that are equal or out of range, or too few.

    Raises
    ------
    UsageError
        For such cosines.
    """
    wrong = len(cosines) < least or len(set(cosines)) < len(cosines)
    if wrong or any(not -1 < c < 1 for c in cosines):
        raise UsageError("the cosines of a half must be different and lie between -1 and 1")


def turning(cosines: Sequence[Fraction]) -> list[list[Fraction]]:
    """Return V, (r, r) with r = 2 m + 1: 1, and a block for each pair."""
    r = 2 * len(cosines) + 1
    V = [[Fraction(int(i == j == 0)) for j in range(r)] for i in range(r)]
    for j, c in enumerate(cosines):
        a = 2 * j + 1
        V[a][a], V[a][a + 1], V[a + 1][a] = 2 * c, Fraction(-1), Fraction(1)
    return V


def dot(a: Sequence[Fraction], b: Sequence[Fraction]) -> Fraction:
    """Return the sum of the products."""
    return sum((x * y for x, y in zip(a, b, strict=True)), Fraction(0))


def row_times(row: Sequence[Fraction], V: Sequence[Sequence[Fraction]]) -> list[Fraction]:
    """Return the row times the matrix."""
    return [dot(row, column) for column in zip(*V, strict=True)]


def integrals(nodes: Sequence[Fraction], point: Fraction) -> list[Fraction]:
    """Return weights at the nodes of the integral from 0 to the point, exact for polynomials."""
    powers = range(len(nodes))
    rows = [[x**k for x in nodes] for k in powers]
    return solve(rows, [point ** (k + 1) / (k + 1) for k in powers])


def ring_points(n: int, spacing: Fraction) -> list[Fraction]:
    """Return the points +-1, .., +-n times the spacing."""
    return [s * i * spacing for i in range(1, n + 1) for s in (1, -1)]


def value_weights(
    series: Sequence[Series], functional: Sequence[Fraction], points: Sequence[Fraction],
    nodes: Sequence[int],
) -> tuple[list[Fraction], list[list[Fraction]]]:  # fmt: skip
    """Return u and B of a start whose stages stand at the points, from slopes at some of them.

    ``series`` are those of the values but the first, which makes ``functional`` of the values, the
    solution, exact.
    """
    zero, powers = Fraction(0), range(len(nodes))
    moments = [[points[i] ** k for i in nodes] for k in powers]
    lines = []
    for row in series:
        solved = solve(moments, [row[k] * factorial(k) for k in powers])
        known = dict(zip(nodes, solved, strict=True))
        lines.append([known.get(j, zero) for j in range(len(points))])
    first = [-dot(functional[1:], column) for column in zip(*lines, strict=True)]
    return [Fraction(1), *[zero] * len(lines)], [first or [zero] * len(points), *lines]


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
    least: ClassVar[int] = 1  #: Fewest pairs of roots.

    def __post_init__(self) -> None:
        check_cosines(self.cosines, least=self.least)

    @property
    def order(self) -> int:
        """The order p."""
        return 2 * len(self.cosines) + 2 * self.minus_one

    @cached_property
    def _columns(self) -> list[Series]:
        """Series in x of what each residue is multiplied by: (m or m + 1) rows."""
        n = self.order + 2
        sinh = even_odd(_ONE, n, 1)
        columns = [quotient(sinh, pair_series(c, n)) for c in self.cosines]
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
        return tuple(solve(rows, right))

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

    def pair_values(self, later: Series, earlier: Series) -> list[Series]:
        """Return the values of the pairs as series, times h y', from two shifts of time."""
        pairs = (pair_series(c, len(later)) for c in self.cosines)
        return [quotient(x, pair) for pair in pairs for x in (later, earlier)]

    def values(self, length: int) -> list[Series]:
        """Return the values but the first as series in x = h D, times h y'."""
        rows = self.pair_values(exponential(_ZERO, length), exponential(-_ONE, length))
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
            "U": [w, row_times(w, self.V)],
            "B": [list(pair) for pair in zip(beginning, ending, strict=True)],
            "V": self.V,
            "output": w,
        }
