"""Starting series and what follows from them (sections 3 and 4)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import lru_cache

from .arithmetic import Fraction, Number
from .classes import reduced
from .document import Component, Method, first_place, reading
from .linalg import (
    Matrix,
    apply,
    combine,
    dot,
    identity,
    inverse_matrix,
    is_exact,
    kernel,
    less,
    minus,
    multiples,
    placewise,
    rank,
    scale,
    solve,
    times,
    transpose,
)
from .numbers import apart, as_reals, inverse, is_enclosure, is_nil, vanishes
from .refusals import require, shown
from .trees import LEAF, Tree, cut, gamma, paths, pool_of, residual_weights, size, trees


class Series:
    """A starting series eta and what follows from it; also, without U, the series of a start.

    Above stage order q = 1 the xi of a tree are those of its class (6.2).
    """

    q = 1

    def __init__(
        self, part: Callable[[str], Component], u: dict[str, list], eta: Callable[[Tree], list]
    ) -> None:
        self.part, self.u, self.eta_of = part, u, eta
        self.known, self.outputs, self.products = {}, {}, {}

    @classmethod
    def of_tables(
        cls, tables: Mapping[str, tuple[list, list]], u: dict[str, list] | None = None
    ) -> Series:
        """Return the series of a starting or finishing method, {colour: (A, B)}."""
        parts = {c: Component(Matrix(A), [[]] * len(A), Matrix(B), [])
                 for c, (A, B) in tables.items()}  # fmt: skip
        return cls(parts.__getitem__, u or {}, lambda tree: [])

    def derivative(self, tree: Tree) -> list:
        """Return xiD(t), the product of the xi of the children; that without the last is kept."""
        colour, children = tree
        n, before = len(self.part(colour).A[0]), (colour, children[:-1])
        if len(children) < 3:
            return placewise(n, map(self.stages, children))
        if before not in self.products:
            self.products[before] = self.derivative(before)
        return placewise(n, (self.products[before], self.stages(children[-1])))

    def stages(self, tree: Tree) -> list:
        """Return xi(t) = A xiD(t) + U eta(t), that of its class times the factor."""
        tree, factor = reduced(tree, self.q) if self.q > 1 else (tree, 1)
        if tree not in self.known:
            m = self.part(tree[0])
            slopes, values = apply(m.A, self.derivative(tree)), apply(m.U, self.eta_of(tree))
            self.known[tree] = [x + y for x, y in zip(slopes, values, strict=True)]
        found = self.known[tree]
        return found if factor == 1 else multiples(factor, found)

    def value(self, tree: Tree) -> list:
        """Return B xiD(t), kept where trees share it."""
        if self.q == 1:
            return apply(self.part(tree[0]).B, self.derivative(tree))
        tree, factor = reduced(tree, self.q)
        if tree not in self.outputs:
            self.outputs[tree] = apply(self.part(tree[0]).B, self.derivative(tree))
        return multiples(factor, self.outputs[tree])

    def residual(self, tree: Tree) -> list:
        """Return R(t) = B xiD(t) - ((E eta)(t) - eta(t))."""
        left, weights = residual_weights(tree)
        return times([weights], [self.value(tree), self.u[tree[0]], *map(self.eta_of, left)])[0]


def path_orders(method: Method, series: Series, colour: str, most: int) -> list[int]:
    """Return for each stage through which order, `most` or less, paths t give c^|t| / |t|!."""
    c = series.stages((colour, ()))
    reached = [min(1, most)] * len(c)
    for n in range(2, most + 1):
        (tree,) = [t for t in paths(method.palette, n) if t[0] == colour]
        for i, x in enumerate(series.stages(tree)):
            if reached[i] == n - 1 and vanishes(x - c[i] ** n * Fraction(1, gamma(tree))):
                reached[i] = n
    return reached


def external(method: Method, colour: str) -> tuple[list, list]:
    """Return (u, w): the values that stand for y0, and the row that reads the solution.

    V u = u. Where 1 is a simple eigenvalue of V, u is scaled so that one stage begins at y0 (that
    all do, U u = 1, is a condition of the order); else u is the only one of a consistent method.
    """
    m = method.part(colour)
    N = kernel(minus(m.V, identity(m.r)))
    require(N, "V u = u has no solution")
    if len(N) == 1:
        seen = sorted((x for x in apply(m.U, N[0]) if apart(x)), key=is_enclosure)
        require(seen, "U u is 0")
        u = multiples(inverse(seen[0]), N[0])
    else:
        found, unique = method.vectors_to_one(colour, consistent=True)
        u = shown(found if unique else None, "u is not determined")
    return u, reading(method, colour, u)


@lru_cache(maxsize=2)
def stages_of(tables: tuple[tuple[str, tuple[tuple[Number, ...], ...]], ...]) -> dict[Tree, list]:
    """Return what is kept of the stages of tables, pairs of a colour and rows, by tree."""
    return {}


class Solved(Series):
    """The starting series that an order needs, found order by order (4).

    (I - V) eta(t) = R(t) leaves N beta(t) open, V N = N. The principal parts beta are 0, or those
    with which the conditions W R(t) = 0 of the next order hold.
    """

    def __init__(self, method: Method, identity_mode: bool, nystrom: bool | str) -> None:
        self.method, self.nystrom = method, nystrom
        self.begin(not identity_mode)
        parts = self.parts
        plain = as_reals if method.numbers.unknowns else lambda x: x
        for c, m in method.parts.items():
            require(is_exact(m.V), "V holds decimals")
            shift = minus(m.V, identity(m.r))
            N, W = kernel(shift), kernel(transpose(shift))
            u, w = external(method, c)
            N = [u] if len(N) == 1 else N
            W = times(inverse_matrix(times(W, transpose(N))), W)
            border = times(transpose(N), [w] if len(N) == 1 else W)
            lift = inverse_matrix(combine(scale(-1, shift), border))
            first = None if c in method.declared or len(N) > 1 else first_place(u)
            self.u[c], self.k[c], self.w[c] = plain(u), first, plain(w)
            self.W[c], self.N[c], self.lift[c] = Matrix(plain(W)), plain(N), plain(lift)
            A, U, B = (Matrix(plain(x)) for x in (m.A, m.U, m.B))
            parts[c] = Component(A, U, B, [])
        self.simple = all(len(N) == 1 for N in self.N.values())
        #: whether the values are the solution itself
        self.solved = identity_mode and all(m.r == 1 for m in method.parts.values())
        self.share_stages()

    def begin(self, free: bool) -> None:
        """Stand before the first order, with no part yet."""
        self.free, self.last, self.order, self.filled = free, None, 0, 0
        self.loose = False  # whether principal parts of a lower order are not the only ones
        self.moving = False  # whether parts of the last order are being moved
        self.W, self.N, self.lift, self.eta, self.k, self.w = {}, {}, {}, {}, {}, {}
        self.gaps, self.rights, self.parts = {}, {}, {}
        super().__init__(self.parts.__getitem__, {}, self.cut_value)

    def share_stages(self) -> None:
        """Take the stages that other weights have found: with eta 0 they depend on A alone."""
        tables = [(c, m.A) for c, m in self.parts.items()]
        if self.solved and all(is_exact(A) for _, A in tables):
            self.known = stages_of(tuple((c, tuple(map(tuple, A))) for c, A in tables))

    def cut_value(self, s: Tree) -> list:
        """Return eta at what is left of a tree, 0 where the one value is the solution."""
        if s not in self.eta and (self.method.system or self.solved):
            return [Fraction(0)]
        return self.eta[s]

    def move(self, s: Tree, beta: list) -> None:
        """Add N beta to eta(s)."""
        for b, n in zip(beta, self.N[s[0]], strict=True):
            self.eta[s] = [x + b * y for x, y in zip(self.eta[s], n, strict=True)]

    def settle(self) -> None:
        """Find the principal parts of the last order, where 1 is a simple eigenvalue of each V."""
        n, palette = self.order + 1, dict(self.method.palette)
        if n == 2:
            first, *others = trees(self.method.palette, 1)
            for s in others:
                self.move(s, self.condition((s[0], (first,))))
            return
        found = {}
        leaf = {c: (children[0], ()) for c, children in palette.items()}
        for s in sorted(self.pool(n - 1), key=lambda s: (-len(s[1]), -s[1].count(leaf[s[0]]))):
            t = (s[0], tuple(sorted((*s[1], leaf[s[0]]))))
            value, ways = self.condition(t), Fraction(0)
            for kept, weight in cut(t):
                if kept == s:
                    ways = weight
                elif kept in found:
                    value = less(value, multiples(weight, found[kept]))
            found[s] = multiples(1 / ways, value)
        for s, beta in found.items():
            if not all(map(is_nil, beta)):
                self.move(s, beta)

    def settle_all(self) -> None:
        """Find the principal parts of the last order from all conditions of the next one.

        They are the only ones, at order 1 up to the flow; `last` is the order where there are none.
        """
        m = self.method.parts
        place, units = {}, []
        for s in self.pool(self.order):
            d, reads = len(self.N[s[0]]), apply(self.N[s[0]], self.w[s[0]])
            if not self.free:  # eta(s) is not read as the solution
                read = dot(self.w[s[0]], self.eta[s])
                self.move(s, [-read * x for x in apply(self.W[s[0]], self.u[s[0]])])
            basis = identity(d) if self.free else kernel([reads])
            place[s] = range(len(units), len(units) + len(basis))
            units += basis
        rows, right = [], []
        for t in self.pool(self.order + 1):
            block = [[Fraction(0)] * len(units) for _ in self.W[t[0]]]
            for s, weight in [*cut(t), *((s, None) for s in t[1][:1] if len(t[1]) == 1)]:
                for j in place.get(s, ()):
                    e = apply(transpose(self.N[s[0]]), units[j])
                    image = units[j] if weight else apply(
                        times(self.W[t[0]], m[t[0]].B, m[s[0]].U), e)  # fmt: skip
                    for row, x in zip(block, image, strict=True):
                        row[j] = row[j] + (-weight * x if weight else x)
            rows, right = rows + block, right + [-x for x in self.condition(t)]
        beta, unique = solve(rows, right) if units else ([], True)
        if beta is None or (not units and not vanishes(right)):
            self.last = self.order
            return
        line = self.order == 1 and self.free and len(units) - rank(rows) == 1
        self.loose = self.loose or not (unique or line)
        for s, at in place.items():
            for j in at:
                self.move(s, [beta[j] * x for x in units[j]])

    def advance(self, order: int) -> None:
        """Go on until the conditions of an order can be evaluated; eta is known below it."""
        while self.order < order and self.last is None:
            if self.order and not self.solved:
                self.fill()
                self.moving = True
                if not self.simple:
                    self.settle_all()
                elif self.free:
                    self.settle()
                # of the trees of this order a part before may have looked at the stages
                self.known = {t: x for t, x in self.known.items() if size(t) < self.order}
                self.products = {t: x for t, x in self.products.items() if size(t) <= self.order}
                self.moving = False
            if self.last is None:
                if self.solved and self.order == self.q + 1:
                    self.raise_stage_order()
                self.order += 1

    def raise_stage_order(self) -> None:
        """Take in that the stages of one exact method are the solution on one order more."""
        if [*self.parts] == ["o"] and is_exact([*self.parts["o"].A, *self.parts["o"].B]):
            bush = ("o", (LEAF,) * self.q)
            c, n = self.stages(LEAF), self.q + 1
            if vanishes(less(self.stages(bush), [x**n * Fraction(1, n) for x in c])):
                self.q = n

    def fill(self) -> None:
        """Find eta at the trees of the order that was reached, principal parts 0.

        It is 0 where the one value is the solution: its stages may be those of other methods, too.
        """
        while self.filled < self.order:
            for t in self.pool(self.filled + 1):
                if self.solved:
                    self.eta[t] = [Fraction(0)]
                    continue
                c, right = t[0], self.right(t)
                self.gaps[t] = apply(self.W[c], right)
                self.eta[t] = [Fraction(0) if j == self.k[c] else dot(row, right)
                               for j, row in enumerate(self.lift[c])]  # fmt: skip
            self.filled += 1

    def residual(self, tree: Tree) -> list:
        """Return R(t); no cut counts where the one value is the solution."""
        if not self.solved:
            return super().residual(tree)
        weight = Fraction(-1, gamma(tree))
        return [x + weight * y for x, y in zip(self.value(tree), self.u[tree[0]], strict=True)]

    def right(self, t: Tree) -> list:
        """Return R(t), kept through the order that was reached: eta moves no more below it."""
        if size(t) > self.order:
            return self.residual(t)
        if t not in self.rights:
            self.rights[t] = self.residual(t)
        return self.rights[t]

    def condition(self, t: Tree) -> list:
        """Return W R(t)."""
        return self.gaps[t] if t in self.gaps else apply(self.W[t[0]], self.right(t))

    def pool(self, order: int) -> list[Tree]:
        """Return the trees of an order that count."""
        return pool_of(self.method, order, self.nystrom)

    def shift(self, t: Tree, sigma: Number) -> list:
        """Return what eta(t) gains by the flow through sigma, for one method."""
        gain = [x * sigma ** size(t) * Fraction(1, gamma(t)) for x in self.u["o"]]
        for s, weight in cut(t):
            if s != t:
                factor = weight * sigma ** (size(t) - size(s))
                gain = [x + factor * y for x, y in zip(gain, self.eta_of(s), strict=True)]
        return gain
