"""Rooted trees in any number of colours.

The text form writes ``o`` for a single node and ``[...]`` for a root with the trees inside the
brackets as its subtrees: ``[o[oo]]``. Two-coloured trees write the colour of every vertex, ``f`` or
``k``, before its bracket: ``f[kk[f]]``. For ``q' = f(q, p)``, ``p' = k(q, p)`` a vertex ``f``
stands for f; its children ``f`` differentiate f by q, its children ``k`` by p. For a separable
system (f depends on p only, k on q only) colours alternate along every edge. The vertices of an
additive method have the numbers of its right-hand sides as colours, ``1[12]``. Other schemes of
coloured stages may use any letter.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), sections 301-304, 383.
Hairer, Lubich, Wanner, "Geometric Numerical Integration" (2006), sections III.1, III.2.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import factorial
from operator import attrgetter
from string import ascii_letters
from types import MappingProxyType
from typing import Any, NoReturn

from ..errors import ExactnessError, UsageError
from ..judge import trees as judged
from ..judge.refusals import Refused
from ..method.component import ROOTED, Palette

#: Largest order for which all trees are listed (32973 one-coloured trees have order 14).
MAX_ORDER = 14

#: Colours that occur together: of one method, of a partitioned one, of the parts of a sum.
_FAMILIES = ("o", "fk", "123456789")
#: The place of every colour in the order in which trees are sorted, and palettes stand.
_PLACES = {colour: k for k, colour in enumerate(ascii_letters + "123456789")}


class Tree:
    """A rooted tree, its vertices coloured ``o``, or ``f`` and ``k``, or ``1`` to ``9``.

    Trees are interned: two equal trees are the same object, so comparison and hashing cost nothing.

    Parameters
    ----------
    text : str
        Text form, for example ``"[o[oo]]"`` or ``"f[kk[f]]"``; see :func:`tree` for a root with
        given children and :func:`trees` for all trees of an order.

    Raises
    ------
    UsageError
        Naming the place that cannot be read.

    Examples
    --------
    >>> from glmref import Tree
    >>> t = Tree("[o[o]]")
    >>> t.order, t.density, t.symmetry
    (4, 8, 1)
    >>> str(t * Tree("o"))
    '[oo[o]]'
    """

    __slots__ = ("children", "colour", "density", "judged", "key", "order", "symmetry")
    colour: str  #: Colour of the root.
    children: tuple[Tree, ...]  #: Subtrees of the root, in ascending order (see :attr:`key`).
    order: int  #: Number of vertices, ``|t|``.
    density: int  #: ``gamma(t)``, the product over all vertices of the order of the subtree there.
    symmetry: int  #: ``sigma(t)``, the order of the automorphism group.
    #: Sort key: by order, then colour, then the largest children first.
    key: tuple[Any, ...]
    judged: judged.Tree  #: The tree as the judge has it: the colour, and the children in its order.

    def __new__(cls, text: str) -> Tree:
        """Return the one tree of a text form."""
        return parse_tree(text)

    def __mul__(self, other: Tree) -> Tree:
        """Return the Butcher product: this tree with ``other`` attached to its root."""
        return tree((*self.children, other), self.colour)

    def __setattr__(self, name: str, value: object) -> NoReturn:
        raise AttributeError(f"a Tree is immutable: `{name}` cannot be set")

    def __delattr__(self, name: str) -> NoReturn:
        raise AttributeError(f"a Tree is immutable: `{name}` cannot be deleted")

    @property
    def labellings(self) -> int:
        """``alpha(t) = |t|! / (sigma gamma)``: number of monotone labellings."""
        return factorial(self.order) // (self.symmetry * self.density)

    def __str__(self) -> str:
        if not self.children:
            return self.colour
        inside = "".join(map(str, self.children))
        return f"{'' if self.colour == 'o' else self.colour}[{inside}]"

    def __repr__(self) -> str:
        return f"Tree({str(self)!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return Tree, (str(self),)

    def __copy__(self) -> Tree:
        return self

    def __deepcopy__(self, memo: object) -> Tree:
        return self


#: All trees made so far.
_MADE: dict[judged.Tree, Tree] = {}
_key = attrgetter("key")


def single(colour: str = "o") -> Tree:
    """Return the tree of one node of the given colour."""
    return tree((), colour)


def tree(children: Iterable[Tree] = (), colour: str = "o") -> Tree:
    """Return the tree with a root of the given colour and the given subtrees, in any order.

    Raises
    ------
    UsageError
        For an unknown colour.
    """
    if colour not in _PLACES:
        raise UsageError(f"`colour` must be a letter or a digit from 1 to 9, got {colour!r}")
    below = tuple(sorted(children, key=_key))
    form = colour, tuple(sorted(x.judged for x in below))
    return _MADE.get(form) or _made(form, below)


def from_judged(t: judged.Tree) -> Tree:
    """Return a tree of the judge as one of the package."""
    return _MADE.get(t) or _made(t, tuple(sorted(map(from_judged, t[1]), key=_key)))


def _made(form: judged.Tree, below: tuple[Tree, ...]) -> Tree:
    new, order = object.__new__(Tree), 1 + sum(x.order for x in below)
    density, symmetry, repeat = order, 1, 0
    for x, before in zip(below, (None, *below), strict=False):
        repeat = repeat + 1 if x is before else 1
        density, symmetry = density * x.density, symmetry * x.symmetry * repeat
    key = order, _PLACES[form[0]], tuple([x.key for x in reversed(below)])
    values = below, form[0], density, form, key, order, symmetry
    for name, value in zip(Tree.__slots__, values, strict=True):
        object.__setattr__(new, name, value)
    _MADE[form] = new
    return new


def parse_tree(text: str) -> Tree:
    """Read the text form, for example ``"[o[oo]]"`` or ``"f[kk[f]]"``.

    Raises
    ------
    UsageError
        Naming the place that cannot be read.
    """
    try:
        result = from_judged(judged.read_tree(text))
    except Refused as error:
        raise UsageError(f"{error}; a tree is such as 'o', '[o[oo]]' or 'f[kk[f]]'") from None
    seen = _colours(result)
    if not any(seen <= set(family) for family in _FAMILIES):
        raise UsageError(
            f"{text!r} mixes 'o' with 'f' and 'k' or digits: the colours of a tree are those of "
            f"one method, 'o', of a partitioned one, 'f' and 'k', or of an additive one, '1' to '9'"
        )
    return result


def _colours(t: Tree) -> set[str]:
    return {t.colour}.union(*map(_colours, t.children))


#: Trees of one order that are listed: more than the judge takes, who needs one where one fails.
_MOST = 1_000_000


@cache
def _level(order: int, colours: judged.Palette) -> tuple[Tree, ...]:
    """Return all trees of an order, sorted: those with the smallest largest branch first."""
    try:
        return tuple(sorted(map(from_judged, judged.trees(colours, order, _MOST)), key=_key))
    except Refused as error:
        raise ExactnessError(f"trees of order {order}: {error}") from error


def trees(order: int, palette: Palette = ROOTED) -> tuple[Tree, ...]:
    """Return all trees of the given order, bushy ones first, in the same order every time.

    Raises
    ------
    UsageError
        For an order outside 1..:data:`MAX_ORDER`, or a palette that is not in order.
    """
    if not isinstance(order, int) or not 1 <= order <= MAX_ORDER:
        raise UsageError(f"`order` must be an integer from 1 to {MAX_ORDER}, got {order!r}")
    if sorted(palette, key=_PLACES.__getitem__) != list(palette):
        raise UsageError(f"the colours of a palette are in order, got {', '.join(palette)}")
    return _level(order, tuple(palette.items()))


def trees_up_to(order: int, palette: Palette = ROOTED) -> tuple[Tree, ...]:
    """Return all trees of order 1 to ``order`` (which may be 0), in ascending order."""
    return tuple(t for n in range(1, order + 1) for t in trees(n, palette))


@cache
def paths(order: int, colours: tuple[tuple[str, str], ...]) -> tuple[Tree, ...]:
    """Return the trees of an order without branches: for each colour of the root one or none.

    Where a colour may stand below itself and below others, the colours alternate.

    Parameters
    ----------
    order : int
        At least 1.
    colours : tuple of (str, str)
        The items of a palette.
    """
    return tuple(map(from_judged, judged.paths(colours, order)))


def is_nystrom(t: Tree) -> bool:
    """Tell whether a tree counts on second-order systems: see :func:`counted`."""
    return judged.is_nystrom(t.judged)


@cache
def counted(system: str) -> Callable[[Tree], bool]:
    """Return the filter of the trees that count on some systems: the others vanish there.

    Parameters
    ----------
    system : str
        That of a method (:attr:`glmref.method.Method.system`), or ``"nystrom"`` for second-order
        systems, q' = M^-1 p. There f is linear and does not see q (HLW 2006, II.2.3): its second
        derivative is zero, and with it the elementary differential of every tree in which a vertex
        f has two children or more.

    The trees left contain, with a tree, all its subtrees and all trees left when branches are cut
    off: their conditions are a system in which the others do not occur.
    """
    if system == "nystrom":
        return is_nystrom
    return lambda t: judged.stands(t.judged, system) if system else True


@cache
def pruned(t: Tree) -> Mapping[Tree, int]:
    """Count the ways from each pruned subtree to ``t``, growing one leaf at a time.

    Returns
    -------
    Mapping[Tree, int]
        For every ``kept`` (a subtree of ``t`` with the same root, ``t`` itself included) the number
        N of pairs: a place of ``kept`` in ``t``, and an order of the removed vertices in which
        parents come first. With it the flow of duration c acts on a series by ``(E^c a)(t) =
        a(empty) c^|t| / gamma(t) + sum N(t, s) c^j / j! a(s)``, ``j = |t| - |s|``.
    """
    ways = ((from_judged(s), weight) for s, weight in judged.cut(t.judged))
    return MappingProxyType({s: int(x * factorial(t.order - s.order)) for s, x in ways})


#: A way to contract a tree: what is left of it with each part as one vertex, the part with the
#: root, the other parts in ascending order.
Contraction = tuple[Tree, Tree, tuple[Tree, ...]]


@cache
def contractions(t: Tree) -> Mapping[Contraction, int]:
    """Cut any edges of a tree and contract each part to a vertex of the colour of its root.

    Returns
    -------
    Mapping[Contraction, int]
        (skeleton, part with the root, other parts) with the number of ways.

    References
    ----------
    Hairer, Lubich, Wanner (2006), section IX.9; Chartier, Hairer, Vilmart, "Algebraic structures
    of B-series", Found. Comput. Math. 10 (2010), 407-427.
    """
    root = single(t.colour)
    if not t.children:
        return MappingProxyType({(root, root, ()): 1})
    last = t.children[-1]
    found: dict[Contraction, int] = {}
    for (skeleton, part, others), ways in contractions(tree(t.children[:-1], t.colour)).items():
        for (inner, below, further), more in contractions(last).items():
            joined = tree((*skeleton.children, *inner.children), t.colour), part * below, further
            for whole, rest, parts in (joined, (skeleton * inner, part, (below, *further))):
                key = whole, rest, tuple(sorted((*others, *parts), key=_key))
                found[key] = found.get(key, 0) + ways * more
    return MappingProxyType(found)


@cache
def edge_cuts(t: Tree) -> Mapping[tuple[Tree, Tree], int]:
    """Cut one edge in all ways: (part cut off, rest with the root) with the number of edges.

    The Lie derivative of a series along a series of vector fields is a sum over these cuts.
    """
    found: dict[tuple[Tree, Tree], int] = {}
    for rest, child in halves(t):
        count = t.children.count(child)
        cuts = [((child, rest), 1), *(((x, rest * y), n) for (x, y), n in edge_cuts(child).items())]
        for key, ways in cuts:
            found[key] = found.get(key, 0) + count * ways
    return MappingProxyType(found)


def halves(t: Tree) -> Iterator[tuple[Tree, Tree]]:
    """Yield the pairs (u, v) with ``t = u * v``, each once: moving the root gives ``v * u``."""
    for i, child in enumerate(t.children):
        if i == 0 or t.children[i - 1] is not child:
            yield tree(t.children[:i] + t.children[i + 1 :], t.colour), child


@dataclass(frozen=True, eq=False)
class FreeTree:
    """A tree without a root: all the rooted trees that differ by the place of the root only.

    Attributes
    ----------
    root : Tree
        The rooted tree that stands for it, the first in the order of :attr:`Tree.key`.
    signs : Mapping[Tree, int]
        Each of the rooted trees with +1 or -1, by the parity of the distance of its root from that
        of ``root``. Elementary Hamiltonians differ by these signs.
    superfluous : bool
        Whether an edge joins two equal halves; the elementary Hamiltonian is then zero.

    References
    ----------
    Hairer, Lubich, Wanner (2006), section IX.9.2.
    """

    root: Tree
    signs: Mapping[Tree, int]
    superfluous: bool

    @property
    def symmetry(self) -> Fraction:
        """Number of automorphisms: the sum of 1/sigma over the rooted trees is order/symmetry."""
        return self.root.order / sum((Fraction(1, t.symmetry) for t in self.signs), Fraction(0))


def free_tree(t: Tree) -> FreeTree:
    """Return the free tree to which a rooted tree belongs."""
    signs = {from_judged(x): sign for x, sign in judged.signed_versions(t.judged).items()}
    root = min(signs, key=_key)
    signs = {x: sign * signs[root] for x, sign in signs.items()}
    return FreeTree(root, signs, judged.is_superfluous(t.judged))


@cache
def free_trees(order: int, colours: tuple[tuple[str, str], ...]) -> tuple[FreeTree, ...]:
    """Return all free trees of an order; a palette by its items."""
    found: dict[Tree, FreeTree] = {}
    for t in trees(order, dict(colours)):
        if t not in found:
            free = free_tree(t)
            found |= dict.fromkeys(free.signs, free)
    return tuple(dict.fromkeys(found.values()))
