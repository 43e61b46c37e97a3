"""Orders: trees, what a step does to them, and the starting series as a system of equations.

A method is run on trees: xi(t) = A prod xi(children) + U eta(t) are the stages, B prod xi + V eta the
values after the step, which must be the values of the exact solution one step later. Order by order
this is linear in eta, and in what of eta the order before left open. The tree without vertices of a
colour is ``(colour, None)``; eta of it is u.
"""

from collections import defaultdict
from collections.abc import Mapping
from fractions import Fraction
from functools import cache, reduce
from operator import mul

import numpy as np
from mpmath import mp

from .methods import Method, Part, Tree, of_second_order, of_time
from .numbers import Array, Margin, Number, Undecided, array, eye, zeros

#: Trees times (stages squared + values cubed), above which an order is not looked at.
WORK = 150_000


@cache
def trees(palette: tuple[tuple[str, str], ...], n: int) -> tuple[Tree, ...]:
    """Return all trees with n vertices, the children of a colour being those of the palette."""
    return tuple((c, forest) for c, below in palette for forest in _forests(palette, n - 1, below))


@cache
def _forests(palette: tuple[tuple[str, str], ...], n: int, below: str,
             most: tuple[int, Tree] | None = None) -> tuple[tuple[Tree, ...], ...]:  # fmt: skip
    """Return the multisets of trees with n vertices in all, none larger than `most`."""
    if n == 0:
        return ((),)
    found = []
    for size in range(n if most is None else min(n, most[0]), 0, -1):
        for t in trees(palette, size):
            if t[0] in below and (most is None or (size, t) <= most):
                found += [(t, *rest) for rest in _forests(palette, n - size, below, (size, t))]
    return tuple(found)


@cache
def size(t: Tree) -> int:
    return 0 if t[1] is None else 1 + sum(map(size, t[1]))


@cache
def exact(t: Tree) -> Fraction:
    """Return the coefficient of the exact solution, 1 / gamma(t)."""
    return reduce(mul, map(exact, t[1]), Fraction(1, size(t)))


@cache
def cuts(t: Tree) -> tuple[tuple[Tree, Fraction, int], ...]:
    """Return (s, weight, vertices cut) for all ways to cut branches off t, or t from nothing."""
    ways = {(): Fraction(1)}
    for child in t[1]:
        more: dict[tuple[Tree, ...], Fraction] = defaultdict(Fraction)
        for forest, x in ways.items():
            for s, y, _ in cuts(child):
                left = forest if s[1] is None else (*forest, s)
                more[tuple(sorted(left, key=lambda s: (size(s), s), reverse=True))] += x * y
        ways = more
    kept = (((t[0], f), w, size(t) - 1 - sum(map(size, f))) for f, w in ways.items())
    return ((t[0], None), exact(t), size(t)), *kept


def number(x: Fraction) -> Number:
    return mp.mpf(x.numerator) / x.denominator


class Series:
    """A table run on trees, from values that have the series eta."""

    def __init__(self, parts: Mapping[str, Part], eta: Mapping[Tree, Array] | None = None) -> None:
        self.parts, self.eta, self.known = parts, dict(eta or {}), {}

    def slopes(self, t: Tree) -> Array:
        """Return the product of the stages at the children, place by place."""
        ones = zeros(self.parts[t[0]].A.shape[1]) + 1
        return reduce(mul, map(self.stages, t[1])) if t[1] else ones

    def stages(self, t: Tree) -> Array:
        """Return the stages of the component of the root at t."""
        if t not in self.known:
            m = self.parts[t[0]]
            self.known[t] = self._sum(m.A, m.U, t)
        return self.known[t]

    def values(self, t: Tree) -> Array:
        """Return the values after the step, without V eta(t) where that is unknown."""
        return self._sum(self.parts[t[0]].B, self.parts[t[0]].V, t)

    def _sum(self, M: Array, N: Array, t: Tree) -> Array:
        found = M @ self.slopes(t)
        return found + N @ self.eta[t] if t in self.eta else found


