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
x^{2 m - 1}. At the time of an evaluation, where the step ends and half of the update has been made,
its value is

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
from fractions import Fraction
from typing import Any

from ..errors import ExactnessError, UsageError
from ..exact import Exact, linalg

#: Distance of the points of the starting method, in steps, with one and with two kicks.
SPACING, TWO_KICK_SPACING = Fraction(1), Fraction(1, 2)

Series = list[Fraction]


def factorial(n: int) -> int:
    """Return n!."""
    return 1 if n < 2 else n * factorial(n - 1)


def _product(a: Series, b: Series) -> Series:
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
    ExactnessError
        When it is singular.
    """
    exact = linalg.solve(
        tuple(tuple(Exact(x) for x in row) for row in rows), tuple((Exact(x),) for x in right)
    )
    return [_fraction(row[0]) for row in exact]


def _fraction(x: Any) -> Fraction:
    found = x.as_fraction()
    assert found is not None  # rational equations have rational solutions
    return found


class Half:
    """One half of a method: its roots, its weights and the series of its values.

    The cosines c_1, .., c_m of the pairs of roots differ and lie in (-1, 1); ``second`` says
    whether the sum of the other half is folded in (second-order systems).
    """

    def __init__(self, cosines: Sequence[Fraction], *, second: bool = False) -> None:
        if len(set(cosines)) < len(cosines) or any(not -1 < c < 1 for c in cosines):
            raise UsageError("the cosines of a half must be different and lie between -1 and 1")
        self.cosines = tuple(cosines)
        self.m = len(self.cosines)
        n = self.length = 2 * self.m + 6
        half = Fraction(1, 2)
        self.sinh = even_odd(half, n, 1)
        self.pairs = [pair_series(c, n) for c in self.cosines]
        one = [Fraction(1), *[Fraction(0)] * (n - 1)]
        # all times x, so that they are power series
        main = quotient(one, [*self.sinh[1:], Fraction(0)])
        target = [*self.sinh[1:], Fraction(0)] if second else one
        mids = [[Fraction(0), *quotient(self.sinh, p)[:-1]] for p in self.pairs]
        self.alpha = self._fit(mids, target, main)
        cosh = even_odd(half, n, 0)
        ends = [
            [Fraction(0), *(x / 2 for x in quotient(even_odd(Fraction(1), n, 1), p)[:-1])]
            for p in self.pairs
        ]
        self.beta = self._fit(ends, one, _product([x / 2 for x in cosh], main))

    def _fit(self, columns: list[Series], target: Series, main: Series) -> list[Fraction]:
        if not self.m:
            return []
        powers = range(2, 2 * self.m + 1, 2)
        rows = [[column[k] for column in columns] for k in powers]
        return solve(rows, [target[k] - main[k] for k in powers])

    @property
    def V(self) -> list[list[Fraction]]:
        """(r, r), r = 2 m + 1."""
        return turning(self.cosines)

    @property
    def entry(self) -> list[Fraction]:
        """What one evaluation is added to: (r,)."""
        return [Fraction(1), *[Fraction(x) for x in (1, 0) * self.m]]

    @property
    def stage(self) -> list[Fraction]:
        """The stage from the values after the update: (r,)."""
        return [Fraction(1), *[s * a for a in self.alpha for s in (1, -1)]]

    @property
    def solution(self) -> list[Fraction]:
        """The solution from the values between the halves of the update: (r,)."""
        weights = zip(self.beta, self.cosines, strict=True)
        return [Fraction(1), *[x for b, c in weights for x in (b, -b * c)]]

    def series(self, *, ended: bool) -> list[Series]:
        """Return the exact values but the first as series in x = h D, times h y'.

        ``ended`` ones are at the time of an evaluation, half of whose update has been made; the
        others in the middle between two evaluations, the earlier of which has been made.
        """
        n, half = self.length, Fraction(1, 2)
        rows = []
        for pair, c in zip(self.pairs, self.cosines, strict=True):
            later, earlier = exponential(half, n), exponential(-half, n)
            if ended:
                later = [x / 2 for x in even_odd(Fraction(1), n, 1)]
                later[0] += c
                earlier = [Fraction(int(k == 0)) for k in range(n)]
            rows += [quotient(later, pair), quotient(earlier, pair)]
        return rows


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
        if len(set(cosines)) < len(cosines) or any(not -1 < c < 1 for c in cosines):
            raise UsageError("the cosines must be different and lie between -1 and 1")
        if len(slopes) != len(cosines):
            raise UsageError("each cosine needs one slope of the first drift")
        self.cosines, self.slopes, self.weight = tuple(cosines), tuple(slopes), weight
        m = self.m = len(self.cosines)
        n = self.length = 2 * m + 6
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
        found = self._fit(columns, target, known, range(1, 2 * m + 1))
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
        beta = self._fit(even, unit, sums, range(2, 2 * m + 1, 2))
        weights = zip(beta, self.cosines, strict=True)
        #: the velocity from the values in the middle of the first kick, (r,)
        self.solution = [one, *(x for b, c in weights for x in (b, -b * c))]

    @staticmethod
    def _pair(c: Fraction, u: Series, u_: Series) -> tuple[Series, Series]:
        """Return (E - V)^-1 of two series, V the block of a pair."""
        step = exponential(Fraction(1), len(u))
        determinant = [x * 2**k - 2 * c * x + (k == 0) for k, x in enumerate(step)]
        upper = [x - y for x, y in zip(_product(step, u), u_, strict=True)]
        lower = [x + y - 2 * c * z for x, y, z in zip(u, _product(step, u_), u_, strict=True)]
        return quotient(upper, determinant), quotient(lower, determinant)

    @staticmethod
    def _fit(
        columns: list[Series], target: Series, main: Series, powers: Sequence[int]
    ) -> list[Fraction]:
        rows = [[column[k] for column in columns] for k in powers]
        try:
            return solve(rows, [target[k] - main[k] for k in powers])
        except ExactnessError:
            raise UsageError("these numbers determine no method: a drift is singular") from None

    def series(self, *, ended: bool) -> list[Series]:
        """Return the exact values but the first at the ends of the step, times h y'.

        Only the exact case is defined: ``ended`` must be true.
        """
        assert ended
        return self.rows

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
            "U": [self.phi, _times(back, self.V)],
            "B": [list(row) for row in zip(turned, self.second, ended, strict=True)],
            "V": self.V,
            "output": self.solution,
        }  # fmt: skip
        return q, p


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
        functional = half.stage if isinstance(half, Half) and half is not ended else half.solution
        points = [c for c, _ in of]
        return value_weights(half.series(ended=half is ended), functional, points, nodes)

    u, B = weights(halves["q"], at_P, P)
    u_hat, B_hat = weights(halves["p"], at_Q, Q)
    return {
        "name": f"Picard iteration on {2 * rounds + 1} points, {rounds} rounds",
        "kind": "runge-kutta",
        "A": matrix(Q, len(P)), "B": B, "A_hat": matrix(P, len(Q)), "B_hat": B_hat,
        "u": u, "u_hat": u_hat,
    }  # fmt: skip


def _times(row: Sequence[Fraction], V: list[list[Fraction]]) -> list[Fraction]:
    return [dot(row, column) for column in zip(*V, strict=True)]


def _apply(V: list[list[Fraction]], column: Sequence[Fraction]) -> list[Fraction]:
    return [dot(row, column) for row in V]


def _halves(outer: Half, inner: Half) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return both halves (A, U, B, V, output): evaluated once, and evaluated at both ends.

    ``outer`` holds the values that the evaluations at both ends of the step update, by half each;
    its stage is in the middle. ``inner`` holds the others, which the stages at the ends read.
    """
    half = Fraction(1, 2)
    middle = {
        "A": [
            [
                half * dot(outer.stage, outer.entry),
                Fraction(0),
            ]
        ],
        "U": [outer.stage],
        "B": [
            [half * x, half * y]
            for x, y in zip(_apply(outer.V, outer.entry), outer.entry, strict=True)
        ],
        "V": outer.V,
        "output": outer.solution,
    }
    ends = {
        "A": [
            [Fraction(0)],
            [dot(inner.stage, inner.entry)],
        ],
        "U": [inner.stage, _times(inner.stage, inner.V)],
        "B": [[x] for x in inner.entry],
        "V": inner.V,
        "output": inner.stage,
    }
    return middle, ends


def multistep_document(
    name: str, q: Sequence[Fraction], p: Sequence[Fraction], *, title: str = ""
) -> dict[str, Any]:
    """Build a method and its start, exact, without claims and source.

    ``q`` and ``p`` are the cosines of the pairs of roots of the two halves. With pairs in both
    halves, as many and different, the method is for separable systems and its word is P Q P; with
    none in q it is for second-order systems and its word is Q P Q.

    Raises
    ------
    UsageError
        For cosines that no method of these kinds has.
    """
    second = not q
    if not p or (q and (len(q) != len(p) or set(q) & set(p))):
        raise UsageError(
            "`p` needs at least one cosine, and `q` none or as many, all different from those "
            "of `p`"
        )
    half_q, half_p = Half(q), Half(p, second=second)
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
    start = _start({"q": Half([]), "p": half}, half, rounds, TWO_KICK_SPACING)
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
