"""Rooted trees: densities, enumeration, cuts, texts (section 3)."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cache
from itertools import product
from math import factorial
from typing import TypeAlias

from .arithmetic import Fraction, Number
from .document import Method
from .refusals import as_text, require

TREES = 40_000  # trees of one order

#: The colours with those that their children may have.
Palette: TypeAlias = "tuple[tuple[str, str], ...]"
#: A rooted tree: the colour of the root and the trees of its children, in order.
Tree: TypeAlias = "tuple[str, tuple[Tree, ...]]"


@cache
def size(tree: Tree) -> int:
    """Return |t|; a tree is (colour, children in order)."""
    return 1 + sum(size(child) for child in tree[1])


@cache
def gamma(tree: Tree) -> int:
    """Return the density gamma(t)."""
    value = size(tree)
    for child in tree[1]:
        value *= gamma(child)
    return value


@cache
def trees(palette: Palette, order: int, most: int = TREES) -> list[Tree]:
    """Return all trees of an order: each colour of root with all multisets of children."""
    smaller = [t for n in range(1, order) for t in trees(palette, n, most)]
    found = []
    for colour, children in palette:
        pool = [t for t in smaller if t[0] in children]
        for forest in forests(pool, order - 1, 0):
            found.append((colour, tuple(sorted(forest))))
            require(len(found) <= most, "beyond the limits of this checker")
    return found


def forests(pool: list[Tree], left: int, start: int) -> Iterator[tuple[Tree, ...]]:
    """Yield the multisets of trees of the pool, which is ordered by size, with `left` vertices."""
    if not left:
        yield ()
        return
    for i in range(start, len(pool)):
        if size(pool[i]) > left:
            return
        for rest in forests(pool, left - size(pool[i]), i):
            yield (pool[i], *rest)


@cache
def is_nystrom(tree: Tree) -> bool:
    """Tell whether no vertex f has two children or more, or a child f."""
    bad = tree[0] == "f" and (len(tree[1]) > 1 or any(x[0] == "f" for x in tree[1]))
    return not bad and all(map(is_nystrom, tree[1]))


def is_coloured(tree: Tree, palette: Palette) -> bool:
    """Tell whether every vertex has a colour of the palette, and children that it may have."""
    below = dict(palette)
    return tree[0] in below and all(
        child[0] in below[tree[0]] and is_coloured(child, palette) for child in tree[1]
    )


@cache
def stands(tree: Tree, system: str) -> bool:
    """Tell whether a tree does not vanish on the systems of a method."""
    colour, n = tree[0], len(tree[1])
    fine = True
    if system == "time":  # t' = 1 has no arguments
        fine = colour != "k" or n == 0
    elif system == "w" or (system and colour == "2"):  # J is linear
        fine = colour != "2" or n < 2
    elif system == "rosenbrock":  # and f - J has the derivative 0
        fine = n != 1
    return fine and all(stands(x, system) for x in tree[1])


def read_tree(text: object) -> Tree:
    """Return the tree of a text such as f[kk[f]]."""
    given, place = as_text(text, "a tree is a text of 1 to 200 characters"), 0
    require(0 < len(given) <= 200, "a tree is a text of 1 to 200 characters")

    def need(truth: object) -> None:
        require(truth, f"{given!r} is no tree, which is seen at its place {place + 1}")

    def vertex() -> Tree:
        nonlocal place
        colour, children = given[place : place + 1], []
        need(colour and colour in "ofk123456789[")
        place += colour != "["
        if colour == "o":  # always a single vertex: with children the colour o is not written
            return "o", ()
        colour = "o" if colour == "[" else colour
        if given[place : place + 1] == "[":
            place += 1
            while given[place : place + 1] not in ("]", ""):
                children.append(vertex())
            need(children and given[place : place + 1] == "]")
            place += 1
        return colour, tuple(sorted(children))

    tree = vertex()
    need(place == len(given))
    return tree


@cache
def cut(tree: Tree) -> list[tuple[Tree, Fraction]]:
    """Return pairs (s, N(t, s) / m!): what is left when branches are cut, the root kept."""
    return list(cuts(tree).items())


def cuts(tree: Tree, weight: Callable[[Tree], Number] | None = None) -> dict:
    """Return {s: sum over the ways to cut of the product of the weights, else of 1 / gamma}."""
    found = {(): Fraction(1)}
    for child in tree[1]:
        kept = cut(child) if weight is None else cuts(child, weight).items()
        gone = Fraction(1, gamma(child)) if weight is None else weight(child)
        options = [((), gone), *(((s,), w) for s, w in kept)]
        more = {}
        for (forest, x), (rest, y) in product(found.items(), options):
            key = tuple(sorted(forest + rest))
            more[key] = more.get(key, 0) + x * y
        found = more
    return {(tree[0], forest): w for forest, w in found.items()}


@cache
def residual_weights(tree: Tree) -> tuple[list[Tree], list[Fraction]]:
    """Return the trees s left when t is cut, but t itself, and the weights of R(t) (section 3).

    They are those of B xiD(t), u and the eta(s): 1, -1 / gamma(t) and -N(t, s) / m!.
    """
    left = [(s, weight) for s, weight in cut(tree) if s != tree]
    weights = [Fraction(1), Fraction(-1, gamma(tree)), *(-weight for _, weight in left)]
    return [s for s, _ in left], weights


PATHS = {"paths": "fk", "nystrom-paths": "f"}  # trees without branches: which stages are checked


def mode(principal: str, name: str) -> tuple[bool, bool | str]:
    """Return (identity?, trees): False for all, True for nystrom, else the name itself."""
    require(principal in ("free", "identity"), "principal is free or identity")
    require(name in ("all", "nystrom", *PATHS), "trees are all, nystrom, paths or nystrom-paths")
    return principal == "identity", name if name in PATHS else name == "nystrom"


def paths(palette: Palette, order: int) -> list[Tree]:
    """Return the trees of an order without branches, colours alternating where there are two."""
    if order == 1:
        return [(colour, ()) for colour, _ in palette]
    below = paths(palette, order - 1)
    return [
        (colour, (t,))
        for colour, children in palette
        for t in below
        if t[0] in children and (t[0] != colour or len(children) == 1)
    ]


def pool_of(method: Method, order: int, nystrom: bool | str) -> list[Tree]:
    """Return the trees of one order that count."""
    return counted(method.palette, method.system, order, nystrom)


def counted(palette: Palette, system: str, order: int, nystrom: bool | str) -> list[Tree]:
    """Return the trees of a palette that count for the systems of a method."""
    if nystrom in PATHS:
        return paths(palette, order)
    return [t for t in trees(palette, order)
            if stands(t, system) and (not nystrom or is_nystrom(t))]  # fmt: skip


def through(method: Method, order: int, nystrom: bool | str) -> list[Tree]:
    """Return the trees through an order that count."""
    return [t for n in range(1, order + 1) for t in pool_of(method, n, nystrom)]


def show(tree: Tree) -> str:
    """Return the text of a tree."""
    inner = "".join(map(show, tree[1]))
    return (tree[0] if tree[0] != "o" or not inner else "") + (f"[{inner}]" if inner else "")


LEAF = ("o", ())


def attach(t: Tree, u: Tree) -> Tree:
    """Return t * u: u attached to the root of t."""
    return t[0], tuple(sorted((*t[1], u)))


@cache
def neighbours(t: Tree) -> list[tuple[Tree, Tree, Tree]]:
    """Return (rest, branch, tree with the root moved into the branch) for each branch."""
    found = []
    for u in dict.fromkeys(t[1]):
        rest = list(t[1])
        rest.remove(u)
        found.append(((t[0], tuple(rest)), u, attach(u, (t[0], tuple(rest)))))
    return found


@cache
def symmetry(tree: Tree) -> int:
    """Return sigma(t), the number of automorphisms."""
    value = 1
    for child in set(tree[1]):
        count = tree[1].count(child)
        value *= factorial(count) * symmetry(child) ** count
    return value


@cache
def signed_versions(t: Tree) -> dict[Tree, int]:
    """Return {version: sign of H at it} of the free tree under t; a move of the root changes it."""
    found, waiting = {t: 1}, [t]
    while waiting:
        s = waiting.pop()
        for _, _, other in neighbours(s):
            if other not in found:
                found[other] = -found[s]
                waiting.append(other)
    return found


@cache
def versions(t: Tree) -> frozenset[Tree]:
    """Return all rooted versions of the free tree under t."""
    return frozenset(signed_versions(t))


def is_superfluous(t: Tree) -> bool:
    """Tell whether an edge of the free tree under t joins two equal halves."""
    return any(rest == branch for s in versions(t) for rest, branch, _ in neighbours(s))
