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

from ..errors import UsageError
from ..method.component import ROOTED, Palette
from .coefficients import Coefficient, is_zero, plus, times
from .trees import Tree, trees_up_to


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
