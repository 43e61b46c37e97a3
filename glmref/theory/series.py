"""B-series and P-series as mappings from trees to coefficients.

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

from collections.abc import Callable, Iterator, Mapping
from fractions import Fraction
from functools import cache, partial
from math import factorial
from typing import Any

from ..errors import UsageError
from ..exact import Exact
from ..method.component import ROOTED, Palette
from ..method.model import Method
from ..method.stage_order import is_shared
from .coefficients import Coefficient, combination, is_zero, plus, times
from .starting_series import tableau_series
from .trees import (
    Tree,
    contractions,
    edge_cuts,
    single,
    trees,
    trees_up_to,
)


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

    Examples
    --------
    >>> import glmref
    >>> from glmref.theory.series import compose, flow, inverse, modified_equation
    >>> heun = glmref.Series.of(glmref.from_rk([[0, 0], [1, 0]], [0.5, 0.5]), 3)
    >>> heun[glmref.Tree("[o]")], heun[glmref.Tree("[oo]")]
    (Exact(1/2), Exact(1/2))
    >>> compose(heun, inverse(heun)) == compose(inverse(heun), heun) == flow(3, 0)
    True
    >>> modified_equation(heun)[glmref.Tree("[oo]")]
    Exact(1/6)
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
        self.order: int = order
        self.palette: Palette = palette
        self._values = dict(values)
        each = empty if isinstance(empty, Mapping) else dict.fromkeys(palette, empty)
        self._empty: dict[str, Coefficient] = dict(each)

    @classmethod
    def of(cls, method: Method, order: int) -> Series:
        """Return the series of a step, a start or a finish that takes in one value.

        Parameters
        ----------
        method : Method
            ``Y = U y + h A F``, values ``V y + h B F`` of one value y; U = 1.
        order : int
            Largest order of a tree.

        Returns
        -------
        Series
            Numbers where one value is made, else vectors.

        Raises
        ------
        UsageError
            When the method carries several values: see :class:`.starting_series.StartingSeries`.
        """
        table = {c.colour: (c.A, c.B, tuple(x for x, *_ in c.V)) for c in method.components}
        rows = [row for c in method.components for row in c.U]
        if any([(x - 1).is_zero() for x in row] != [True] for row in rows):
            raise UsageError("a series of a method needs one value taken in, with U = 1")
        levels = partial(trees, palette=method.palette)
        found: dict[Any, Coefficient] = dict(tableau_series(levels, table, order))
        if all(len(u) == 1 for _, _, u in table.values()):
            found = {t: x for t, (x,) in found.items()}
        empty = {colour: found.pop(colour) for colour in table}
        return cls(found, empty, order, method.palette)

    def empty(self, colour: str | None = None) -> Coefficient:
        """Return the coefficient of the empty tree, for the component of the given root colour."""
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
        """Return whether all coefficients are equal; balls are equal only where that is certain."""
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

    It is ``exp(d_b) second``, b the field whose flow is ``first``; ``second`` may be vector-valued.

    Raises
    ------
    UsageError
        When ``first`` is not scalar with empty coefficient 1.

    References
    ----------
    Butcher (2016), section 383; Hairer, Lubich, Wanner (2006), theorem III.1.10.
    """
    _check_pair(first, second)
    return exponential(_logarithm(first), second)


def inverse(series: Series) -> Series:
    """Return the series b with ``compose(series, b)`` and ``compose(b, series)`` the identity.

    Raises
    ------
    UsageError
        When ``series`` is not scalar with empty coefficient 1.
    """
    return exponential(_logarithm(series).map(partial(times, -1)))


def substitute(field: Series, series: Series) -> Series:
    """Return the series of a map in which the vector field is replaced by a series of its own.

    With ``h f~ = sum of b(t) h^|t| / sigma(t) F(t)``, b the ``field``, the B-series a of f~ is the
    B-series ``b * a`` of f: the sum over all ways to contract t of a(skeleton) times the product
    of b(part) over the parts.

    Raises
    ------
    UsageError
        For different palettes, or one with colours that may not stand below each other: the field
        of a separable system is not separable.

    References
    ----------
    Hairer, Lubich, Wanner (2006), theorem IX.9.3; Chartier, Hairer, Vilmart (2010), theorem 3.2.
    """
    order = _check_fields(field, series)
    values = {t: _contracted(t, field, series) for t in trees_up_to(order, series.palette)}
    return Series(values, series._empty, order, series.palette)


def _check_fields(first: Series, second: Series) -> int:
    if dict(first.palette) != dict(second.palette) or not is_shared(first.palette):
        raise UsageError("a field is substituted over one palette, all colours below each")
    return min(first.order, second.order)


def _contracted(t: Tree, field: Mapping[Tree, Any], series: Series, *, whole: bool = True) -> Any:
    """Return the sum of a(skeleton) times the b of the parts.

    Not ``whole``: at least one edge is cut.
    """
    total: Any = 0
    for (skeleton, part, others), ways in contractions(t).items():
        if whole or others:
            value = times(ways, series[skeleton])
            for s in (part, *others):
                value = times(field[s], value)
            total = plus(total, value)
    return total


def conjugated(field: Series, along: Series) -> Series:
    """Return a field in the coordinates that the flow of ``along`` for h changes.

    If the flow of ``field`` is the map Phi and that of ``along`` the map chi, it is the field of
    ``chi^-1 Phi chi``.
    """
    chi = exponential(along)
    return _logarithm(compose(compose(chi, exponential(field)), inverse(chi)))


