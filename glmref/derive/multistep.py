r"""Explicit symmetric partitioned multistep methods in one-step form, with their starts, exactly.

Each half of a method is a linear multistep formula on a staggered grid,

    rho_q(E) q_{n+1/2} = h E sigma_q(E) f(p_n),    rho_p(E) p_n = h E^{1/2} sigma_p(E) k(q_{n+1/2}),

with rho(z) = (z - 1) prod_j (z^2 - 2 c_j z + 1), a simple root 1 and m pairs on the unit circle,
and sigma palindromic of degree 2 m. One step evaluates f and k once each. Partial fractions give
the values that are carried: one for the root 1, and x_j, x'_j with ``x_j <- 2 c_j x_j - x'_j +
h f``, ``x'_j <- x_j`` for each pair, so that the entries of V are 0, 1, -1 and the numbers 2 c_j:
its eigenvalues stay on the unit circle however 2 c_j is rounded, for the determinant of each block
is 1.

Two kinds are built with one evaluation of the force k a step, and one with two:

*Separable systems*, q' = f(p), p' = k(q): both halves have pairs, and no root but 1 is common. Then
no parasitic growth of first order exists, for any T and V. With m pairs each the order is 2 m + 2.

*Second-order systems*, q' = M^-1 p: q is the plain sum, rho_q = z - 1, and sigma_p is such that the
whole is the symmetric multistep method (z - 1)^2 prod_j (z^2 - 2 c_j z + 1) of order 2 m + 2.

*Second-order systems, two kicks*: the forces at the ends and in the middle of a step are added to
the values of p, and q is moved between. See :class:`TwoKicks`.

With one kick the weights follow from the cosines by one linear system each. With x = log z, a half
with pairs is, in the middle between two evaluations,

    1/(2 sinh(x/2)) + sum_j alpha_j 2 sinh(x/2) / (2 cosh x - 2 c_j) = T(x) + O(x^{2 m + 1}),

T = 1/x for separable systems, 2 sinh(x/2)/x^2 for second-order ones: the rows x, x^3, ..,
x^{2 m - 1}. With error constants, T (1 + C x^{2 m} + C' x^{2 m - 2} + ..) stands in place of T: the
order is less by two for each, and the error may vanish at frequencies other than 0. At the time of
an evaluation, where the step ends and half of the update has been made, its value is

    coth(x/2)/2 + sum_j beta_j sinh x / (2 cosh x - 2 c_j) = 1/x + O(x^{2 m + 1}).

The step so begins and ends between two halves of one update: the word of the stages is P Q P or
Q P Q, the same backwards, and the solution is a functional of the values, of full order.

*Start.* The values x_j are ``g(h D) h y'`` with the series g of the fractions above. The
derivatives come from a formula on 2 m + 3 points ``t + i h``, whose values are computed by Picard
iteration: each round interpolates what it knows, integrates, and gains two orders with two points
more. The first value is chosen so that the solution is the initial value.

References
----------
    Quinlan and Tremaine, Astron. J. 100 (1990), 1694-1700; Hairer, Lubich, Wanner, "Geometric
    Numerical Integration" (2006), chapter XV; Console and Hairer, "Long-term stability of symmetric
    partitioned linear multistep methods", Lecture Notes in Mathematics 2082 (2014), 1-37.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any, ClassVar

from ..errors import UsageError
from .halves import (
    EndedHalf,
    Series,
    check_cosines,
    dot,
    even_odd,
    exponential,
    integrals,
    pair_series,
    quotient,
    ring_points,
    row_times,
    series_product,
    solve,
    turning,
    value_weights,
)

#: Distance of the points of the starting method, in steps, with one and with two kicks.
SPACING, TWO_KICK_SPACING = Fraction(1), Fraction(1, 2)


def _fit(
    columns: list[Series], target: Series, main: Series, powers: Sequence[int]
) -> list[Fraction]:
    """Return the weights of the columns with which ``main`` is the target, power by power."""
    rows = [[column[k] for column in columns] for k in powers]
    return solve(rows, [target[k] - main[k] for k in powers])


@dataclass(frozen=True)
class Half(EndedHalf):
    """One half of a method: the values end a step in the middle of an update, or between two."""

    explicit: bool = False
    second: bool = False  #: Whether the sum of the other half is folded in (second-order systems).
    constants: tuple[Fraction, ...] = ()  #: C_{2m}, C_{2m-2}, .. of the error, at most m of them.
    least: ClassVar[int] = 0

    @cached_property
    def stage(self) -> list[Fraction]:
        """The stage from the values after the update: (r,)."""
        n, half = 2 * len(self.cosines) + 2, Fraction(1, 2)
        one, zero = [Fraction(1), *[Fraction(0)] * n], [Fraction(0)]
        sinh = even_odd(half, n + 2, 1)[1:]
        # all times x, so that they are power series
        pairs = [quotient(even_odd(half, n, 1), pair_series(c, n)) for c in self.cosines]
        error = one[:]
        for j, constant in enumerate(self.constants):
            error[2 * (len(self.cosines) - j)] = constant
        target = series_product(sinh if self.second else one, error)
        alpha = _fit([zero + x for x in pairs], target, quotient(one, sinh), range(2, n, 2))
        return [Fraction(1), *[s * a for a in alpha for s in (1, -1)]]

    def between(self, length: int) -> list[Series]:
        """Return the values but the first in the middle between two evaluations, as series."""
        half = Fraction(1, 2)
        return self.pair_values(exponential(half, length), exponential(-half, length))


class TwoKicks:
    """A half with two kicks in a step, for q' = M^-1 p: weights and series.

    The step has length 1. Kicks at its ends, half of each belonging to it, add (1, 0) to the values
    x, x' of a pair and the weight w to the sum; the kick in the middle, s_j (1 + 2 c_j, 1) and 1 -
    w. The pairs are turned by V_j = [[2 c_j, -1], [1, 0]] from end to end, with different cosines
    c_j in (-1, 1). Each kick is its own mirror image: with L = [[1, -2 c_j], [0, -1]] L V L is the
    inverse of V, L leaves (1, 0) as it is, and L V^-1 the kick in the middle. So the step reads the
    same backwards.

    q is moved by h phi y to the second kick, y the values after the half of the first, and by h phi
    L y to the end, y the values before the half of the last. phi is a_j (1, d_j) for each pair, d_j
    its slope. The values being affine in s_j, the powers x, .., x^{2 m + 1} of exp(x/2) - 1, the
    forces being x^2 exp(t x), are linear equations for a_j and a_j s_j. In the two drifts together
    x^{2 m + 2} cancels. The velocity, in the middle of the first kick, is as with one kick. So the
    order is 2 m + 2 for all c_j, d_j and w. Two steps of the method with one kick and the cosines
    e_j are c_j = 2 e_j^2 - 1, d_j = 1 - 2 e_j, w = 1/2. (With s_j as free numbers instead, changes
    of 1e-5 change phi by a fourth.)
    """

    def __init__(
        self, cosines: Sequence[Fraction], slopes: Sequence[Fraction], weight: Fraction
    ) -> None:
        check_cosines(cosines, least=0)
        if len(slopes) != len(cosines):
            raise UsageError("each cosine needs one slope of the first drift")
        self.cosines, self.slopes, self.weight = tuple(cosines), tuple(slopes), weight
        m = self.m = len(self.cosines)
        n = 2 * m + 6
        zero, one, half = Fraction(0), Fraction(1), Fraction(1, 2)
        self.V = turning(self.cosines)
        # values over h k in the middle of the first kick: (E - V)^-1 of what the kicks add
        step, middle = exponential(one, n), exponential(half, n)
        added = [weight * (x + (k == 0)) / 2 for k, x in enumerate(step)]
        added = [x + (1 - weight) * y for x, y in zip(added, middle, strict=True)]
        sums = quotient(added, [*step[1:], zero])  # times x, the last power unknown
        alone: list[tuple[Series, Series]] = []  # by the first kick, by the second with s_j = 1
        other: list[tuple[Series, Series]] = []
        for c in self.cosines:
            both = [x / 2 + c * (k == 0) for k, x in enumerate(step)]
            alone.append(self._pair(c, both, [half * (k == 0) for k in range(n)]))
            other.append(self._pair(c, [(1 + 2 * c) * x for x in middle], middle))
        columns = []
        for (u, u_), (v, v_), d in zip(alone, other, self.slopes, strict=True):
            kicked = [
                half * (k == 0) + x + d * y for k, (x, y) in enumerate(zip(u, u_, strict=True))
            ]
            columns += [kicked, [x + d * y for x, y in zip(v, v_, strict=True)]]
        columns = [[zero, *column[:-1]] for column in columns]  # times x, as the sums
        target = exponential(half, n + 1)[1:]
        known = [(x + weight / 2 * (k == 1)) / 2 for k, x in enumerate(sums)]
        found = _fit(columns, target, known, range(1, 2 * m + 1))
        if not all(found[::2]):
            raise UsageError("these numbers determine no method: a pair is not read")
        seconds = [b / a for a, b in zip(found[::2], found[1::2], strict=True)]
        #: of the first drift, over its length: (r,)
        self.phi = [one]
        for a, d in zip(found[::2], self.slopes, strict=True):
            self.phi += [2 * a, 2 * a * d]
        self.first, self.second = [weight], [1 - weight]
        self.rows: list[Series] = []
        for c, s, own, more in zip(self.cosines, seconds, alone, other, strict=True):
            self.first += [one, zero]
            self.second += [s * (1 + 2 * c), s]
            self.rows += [
                [x + s * y for x, y in zip(*row, strict=True)]
                for row in zip(own, more, strict=True)
            ]
        even = [
            [zero, *(x - c * y for x, y in zip(*self.rows[2 * j : 2 * j + 2], strict=True))][:n]
            for j, c in enumerate(self.cosines)
        ]
        unit = [one, *[zero] * (n - 1)]
        beta = _fit(even, unit, sums, range(2, 2 * m + 1, 2))
        weights = zip(beta, self.cosines, strict=True)
        #: the velocity from the values in the middle of the first kick, (r,)
        self.U = [one, *(x for b, c in weights for x in (b, -b * c))]

    @staticmethod
    def _pair(c: Fraction, u: Series, u_: Series) -> tuple[Series, Series]:
        """Return (E - V)^-1 of two series, V the block of a pair."""
        step = exponential(Fraction(1), len(u))
        determinant = [x * 2**k - 2 * c * x + (k == 0) for k, x in enumerate(step)]
        upper = [x - y for x, y in zip(series_product(step, u), u_, strict=True)]
        lower = [x + y - 2 * c * z for x, y, z in zip(u, series_product(step, u_), u_, strict=True)]
        return quotient(upper, determinant), quotient(lower, determinant)

    def values(self, length: int) -> list[Series]:
        """Return the values but the first at the ends of the step as series, times h y'."""
        return [row[:length] for row in self.rows]

    def blocks(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return (A, U, B, V, output) of the halves q and p, of which the stages are Q P Q P Q."""
        zero, one, half = Fraction(0), Fraction(1), Fraction(1, 2)
        back = [one]  # phi L
        for j, c in enumerate(self.cosines):
            a, b = self.phi[2 * j + 1 : 2 * j + 3]
            back += [a, -2 * c * a - b]
        turned = [x / 2 for x in _apply(self.V, self.first)]
        ended = [x / 2 for x in self.first]
        q = {
            "A": [[zero, zero], [half, zero], [half, half]],
            "U": [[one]] * 3,
            "B": [[half, half]],
            "V": [[one]],
            "output": [one],
        }
        p = {
            "A": [[dot(self.phi, ended), zero, zero],
                  [dot(back, turned), dot(back, self.second), zero]],
            "U": [self.phi, row_times(back, self.V)],
            "B": [list(row) for row in zip(turned, self.second, ended, strict=True)],
            "V": self.V,
            "output": self.U,
        }  # fmt: skip
        return q, p


def _start(
    halves: dict[str, Half | TwoKicks], ended: Half | TwoKicks, rounds: int, spacing: Fraction
) -> dict[str, Any]:
    """Return the starting method, see the module.

    ``ended`` is the half that is cut in the middle of an update.

    Stage 0 of either kind is the point itself. Round r knows Q at the points of ring r + 1 and P at
    those of ring r, to order 2 r + 1 and 2 r.
    """
    zero = Fraction(0)
    Q: list[tuple[Fraction, dict[int, Fraction]]] = [(zero, {})]
    P: list[tuple[Fraction, dict[int, Fraction]]] = [(zero, {})]

    def add(to: list, nodes: list[int], of: list, ring: int) -> list[int]:
        first = len(to)
        abscissae = [of[i][0] for i in nodes]
        for c in ring_points(ring, spacing):
            to.append((c, dict(zip(nodes, integrals(abscissae, c), strict=True))))
        return [0, *range(first, len(to))]

    at_P, at_Q = [0], [0]
    for r in range(rounds):
        at_Q = add(Q, at_P, P, r + 1)
        at_P = add(P, at_Q, Q, r + 1)

    def matrix(rows: list, columns: int) -> list[list[Fraction]]:
        return [[row.get(j, zero) for j in range(columns)] for _, row in rows]

    def weights(
        half: Half | TwoKicks, nodes: list[int], of: list
    ) -> tuple[list, list[list[Fraction]]]:
        points, n = [c for c, _ in of], len(nodes)
        if isinstance(half, Half) and half is not ended:
            return value_weights(half.between(n), half.stage, points, nodes)
        return value_weights(half.values(n), half.U, points, nodes)

    u, B = weights(halves["q"], at_P, P)
    u_hat, B_hat = weights(halves["p"], at_Q, Q)
    return {
        "name": f"Picard iteration on {2 * rounds + 1} points, {rounds} rounds",
        "kind": "runge-kutta",
        "A": matrix(Q, len(P)), "B": B, "A_hat": matrix(P, len(Q)), "B_hat": B_hat,
        "u": u, "u_hat": u_hat,
    }  # fmt: skip


def _apply(V: list[list[Fraction]], column: Sequence[Fraction]) -> list[Fraction]:
    return [dot(row, column) for row in V]


def _halves(outer: Half, inner: Half) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return both halves (A, U, B, V, output): evaluated once, and evaluated at both ends.

    ``outer`` holds the values that the evaluations at both ends of the step update, by half each;
    its stage is in the middle. ``inner`` holds the others, which the stages at the ends read.
    """
    middle = {
        **outer.block(),
        "A": [[dot(outer.stage, outer.entry) / 2, Fraction(0)]],
        "U": [outer.stage],
    }
    ends = {
        "A": [[Fraction(0)], [dot(inner.stage, inner.entry)]],
        "U": [inner.stage, row_times(inner.stage, inner.V)],
        "B": [[x] for x in inner.entry],
        "V": inner.V,
        "output": inner.stage,
    }
    return middle, ends


def multistep_document(
    name: str,
    q: Sequence[Fraction],
    p: Sequence[Fraction],
    *,
    title: str = "",
    constants: Sequence[Fraction] = (),
) -> dict[str, Any]:
    """Build a method and its start, exact, without claims and source.

    ``q`` and ``p`` are the cosines of the pairs of roots of the two halves. With pairs in both
    halves, as many and different, the method is for separable systems and its word is P Q P; with
    none in q it is for second-order systems and its word is Q P Q. These may have error constants,
    as many as pairs or fewer.

    Raises
    ------
    UsageError
        For cosines or constants that no method of these kinds has.
    """
    second = not q
    if not p or (q and (len(q) != len(p) or set(q) & set(p))):
        raise UsageError(
            "`p` needs at least one cosine, and `q` none or as many, all different from those "
            "of `p`"
        )
    if constants and (not second or len(constants) > len(p)):
        raise UsageError(
            "error constants are for second-order systems, without `q`, and at most as many as the "
            f"cosines of `p`, got {len(constants)}"
        )
    if constants and not constants[-1]:
        raise UsageError("the last error constant must not be 0: leave it away")
    half_q, half_p = Half(tuple(q)), Half(tuple(p), second=second, constants=tuple(constants))
    rounds = len(p) + 1
    ended, other = (half_p, half_q) if second else (half_q, half_p)
    middle, ends = _halves(ended, other)
    block_q, block_p = (ends, middle) if second else (middle, ends)
    start = _start({"q": half_q, "p": half_p}, ended, rounds, SPACING)
    order = 2 if second else 2 * rounds
    return partitioned(name, title, block_q, block_p, start, order, separable=True)


def two_kick_document(name: str, half: TwoKicks, *, title: str = "") -> dict[str, Any]:
    """Build a method with two kicks and its start, exact, without claims and source."""
    q, p = half.blocks()
    rounds = half.m + 1
    start = _start({"q": Half(()), "p": half}, half, rounds, TWO_KICK_SPACING)
    return partitioned(name, title, q, p, start, 2, separable=True)


def written(value: Any) -> Any:
    """Return the document with its fractions as text."""
    if isinstance(value, Fraction):
        return str(value)
    if isinstance(value, dict):
        return {key: written(x) for key, x in value.items()}
    return [written(x) for x in value] if isinstance(value, list | tuple) else value


def partitioned(
    name: str, title: str, q: Mapping[str, Any], p: Mapping[str, Any], start: Mapping[str, Any],
    order: int, *, separable: bool = False,
) -> dict[str, Any]:  # fmt: skip
    """Return the document of two blocks and a start of an order."""
    return written({
        "format": "glmref-method-1",
        "name": name,
        "title": title,
        "class": "partitioned",
        **({"separable": True} if separable else {}),
        "q": q,
        "p": p,
        "starting": {**start, "order": order},
    })  # fmt: skip
