"""Order conditions of symmetric G-symplectic methods: the few that are needed, and why.

The starting series is zeta: trees -> C^r with zeta(empty) = e_1 and principal part zeta_1. A
method with ``V = 1 + V_2`` (block diagonal), ``1 - V_2`` regular, first column of U ones and ``G
= 1 + G_2`` gives, tree by tree (``etaD`` is the product of eta over the subtrees, ``etaD(o) =
1``),

    eta(t) = A etaD(t) + U zeta(t)             (M zeta)(t) = B etaD(t) + V zeta(t)
    (E zeta)(t) = zeta(t) + sum of zeta(kept) / prod gamma(removed) + e_1 / gamma(t)

(the sum runs over the ways to cut t so that its root is kept and something is removed), and
components 2..r of zeta(t) are *defined* by (M zeta - E zeta)_k(t) = 0. What is left is the
residual ``R(t) = (M zeta - E zeta)_1(t)``: the method has order p when R vanishes on all trees of
order <= p for some choice of zeta_1.

**Theorem 1 (moving the root).** Write t*u for t with u attached to its root,
``Q(t, u) = zeta(t)^T G zeta(u) - zeta_1(t*u) - zeta_1(u*t)``. For a G-symplectic method
``(M zeta)(t)^T G (M zeta)(u) - zeta(t)^T G zeta(u) = b^T etaD(t*u) + b^T etaD(u*t)`` (insert the
two equations and the three identities). So if R = 0 below order n = |t| + |u| and Q = 0 for all
pairs of total order < n, then ``R(t*u) + R(u*t) = 0``: the conditions of two rooted trees that
differ by one move of the root are equivalent, and one rooted tree is enough for each free tree;
it is satisfied by itself when the free tree is superfluous (t = u). Proof: subtract ``(E zeta)_1
- zeta_1`` on both sides. The left side becomes ``(E Q)(t, u) - Q(t, u)``, where (E Q) is the same
bilinear expression in E zeta; as ``E(t*u) + E(u*t) = E(t) E(u)`` for the exact flow, it is a
combination of Q on pruned pairs, of lower total order. (Butcher and Imran 2015 state this for
their normalisation of zeta.)

**Theorem 2 (choice of zeta_1).** At stage order 1, Q = 0 can always be achieved: given zeta_1 at
one rooted version of every free tree that is not superfluous, ``zeta_1(u*t) = zeta(t)^T G zeta(u)
- zeta_1(t*u)`` carries it to the others. The rooted versions of a free tree and their moves form
a tree (the quotient of the free tree by its automorphisms), with one loop where it is
superfluous, which then says ``zeta_1(t*t) = zeta(t)^T G zeta(t) / 2``: no equation is left over.
At higher stage order there are fewer values of zeta_1 and fewer conditions; what has to be
checked then is rational linear algebra, done in :mod:`glmref.prove.classes`.

**Theorem 3 (symmetry).** Let the method be symmetric with L e_1 = e_1 and L^T G L = G, and choose
zeta_1 = 0 at odd trees. If R = 0 below order n then ``zeta(t) = (-1)^|t| L zeta(t)`` for |t| <=
n, so Q(t, u) = 0 for |t| + |u| odd, and R(t) = 0 for |t| = n even. Proof: with S(h) the starting
method, ``M(h) S(h) = S(h) E(h) + e_1 R h^n + ...`` and symmetry, ``M(-h) L M(h) = L``, the method
S'(h) = L S(-h) satisfies the same equations with the same principal part, so S' = S; and ``L S(h)
= M(-h) L (S(h) E(h) + e_1 R h^n) = S(-h) + (-h)^n R e_1 + h^n R e_1`` leaves ``(1 + (-1)^n) R =
0``. The stages satisfy ``eta_(s+1-i)(h) = eta_i(-h) E(h)``: stage i has stage order q when its
mirror image has, and in the middle the defect of stage order vanishes at odd orders.

Together: a symmetric G-symplectic method of stage order q has even order p as soon as R = 0 at a
few trees of the odd orders 1, 3, .. below p (:func:`glmref.prove.classes.representatives`):

    q = 1:  1 + 1 + 3 + 11 trees for order 8 (one for each free tree), in place of 1 + 2 + 9 + 48
    q = 2:  1 + 0 + 1 + 3
    q = 3:  1 + 0 + 1 + 1

References
----------
    Butcher and Imran, "Order conditions for G-symplectic methods", BIT 55 (2015), 927-948;
    Butcher, "B-Series: Algebraic Analysis of Numerical Methods" (2021), sections 7.6 and 7.7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import factorial
from typing import Any

from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..theory.trees import Tree, pruned, trees
from .classes import classes, plan, reduce_tree

__all__ = ["Blocks", "Series", "starting_series"]


@dataclass(frozen=True, eq=False)
class Blocks:
    """The four matrices of a method over any scalar (exact, ball or jet), with G.

    V must be ``1 + V_2`` and G ``1 + G_2`` (block diagonal), the first column of U ones.
    """

    A: Matrix
    U: Matrix
    B: Matrix
    V: Matrix
    G: Matrix


@dataclass(frozen=True, eq=False)
class Series:
    """What the recursion found: stages eta(t), starting series zeta(t), residuals R(t)."""

    eta: Mapping[Tree, tuple[Any, ...]]
    zeta: Mapping[Tree, tuple[Any, ...]]
    residual: Mapping[Tree, Any]


def starting_series(
    blocks: Blocks,
    order: int,
    principal: Mapping[Tree, Any] | None = None,
    *,
    stage_order: int = 1,
    wanted: Sequence[Tree] | None = None,
) -> Series:
    """Compute eta, zeta and the residuals R tree by tree.

    Args:
        blocks: the method, as :class:`Blocks` asks.
        order: residuals are computed for trees up to this order.
        principal: zeta_1 at even trees where it is free; zero at free ones that are missing.
        stage_order: of the method: zeta_1 respects it.
        wanted: residuals at these trees only, and the series on classes only, which is all that is
            needed to solve; ``None`` means all trees.
    """
    A, U, B, V = blocks.A, blocks.U, blocks.B, blocks.V
    r, given = len(V), dict(principal or {})
    resolvent = _resolvent(V)
    eta: dict[Tree, tuple[Any, ...]] = {}
    zeta: dict[Tree, tuple[Any, ...]] = {}
    residual: dict[Tree, Any] = {}
    for n in range(1, order + 1):
        needed = n < order
        todo: Sequence[Tree] = trees(n)
        if wanted is not None:
            inner = classes(n, stage_order) if needed else ()
            todo = list(dict.fromkeys([*inner, *(t for t in wanted if t.order == n)]))
        first = _principal_parts(n, stage_order, given, zeta, blocks.G) if needed else {}
        for t in todo:
            derivative = _products(t, eta, len(A), stage_order)
            right = linalg.matvec(B, derivative)
            for kept, ways in pruned(t).items():
                if kept is not t:
                    below, factor = _look_up(kept, zeta, stage_order)
                    weight = factor * Fraction(ways, factorial(t.order - kept.order))
                    right = tuple(
                        x if y.is_zero() is True else x - y * weight
                        for x, y in zip(right, below, strict=True)
                    )
            residual[t] = right[0] - Fraction(1, t.density)
            if needed:
                reduced, factor = reduce_tree(t, stage_order)
                above = linalg.matvec(resolvent, right[1:]) if r > 1 else ()
                zeta[t] = (first[reduced] * factor, *above)
                stages, values = linalg.matvec(A, derivative), linalg.matvec(U, zeta[t])
                eta[t] = tuple(x + y for x, y in zip(stages, values, strict=True))
    return Series(eta=eta, zeta=zeta, residual=residual)


def _resolvent(V: Matrix) -> Matrix:
    """Inverse of 1 - V on the values 2..r."""
    r = range(1, len(V))
    rest = tuple(tuple((1 if i == j else 0) - V[i][j] for j in r) for i in r)
    return linalg.inverse(rest) if rest else ()


def _look_up(
    t: Tree, known: Mapping[Tree, tuple[Any, ...]], stage_order: int
) -> tuple[tuple[Any, ...], Fraction]:
    """Series value of a tree, or of its class with the factor."""
    if t in known:
        return known[t], Fraction(1)
    reduced, factor = reduce_tree(t, stage_order)
    return known[reduced], factor


def _products(
    t: Tree, eta: Mapping[Tree, tuple[Any, ...]], s: int, stage_order: int
) -> tuple[Any, ...]:
    """EtaD(t): stage by stage the product of eta over the subtrees."""
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
) -> dict[Tree, Any]:
    """zeta_1 at the classes of an order: Q = 0 on the defining pairs; zero at odd orders."""
    zero = Exact(0)
    if order % 2:
        return dict.fromkeys(classes(order, stage_order), zero)
    known = tuple(t for t in given if t.order == order)
    chosen = plan(order, stage_order, known)
    right = [linalg.dot(zeta[t], linalg.matvec(G, zeta[u])) for t, u in chosen.defining]
    right += [given.get(t, zero) for t in chosen.free]
    return dict(zip(chosen.classes, linalg.matvec(chosen.inverse, right), strict=True))
