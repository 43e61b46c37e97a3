"""Series of Runge-Kutta-like tableaux over any scalar, with what parity and stage order save."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from ..exact import Exact, linalg
from ..exact.linalg import Matrix
from ..theory.trees import Tree
from .classes import classes, reduce_tree

__all__ = ["outputs", "slopes", "stage_order", "weights"]


def weights(
    A: Matrix,
    rows: Matrix,
    order: int,
    base: Mapping[Tree, Any] | None = None,
    *,
    parity: bool = False,
    q: int = 1,
) -> list[Mapping[Tree, Any]]:
    """Series of ``h sum rows_kj f(Y_j)`` with ``Y_i = S + h sum A_ij f(Y_j)``.

    Args:
        A, order, base, parity, q: see :func:`slopes`. rows: (k, m).

    Returns
    -------
        For each row the map tree -> coefficient.
    """
    return outputs(rows, slopes(A, order, base, parity=parity, q=q))


def outputs(rows: Matrix, derivatives: Mapping[Tree, Sequence[Any]]) -> list[Mapping[Tree, Any]]:
    """For each row the sums ``sum rows_kj F_j``, by tree."""
    return [{t: linalg.dot(row, x) for t, x in derivatives.items()} for row in rows]


def slopes(
    A: Matrix,
    order: int,
    base: Mapping[Tree, Any] | None = None,
    *,
    parity: bool = False,
    q: int = 1,
) -> dict[Tree, tuple[Any, ...]]:
    """Series of ``h f(Y_j)`` with ``Y_i = S + h sum A_ij f(Y_j)``: m numbers for each tree.

    Args:
        A: (m, m). order: last order.
        base: series of S, where it is not the identity.
        parity: whether A and the base are known to have parity: the series of every second stage
            is then that of its partner at -h.
        q: known stage order, where S is the identity: the series at classes of trees only.
    """
    eta: dict[Tree, tuple[Any, ...]] = {}
    found: dict[Tree, tuple[Any, ...]] = {}
    computed = [i for i in range(len(A)) if not parity or i == 0 or i % 2]
    for n in range(1, order + 1):
        for t in classes(n, q):
            found[t] = derivative = _product(t, eta, len(A), q)
            if n < order:
                shift = base[t] if base is not None else Exact(0)
                stages: dict[int, Any] = {}
                for i in computed:
                    stages[i] = linalg.dot(A[i], derivative) + shift
                    if parity and i:
                        stages[i + 1] = stages[i] if n % 2 == 0 else -stages[i]
                eta[t] = tuple(stages[i] for i in range(len(A)))
    return found


def _product(t: Tree, eta: Mapping[Tree, tuple[Any, ...]], m: int, q: int) -> tuple[Any, ...]:
    """Stage by stage the product of eta over the subtrees."""
    result: tuple[Any, ...] | None = None
    for child in t.children:
        below, factor = reduce_tree(child, q)
        values = eta[below] if factor == 1 else tuple(x * factor for x in eta[below])
        if result is None:
            result = values
        else:
            result = tuple(x * y for x, y in zip(result, values, strict=True))
    return (Exact(1),) * m if result is None else result


def stage_order(A: Matrix, *, most: int) -> int:
    """Largest q <= ``most`` with ``A c^(k-1) = c^k / k`` exactly for k = 2..q, c = A 1."""
    ones = (Exact(1),) * len(A)
    c = linalg.matvec(A, ones)
    power, q = c, 1
    while q < most:
        below = linalg.matvec(A, power)
        power = tuple(x * y for x, y in zip(power, c, strict=True))
        gaps = (x * (q + 1) - y for x, y in zip(below, power, strict=True))
        if any(x.is_zero() is not True for x in gaps):
            break
        q += 1
    return q
