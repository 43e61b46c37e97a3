"""Order of a pair on second-order systems q' = M^-1 p, p' = k(q) or k(q, p): fewer trees count.

Where f is linear its second derivative is zero, and with it the elementary differential of every
tree in which a vertex f has two children or more. What is left is a set of trees that contains,
with a tree, all its subtrees and all trees left when branches are cut off: the conditions of these
trees are a system of their own, in which the others do not occur. A pair whose outputs are the
solution itself has order p on such systems when the residuals of these trees vanish through p.

Symplectic Runge-Kutta-Nyström methods in the form of splittings of p^2/2 + V(q) are the case r = 1.

References
----------
    Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), sections II.2.3 and III.2.3;
    Blanes and Moan, J. Comput. Appl. Math. 142 (2002), 313-330.
"""

from __future__ import annotations

from functools import cache

from ..method import Method
from .order import OrderResult, order_of
from .trees import Tree


@cache
def is_nystrom(t: Tree) -> bool:
    """Whether no vertex f of the tree has two children or more, or a child f: q' is linear in p."""
    if t.colour == "f" and (len(t.children) > 1 or any(x.colour == "f" for x in t.children)):
        return False
    return all(map(is_nystrom, t.children))


def nystrom_order_of(pair: Method, *, max_order: int = 9) -> OrderResult:
    """Decide the order of a pair on systems q' = M^-1 p, p' = k(q).

    The outputs are taken as the solution itself (no finishing method).

    Returns
    -------
    OrderResult
        As :func:`~glmref.theory.order.order_of`, the starting series on the trees that count only;
        order 0 where the pair is not preconsistent.
    """
    return order_of(pair, max_order=max_order, principal="identity", counts=is_nystrom)
