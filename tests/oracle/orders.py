"""Orders: trees, what a step does to them, and the starting series as a system of equations.

A method is run on trees: xi(t) = A prod xi(children) + U eta(t) are the stages, B prod xi + V eta the
values after the step, which must be the values of the exact solution one step later. Order by order
this is linear in eta, and in what of eta the order before left open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import cache

from mpmath import mp

from .methods import Method, Tree, of_second_order, of_time
from .numbers import Margin, Matrix, Number, Undecided, Vector, at, dot, eye, plus, transposed

#: Trees times (stages squared + values cubed), above which an order is not looked at.
WORK = 150_000


@cache
def trees(palette: tuple[tuple[str, str], ...], n: int) -> tuple[Tree, ...]:
    """Return all trees with n vertices, the children of a colour being those of the palette."""
    return tuple(
        (c, forest) for c, below in palette for forest in _forests(palette, n - 1, below, None)
    )


@cache
def _forests(
    palette: tuple[tuple[str, str], ...], n: int, below: str, most: tuple[int, Tree] | None
) -> tuple[tuple[Tree, ...], ...]:
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
    """Return the number of vertices."""
    return 1 + sum(map(size, t[1]))


@cache
def exact(t: Tree) -> Fraction:
    """Return the coefficient of the exact solution, 1 / gamma(t)."""
    found = Fraction(1, size(t))
    for child in t[1]:
        found *= exact(child)
    return found


@cache
def kept(t: Tree) -> tuple[tuple[Tree, Fraction, int], ...]:
    """Return (s, weight, vertices cut) for all ways to cut branches off t and keep the root."""
    ways: dict[tuple[Tree, ...], Fraction] = {(): Fraction(1)}
    for child in t[1]:
        more: dict[tuple[Tree, ...], Fraction] = {}
        for forest, x in ways.items():
            for s, y in [(None, exact(child)), *((s, y) for s, y, _ in kept(child))]:
                key = forest if s is None else tuple(sorted((*forest, s), key=_rank, reverse=True))
                more[key] = more.get(key, Fraction(0)) + x * y
        ways = more
    return tuple(((t[0], f), w, size(t) - 1 - sum(map(size, f))) for f, w in ways.items())


def _rank(t: Tree) -> tuple[int, Tree]:
    return size(t), t


def number(x: Fraction) -> Number:
    """Return the number of mpmath."""
    return mp.mpf(x.numerator) / x.denominator


class Run:
    """A table (A, B, and U with a series eta) run on trees."""

    def __init__(self, tables: Mapping[str, tuple[Matrix, Matrix]],
                 base: Callable[[Tree], Vector | None] | None = None) -> None:  # fmt: skip
        self.tables, self.base, self.known = tables, base, {}

    def slopes(self, t: Tree) -> Vector:
        """Return the product of the stages at the children, place by place."""
        found = [mp.mpf(1)] * len(self.tables[t[0]][0][0])
        for child in t[1]:
            found = [x * y for x, y in zip(found, self.stages(child), strict=True)]
        return found

    def stages(self, t: Tree) -> Vector:
        """Return the stages of the component of the root at t."""
        if t not in self.known:
            own = at(self.tables[t[0]][0], self.slopes(t))
            more = self.base(t) if self.base else None
            self.known[t] = own if more is None else [x + y for x, y in zip(own, more, strict=True)]
        return self.known[t]

    def values(self, t: Tree) -> Vector:
        """Return B times the slopes."""
        return at(self.tables[t[0]][1], self.slopes(t))


class Starting(Run):
    """The starting series that a method asks for, found order by order.

    Parameters
    ----------
    method : Method
        The method.
    margin : Margin
        What counts as zero.
    identity : bool
        Whether the value that is read as the solution is to be the solution itself.
    nystrom : bool
        Whether only trees of second-order systems count.

    Attributes
    ----------
    order : int
        The order as far as it was found.
    most : int or None
        An upper bound, ``None`` where the trees looked at do not give one.
    """

    def __init__(self, method: Method, margin: Margin, identity: bool, nystrom: bool = False,
                 limit: int = 12) -> None:  # fmt: skip
        parts = method.parts
        super().__init__({c: (m.A, m.B) for c, m in parts.items()}, self._seen)
        self.method, self.margin, self.identity, self.nystrom = method, margin, identity, nystrom
        self.palette = tuple(method.children.items())
        self.eta: dict[Tree, Vector] = {}
        self.u: dict[str, Vector] = {}
        self.N, self.W, self.w = {}, {}, {}
        self.order, self.most, self.loose = 0, None, False
        for c, m in parts.items():
            shift = plus(m.V, eye(m.r), -1)
            self.N[c], self.W[c] = margin.null(shift), margin.null(transposed(shift))
            u = self._vector(c)
            if u is None:
                self.most = 0
                return
            self.u[c] = u
            k = next(k for k, x in enumerate(u) if not margin.zero(x))
            own = method.output.get(c)
            self.w[c] = own or [(1 / x if j == k else mp.mpf(0)) for j, x in enumerate(u)]
        while self.most is None and self.order < limit and self._work(self.order + 1) < WORK:
            self._advance()

    def _work(self, n: int) -> int:
        parts = self.method.parts.values()
        return len(self.pool(n)) * max(len(m.A) * len(m.A[0]) + m.r**3 for m in parts)

    def pool(self, n: int) -> list[Tree]:
        """Return the trees of an order that count."""
        return [t for t in trees(self.palette, n)
                if self.method.counts(t) and (not self.nystrom or of_second_order(t))]  # fmt: skip

    def _vector(self, c: str) -> Vector | None:
        """Return the u with V u = u, U u = 1 and w u = w B 1 for all w = w V."""
        m, (u, free) = self.method.parts[c], ones_of(self.method, self.margin, c)
        ones = [mp.mpf(1)] * len(m.B[0])
        if u is None:
            return None
        rows = [[dot(w, n) for n in free] for w in self.W[c]]
        right = [dot(w, at(m.B, ones)) - dot(w, u) for w in self.W[c]]
        if not free:
            return u if self.margin.zeros(right) else None
        x = self.margin.solve(rows, right)
        if x is None:
            return None
        if self.margin.rank(rows) < len(free):
            raise Undecided("u is not determined")
        return [y + dot(x, [n[k] for n in free]) for k, y in enumerate(u)]

    def _seen(self, t: Tree) -> Vector | None:
        eta = self.eta.get(t)
        return None if eta is None else at(self.method.parts[t[0]].U, eta)

    def later(self, t: Tree, step: Number = 1) -> Vector:
        """Return eta at t after the exact solution has gone on by `step`."""
        found = [x * number(exact(t)) * step ** size(t) for x in self.u[t[0]]]
        for s, weight, gone in kept(t):
            if s in self.eta:
                factor = number(weight) * step**gone
                found = [x + factor * y for x, y in zip(found, self.eta[s], strict=True)]
        return found

    def residual(self, t: Tree) -> Vector:
        """Return B slopes + V eta less the series one step later; eta(t) is 0 where unknown."""
        found = [x - y for x, y in zip(self.values(t), self.later(t), strict=True)]
        if t in self.eta:
            more = at(self.method.parts[t[0]].V, self.eta[t])
            found = [x + y for x, y in zip(found, more, strict=True)]
        return found

    def _advance(self) -> None:
        """Solve the conditions of the next order, or find that there is no solution."""
        n, level, ahead = (
            self.order,
            self.pool(self.order) if self.order else [],
            self.pool(self.order + 1),
        )
        names = [(s, k) for s in level for k in range(len(self.N[s[0]]))]
        place, parts = {x: j for j, x in enumerate(names)}, self.method.parts
        gaps = {t: self.residual(t) for t in ahead}
        if self.method.one and self.identity:
            self._settled(n, ahead, gaps, self.margin.zeros([x for g in gaps.values() for x in g]))
            return
        rows, right = [], []
        for t in ahead:
            changes: dict[int, Vector] = {}
            if len(t[1]) == 1:
                s = t[1][0]
                for k, nu in enumerate(self.N[s[0]] if (s, 0) in place else ()):
                    j = place[s, k]
                    changes[j] = at(parts[t[0]].B, at(parts[s[0]].U, nu))
            for s, weight, gone in kept(t):
                for k, nu in enumerate(self.N[s[0]] if gone == 1 and (s, 0) in place else ()):
                    j, old = place[s, k], changes.get(place[s, k], [mp.mpf(0)] * len(nu))
                    changes[j] = [x - number(weight) * y for x, y in zip(old, nu, strict=True)]
            for w in self.W[t[0]]:
                rows.append(
                    [dot(w, changes[j]) if j in changes else mp.mpf(0) for j in range(len(names))]
                )
                right.append(-dot(w, gaps[t]))
        for s in level if self.identity else ():
            rows.append(
                [dot(self.w[s[0]], self.N[s[0]][k]) if s == x else mp.mpf(0) for x, k in names]
            )
            right.append(-dot(self.w[s[0]], self.eta[s]))
        if not names:
            self._settled(n, ahead, gaps, self.margin.zeros(right))
            return
        x = self.margin.solve(rows, right)
        if x is not None:
            spare = len(names) - self.margin.rank(rows)
            self.loose = self.loose or spare > int(n == 1 and not self.identity)
            for s in level:
                beta = [x[place[s, k]] for k in range(len(self.N[s[0]]))]
                self.eta[s] = [
                    y + dot(beta, [nu[i] for nu in self.N[s[0]]]) for i, y in enumerate(self.eta[s])
                ]
            self.known = {t: y for t, y in self.known.items() if size(t) < n}
            gaps = {t: self.residual(t) for t in ahead}
        self._settled(n, ahead, gaps, x is not None)

    def _settled(self, n: int, ahead: list[Tree], gaps: Mapping[Tree, Vector], fine: bool) -> None:
        """Go on to the next order, or stop at this one."""
        if not fine:
            if self.loose:
                raise Undecided("other starting series may have a higher order")
            self.most = n
            return
        for t in ahead:
            m = self.method.parts[t[0]]
            eta = (
                self.margin.solve(plus(eye(m.r), m.V, -1), gaps[t])
                if not self.method.one or not self.identity
                else [mp.mpf(0)]
            )
            if eta is None:
                raise Undecided("eta")
            self.eta[t] = eta
            self.known.pop(t, None)
        self.order = n + 1
        for s in ahead if self.identity and not self.method.one else ():
            if len(self.N[s[0]]) == 1:  # what is read is the solution
                nu = self.N[s[0]][0]
                factor = dot(self.w[s[0]], self.eta[s]) / dot(self.w[s[0]], nu)
                self.eta[s] = [x - factor * y for x, y in zip(self.eta[s], nu, strict=True)]

    def settled(self, t: Tree, gap: Vector, images: Matrix) -> bool:
        """Return whether a gap vanishes, by what the last order leaves open where t is of it."""
        if size(t) < self.order or not images or (self.identity and len(images) == 1):
            return self.margin.zeros(gap)
        if self.identity and not self.margin.zeros(gap):
            raise Undecided("the principal part of the last order")
        return self.margin.solve(transposed(images), gap) is not None


def ones_of(method: Method, margin: Margin, c: str) -> tuple[Vector | None, Matrix]:
    """Return u with V u = u and U u = 1, None where there is none, and what may be added to it."""
    m = method.parts[c]
    rows = [*plus(m.V, eye(m.r), -1), *m.U]
    right = [mp.mpf(0)] * m.r + [mp.mpf(1)] * len(m.U)
    return margin.solve(rows, right), margin.null(rows)


def through(start: Starting, n: int) -> Iterator[Tree]:
    """Yield the trees through an order that count."""
    for k in range(1, n + 1):
        yield from start.pool(k)


def stage_order(start: Starting) -> int:
    """Return the stage order: the stages are the solution at c = xi of a single vertex."""
    if start.loose:
        raise Undecided("the starting series is not the only one")
    if not start.method.pair or start.method.counts is of_time:  # a stage has one abscissa
        first, *others = (start.stages((c, ())) for c in start.method.parts)
        gaps = [x - y for other in others for x, y in zip(first, other, strict=True)]
        if not start.margin.zeros(gaps):
            return 0
    q = min(start.order, 1)
    while q < start.order:
        for t in start.pool(q + 1):
            c = start.stages((t[0], ()))
            gap = [
                x - y ** (q + 1) * number(exact(t)) for x, y in zip(start.stages(t), c, strict=True)
            ]
            images = (
                [at(start.method.parts[t[0]].U, n) for n in start.N[t[0]]]
                if not start.method.one
                else []
            )
            if not start.settled(t, gap, images):
                return q
        q += 1
    return q


def starting_order(start: Starting, run: Run, u: Mapping[str, Vector]) -> int:
    """Return through which order a starting method has the series that is asked for."""
    if start.loose:
        raise Undecided("the starting series is not the only one")
    m = start.margin
    if any(not m.zeros([x - y for x, y in zip(u[c], start.u[c], strict=True)]) for c in u):
        return 0
    step = mp.mpf(0)
    if not start.identity and start.order:
        (c,) = u
        leaf = (c, ())
        step = dot(start.w[c], run.values(leaf)) - dot(start.w[c], start.eta[leaf])
    for q in range(1, start.order + 1):
        for t in start.pool(q):
            wanted = start.eta[t] if start.identity else start.later(t, step)
            gap = [x - y for x, y in zip(run.values(t), wanted, strict=True)]
            if not start.settled(t, gap, start.N[t[0]]):
                return q - 1
    return start.order
