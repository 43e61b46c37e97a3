"""In which order stages can be computed, which of them are coupled, and which are needed at all.

Stage i needs stage j where its sum has a term ``h a_ij f(Y_j)``. Everything here follows from that
relation between numbers: nothing depends on how the stages are numbered.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from ..exact import Scalar
from ..exact.linalg import nonzero
from .component import Component

#: ``needs(i, j)``: whether number i is computed from number j.
Needs = Callable[[int, int], bool]


@dataclass(frozen=True)
class StageBlock:
    """Stages that are computed together."""

    stages: tuple[int, ...]  #: Stage numbers from 0, in order.
    implicit: bool  #: Whether an equation has to be solved for them.


def reached(first: Iterable[int], needs: Callable[[int], Iterable[int]]) -> set[int]:
    """Return numbers that are needed for the first ones, directly or through others.

    The first ones are included.

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
    tuple[StageBlock, ...]
        The strongly connected components in a topological order; among those possible the one that
        follows the numbering.
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


def is_shared(palette: Mapping[str, str]) -> bool:
    """Return whether every right-hand side is evaluated at the stages of all components."""
    return all(len(seen) == len(palette) for seen in palette.values())


def offsets(components: Sequence[Component], palette: Mapping[str, str]) -> dict[str, int]:
    """Return the first stage of each component, by colour; 0 where stages are shared."""
    found, at = {}, 0
    for c in components:
        found[c.colour] = at
        at += 0 if is_shared(palette) else len(c.A)
    return found


def stage_blocks(
    components: Sequence[Component], palette: Mapping[str, str]
) -> tuple[StageBlock, ...]:
    """Order the stages of a method: explicit ones, diagonally implicit ones, coupled blocks.

    Parameters
    ----------
    components : their A; the pattern of exact zeros decides.
    palette : at the stages of which components each right-hand side is evaluated.

    Returns
    -------
    tuple[StageBlock, ...]
        Blocks of numbers: the stages of the components one after another, or, where all right-hand
        sides are evaluated at the same stages, the numbers of these.
    """
    table = _needs(components, palette)
    return dependency_blocks(len(table), lambda i, j: j in table[i])


def read_stages(components: Sequence[Component], palette: Mapping[str, str]) -> frozenset[int]:
    """Return stages that some value reads, directly or through others.

    They are numbered as in :meth:`stage_blocks`.
    """
    table, first = _needs(components, palette), offsets(components, palette)
    ends = {j for c in components for row in c.B for j in _sources(c, row, palette, first)}
    return frozenset(reached(ends, table.__getitem__))


def _needs(components: Sequence[Component], palette: Mapping[str, str]) -> dict[int, set[int]]:
    """Return what each stage is computed from: stages by number."""
    first = offsets(components, palette)
    table: dict[int, set[int]] = {}
    for c in components:
        for i, row in enumerate(c.A):
            table.setdefault(first[c.colour] + i, set()).update(_sources(c, row, palette, first))
    return table


def _sources(
    c: Component, row: Sequence[Scalar], palette: Mapping[str, str], first: Mapping[str, int]
) -> set[int]:
    """Return stages whose slopes a row of A or B sums."""
    used = [j for j, _ in nonzero(row)]
    return {first[d] + j for d in palette[c.colour] for j in used}