class AfterFlow:
    """The series ``exp(d_b) a``: a after the flow of a field b for h, found tree by tree.

    Parameters
    ----------
    empty : Mapping[str, Coefficient]
        Coefficient of the empty tree of a, by colour.

    Attributes
    ----------
    field : dict[Tree, Any]
        The field as far as it is known; zeros are left out.

    No other cuts than those of single edges are needed (Hairer, Lubich, Wanner 2006, lemma
    III.5.1), and no iterated derivatives: with ``phi_m = sum of d_b^j a / (j + m)!``

        phi_m(t) = a(t)/m! + b(t) a(empty)/(m + 1)! + sum of b(part cut off) phi_(m+1)(rest)

    phi_0 at the trees of order n asks for phi_m at those of order n - m only. So most trees, which
    have the last order, cost one sum over their edges.
    """

    def __init__(self, empty: Mapping[str, Coefficient]) -> None:
        self.empty, self.field = empty, dict[Tree, Any]()
        self._series: dict[Tree, Coefficient] = {}
        self._phi: list[dict[Tree, Coefficient]] = []

    def beyond(self, t: Tree, m: int = 0) -> Coefficient:
        """Return the sum over the edges of t: of ``phi_0(t)`` what lower orders give."""
        if m + 1 >= len(self._phi):
            self._phi += [{} for _ in range(m + 2 - len(self._phi))]
        known, terms = self._phi[m + 1], []
        for (part, rest), ways in edge_cuts(t).items():
            factor = self.field.get(part)
            if factor is None:
                continue
            value = known.get(rest)
            if value is None:
                value = known[rest] = self._weighted(rest, m + 1)
            if type(value) is not int or value != 0:
                terms.append((times(ways, factor), value))
        return combination(terms)

    def _weighted(self, t: Tree, m: int) -> Coefficient:
        """Return phi_m(t)."""
        terms = [(_inverse_factorial(m), self._series[t]), (Exact(1), self.beyond(t, m))]
        if t in self.field:
            slope = times(_inverse_factorial(m + 1), self.field[t])
            terms.append((slope, self.empty[t.colour]))
        terms = [(x, y) for x, y in terms if type(y) is not int or y != 0]
        value = combination(terms)
        return 0 if is_zero(value) is True else value

    def settle(self, t: Tree, value: Coefficient, slope: Any) -> None:
        """Take in a(t) and b(t)."""
        if is_zero(slope) is not True:
            self.field[t] = slope
        self._series[t] = 0 if is_zero(value) is True else value


@cache
def _inverse_factorial(j: int) -> Exact:
    return Exact(Fraction(1, factorial(j)))


def exponential(field: Series, series: Series | None = None) -> Series:
    """Return the series: follow the flow of a field for h, then apply ``series``.

    Without ``series`` it is the map of the flow itself; :func:`modified_equation` is the inverse.

    Raises
    ------
    UsageError
        For different palettes.
    """
    series = identity(field.order, field.palette) if series is None else series
    order, values = _check_palettes(field, series), {}
    after = AfterFlow(series._empty)
    for t in trees_up_to(order, series.palette):
        values[t] = plus(series[t], times(field[t], series.empty(t.colour)))
        beyond = after.beyond(t)
        if type(beyond) is not int or beyond != 0:
            values[t] = plus(values[t], beyond)
        after.settle(t, series[t], field[t])
    return Series(values, series._empty, order, series.palette)


def _check_palettes(first: Series, second: Series) -> int:
    if dict(first.palette) != dict(second.palette):
        raise UsageError("series over different palettes cannot be combined")
    return min(first.order, second.order)


def modified_equation(series: Series, of: Series | None = None) -> Series:
    """Return the vector field f~ whose exact flow is the map of a series: backward error analysis.

    Parameters
    ----------
    series : Series
        Of a consistent one-step method, a(o) = 1.
    of : Series or None
        The map for f~ is that of this series in place of the exact flow; all colours of its
        palette stand below each. With the flow as
        ``series`` and the method as ``of``, f~ is the modifying integrator: the method applied to
        f~ gives the exact solution of f.

    Returns
    -------
    Series
        b with the empty coefficient 0 and ``substitute(b, of) = series``.

    Raises
    ------
    UsageError
        When a(o) of ``of`` is not 1, or as :func:`substitute`.

    References
    ----------
    Hairer, Lubich, Wanner (2006), section IX.9; Chartier, Hairer, Vilmart (2010), section 3.
    """
    if of is None:
        return _logarithm(series)
    if any(is_zero(_minus(of[single(c)], 1)) is not True for c in of.palette):
        raise UsageError("a modified equation needs a consistent method: a(o) = 1")
    order, values = _check_fields(series, of), {}
    for t in trees_up_to(order, series.palette):
        values[t] = _minus(series[t], _contracted(t, values, of, whole=False))
    return Series(values, 0, order, series.palette)


def _logarithm(series: Series) -> Series:
    order = _check_pair(series, series)
    after, values = AfterFlow(series._empty), {}
    for t in trees_up_to(order, series.palette):
        values[t] = _minus(series[t], after.beyond(t))
        after.settle(t, 0, values[t])
    return Series(values, 0, order, series.palette)
