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

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cache
from types import SimpleNamespace
from typing import Any, Self

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.judging import (
    Fraction,
    as_number,
    as_numbers,
    as_scalar,
    fast_judge,
    kept_whole,
)
from ..exact.linalg import Matrix, Vector
from ..judge.refusals import Refused
from ..method.component import Palette
from ..method.model import Method
from ..method.preconsistency import first_functional
from ..method.stage_order import is_shared
from ..system.budget import spend
from .coefficients import is_zero
from .trees import Tree, paths, single, trees

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
    A, U, B : Matrix
        Of the method.
    u : Vector
        V u = u, U u = 1.
    N, W
        See the module docstring; N by columns.
    output : Vector
        w with w u = 1 that reads the solution off the values: the declared one, or that of
        the first k with u_k not 0.
    lift : Matrix
        R -> the solution x of (I - V) x = R with w x = 0, for W R = 0.
    certain : bool
        Whether U u = 1 exactly.
    """

    A: Matrix
    U: Matrix
    B: Matrix
    W: Matrix
    u: Vector
    N: tuple[Vector, ...]
    output: Vector
    lift: Matrix
    certain: bool


def read(c: Prepared, values: Sequence[Any]) -> Any:
    """Return the solution that a vector of values holds: what the output functional sees of it."""
    return linalg.dot(c.output, values)


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
    return Prepared(A, U, B, W, u, tuple(N), w, lift, certain)


def _lift(D: Matrix, N: Sequence[Vector], left: Sequence[Vector], u: Vector, w: Vector) -> Matrix:
    """Solve (I - V) x = R up to the part that W sees, through the bordered matrix."""
    r, d = len(D), len(N)
    rows = [(*(-x for x in D[i]), *(left[k][i].conjugate() for k in range(d))) for i in range(r)]
    rows += [(*(x.conjugate() for x in v), *([_ZERO] * d)) for v in N]
    solve = tuple(row[:r] for row in linalg.inverse(tuple(rows))[:r])
    shadow = linalg.vecmat(w, solve)
    return tuple(
        tuple(x - u[i] * y for x, y in zip(row, shadow, strict=True)) for i, row in enumerate(solve)
    )


@dataclass(frozen=True)
class Judged:
    """The starting series that the judge has of an exact method.

    Attributes
    ----------
    series : Any
        Of :class:`glmref.judge.series.Solved`.
    kept : Callable[[tuple, Callable[[], Any]], Any]
        Returns what the judge has made of the method under a name, or makes it.
    scalar : Callable[[Any], Scalar]
        Returns one of its numbers as one of the package.
    """

    series: Any
    kept: Callable[[tuple[Any, ...], Callable[[], Any]], Any]
    scalar: Callable[[Any], Scalar]


class StartingSeries:
    """The one starting series of a method, up to what is free, and the residuals beyond.

    The series is that of the judge, :class:`glmref.judge.series.Solved`, over the numbers of the
    package; what is added here is what a finder asks of it.

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
    judged : Judged or None
        The series that the judge has of the same exact method, where 1 is a simple eigenvalue of
        each V: it is gone on with, so that no condition is evaluated twice.

    Attributes
    ----------
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
        judged: Judged | None = None,
    ) -> None:
        self.components: dict[str, Prepared] = components
        self.palette: Palette = palette
        self.free: bool = free
        self.counts: Callable[[Tree], bool] = counts
        self.along_paths: bool = along_paths
        self.simple: bool = all(len(c.N) == 1 for c in components.values())
        self.determined: frozenset[Tree] = frozenset()
        self.judged: Judged | None = judged
        self._order, self._settled = 0, False
        self._own: Any = None

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
        (Exact(0), Exact(-1))
        """
        components = {c.colour: component(*c.matrices, c.output) for c in method.components}
        return cls(components, method.palette, free=free, counts=counts, along_paths=along_paths)

    @property
    def solved(self) -> Any:
        """The series of the judge that conditions are evaluated on."""
        if self.judged is not None:
            return self.judged.series
        if self._own is None:
            self._own = _solver()(self)
        return self._own

    def scalars(self, values: Iterable[Any]) -> Vector:
        """Return numbers of the series as numbers of the package."""
        scalar = as_scalar if self.judged is None else self.judged.scalar
        return tuple(map(scalar, values))

    @property
    def order(self) -> int:
        """The order that was reached."""
        return self._order

    @property
    def complete(self) -> bool:
        """Whether a residual that is not zero excludes every starting series."""
        return self.simple or (len(self.components) == 1 and not self.solved.loose)

    def level(self, n: int) -> list[Tree]:
        """Return the trees of an order that count."""
        if self.along_paths:
            return list(filter(self.counts, paths(n, tuple(self.palette.items()))))
        return list(filter(self.counts, trees(n, self.palette)))

    def value(self, t: Tree) -> Vector:
        """Return eta(t)."""
        found = self.solved.eta.get(t.judged)
        return (_ZERO,) * len(self.components[t.colour].u) if found is None else self.scalars(found)

    @property
    def eta(self) -> Mapping[Tree, Vector]:
        """The values that are not zero, by tree."""
        values = {t: self.value(t) for n in range(1, self.order + 1) for t in self.level(n)}
        return {t: x for t, x in values.items() if is_zero(x) is not True}

    def plain(self, t: Tree) -> Vector:
        """Return eta(t) with its principal part zero; the conditions of its order are known."""
        right = self.solved.right(t.judged)
        return self.scalars(fast_judge().series.apply(self.solved.lift[t.colour], right))

    def output(self, t: Tree) -> Vector:
        """Return B xiD(t)."""
        return self.scalars(self.solved.value(t.judged))

    def abscissae(self, colour: str) -> Vector:
        """Return c = xi of the single node: a stage stands at ``t + c_i h``; of order 2 or more."""
        return self.scalars(self.solved.stages((colour, ())))

    def stage_defect(self, t: Tree) -> Vector:
        """Return ``xi(t) - c^|t| / gamma(t)``, stage by stage."""
        defect = fast_judge().rules_orders.stage_defect
        return self.scalars(defect(self.solved, t.judged, False))

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
        with within_limits():
            self.solved.advance(n)
        self._order, self._settled = min(n, self.solved.order), False
        used = self.free and n > 2 and self.complete
        leaf = {c: single(below[0]) for c, below in self.palette.items()} if used else {}
        smaller = trees(n - 1, self.palette) if used else ()
        self.determined = frozenset(s * leaf[s.colour] for s in smaller)
        return self.level(n)

    def residual(self, t: Tree) -> Vector:
        """Return ``W R(t)`` of a tree of the last order, 0 where it determines a principal part."""
        if t in self.determined:
            return (_ZERO,) * len(self.components[t.colour].N)
        spend()
        return self.scalars(self.solved.condition(t.judged))

    def settle(self) -> None:
        """Find eta at the trees of the last order, but for the principal parts."""
        with within_limits():
            self.solved.fill()
        self._settled = True


@contextmanager
def within_limits() -> Iterator[None]:
    """Say of more trees than the judge lists that nothing is decided."""
    try:
        with kept_whole():
            yield
    except Refused as error:
        raise ExactnessError(str(error)) from error


def _scalars(values: list) -> Vector:
    return tuple(map(as_scalar, values))


@cache
def _solver() -> Any:
    """Return the series of the judge as a class for prepared components."""
    series = fast_judge().series

    class Made(series.Solved):
        """The series of the judge where u, N, W, the output and the trees are given."""

        def __init__(self, of: StartingSeries) -> None:
            self.of, self.simple = of, of.simple
            self.begin(of.free)
            for colour, c in of.components.items():
                self.u[colour], self.w[colour], *self.N[colour] = as_numbers((c.u, c.output, *c.N))
                self.W[colour], self.lift[colour], A, U, B = map(
                    as_numbers, (c.W, c.lift, c.A, c.U, c.B)
                )
                self.k[colour] = None
                self.parts[colour] = series.Component(
                    *map(series.Matrix, (A, U, B)), [[]] * len(c.u)
                )
            palette, separable = tuple(of.palette.items()), not is_shared(of.palette)
            self.method = SimpleNamespace(
                palette=palette, parts=self.parts, part=self.part, separable=separable
            )
            self.solved = not of.free and all(m.r == 1 for m in self.parts.values())
            self.share_stages()

        def pool(self, order: int) -> list:
            return [t.judged for t in self.of.level(order)]

        def cut_value(self, s: Any) -> list:
            return self.eta.get(s) or [Fraction(0)] * len(self.u[s[0]])

        def give(self, t: Tree, value: Sequence[Any]) -> None:
            self.eta[t.judged] = list(map(as_number, value))

        def settle_all(self) -> None:
            """Take the multiple eigenvalue 1 of one V; that of several is left open."""
            if not self.of.complete:
                return
            try:
                if self.order > 1:
                    self.settle()
                else:
                    self.settle_first()
            except Refused:
                self.loose = True
                return
            for t in self.pool(self.order) if self.order == 1 or not self.free else ():
                read = series.dot(self.w[t[0]], self.eta[t])
                self.eta[t] = [x - read * y for x, y in zip(self.eta[t], self.u[t[0]], strict=True)]

        def settle_first(self) -> None:
            """Take the principal part of order 1; where none is found, that of most conditions.

            The others solve all rows of (K - I) beta = -W R([o]), K = W B U N, but those that
            contradict these: that the corank is 1 is proved over balls, too. What is left free is
            the shift along the flow, a multiple of W u.
            """
            before, decided = dict(self.eta), False
            with suppress(Refused):
                super().settle_all()
                decided = self.last is not None  # there is none
                if not decided:
                    return
            self.eta, self.last = before, None
            (node,) = self.pool(1)
            c = self.of.components[node[0]]
            columns = [linalg.matvec(c.W, linalg.matvec(c.B, linalg.matvec(c.U, x))) for x in c.N]
            square = linalg.sub(linalg.transpose(tuple(columns)), linalg.identity(len(columns)))
            residual = _scalars(self.condition((node[0], (node,))))
            found = linalg.solve_affine(square, tuple(-x for x in residual))
            if len(found.directions) == 1:
                self.move(node, list(map(as_number, found.point)))
            elif not decided:
                raise Refused("no principal part of order 1 is shown to be the only one")

    return Made


def tableau(table: Mapping[str, Any]) -> Any:
    """Return the series of stages and values (A, B) by colour, as the judge has it."""
    tables = {c: (as_numbers(A), as_numbers(B)) for c, (A, B, *_) in table.items()}
    return fast_judge().series.Series.of_tables(tables)


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
    """
    series = tableau(table)
    found: dict[Any, tuple[Any, ...]] = {c: tuple(u) for c, (_, _, u) in table.items()}
    for n in range(1, p + 1):
        found |= {t: _scalars(series.value(t.judged)) for t in level(n)}
    return found
