"""Series of Runge-Kutta-like tableaux over any scalar, with what parity and stage order save."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from operator import add, sub
from typing import Any

from ..exact import Exact, sum_of_products
from ..exact.judging import as_numbers, fast_judge
from ..exact.linalg import Matrix
from ..theory.trees import Tree
from .classes import classes, reduce_tree

#: The entries of a row that are not exact zeros, with their columns.
_Row = list[tuple[int, Any]]


class TableauSeries:
    """Series of ``h f(Y_j)``, ``Y_i = S + h sum A_ij f(Y_j)``, tree by tree where it is requested.

    With *parity* stage 0 is even in h and h -> -h exchanges stages 1 and 2, 3 and 4, ..; series of
    one stage of each pair are enough then, as ``h f`` at the other is the same at trees of odd
    order and the opposite at trees of even order.

    Parameters
    ----------
    A : Mapping[str, Matrix]
        By the colour of the root of a tree, (stages where its value is read, stages where its
        right-hand side is evaluated).
    base : Mapping[Tree, Any] or None
        Series of S, where it is not the identity.
    parity : bool
        Whether A and the base are known to have parity.
    q : int
        Known stage order, where S is the identity: trees are replaced by their classes.
    """

    def __init__(
        self,
        A: Mapping[str, Matrix],
        base: Mapping[Tree, Any] | None = None,
        *,
        parity: bool = False,
        q: int = 1,
    ) -> None:
        self._A, self._base, self._parity, self._q = A, base, parity, q
        self._rows: dict[tuple[str, int], list[_Row]] = {}
        self._last: tuple[Any, dict[int, list[_Row]]] = (None, {})
        self._stages: dict[Tree, tuple[Any, ...]] = {}
        self._slopes: dict[Tree, tuple[Any, ...]] = {}

    def outputs(self, rows: Matrix, t: Tree) -> list[Any]:
        """Return for each row the sum ``sum row_j h f(Y_j)`` at a tree."""
        if self._last[0] is not rows:
            self._last = rows, {}
        known, odd = self._last[1], t.order % 2
        if odd not in known:
            known[odd] = self._folded(rows, t)
        slopes = self._slope(t)
        return [_dot(row, slopes) for row in known[odd]]

    def _folded(self, rows: Sequence[Sequence[Any]], t: Tree) -> list[_Row]:
        """Return rows as they meet slopes at a tree, with parity of one stage of each pair."""
        if self._parity and t.order % 2:
            rows = [(row[0], *map(add, row[1::2], row[2::2])) for row in rows]
        elif self._parity:
            rows = [(Exact(0), *map(sub, row[1::2], row[2::2])) for row in rows]
        return [[(j, x) for j, x in enumerate(row) if not x.vanishes()] for row in rows]

    def _stage(self, t: Tree) -> tuple[Any, ...]:
        if t not in self._stages:
            key = t.colour, t.order % 2
            if key not in self._rows:
                rows = self._A[t.colour]
                self._rows[key] = self._folded([rows[0], *rows[1::2]] if self._parity else rows, t)
            slopes = self._slope(t)
            found = tuple(_dot(row, slopes) for row in self._rows[key])
            if self._base is not None:
                found = tuple(x + self._base[t] for x in found)
            self._stages[t] = found
        return self._stages[t]

    def _slope(self, t: Tree) -> tuple[Any, ...]:
        """Return stage by stage the product of the stages over the subtrees."""
        if t not in self._slopes:
            result: tuple[Any, ...] | None = None
            for child in t.children:
                below, factor = reduce_tree(child, self._q)
                values = self._stage(below)
                if factor != 1:
                    values = tuple(x * factor for x in values)
                if result is None:
                    result = values
                else:
                    result = tuple(x * y for x, y in zip(result, values, strict=True))
            columns = len(self._A[t.colour][0])
            size = (columns + 1) // 2 if self._parity else columns
            self._slopes[t] = (Exact(1),) * size if result is None else result
        return self._slopes[t]


def _dot(row: _Row, x: Sequence[Any]) -> Any:
    return sum_of_products([(factor, x[j]) for j, factor in row])


def weights(
    A: Matrix,
    rows: Matrix,
    order: int,
    base: Mapping[Tree, Any] | None = None,
    *,
    parity: bool = False,
    q: int = 1,
) -> list[Mapping[Tree, Any]]:
    """Return series of ``h sum rows_kj f(Y_j)`` of one component at the classes of trees.

    Parameters
    ----------
    A : Matrix
        (m, m).
    rows : Matrix
        (k, m).
    order : int
        Last order.
    base, parity, q
        See :class:`TableauSeries`.

    Returns
    -------
    list[Mapping[Tree, Any]]
        For each row the map tree -> coefficient.
    """
    series = TableauSeries({"o": A}, base, parity=parity, q=q)
    listed = [t for n in range(1, order + 1) for t in classes(n, q)]
    found = {t: series.outputs(rows, t) for t in listed}
    return [{t: x[k] for t, x in found.items()} for k in range(len(rows))]


def stage_order(A: Matrix, *, most: int) -> int:
    """Return largest q <= ``most`` with ``A c^(k-1) = c^k / k`` exactly for k = 2..q, c = A 1."""
    return int(fast_judge().parity.simplifies(as_numbers(A), most))
