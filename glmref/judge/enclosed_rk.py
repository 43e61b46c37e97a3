"""Runge-Kutta and Rosenbrock methods with an enclosure (section 6.8).

Where D(1) holds at every column, b A x = b (1 - C) x for x the product of the A Phi(t_i): the
condition of [[t_1 .. t_k]] is that of [t_1 .. t_k] less that of [o t_1 .. t_k], as 1 / gamma obeys
the same relation (Butcher 2016, 321; Hairer, Norsett, Wanner 1993, II.1).

Let B(2s) hold and C(s) at every stage. The c_i differ, since no quadrature with fewer than s nodes
is exact on the square of the product of all x - c_i; that product is orthogonal to all polynomials
of degree below s, so that the c_i are the zeros of the shifted Legendre polynomial: it is the Gauss
method (Butcher 1964), symplectic (Sanz-Serna 1988), symmetric and A-stable (Ehle 1969). Where a
file is mirrored, c_i' = 1 - c_i by B(1), and with p(x) = (1 - x)^(k-1) sum_j (b_j - a_ij) p(c_j) is
the integral of p from c_i to 1: by B(k) and C(k) at i, C(k) holds at i'. At the middle stage it
says so of odd k, from what holds below k; B(k) of even k follows from those below, as
sum b_j (c_j - 1/2)^(k-1) = 0.
"""

from __future__ import annotations

import re
from functools import cache

from .arithmetic import Fraction, Number
from .document import Method, rows_of
from .enclosures import Enclosed
from .krawczyk import Linear, at_values
from .linalg import apply, dot, placewise
from .numbers import is_nil, total
from .refusals import keys, matched, require
from .trees import LEAF, Tree, gamma, is_coloured, pool_of, read_tree

RK_EQUATION = re.compile(r"order (\S+)|embedded (.+) (\S+)|column ([1-9][0-9]?)"
                         r"|stage ([1-9][0-9]?) ([1-9][0-9]?)")  # fmt: skip


def bush(n: int) -> Tree:
    """Return the tree of n vertices whose root has leaves only."""
    return "o", (LEAF,) * (n - 1)


