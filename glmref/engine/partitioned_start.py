"""The start of a pair from the tableau of its file.

    Q = q0 + h A f(P)      q_k = u_k q0 + h B_k f(P)
    P = p0 + h A^ k(Q)     p_k = u^_k p0 + h B^_k k(Q)

The stages are taken in their explicit order, f and k each only where a stage is due, and stages
that nothing reads are left out. On a problem that is not separable stage i is the point (Q_i, P_i)
and one evaluation gives f and k.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import UsageError
from ..exact import exact
from ..exact.linalg import Matrix, Vector
from ..method import PairStartingMethod, PartitionedGLM
from ..method.stage_order import pair_blocks, reached
from .outcome import StartFailed
from .reference import PairStepper

__all__ = ["apply_pair_start", "explicit_order", "used_stages"]


def used_stages(start: PairStartingMethod, *, joint: bool = False) -> tuple[list[int], list[int]]:
    """Numbers of the stages Q and P that some starting value reads, directly or through others.

    Where nothing reads any stage of a kind, the first one is kept.

    Args:
        joint: whether stage i is (Q_i, P_i), evaluated together; their numbers must agree.
    """
    n = len(start.A)  # stage P_i has the number n + i, or i where it goes with Q_i

    def read(row: Vector, shift: int) -> list[int]:
        return [j + shift for j, x in enumerate(row) if x.is_zero() is not True]

    if joint:
        first = {j for row in (*start.B, *start.B_hat) for j in read(row, 0)}
        both = reached(first, lambda i: read(start.A[i], 0) + read(start.A_hat[i], 0))
        return sorted(both or {0}), sorted(both or {0})
    first = {j for row in start.B_hat for j in read(row, 0)}
    first |= {j for row in start.B for j in read(row, n)}
    used = reached(first, lambda i: read(start.A[i], n) if i < n else read(start.A_hat[i - n], 0))
    of_q, of_p = {i for i in used if i < n}, {i - n for i in used if i >= n}
    return sorted(of_q or {0}), sorted(of_p or {0})


def _chosen(rows: Matrix, columns: list[int], among: list[int] | None = None) -> Matrix:
    kept = rows if among is None else tuple(rows[i] for i in among)
    return tuple(tuple(row[j] for j in columns) for row in kept)


def _as_pair(start: PairStartingMethod, pair: PartitionedGLM, *, joint: bool) -> PartitionedGLM:
    """The used stages as a pair that carries one value of each kind and does not change it."""
    one, zero = exact(1), exact(0)
    of_q, of_p = used_stages(start, joint=joint)
    return PartitionedGLM(
        A=_chosen(start.A, of_p, of_q),
        U=((one,),) * len(of_q),
        B=((zero,) * len(of_p),),
        V=((one,),),
        A_hat=_chosen(start.A_hat, of_q, of_p),
        U_hat=((one,),) * len(of_p),
        B_hat=((zero,) * len(of_q),),
        V_hat=((one,),),
        separable=pair.separable or not joint,
    )


def apply_pair_start(
    start: PairStartingMethod, engine: PairStepper, t: Any, y0: np.ndarray, h: Any
) -> tuple[np.ndarray, int, int]:
    """Starting values and what they cost.

    Returns
    -------
        values (max(r, r^), d); evaluations of k (of the whole right-hand side where the problem is
        not separable); evaluations of f (0 there).

    Raises
    ------
        UsageError: for a start that gives other numbers of values than the pair carries.
        StartFailed: when implicit stages cannot be solved.
    """
    pair, m, joint = engine.pair, engine.half, not engine.problem.separable
    if (len(start.u), len(start.u_hat)) != (pair.r, pair.r_hat):
        raise UsageError(
            f"the starting method gives {len(start.u)} and {len(start.u_hat)} values, the pair "
            f"carries {pair.r} and {pair.r_hat}"
        )
    _, inner = engine.tableaux.get(id(start.A), (start.A, None))
    if inner is None:  # rounding a tableau of decimals costs more than a step: done once
        inner = engine.with_method(_as_pair(start, pair, joint=joint))
        engine.tableaux[id(start.A)] = start.A, inner
    taken = inner.step(t, y0[None, :], h)
    if not taken.converged:
        raise StartFailed("the stages of a starting method could not be solved; use a smaller h")
    of_q, of_p = used_stages(start, joint=joint)
    values = engine.arithmetic.zeros(engine.shape)
    f, k = taken.slopes
    for columns, u, B, used, slopes in (
        (slice(0, m), start.u, start.B, of_p, f),
        (slice(m, 2 * m), start.u_hat, start.B_hat, of_q, k),
    ):
        weights = engine.arithmetic.array(_chosen(B, used))
        multiples = engine.arithmetic.array((u,))[0]
        found = np.outer(multiples, y0[columns]) + weights.dot(slopes) * h
        values[: len(found), columns] = found
    return values, taken.evaluations, taken.velocity_evaluations


def explicit_order(start: PairStartingMethod, pair: PartitionedGLM) -> list[tuple[str, int]] | None:
    """Stages in an order in which each needs earlier ones only, on separable problems.

    Returns
    -------
        ("Q", j), ("P", i) by their numbers in the start; ``None`` where there is no such order.
    """
    of_q, of_p = used_stages(start)
    order: list[tuple[str, int]] = []
    for block in pair_blocks(_as_pair(start, pair, joint=False)):
        if block.implicit:
            return None
        (node,) = block.stages
        is_q = node < len(of_q)
        order.append(("Q", of_q[node]) if is_q else ("P", of_p[node - len(of_q)]))
    return order
