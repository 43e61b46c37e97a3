"""B-series and P-series as mappings from trees to coefficients.

Public names::

    Series(values, empty, order, palette=ROOTED)     mapping Tree -> Coefficient, truncated
    identity(order, palette=ROOTED) -> Series        the map that does nothing
    flow(order, time=1, palette=ROOTED) -> Series    exact flow of ``time * h``: time^|t| / gamma
    compose(first, second) -> Series                 ``first`` is applied first, then ``second``
    inverse(series) -> Series                        of a scalar series with empty coefficient 1
    derivative(series) -> Series                     coefficients of h f(series(y))
    shift(series, time=1) -> Series                  compose(flow(time), series), much faster
    elementary_weights(A, B, order, u=1, ...)        series of Y = y + h A f(Y), x = u y + h B f(Y)
    values_series(start, order, palette) -> Series  of a starting or finishing method
    combine(terms) -> Series                         linear combination of series
    is_zero(coefficient)                             True, False or None (undecided), any type

A series with coefficients a stands for ``a(empty) y + sum of a(t) h^|t| / sigma(t) F(t)(y)``. A
coefficient is a number (int, Fraction or any Scalar) or a tuple of numbers: a vector-valued series
describes r values at once. Over a two-coloured palette the trees with root ``f`` describe the
q-component, those with root ``k`` the p-component: a P-series is one Series.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 383-386.
Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), sections III.1.4 and III.2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from fractions import Fraction
from math import factorial
from typing import Any

from ..errors import UsageError
from ..method import Method
from ..method.stage_order import reached
from .coefficients import Coefficient, is_zero, plus, pointwise, times, weighted
from .trees import ROOTED, Palette, Tree, coproduct, pruned, trees, trees_up_to

__all__ = [
    "Coefficient",
    "Series",
    "combine",
    "compose",
    "derivative",
    "elementary_weights",
    "flow",
    "identity",
    "inverse",
    "is_zero",
    "shift",
    "values_series",
]


class Series(Mapping[Tree, Coefficient]):
    """A truncated B-series or P-series.

    Parameters
    ----------
    values : Mapping[Tree, Coefficient]
        Coefficients by tree; trees that are missing have the coefficient zero.
    empty : Coefficient or Mapping[str, Coefficient]
        Coefficient of the empty tree: one coefficient, or one for every root colour.
    order : int
        Largest order of a tree that has a coefficient.
    palette : Palette
        Colours of the trees.

    Raises
    ------
    UsageError
        For a tree of another palette or of too high an order.
    """

    __slots__ = ("_empty", "_values", "order", "palette")

    def __init__(
        self,
        values: Mapping[Tree, Coefficient],
        empty: Coefficient | Mapping[str, Coefficient],
        order: int,
        palette: Palette = ROOTED,
    ) -> None:
        for t in values:
            if t.order > order or t.colour not in palette:
                raise UsageError(
                    f"a series of order {order} over the colours {', '.join(palette)} "
                    f"has no coefficient for the tree {t}"
                )
        self.order, self.palette = order, palette
        self._values = dict(values)
        each = empty if isinstance(empty, Mapping) else dict.fromkeys(palette, empty)
        self._empty: dict[str, Coefficient] = dict(each)

    def empty(self, colour: str | None = None) -> Coefficient:
        """Coefficient of the empty tree, for the component of the given root colour."""
        return self._empty[next(iter(self.palette)) if colour is None else colour]

    def __getitem__(self, t: Tree) -> Coefficient:
        found = self._values.get(t)
        if found is not None:
            return found
        if not isinstance(t, Tree) or t.order > self.order or t.colour not in self.palette:
            raise KeyError(t)
        return times(0, self._empty[t.colour])

    def __iter__(self) -> Iterator[Tree]:
        return iter(trees_up_to(self.order, self.palette))

    def __len__(self) -> int:
        return len(trees_up_to(self.order, self.palette))

    def __eq__(self, other: object) -> bool:
        """Whether all coefficients are equal; balls are equal only where that is certain."""
        if not isinstance(other, Series) or dict(self.palette) != dict(other.palette):
            return NotImplemented
        return (
            self.order == other.order
            and all(is_zero(_minus(x, other._empty[c])) is True for c, x in self._empty.items())
            and all(is_zero(_minus(self[t], other[t])) is True for t in self)
        )

    __hash__ = None  # type: ignore[assignment]  # as for the numbers inside

    def __repr__(self) -> str:
        return f"<Series of order {self.order} over {''.join(self.palette)}: {len(self)} trees>"

    def truncate(self, order: int) -> Series:
        """Return the same series without trees of higher order."""
        kept = {t: x for t, x in self._values.items() if t.order <= order}
        return Series(kept, self._empty, min(order, self.order), self.palette)

    def map(self, function: Callable[[Coefficient], Coefficient]) -> Series:
        """Return the series with a linear function applied to every coefficient."""
        values = {t: function(x) for t, x in self._values.items()}
        empty = {colour: function(x) for colour, x in self._empty.items()}
        return Series(values, empty, self.order, self.palette)

    def support(self) -> dict[Tree, Coefficient]:
        """Return the coefficients that are not certainly zero."""
        return {t: x for t, x in self._values.items() if is_zero(x) is not True}


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
    """Return the series of ``Y = y + h A f(Y)``, ``x = u y + h B f(Y)``.

    Parameters
    ----------
    A : Sequence[Sequence[Any]]
        (m, m) stages; m may be 0.
    B : Sequence[Any]
        (m,) weights of one value, or (r, m) weights of r values.
    order : int
        Largest order of a tree.
    u : Coefficient
        Multiple of y: a number for one value, a tuple of r numbers for r values.

    Returns
    -------
    Series
        A scalar series, or a vector-valued one when ``u`` is a tuple.
    """
    outputs = B if isinstance(u, tuple) else (B,)
    rows, weights = _needed([_nonzero(row) for row in A], [_nonzero(row) for row in outputs])
    values = _weights({"o": rows}, {"o": weights}, order, ROOTED)
    return Series(
        values if isinstance(u, tuple) else {t: x for t, (x,) in values.items()}, u, order
    )


def values_series(method: Method, order: int, palette: Palette | None = None) -> Series:
    """Return the series of the values that a starting or finishing method makes.

    Parameters
    ----------
    method : Method
        A start or a finish.
    order : int
        Largest order of a tree.
    palette : Palette or None
        Colours below each vertex, those of the method that is started; by default its own.

    Returns
    -------
    Series
        Vectors with one entry for each value; the component of a tree is that of its root.
    """
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
