"""All rooted trees of a palette of colours, numbered: the kernel's own list, which nobody hands in.

A tree is a number. Trees of smaller order have smaller numbers, and the children of a tree are
kept in ascending order, so that every multiset of children is one tuple and every tree is listed
once: a tree with a largest child ``last`` is a smaller tree ``rest``, without a child above
``last``, with ``last`` added.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 301-304, 383.
"""

from __future__ import annotations

from functools import cache
from math import comb, factorial

#: Colours with the colours their children may have.
Palette = tuple[tuple[str, str], ...]


class _Cuts(dict[int, dict[int, int]]):
    """Cuts by tree, found when they are asked for: a method that carries one value needs none."""

    def __init__(self, trees: Forest) -> None:
        super().__init__()
        self._trees = trees

    def __missing__(self, t: int) -> dict[int, int]:
        found = self[t] = self._trees.pruned(t)
        return found


class Forest:
    """Trees of one palette, listed order by order as they are asked for.

    Attributes
    ----------
    colour, children, order, density
        Of each tree, by its number. ``density`` is gamma.
    text
        Of each tree: ``o``, ``[o[oo]]``, ``f[kk]``.
    cuts
        Of each tree, ``{kept: N}``: the number N of ways to grow the tree from ``kept`` (the same
        root, branches cut off) leaf by leaf. ``N / (|t| - |kept|)!`` is the sum, over the ways to
        cut, of 1 over the product of gamma of the branches.
    """

    def __init__(self, palette: Palette) -> None:
        self.palette = dict(palette)
        self.colour: list[str] = []
        self.children: list[tuple[int, ...]] = []
        self.order: list[int] = []
        self.density: list[int] = []
        self.text: list[str] = []
        self.cuts = _Cuts(self)
        self.levels: list[tuple[int, ...]] = [()]
        self._number: dict[tuple[str, tuple[int, ...]], int] = {}

    def level(self, n: int) -> tuple[int, ...]:
        """Every tree of order n."""
        while len(self.levels) <= n:
            self._extend(len(self.levels))
        return self.levels[n]

    def tree(self, colour: str, children: tuple[int, ...]) -> int:
        """Number of the tree with this root and these children, in any order."""
        return self._number[colour, tuple(sorted(children))]

    def _extend(self, n: int) -> None:
        first = len(self.order)
        for colour, allowed in self.palette.items():
            if n == 1:
                self._add(colour, ())
            for size in range(1, n):
                rests = [t for t in self.levels[n - size] if self.colour[t] == colour]
                for last in self.levels[size]:
                    if self.colour[last] in allowed:
                        for rest in rests:
                            below = self.children[rest]
                            if not below or below[-1] <= last:
                                self._add(colour, (*below, last))
        self.levels.append(tuple(range(first, len(self.order))))

    def _add(self, colour: str, children: tuple[int, ...]) -> None:
        order = 1 + sum(self.order[c] for c in children)
        density = order
        for c in children:
            density *= self.density[c]
        inside = "".join(self.text[c] for c in children)
        head = "" if colour == "o" else colour
        self._number[colour, children] = len(self.order)
        self.colour.append(colour)
        self.children.append(children)
        self.order.append(order)
        self.density.append(density)
        self.text.append(f"{head}[{inside}]" if children else colour)

    def pruned(self, t: int) -> dict[int, int]:
        """What is left of a tree when branches are cut off, with the number of ways."""
        if not self.children[t]:
            return {t: 1}
        colour, last = self.colour[t], self.children[t][-1]
        rest = self._number[colour, self.children[t][:-1]]
        away = factorial(self.order[last]) // self.density[last]
        found: dict[int, int] = {}
        for kept, ways in self.cuts[rest].items():
            gone = self.order[rest] - self.order[kept]
            for inner, more in ((None, away), *self.cuts[last].items()):
                removed = gone + self.order[last]
                whole = kept
                if inner is not None:
                    removed -= self.order[inner]
                    whole = self.tree(colour, (*self.children[kept], inner))
                found[whole] = found.get(whole, 0) + ways * more * comb(removed, gone)
        return found


class Paths(Forest):
    """The trees without branches: for each order and each colour of the root one or none."""

    def _extend(self, n: int) -> None:
        first = len(self.order)
        for colour, allowed in self.palette.items():
            if n == 1:
                self._add(colour, ())
            for below in self.levels[n - 1]:
                if self.colour[below] in allowed:
                    self._add(colour, (below,))
        self.levels.append(tuple(range(first, len(self.order))))


@cache
def forest(palette: Palette) -> Forest:
    """Return the trees of a palette, shared by all who ask."""
    return Forest(palette)


@cache
def paths(palette: Palette) -> Paths:
    """Return the trees without branches of a palette, shared by all who ask."""
    return Paths(palette)
