"""Order of a pair of general linear methods: starting series over two-coloured trees.

Public names::

    pair_order_of(pair, *, max_order=10, principal="free") -> OrderResult
    pair_residuals(pair, order, *, principal="identity") -> dict[Tree, Scalar]
    parasitic_curvature(pair) -> Scalar

For ``q' = f(q, p)``, ``p' = k(q, p)`` a tree with root ``f`` belongs to q, one with root ``k`` to
p; for a separable pair (f depends on p, k on q) colours alternate along every edge. The pair has
order p when there is a pair of starting series with ``M S = S E + O(h^(p+1))``; conditions and
proof of completeness are those of one method: see :mod:`glmref.theory.conditions`.

With ``principal="free"`` symplectic Euler has order 2 on separable systems, being conjugate to
Stormer-Verlet there.

**The oscillator near w = -1.** With V and V^ of eigenvalues 1 and -1 the step of a pair on q' = p,
p' = -q is a matrix M(y), y = h, with w = -1 twice at y = 0. For a symmetric G-symplectic pair the
eigenvalues come as z, 1/z: ``det(w - M) = w^2 (s^2 - t s + u - 2)`` with s = w + 1/w, t = tr M and
u the sum of the principal minors of order two. So ``2 + 2 t + u = det(1 + M) = e(y)`` and, near
s = -2, ``(s + 2)(4 + t) = e(y) + O((s + 2)^2)`` with t(0) = 0. Without growth to first order e
begins with y^6, and ``s = -2 + kappa y^6 + ..``, kappa = e_6 / 4: the parasitic eigenvalues stay on
the unit circle for small y if kappa > 0, and leave it at once, ``|w| - 1 = sqrt(-kappa) y^3``, if
kappa < 0. Growth parameters that are zero say nothing about the sign.

References
----------
Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), section III.2.
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 389, 535.
"""

from __future__ import annotations

from ..errors import UsageError
from ..exact import Exact, Scalar
from ..method import PartitionedGLM
from ..method.solution_value import Component, halves
from .blocks import NotPreconsistent, block_of
from .order import OrderResult, Principal, decide, residuals_of
from .stability import axis_polynomial
from .trees import GENERAL, SEPARABLE, Palette, Tree

__all__ = ["pair_order_of", "pair_residuals", "parasitic_curvature"]


def _parts(pair: PartitionedGLM) -> tuple[list[tuple[str, Component]], Palette]:
    """The two blocks by root colour, and the colours children may have.

    The stages Q are those of the method for q, and a tree with root f takes slopes f(P): where the
    two stage sets differ this is what alternating colours mean.
    """
    return list(zip("fk", halves(pair), strict=True)), SEPARABLE if pair.separable else GENERAL


def pair_order_of(
    pair: PartitionedGLM, *, max_order: int = 10, principal: Principal = "free"
) -> OrderResult:
    """Decide the order of a pair, over all trees its systems have.

    Args:
        pair: a separable pair is checked on trees whose colours alternate, any other on all
            two-coloured trees.
        max_order: largest order looked at.
        principal: ``"free"``, or ``"identity"`` where the outputs of q and of p must be the
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
        blocks = {colour: block_of(m) for colour, m in methods}
    except NotPreconsistent as reason:
        raise UsageError(f"the pair {pair.name!r} is not preconsistent: {reason}") from None
    return residuals_of(blocks, palette, order, principal)


def parasitic_curvature(pair: PartitionedGLM) -> Scalar:
    """Return kappa of the module docstring: its sign says whether oscillations stay bounded.

    Args:
        pair: explicit, r = r^ = 2, V and V^ with the eigenvalues 1 and -1.

    Raises
    ------
        UsageError: for another pair, or one that grows already in the first order.
    """
    if pair.r != 2 or pair.r_hat != 2:
        raise UsageError(f"the pair {pair.name!r} must carry two values of q and two of p")
    by_power = axis_polynomial(pair)
    total: list[Scalar] = [Exact(0)] * max(map(len, by_power))
    for k, coefficients in enumerate(by_power):
        for j, x in enumerate(coefficients):
            total[j] = total[j] + (x if k % 2 == 0 else -x)
    if len(by_power) != 5 or (by_power[4][0] - 1).is_zero() is False or len(by_power[4]) > 1:
        raise UsageError(f"the pair {pair.name!r} must be explicit")
    low = (*total[:6], sum((row[0] for row in by_power if row), Exact(0)))
    if any(x.is_zero() is False for x in low):
        raise UsageError(f"the pair {pair.name!r} has other eigenvalues than 1 and -1, or grows")
    return total[6] / 4 if len(total) > 6 else Exact(0)
