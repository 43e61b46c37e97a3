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

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from math import comb, factorial
from operator import attrgetter
from string import ascii_letters
from types import MappingProxyType
from typing import Any, NoReturn

from ..errors import UsageError
from ..judge import trees as judged
from ..method.component import ROOTED, Palette

#: Largest order for which all trees are listed (32973 one-coloured trees have order 14).
MAX_ORDER = 14

#: Colours that occur together: of one method, of a partitioned one, of the parts of a sum.
_FAMILIES = ("o", "fk", "123456789")
_READ = "".join(_FAMILIES)
#: Every colour, in the order in which trees are sorted; those of a palette stand in this order.
_COLOURS = ascii_letters + "123456789"
_MAX_TEXT = 2000  # characters of a tree's text form


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

    __slots__ = ("_repeat", "children", "colour", "density", "key", "order", "symmetry")
    colour: str  #: Colour of the root.
    children: tuple[Tree, ...]  #: Subtrees of the root, in ascending order (see :attr:`key`).
    order: int  #: Number of vertices, ``|t|``.
    density: int  #: ``gamma(t)``, the product over all vertices of the order of the subtree there.
    symmetry: int  #: ``sigma(t)``, the order of the automorphism group.
    #: Sort key: by order, then colour, then the largest children first.
    key: tuple[Any, ...]
    _repeat: int  # how many of the last children are equal

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

    @property
    def extensions(self) -> int:
        """``|t|! / gamma(t)``: orders in which the vertices can appear, parents first."""
        return factorial(self.order) // self.density

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


_set_colour = Tree.colour.__set__  # type: ignore[attr-defined]
_set_children = Tree.children.__set__  # type: ignore[attr-defined]
_set_order = Tree.order.__set__  # type: ignore[attr-defined]
_set_density = Tree.density.__set__  # type: ignore[attr-defined]
_set_symmetry = Tree.symmetry.__set__  # type: ignore[attr-defined]
_set_key = Tree.key.__set__  # type: ignore[attr-defined]
_set_repeat = Tree._repeat.__set__  # type: ignore[attr-defined]
_blank = object.__new__

#: All trees made so far: colour of the root -> children -> tree.
_MADE: dict[str, dict[tuple[Tree, ...], Tree]] = {colour: {} for colour in _COLOURS}


def _make_single(colour: str) -> Tree:
    new = _blank(Tree)
    _set_colour(new, colour)
    _set_children(new, ())
    _set_order(new, 1)
    _set_density(new, 1)
    _set_symmetry(new, 1)
    _set_key(new, (1, _COLOURS.index(colour), ()))
    _MADE[colour][()] = new
    return new


_SINGLE = {colour: _make_single(colour) for colour in _COLOURS}


def _graft(rest: Tree, last: Tree) -> Tree:
    """Return ``rest`` with ``last``, not smaller than its children, as one more child."""
    return _graft_all((rest,), last)[0]


