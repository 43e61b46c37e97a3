"""Permutations of stages that respect given matrices, found by backtracking."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..exact import Ball, Scalar
from ..exact.linalg import Matrix
from ..system.budget import spend


@dataclass(frozen=True, eq=False)
class Relation:
    """Ask for ``A[i][j] + A[P i][P j] = target[i][j]``, in a common numbering of all stages."""

    #: (n, m).
    A: Matrix
    target: Matrix
    #: Number of the first row and column.
    row_offset: int
    column_offset: int


def _may_vanish(exact_value: Scalar) -> bool:
    return exact_value.is_zero() is not False


def _balls(a: Matrix) -> list[list[Ball]]:
    return [[x.ball() for x in row] for row in a]


class _Checked:
    """A relation with its entries enclosed, so that most mismatches cost one ball operation."""

    def __init__(self, relation: Relation) -> None:
        self.relation = relation
        self.A, self.target = _balls(relation.A), _balls(relation.target)
        self.known: dict[tuple[int, int, int, int], bool] = {}

    def fits(self, i: int, j: int, k: int, m: int) -> bool:
        """Return whether ``A[i][j] + A[k][m] - target[i][j]`` is zero or may be."""
        key = (i, j, k, m)
        if key not in self.known:
            near = (self.A[i][j] + self.A[k][m] - self.target[i][j]).contains_zero()
            A, target = self.relation.A, self.relation.target
            self.known[key] = near and _may_vanish(A[i][j] + A[k][m] - target[i][j])
        return self.known[key]

    def consistent(self, order: Sequence[int], new: Sequence[int]) -> bool:
        """Return whether the relation holds wherever the newly placed stages take part."""
        rows, columns = len(self.A), len(self.A[0])
        a, b = self.relation.row_offset, self.relation.column_offset
        placed = [i for i, k in enumerate(order) if k >= 0]
        for i in placed:
            for j in placed if i in new else new:
                if not (a <= i < a + rows and b <= j < b + columns):
                    continue
                if not self.fits(i - a, j - b, order[i] - a, order[j] - b):
                    return False
        return True


def involutions(relations: Sequence[Relation], kinds: Sequence[int]) -> Iterator[tuple[int, ...]]:
    """Yield involutive permutations P under which all relations hold or may hold.

    Parameters
    ----------
    relations : Sequence[Relation]
        The matrices to respect.
    kinds : Sequence[int]
        For each stage a label; only stages of the same kind are exchanged.

    Yields
    ------
    tuple[int, ...]
        Permutations as tuples, from 0. The exchange with the mirror image among the stages of the
        same kind is tried first at every place.
    """
    checked = [_Checked(r) for r in relations]
    mirror, sequence = _mirror(kinds), _interleaved(kinds)
    order = [-1] * len(kinds)

    def place(at: int) -> Iterator[tuple[int, ...]]:
        while at < len(order) and order[sequence[at]] >= 0:
            at += 1
        if at == len(order):
            yield tuple(order)
            return
        i = sequence[at]
        free = [k for k in sequence[at:] if order[k] < 0 and kinds[k] == kinds[i]]
        free.sort(key=lambda k: k != mirror[i])
        for k in free:
            spend()
            order[i], order[k] = k, i
            if all(c.consistent(order, (i, k)) for c in checked):
                yield from place(at + 1)
            order[i] = order[k] = -1

    return place(0)


def _groups(kinds: Sequence[int]) -> list[list[int]]:
    places: dict[int, list[int]] = {}
    for i, kind in enumerate(kinds):
        places.setdefault(kind, []).append(i)
    return list(places.values())


def _interleaved(kinds: Sequence[int]) -> list[int]:
    """Return stages of the different kinds in turn: relations between kinds then prune early."""
    share = {i: n / len(group) for group in _groups(kinds) for n, i in enumerate(group)}
    return sorted(range(len(kinds)), key=share.__getitem__)


def _mirror(kinds: Sequence[int]) -> list[int]:
    result = [0] * len(kinds)
    for group in _groups(kinds):
        for i, k in zip(group, reversed(group), strict=True):
            result[i] = k
    return result
