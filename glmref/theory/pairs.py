"""Order of a pair of general linear methods: starting series over two-coloured trees.

Public names::

    pair_order_of(pair, *, max_order=10, principal="free") -> OrderResult
    pair_residuals(pair, order, *, principal="identity") -> dict[Tree, Scalar]

For ``q' = f(q, p)``, ``p' = k(q, p)`` a tree with root ``f`` belongs to q, one with root ``k`` to
p; for a separable pair (f depends on p, k on q) colours alternate along every edge. The pair has
order p when there is a pair of starting series with ``M S = S E + O(h^(p+1))``; conditions and
proof of completeness are those of one method: see :mod:`glmref.theory.conditions`.

With ``principal="free"`` symplectic Euler has order 2 on separable systems, being conjugate to
Stormer-Verlet there.

References
----------
Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), section III.2.
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 389, 535.
"""

from __future__ import annotations

from typing import Any

from ..claims import UsageError
from ..exact import Scalar
from ..method import PartitionedGLM
from .blocks import NotPreconsistent, make_block
from .order import OrderResult, Principal, decide, residuals_of
from .trees import GENERAL, SEPARABLE, Palette, Tree

__all__ = ["pair_order_of", "pair_residuals"]


def _parts(pair: PartitionedGLM) -> tuple[list[tuple[str, tuple[Any, Any, Any, Any]]], Palette]:
    """The two blocks by root colour, and the colours children may have.

    The stages Q are those of the method for q, and a tree with root f takes slopes f(P): where the
    two stage sets differ this is what alternating colours mean.
    """
    blocks = [
        ("f", (pair.A, pair.U, pair.B, pair.V)),
        ("k", (pair.A_hat, pair.U_hat, pair.B_hat, pair.V_hat)),
    ]
    return blocks, SEPARABLE if pair.separable else GENERAL


def pair_order_of(
    pair: PartitionedGLM, *, max_order: int = 10, principal: Principal = "free"
) -> OrderResult:
    """Decide the order of a pair, over all trees its systems have.

    Args:
        pair: a separable pair is checked on trees whose colours alternate, any other on all
            two-coloured trees.
        max_order: largest order looked at.
        principal: ``"free"``, or ``"identity"`` where the first values of q and of p must be the
            solution itself.

    Returns
    -------
        As :func:`~glmref.theory.order.order_of`; trees with root ``f`` belong to q, those with root
        ``k`` to p. The principal parts at the single nodes are normalised to zero for q.

    Raises
    ------
        UsageError: for another ``principal`` or a ``max_order`` for which trees are not listed.
    """
    blocks, palette = _parts(pair)
    return decide(blocks, palette, max_order, principal)


def pair_residuals(
    pair: PartitionedGLM, order: int, *, principal: Principal = "identity"
) -> dict[Tree, Scalar]:
    """Return the residuals of all conditions through the given order, decided or not.

    Raises
    ------
        UsageError: when one of the methods has no u with V u = u and U u = 1.
    """
    methods, palette = _parts(pair)
    try:
        blocks = {colour: make_block(*entries) for colour, entries in methods}
    except NotPreconsistent as reason:
        raise UsageError(f"the pair {pair.name!r} is not preconsistent: {reason}") from None
    return residuals_of(blocks, palette, order, principal)
