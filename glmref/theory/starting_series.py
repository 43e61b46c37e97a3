"""Starting series and order conditions of general linear methods, in any number of colours.

Prepared c has the blocks (A, U, B, V) and the colour c; ``X = h A F + U x``, ``x+ = h B F + V x``.
For a tree t = [t1 .. tm] with root colour c, eta(empty) = u_c::

    xiD(t) = xi(t1) ... xi(tm)                          xi(t) = A xiD(t) + U eta(t)
    R(t)   = B xiD(t) - ((E eta)(t) - eta(t))           (I - V) eta(t) = R(t)

A starting method S with M S = S E + O(h^(p+1)) exists exactly if these can be solved through p.
W (rows) and N (columns) are bases of the left and right eigenvectors of V to 1, W N = I: then t has
the condition ``W R(t) = 0``, and eta(t) is determined up to ``N beta(t)``, its principal part.

The principal parts
-------------------
*They enter linearly, one order later.* Changing beta at the trees of order k changes the condition
of a tree t of order k + 1 by

    (L beta)(t) = K beta(t1) [only if t = [t1]] - sum n(s, t) beta(s),     K = W B U N,

the sum over the trees s left when a leaf of t is removed, n(s, t) counting the leaves. K is 1 for a
simple eigenvalue (then K = w B 1 = w u, by the condition of order 1).

*They are unique.* L is injective for k >= 2: among the trees where a beta in its kernel is not zero
take s with the most children, and among those with the most leaves of one colour x at the root. Let
t be s with one more such leaf at the root. It has two children or more, so K plays no part.
Removing from t a leaf that is not a child of the root leaves more children at the root than s has;
removing a leaf of another colour there leaves more leaves x. So beta is zero on all the trees in
the sum but s, hence n(s, t) beta(s) = 0, and n(s, t) > 0. The same proof is an algorithm: the
conditions of the trees with such a leaf at the root determine beta by back substitution; the
conditions of the other trees remain, and they decide.

*At k = 1 one parameter is left, and it does not matter.* L maps beta(single nodes) to the trees of
order 2; its kernel holds the multiples of W u, because S E^a (follow the flow for a h, then start)
is a starting method whenever S is: M S E^a = S E E^a = S E^a E. These shifts act on all starting
series, and reach every value of the parameter. So a solution with the parameter normalised to zero
exists whenever any solution exists. For any number of colours with simple eigenvalues the kernel is
exactly that (the tree [x] with root y says beta_x - beta_y = known); for one colour with a multiple
eigenvalue the rank of K - I is computed.

Hence deciding order by order is complete, though the conditions are not linear as a whole: at each
order at most one choice of the principal parts is left, up to the shift. In the language of
Butcher (1969): the method's underlying one-step method Phi satisfies Phi beta = beta E; beta is
unique up to the centraliser of E, and that is the flow itself.

Over balls every quantity encloses that of each method within them, since each step (solving with
the exact V, back substitution) does. A residual that excludes zero excludes every starting series
of every such method; a residual that contains zero proves nothing.

References
----------
Butcher, "The effective order of Runge-Kutta methods" (1969), Lecture Notes in Math. 109.
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 389, 535.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import factorial
from typing import Any, Self

from ..errors import ExactnessError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from ..method.component import Palette
from ..method.model import Method
from ..method.preconsistency import first_functional
from ..system.budget import spend
from .coefficients import (
    Rows,
    apply,
    combination,
    is_zero,
    plus,
    scalars,
    sparse,
    tidy,
    times,
    weighted,
)
from .trees import Tree, paths, pruned, single, tree, trees

_ZERO, _ONE = Exact(0), Exact(1)


class NotPreconsistent(Exception):
    """There is no u with V u = u and U u = 1, or none with the condition of order 1."""


class NoOrderOne(NotPreconsistent):
    """1 is a multiple eigenvalue of V, and the u that order 1 asks for has not U u = 1."""


@dataclass(frozen=True, eq=False)
class Prepared:
    """One colour's method, prepared; its V is exact.

    Attributes
    ----------
    A, U, B, W : Rows
        Entries by row, exact zeros left out.
    slopes : int
        Columns of A.
    u : Vector
        V u = u, U u = 1.
    N, W
        See the module docstring.
    output : Vector
        w with w u = 1 that reads the solution off the values: the declared one, or that of
        the first k with u_k not 0.
    lift : Rows
        R -> the solution x of (I - V) x = R with w x = 0, for W R = 0.
    certain : bool
        Whether U u = 1 exactly.
    """

    A: Rows
    U: Rows
    B: Rows
    W: Rows
    slopes: int
    u: Vector
    N: tuple[Vector, ...]
    output: Vector
    lift: Rows
    certain: bool


def read(c: Prepared, values: Sequence[Any]) -> Any:
    """Return the solution that a vector of values holds: what the output functional sees of it."""
    return weighted([(j, x) for j, x in enumerate(c.output) if not x.vanishes()], values)


def component(
    A: Matrix,
    U: Matrix,
    B: Matrix,
    V: Matrix,
    output: Vector | None = None,
    *,
    measured: bool = False,
) -> Prepared:
    """Prepare one component.

    Parameters
    ----------
    A, U, B, V, output
        Of the method.
    measured : bool
        Whether u is taken although U u = 1 may fail, for residuals that prove nothing.

    Raises
    ------
    NotPreconsistent
        A proof that there is no order 1, or no u, with the reason.
    ExactnessError
        When V holds balls, the eigenvalue 1 is defective, or the declared output does not read the
        solution: nothing is decided.
    """
    if not all(isinstance(x, Exact) for row in V for x in row):
        raise ExactnessError("V holds published decimals: whether 1 is an eigenvalue is open")
    r = len(V)
    D = linalg.sub(V, linalg.identity(r))
    N, left = linalg.nullspace(D), linalg.nullspace(linalg.transpose(D))
    if not N:
        raise NotPreconsistent("V has no eigenvalue 1")
    pairing = tuple(tuple(linalg.dot(w, v) for v in N) for w in left)
    if linalg.rank(pairing) < len(N):
        raise ExactnessError("the eigenvalue 1 of V is defective: other starts are not excluded")
    W = linalg.solve(pairing, tuple(left))
    if len(N) == 1:
        image = linalg.matvec(U, N[0])
        at = next((x for x in image if x.is_zero() is False), None)
        if at is None:
            if all(x.is_zero() is True for x in image):
                raise NotPreconsistent("the eigenvector u of V to the eigenvalue 1 has U u = 0")
            raise ExactnessError("whether U u = 1 is not decided within the digits")
        u = tuple(x / at for x in N[0])
        N, W = [u], linalg.scale(at, W)
    else:  # the condition of order 1, W u = W B 1, determines u
        total = linalg.matvec(linalg.matmul(W, B), [_ONE] * len(B[0]))
        u = linalg.matvec(linalg.transpose(tuple(N)), total)
    seen = [x - 1 for x in linalg.matvec(U, u)]
    for i, x in enumerate(seen):
        if x.is_zero() is False and not measured:
            size = complex(x + 1)
            shown = f"{size.real:.6g}" if size.imag == 0 else f"{size:.6g}"
            if len(N) > 1:
                text = "no eigenvector u of V to the eigenvalue 1 has U u = 1 and order 1"
                raise NoOrderOne(text)
            raise NotPreconsistent(
                f"row {i + 1} of U u is {shown} instead of 1, u the eigenvector of V to 1"
            )
    w = first_functional(u) if output is None else output
    if output is not None and (linalg.dot(w, u) - 1).is_zero() is not True:
        raise ExactnessError("whether the declared output reads the solution is not decided")
    lift = _lift(D, N, left, u, w)
    certain = all(x.is_zero() is True for x in seen)
    return Prepared(
        sparse(A),
        sparse(U),
        sparse(B),
        sparse(W),
        len(A[0]),
        u,
        tuple(N),
        w,
        lift,
        certain,
    )


def _lift(D: Matrix, N: Sequence[Vector], left: Sequence[Vector], u: Vector, w: Vector) -> Rows:
    """Solve (I - V) x = R up to the part that W sees, through the bordered matrix."""
    r, d = len(D), len(N)
    rows = [(*(-x for x in D[i]), *(left[k][i].conjugate() for k in range(d))) for i in range(r)]
    rows += [(*(x.conjugate() for x in v), *([_ZERO] * d)) for v in N]
    solve = tuple(row[:r] for row in linalg.inverse(tuple(rows))[:r])
    shadow = linalg.vecmat(w, solve)
    return sparse(
        [[x - u[i] * y for x, y in zip(row, shadow, strict=True)] for i, row in enumerate(solve)]
    )


def _apply_u(c: Prepared) -> tuple[Any, ...]:
    return apply(c.W, c.u)


def _bordered(square: Matrix, residual: Vector, along: Vector) -> list[Any] | None:
    """Return the x with square x = -residual and one entry 0, where along has none.

    ``None`` means that none is shown.

    One row is left out: the others must be regular in the other columns. Where several may be, it
    is the one that the x found satisfies best.
    """
    size, best = len(square), None
    for column in (j for j in range(size) if along[j].is_zero() is False):
        kept = [j for j in range(size) if j != column]
        for row in range(size):
            rows = [i for i in range(size) if i != row]
            part = tuple(tuple(square[i][j] for j in kept) for i in rows)
            try:
                found = linalg.solve(part, tuple((-residual[i],) for i in rows))
            except ExactnessError:
                continue
            x: list[Any] = [_ZERO] * size
            for j, value in zip(kept, found, strict=True):
                x[j] = value[0]
            left = (linalg.dot(square[row], x) + residual[row]).magnitude()
            if best is None or left < best[0]:
                best = left, x
        if best is not None:
            return best[1]
    return None


@lru_cache(maxsize=4096)
def _exactly(ratio: Fraction) -> Exact:
    return Exact(ratio)


@lru_cache(maxsize=4096)
def _weight(ways: int, size: int) -> Exact:
    return Exact(Fraction(-ways, size))


class StartingSeries:
    """The one starting series of a method, up to what is free, and the residuals beyond.

    Parameters
    ----------
    components : dict[str, Prepared]
        By colour, in the order of the palette.
    palette : Palette
        Colours of the trees.
    free : bool
        Whether principal parts are free; otherwise w eta(t) = 0, w the output.
    counts : Callable[[Tree], bool]
        Which trees count; the set is closed under subtrees and cuts.
    along_paths : bool
        Whether only the trees without branches are looked at.

    Attributes
    ----------
    eta
        By tree; vectors of zeros are left out. Principal parts of the last order are zero.
    determined
        Trees whose conditions were used to determine principal parts.
    complete
        Whether a residual that is not zero excludes every starting series.
    """

    def __init__(
        self,
        components: dict[str, Prepared],
        palette: Palette,
        *,
        free: bool,
        counts: Callable[[Tree], bool] = lambda t: True,
        along_paths: bool = False,
    ) -> None:
        self.components: dict[str, Prepared] = components
        self.palette: Palette = palette
        self.free: bool = free
        self.counts: Callable[[Tree], bool] = counts
        self.along_paths: bool = along_paths
        self.simple: bool = all(len(c.N) == 1 for c in components.values())
        self.complete: bool = self.simple or len(components) == 1
        self.order: int = 0
        self.eta: dict[Tree, tuple[Any, ...]] = {}
        self.determined: frozenset[Tree] = frozenset()
        self._waiting: list[Tree] = []  # trees of the last order whose eta is not found yet
        self._rights: dict[Tree, tuple[Any, ...]] = {}
        # xi(t) = ratio * product of stored vectors: trees that a stage order makes alike cost once
        self._bases: list[tuple[Any, ...]] = []
        self._stage: dict[Tree, tuple[Fraction, tuple[int, ...]]] = {}
        self._shared: dict[tuple[str, tuple[int, ...]], tuple[Fraction, tuple[int, ...]]] = {}
        self._images: dict[tuple[str, tuple[int, ...], bool], tuple[Any, ...]] = {}
        self._products: dict[tuple[int, ...], tuple[Any, ...]] = {}
        self._abscissae: dict[str, int] = {}

    @classmethod
    def of(
        cls, method: Method, *, free: bool = True, counts: Callable[[Tree], bool] = lambda t: True,
        along_paths: bool = False,
    ) -> StartingSeries:  # fmt: skip
        """Return the series of a method, before the first order.

        Parameters
        ----------
        method : Method
            Its values may be several; V is exact.
        free, counts, along_paths
            See :class:`StartingSeries`.

        Raises
        ------
        NotPreconsistent, ExactnessError
            As :func:`component`.

        Examples
        --------
        >>> from glmref import StartingSeries, Tree, load
        >>> series = StartingSeries.of(load("ab-2"), free=False).through(2)
        >>> series.value(Tree("[o]"))
        (0, Exact(-1))
        """
        components = {c.colour: component(*c.matrices, c.output) for c in method.components}
        return cls(components, method.palette, free=free, counts=counts, along_paths=along_paths)

    def level(self, n: int) -> list[Tree]:
        """Return the trees of an order that count."""
        if self.along_paths:
            return list(filter(self.counts, paths(n, tuple(self.palette.items()))))
        return list(filter(self.counts, trees(n, self.palette)))

    def value(self, t: Tree) -> tuple[Any, ...]:
        """Return eta(t)."""
        found = self.eta.get(t)
        return (0,) * len(self.components[t.colour].u) if found is None else found

    def plain(self, t: Tree) -> tuple[Any, ...]:
        """Return eta(t) with its principal part zero; the conditions of its order are known."""
        return tidy(apply(self.components[t.colour].lift, self._right(t)))

    # -- stages

    def _image(self, colour: str, monomial: tuple[int, ...], *, stages: bool) -> tuple[Any, ...]:
        """Return A (for the stages) or B times a product of stored vectors."""
        key = (colour, monomial, stages)
        if key not in self._images:
            c = self.components[colour]
            vector = self._product(monomial) if monomial else (1,) * c.slopes
            self._images[key] = apply(c.A if stages else c.B, vector)
        return self._images[key]

    def _product(self, monomial: tuple[int, ...]) -> tuple[Any, ...]:
        """Return the product of stored vectors, entry by entry."""
        if len(monomial) == 1:
            return self._bases[monomial[0]]
        if monomial not in self._products:
            first, last = self._product(monomial[:-1]), self._bases[monomial[-1]]
            self._products[monomial] = tuple(map(times, first, last))
        return self._products[monomial]

    def _slope(self, t: Tree) -> tuple[Fraction, tuple[int, ...]]:
        ratio, factors = Fraction(1), []
        for child in t.children:
            factor, monomial = self._stage[child]
            ratio *= factor
            factors += monomial
        return ratio, tuple(sorted(factors))

    def stage(self, t: Tree, value: Sequence[Any]) -> tuple[Any, ...]:
        """Return xi(t) from its definition, with eta(t) = value."""
        colour = t.colour
        ratio, monomial = self._slope(t)
        vector = times(ratio, self._image(colour, monomial, stages=True))
        return plus(vector, apply(self.components[colour].U, value))

    def output(self, t: Tree) -> tuple[Any, ...]:
        """Return B xiD(t)."""
        ratio, monomial = self._slope(t)
        return times(ratio, self._image(t.colour, monomial, stages=False))

    def settle_stage(self, t: Tree) -> None:
        """Find xi(t), from eta(t) if it is there."""
        colour, value = t.colour, self.eta.get(t)
        if value is not None:
            vector = self.stage(t, value)
            self._stage[t] = self._store(t, vector, Fraction(1, t.density))
            return
        ratio, monomial = self._slope(t)
        if ratio == 0:
            self._stage[t] = (ratio, ())
            return
        key = (colour, monomial)
        if key not in self._shared:
            wanted = 1 / (t.density * ratio)
            self._shared[key] = self._store(t, self._image(*key, stages=True), wanted)
        factor, found = self._shared[key]
        self._stage[t] = (ratio * factor, found)

    def _store(self, t: Tree, vector: Any, wanted: Fraction) -> tuple[Fraction, tuple[int, ...]]:
        """Write a stage vector as zero, as ``wanted * c^|t|``, or as a new one."""
        vector = tidy(vector)
        if all(type(x) is int and x == 0 for x in vector):
            return Fraction(0), ()
        order, colour = t.order, t.colour
        base = self._abscissae.get(colour)
        if base is not None:
            power = self._product((base,) * order)
            if all(
                is_zero(plus(x, times(-wanted, y))) is True
                for x, y in zip(vector, power, strict=True)
            ):
                return wanted, (base,) * order
        self._bases.append(vector)
        if order == 1:
            self._abscissae[colour] = len(self._bases) - 1
        return Fraction(1), (len(self._bases) - 1,)

    def abscissae(self, colour: str) -> tuple[Any, ...]:
        """Return c = xi of the single node: a stage stands at ``t + c_i h``; of order 2 or more."""
        node = single(colour)
        return self.stage(node, self.value(node))

    def defect(self, t: Tree, c: tuple[Any, ...], value: Sequence[Any]) -> tuple[Any, ...]:
        """Return ``xi(t) - c^|t| / gamma(t)``, stage by stage, where eta(t) is ``value``."""
        expected = times(Fraction(1, t.density), self.power(c, t.order))
        return plus(self.stage(t, value), times(-1, expected))

    @staticmethod
    def power(c: tuple[Any, ...], n: int) -> tuple[Any, ...]:
        """Return c^n, entry by entry."""
        result = c
        for _ in range(n - 1):
            result = tuple(map(times, result, c))
        return result

    def fixed_stages(self, colour: str, value: Sequence[Any]) -> tuple[Any, ...]:
        """Return the factors U N through which principal parts N beta of a value enter the stages.

        Raises
        ------
        ExactnessError
            Where 1 is a multiple eigenvalue of V and U holds balls.
        """
        c = self.components[colour]
        if len(c.N) == 1:  # U u = 1
            return tuple(plus(x, times(-1, value[0])) for x in value[1:])
        moved = tuple(scalars(apply(c.U, x)) for x in c.N)
        if not all(isinstance(x, Exact) for row in moved for x in row):
            raise ExactnessError("what principal parts add to the stages is not known exactly")
        return tuple(weighted(list(enumerate(z)), value) for z in linalg.nullspace(moved))

    # -- conditions

    def _right(self, t: Tree) -> tuple[Any, ...]:
        """Return R(t)."""
        c = self.components[t.colour]
        ratio, monomial = self._slope(t)
        terms = []
        if ratio:
            terms.append((_exactly(ratio), self._image(t.colour, monomial, stages=False)))
        terms.append((_weight(1, t.density), c.u))
        if self.eta:
            for kept, ways in pruned(t).items():
                value = self.eta.get(kept)
                if value is not None and kept is not t:
                    terms.append((_weight(ways, factorial(t.order - kept.order)), value))
        return combination(terms)

    def _set(self, t: Tree, value: tuple[Any, ...]) -> None:
        value = tidy(value)
        if all(type(x) is int and x == 0 for x in value):
            self.eta.pop(t, None)
        else:
            self.eta[t] = value

    def through(self, order: int) -> Self:
        """Return the series itself, after as many orders at least."""
        while self.order < order:
            self.advance()
        self.settle()
        return self

    def advance(self) -> list[Tree]:
        """Go to the next order; its trees that count."""
        self.settle()
        n = self.order + 1
        level, self._rights = self.level(n), {}
        if n == 2:
            self._settle_first()
        elif n > 2 and (self.free or not self.simple):
            self._rights = self._settle_principal(n)
        self.determined = frozenset(self._rights) if self.free else frozenset()
        for t in self.level(n - 1) if n > 1 else ():
            if t not in self._stage:
                self.settle_stage(t)
        self.order, self._waiting = n, level
        return level

    def residual(self, t: Tree) -> tuple[Any, ...]:
        """Return ``W R(t)`` of a tree of the last order, 0 where it determines a principal part."""
        c = self.components[t.colour]
        if t in self.determined:
            return (0,) * len(c.N)
        if t not in self._rights:
            spend()
            self._rights[t] = self._right(t)
        return apply(c.W, self._rights[t])

    def settle(self) -> None:
        """Find eta at the trees of the last order, but for the principal parts."""
        for t in self._waiting:
            spend()
            right = self._rights[t] if t in self._rights else self._right(t)
            self._set(t, apply(self.components[t.colour].lift, right))
        self._waiting = []

    def _settle_first(self) -> None:
        """Determine principal parts at the single vertices, up to the shift along the flow."""
        first, *others = map(single, self.palette)
        if not self.simple:
            if self.complete:
                self._settle_first_multiple(first)
            return
        if not self.free:
            return
        self.settle_stage(first)
        for node in others:
            t = tree((first,), node.colour)
            c = self.components[node.colour]
            (beta,) = apply(c.W, self._right(t))
            self._set(node, plus(self.value(node), times(beta, c.u)))

    def _settle_first_multiple(self, node: Tree) -> None:
        """Solve (K - I) beta = -residual of [o], of corank 1: one colour, several eigenvectors.

        The shift along the flow adds a multiple of W u to beta, which takes one entry to zero; the
        others solve a regular part of the system, so that corank 1 is proved, over balls too.
        """
        c = self.components[node.colour]
        before = self.value(node)
        right = plus(apply(c.B, self.stage(node, before)), times(-1, before))
        residual = scalars(apply(c.W, plus(right, times(Fraction(-1, 2), c.u))))
        columns = [scalars(apply(c.W, apply(c.B, apply(c.U, x)))) for x in c.N]
        K = linalg.transpose(tuple(columns))
        square = linalg.sub(K, linalg.identity(len(K)))
        along = scalars(_apply_u(c))
        beta = _bordered(square, residual, along)
        self.complete = beta is not None
        if beta is not None:
            self._set(node, plus(before, self._principal(c, beta, whole=False)))

    def _principal(self, c: Prepared, beta: Sequence[Any], *, whole: bool) -> tuple[Any, ...]:
        """Return N beta, without its part along u that the output sees, unless whole."""
        total: Any = (0,) * len(c.u)
        for factor, vector in zip(beta, c.N, strict=True):
            total = plus(total, times(factor, vector))
        if whole:
            return total
        return plus(total, times(-1, times(read(c, total), c.u)))

    def _settle_principal(self, n: int) -> dict[Tree, tuple[Any, ...]]:
        """Find principal parts of order n - 1 >= 2 by back substitution; R(t) of the trees used."""
        if not self.complete:
            return {}
        smaller = trees(n - 1, self.palette)
        leaf = {c: single(below[0]) for c, below in self.palette.items()}
        larger = {s: tree((*s.children, leaf[s.colour]), s.colour) for s in smaller}
        right = {t: self._right(t) for t in larger.values()}
        residual = {t: apply(self.components[t.colour].W, x) for t, x in right.items()}
        if all(is_zero(x) is True for x in residual.values()):
            return right
        below = {t: [(s, m) for s, m in pruned(t).items() if s.order == n - 1] for t in right}
        ranked = sorted(
            smaller, key=lambda s: (-len(s.children), -s.children.count(leaf[s.colour]))
        )
        beta: dict[Tree, tuple[Any, ...]] = {}
        for s in ranked:
            t, ways = larger[s], 0
            value: Any = residual[t]
            for kept, count in below[t]:
                if kept is s:
                    ways = count
                elif kept in beta:
                    value = plus(value, times(-count, beta[kept]))
            value = times(Fraction(1, ways), value)
            if is_zero(value) is not True:
                beta[s] = value
        moved = {
            s: self._principal(self.components[s.colour], x, whole=self.free)
            for s, x in beta.items()
        }
        for s, x in moved.items():
            before = self.eta.get(s)
            self._set(s, x if before is None else plus(before, x))
        for t in right:
            for kept, count in below[t]:
                if kept in moved:
                    right[t] = plus(right[t], times(-count, moved[kept]))
        return right


def tableau_series(
    level: Callable[[int], Sequence[Tree]], table: Mapping[str, Any], p: int
) -> dict[Any, tuple[Any, ...]]:
    """Return the series of values ``B xiD``, xi = A xiD, by tree, and the multiples of y by colour.

    Parameters
    ----------
    level : callable
        The trees of an order.
    table : Mapping[str, Any]
        (A, B, multiples of y) by colour.
    p : int
        Last order.

    The stages are those of a :class:`StartingSeries` with eta = 0.
    """
    components = {
        c: Prepared(sparse(A), (), sparse(B), (), len(B[0]), tuple(u), (), (), (), certain=True)
        for c, (A, B, u) in table.items()
    }
    series = StartingSeries(components, dict.fromkeys(table, ""), free=False)
    found: dict[Any, tuple[Any, ...]] = {c: x.u for c, x in components.items()}
    for n in range(1, p + 1):
        for t in level(n):
            found[t] = series.output(t)
            if n < p:
                series.settle_stage(t)
    return found
