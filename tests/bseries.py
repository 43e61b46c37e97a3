"""The algebra of B-series and P-series: what proofs of the package are compared with.

The kernel compares coefficients tree by tree and composes nothing. Here series are composed, turned
round and shifted along the flow, by cutting trees in all ways (Hairer, Lubich, Wanner 2006, section
III.1.4; Butcher 2016, sections 383-386).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from functools import cache
from math import factorial
from typing import Any

from glmref.errors import UsageError
from glmref.method import Method
from glmref.method.component import ROOTED, Palette
from glmref.method.stage_order import reached
from glmref.theory.coefficients import Coefficient, is_zero, plus, times, weighted
from glmref.theory.series import Series
from glmref.theory.trees import Tree, pruned, tree, trees, trees_up_to

__all__ = [
    "Series",
    "combine",
    "compose",
    "coproduct",
    "derivative",
    "elementary_weights",
    "flow",
    "identity",
    "inverse",
    "is_zero",
    "shift",
    "values_series",
]


@cache
def coproduct(t: Tree) -> tuple[tuple[Tree, tuple[Tree, ...], int], ...]:
    """Cut ``t`` in all ways that keep its root: triples (kept, removed, multiplicity).

    The removed trees are sorted. The first triple is ``(t, (), 1)``; the term in which nothing is
    kept is not among them.

    References
    ----------
    Hairer, Lubich, Wanner (2006), section III.1.4; Butcher (2016), section 383.
    """
    if not t.children:
        return ((t, (), 1),)
    last = t.children[-1]
    rest = tree(t.children[:-1], t.colour)
    found: dict[tuple[Tree, tuple[Tree, ...]], int] = {}
    for kept_rest, removed_rest, ways in coproduct(rest):
        for kept_last, removed_last, more in ((None, (last,), 1), *coproduct(last)):
            kept = tree((*kept_rest.children, kept_last), t.colour) if kept_last else kept_rest
            removed = tuple(sorted((*removed_rest, *removed_last), key=lambda x: x.key))
            found[kept, removed] = found.get((kept, removed), 0) + ways * more
    ranked = sorted(found.items(), key=lambda item: (-item[0][0].order, item[0][0].key))
    return tuple((kept, removed, ways) for (kept, removed), ways in ranked)


def pointwise(a: Coefficient, b: Coefficient) -> Coefficient:
    """Product of two coefficients of one kind, vectors component by component."""
    if isinstance(a, tuple):
        return tuple(times(x, y) for x, y in zip(a, b, strict=True))
    return times(a, b)


def _minus(a: Coefficient, b: Coefficient) -> Coefficient:
    return plus(a, times(-1, b))


def identity(order: int, palette: Palette = ROOTED) -> Series:
    """Return the series of the identity map."""
    return Series({}, 1, order, palette)


def flow(order: int, time: Any = 1, palette: Palette = ROOTED) -> Series:
    """Return the series of the exact flow after ``time * h``: ``time^|t| / gamma(t)``."""
    powers: list[Any] = [1]
    for _ in range(order):
        powers.append(times(time, powers[-1]))
    values = {
        t: times(Fraction(1, t.density), powers[t.order]) for t in trees_up_to(order, palette)
    }
    return Series(values, 1, order, palette)


def _check_pair(first: Series, second: Series) -> int:
    if dict(first.palette) != dict(second.palette):
        raise UsageError("series over different palettes cannot be composed")
    if any(
        isinstance(x, tuple) or is_zero(_minus(x, 1)) is not True for x in first._empty.values()
    ):
        raise UsageError("the series applied first must be scalar, with empty coefficient 1")
    return min(first.order, second.order)


def compose(first: Series, second: Series) -> Series:
    """Return the series of: apply ``first``, then ``second``.

    ``(first second)(t) = second(empty) first(t) + sum second(kept) * product of first(removed)``
    over all cuts of t that keep the root. ``second`` may be vector-valued.

    Raises
    ------
    UsageError
        When ``first`` is not scalar with empty coefficient 1.

    References
    ----------
    Butcher (2016), section 383; Hairer, Lubich, Wanner (2006), theorem III.1.10.
    """
    order = _check_pair(first, second)
    values: dict[Tree, Coefficient] = {}
    for t in trees_up_to(order, first.palette):
        total = times(first[t], second.empty(t.colour))
        for kept, removed, multiplicity in coproduct(t):
            factor = _product(first, removed, multiplicity)
            total = plus(total, times(factor, second[kept]))
        values[t] = total
    return Series(values, second._empty, order, first.palette)


def _product(series: Series, removed: Iterable[Tree], start: int) -> Any:
    result: Any = start
    for t in removed:
        result = times(result, series[t])
    return result


def inverse(series: Series) -> Series:
    """Return the series b with ``compose(series, b)`` and ``compose(b, series)`` the identity.

    Raises
    ------
    UsageError
        When ``series`` is not scalar with empty coefficient 1.
    """
    order = _check_pair(series, series)
    values: dict[Tree, Any] = {}
    for t in trees_up_to(order, series.palette):
        total = series[t]
        for kept, removed, multiplicity in coproduct(t):
            if removed:
                factor = _product(series, removed, multiplicity)
                total = plus(total, times(factor, values[kept]))
        values[t] = times(-1, total)
    return Series(values, 1, order, series.palette)


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


def shift(series: Series, time: Any = 1) -> Series:
    """Return ``E^time series``: follow the exact flow for ``time * h``, then apply the series.

    The same as ``compose(flow(order, time), series)``, by counting growth orders instead of cuts
    (see :func:`~glmref.theory.trees.pruned`).
    """
    values: dict[Tree, Coefficient] = {}
    powers: list[Any] = [1]
    for _ in range(series.order):
        powers.append(times(time, powers[-1]))
    known = series.support()
    for t in trees_up_to(series.order, series.palette):
        by_size = grown(t, known)
        total = times(times(Fraction(1, t.density), powers[t.order]), series.empty(t.colour))
        for removed, part in by_size.items():
            weight = times(Fraction(1, factorial(removed)), powers[removed])
            total = plus(total, times(weight, part))
        values[t] = total
    return Series(values, series._empty, series.order, series.palette)


def grown(t: Tree, known: Mapping[Tree, Coefficient]) -> dict[int, Coefficient]:
    """Sum ``N(t, s) known[s]`` over the pruned subtrees s of t, by the number of removed vertices.

    Sums of one size share a denominator, which is left to the caller; trees that are missing in
    ``known`` count as zero.
    """
    sums: dict[int, Coefficient] = {}
    for kept, ways in pruned(t).items():
        value = known.get(kept)
        if value is None:
            continue
        removed = t.order - kept.order
        term = times(ways, value)
        sums[removed] = plus(sums[removed], term) if removed in sums else term
    return sums


def combine(terms: Sequence[tuple[Any, Series]]) -> Series:
    """Return the linear combination ``sum of factor * series``, truncated to the shortest.

    Raises
    ------
    UsageError
        Without terms.
    """
    if not terms:
        raise UsageError("a linear combination needs at least one series")
    order = min(series.order for _, series in terms)
    palette = terms[0][1].palette
    values: dict[Tree, Coefficient] = {}
    for t in trees_up_to(order, palette):
        total: Coefficient = times(0, terms[0][1][t])
        for factor, series in terms:
            total = plus(total, times(factor, series[t]))
        values[t] = total
    empty: dict[str, Coefficient] = {}
    for colour in palette:
        total = times(0, terms[0][1].empty(colour))
        for factor, series in terms:
            total = plus(total, times(factor, series.empty(colour)))
        empty[colour] = total
    return Series(values, empty, order, palette)


def elementary_weights(
    A: Sequence[Sequence[Any]],
    B: Sequence[Any],
    order: int,
    *,
    u: Coefficient = 1,
) -> Series:
    """Return the series of ``Y = y + h A f(Y)``, ``x = u y + h B f(Y)``."""
    outputs = B if isinstance(u, tuple) else (B,)
    rows, weights = _needed([_nonzero(row) for row in A], [_nonzero(row) for row in outputs])
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
                stages[t] = tuple([weighted(row, slopes) for row in rows[t.colour]])
            values[t] = tuple([weighted(row, slopes) for row in outputs[t.colour]])
    return values


#: The entries of a row that are not certainly zero, with their columns.
_Sparse = list[tuple[int, Any]]


def _nonzero(row: Sequence[Any]) -> _Sparse:
    return [(j, x) for j, x in enumerate(row) if is_zero(x) is not True]


def _needed(rows: list[_Sparse], weights: list[_Sparse]) -> tuple[list[_Sparse], list[_Sparse]]:
    """Leave out the stages on which no weight depends."""
    found = reached({j for row in weights for j, _ in row}, lambda i: {j for j, _ in rows[i]})
    place = {j: k for k, j in enumerate(sorted(found))}
    kept = [[(place[j], x) for j, x in rows[i]] for i in place]
    return kept, [[(place[j], x) for j, x in row] for row in weights]