class RungeKutta(Enclosed):
    """A file of class rk or rosenbrock with an enclosure: trees, D(1), C(k) at stages (6.8)."""

    def prepare(self) -> None:
        """Read what stands below a vertex, the rows of weights and the equations."""
        doc = self.document
        require(not {"c", "dense", "starting", "finishing"} & set(doc), "not covered: c or a start")
        if doc["class"] == "rk":
            self.palette, self.below = (("o", "o"),), {"o": self.matrix("A")}
        else:
            alpha, gamma_ = self.matrix("alpha"), self.matrix("gamma")
            require(len(alpha) == len(gamma_), "shapes")
            both = [[x + y for x, y in zip(*rows, strict=True)]
                    for rows in zip(alpha, gamma_, strict=True)]  # fmt: skip
            self.palette, self.below = (("1", "12"), ("2", "12")), {"1": alpha, "2": both}
        self.A = next(iter(self.below.values()))
        self.rows: dict[str | None, list] = {None: self.numbers.vector(doc["b"], doc)}
        for row in rows_of(doc):
            keys(row, "name b", where="embedded")
            require(row["name"] not in ("column", "stage"), "a row with the name of an equation")
            self.rows[str(row["name"])] = self.numbers.vector(row["b"], doc)
        self.s = len(self.A)
        shapes = [len(x) for x in (*self.A, *self.rows.values())]
        require(all(n == self.s for n in shapes), "shapes")
        self.equations = [self.read(text) for text in self.texts]
        self.columns = len(self.below) == 1 and all(
            ("column", (j,)) in self.equations or self.vanishes(j)
            for j in range(self.s))  # fmt: skip
        self.mirrored = self.is_mirrored()
        self.gauss = len(self.below) == 1 and self.is_gauss()

    def read(self, text: object) -> tuple:
        """Return an equation ("column", j), ("stage", (i, k)) or (row, tree)."""
        found = matched(RK_EQUATION, text, f"{str(text)[:40]!r} is no equation")
        first, row, second, column, *stage = found.groups()
        numbers = [int(x) for x in (column, *stage) if x]
        require(len(self.below) == 1 or not numbers, "an equation of another class")
        require(max(numbers, default=0) <= self.s, "an equation names another stage")
        if stage[0]:
            i, k = map(int, stage)
            return "stage", (i - 1, k)
        if column:
            return "column", (int(column) - 1,)
        require(row in self.rows, "an equation names another row")
        tree = read_tree(first or second)
        require(is_coloured(tree, self.palette), "an equation names another tree")
        return row, self.plain(tree)

    def plain(self, t: Tree) -> Tree:
        """Return the tree with leaves of the first colour: what stands below one is not used."""
        if not t[1]:
            return self.palette[0][0], ()
        return t[0], tuple(sorted(map(self.plain, t[1])))

    def column(self, A: list, b: list, j: int) -> Number:
        """Return sum b_i a_ij - b_j (1 - c_j)."""
        return total(x * row[j] for x, row in zip(b, A, strict=True)) - (1 - total(A[j])) * b[j]

    def vanishes(self, j: int) -> bool:
        """Tell whether D(1) holds at a column for all values of the unknowns."""
        b, rows = self.rows[None], range(self.s)
        products = [(1 - total(self.A[j]), b[j]), *((b[i], self.A[i][j]) for i in rows)]
        if any(isinstance(x, Linear) and isinstance(y, Linear) for x, y in products):
            return False
        return is_nil(self.column(self.A, b, j))

    def residuals(self, values: list) -> list:
        """Return left minus right of every equation."""
        matrices = {c: at_values(M, values) for c, M in self.below.items()}
        rows = {name: at_values(b, values) for name, b in self.rows.items()}
        A = next(iter(matrices.values()))

        @cache
        def weights(t: Tree) -> list:
            return placewise(self.s, [apply(matrices[t[0]], weights(child)) for child in t[1]])

        def residual(row: str | None, what: tuple) -> Number:
            if row == "column":
                return self.column(A, rows[None], what[0])
            if row == "stage":
                i, k = what
                c_to_k = weights(bush(k + 1))[i] * Fraction(1, k)
                return dot(A[i], weights(bush(k))) - c_to_k
            return dot(rows[row], weights(what)) - Fraction(1, gamma(what))

        return [residual(*equation) for equation in self.equations]

    def is_mirrored(self) -> bool:
        """Tell whether a_i'j' = b_j - a_ij and b_j' = b_j identically, i' = s + 1 - i."""
        b = self.rows[None]
        gaps = [x - y for x, y in zip(b, reversed(b), strict=True)]
        for row, other in zip(self.A, reversed(self.A), strict=True):
            gaps += [x + y - z for x, y, z in zip(row, reversed(other), b, strict=True)]
        return all(map(is_nil, gaps))

    def has_stage(self, i: int, k: int) -> bool:
        """Tell whether C(k) is given at a stage where it is so below k (6.8)."""
        mirror = self.s - 1 - i
        return k == 1 or ("stage", (i, k)) in self.equations or (self.mirrored and (
            ("stage", (mirror, k)) in self.equations or (i == mirror and k % 2 == 1)))  # fmt: skip

    def is_gauss(self) -> bool:
        """Tell whether B(2 s) and C(s) are given: it is the Gauss method then (6.8)."""
        quadrature = all(
            (self.mirrored and k % 2 == 0)
            or (None, bush(k)) in self.equations
            or (k == 1 and is_nil(total(self.rows[None]) - 1))
            for k in range(1, 2 * self.s + 1)
        )
        return quadrature and all(
            self.has_stage(i, k) for k in range(1, self.s + 1) for i in range(self.s)
        )

    def given(self, t: Tree, row: str | None) -> bool:
        """Tell whether the condition of a tree follows from the equations (6.8).

        By D(1) that of [[..]] follows from those of [..] and [o ..], which are no larger.
        """
        t = self.plain(t)
        if (row, t) in self.equations:
            return True
        if not t[1]:
            return is_nil(total(self.rows[row]) - 1)
        return row is None and len(t[1]) == 1 and self.columns

    def gives_order(self, p: int, nystrom: bool | str, row: str | None, method: Method) -> bool:
        """Tell whether the equations give all conditions through order p with the row."""
        if row is None and self.gauss:
            return p <= 2 * self.s
        level = (t for n in range(1, p + 1) for t in pool_of(method, n, nystrom))
        return all(self.given(t, row) for t in level)

    def implies(self, claim: str) -> bool:
        """Tell whether a claim that is true or false holds at the root."""
        if claim == "embedded-difference":
            return len(self.rows) > 1 and all(self.given(LEAF, row) for row in self.rows)
        if claim in ("symplectic", "g-symplectic", "conjugate-symplectic", "symmetric", "a-stable"):
            return self.gauss
        return claim == "preconsistent" or (claim == "consistent" and self.given(LEAF, None))

    def zero_growths(self) -> None:
        """Return None: no growth parameter is an equation."""

    def gives_stage_order(self, q: int) -> bool:
        """Tell whether q is 1, which c = A 1 is, or q <= s of the Gauss method."""
        return q <= (self.s if self.gauss else 1)
