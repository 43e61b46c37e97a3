"""Order conditions of symmetric G-symplectic pairs: the few that are needed, and why.

The starting series are zeta (for q, on trees with root f) and zeta^ (for p, on trees with root k),
with values e_1 at the empty tree and principal parts zeta_1. A pair in the sweep form
(:mod:`.partitioned_sweep`) with V = 1 + V_2, V^ = 1 + V^_2, G = 1 + G_2 (block diagonal) gives, for
a tree t with root f (and the same with the roles exchanged for a root k)

    xi_Q(t) = A etaD(t) + U zeta(t)      (M zeta)(t) = B etaD(t) + V zeta(t)

where etaD(t) is the product, stage by stage, of xi_P over the subtrees of t. Components 2..r of
zeta(t) are defined by ``(M zeta - E zeta)_k(t) = 0``; what is left is ``R(t) = (M zeta - E
zeta)_1(t)``. The pair has order p when R = 0 on all trees of order <= p for some principal parts.

**Theorem 1 (moving the root).** For t with root f and u with root k write t*u for t with u attached
to its root, u*t likewise, and ``Q(t, u) = zeta(t)^T G zeta^(u) - zeta_1(t*u) - zeta_1(u*t)``. If R
= 0 below order n = |t| + |u| and Q = 0 for all pairs of total order below n, then ``R(t*u) + R(u*t)
= 0``. Proof: inserting the definitions and the three identities gives ``(M zeta)(t)^T G
(M zeta^)(u) - zeta(t)^T G zeta^(u) = b^T etaD(t*u) + c^T etaD(u*t)``; indeed the mixed term is
``etaD(t)^T (B^T G B^) etaD(u)`` with ``B^T G B^ = D_P A^ + A^T D_Q``, and the others are ``D_P U^``
and ``D_Q U``. Subtract ``(E zeta)_1 - zeta_1`` on both sides: as ``E(t*u) + E(u*t) = E(t) E(u)``
for the exact flow, the left side becomes ``(E Q)(t, u) - Q(t, u)``, a combination of Q on pruned
pairs, of lower total order. So one rooted tree is enough for each free two-coloured tree.

**Theorem 2 (principal parts).** Q = 0 can always be achieved: given zeta_1 at one rooted version of
every free tree, ``zeta_1(u*t) = zeta(t)^T G zeta^(u) - zeta_1(t*u)`` carries it to the others. The
versions and their moves form a tree, so no equation is left over. All principal parts are zero
(no finishing method: the first values are the solution) exactly where ``zeta(t)^T G zeta^(u) = 0``
for all pairs below the order.

**Theorem 3 (symmetry).** Let the pair be symmetric with L e_1 = e_1, L^ e_1 = e_1 and L^T G L^ = G,
and choose zeta_1 = 0 at odd trees. If R = 0 below order n, then zeta(t) = (-1)^|t| L zeta(t)
through order n, and R(t) = 0 for |t| = n even. Proof: as for one method
(:mod:`glmref.prove.equations`); L and L^ act on the two halves.

So a symmetric pair of this form has even order p as soon as R vanishes at one rooted version of
each free tree of the odd orders below p: 2 + 2 + 6 trees for order 6 in place of all 74, and 22
more for order 8. With r = r^ = 1, where the pair is a product of flows, :mod:`.pair_trees` says
which of these suffice.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import factorial
from typing import Any

from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..theory.trees import Tree, pruned
from .partitioned_trees import free_tree, listed, moves

__all__ = ["PairNumbers", "PairSeries", "pair_series"]


@dataclass(frozen=True, eq=False)
class PairNumbers:
    """The sweep form of a pair over any scalar: see :mod:`.partitioned_sweep`."""

    b: Sequence[Any]
    X: Matrix
    c: Sequence[Any]
    Y: Matrix
    V: Matrix
    V_hat: Matrix
    G: Matrix
    word: Sequence[tuple[str, int]]


@dataclass(frozen=True, eq=False)
class PairSeries:
    """Starting series by tree (root f: of q, root k: of p) and residuals R."""

    zeta: Mapping[Tree, tuple[Any, ...]]
    residual: Mapping[Tree, Any]


class _Half:
    """What a root colour means: which stages it reads, which values it updates."""

    def __init__(self, pair: PairNumbers, colour: str) -> None:
        T = linalg.transpose
        of_q = colour == "f"
        self.letter = "P" if of_q else "Q"  # the stages where the root is evaluated
        self.weights = pair.b if of_q else pair.c
        self.columns = T(pair.X if of_q else pair.Y)  # updates of the values
        self.V = pair.V if of_q else pair.V_hat
        self.resolvent = _resolvent(self.V)
        # what the stages of the other half read of these values: y^T G^T q, or x^T G p
        self.readers = (
            T(linalg.matmul(pair.G, pair.Y)) if of_q else linalg.matmul(T(pair.X), pair.G)
        )


def _resolvent(V: Matrix) -> Matrix:
    """Inverse of 1 - V on the values 2..r."""
    r = range(1, len(V))
    rest = tuple(tuple((1 if i == j else 0) - V[i][j] for j in r) for i in r)
    return linalg.inverse(rest) if rest else ()


def pair_series(
    pair: PairNumbers,
    order: int,
    principal: Mapping[Tree, Any] | None = None,
    *,
    identity: bool = False,
    nystrom: bool = False,
    wanted: Sequence[Tree] | None = None,
    starts: bool = False,
) -> PairSeries:
    """Compute the starting series and the residuals R tree by tree.

    Args:
        pair: the numbers of a pair in the sweep form.
        order: residuals are computed for trees up to this order.
        principal: zeta_1 at one version of even free trees; zero at those that are missing.
        identity: whether every principal part is zero, whatever theorem 2 would give.
        nystrom: whether only the trees that count on second-order systems are taken.
        wanted: residuals of these trees only at the orders where none below them is needed.
        starts: whether zeta is computed at the trees of the last order too.
    """
    halves = {colour: _Half(pair, colour) for colour in "fk"}
    given = dict(principal or {})
    zeta: dict[Tree, tuple[Any, ...]] = {}
    stages: dict[Tree, tuple[Any, ...]] = {}  # xi(t) at the stages of the other half
    residual: dict[Tree, Any] = {}
    zero = Exact(0)
    for n in range(1, order + 1):
        last = n == order
        level = listed(n, nystrom=nystrom)
        if last and wanted is not None:
            level = tuple(t for t in wanted if t.order == n)
        first: Mapping[Tree, Any] = {}
        if not last and not identity and n % 2 == 0:
            first = _principal_parts(level, given, zeta, pair.G)
        for t in level:
            half = halves[t.colour]
            slopes = _slopes(t, stages, len(half.weights))
            right = _outputs(half, slopes)
            for kept, ways in pruned(t).items():
                if kept is not t:
                    weight = Fraction(ways, factorial(t.order - kept.order))
                    right = tuple(
                        x if y.is_zero() is True else x - y * weight
                        for x, y in zip(right, zeta[kept], strict=True)
                    )
            residual[t] = right[0] - Fraction(1, t.density)
            if not last or starts:
                above = linalg.matvec(half.resolvent, right[1:]) if len(right) > 1 else ()
                zeta[t] = (first.get(t, zero), *above)
                stages[t] = _swept(half, pair.word, slopes, zeta[t])
    if wanted is not None:
        residual = {t: residual[t] for t in wanted}
    return PairSeries(zeta, residual)


def _slopes(t: Tree, stages: Mapping[Tree, tuple[Any, ...]], size: int) -> tuple[Any, ...]:
    """EtaD(t): stage by stage the product over the subtrees."""
    result: tuple[Any, ...] = (Exact(1),) * size
    for child in t.children:
        result = tuple(x * y for x, y in zip(result, stages[child], strict=True))
    return result


def _outputs(half: _Half, slopes: Sequence[Any]) -> tuple[Any, ...]:
    """``B etaD(t)``."""
    total: list[Any] = [Exact(0)] * len(half.V)
    for weight, column, slope in zip(half.weights, half.columns, slopes, strict=True):
        update = weight * slope
        total = [x + update * y for x, y in zip(total, column, strict=True)]
    return tuple(total)


def _swept(
    half: _Half, word: Sequence[tuple[str, int]], slopes: Sequence[Any], start: Sequence[Any]
) -> tuple[Any, ...]:
    """``A etaD(t) + U zeta(t)`` by one sweep through the stages."""
    values = list(linalg.matvec(half.V, tuple(start)))
    found: list[Any] = []
    for letter, i in word:
        if letter == half.letter:
            update = half.weights[i] * slopes[i]
            values = [x + update * y for x, y in zip(values, half.columns[i], strict=True)]
        else:
            found.append(linalg.dot(half.readers[i], values))
    return tuple(found)


def _principal_parts(
    level: Sequence[Tree],
    given: Mapping[Tree, Any],
    zeta: Mapping[Tree, tuple[Any, ...]],
    G: Matrix,
) -> dict[Tree, Any]:
    """zeta_1 at the trees of an even order: Q = 0 along every move of the root."""
    found: dict[Tree, Any] = {}
    for t in level:
        if t in found:
            continue
        versions = free_tree(t)
        root = next((x for x in versions if x in given), versions[0])
        found[root] = given.get(root, Exact(0))
        waiting = [root]
        while waiting:
            version = waiting.pop()
            for rest, branch, other in moves(version):
                if other not in found:
                    q, p = (rest, branch) if rest.colour == "f" else (branch, rest)
                    form = linalg.dot(zeta[q], linalg.matvec(G, zeta[p]))
                    found[other] = form - found[version]
                    waiting.append(other)
    return found
