"""In which order stages can be computed, which of them are coupled, and which are needed at all.

Stage i needs stage j where its sum has a term ``h a_ij f(Y_j)``. Everything here follows from that
relation between numbers: nothing depends on how the stages are numbered.

Public names::

    dependency_blocks(size, needs) -> tuple of StageBlock(stages, implicit), in a possible order
    stage_blocks(A)                                       of one method
    pair_blocks(pair, joint=False)                        of a pair
    is_acyclic(size, needs) -> bool                       no stage needs an equation solved
    reached(first, needs) -> set of numbers               everything the first ones need
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from ..exact.linalg import Matrix

if TYPE_CHECKING:  # a method asks this module for its implicit stages
    from .glm import PartitionedGLM

__all__ = [
    "StageBlock",
    "dependency_blocks",
    "is_acyclic",
    "pair_blocks",
    "reached",
    "stage_blocks",
]

#: ``needs(i, j)``: whether number i is computed from number j.
Needs = Callable[[int, int], bool]


@dataclass(frozen=True)
class StageBlock:
    """Stages that are computed together.

    Attributes
    ----------
        stages: stage numbers from 0, in order.
        implicit: whether an equation has to be solved for them.
    """

    stages: tuple[int, ...]
    implicit: bool


def reached(first: Iterable[int], needs: Callable[[int], Iterable[int]]) -> set[int]:
    """Numbers that are needed for the first ones, directly or through others; these included.

    Parameters
    ----------
    first : where to begin.
    needs : ``needs(i)`` lists the numbers that i is computed from.
    """
    found = set(first)
    waiting = list(found)
    while waiting:
        new = set(needs(waiting.pop())) - found
        found |= new
        waiting += new
    return found


def dependency_blocks(size: int, needs: Needs) -> tuple[StageBlock, ...]:
    """Order ``size`` unknowns so that each needs only earlier ones; cycles become one block.

    Returns
    -------
        The strongly connected components in a topological order; among those possible the one
        that follows the numbering.
    """
    direct = [[j for j in range(size) if needs(i, j)] for i in range(size)]
    reach = [reached(direct[i], direct.__getitem__) for i in range(size)]
    waiting = list(range(size))
    blocks: list[StageBlock] = []
    while waiting:
        for i in waiting:
            together = [j for j in waiting if j == i or (j in reach[i] and i in reach[j])]
            if all(j in together or j not in waiting for j in reach[i]):
                blocks.append(StageBlock(tuple(together), i in reach[i]))
                waiting = [j for j in waiting if j not in together]
                break
    return tuple(blocks)


def is_acyclic(size: int, needs: Needs) -> bool:
    """Whether the unknowns have an order in which each needs earlier ones only."""
    return not any(block.implicit for block in dependency_blocks(size, needs))


def stage_blocks(A: Matrix) -> tuple[StageBlock, ...]:
    """Order the stages of a GLM: explicit ones, diagonally implicit ones, coupled blocks.

    Parameters
    ----------
    A : (s, s); the pattern of its exact zeros decides.
    """
    return dependency_blocks(len(A), lambda i, j: A[i][j].is_zero() is not True)


def pair_blocks(pair: PartitionedGLM, *, joint: bool = False) -> tuple[StageBlock, ...]:
    """Order the stages of a pair.

    Parameters
    ----------
    joint : whether stage i is (Q_i, P_i), as on a problem that is not separable.

    Returns
    -------
        Blocks of numbers: Q stages 0..n_Q-1, then P stages n_Q..n_Q+n_P-1 (joint: stages 0..s-1).
    """
    n_q, n_p = pair.n_Q, pair.n_P

    def zero(matrix: Matrix, i: int, j: int) -> bool:
        return matrix[i][j].is_zero() is True

    if joint:
        return dependency_blocks(
            n_q, lambda i, j: not (zero(pair.A, i, j) and zero(pair.A_hat, i, j))
        )

    def needs(i: int, j: int) -> bool:
        if i < n_q <= j:
            return not zero(pair.A, i, j - n_q)
        if j < n_q <= i:
            return not zero(pair.A_hat, i - n_q, j)
        return False

    return dependency_blocks(n_q + n_p, needs)
