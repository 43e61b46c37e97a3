"""Pairs and splittings with an enclosure (section 6.4)."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from itertools import pairwise

from .arithmetic import Fraction
from .classes import Span
from .document import Method
from .enclosures import Enclosed, parameter
from .krawczyk import at_values
from .lie import lie_images
from .linalg import ones
from .numbers import is_nil, total
from .refusals import as_text, matched, require
from .series import Solved
from .trees import Tree, is_nystrom, read_tree, size, trees, versions

PAIR_EQUATION = re.compile(r"order (\S+)|growth ([qp]) (.+)|start (\S+) ([1-9][0-9]?)")


ALTERNATING = (("f", "k"), ("k", "f"))


@cache
def second_order(t: Tree) -> bool:
    """Tell whether every vertex f of the free tree has two neighbours or fewer."""
    return len(t[1]) <= (2 if t[0] == "f" else size(t)) and all(map(is_nystrom, t[1]))


@cache
def listed(n: int, nystrom: bool | str) -> list[Tree]:
    """Return all alternating trees of an order, or those of second-order systems."""
    return [t for t in trees(ALTERNATING, n) if not nystrom or second_order(t)]


@cache
def all_follow(n: int, nystrom: bool | str, given: frozenset[Tree], kind: str | None) -> bool:
    """Tell whether the conditions of some trees of an order give all of that order (6.4).

    One version of each free tree does; of products of flows it is enough that their images span
    those of all trees. `kind` is "splitting", or "f" or "k" for a composition of Verlet steps that
    begin with it; None for methods that carry several values.
    """
    table = {versions(t) for t in listed(n, nystrom)}
    if kind is None:
        return not any(given.isdisjoint(free) for free in table)
    every, chosen = Span(), Span()
    for free in table:
        row = dict(enumerate(lie_images(min(free), kind)))
        every.add(row)
        if not given.isdisjoint(free):
            chosen.add(row)
    return len(chosen.rows) == len(every.rows)


class Pair(Enclosed):
    """A file of class pair-sweep or splitting with an enclosure (6.4)."""

    members = "trees", ""

    def prepare(self) -> None:
        """Read the matrices and equations and check what the theorems suppose."""
        doc, one = self.document, [[Fraction(1)]]
        self.splitting = doc["class"] == "splitting"
        names = ("a", "b") if self.splitting else ("b", "c")
        self.b, self.c = (self.numbers.vector(doc[x], doc) for x in names)
        X, Y = [ones(len(self.b))], [ones(len(self.c))]
        if self.splitting:
            self.V, self.G, self.first, self.last = {"f": one, "k": one}, one, one, one
            letters = ("PQ" if doc["first"] == "q" else "QP") * max(len(self.b), len(self.c))
            letters = letters[: len(self.b) + len(self.c)]
        else:
            self.suppose({"f": "V", "k": "V_hat"})
            letters = as_text(doc["stages"], "the stages")
            X += self.matrix("w") if doc.get("w", []) != [] else []
            Y += self.matrix("v") if doc.get("v", []) != [] else []
        self.halves = {"f": (self.b, X), "k": (self.c, Y)}
        require(set(letters) <= {"P", "Q"}, "the stages")
        require(letters.count("P") == len(self.b) and letters.count("Q") == len(self.c), "stages")
        self.letters = letters
        self.one_step = len(self.first) == len(self.last) == 1
        require(self.proof.get("trees", "all") in ("all", "nystrom"), "trees")
        self.nystrom = self.proof.get("trees") == "nystrom"
        self.equations = [self.read(text) for text in self.texts]
        self.order = max((size(e[1]) + (e[0] == "start") for e in self.equations
                          if e[0] != "growth"), default=1)  # fmt: skip
        self.signs = self.find_signs() if letters == letters[::-1] else None
        why = "a principal part is not 0" if self.signs else "b, c, w, v must be palindromic"
        require(self.identity_through(self.order - 1, self.nystrom), why)

    def read(self, text: object) -> tuple:
        """Return an equation: (order, tree), (growth, -, form) or (start, tree, value)."""
        found = matched(PAIR_EQUATION, text, f"{str(text)[:40]!r} is no equation")
        tree, half, z, start, value = found.groups()
        if half:
            return "growth", None, self.growth_form(z, "f" if half == "q" else "k")
        tree_ = read_tree(tree or start)
        require(tree_ in trees(ALTERNATING, size(tree_)), "an equation names another tree")
        require(not self.nystrom or second_order(tree_), "an equation names another tree")
        if tree:
            return "order", tree_
        require(2 <= int(value) <= len(self.V[tree_[0]]), "an equation names another value")
        return "start", tree_, int(value) - 1

    def series(self, values: list, order: int, nystrom: bool | str) -> Solved:
        """Return the series with principal parts 0, with eta below the order; the root moves."""
        found = Solved(self.at(values), True, nystrom)
        found.pool = lambda order: listed(order, nystrom)
        found.advance(order)
        return found

    def residuals(self, values: list) -> list:
        """Return left minus right of every equation."""
        series, found = self.series(values, self.order, self.nystrom), []
        for kind, tree, *what in self.equations:
            if kind == "order":
                found += series.condition(tree)
            elif kind == "start":
                found.append(series.eta[tree][what[0]])
            else:
                half, _, H = what[0]
                found.append(parameter(H, *(at_values(x, values) for x in self.halves[half])))
        return found

    def is_zero_start(self, t: Tree, k: int, L: Mapping[str, list]) -> bool:
        """Tell whether zeta_k(t) = 0 by an equation `start` or by parity."""
        if ("start", t, k) in self.equations:
            return True
        off = any(bool(x) for j, x in enumerate(L[t[0]][k]) if j != k)
        return not off and L[t[0]][k][k] == (-1) ** (size(t) + 1)

    def identity_through(self, n: int, nystrom: bool | str) -> bool:
        """Tell whether all principal parts through order n are 0 (6.4)."""
        if self.one_step or n < 2:
            return True
        if self.signs is None:
            return False
        L = self.reversal()
        level = [t for m in range(1, n) for t in listed(m, nystrom)]
        shown = {(t, k): self.is_zero_start(t, k, L) for t in level for k in range(1, len(L[t[0]]))}
        return all(shown[t, k] or shown[u, l]
                   for t in level if t[0] == "f" for u in level if u[0] == "k"
                   and size(t) + size(u) <= n
                   for k in range(1, len(self.G)) for l in range(1, len(self.G[0]))
                   if bool(self.G[k][l]))  # fmt: skip

    def flow(self) -> str | None:
        """Return the Lie algebra of a product of flows (6.4), None for several values."""
        if not self.one_step:
            return None
        for outer, inside, pattern in ((self.b, self.c, "PQ"), (self.c, self.b, "QP")):
            if self.letters != pattern * len(inside) + pattern[0]:
                continue
            steps = [Fraction(0), *inside, Fraction(0)]
            if all(2 * x == a + b for x, (a, b) in zip(outer, pairwise(steps), strict=True)):
                return "f" if pattern == "PQ" else "k"
        return "splitting"

    def covered(self, n: int, nystrom: bool | str) -> bool:
        """Tell whether the equations give all conditions of order n."""
        given = {e[1] for e in self.equations if e[0] == "order"}
        if n == 1:
            for root, weights in (("f", self.b), ("k", self.c)):
                if is_nil(total(weights) - 1):
                    given.add((root, ()))
        named = frozenset(t for t in given if size(t) == n)
        return all_follow(n, nystrom, named, self.flow())

    def is_of_the_theorem(self, identity: bool, nystrom: bool | str, row: str | None) -> bool:
        """Tell whether the pair is symmetric or carries one value of each component."""
        return self.signs is not None or self.one_step

    def principal_is_zero(self, p: int, identity: bool, nystrom: bool | str) -> bool:
        """Tell whether all principal parts below p are 0."""
        return self.identity_through(p - 1, nystrom)

    def gives_order(self, p: int, nystrom: bool | str, row: str | None, method: Method) -> bool:
        """Tell whether the equations give all conditions through order p."""
        step = 2 if self.signs is not None else 1
        return all(self.covered(n, nystrom) for n in range(1, p + 1, step))

    def implies(self, claim: str) -> bool:
        """Tell whether a claim that is true or false holds at the root."""
        if claim == "symplectic":
            return self.one_step
        if claim == "consistent":
            return self.covered(1, False)
        if claim == "symmetric":
            return self.signs is not None
        return claim in ("preconsistent", "g-symplectic")

    def zero_start_holds(self, q: int, nystrom: bool | str) -> bool:
        """Tell whether every value but the first is 0 on all trees through order q."""
        if self.one_step or self.signs is None:
            return self.one_step
        L = self.reversal()
        return all(self.is_zero_start(t, k, L) for n in range(1, q + 1)
                   for t in listed(n, nystrom) for k in range(1, len(L[t[0]])))  # fmt: skip
