"""Runge-Kutta and Rosenbrock methods with an enclosure (section 6.8)."""

import re
from fractions import Fraction
from functools import cache

from .enclosures import Enclosed
from .krawczyk import Linear, at_values
from .linalg import apply, dot, placewise
from .numbers import is_nil, total
from .refusals import keys, require
from .trees import LEAF, attach, gamma, pool_of, read_tree, size, trees

RK_EQUATION = re.compile(r"order (\S+)|embedded (.+) (\S+)|column ([1-9][0-9]?)")


class RungeKutta(Enclosed):
    """A file of class rk or rosenbrock with an enclosure: trees, and D(1) at columns (6.8)."""

    def prepare(self):
        """Read what stands below a vertex, the rows of weights and the equations."""
        doc = self.document
        require(not {"c", "dense", "starting", "finishing"} & set(doc), "not covered: c or a start")
        require(not self.xi and not set(self.proof) & {"free", "trees"}, "xi, free or trees")
        if doc["class"] == "rk":
            self.palette, self.below = (("o", "o"),), {"o": self.matrix("A")}
        else:
            alpha, gamma_ = self.matrix("alpha"), self.matrix("gamma")
            require(len(alpha) == len(gamma_), "shapes")
            both = [[x + y for x, y in zip(*rows, strict=True)]
                    for rows in zip(alpha, gamma_, strict=True)]  # fmt: skip
            self.palette, self.below = (("1", "12"), ("2", "12")), {"1": alpha, "2": both}
        self.A = next(iter(self.below.values()))
        self.rows = {None: self.numbers.vector(doc["b"], doc)}
        for row in doc.get("embedded", []):
            keys(row, "name b", where="embedded")
            self.rows[row["name"]] = self.numbers.vector(row["b"], doc)
        self.s = len(self.A)
        shapes = [len(x) for x in (*self.A, *self.rows.values())]
        require(all(n == self.s for n in shapes), "shapes")
        self.equations = [self.read(text) for text in self.texts]
        self.columns = len(self.below) == 1 and all(
            ("column", j) in self.equations or self.vanishes(j) for j in range(self.s))  # fmt: skip

    def read(self, text):
        """Return an equation ("column", j) or (row, tree)."""
        found = isinstance(text, str) and RK_EQUATION.fullmatch(text)
        require(found, f"{str(text)[:40]!r} is no equation")
        first, row, second, column = found.groups()
        if column:
            one = len(self.below) == 1
            require(one and int(column) <= self.s, "an equation names another column")
            return "column", int(column) - 1
        require(row is None or row in self.rows, "an equation names another row")
        tree = read_tree(first or second)
        require(tree in trees(self.palette, size(tree)), "an equation names another tree")
        return row, self.plain(tree)

    def plain(self, t):
        """Return the tree with leaves of the first colour: what stands below one is not used."""
        if not t[1]:
            return self.palette[0][0], ()
        return t[0], tuple(sorted(map(self.plain, t[1])))

    def column(self, A, b, j):
        """Return sum b_i a_ij - b_j (1 - c_j)."""
        return total(x * row[j] for x, row in zip(b, A, strict=True)) - (1 - total(A[j])) * b[j]

    def vanishes(self, j):
        """Tell whether D(1) holds at a column for all values of the unknowns."""
        b, rows = self.rows[None], range(self.s)
        products = [(1 - total(self.A[j]), b[j]), *((b[i], self.A[i][j]) for i in rows)]
        if any(isinstance(x, Linear) and isinstance(y, Linear) for x, y in products):
            return False
        return is_nil(self.column(self.A, b, j))

    def residuals(self, values):
        """Return left minus right of every equation."""
        matrices = {c: at_values(M, values) for c, M in self.below.items()}
        rows = {name: at_values(b, values) for name, b in self.rows.items()}
        A = next(iter(matrices.values()))

        @cache
        def weights(t):
            return placewise(self.s, [apply(matrices[t[0]], weights(child)) for child in t[1]])

        return [self.column(A, rows[None], what) if row == "column"
                else dot(rows[row], weights(what)) - Fraction(1, gamma(what))
                for row, what in self.equations]  # fmt: skip

    def given(self, t, row):
        """Tell whether the condition of a tree follows from the equations (6.8)."""
        t = self.plain(t)
        if (row, t) in self.equations:
            return True
        if not t[1]:
            return is_nil(total(self.rows[row]) - 1)
        if row is not None or len(t[1]) != 1 or not self.columns:
            return False
        below = t[1][0][1]
        if not below:
            return self.given(LEAF, None)
        return self.given(("o", below), None) and self.given(attach(("o", below), LEAF), None)

    def order_holds(self, p, identity_mode, nystrom, row, method):
        """Refuse unless the equations give order p with the weights of a row."""
        require(not nystrom and identity_mode, "one value is carried")
        require(row in self.rows, "no row of embedded has the name")
        for n in range(1, p + 1):
            fine = all(self.given(t, row) for t in pool_of(method, n, nystrom))
            require(fine, f"the conditions of order {n}")

    def implies(self, claim):
        """Tell whether a claim that is true or false holds at the root."""
        if claim == "embedded-difference":
            return len(self.rows) > 1 and all(self.given(LEAF, row) for row in self.rows)
        if len(self.below) > 1:
            return False
        return claim == "preconsistent" or (claim == "consistent" and self.given(LEAF, None))

    def zero_growths(self):
        """No growth parameter is an equation."""

    def stage_order_holds(self, q, p):
        """Refuse all but q = 1, which c = A 1 is."""
        require(len(self.below) == 1 and q == 1 <= p, "the stages are not given")
