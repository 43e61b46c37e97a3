"""Rooted trees: densities, enumeration, cuts, texts (section 3)."""

from __future__ import annotations

from functools import cache
from itertools import product
from typing import TypeAlias

from .arithmetic import Fraction
from .refusals import require

TREES = 40_000  # trees of one order

#: A rooted tree: the colour of the root and the trees of its children, in order.
Tree: TypeAlias = "tuple[str, tuple[Tree, ...]]"


@cache
def size(tree):
    """Return |t|; a tree is (colour, children in order)."""
    return 1 + sum(size(child) for child in tree[1])


@cache
def gamma(tree):
    """Return the density gamma(t)."""
    value = size(tree)
    for child in tree[1]:
        value *= gamma(child)
    return value


@cache
def trees(palette, order):
    """Return all trees of an order: each colour of root with all multisets of children."""
    smaller = [t for n in range(1, order) for t in trees(palette, n)]
    found = []
    for colour, children in palette:
        pool = [t for t in smaller if t[0] in children]
        for forest in forests(pool, order - 1, 0):
            found.append((colour, tuple(sorted(forest))))
            require(len(found) <= TREES, "beyond the limits of this checker")
    return found


def forests(pool, left, start):
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
def is_nystrom(tree):
    """Tell whether no vertex f has two children or more, or a child f."""
    bad = tree[0] == "f" and (len(tree[1]) > 1 or any(x[0] == "f" for x in tree[1]))
    return not bad and all(map(is_nystrom, tree[1]))


def is_coloured(tree, palette):
    """Tell whether every vertex has a colour of the palette, and children that it may have."""
    below = dict(palette)
    return tree[0] in below and all(
        child[0] in below[tree[0]] and is_coloured(child, palette) for child in tree[1]
    )


@cache
def stands(tree, system):
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


def read_tree(text):
    """Return the tree of a text such as f[kk[f]]."""
    require(isinstance(text, str) and 0 < len(text) <= 200, "a tree is a short text")
    place = 0

    def vertex():
        nonlocal place
        colour, children = text[place : place + 1], []
        require(colour and colour in "ofk123456789[", f"{text!r} is no tree")
        place += colour != "["
        if colour == "o":  # always a single vertex: with children the colour o is not written
            return "o", ()
        colour = "o" if colour == "[" else colour
        if text[place : place + 1] == "[":
            place += 1
            while text[place : place + 1] not in ("]", ""):
                children.append(vertex())
            require(children and text[place : place + 1] == "]", f"{text!r} is no tree")
            place += 1
        return colour, tuple(sorted(children))

    tree = vertex()
    require(place == len(text), f"{text!r} is no tree")
    return tree


@cache
def cut(tree):
    """Return pairs (s, N(t, s) / m!): what is left when branches are cut, the root kept."""
    return list(cuts(tree).items())


def cuts(tree, weight=None):
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
def residual_weights(tree):
    """Return the trees s left when t is cut, but t itself, and the weights of R(t) (section 3).

    They are those of B xiD(t), u and the eta(s): 1, -1 / gamma(t) and -N(t, s) / m!.
    """
    left = [(s, weight) for s, weight in cut(tree) if s != tree]
    weights = [Fraction(1), Fraction(-1, gamma(tree)), *(-weight for _, weight in left)]
    return [s for s, _ in left], weights


PATHS = {"paths": "fk", "nystrom-paths": "f"}  # trees without branches: which stages are checked


def mode(witness):
    """Return (identity?, nystrom?) of a witness."""
    require(witness["principal"] in ("free", "identity"), "principal is free or identity")
    return witness["principal"] == "identity", counted(witness["trees"])


def counted(name):
    """Return which trees a name means: False for all, True for nystrom, else the name itself."""
    require(name in ("all", "nystrom", *PATHS), "trees are all, nystrom, paths or nystrom-paths")
    return name if name in PATHS else name == "nystrom"


def paths(palette, order):
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


def pool_of(method, order, nystrom):
    """Return the trees of one order that count."""
    if nystrom in PATHS:
        return paths(method.palette, order)
    return [t for t in trees(method.palette, order)
            if stands(t, method.system) and (not nystrom or is_nystrom(t))]  # fmt: skip


def through(method, order, nystrom):
    """Return the trees through an order that count."""
    return [t for n in range(1, order + 1) for t in pool_of(method, n, nystrom)]


def show(tree):
    """Return the text of a tree."""
    inner = "".join(map(show, tree[1]))
    return (tree[0] if tree[0] != "o" or not inner else "") + (f"[{inner}]" if inner else "")


LEAF = ("o", ())


def attach(t, u):
    """Return t * u: u attached to the root of t."""
    return t[0], tuple(sorted((*t[1], u)))


@cache
def neighbours(t):
    """Return (rest, branch, tree with the root moved into the branch) for each branch."""
    found = []
    for u in dict.fromkeys(t[1]):
        rest = list(t[1])
        rest.remove(u)
        found.append(((t[0], tuple(rest)), u, attach(u, (t[0], tuple(rest)))))
    return found


@cache
def versions(t):
    """Return all rooted versions of the free tree under t."""
    found, waiting = {t}, [t]
    while waiting:
        for _, _, other in neighbours(waiting.pop()):
            if other not in found:
                found.add(other)
                waiting.append(other)
    return frozenset(found)
