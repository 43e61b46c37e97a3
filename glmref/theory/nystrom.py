"""Order of a pair on second-order systems q' = M^-1 p, p' = k(q): fewer trees count.

Where f is linear its second derivative is zero, and with it the elementary differential of every
tree in which a vertex f has two children or more. What is left is a set of trees that contains,
with a tree, all its subtrees and all trees left when branches are cut off: the conditions of these
trees are a system of their own, in which the others do not occur. A pair whose outputs are the
solution itself has order p on such systems when the residuals of these trees vanish through p.

Symplectic Runge-Kutta-Nyström methods in the form of splittings of p^2/2 + V(q) are the case r = 1.

Public names::

    is_nystrom(tree) -> bool                  nystrom_trees(order) -> tuple of trees
    nystrom_order_of(pair, *, max_order=9) -> OrderResult

References
----------
    Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), sections II.2.3 and III.2.3;
    Blanes and Moan, J. Comput. Appl. Math. 142 (2002), 313-330.
"""

from __future__ import annotations

from functools import cache

from ..errors import ExactnessError
from ..exact import Scalar
from ..findings import Proof
from ..method import PartitionedGLM
from ..method.solution_value import halves
from .blocks import NotPreconsistent, as_scalar, block_of, is_enclosed
from .coefficients import is_zero
from .conditions import Conditions
from .order import OrderResult
from .series import Series
from .trees import SEPARABLE, Tree, trees

__all__ = ["is_nystrom", "nystrom_order_of", "nystrom_trees"]


@cache
def is_nystrom(t: Tree) -> bool:
    """Whether no vertex f of the tree has two children or more."""
    if t.colour == "f" and len(t.children) > 1:
        return False
    return all(map(is_nystrom, t.children))


def nystrom_trees(order: int) -> tuple[Tree, ...]:
    """Trees of an order with alternating colours that count where f is linear."""
    return tuple(t for t in trees(order, SEPARABLE) if is_nystrom(t))


def nystrom_order_of(pair: PartitionedGLM, *, max_order: int = 9) -> OrderResult:
    """Decide the order of a pair on systems q' = M^-1 p, p' = k(q).

    The outputs are taken as the solution itself (no finishing method).

    Returns
    -------
        As :func:`~glmref.theory.order.order_of`, the starting series on the trees that count only;
        order 0 where the pair is not preconsistent or the two halves share their stages.
    """
    q, p = halves(pair)
    proof = Proof.ENCLOSED if is_enclosed(q) or is_enclosed(p) else Proof.EXACT
    if not pair.separable:
        return OrderResult(0, "identity", proof=proof, reason="the stages are shared")
    try:
        blocks = {"f": block_of(q), "k": block_of(p)}
    except (NotPreconsistent, ExactnessError) as reason:
        return OrderResult(0, "identity", proof=proof, reason=f"not preconsistent: {reason}")
    conditions = Conditions(blocks, SEPARABLE, "identity")
    largest, undecided = 0.0, []
    for n in range(1, max_order + 1):
        level = {t: _one(x) for t, x in conditions.advance().items() if is_nystrom(t)}
        failing = next((t for t, x in level.items() if is_zero(x) is False), None)
        if failing is not None:
            return OrderResult(
                n - 1,
                "identity",
                failing_tree=failing,
                residual=level[failing],
                residuals=level,
                proof=proof,
                largest_residual=largest,
                undecided=tuple(undecided),
                eta=_starting_series(conditions, n - 1),
                multiplicity=max(len(b.N) for b in blocks.values()),
            )
        undecided += [t for t, x in level.items() if is_zero(x) is None]
        largest = max([largest, *(x.magnitude() for x in level.values() if is_zero(x) is None)])
    return OrderResult(
        max_order,
        "identity",
        proof=proof,
        largest_residual=largest,
        undecided=tuple(undecided),
        eta=_starting_series(conditions, max_order),
        at_least=True,
    )


def _starting_series(conditions: Conditions, order: int) -> Series | None:
    """The starting series on the trees that count; zero on all others."""
    if not order:
        return None
    values = {t: x for t, x in conditions.eta.items() if t.order <= order and is_nystrom(t)}
    empty = {colour: block.u for colour, block in conditions.blocks.items()}
    return Series({t: tuple(map(as_scalar, x)) for t, x in values.items()}, empty, order, SEPARABLE)


def _one(residual: tuple[object, ...]) -> Scalar:
    """The residual of a tree as one number: the first entry that is not certainly zero."""
    return as_scalar(next((x for x in residual if is_zero(x) is not True), 0))
