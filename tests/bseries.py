"""B-series of methods by their definition, for comparison with what the package proves.

The kernel compares coefficients tree by tree. Here weights are computed from the tableau by another
recursion, and series are composed with :mod:`glmref.theory.series`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any

from glmref.method import Method
from glmref.method.component import ROOTED, Palette
from glmref.theory.coefficients import Coefficient, combination, first_nonzero, is_zero, plus, times
from glmref.theory.series import Series
from glmref.theory.starting_series import StartingSeries
from glmref.theory.trees import Tree, trees, trees_up_to


def order_residuals(method: Method, order: int, *, free: bool = False) -> dict[Tree, Any]:
    """Return the residuals of all conditions through an order but those that are used up."""
    series, found = StartingSeries.of(method, free=free), {}
    for _ in range(order):
        level = series.advance()
        found |= {t: first_nonzero(series.residual(t)) for t in level if t not in series.determined}
    return found


def pointwise(a: Coefficient, b: Coefficient) -> Coefficient:
    """Product of two coefficients of one kind, vectors component by component."""
    if isinstance(a, tuple):
        return tuple(times(x, y) for x, y in zip(a, b, strict=True))
    return times(a, b)


def derivative(series: Series) -> Series:
    """Return the series of ``h f(series(y))``: 1 at a single node, else the product over children.

    ``series`` must have the empty coefficient 1 (in every component). Products of vectors are taken
    component by component, so a vector of stages gives the vector of stage derivatives.
    """
    values: dict[Tree, Coefficient] = {}
    one = {colour: _ones(x) for colour, x in series._empty.items()}
    for t in trees_up_to(series.order, series.palette):
        total = one[next(iter(series.palette[t.colour]))]
        for child in t.children:
            total = pointwise(total, series[child])
        values[t] = total
    empty = {colour: times(0, x) for colour, x in series._empty.items()}
    return Series(values, empty, series.order, series.palette)


def _ones(like: Coefficient) -> Coefficient:
    return tuple(1 for _ in like) if isinstance(like, tuple) else 1


def combine(terms: Sequence[tuple[Any, Series]]) -> Series:
    """Return the linear combination ``sum of factor * series``, truncated to the shortest."""
    first = terms[0][1]

    def total(coefficient: Callable[[Series], Coefficient]) -> Coefficient:
        return reduce(plus, (times(factor, coefficient(series)) for factor, series in terms))

    order = min(series.order for _, series in terms)
    values = {t: total(lambda x, t=t: x[t]) for t in trees_up_to(order, first.palette)}
    empty = {c: total(lambda x, c=c: x.empty(c)) for c in first.palette}
    return Series(values, empty, order, first.palette)


def elementary_weights(
    A: Sequence[Sequence[Any]], B: Sequence[Any], order: int, *, u: Coefficient = 1
) -> Series:
    """Return the series of ``Y = y + h A f(Y)``, ``x = u y + h B f(Y)``."""
    outputs = B if isinstance(u, tuple) else (B,)
    rows, weights = ([_nonzero(row) for row in M] for M in (A, outputs))
    values = _weights({"o": rows}, {"o": weights}, order, ROOTED)
    return Series(
        values if isinstance(u, tuple) else {t: x for t, (x,) in values.items()}, u, order
    )


def values_series(method: Method, order: int, palette: Palette | None = None) -> Series:
    """Return the series of the values that a starting or finishing method makes."""
    palette = method.palette if palette is None else palette
    rows = {c.colour: [_nonzero(row) for row in c.A] for c in method.components}
    outputs = {c.colour: [_nonzero(row) for row in c.B] for c in method.components}
    empty = {c.colour: tuple(row[0] for row in c.V) for c in method.components}
    return Series(_weights(rows, outputs, order, palette), empty, order, palette)


def _weights(
    rows: Mapping[str, list[_Sparse]], outputs: Mapping[str, list[_Sparse]],
    order: int, palette: Palette,
) -> dict[Tree, tuple[Any, ...]]:  # fmt: skip
    """Series of ``h B f(Y)``, ``Y = y + h A f(Y)`` by tree, over any palette."""
    stages: dict[Tree, tuple[Any, ...]] = {}
    values: dict[Tree, tuple[Any, ...]] = {}
    ones = {colour: tuple(1 for _ in rows[seen[0]]) for colour, seen in palette.items()}
    for n in range(1, order + 1):
        for t in trees(n, palette):
            slopes = ones[t.colour] if not t.children else stages[t.children[0]]
            for child in t.children[1:]:
                slopes = pointwise(slopes, stages[child])
            if n < order:
                stages[t] = tuple([_sum(row, slopes) for row in rows[t.colour]])
            values[t] = tuple([_sum(row, slopes) for row in outputs[t.colour]])
    return values


#: The entries of a row that are not certainly zero, with their columns.
_Sparse = list[tuple[int, Any]]


def _nonzero(row: Sequence[Any]) -> _Sparse:
    return [(j, x) for j, x in enumerate(row) if is_zero(x) is not True]


def _sum(row: _Sparse, x: Sequence[Any]) -> Any:
    return combination([(factor, x[j]) for j, factor in row])
