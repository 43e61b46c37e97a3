"""Trees up to stage order, pairs of trees, and what follows from what: rational linear algebra.

A :class:`Family` is a set of trees that is closed under cutting branches and under *moves* of the
root (writing t*u for t with u attached to its root, from t*u to u*t): all trees of one colour; of
two, alternating along every edge (separable systems); of the latter those that count on
second-order systems, where f is linear and a vertex f has at most two neighbours. A version whose
root f has two children has no elementary differential, but it stands between two versions that have
one, and residuals of such versions vanish with those of their neighbours. There are 1, 1, 1, 2, 3,
6, 11 free trees (rooted ones up to moves) of one colour of the orders 1 to 7, 2, 1, 2, 3, 6, 10, 22
of two and 2, 1, 2, 2, 4, 5, 10 on second-order systems. A free tree with an edge whose ends are
alike, t*t, is *superfluous*; there is none of two colours, where the ends of an edge differ.

Where every stage satisfies ``eta_i(t) = c_i^|t| / gamma(t)`` for |t| <= q (stage order q), a
subtree t with |t| <= q below some vertex may be replaced by |t| leaves there, with the factor
1/gamma(t): the ideal of these relations is mapped into itself by cutting (both sides are the
exact flow at c_i), so by induction on the order zeta, eta and R take the factor too, as soon as
zeta_1 does. Trees without such subtrees are the *classes*; with q = 1, which is supposed where
there are two colours, every tree is one.

On classes the theorems of :mod:`glmref.prove.equations` are linear statements with rational
coefficients. Unknown to them are zeta_1 and the pair defects Q at an even order n, and the
residuals R at n + 1:

* :func:`plan` chooses pairs (t, u), as many as zeta_1 has independent values on them, where Q = 0
  *defines* zeta_1, and classes where zeta_1 stays free. For q = 1 these are all pairs (theorem
  2).
* The judge (``conditions_follow``) decides whether the identities ``R(t*u) + R(u*t) = (E Q)(t, u)
  - Q(t, u)`` of order n + 1 and some given equations R = 0 leave only the zero solution: then all
  of R at n + 1 and all of Q at n vanish, and the induction goes on. :func:`representatives` lists
  as few equations as there can be.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from functools import cache
from math import factorial

from ..errors import DataError
from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..judge.classes import Span
from ..method.component import ROOTED, SEPARABLE, Palette
from ..theory.trees import Tree, is_nystrom, parse_tree, pruned, single, tree, trees

Pair = tuple[Tree, Tree]

#: Rooted versions that stand for their free trees where there is a choice.
_PREFERRED = ("o", "[oo]", "[oooo]", "[oo[o]]", "[[o][o]]", "[ooo]")


class Family(Enum):
    """Trees that count together: see the module docstring."""

    ROOTED = "rooted"
    SEPARABLE = "separable"
    SECOND_ORDER = "second-order"

    @property
    def palette(self) -> Palette:
        """Colours with the colours of their neighbours."""
        return ROOTED if self is Family.ROOTED else SEPARABLE

    def __contains__(self, t: object) -> bool:
        return (
            isinstance(t, Tree)
            and t.colour in self.palette
            and _fits(t, self)
            and (self is not Family.SECOND_ORDER or second_order(t))
        )


@cache
def _fits(t: Tree, family: Family) -> bool:
    """Return whether every edge of a tree joins colours that may be neighbours."""
    allowed = family.palette[t.colour]
    return all(x.colour in allowed and _fits(x, family) for x in t.children)


@cache
def _listed(order: int, family: Family) -> tuple[Tree, ...]:
    """Return all trees of an order that belong to a family."""
    whole = trees(order, family.palette)
    return tuple(t for t in whole if family is not Family.SECOND_ORDER or second_order(t))


@cache
def second_order(t: Tree) -> bool:
    """Return whether every vertex f of the free tree has at most two neighbours."""
    allowed = 2 if t.colour == "f" else t.order
    return len(t.children) <= allowed and all(map(is_nystrom, t.children))


@cache
def reduce_tree(t: Tree, q: int) -> tuple[Tree, Fraction]:
    """Return the class of a tree at stage order q, and its factor."""
    if q == 1:
        return t, Fraction(1)
    children: list[Tree] = []
    factor = Fraction(1)
    for child in t.children:
        if 1 < child.order <= q:
            children += [single()] * child.order
            factor /= child.density
        else:
            below, times = reduce_tree(child, q)
            children.append(below)
            factor *= times
    return tree(children), factor


@cache
def classes(order: int, q: int, family: Family = Family.ROOTED) -> tuple[Tree, ...]:
    """Return the trees of an order that are their own class."""
    return tuple(t for t in _listed(order, family) if reduce_tree(t, q)[0] is t)


@cache
def pairs(order: int, q: int, family: Family = Family.ROOTED) -> tuple[Pair, ...]:
    """Return unordered pairs (t, u) of classes of this total order with t*u in the family."""
    found: list[Pair] = []
    for n in range(1, order // 2 + 1):
        for i, t in enumerate(classes(n, q, family)):
            for j, u in enumerate(classes(order - n, q, family)):
                if (n < order - n or i <= j) and t * u in family:
                    found.append((t, u))
    return tuple(found)


def _spread(pair: Pair, index: dict[Tree, int], q: int, size: int) -> list[Fraction]:
    """Return coefficients of ``x(t*u) + x(u*t)`` in the values of x at the classes."""
    row = [Fraction(0)] * size
    t, u = pair
    for grown in (t * u, u * t):
        reduced, factor = reduce_tree(grown, q)
        row[index[reduced]] += factor
    return row


@dataclass(frozen=True)
class Plan:
    """How zeta_1 is found at one even order.

    Attributes
    ----------
    classes : tuple[Tree, ...]
        The unknown values, in this order.
    defining : tuple[Pair, ...]
        Pairs with Q = 0 by definition.
    leftover : tuple[Pair, ...]
        Pairs where Q = 0 has to be proved.
    free : tuple[Tree, ...]
        Classes whose value is given (by a file's ``xi``, else zero).
    inverse : Matrix
        Maps (zeta(t)^T G zeta(u) over ``defining``, values over ``free``) to zeta_1.
    """

    classes: tuple[Tree, ...]
    defining: tuple[Pair, ...]
    leftover: tuple[Pair, ...]
    free: tuple[Tree, ...]
    inverse: Matrix


@cache
def plan(order: int, q: int, given: tuple[Tree, ...] = (), family: Family = Family.ROOTED) -> Plan:
    """Choose the defining pairs and the free classes at an even order.

    Parameters
    ----------
    order : int
        even.
    q : int
        Stage order.
    given : tuple[Tree, ...]
        Trees at which zeta_1 is given; other free classes are chosen after them.
    family : Family
        Of the trees that count.

    Raises
    ------
    DataError
        When zeta_1 cannot be given at these trees.
    """
    unknown = classes(order, q, family)
    index = {t: i for i, t in enumerate(unknown)}
    size, span = len(unknown), Span()
    rows: list[list[Fraction]] = []
    defining: list[Pair] = []
    leftover: list[Pair] = []
    for pair in pairs(order, q, family):
        row = _spread(pair, index, q, size)
        if span.add(dict(enumerate(row))):
            rows.append(row)
            defining.append(pair)
        else:
            leftover.append(pair)
    free: list[Tree] = []
    for t in dict.fromkeys((*given, *unknown)):
        reduced, factor = reduce_tree(t, q)
        row = [factor if i == index[reduced] else Fraction(0) for i in range(size)]
        if span.add(dict(enumerate(row))):
            rows.append(row)
            free.append(t)
        elif t in given:
            raise DataError(
                f"zeta_1({t}) is not free at stage order {q}: it follows from the others"
            )
    matrix = tuple(tuple(Exact(x) for x in row) for row in rows)
    return Plan(unknown, tuple(defining), tuple(leftover), tuple(free), linalg.inverse(matrix))


@cache
def _cuts(t: Tree, q: int) -> tuple[tuple[Tree, Fraction], ...]:
    """Return classes left when t is cut, root kept (t included), with the sum of 1/prod gamma."""
    found: dict[Tree, Fraction] = {}
    for kept, ways in pruned(t).items():
        reduced, factor = reduce_tree(kept, q)
        weight = factor * Fraction(ways, factorial(t.order - kept.order))
        found[reduced] = found.get(reduced, Fraction(0)) + weight
    return tuple(found.items())


def _identities(
    order: int, q: int, family: Family
) -> tuple[dict[object, int], list[list[Fraction]]]:
    """Return the identities of an odd order: unknowns (R at classes, leftover Q below) and rows."""
    leftover = plan(order - 1, q, family=family).leftover if q > 1 else ()
    by_class = {t: i for i, t in enumerate(classes(order, q, family))}
    index: dict[object, int] = {**by_class}
    for pair in leftover:
        index[pair] = len(index)
    rows = []
    for t, u in pairs(order, q, family):
        row = _spread((t, u), by_class, q, len(index))
        for a, x in _cuts(t, q) if leftover else ():
            for b, y in _cuts(u, q):
                at = index.get((a, b), index.get((b, a)))
                if a.order + b.order == order - 1 and at is not None:
                    row[at] -= x * y
        rows.append(row)
    return index, rows


@cache
def representatives(order: int, q: int = 1, family: Family = Family.ROOTED) -> tuple[Tree, ...]:
    """Return trees whose conditions give all others of their order: as few as there can be.

    One for each free tree at stage order 1: 1, 1, 3, 11 for the orders 1, 3, 5, 7 and one colour;
    at stage order 2, of odd orders, 1, 0, 1, 3; at stage order 3: 1, 0, 1, 1, 3 (order 9).
    """
    if order == 1:
        return classes(1, q, family)
    index, rows = _identities(order, q, family)
    span = Span()
    rank = sum(span.add(dict(enumerate(row))) for row in rows)
    preferred = [t for t in map(parse_tree, _PREFERRED) if t.order == order and t in family]
    chosen: list[Tree] = []
    for t in dict.fromkeys([*preferred, *classes(order, q, family)]):
        reduced, _ = reduce_tree(t, q)
        if rank < len(index) and span.add({index[reduced]: 1}):
            chosen.append(t)
            rank += 1
    return tuple(chosen)