def _graft_all(rests: Sequence[Tree], last: Tree) -> list[Tree]:
    """Graft ``last`` on each of the trees, which have roots of one colour.

    One loop for many trees, for speed: all 1205 trees of order 10 or less take about a millisecond.
    """
    made = _MADE[rests[0].colour] if rests else {}
    result = []
    for rest in rests:
        children = (*rest.children, last)
        new = made.get(children)
        if new is None:
            made[children] = new = _blank(Tree)
            order = rest.order + last.order
            repeat = rest._repeat + 1 if len(children) > 1 and children[-2] is last else 1
            _set_colour(new, rest.colour)
            _set_children(new, children)
            _set_order(new, order)
            _set_density(new, rest.density // rest.order * last.density * order)
            _set_symmetry(new, rest.symmetry * last.symmetry * repeat)
            _set_key(new, (order, rest.key[1], (last.key, *rest.key[2])))
            _set_repeat(new, repeat)
        result.append(new)
    return result


def single(colour: str = "o") -> Tree:
    """Return the tree of one node of the given colour."""
    return _SINGLE[colour]


def tree(children: Iterable[Tree] = (), colour: str = "o") -> Tree:
    """Return the tree with a root of the given colour and the given subtrees, in any order.

    Raises
    ------
    UsageError
        For an unknown colour.
    """
    if colour not in _SINGLE:
        raise UsageError(f"`colour` must be a letter or a digit from 1 to 9, got {colour!r}")
    below = tuple(sorted(children, key=_key))
    known = _MADE[colour].get(below)
    if known is not None:
        return known
    result = _SINGLE[colour]
    for child in below:
        result = _graft(result, child)
    return result


_key = attrgetter("key")


def parse_tree(text: str) -> Tree:
    """Read the text form, for example ``"[o[oo]]"`` or ``"f[kk[f]]"``.

    Raises
    ------
    UsageError
        Naming the place that cannot be read.
    """
    if not isinstance(text, str) or len(text) > _MAX_TEXT:
        raise UsageError(f"a tree is a text of at most {_MAX_TEXT} characters such as '[o[oo]]'")
    open_roots: list[tuple[str, list[Tree]]] = [("", [])]
    place = 0
    while place < len(text):
        letter = text[place]
        if letter == "[" or (letter in _READ[1:] and text[place + 1 : place + 2] == "["):
            open_roots.append(("o" if letter == "[" else letter, []))
            place += 1 if letter == "[" else 2
        elif letter in _READ:
            open_roots[-1][1].append(_SINGLE[letter])
            place += 1
        elif letter == "]" and len(open_roots) > 1 and open_roots[-1][1]:
            colour, children = open_roots.pop()
            open_roots[-1][1].append(tree(children, colour))
            place += 1
        else:
            raise UsageError(f"{text!r} is not a tree: {letter!r} at place {place + 1}")
    if len(open_roots) != 1 or len(open_roots[0][1]) != 1:
        raise UsageError(f"{text!r} is not one tree such as 'o', '[o[oo]]' or 'f[kk[f]]'")
    result = open_roots[0][1][0]
    seen = {vertex.colour for vertex in _vertices(result)}
    if not any(seen <= set(family) for family in _FAMILIES):
        raise UsageError(
            f"{text!r} mixes 'o' with 'f' and 'k' or digits: the colours of a tree are those of "
            f"one method, 'o', of a partitioned one, 'f' and 'k', or of an additive one, '1' to '9'"
        )
    return result


def _vertices(t: Tree) -> Iterator[Tree]:
    waiting = [t]
    while waiting:
        vertex = waiting.pop()
        yield vertex
        waiting.extend(vertex.children)


class _Listing:
    """All trees of one palette, order by order; each tree is reached exactly once.

    A tree with more than one vertex is ``rest`` with its largest child ``last`` grafted on, so the
    trees of order n are the pairs (last, rest) with ``|last| + |rest| = n`` and no child of
    ``rest`` larger than ``last``. Lists are sorted by largest child: these ``rest`` are a prefix.
    """

    def __init__(self, palette: Palette) -> None:
        self.palette = dict(palette)
        if sorted(palette, key=_COLOURS.index) != list(palette):
            raise UsageError(f"the colours of a palette are in order, got {', '.join(palette)}")
        self.levels: list[dict[str, list[Tree]]] = [{}, {c: [_SINGLE[c]] for c in palette}]
        self.sorted: list[tuple[Tree, ...]] = [(), tuple(_SINGLE[c] for c in palette)]

    def level(self, order: int) -> tuple[Tree, ...]:
        while len(self.levels) <= order:
            self._extend(len(self.levels))
        return self.sorted[order]

    def _extend(self, order: int) -> None:
        level: dict[str, list[Tree]] = {}
        for colour, allowed in self.palette.items():
            level[colour] = found = []
            for size in range(1, order):
                rests = self.levels[order - size][colour]
                end = 0
                while end < len(rests) and (
                    not rests[end].children or rests[end].children[-1].order < size
                ):
                    end += 1
                for last in self.sorted[size]:
                    if last.colour not in allowed:
                        continue
                    while end < len(rests) and rests[end].children[-1] is last:
                        end += 1
                    found += _graft_all(rests[:end], last)
        self.levels.append(level)
        self.sorted.append(tuple(t for colour in self.palette for t in level[colour]))


_LISTINGS: dict[tuple[tuple[str, str], ...], _Listing] = {}


def trees(order: int, palette: Palette = ROOTED) -> tuple[Tree, ...]:
    """Return all trees of the given order, bushy ones first, in the same order every time.

    Raises
    ------
    UsageError
        For an order outside 1..:data:`MAX_ORDER`, or a palette that is not in order.
    """
    if not isinstance(order, int) or not 1 <= order <= MAX_ORDER:
        raise UsageError(f"`order` must be an integer from 1 to {MAX_ORDER}, got {order!r}")
    name = tuple(palette.items())
    if name not in _LISTINGS:
        _LISTINGS[name] = _Listing(palette)
    return _LISTINGS[name].level(order)


def trees_up_to(order: int, palette: Palette = ROOTED) -> tuple[Tree, ...]:
    """Return all trees of order 1 to ``order`` (which may be 0), in ascending order."""
    return tuple(t for n in range(1, order + 1) for t in trees(n, palette))


@cache
def as_judged(t: Tree) -> judged.Tree:
    """Return a tree as the judge has it: the colour of the root, and the children in order."""
    return t.colour, tuple(sorted(map(as_judged, t.children)))


def from_judged(t: judged.Tree) -> Tree:
    """Return a tree of the judge as one of the package."""
    return tree(map(from_judged, t[1]), t[0])


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
    return judged.is_nystrom(as_judged(t))


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
    return lambda t: judged.stands(as_judged(t), system) if system else True


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

    Integers only, so they are remembered for good.
    """
    if not t.children:
        return MappingProxyType({t: 1})
    last = t.children[-1]
    rest = _MADE[t.colour][t.children[:-1]]
    ways: dict[Tree, int] = {}
    whole = [(None, last.extensions), *pruned(last).items()]
    for kept_rest, ways_rest in pruned(rest).items():
        removed_rest = rest.order - kept_rest.order
        for kept_last, ways_last in whole:
            removed = removed_rest + last.order - (kept_last.order if kept_last else 0)
            kept = _insert(kept_rest, kept_last) if kept_last else kept_rest
            count = ways_rest * ways_last * comb(removed, removed_rest)
            ways[kept] = ways.get(kept, 0) + count
    return MappingProxyType(ways)


def _insert(rest: Tree, child: Tree) -> Tree:
    """Return ``rest`` with one more child, which may be smaller than the others."""
    if not rest.children or rest.children[-1] is child:
        return _graft(rest, child)
    return tree((*rest.children, child), rest.colour)


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
    if not t.children:
        return MappingProxyType({})
    last = t.children[-1]
    rest = _MADE[t.colour][t.children[:-1]]
    found: dict[tuple[Tree, Tree], int] = {(last, rest): 1}
    for (part, kept), ways in edge_cuts(rest).items():
        key = part, _insert(kept, last)
        found[key] = found.get(key, 0) + ways
    for (part, kept), ways in edge_cuts(last).items():
        key = part, _insert(rest, kept)
        found[key] = found.get(key, 0) + ways
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
    signs, superfluous, waiting = {t: 1}, False, [t]
    while waiting:
        at = waiting.pop()
        for u, v in halves(at):
            superfluous |= u is v
            if v * u not in signs:
                signs[v * u] = -signs[at]
                waiting.append(v * u)
    root = min(signs, key=_key)
    return FreeTree(root, {x: sign * signs[root] for x, sign in signs.items()}, superfluous)


@cache
def free_trees(order: int, colours: tuple[tuple[str, str], ...]) -> tuple[FreeTree, ...]:
    """Return all free trees of an order; a palette by its items."""
    found: dict[Tree, FreeTree] = {}
    for t in trees(order, dict(colours)):
        if t not in found:
            free = free_tree(t)
            found |= dict.fromkeys(free.signs, free)
    return tuple(dict.fromkeys(found.values()))
