"""Order conditions of symmetric G-symplectic methods: the few that are needed, and why.

A method has one component or, on separable systems, two; trees have one colour or two that
alternate along every edge. The starting series is zeta:
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
checked then is rational linear algebra, done in :mod:`glmref.judge.classes`. All principal parts
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
few trees of the odd orders 1, 3, .. below p (:func:`representatives`):

    q = 1:  1 + 1 + 3 + 11 trees for order 8 (one for each free tree), in place of 1 + 2 + 9 + 48
    q = 2:  1 + 0 + 1 + 3
    q = 3:  1 + 0 + 1 + 1
    pairs:  2 + 2 + 6 + 22 trees for order 8; 2 + 2 + 4 + 10 on second-order systems

With r = r^ = 1, where a pair is a product of flows, :mod:`glmref.judge.lie` says which of these
suffice.

**Classes.** Where every stage satisfies ``eta_i(t) = c_i^|t| / gamma(t)`` for |t| <= q (stage order
q), a subtree t with |t| <= q below some vertex may be replaced by |t| leaves there, with the factor
1/gamma(t): the ideal of these relations is mapped into itself by cutting (both sides are the exact
flow at c_i), so by induction on the order zeta, eta and R take the factor too, as soon as zeta_1
does. Trees without such subtrees are the *classes*; with q = 1, which is supposed where there are
two colours, every tree is one. On classes the theorems are linear statements with rational
coefficients. Unknown to them are zeta_1 and the pair defects Q at an even order n, and the
residuals R at n + 1. As many pairs as zeta_1 has independent values on them *define* zeta_1 by Q =
0 (for q = 1 all pairs, theorem 2), and at some classes it stays free. The identities ``R(t*u) +
R(u*t) = (E Q)(t, u) - Q(t, u)`` of order n + 1 and some given equations R = 0 may leave only the
zero solution: then all of R at n + 1 and all of Q at n vanish, and the induction goes on.

Of two colours the trees that count are all that alternate, or those that count on second-order
systems, where f is linear and a vertex f has at most two neighbours. A version whose root f has two
children has no elementary differential, but it stands between two versions that have one, and
residuals of such versions vanish with those of their neighbours. There are 1, 1, 1, 2, 3, 6, 11
free trees (rooted ones up to moves) of one colour of the orders 1 to 7, 2, 1, 2, 3, 6, 10, 22 of
two and 2, 1, 2, 2, 4, 5, 10 on second-order systems. A free tree with an edge whose ends are alike,
t*t, is *superfluous*; there is none of two colours, where the ends of an edge differ.

The series, the residuals and what follows from what are the judge's (:mod:`glmref.judge.classes`,
``enclosed_sweep``, ``enclosed_pair``); here is said which trees a finder names.

References
----------
    Butcher and Imran, "Order conditions for G-symplectic methods", BIT 55 (2015), 927-948;
    Butcher, "B-Series: Algebraic Analysis of Numerical Methods" (2021), sections 7.6 and 7.7.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache

from ..judge.classes import Span, identities, pairs_of, reduced, spread_of
from ..judge.enclosed_pair import second_order
from ..judge.trees import read_tree, versions
from ..method.component import SEPARABLE
from ..theory.trees import trees

#: Rooted versions that stand for their free trees where there is a choice.
_PREFERRED = ("o", "[oo]", "[oooo]", "[oo[o]]", "[[o][o]]", "[ooo]")


@cache
def classes(order: int, q: int) -> tuple[str, ...]:
    """Return the trees of an order and one colour that are their own class."""
    texts = [(str(t), read_tree(str(t))) for t in trees(order)]
    return tuple(text for text, t in texts if reduced(t, q)[0] == t)


def _chosen(span: Span, texts: Iterable[str], q: int) -> tuple[str, ...]:
    """Return those of some trees whose values are independent of a span and of those before."""
    return tuple(t for t in dict.fromkeys(texts) if span.add({reduced(read_tree(t), q)[0]: 1}))


@cache
def free_trees(order: int, q: int, given: tuple[str, ...] = ()) -> tuple[str, ...]:
    """Return trees of an even order where zeta_1 is free, at stage order q, those given first."""
    span = Span()
    for pair in pairs_of(order, q):
        span.add(spread_of(*pair, q))
    return _chosen(span, (*given, *classes(order, q)), q)


@cache
def representatives(order: int, q: int = 1) -> tuple[str, ...]:
    """Return trees whose conditions give all others of an odd order: as few as there can be.

    One for each free tree at stage order 1: 1, 1, 3, 11 for the orders 1, 3, 5, 7; at stage order
    2: 1, 0, 1, 3; at stage order 3: 1, 0, 1, 1, 3 (order 9).
    """
    if order == 1:
        return ("o",)
    span, _ = identities(order, q, tuple(map(read_tree, free_trees(order - 1, q))))
    names = [str(t) for t in trees(order)]
    preferred = [t for t in _PREFERRED if t in names]
    return _chosen(span, (*preferred, *classes(order, q)), q)


@cache
def one_of_each(order: int, *, nystrom: bool = False) -> tuple[str, ...]:
    """Return one rooted version of each free tree of two colours.

    With ``nystrom`` only of those that count on second-order systems.
    """
    found: dict[object, str] = {}
    for text in map(str, trees(order, SEPARABLE)):
        t = read_tree(text)
        if not nystrom or second_order(t):
            found.setdefault(versions(t), text)
    return tuple(found.values())
