"""Order conditions of symmetric G-symplectic methods: the few that are needed, and why.

A method has one component or, on separable systems, two; trees have one colour or two that
alternate along every edge (:class:`glmref.prove.classes.Family`). The starting series is zeta:
trees -> C^r with zeta(empty) = e_1 and principal part zeta_1, where the root of a tree says to
which component its value belongs. Write A, U, B, V for the matrices of the component of the root of
t, and G for the form between the values of the roots of t and u (G, or G^T where u comes first).
With ``V = 1 + V_2`` (block diagonal), ``1 - V_2`` regular, first column of U ones and ``G = 1 +
G_2``, a method gives, tree by tree (``etaD`` is the product of eta over the subtrees, ``etaD(o) =
1``),

    eta(t) = A etaD(t) + U zeta(t)             (M zeta)(t) = B etaD(t) + V zeta(t)
    (E zeta)(t) = zeta(t) + sum of zeta(kept) / prod gamma(removed) + e_1 / gamma(t)

(the sum runs over the ways to cut t so that its root is kept and something is removed), and
components 2..r of zeta(t) are *defined* by (M zeta - E zeta)_k(t) = 0. What is left is the
residual ``R(t) = (M zeta - E zeta)_1(t)``: the method has order p when R vanishes on all trees of
order <= p for some choice of zeta_1.

**Theorem 1 (moving the root).** Write t*u for t with u attached to its root,
``Q(t, u) = zeta(t)^T G zeta(u) - zeta_1(t*u) - zeta_1(u*t)``. If R = 0 below order n = |t| + |u|
and Q = 0 for all pairs of total order < n, then ``R(t*u) + R(u*t) = 0``: the conditions of two
rooted trees that differ by one move of the root are equivalent, and one rooted tree is enough for
each free tree; it is satisfied by itself when the free tree is superfluous (t = u). Proof: for a
G-symplectic method ``(M zeta)(t)^T G (M zeta)(u) - zeta(t)^T G zeta(u) = d^T etaD(t*u) + d^T
etaD(u*t)``, each with the weights d of its root (insert the two equations and the three
identities; the mixed term is ``etaD(t)^T (B^T G B) etaD(u)`` with ``B^T G B = D A + A^T D``, A of
one component and of the other). Subtract ``(E zeta)_1 - zeta_1`` on both sides. The left side
becomes ``(E Q)(t, u) - Q(t, u)``, where (E Q) is the same bilinear expression in E zeta; as
``E(t*u) + E(u*t) = E(t) E(u)`` for the exact flow, it is a combination of Q on pruned pairs, of
lower total order. (Butcher and Imran 2015 state this for one component and their normalisation of
zeta.)

**Theorem 2 (choice of zeta_1).** At stage order 1, Q = 0 can always be achieved: given zeta_1 at
one rooted version of every free tree that is not superfluous, ``zeta_1(u*t) = zeta(t)^T G zeta(u)
- zeta_1(t*u)`` carries it to the others. The rooted versions of a free tree and their moves form
a tree (the quotient of the free tree by its automorphisms), with one loop where it is
superfluous, which then says ``zeta_1(t*t) = zeta(t)^T G zeta(t) / 2``: no equation is left over.
At higher stage order there are fewer values of zeta_1 and fewer conditions; what has to be
checked then is rational linear algebra, done in :mod:`glmref.prove.classes`. All principal parts
are zero (no finishing method: the first values are the solution) where ``zeta(t)^T G zeta(u) = 0``
for all pairs below the order.

**Theorem 3 (symmetry).** Let the method be symmetric with L e_1 = e_1 and L^T G L = G (L of either
component), and choose zeta_1 = 0 at odd trees. If R = 0 below order n then ``zeta(t) = (-1)^|t| L
zeta(t)`` for |t| <= n, so Q(t, u) = 0 for |t| + |u| odd, and R(t) = 0 for |t| = n even. Proof: with
S(h) the starting method, ``M(h) S(h) = S(h) E(h) + e_1 R h^n + ...`` and symmetry, ``M(-h) L M(h) =
L``, the method S'(h) = L S(-h) satisfies the same equations with the same principal part, so S' =
S; and ``L S(h) = M(-h) L (S(h) E(h) + e_1 R h^n) = S(-h) + (-h)^n R e_1 + h^n R e_1`` leaves ``(1 +
(-1)^n) R = 0``. The stages satisfy ``eta_(s+1-i)(h) = eta_i(-h) E(h)``: stage i has stage order q
when its mirror image has, and in the middle the defect of stage order vanishes at odd orders.

Together: a symmetric G-symplectic method of stage order q has even order p as soon as R = 0 at a
few trees of the odd orders 1, 3, .. below p (:func:`glmref.prove.classes.representatives`):

    q = 1:  1 + 1 + 3 + 11 trees for order 8 (one for each free tree), in place of 1 + 2 + 9 + 48
    q = 2:  1 + 0 + 1 + 3
    q = 3:  1 + 0 + 1 + 1
    pairs:  2 + 2 + 6 + 22 trees for order 8; 2 + 2 + 4 + 10 on second-order systems

With r = r^ = 1, where a pair is a product of flows, :mod:`glmref.judge.lie` says which of these
suffice.

References
----------
    Butcher and Imran, "Order conditions for G-symplectic methods", BIT 55 (2015), 927-948;
    Butcher, "B-Series: Algebraic Analysis of Numerical Methods" (2021), sections 7.6 and 7.7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from math import factorial
from typing import Any

from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..method.component import Component
from ..theory.trees import Tree, pruned
from .classes import Family, classes, plan, reduce_tree


@dataclass(frozen=True, eq=False)
class Series:
    """What the recursion found: stages eta(t), starting series zeta(t), residuals R(t)."""

    eta: Mapping[Tree, tuple[Any, ...]]
    zeta: Mapping[Tree, tuple[Any, ...]]
    residual: Mapping[Tree, Any]


def starting_series(
    components: Sequence[Component],
    G: Matrix,
    order: int,
    principal: Mapping[Tree, Any] | None = None,
    *,
    family: Family = Family.ROOTED,
    stage_order: int = 1,
    identity: bool = False,
    wanted: Sequence[Tree] | None = None,
) -> Series:
    """Compute eta, zeta and the residuals R tree by tree.

    Parameters
    ----------
    components : Sequence[Component]
        One or two, over any scalar (exact, ball or jet), in the form that the module docstring asks
        for.
    G : Matrix
        (r, r), of two components (r, r^).
    order : int
        Residuals are computed for trees up to this order.
    principal : Mapping[Tree, Any] or None
        zeta_1 at even trees where it is free; zero at free ones that are missing.
    family : Family
        The trees that count.
    stage_order : int
        Of the method: zeta_1 respects it.
    identity : bool
        Whether every principal part is zero, whatever theorem 2 would give.
    wanted : Sequence[Tree] or None
        Residuals at these trees only, and the series on classes only, which is all that is needed
        to solve; ``None`` means all trees.
    """
    blocks = {c.colour: c for c in components}
    resolvents = {c.colour: _resolvent(c.V) for c in components}
    last = components[-1].colour
    given = {t: x for t, x in (principal or {}).items() if t in family}
    zero = Exact(0)
    eta: dict[Tree, tuple[Any, ...]] = {}
    zeta: dict[Tree, tuple[Any, ...]] = {}
    residual: dict[Tree, Any] = {}
    one_step = identity and all(len(c.V) == 1 for c in components)  # zeta is zero
    inside = _subtrees(wanted) if one_step and wanted is not None else None
    for n in range(1, order + 1):
        needed = n < order
        todo = classes(n, 1, family)
        if inside is not None:
            todo = tuple(t for t in inside if t.order == n)
        elif wanted is not None:
            inner = classes(n, stage_order, family) if needed else ()
            todo = tuple(dict.fromkeys([*inner, *(t for t in wanted if t.order == n)]))
        first: Mapping[Tree, Any] = {}
        if needed and not identity and n % 2 == 0:
            first = _principal_parts(n, stage_order, given, zeta, G, family, last)
        for t in todo:
            c = blocks[t.colour]
            derivative = _products(t, eta, len(c.A[0]), stage_order)
            right = linalg.matvec(c.B, derivative)
            weights, below = [], []
            for kept, ways in () if one_step else pruned(t).items():
                if kept is not t:
                    value, factor = _look_up(kept, zeta, stage_order)
                    size = factorial(t.order - kept.order) * factor.denominator
                    weights.append(_share(ways * factor.numerator, size))
                    below.append(value)
            right = _minus_weighted(right, weights, below)
            residual[t] = right[0] - Fraction(1, t.density)
            if needed:
                reduced, factor = reduce_tree(t, stage_order)
                above = linalg.matvec(resolvents[t.colour], right[1:])
                zeta[t] = (first.get(reduced, zero) * factor, *above)
                stages, values = linalg.matvec(c.A, derivative), linalg.matvec(c.U, zeta[t])
                eta[t] = tuple(x + y for x, y in zip(stages, values, strict=True))
    return Series(eta=eta, zeta=zeta, residual=residual)


def _subtrees(given: Sequence[Tree]) -> list[Tree]:
    """Return the trees with everything that stands in them, each once."""
    found: dict[Tree, None] = {}
    waiting = list(given)
    while waiting:
        t = waiting.pop()
        if t not in found:
            found[t] = None
            waiting += t.children
    return list(found)


@lru_cache(maxsize=4096)
def _share(ways: int, size: int) -> Exact:
    """Return ``ways / size``, the same object each time."""
    return Exact(Fraction(ways, size))


def _minus_weighted(
    x: tuple[Any, ...], weights: Sequence[Exact], vectors: Sequence[Sequence[Any]]
) -> tuple[Any, ...]:
    """Return ``x - sum weights_k vectors_k``."""
    if not vectors:
        return x
    columns = zip(*vectors, strict=True)
    return tuple(y - linalg.dot(weights, column) for y, column in zip(x, columns, strict=True))


def _resolvent(V: Matrix) -> Matrix:
    """Return the inverse of 1 - V on the values 2..r."""
    r = range(1, len(V))
    rest = tuple(tuple((1 if i == j else 0) - V[i][j] for j in r) for i in r)
    return linalg.inverse(rest) if rest else ()


def _look_up(
    t: Tree, known: Mapping[Tree, tuple[Any, ...]], stage_order: int
) -> tuple[tuple[Any, ...], Fraction]:
    """Return series value of a tree, or of its class with the factor."""
    if t in known:
        return known[t], Fraction(1)
    reduced, factor = reduce_tree(t, stage_order)
    return known[reduced], factor


def _products(
    t: Tree, eta: Mapping[Tree, tuple[Any, ...]], s: int, stage_order: int
) -> tuple[Any, ...]:
    """Return etaD(t): stage by stage the product of eta over the subtrees."""
    result: tuple[Any, ...] = (Exact(1),) * s
    for child in t.children:
        below, factor = _look_up(child, eta, stage_order)
        if factor != 1:
            below = tuple(x * factor for x in below)
        result = tuple(x * y for x, y in zip(result, below, strict=True))
    return result


def _principal_parts(
    order: int,
    stage_order: int,
    given: Mapping[Tree, Any],
    zeta: Mapping[Tree, tuple[Any, ...]],
    G: Matrix,
    family: Family,
    last: str,
) -> dict[Tree, Any]:
    """Return zeta_1 at the classes of an even order: Q = 0 on the defining pairs."""
    known = tuple(t for t in given if t.order == order)
    chosen = plan(order, stage_order, known, family)
    right: list[Any] = []
    for pair in chosen.defining:
        t, u = pair if pair[1].colour == last else pair[::-1]  # G has the last colour on its right
        right.append(linalg.dot(zeta[t], linalg.matvec(G, zeta[u])))
    right += [given.get(t, Exact(0)) for t in chosen.free]
    return dict(zip(chosen.classes, linalg.matvec(chosen.inverse, right), strict=True))