class Starting(Series):
    """The starting series that a method asks for, found order by order.

    Parameters
    ----------
    method, margin
        The method, and what counts as zero.
    identity : bool
        Whether the value that is read as the solution is to be the solution itself.
    nystrom : bool
        Whether only trees of second-order systems count.
    limit : int
        Order beyond which nothing is looked for.

    Attributes
    ----------
    order, most : int
        The order as far as it was found, and an upper bound, ``None`` where no tree gave one.
    loose : bool
        Whether there are other starting series.
    """

    def __init__(self, method: Method, margin: Margin, identity: bool, nystrom: bool = False,
                 limit: int = 12) -> None:  # fmt: skip
        super().__init__(method.parts)
        self.method, self.margin, self.identity, self.nystrom = method, margin, identity, nystrom
        self.plain = identity and method.one  # eta is 0
        self.order, self.most, self.loose = 0, None, False
        self.N, self.W, self.w, self.spare = {}, {}, {}, {}
        for c, m in self.parts.items():
            self.N[c], self.W[c] = (margin.null(x - eye(m.r)) for x in (m.V, m.V.T))
            self.eta[c, None], self.spare[c] = ones_of(method, margin, c)
            if self.eta[c, None] is None:
                self.most = 0
        while self.most is None and self.order < limit and self.work(self.order + 1) < WORK:
            self._advance(self.order)

    def work(self, n: int) -> int:
        return len(self.pool(n)) * max(m.A.size + m.r**3 for m in self.parts.values())

    def pool(self, n: int) -> list[Tree]:
        """Return the trees of an order that count."""
        return [t for t in trees(tuple(self.method.children.items()), n)
                if self.method.counts(t) and (not self.nystrom or of_second_order(t))]  # fmt: skip

    def later(self, t: Tree, step: Number = 1) -> Array:
        """Return eta at t after the exact solution has gone on by `step`."""
        return sum(self.eta[s] * (number(weight) * step**gone)
                   for s, weight, gone in cuts(t) if s in self.eta)  # fmt: skip

    def _system(self, n: int, level: list[Tree], ahead: list[Tree],
                free: Mapping[Tree, Array]) -> tuple[Array, Array, dict[Tree, slice]]:  # fmt: skip
        """Return the equations of the next order for what this one leaves open, and their unknowns."""
        ends = np.cumsum([0, *map(len, free.values())])
        place = {
            s: slice(*x) for s, x in zip(free, zip(ends, ends[1:], strict=False), strict=False)
        }
        rows, right = [zeros(0, ends[-1])], [zeros(0)]
        for t in ahead:
            m, W = self.parts[t[0]], self.W[t[0]]
            row = zeros(len(W), ends[-1])
            for s, weight, gone in cuts(t):
                if gone == 1 and s in place:
                    row[:, place[s]] -= W @ free[s].T * number(weight)
            for s in t[1] if len(t[1]) == 1 and t[1][0] in place else ():
                row[:, place[s]] += W @ m.B @ self.parts[s[0]].U @ free[s].T
            rows.append(row)
            right.append(W @ (self.later(t) - self.values(t)))
        for s in level if self.identity and n else ():
            rows.append(zeros(1, ends[-1]))
            rows[-1][0, place[s]] = free[s] @ self.w[s[0]]
            right.append(array([-(self.w[s[0]] @ self.eta[s])]))
        return np.vstack(rows), np.hstack(right), place

    def _advance(self, n: int) -> None:
        """Solve the conditions of the order n + 1, or find that there is no solution."""
        level = [(c, None) for c in self.parts] if n == 0 else [] if self.plain else self.pool(n)
        ahead, basis = self.pool(n + 1), self.N if n else self.spare
        free = {s: basis[s[0]] for s in level}
        system, right, place = self._system(n, level, ahead, free)
        x, more = self.margin.general(system, right)
        if x is None:
            if self.loose:
                raise Undecided("other starting series may have a higher order")
            self.most = n
            return
        if n == 0 and len(more):
            raise Undecided("u is not determined")
        self.loose = self.loose or len(more) > int(n == 1 and not self.identity)
        for s in level:
            self.eta[s] = self.eta[s] + x[place[s]] @ free[s]
        if level:
            self.known = {t: y for t, y in self.known.items() if size(t) < n}
        for c, m in self.parts.items() if n == 0 else ():
            u = self.eta[c, None]
            k = next(k for k, x in enumerate(u) if not self.margin.zero(x))
            self.w[c] = self.method.output.get(c, eye(m.r)[k] / u[k])
        self.order = n + 1
        for t in ahead if not self.plain else ():
            m, w, N = self.parts[t[0]], self.w[t[0]], self.N[t[0]]
            eta = self.margin.solve(eye(m.r) - m.V, self.values(t) - self.later(t))
            if eta is None:
                raise Undecided("eta")
            if self.identity and len(N) == 1:  # what is read is the solution
                eta = eta - N[0] * ((w @ eta) / (w @ N[0]))
            self.eta[t] = eta

    def settled(self, t: Tree, gap: Array, images: Array) -> bool:
        """Return whether a gap vanishes, by what the last order leaves open where t is of it."""
        if size(t) < self.order or not len(images) or (self.identity and len(images) == 1):
            return self.margin.zeros(gap)
        if self.identity and not self.margin.zeros(gap):
            raise Undecided("the principal part of the last order")
        return self.margin.solve(images.T, gap) is not None


def ones_of(method: Method, margin: Margin, c: str) -> tuple[Array | None, Array]:
    """Return u with V u = u and U u = 1, None where there is none, and what may be added to it."""
    m = method.parts[c]
    right = np.hstack([zeros(m.r), zeros(len(m.U)) + 1])
    return margin.general(np.vstack([m.V - eye(m.r), m.U]), right)


def stage_order(start: Starting) -> int:
    """Return the stage order: the stages are the solution at c = xi of a single vertex."""
    if start.loose:
        raise Undecided("the starting series is not the only one")
    if not start.method.pair or start.method.counts is of_time:  # a stage has one abscissa
        first, *others = (start.stages((c, ())) for c in start.parts)
        if not start.margin.zeros([x for other in others for x in first - other]):
            return 0
    for q in range(2, start.order + 1):
        for t in start.pool(q):
            gap = start.stages(t) - start.stages((t[0], ())) ** q * number(exact(t))
            m, N = start.parts[t[0]], start.N[t[0]]
            if not start.settled(t, gap, N[:0] if start.method.one else N @ m.U.T):
                return q - 1
    return start.order


def starting_order(start: Starting, run: Series, u: Mapping[str, Array]) -> int:
    """Return through which order a starting method has the series that is asked for."""
    if start.loose:
        raise Undecided("the starting series is not the only one")
    if start.order == 0 or not start.margin.zeros(
        np.hstack([u[c] - start.eta[c, None] for c in u])
    ):
        return 0
    step = mp.mpf(0)
    if not start.identity:
        (c,) = u
        step = start.w[c] @ (run.values((c, ())) - start.eta[c, ()])
    for q in range(1, start.order + 1):
        for t in start.pool(q):
            wanted = start.eta.get(t, 0) if start.identity else start.later(t, step)
            if not start.settled(t, run.values(t) - wanted, start.N[t[0]]):
                return q - 1
    return start.order
