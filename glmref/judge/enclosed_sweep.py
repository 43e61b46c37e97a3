"""Sweeps with an enclosure (sections 6.2 and 6.3)."""

from __future__ import annotations

import re

from .arithmetic import Fraction
from .classes import classes, conditions_follow, plan, reduced
from .document import Method
from .enclosures import Enclosed, parameter
from .krawczyk import at_value, at_values
from .linalg import apply, combine, dot, equal, identity, kernel, multiples, transpose
from .numbers import as_reals, is_nil, total
from .refusals import as_list, as_object, matched, require
from .series import Solved
from .trees import LEAF, Tree, gamma, read_tree, size, trees, versions

EQUATION = re.compile(r"(order|growth|explicit|defect|abscissa|start|identity) ([^=]+?)"
                      r"(?: = (.+))?")  # fmt: skip


class Sweep(Enclosed):
    """A file of class sweep with an enclosure: equations, theorems 1 to 3 of 6.2 and 6.3."""

    members = "free", "xi"

    def prepare(self) -> None:
        """Read the matrices and equations and check what the theorems suppose."""
        self.D, self.X = self.numbers.vector(self.document["D"], self.document), self.matrix("X")
        self.suppose({"o": "V"})
        equal(self.G, transpose(self.G), "G = G^T")
        self.halves, self.r, self.s = {"o": (self.D, self.X)}, len(self.first), len(self.D)
        require(len(self.X) == self.r == len(self.G) and len(self.X[0]) == self.s, "shapes")
        require(all(x == 1 for x in self.X[0]), "the first row of X is not 1 identically")
        self.equations = [self.read(text) for text in self.texts]
        self.signs = self.find_signs()
        self.q = self.find_stage_order()
        given = as_object(self.proof.get("free", {}))
        why = "free trees are lists by order"
        require(all(n.isdecimal() for n in given), why)
        self.free = {int(n): tuple(map(read_tree, as_list(ts, why))) for n, ts in given.items()}
        for n, ts in self.free.items():
            require(all(size(t) == n for t in ts), "a free tree has another order")
        require(all(t in self.free.get(size(t), ()) for t in self.xi), "a tree of xi is not free")
        self.explicit = {i for kind, i, *_ in self.equations if kind == "explicit"}
        if self.signs is not None:
            self.explicit |= {self.s - 1 - i for i in self.explicit}
        self.order = max((size(e[2]) + (e[0] != "order") for e in self.equations
                          if e[0] in ("order", "identity", "defect")), default=2)  # fmt: skip

    def read(self, text: object) -> tuple:
        """Return an equation (kind, stage or value, tree or number)."""
        found = matched(EQUATION, text, f"{str(text)[:40]!r} is no equation")
        kind, what, value = found.groups()
        require((value is not None) == (kind == "abscissa"), "an equation")
        if kind in ("order", "identity"):
            tree = read_tree(what)
            require(tree in trees((("o", "o"),), size(tree)), "an equation names another tree")
            return kind, None, tree
        if kind == "growth":
            return kind, None, self.growth_form(what, "o")
        first, _, rest = what.partition(" ")
        top = self.r if kind == "start" else self.s
        require(first.isdigit() and 1 <= int(first) <= top, "an equation names another stage")
        if kind == "abscissa":
            number = self.number(value)
            require(isinstance(number, Fraction) and not rest, "an abscissa is rational")
            return kind, int(first) - 1, number
        if kind == "explicit":
            require(not rest, "an equation")
            return kind, int(first) - 1, None
        return kind, int(first) - 1, read_tree(rest or ("[o]" if kind == "defect" else "o"))

    def find_stage_order(self) -> int:
        """Return the stage order that the equations `defect` give."""
        have, q = {(i, t) for kind, i, t in self.equations if kind == "defect"}, 1
        while True:
            tree = ("o", (LEAF,) * q)
            half = self.s // 2 if (q + 1) % 2 else (self.s + 1) // 2
            if self.signs is None or any((i, tree) not in have for i in range(half)):
                return q
            q += 1

    def series(self, values: list, order: int, nystrom: bool | str = False) -> ByClasses:
        """Return the series by classes, with eta below the order (6.2); it has one component."""
        found = ByClasses(self, values)
        found.advance(order)
        return found

    def residuals(self, values: list) -> list:
        """Return left minus right of every equation."""
        series, found = self.series(values, self.order), []
        for kind, i, what in self.equations:
            if kind == "order":
                found += series.condition(what)
            elif kind in ("identity", "start"):
                found.append(series.cut_value(what)[i or 0])
            elif kind == "growth":
                found.append(parameter(what[2], *(at_values(x, values) for x in (self.D, self.X))))
            elif kind == "explicit":
                found.append(series.part("o").A[i][i])
            elif kind == "abscissa":
                found.append(series.stages(LEAF)[i] - what)
            else:
                c = series.stages(LEAF)[i]
                found.append(series.stages(what)[i] - c ** size(what) * Fraction(1, gamma(what)))
        return found

    # what follows at the root

    def starts_at_two(self) -> bool:
        """Tell whether equations `start K` give zeta(o) = 0 (6.3)."""
        if self.r == 1:
            return True
        L = self.reversal()["o"]
        basis = kernel([row[1:] for row in combine(L, identity(self.r))])
        values = [i for kind, i, t in self.equations if kind == "start" and t == LEAF]
        return len(basis) == 1 and any(k and bool(basis[0][k - 1]) for k in values)

    def abscissae(self) -> list | None:
        """Return the abscissae that the file fixes exactly, or None."""
        c = {}
        for kind, i, value in self.equations:
            if kind == "abscissa":
                c[i] = value
            elif kind == "explicit" and i == 0 and self.starts_at_two():
                c[0] = Fraction(0)
        if self.signs is not None:  # c of the mirror stage is 1 - c
            for i, x in list(c.items()):
                c.setdefault(self.s - 1 - i, 1 - x)
            if self.s % 2:
                c.setdefault(self.s // 2, Fraction(1, 2))
        return [c[i] for i in range(self.s)] if len(c) == self.s else None

    def quadrature(self, power: int) -> bool:
        """Tell whether sum d_i c_i^power = 1 / (power + 1) for all values of the unknowns."""
        c = self.abscissae()
        if c is None:
            return False
        return is_nil(total(d * x**power for d, x in zip(self.D, c, strict=True))
                      - Fraction(1, power + 1))  # fmt: skip

    def given_trees(self) -> set[Tree]:
        """Return the trees whose conditions the file gives (6.3).

        With D exact and all abscissae fixed, zeta_1([o]) = zeta_1([ooo]) = 0 make [oo] the identity
        sum d_i c_i^2 = 1/3 and [oooo] sum d_i c_i^4 = 1/5. zeta_1([ooo]) = 0 is the choice made
        where the file gives no `xi`; zeta_1([o]) = zeta(o)^T G zeta(o) / 2 is 0 by the equation of
        [oo] and the quadrature, or with zeta(o).

        For r = 1 the method composes s steps of the implicit midpoint rule of lengths d_i h,
        palindromic; the logarithm of one is h f + h^3 alpha_3 + h^5 alpha_5 + .., so with
        sum d_i = 1 and sum d_i^3 = 0 the whole is the flow of f + h^4 (p alpha_5 +
        q [f, [f, alpha_3]]) + .. for two numbers p, q: R at order 5 lies in a plane (Yoshida 1990;
        Hairer, Lubich, Wanner 2006, V.3), on which [oooo] and [[o][o]] are coordinates (exact, in
        ``tests/unit/test_derive_enclosure.py``): these two give [oo[o]].
        """
        given = {t for kind, _, t in self.equations if kind == "order"}
        third, fifth, bush, path = map(read_tree, ("[oo]", "[oooo]", "[oo[o]]", "[[o][o]]"))
        free = [versions(t) for t in given]
        if is_nil(total(self.D) - 1):
            given.add(LEAF)
        if self.starts_at_two() and self.quadrature(2):
            given.add(third)
        has_third = third in given or versions(third) in free
        if has_third and not self.xi and self.quadrature(2) and self.quadrature(4):
            given.add(fifth)
        if self.r == 1 and all(versions(t) in free for t in (third, fifth, path)):
            given.add(bush)
        return given

    def is_of_the_theorem(self, identity: bool, nystrom: bool | str, row: str | None) -> bool:
        """Tell whether the method is symmetric, and its order is on all trees."""
        return self.signs is not None

    def principal_is_zero(self, p: int, identity: bool, nystrom: bool | str) -> bool:
        """Tell whether the first value is 0 at all classes below p, where it is the solution."""
        return not identity or all(is_nil(x[0]) for x in self.series(self.root, p).eta.values())

    def gives_order(self, p: int, nystrom: bool | str, row: str | None, method: Method) -> bool:
        """Tell whether the equations give all conditions through order p."""
        given = self.given_trees()
        return all(conditions_follow(n, self.q, given, self.free) for n in range(1, p + 1, 2))

    def implies(self, claim: str) -> bool:
        """Tell whether a claim that is true or false holds at the root."""
        if claim == "consistent":
            return LEAF in self.given_trees()
        if claim in ("preconsistent", "g-symplectic", "conjugate-symplectic"):
            return True  # real, and 1 is a simple eigenvalue of V
        if claim == "symplectic":
            return self.r == 1
        return claim == "symmetric" and self.signs is not None

    def gives_stage_order(self, q: int) -> bool:
        """Tell whether every stage has order q."""
        return q <= self.q


class ByClasses(Solved):
    """The series of a sweep at values of its unknowns, by classes; zeta_1 by theorem 2 (6.2)."""

    def __init__(self, sweep: Sweep, values: list) -> None:
        super().__init__(sweep.at(values), False, False)
        self.sweep, self.q, self.G = sweep, sweep.q, as_reals(sweep.G)
        self.given = {t: at_value(x, values) for t, x in sweep.xi.items()}

    def pool(self, order: int) -> list[Tree]:
        """Return the classes of an order."""
        return classes(order, self.q)

    def cut_value(self, s: Tree) -> list:
        """Return eta(s), that of its class times the factor."""
        below, factor = reduced(s, self.q)
        return self.eta[below] if factor == 1 else [x * factor for x in self.eta[below]]

    def condition(self, t: Tree) -> list:
        """Return R_1(t), that of its class times the factor."""
        below, factor = reduced(t, self.q)
        return multiples(factor, super().condition(below))

    def settle(self) -> None:
        """Find the principal parts of the last order, 0 where it is odd."""
        if self.order % 2:
            return
        free = self.sweep.free.get(self.order, ())
        defining, _, back = plan(self.order, self.q, free)
        right = [dot(self.eta[t], apply(self.G, self.eta[u])) for t, u in defining]
        right += [self.given.get(t, Fraction(0)) for t in free]
        for t, row_ in zip(classes(self.order, self.q), back, strict=True):
            self.move(t, [dot(row_, right)])
