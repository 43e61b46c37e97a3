"""Check certificates of format glmref-certificate-1 with Python's standard library only.

``python checker/glmref_check.py FILE...`` says ``yes`` or ``no`` and why for every certificate. The
sections below are those of docs/certificates.md; each function names the section it implements.
Exit code: 0 when all are accepted, 1 when one is refused, 2 when a file cannot be read.
"""

import argparse
import cmath
import json
import re
import signal
import sys
from collections import namedtuple
from copy import copy
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from math import factorial

SECONDS = 60  # wall clock for one certificate
MEGABYTES = 32  # size of a file
TREES = 40_000  # trees of one order
DIMENSION = 64  # of a tower over the rationals
SIZE = 200  # rows and columns of a matrix of the document
DIGITS = 4000  # characters of an entry
BITS = (64, 256, 1024, 4096)  # precisions of the interval arithmetic
FORMAT = "glmref-certificate-1"


class Refused(Exception):
    """The certificate proves nothing: the answer is no."""

    def __init__(self, why):
        super().__init__(why if len(why) <= 200 else f"{why[:200]}...")


class Unreadable(Exception):
    """The file is not JSON: the exit code is 2."""


def require(truth, why):
    """Refuse unless `truth`."""
    if not truth:
        raise Refused(why)


def not_covered(what):
    """Refuse what this checker does not decide."""
    raise Refused(f"not covered: {what}")


def beyond(_number=None, _frame=None):
    """Refuse what takes too long."""
    raise Refused("beyond the limits of this checker")


def keys(thing, needed, optional="", where="witness"):
    """Refuse an object whose keys are not the `needed` ones and some `optional` ones."""
    require(isinstance(thing, dict), f"the {where} is no object")
    needed, optional = set(needed.split()), set(optional.split())
    for key in needed - set(thing):
        raise Refused(f"the {where} has no key {key!r}")
    for key in set(thing) - needed - optional:
        raise Refused(f"the {where} has an unknown key {key!r}")


def whole(value, low=0, high=20):
    """Return an integer within bounds."""
    require(type(value) is int and low <= value <= high, f"{value!r} is no whole number in bounds")
    return value


# ---------------------------------------------------------------- linear algebra over any numbers


def multiples(factor, values):
    """Return factor x for every x; an exact zero stays one where the factor is an interval."""
    return [x if is_nil(x) else factor * x for x in values]


def total(values):
    """Return a sum that starts from an exact zero."""
    return sum(values, Fraction(0))


def is_nil(x):
    """Tell whether a number is the exact zero."""
    return type(x) is Fraction and not x


def dot(x, y):
    """Return sum x_i y_i; zeros cost nothing."""
    require(len(x) == len(y), "shapes do not fit")
    return total(a * b for a, b in zip(x, y, strict=True) if not (is_nil(a) or is_nil(b)))


def less(x, y):
    """Return x - y."""
    return [a - b for a, b in zip(x, y, strict=True)]


def placewise(n, vectors):
    """Return the product of vectors place by place, n ones if there are none; zeros stay exact."""
    found = None
    for x in vectors:
        found = x if found is None else [
            Fraction(0) if is_nil(a) or is_nil(b) else a * b
            for a, b in zip(found, x, strict=True)]  # fmt: skip
    return ones(n) if found is None else found


def transpose(M):
    """Return the transpose."""
    return [list(column) for column in zip(*M, strict=True)]


def star(M):
    """Return the conjugate transpose."""
    return [[conj(x) for x in column] for column in transpose(M)]


def apply(M, x):
    """Return M x."""
    return [dot(row, x) for row in M]


def times(first, *others):
    """Return a product of matrices."""
    for M in others:
        require(len(first[0]) == len(M), "shapes do not fit")
        columns = transpose(M)
        first = [[dot(row, column) for column in columns] for row in first]
    return first


def combine(M, N, factor=1):
    """Return M + factor N."""
    require(len(M) == len(N) and len(M[0]) == len(N[0]), "shapes do not fit")
    return [[a + factor * b for a, b in zip(p, q, strict=True)] for p, q in zip(M, N, strict=True)]


def minus(M, N):
    """Return M - N."""
    return combine(M, N, -1)


def scale(factor, M):
    """Return factor M."""
    return [multiples(factor, row) for row in M]


def diagonal(values):
    """Return the diagonal matrix of `values`."""
    return [
        [x if i == j else Fraction(0) for j in range(len(values))] for i, x in enumerate(values)
    ]


def identity(n):
    """Return the unit matrix."""
    return diagonal([Fraction(1)] * n)


def ones(n):
    """Return a vector of ones."""
    return [Fraction(1)] * n


def vanishes(thing):
    """Tell whether a number, vector or matrix reduces to 0."""
    return all(vanishes(x) for x in thing) if isinstance(thing, list) else not thing


def equal(x, y, why):
    """Refuse two vectors or matrices that differ."""
    same = len(x) == len(y) and (not isinstance(x[0], list) or len(x[0]) == len(y[0]))
    require(same, f"{why}: shapes do not fit")
    difference = (
        minus(x, y) if isinstance(x[0], list) else [a - b for a, b in zip(x, y, strict=True)]
    )
    require(vanishes(difference), f"{why} does not hold")


def live(x):
    """Tell whether a number is not the exact zero; an interval counts."""
    return type(x) is Interval or bool(x)


def smallest(x):
    """Return a bound below |x|, infinity for a number that is exact."""
    return min(abs(x.lo), abs(x.hi)) if type(x) is Interval else float("inf")


def echelon(M):
    """Return the reduced rows and the pivot columns of M; pivots are not 0 in any interval."""
    rows, pivots = [list(row) for row in M], []
    for column in range(len(rows[0]) if rows else 0):
        top = len(pivots)
        below = [i for i in range(top, len(rows)) if live(rows[i][column])]
        good = [i for i in below if not may_vanish(rows[i][column])]
        require(good or not below, "an interval holds 0: nothing is decided")
        if not good:
            continue
        found = max(good, key=lambda i, k=column: smallest(rows[i][k]))
        rows[top], rows[found] = rows[found], rows[top]
        factor = inverse(rows[top][column])
        rows[top] = [factor * x if live(x) else x for x in rows[top]]
        for i, row in enumerate(rows):
            if i != top and live(row[column]):
                head = row[column]
                rows[i] = [
                    x - head * y if live(y) else x for x, y in zip(row, rows[top], strict=True)
                ]
        pivots.append(column)
    return rows[: len(pivots)], pivots


def rank(M):
    """Return the rank of M."""
    return len(echelon(M)[1])


def solve(M, y):
    """Return (x, unique) with M x = y, or (None, False) where the equations contradict."""
    n = len(M[0])
    rows, pivots = echelon([[*row, b] for row, b in zip(M, y, strict=True)])
    if n in pivots:
        return None, False
    x = [Fraction(0)] * n
    for row, column in zip(rows, pivots, strict=True):
        x[column] = row[n]
    return x, len(pivots) == n


def kernel(M):
    """Return a basis of the vectors x with M x = 0."""
    rows, pivots = echelon(M)
    basis = []
    for free in set(range(len(M[0]))) - set(pivots):
        x = [Fraction(int(j == free)) for j in range(len(M[0]))]
        for row, column in zip(rows, pivots, strict=True):
            x[column] = -row[free]
        basis.append(x)
    return basis


def inverse_matrix(M):
    """Return the inverse of M."""
    n = len(M)
    rows, pivots = echelon([[*row, *unit] for row, unit in zip(M, identity(n), strict=True)])
    require(pivots == list(range(n)), "a matrix that must be inverted is singular")
    return [row[n:] for row in rows]


# ------------------------------------------------------- section 1: from the document to matrices

COMMON = "$schema format name title class field broken notes digits constants claims source"
CLASSES = {  # needed keys, optional keys
    "glm": ("A U B V", "G D output starting finishing embedded"),
    "rk": ("A b", "starting finishing c embedded dense unknowns enclosure"),
    "composition": ("base gamma", "starting finishing"),
    "lmm": ("alpha beta", "starting finishing"),
    "one-leg": ("alpha beta", "G starting finishing"),
    "additive": ("parts", "embedded"),
    "nystrom": ("A b b_prime c", "A_prime embedded"),
    "rosenbrock": ("alpha gamma b", "embedded unknowns enclosure"),
    "sweep": ("D X V G", "unknowns enclosure starting finishing"),
    "splitting": ("first a b", "unknowns enclosure starting"),
    "partitioned-rk": ("A b A_hat b_hat", "starting separable"),
    "partitioned": ("q p", "G D_P D_Q separable starting"),
    "pair-sweep": ("stages b w c v V V_hat G", "unknowns enclosure starting"),
}


class Component(namedtuple("Component", "A U B V")):
    """Matrices A (stages, slopes), U, B, V."""

    __slots__ = ()

    @property
    def r(self):
        """Number of values."""
        return len(self.V)


class Method:
    """Components with their colours, the palette, and what else the file gives."""

    def __init__(self, document, numbers, base=None):
        self.document, self.numbers = document, numbers
        kind = document.get("class")
        require(isinstance(kind, str) and kind in CLASSES, f"no class is called {kind!r}")
        needed, optional = CLASSES[kind]
        keys(document, needed + " class", COMMON + " " + optional, where="document")
        formats = ("glmref-method-1", "glmref-method-2")
        require(document.get("format", formats[0]) in formats, "another format")
        require((base is not None) == (kind == "composition"), "a base belongs to compositions")
        self.kind, self.base = kind, base
        made = getattr(self, "make_" + kind.replace("-", "_"))()
        self.pair, self.additive = type(made) is tuple, kind in ("additive", "rosenbrock")
        self.system = "rosenbrock" if kind == "rosenbrock" else ""
        self.parts = {"f": made[0], "k": made[1]} if self.pair else {"o": made}
        if self.additive:
            self.parts = made
        blocks = {"glm": {"o": document}}
        if kind == "partitioned":
            blocks = {kind: {"f": document["q"], "k": document["p"]}}
        self.declared = {
            c: self.list("output", block)
            for c, block in blocks.get(kind, {}).items()
            if "output" in block
        }
        fixed = {"splitting": True, "pair-sweep": True, "partitioned-rk": False,
                 "nystrom": "A_prime" not in document}  # fmt: skip
        self.separable = self.pair and document.get("separable", fixed.get(kind, False)) is True
        children = {"f": "k", "k": "f"} if self.separable else {}
        self.palette = tuple((c, children.get(c, "".join(self.parts))) for c in self.parts)

    def single(self):
        """Return the component of a method that is no pair."""
        require("o" in self.parts, "the rule is for single methods")
        return self.parts["o"]

    def part(self, colour):
        """Return the component of a colour."""
        require(isinstance(colour, str) and colour in self.parts, f"no component {colour!r}")
        return self.parts[colour]

    def list(self, key, source=None):
        """Return a vector of the document."""
        return self.numbers.vector((source or self.document).get(key), self.document)

    def matrix(self, key, source=None):
        """Return a matrix of the document."""
        return self.numbers.matrix((source or self.document).get(key), self.document)

    def form(self, key="G"):
        """Return a matrix that may be written as its diagonal."""
        return self.numbers.form(self.document[key], self.document)

    @staticmethod
    def runge_kutta(A, b):
        """Return the component of a Runge-Kutta method."""
        return Component(A, [[Fraction(1)] for _ in A], [b], [[Fraction(1)]])

    def make_glm(self, source=None):
        """Return the matrices as they stand."""
        return Component(*(self.matrix(key, source) for key in "AUBV"))

    def make_rk(self):
        """Return A, U = 1, B = b, V = 1."""
        return self.runge_kutta(self.matrix("A"), self.list("b"))

    def make_composition(self):
        """Return the base with steps gamma_1 h, gamma_2 h, .."""
        require(isinstance(self.base, dict) and self.base.get("class") == "rk", "a base must be rk")
        require(self.base.get("name") == self.document.get("base"), "the base has another name")
        base, gamma = Method(self.base, self.numbers).single(), self.list("gamma")
        (b,), zero, A, left = base.B, [Fraction(0)], [], []
        for k, g in enumerate(gamma, 1):
            right = zero * (len(b) * (len(gamma) - k))
            A += [left + multiples(g, row) + right for row in base.A]
            left = left + multiples(g, b)
        return self.runge_kutta(A, left)

    def multistep(self):
        """Return alpha and beta of equal lengths."""
        alpha, beta = self.list("alpha"), self.list("beta")
        require(len(alpha) == len(beta) >= 2, "alpha and beta have other lengths")
        require(nonzero(alpha[-1]), "alpha_k is 0")
        return alpha, beta

    def make_lmm(self):
        """Return the form with one stage and the values y and f that are needed."""
        alpha, beta = self.multistep()
        k, unit = len(alpha) - 1, inverse(alpha[-1])
        a, b = multiples(unit, alpha), multiples(unit, beta)
        implicit = bool(b[k])
        low = next((m for m in range(k) if a[m]), k - 1)
        ys = list(range(k - 1, low - 1, -1))
        first = next((m for m in range(k + 1) if b[m]), k)
        fs = list(range(k - 1 if implicit else k - 2, first - 1, -1))
        r, e = len(ys) + len(fs), identity(len(ys) + len(fs))
        new = [-a[m] for m in ys] + [b[m] for m in fs]
        V = [new, *e[: len(ys) - 1]]
        B = [b[k] if implicit else b[k - 1]] + [Fraction(0)] * (len(ys) - 1)
        if fs:
            V += [[Fraction(0)] * r, *e[len(ys) : r - 1]]
            B += [Fraction(1)] + [Fraction(0)] * (len(fs) - 1)
        return Component([[b[k]]], [new if implicit else e[0]], [[x] for x in B], V)

    def make_one_leg(self):
        """Return the one-leg form."""
        alpha, beta = self.multistep()
        unit, k = inverse(alpha[-1]), len(alpha) - 1
        a, back = multiples(unit, alpha), range(k - 1, -1, -1)
        V = [[-a[m] for m in back], *identity(k)[: k - 1]]
        U = [beta[m] - x for m, x in zip(back, multiples(beta[k], a[-2::-1]), strict=True)]
        B = [[unit]] + [[Fraction(0)] for _ in range(k - 1)]
        return Component([[unit * beta[k]]], [U], B, V)

    def make_sweep(self):
        """Return B = X D, U = X^* G V, A from S = X^* G X."""
        X, d, V = self.matrix("X"), self.list("D"), self.matrix("V")
        left = times(star(X), self.form())
        S, none = times(left, X), self.numbers.explicit
        texts = self.document.get("enclosure", {}).get("equations", [])
        if none is None and any(str(text).startswith("explicit") for text in texts):
            not_covered("stages of a sweep that an equation makes explicit")
        for i, row in enumerate(S):
            own = Fraction(0) if i in (none or ()) else d[i] * row[i] * Fraction(1, 2)
            row[i:] = [own] + [Fraction(0)] * (len(d) - i - 1)
            row[:i] = [x * y for x, y in zip(d, row[:i], strict=False)]
        return Component(S, times(left, V), times(X, diagonal(d)), V)

    def make_partitioned(self):
        """Return two methods as they stand."""
        for key in ("q", "p"):
            keys(self.document[key], "A U B V", "output", where=f"component {key}")
        return self.make_glm(self.document["q"]), self.make_glm(self.document["p"])

    def make_partitioned_rk(self):
        """Return two Runge-Kutta methods."""
        return self.make_rk(), self.runge_kutta(self.matrix("A_hat"), self.list("b_hat"))

    def make_additive(self):
        """Return a Runge-Kutta method for each right-hand side; the colours are digits."""
        parts = self.document["parts"]
        require(isinstance(parts, list) and 2 <= len(parts) <= 9, "there are 2 to 9 parts")
        for part in parts:
            keys(part, "A b", where="part")
        return {str(n): self.runge_kutta(self.matrix("A", part), self.list("b", part))
                for n, part in enumerate(parts, 1)}  # fmt: skip

    def make_rosenbrock(self):
        """Return f - J with alpha and J with alpha + gamma below it, on two sets of stages."""
        alpha, gamma, b = self.matrix("alpha"), self.matrix("gamma"), self.list("b")
        require(len(alpha) == len(gamma), "alpha and gamma have other shapes")
        rows, none = alpha + combine(alpha, gamma), [Fraction(0)] * len(b)
        return {"1": self.runge_kutta([x + none for x in rows], b + none),
                "2": self.runge_kutta([none + x for x in rows], none + b)}  # fmt: skip

    def make_nystrom(self):
        """Return the pair q' = p, p' = k: the stages p and p + h k_l, from which Q is combined."""
        zero, see, c, A = Fraction(0), "A_prime" in self.document, self.list("c"), self.matrix("A")
        s = len(c)
        require(len(A) == s and all(len(x) == s for x in A), "A has another shape")
        below_q = [[x - total(row), *row] for x, row in zip(c, A, strict=True)]
        below_p = [[zero] * s, *identity(s)]
        if see:
            below_q = [[zero] * (2 * s + 1)] * (s + 1) + [row + [zero] * s for row in below_q]
            below_p = [[zero] * (s + 1) + row for row in below_p + self.matrix("A_prime")]
        pairs = zip((below_q, below_p), self.weights(self.document), strict=True)
        return tuple(self.runge_kutta(*pair) for pair in pairs)

    def weights(self, source):
        """Return the weights of a row of the file, for each component."""
        if self.kind == "additive":
            return self.matrix("b", source)
        b = self.list("b", source)
        none = [Fraction(0)] * len(b)
        if self.kind == "rosenbrock":
            return [b + none, none + b]
        if self.kind == "nystrom":
            more = none if "A_prime" in self.document else []
            first = [1 - total(b), *b, *more]
            return [first, more + [Fraction(0)] * bool(more) + self.list("b_prime", source)]
        return [b]

    def rows(self):
        """Return {name: (weights of the solution, of the estimate) by colour} of `embedded`."""
        given = self.document.get("embedded", [])
        require(isinstance(given, list) and len(given) <= 20, "embedded is a list")
        own = {"rk": "b", "additive": "b", "nystrom": "b b_prime", "rosenbrock": "b", "glm": "b v"}
        require(not given or self.kind in own, "no rows are embedded here")
        found = {}
        for row in given:
            error = self.kind == "rk" and "error" in as_object(row)
            keys(row, "name " + ("error" if error else own[self.kind]), where="embedded")
            require(row["name"] not in ("b", *found), "a name stands twice in embedded")
            weights = self.weights({"b": row["error"]} if error else row)
            if self.kind == "glm":
                found[row["name"]] = {"o": (weights[0], self.list("v", row))}, {}
                continue
            require(len(weights) == len(self.parts), "embedded has another number of rows")
            weights = dict(zip(self.parts, weights, strict=True))
            fine = all(len(self.part(c).B[0]) == len(w) for c, w in weights.items())
            require(fine, "embedded has another length")
            other = {c: less(self.part(c).B[0], w) for c, w in weights.items()}
            found[row["name"]] = (other, weights) if error else (weights, other)
        return found

    def with_parts(self, parts, system="", separable=None):
        """Return this method with other components."""
        other = object.__new__(Method)
        other.__dict__.update(self.__dict__, parts=parts, system=system)
        other.pair = set(parts) == {"f", "k"}
        other.additive = set(parts) == {"1", "2"} or (self.additive and len(parts) > 1)
        if other.pair and not self.pair:
            other.separable, other.palette = False, (("f", "fk"), ("k", "fk"))
        if set(parts) == {"o"}:
            other.palette = (("o", "o"),)
        return other

    def for_claim(self, claim):
        """Return the method that a claim is about."""
        if self.kind == "rosenbrock" and claim in ("a-stable", "l-stable"):
            beta = combine(self.matrix("alpha"), self.matrix("gamma"))
            return self.with_parts({"o": self.runge_kutta(beta, self.list("b"))})
        if self.kind == "rosenbrock":
            return self.with_parts(self.parts, "w" if claim == "w-order" else "rosenbrock")
        if self.kind != "rk" or "c" not in self.document or claim not in (*ORDERS, *SECOND):
            return self
        m, c = self.single(), self.list("c")
        require(len(c) == len(m.A), "c has another length")
        if all(type(x) is not Interval and not x for x in gaps_of_rows(self)):
            return self  # what is not decided is a c of its own, which A 1 is too
        require(claim in (*ORDERS, "stage-order"), "a claim with c apart")
        rest = [Fraction(0)] * (len(c) - 1)
        time = self.runge_kutta([[x, *rest] for x in c], [Fraction(1), *rest])
        return self.with_parts({"f": m, "k": time}, "time")

    def with_row(self, weights):
        """Return the method with other weights by colour; of class glm with weights of the values.

        There the values after a step are moved along u, so that their output is the row.
        """
        if self.kind != "glm":
            parts = {c: self.runge_kutta(m.A, weights[c]) for c, m in self.parts.items()}
            return self.with_parts(parts, self.system)
        m, (b, v), u = self.single(), weights["o"], self.u("o")
        w = reading(self, "o", u)
        require(len(b) == len(m.A) and len(v) == m.r, "embedded has another length")

        def moved(M, own):
            gap = less(own, apply(transpose(M), w))
            return [[x + k * y for x, y in zip(r, gap, strict=True)]
                    for k, r in zip(u, M, strict=True)]  # fmt: skip

        return self.with_parts(
            {"o": Component(m.A, m.U, moved(m.B, b), moved(m.V, v))}, self.system
        )

    def make_splitting(self):
        """Return the pair of a splitting: P stages from a, Q stages from b."""
        first, a, b, zero = self.document["first"], self.list("a"), self.list("b"), Fraction(0)
        require(first in ("q", "p"), "first is q or p")
        early = int(first == "q")
        A = [[x if i < j + early else zero for i, x in enumerate(a)] for j in range(len(b))]
        A_hat = [[x if j + early <= i else zero for j, x in enumerate(b)] for i in range(len(a))]
        return self.runge_kutta(A, a), self.runge_kutta(A_hat, b)

    def make_pair_sweep(self):
        """Return the pair of a sweep through the letters of `stages`."""
        letters = self.document["stages"]
        require(isinstance(letters, str) and set(letters) <= set("PQ"), "stages are letters P, Q")
        P, Q = ([n for n, x in enumerate(letters) if x == y] for y in "PQ")
        G, b, c, zero = self.form(), self.list("b"), self.list("c"), Fraction(0)
        X = [ones(len(P)), *(self.matrix("w") if self.document["w"] else [])]
        Y = [ones(len(Q)), *(self.matrix("v") if self.document["v"] else [])]
        V, V_hat, S = self.matrix("V"), self.matrix("V_hat"), times(transpose(X), G, Y)
        below = [[P[i] < Q[j] for j in range(len(Q))] for i in range(len(P))]
        A = [[x * S[i][j] if below[i][j] else zero for i, x in enumerate(b)] for j in range(len(Q))]
        A_hat = [[zero if below[i][j] else x * S[i][j] for j, x in enumerate(c)]
                 for i in range(len(P))]  # fmt: skip
        U, U_hat = times(transpose(Y), transpose(G), V), times(transpose(X), G, V_hat)
        return (Component(A, U, times(X, diagonal(b)), V),
                Component(A_hat, U_hat, times(Y, diagonal(c)), V_hat))  # fmt: skip

    def check_shapes(self):
        """Refuse matrices that do not fit each other, and stages of a pair that do not meet."""
        stages = {len(m.A) for m in self.parts.values()}
        require(not self.additive or len(stages) == 1, "the parts have other stages")
        for c, m in self.parts.items():
            slopes, r = len(m.B[0]), m.r
            partner = self.parts["k" if c == "f" else "f"] if self.pair else m
            fits = len(m.A) == len(m.U) == len(partner.B[0]) and len(m.A[0]) == slopes
            fits = fits and len(m.U[0]) == len(m.V[0]) == len(m.B) == r
            fits = fits and (self.separable or len(m.A) == slopes)
            require(fits, f"shapes of component {c} do not fit")

    def vectors_to_one(self, colour):
        """Return the list of u with V u = u and U u = 1, one or none; there may be no more."""
        m = self.part(colour)
        rows = minus(m.V, identity(m.r)) + m.U
        u, unique = solve(rows, [Fraction(0)] * m.r + ones(len(m.U)))
        require(u is None or unique, "u is not determined by V u = u, U u = 1")
        return [] if u is None else [u]

    def u(self, colour):
        """Return the u with V u = u and U u = 1, which must be the only one."""
        found = self.vectors_to_one(colour)
        require(found, "there is no u with V u = u, U u = 1")
        return found[0]


# ---------------------------------------------------------------------------- section 2: numbers


class Ring:
    """What follows from sums and products."""

    __slots__ = ()

    def __neg__(self):
        return self * -1

    def __sub__(self, other):
        return self + -other

    def __rsub__(self, other):
        return -self + other

    def __pow__(self, n):
        return self if n == 1 else self * self ** (n - 1) if n else Fraction(1)


class Element(Ring):
    """A polynomial in the generators of a tower, reduced; never a rational number."""

    __slots__ = ("terms", "tower")

    def __init__(self, tower, terms):
        self.tower, self.terms = tower, terms

    def __add__(self, other):
        if not isinstance(other, Element | Fraction | int):
            return NotImplemented
        terms = dict(self.terms)
        for k, x in other.terms.items() if isinstance(other, Element) else ((0, other),):
            terms[k] = terms.get(k, 0) + x
        return self.tower.element(terms)

    def __mul__(self, other):
        if not isinstance(other, Element | Fraction | int):
            return NotImplemented
        if not isinstance(other, Element):
            return self.tower.element({k: x * other for k, x in self.terms.items()})
        terms = {}
        for (i, x), (j, y) in product(self.terms.items(), other.terms.items()):
            for k, z in self.tower.table(i, j):
                terms[k] = terms.get(k, 0) + x * y * z
        return self.tower.element(terms)

    __radd__, __rmul__ = __add__, __mul__

    def conj(self):
        """Return the conjugate: each generator replaced by its own."""
        if all(self.tower.real):
            return self
        value = Fraction(0)
        for k, c in self.terms.items():
            for g, power in enumerate(self.tower.basis[k]):
                if power:
                    c = c * self.tower.conjugate(g) ** power
            value = value + c
        return value

    def __eq__(self, other):
        return vanishes(self - other)

    def __hash__(self):
        return hash(frozenset(self.terms.items()))


class Box(Ring):
    """A closed rectangle with ends that are whole multiples of 2^-bits, rounded outward."""

    __slots__ = ("bits", "im", "re")

    def __init__(self, re, im, bits):
        self.re, self.im, self.bits = re, im, bits

    @classmethod
    def of(cls, re, im, bits):
        """Return the rectangle around two intervals of rationals."""
        return cls(*((int((lo * 2**bits).__floor__()), int((hi * 2**bits).__ceil__()))
                     for lo, hi in (re, im)), bits)  # fmt: skip

    @classmethod
    def within(cls, re, im, bits):
        """Return the largest rectangle inside two intervals of rationals."""
        return cls(*(((lo * 2**bits).__ceil__(), (hi * 2**bits).__floor__())
                     for lo, hi in (re, im)), bits)  # fmt: skip

    def __add__(self, other):
        (a, b), (c, d), (e, f), (g, h) = self.re, self.im, other.re, other.im
        return Box((a + e, b + f), (c + g, d + h), self.bits)

    def __neg__(self):
        return Box((-self.re[1], -self.re[0]), (-self.im[1], -self.im[0]), self.bits)

    def __mul__(self, other):
        def by(x, y):
            ends = [a * b for a in x for b in y]
            return min(ends), max(ends)

        (a, b), (c, d) = by(self.re, other.re), by(self.im, other.im)
        (e, f), (g, h) = by(self.re, other.im), by(self.im, other.re)
        n = self.bits
        return Box(((a - d) >> n, -((c - b) >> n)), ((e + g) >> n, -((-f - h) >> n)), n)

    def excludes_zero(self):
        """Tell whether 0 lies outside."""
        return any(lo > 0 or hi < 0 for lo, hi in (self.re, self.im))

    def inside(self, other, strict=True):
        """Tell whether the rectangle lies in (the interior of) another."""
        return all((c < a and b < d) if strict else (c <= a and b <= d)
                   for (a, b), (c, d) in ((self.re, other.re), (self.im, other.im)))  # fmt: skip

    def meet(self, other):
        """Return the intersection."""
        return Box(*((max(a, c), min(b, d))
                     for (a, b), (c, d) in ((self.re, other.re), (self.im, other.im))),
                   self.bits)  # fmt: skip

    def at(self, bits):
        """Return the rectangle at a precision that is not lower."""
        more = bits - self.bits
        return Box(*(tuple(x << more for x in ends) for ends in (self.re, self.im)), bits)

    def middle(self):
        """Return the midpoint, a rectangle without width."""
        return Box(*((sum(x) // 2,) * 2 for x in (self.re, self.im)), self.bits)


def horner(coefficients, x):
    """Return the value of a polynomial, constant first."""
    value = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        value = value * x + c
    return value


def derivative(p):
    """Return p' of a list of coefficients, constant first."""
    return [k * c for k, c in enumerate(p)][1:] or [Fraction(0)]


class Tower:
    """The rationals with generators; arithmetic by reduction, enclosures by bisection (2)."""

    def __init__(self, generators=()):
        self.names, self.degrees, self.polynomials, self.start = [], [], [], []
        self.real, self.conjugates, self.boxes, self.inverses = [], [], {}, {}
        self.tables, self.basis, self.index = {}, [()], {(): 0}
        require(isinstance(generators, list | tuple), "generators are a list")
        for k, entry in enumerate(generators):
            keys(entry, "name polynomial real imag", "conjugate", "generator")
            require(entry["name"] == f"g{k + 1}", "generators are called g1, g2, ..")
            self.adjoin(entry)
        for entry, name in zip(generators, self.names, strict=True):
            self.check_conjugate(entry, name)

    def adjoin(self, entry):
        """Add a generator: its polynomial, and a box that is shown to hold one root."""
        polynomial = entry["polynomial"]
        require(isinstance(polynomial, list) and polynomial, "a polynomial is a list")
        degree = len(polynomial)
        require(2 <= degree and degree * len(self.basis) <= DIMENSION, "degrees of the tower")
        self.polynomials.append([self.parse(text) for text in polynomial])
        ends = [[rational(x) for x in entry[key]] for key in ("real", "imag")]
        require(all(len(x) == 2 and x[0] <= x[1] for x in ends), "a box has ends that are ordered")
        self.names.append(entry["name"])
        self.degrees.append(degree)
        old = self.basis
        self.basis = [(*e, k) for k in range(degree) for e in old]  # old indices keep their place
        self.index = {e: k for k, e in enumerate(self.basis)}
        self.tables, self.inverses = {}, {}
        self.start.append(ends)
        self.boxes.clear()
        self.real.append(ends[1] == [0, 0])
        self.enclosure(len(self.names) - 1, BITS[0])

    def element(self, terms):
        """Return a reduced element, as a rational where it is one."""
        terms = {k: x for k, x in terms.items() if x}
        if set(terms) <= {0}:
            return Fraction(terms.get(0, 0))
        return Element(self, terms)

    def generator(self, k):
        """Return g_(k+1)."""
        return self.element({self.index[tuple(int(j == k) for j in range(len(self.names)))]: 1})

    def table(self, i, j):
        """Return the product of two monomials of the basis, reduced."""
        if (i, j) not in self.tables:
            powers = tuple(a + b for a, b in zip(self.basis[i], self.basis[j], strict=True))
            self.tables[i, j] = list(self.reduce(powers).items())
        return self.tables[i, j]

    def reduce(self, powers):
        """Return a monomial by the monic polynomials."""
        high = next((k for k in reversed(range(len(powers))) if powers[k] >= self.degrees[k]), None)
        if high is None:
            return {self.index[powers]: Fraction(1)}
        terms, degree = {}, self.degrees[high]
        for k, c in enumerate(self.polynomials[high]):
            for at, x in c.terms.items() if isinstance(c, Element) else ((0, c),):
                inner = self.basis[at] + (0,) * (len(powers) - len(self.basis[at]))
                moved = [a + b for a, b in zip(powers, inner, strict=True)]
                moved[high] += k - degree
                for index, y in self.reduce(tuple(moved)).items() if x else ():
                    terms[index] = terms.get(index, 0) - x * y
        return terms

    def inverse(self, x):
        """Return y with x y = 1 in the ring."""
        if x not in self.inverses:
            n = len(self.basis)
            columns = []
            for k in range(n):
                y = x * self.element({k: Fraction(1)})
                terms = y.terms if isinstance(y, Element) else {0: y}
                columns.append([terms.get(i, Fraction(0)) for i in range(n)])
            y, _ = solve(transpose(columns), [Fraction(int(i == 0)) for i in range(n)])
            require(y is not None, "a divisor has no inverse in the ring of the tower")
            self.inverses[x] = self.element(dict(enumerate(y)))
        return self.inverses[x]

    def parse(self, text, radical=None):
        """Return a number of the certificate: rationals, names of generators, and radicals."""
        names = {name: self.generator(k) for k, name in enumerate(self.names)}
        return Parser(text, names.get, radical).value

    def conjugate(self, k):
        """Return the conjugate of a generator."""
        require(self.conjugates[k] is not None, f"the conjugate of g{k + 1} is not given")
        return self.conjugates[k]

    def check_conjugate(self, entry, name):
        """Show that `conjugate` is the root of the conjugate polynomial in the mirrored box."""
        k = self.names.index(name)
        if "conjugate" not in entry:
            self.conjugates.append(self.generator(k) if self.real[k] else None)
            return
        value = self.parse(entry["conjugate"])
        mirrored = [conj(c) for c in self.polynomials[k]] + [Fraction(1)]
        require(vanishes(horner(mirrored, value)), f"the conjugate of {name} is no conjugate root")
        (a, b), (c, d) = self.start[k]
        box = enclose(value, BITS[1])
        mirror = Box.within((a, b), (-d, -c), BITS[1])
        require(box.inside(mirror, strict=False), f"the conjugate of {name} is another root")
        self.conjugates.append(value)

    def enclosure(self, k, bits):
        """Return a box around a generator, which is the only root in its first box."""
        if (k, bits) not in self.boxes:
            p = [enclose(c, bits) for c in self.polynomials[k]] + [enclose(1, bits)]
            re, im = self.start[k]
            if [0, 0] not in (re, im):
                found = in_plane(p, Box.of(re, im, bits), Box.within(re, im, bits))
            else:  # on an axis, which is turned to the real one
                re, turn = (re, (1, 0)) if im == [0, 0] else (im, (0, 1))
                turn, power, q = Box.of(*((x, x) for x in turn), bits), enclose(1, bits), []
                for c in p:
                    q.append(c * power)
                    power = power * turn
                require(all(c.im == (0, 0) for c in q), "a polynomial is not real on its axis")
                # the only root in a box that is its own mirror image is real
                found = in_plane(q, Box.of(re, (0, 0), bits), Box.within(re, (-1, 1), bits))
                found = Box(found.re, (0, 0), bits) * turn
            self.boxes[k, bits] = found
        return self.boxes[k, bits]


def in_plane(p, box, inner):
    """Return the one root of p in a box: subdivision, then the test of Krawczyk on the hull."""
    slopes = [Box(tuple(n * x for x in c.re), tuple(n * x for x in c.im), c.bits)
              for n, c in enumerate(p)][1:]  # fmt: skip
    parts = [box]
    for _ in range(40):
        parts = [q for part in parts for q in quarters(part) if not horner(p, q).excludes_zero()]
        require(0 < len(parts) <= 256, "a box is not shown to hold one root")
        ends = [(min(getattr(q, key)[0] for q in parts), max(getattr(q, key)[1] for q in parts))
                for key in ("re", "im")]  # fmt: skip
        more = max(hi - lo for lo, hi in ends) // 8 + 2
        hull = Box(*((lo - more, hi + more) for lo, hi in ends), box.bits)
        image = krawczyk(p, slopes, hull)
        if image is not None and image.inside(hull):
            for _ in range(20):
                better = krawczyk(p, slopes, image)
                image = image.meet(better) if better is not None else image
            require(image.inside(inner, strict=False), "the root is not in its box")
            return image
    raise Refused("a box is not shown to hold one root")


def quarters(box):
    """Return four rectangles that cover one, two where it has no width."""
    halves = [{(lo, (lo + hi) // 2), ((lo + hi) // 2, hi)} for lo, hi in (box.re, box.im)]
    return [Box(x, y, box.bits) for x, y in product(*halves)]


def krawczyk(p, slopes, box):
    """Return m - Y p(m) + (1 - Y p'(X)) (X - m), Y about 1 / p'(m)."""
    m, n = box.middle(), box.bits
    at = horner(slopes, m).middle()
    a, b = at.re[0], at.im[0]
    if not a * a + b * b:
        return None
    Y = Box(*(((x << 2 * n) // (a * a + b * b),) * 2 for x in (a, -b)), n)
    one = Box.of((1, 1), (0, 0), n)
    return m - Y * horner(p, m) + (one - Y * horner(slopes, box)) * (box - m)


def enclose(x, bits):
    """Return a box around a number."""
    if not isinstance(x, Element):
        return Box.of((Fraction(x),) * 2, (0, 0), bits)
    value = Box((0, 0), (0, 0), bits)
    for k, c in x.terms.items():
        term = enclose(c, bits)
        for g, power in enumerate(x.tower.basis[k]):
            for _ in range(power):
                term = term * x.tower.enclosure(g, bits)
        value = value + term
    return value


def conj(x):
    """Return the conjugate of a number."""
    return x.conj() if isinstance(x, Element | OnAxis) else x


def inverse(x):
    """Return 1 / x."""
    require(x, "a division by 0")
    if type(x) is Interval:
        return Interval(4**PLACES // x.hi, -(-(4**PLACES) // x.lo))
    return x.tower.inverse(x) if isinstance(x, Element) else 1 / Fraction(x)


def nonzero(x):
    """Tell whether a number is not 0: it reduces to 0, or a box excludes 0."""
    if not isinstance(x, Element):
        return bool(x)
    for bits in BITS:
        if enclose(x, bits).excludes_zero():
            return True
    return bool(inverse(x))


def sign(x):
    """Return the sign of a number that is its own conjugate."""
    if type(x) is Interval:
        return 1 if x and x.lo > 0 else -1
    if not isinstance(x, Element):
        return (x > 0) - (x < 0)
    require(conj(x) == x, "a sign is asked of a number that is not real")
    for bits in BITS:
        low, high = enclose(x, bits).re
        if low > 0 or high < 0:
            return 1 if low > 0 else -1
    return beyond()


def real(x):
    """Return the real part."""
    return (x + conj(x)) * Fraction(1, 2)


def upper(x):
    """Tell whether the imaginary part is shown to be positive."""
    return any(enclose(x, bits).im[0] > 0 for bits in BITS[:2])


def rational(text):
    """Return a rational number written as a string."""
    found = isinstance(text, str) and re.fullmatch(r"-?[0-9]+(/[0-9]+)?", text)
    require(found and len(text) <= DIGITS, f"{str(text)[:40]!r} is no rational number")
    top, _, bottom = text.partition("/")
    require(int(bottom or 1), "a division by 0")
    return Fraction(int(top), int(bottom or 1))


class Parser:
    """The grammar of entries (data contract); `value` is the number, `text` the expanded text."""

    token = re.compile(r"[0-9]+\.[0-9]+|[0-9]+|[A-Za-z_][A-Za-z_0-9]*|[-+*/(),]")

    def __init__(self, text, name, radical, constant_text=None, decimal=None):
        require(isinstance(text, str) and 0 < len(text) <= DIGITS, "an entry is no short string")
        text = text.replace(" ", "")
        self.tokens = self.token.findall(text)
        require("".join(self.tokens) == text, f"{text[:40]!r} is no entry")
        self.name, self.radical, self.constant_text = name, radical, constant_text
        self.decimal, self.at = decimal, 0
        self.value, self.text = self.sum()
        require(self.at == len(self.tokens), f"{text[:40]!r} is no entry")

    def peek(self):
        """Return the next token, or an empty string."""
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def take(self, expected=None):
        """Return the next token and go on."""
        token = self.peek()
        require(token and expected in (None, token), "an entry breaks the grammar")
        self.at += 1
        return token

    def sum(self):
        """Return product (("+" | "-") product)*."""
        value, text = self.product()
        while self.peek() in ("+", "-"):
            token = self.take()
            other, more = self.product()
            value, text = value + other if token == "+" else value - other, text + token + more
        return value, text

    def product(self):
        """Return factor (("*" | "/") factor)*."""
        value, text = self.factor()
        while self.peek() in ("*", "/"):
            token = self.take()
            other, more = self.factor()
            value, text = value * (other if token == "*" else inverse(other)), text + token + more
        return value, text

    def factor(self):
        """Return ("+" | "-") factor | atom."""
        if self.peek() in ("+", "-"):
            token = self.take()
            value, text = self.factor()
            return (-value if token == "-" else value), token + text
        return self.atom()

    def atom(self):
        """Return a number, a name, a sum in parentheses or a radical."""
        token = self.take()
        if token.isdigit():
            return Fraction(int(token)), token
        if token[0].isdigit():
            require(self.decimal, "a decimal is no exact number")
            return self.decimal(token), token
        if token == "(":
            value, text = self.sum()
            return value, "(" + text + self.take(")")
        require(token[0].isalpha() or token[0] == "_", "an entry breaks the grammar")
        if token in ("sqrt", "root", "exp"):
            return self.function(token)
        if token == "i":
            require(self.radical, "i stands where no radical may")
            return self.radical("i"), "i"
        value = self.name(token)
        require(value is not None, f"nothing is called {token[:40]!r}")
        return value, "(" + self.constant_text(token) + ")" if self.constant_text else token

    def function(self, token):
        """Return sqrt(..), root(.., n) or exp(..): what the certificate says it is."""
        require(self.radical, "a radical stands where none may")
        self.take("(")
        if token == "exp":
            inner = ""
            while self.peek() not in (")", ""):
                inner += self.take()
        else:
            inner = self.sum()[1]
        if token == "root":
            self.take(",")
            inner += "," + self.take()
        text = f"{token}({inner}{self.take(')')}"
        return self.radical(text), text


class Numbers:
    """The field of a certificate: reads entries and checks radicals (2)."""

    def __init__(self, field):
        kind = field.get("kind") if isinstance(field, dict) else None
        more = {"rational": "", "tower": "generators radicals", "balls": "generators radicals",
                "enclosure": "generators radicals proofs"}  # fmt: skip
        require(isinstance(kind, str) and kind in more, "no field is of this kind")
        keys(field, "kind " + more[kind], "", "field")
        self.tower, self.memory, self.radicals = Tower(field.get("generators", ())), {}, {}
        self.unknowns, self.decimal, self.explicit = {}, None, None
        texts = field.get("radicals", {})
        require(isinstance(texts, dict) and len(texts) <= 100, "radicals are an object")
        self.radicals = {text: self.tower.parse(value) for text, value in texts.items()}
        for text, value in self.radicals.items():
            self.check_radical(text, value)

    def changed(self, **more):
        """Return the same numbers with other unknowns, or another meaning of decimals."""
        other = copy(self)
        other.memory = {}
        for key, value in more.items():
            setattr(other, key, value)
        return other

    def radical(self, text):
        """Return what a radical is said to be."""
        require(text in self.radicals, f"the radical {text[:60]} is not in the field")
        return self.radicals[text]

    def check_radical(self, text, x):
        """Refuse a value that is not the radical."""
        wrong = f"{text[:60]} is another number"
        if text == "i":
            require(x * x == -1 and upper(x), wrong)
            return
        found = re.fullmatch(r"(sqrt|root|exp)\((.*)\)", text)
        require(found, f"{text[:60]!r} is no radical")
        kind, inner = found.groups()
        if kind == "exp":
            self.check_root_of_unity(inner, x, wrong)
            return
        power = 2
        if kind == "root":
            inner, _, last = inner.rpartition(",")
            require(last.isdigit() and 1 <= int(last) <= DIMENSION, wrong)
            power = int(last)
        radicand = Parser(inner, lambda name: None, self.radical).value
        require(x**power == radicand, wrong)
        if not x:
            return
        half = vanishes(real(x)) and upper(x) if kind == "sqrt" else False
        require(half or (enclose(x, BITS[1]).re[0] > 0 and (kind == "sqrt" or conj(x) == x)), wrong)

    @staticmethod
    def check_root_of_unity(inner, x, wrong):
        """Refuse x unless x^n = 1 and x is nearer to the angle than other roots are."""
        words = inner if "/(" in inner else inner.replace("(", "").replace(")", "")
        fits = re.fullmatch(r"[-+]?(?:\d+|pi|i)(?:[*/](?:\d+|pi|i))*", words)
        require(fits, f"not covered: the angle {inner[:40]}")
        turns, at = Fraction(-1 if words[0] == "-" else 1, 2), {"*pi": 0, "*i": 0}
        for word in re.findall(r"[*/]\w+", "*" + words.lstrip("+-")):
            if word in at:
                at[word] += 1
            else:
                number = Fraction(int(word[1:]) if word[1:].isdigit() else 0)
                require(number or word[0] == "*", wrong)
                turns = turns * number if word[0] == "*" else turns / number
        require(not turns or set(at.values()) == {1}, wrong)
        n, box = turns.denominator, enclose(x, BITS[1])
        require(n <= 100 and x**n == 1, wrong)
        # the n-th roots are 4/n apart at least, so that floating-point numbers tell which one it is
        middle = complex(sum(box.re), sum(box.im)) / 2 ** (BITS[1] + 1)
        require(abs(middle - cmath.exp(2j * cmath.pi * float(turns % 1))) * n < 1, wrong)

    def name(self, document, name):
        """Return (value, text) of a constant or unknown of the document."""
        memory = self.memory.setdefault(id(document), (document, {}))[1]  # keeps the object
        if name not in memory:
            memory[name] = None  # a constant that uses itself finds nothing
            own = document.get("constants", {})
            require(isinstance(own, dict), "constants are an object")
            if name in document.get("unknowns", {}):
                require(name in self.unknowns and name not in own, "an unknown")
                memory[name] = (self.unknowns[name], name)
            elif name not in own:
                return None
            else:
                above = {*list(own)[: list(own).index(name)], *document.get("unknowns", {})}
                parser = self.parser(own[name], document, above)
                memory[name] = (parser.value, parser.text)
        return memory[name]

    def parser(self, text, document, allowed=None):
        """Return the parsed entry of a document."""

        def known(name):
            found = self.name(document, name) if allowed is None or name in allowed else None
            return found and found[0]

        def decimal(number):
            if not Fraction(number):
                return Fraction(0)  # 0.000 of a table is 0
            require(self.decimal is not None, "a decimal is no exact number")
            return self.decimal(number)

        return Parser(text, known, self.radical, lambda n: self.name(document, n)[1],
                      decimal if "digits" in document else None)  # fmt: skip

    def vector(self, texts, document=None):
        """Return a list of entries of the document, or of a witness."""
        require(isinstance(texts, list) and 0 < len(texts) <= SIZE, "a list of numbers is missing")
        if document is None:
            return [self.number(text) for text in texts]
        return [self.parser(text, document).value for text in texts]

    def matrix(self, rows, document=None):
        """Return a matrix of the document, or of a witness."""
        require(isinstance(rows, list) and 0 < len(rows) <= SIZE, "a matrix is missing")
        rows = [self.vector(row, document) for row in rows]
        require(len({len(row) for row in rows}) == 1, "rows of a matrix have other lengths")
        return rows

    def form(self, value, document):
        """Return a matrix of the document that may be written as its diagonal."""
        flat = isinstance(value, list) and value and isinstance(value[0], str)
        return diagonal(self.vector(value, document)) if flat else self.matrix(value, document)

    def number(self, text):
        """Return a number of a witness."""
        return self.tower.parse(text, self.radical)


# ------------------------------------------------------------------- section 3: trees and series


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


def less_cuts(values, tree, eta):
    """Return values less N(t, s) / m! eta(s) for all that is left when t is cut, but t itself."""
    for s, weight in cut(tree):
        if s != tree:
            values = [x if is_nil(y) else x - y * weight
                      for x, y in zip(values, eta(s), strict=True)]  # fmt: skip
    return values


class Series:
    """A starting series eta and what follows from it; also, without U, the series of a start.

    Above stage order q = 1 the xi of a tree are those of its class (6.2).
    """

    q = 1

    def __init__(self, part, u, eta):
        self.part, self.u, self.eta_of = part, u, eta
        self.known = {}

    @classmethod
    def read(cls, method, witness, order, nystrom, identity_mode):
        """Return the series of a witness, with every tree through the order."""
        u = read_u(method, witness["u"])
        pool = [t for n in range(1, order + 1) for t in pool_of(method, n, nystrom)]
        zero = {c: [Fraction(0)] * method.part(c).r for c in method.parts}
        if witness["eta"] == "zero":
            eta = {t: zero[t[0]] for t in pool}
        else:
            require(isinstance(witness["eta"], dict), "eta is an object")
            eta = {}
            for text, values in witness["eta"].items():
                tree = read_tree(text)
                require(tree not in eta, f"the tree {text} is there twice")
                eta[tree] = method.numbers.vector(values)
            for tree in pool:
                require(tree in eta, "a tree is missing in eta")
                require(len(eta[tree]) == len(zero[tree[0]]), "a value of eta has another length")
            require(len(eta) == len(pool), "there are trees too many in eta")
        if identity_mode:
            reads = {c: reading(method, c, x) for c, x in u.items()}
            fine = all(vanishes(dot(reads[t[0]], x)) for t, x in eta.items())
            require(fine, "eta is not 0 in what is read as the solution")
        if not method.system:
            return cls(method.part, u, eta.__getitem__)
        # the trees are not closed under cuts; one value that is the solution has no series but 0
        fine = identity_mode and all(len(x) == 1 for x in zero.values())
        require(fine, "several values are carried, or the solution is not among them")
        return cls(method.part, u, lambda t: eta.get(t, zero[t[0]]))

    @classmethod
    def of_tables(cls, tables, u=None):
        """Return the series of a starting or finishing method, {colour: (A, B)}."""
        parts = {c: Component(A, [[]] * len(A), B, None) for c, (A, B) in tables.items()}
        return cls(parts.__getitem__, u, lambda tree: [])

    def derivative(self, tree):
        """Return xiD(t), the product of the xi of the children."""
        return placewise(len(self.part(tree[0]).A[0]), map(self.stages, tree[1]))

    def stages(self, tree):
        """Return xi(t) = A xiD(t) + U eta(t), that of its class times the factor."""
        tree, factor = reduced(tree, self.q) if self.q > 1 else (tree, 1)
        if tree not in self.known:
            m = self.part(tree[0])
            slopes, values = apply(m.A, self.derivative(tree)), apply(m.U, self.eta_of(tree))
            self.known[tree] = [x + y for x, y in zip(slopes, values, strict=True)]
        found = self.known[tree]
        return found if factor == 1 else multiples(factor, found)

    def value(self, tree):
        """Return B xiD(t)."""
        return apply(self.part(tree[0]).B, self.derivative(tree))

    def residual(self, tree):
        """Return R(t) = B xiD(t) - ((E eta)(t) - eta(t))."""
        flow = [x * Fraction(1, gamma(tree)) for x in self.u[tree[0]]]
        return less_cuts(less(self.value(tree), flow), tree, self.eta_of)


def first_place(u):
    """Return the first place where u is not 0."""
    place = next((k for k, x in enumerate(u) if nonzero(x)), None)
    require(place is not None, "u is 0")
    return place


def reading(method, colour, u):
    """Return the row that reads the solution: as declared, or 1 / u_k at the first place k."""
    w = method.declared.get(colour)
    if w is None:
        k = first_place(u)
        return [inverse(u[k]) if j == k else Fraction(0) for j in range(len(u))]
    require(len(w) == len(u) and vanishes(dot(w, u) - 1), "the output does not read the solution")
    return w


def read_u(method, given):
    """Return u of each colour after V u = u, U u = 1."""
    require(isinstance(given, dict) and set(given) == set(method.parts), "u is given by colours")
    u = {c: method.numbers.vector(x) for c, x in given.items()}
    for c, x in u.items():
        m = method.part(c)
        require(len(x) == m.r, "u has another length")
        equal(apply(m.V, x), x, f"V u = u ({c})")
        equal(apply(m.U, x), ones(len(m.U)), f"U u = 1 ({c})")
    return u


# ---------------------------------------------------------------- section 4: rules for orders


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
    """Return the trees of an order without branches."""
    if order == 1:
        return [(colour, ()) for colour, _ in palette]
    below = paths(palette, order - 1)
    return [(colour, (t,)) for colour, children in palette for t in below if t[0] in children]


def pool_of(method, order, nystrom):
    """Return the trees of one order that count."""
    if nystrom in PATHS:
        return paths(method.palette, order)
    return [t for t in trees(method.palette, order)
            if stands(t, method.system) and (not nystrom or is_nystrom(t))]  # fmt: skip


def check_series(method, series, order, nystrom):
    """Refuse unless (I - V) eta(t) = R(t) for every tree through the order."""
    for tree in (t for n in range(1, order + 1) for t in pool_of(method, n, nystrom)):
        m, eta = method.part(tree[0]), series.eta_of(tree)
        left = less(eta, apply(m.V, eta))
        equal(left, series.residual(tree), f"the condition of tree {show(tree)}")


def check_quadrature(method, series, order, which):
    """Refuse unless paths decide: stages are the solution on the paths below the order."""
    require(method.separable, "paths decide for separable pairs")
    reads = {c: reading(method, c, u) for c, u in series.u.items()}
    trees_ = [t for n in range(1, order + 1) for t in paths(method.palette, n)]
    fine = all(vanishes(dot(reads[t[0]], series.eta_of(t))) for t in trees_)
    require(fine, "paths decide where principal parts are the identity")
    for colour in PATHS[which]:
        reached = min(path_orders(method, series, colour, order - 1))
        require(reached >= order - 1, f"a stage of {colour} is not the solution")


def path_orders(method, series, colour, most):
    """Return for each stage through which order, `most` or less, paths t give c^|t| / |t|!."""
    c = series.stages((colour, ()))
    reached = [min(1, most)] * len(c)
    for n in range(2, most + 1):
        (tree,) = [t for t in paths(method.palette, n) if t[0] == colour]
        for i, x in enumerate(series.stages(tree)):
            if reached[i] == n - 1 and vanishes(x - c[i] ** n * Fraction(1, gamma(tree))):
                reached[i] = n
    return reached


def check_start_along_paths(method, start, p, nystrom):
    """Refuse unless the values of a start use stages that are the solution far enough (4)."""
    if isinstance(start, ZeroStart):
        return  # its values are 0 on a tree where eta is: there and on the path of the same order
    (A, B), (A_hat, B_hat) = ((start.part(c).A, start.part(c).B) for c in "fk")
    if nystrom:
        links = {"f": (times(A, A_hat), "f", 2)}
        used = [(B_hat, "f", p - 1), (times(B, A_hat), "f", p - 2)]
    else:
        links = {"f": (A, "k", 1), "k": (A_hat, "f", 1)}
        used = [(B, "k", p - 1), (B_hat, "f", p - 1)]
    orders = {c: path_orders(method, start, c, p) for c in links}
    before = None
    while before != orders:
        before = {c: list(x) for c, x in orders.items()}
        for c, (M, other, gain) in links.items():
            for i, row_ in enumerate(M):
                least = [orders[other][j] + gain for j, x in enumerate(row_) if not is_nil(x)]
                orders[c][i] = min([orders[c][i], *least])
    fine = all(is_nil(x) or orders[c][j] >= least
               for M, c, least in used for row_ in M for j, x in enumerate(row_))  # fmt: skip
    require(fine, "a value of the start uses a stage that is not the solution")


def show(tree):
    """Return the text of a tree."""
    inner = "".join(map(show, tree[1]))
    return (tree[0] if tree[0] != "o" or not inner else "") + (f"[{inner}]" if inner else "")


def order_at_least(proof, w):
    """Rule order-at-least: of the last order values of eta, or only that there are some."""
    keys(w, "order principal trees u eta", "last")
    identity_mode, nystrom = mode(w)
    order = whole(w["order"], 0, 20 if nystrom in PATHS else 14)
    solvable = "last" in w
    series = Series.read(proof.method, w, order - solvable, nystrom, identity_mode)
    check_series(proof.method, series, order - solvable, nystrom)
    if solvable:
        fine = w["last"] == "solvable" and nystrom not in PATHS and not proof.method.system
        require(fine and order, "the last order")
        left = {c: kernel(transpose(minus(m.V, identity(m.r))))
                for c, m in proof.method.parts.items()}  # fmt: skip
        for tree in pool_of(proof.method, order, nystrom):
            found = vanishes(apply(left[tree[0]], series.residual(tree)))
            require(found, f"the condition of tree {show(tree)}")
    if nystrom in PATHS:
        check_quadrature(proof.method, series, order, nystrom)
    proof.series, proof.low = series, (order, identity_mode, nystrom)


def order_at_most(proof, w):
    """Rule order-at-most: order p + 1 is not reached."""
    method, same = proof.method, w.get("same", False) is True
    keys(w, "order principal trees W N n" + (" same" if same else " u eta"))
    identity_mode, nystrom = mode(w)
    p = whole(w["order"], 0, 20 if nystrom in PATHS else 14)
    if same:
        require(proof.low == (p, identity_mode, nystrom), "order-at-least has another series")
        series = proof.series
    else:
        series = Series.read(method, w, p, nystrom, identity_mode)
        check_series(method, series, p, nystrom)
    W, N = eigenspaces_to_one(method, w)
    d = {c: len(W[c]) for c in W}
    K = {(c, e): times(W[c], method.part(c).B, method.part(e).U, N[e])
         for c, children in method.palette for e in children}  # fmt: skip
    if p >= 2 and (len(d) > 1 or max(d.values()) > 1):
        check_kernel(method, d, K)
    n = {read_tree(text): method.numbers.vector(x) for text, x in as_object(w["n"]).items()}
    require(len(n) == len(w["n"]), "a tree is there twice in n")
    counted = set(pool_of(method, p + 1, nystrom))
    require(set(n) <= counted, "a tree of n is not of order p + 1")
    require(all(len(x) == d[t[0]] for t, x in n.items()), "a value of n has another length")
    first = total(dot(x, apply(W[t[0]], series.residual(t))) for t, x in n.items())
    require(nonzero(first), "the sum (a) is 0")
    check_sum_b(method, p, nystrom, n, K, principal_parts(method, series, N, identity_mode))
    simple = max(d.values()) == 1
    require(nystrom not in PATHS or (same and simple), "paths need a simple eigenvalue 1")
    proof.high, proof.simple = (p, identity_mode, nystrom), simple


def as_object(value):
    """Return an object of the certificate."""
    require(isinstance(value, dict), "an object is missing")
    return value


def eigenspaces_to_one(method, w):
    """Return W and N of each colour: V N = N, W V = W, W N = I, rank (I - V) = r - d."""
    W, N = {}, {}
    for key, store in (("W", W), ("N", N)):
        require(set(as_object(w[key])) == set(method.parts), f"{key} is given by colours")
        store.update({c: method.numbers.matrix(M) for c, M in w[key].items()})
    for c in W:
        V, r, d = method.part(c).V, method.part(c).r, len(W[c])
        require(len(W[c][0]) == len(N[c]) == r and len(N[c][0]) == d, "W or N has another shape")
        equal(times(V, N[c]), N[c], "V N = N")
        equal(times(W[c], V), W[c], "W V = W")
        equal(times(W[c], N[c]), identity(d), "W N = I")
        require(rank(minus(identity(r), V)) == r - d, "the rank of I - V is not r - d")
    return W, N


def check_kernel(method, d, K):
    """Refuse unless beta -> (K beta(s) [t = [s]] - N(t, s) beta(s))_t has a kernel line."""
    offset, width = {}, 0
    for c in d:
        offset[c], width = width, width + d[c]
    rows = []
    for tree in trees(method.palette, 2):
        c, e = tree[0], tree[1][0][0]
        for i in range(d[c]):
            row = [Fraction(0)] * width
            for j in range(d[e]):
                row[offset[e] + j] += K[c, e][i][j]
            row[offset[c] + i] -= 1
            rows.append(row)
    require(width - rank(rows) == 1, "principal parts at order 1 are not unique up to the flow")


def principal_parts(method, series, N, identity_mode):
    """Return a basis of F for each colour: all e, or those that are not read in N e."""
    if not identity_mode:
        return {c: identity(len(M[0])) for c, M in N.items()}
    return {c: kernel(times([reading(method, c, series.u[c])], M)) for c, M in N.items()}


def check_sum_b(method, p, nystrom, n, K, free):
    """Refuse unless (b) holds for every tree s of order p and e in F_s."""
    for s in pool_of(method, p, nystrom) if p else ():
        for e in free[s[0]]:
            value = Fraction(0)
            for t, x in n.items():
                if t[1] == (s,):
                    value = value + dot(x, apply(K[t[0], s[0]], e))
                weight = dict(cut(t)).get(s, 0)  # m = 1: N(t, s) / 1!
                if weight:
                    value = value - weight * dot(x, e)
            require(vanishes(value), f"the sum (b) is not 0 for the tree {show(s)}")


def contradiction(proof, w, preconsistency):
    """Rules no-order-1 and not-preconsistent."""
    m = proof.method.part(w.get("colour"))
    if "rows" in w:  # u is a multiple of the eigenvector, and two entries of U u differ
        keys(w, "colour rows")
        u = [apply(m.U, x) for x in kernel(minus(m.V, identity(m.r)))]
        require(preconsistency and len(u) < 2, "1 is a multiple eigenvalue")
        rows = w["rows"]
        require(isinstance(rows, list) and len(rows) == 2, "rows are two")
        i, j = (whole(x, 0, len(m.U) - 1) for x in rows)
        require(not u or apart(u[0][i] - u[0][j]), "the two entries may agree")
        return
    if set(w) == {"colour"}:  # W u = W B 1 says what u is, and U u is not 1
        require(not preconsistency, "x and y are missing")
        shift, slopes = minus(m.V, identity(m.r)), apply(m.B, ones(len(m.B[0])))
        right, left = kernel(shift), kernel(transpose(shift))
        if right:
            back = inverse_matrix(times(left, transpose(right)))
            u = apply(transpose(right), apply(back, apply(left, slopes)))
            require(any(apart(x - 1) for x in apply(m.U, u)), "U u may be 1")
        return
    keys(w, "colour x y" + ("" if preconsistency else " z"))
    x, y, *z = (proof.method.numbers.vector(w[k]) for k in ("x", "y", "z") if k in w)
    shift = transpose(minus(m.V, identity(m.r)))
    right = z[0] if z else [Fraction(0)] * m.r
    left = [a + b for a, b in zip(apply(shift, x), apply(transpose(m.U), y), strict=True)]
    equal(left, right, "x (V - I) + y U = z")
    value = total(y)
    if z:
        require(vanishes(apply(shift, z[0])), "z (V - I) = 0 does not hold")
        value = value - dot(z[0], apply(m.B, ones(len(m.B[0]))))
    require(nonzero(value), "the contradiction is 0 = 0")


def preconsistent(proof, w):
    """Rule preconsistent."""
    keys(w, "u")
    proof.u = read_u(proof.method, w["u"])


def consistent(proof, w):
    """Rule consistent: also B 1 + V v = u + v; return u and v, v None where it only exists."""
    keys(w, "u", "v")
    u = read_u(proof.method, w["u"])
    if "v" not in w:
        for c, m in proof.method.parts.items():
            gap = less(apply(m.B, ones(len(m.B[0]))), u[c])
            left = kernel(transpose(minus(m.V, identity(m.r))))
            require(vanishes(apply(left, gap)), "(I - V) v = B 1 - u has no solution")
        return u, None
    require(set(as_object(w["v"])) == set(u), "v is given by colours")
    v = {c: proof.method.numbers.vector(x) for c, x in w["v"].items()}
    for c in u:
        m = proof.method.part(c)
        left = [x + y for x, y in zip(apply(m.B, ones(len(m.B[0]))), apply(m.V, v[c]), strict=True)]
        equal(left, [x + y for x, y in zip(u[c], v[c], strict=True)], "B 1 + V v = u + v")
    return u, v


def named_tree(proof, w, order, nystrom):
    """Return the tree of a witness, which must be one of this order."""
    tree = read_tree(w["tree"])
    require(tree in pool_of(proof.method, order, nystrom), "the tree has another order")
    return tree


def stage_defect(series, tree, fixed):
    """Return xi(t) - c^|t| / gamma(t), or what `fixed` gives of it by the colour."""
    c = series.stages((tree[0], ()))
    gap = less(series.stages(tree), [x ** size(tree) * Fraction(1, gamma(tree)) for x in c])
    return apply(fixed[tree[0]], gap) if fixed else gap


def fixed_rows(proof, order, p):
    """Return by colour the rows z with z U n = 0 for all n = V n; None below p and for identity."""
    parts, identity_mode = proof.method.parts, proof.mode()[0]
    if order != p or identity_mode or all(m.r == 1 for m in parts.values()):
        return None
    rows = {}
    for c, m in parts.items():
        require(not any(type(x) is Interval for row in m.V for x in row), "V holds decimals")
        N = kernel(minus(m.V, identity(m.r)))
        moved = [apply(m.U, n) for n in N]
        if len(N) == 1:  # U u = 1
            moved = [[Fraction(1)] * len(m.U)]
        balls = any(type(x) is Interval for row in moved for x in row)
        require(not balls, "not covered: decimals in U where the eigenvalue 1 of V is multiple")
        rows[c] = kernel(moved)
    return rows


def stage_order_at_least(proof, w):
    """Rule stage-order-at-least; c is what the stages are at the single vertices."""
    keys(w, "q")
    q = whole(w["q"])
    require(proof.low and q <= proof.low[0], "the stage order is above the order")
    require(proof.high or (proof.low[1] and proof.mode()[0]), "the order is not enclosed")
    for n in range(2, q + 1):
        fixed = fixed_rows(proof, n, proof.low[0])
        for tree in pool_of(proof.method, n, proof.low[2]):
            gap = stage_defect(proof.series, tree, fixed)
            require(vanishes(gap), f"the stages are wrong at tree {show(tree)}")
    return q


def stage_order_at_most(proof, w):
    """Rule stage-order-at-most."""
    keys(w, "q", "tree")
    q = whole(w["q"])
    require(proof.high and proof.low and proof.high == proof.low, "the order is not enclosed")
    if q < proof.low[0]:
        require("tree" in w, "the tree is missing")
        tree = named_tree(proof, w, q + 1, proof.low[2])
        gap = stage_defect(proof.series, tree, fixed_rows(proof, q + 1, proof.low[0]))
        require(any(nonzero(x) for x in gap), "the stages are right at the tree")
    require(q <= proof.low[0], "the stage order is above the order")
    return q


class ZeroStart:
    """The start (y0, 0, ..) of a pair without `starting`."""

    def __init__(self, method):
        self.u = {c: [Fraction(int(k == 0)) for k in range(m.r)] for c, m in method.parts.items()}

    def value(self, tree):
        """Return zeros."""
        return [Fraction(0)] * len(self.u[tree[0]])


def start_of(method):
    """Return the series of the file's start."""
    table = method.document.get("starting")
    if table is None:
        require(method.pair, "the file has no start")
        return ZeroStart(method)
    hats = {"o": ""} if not method.pair else {"f": "", "k": "_hat"}
    keys(table, " ".join(f"A{h} B{h} u{h}" for h in hats.values()), "name kind order", "start")
    tables = {c: (method.matrix("A" + h, table), method.matrix("B" + h, table))
              for c, h in hats.items()}  # fmt: skip
    u = {c: method.list("u" + h, table) for c, h in hats.items()}
    for c, (_, B) in tables.items():
        require(len(B) == len(u[c]) == method.part(c).r, "the start has another number of values")
    return Series.of_tables(tables, u)


def start_series(proof, w):
    """Return (q, order, eta, start) of a start-at-.. witness; eta satisfies order-at-least."""
    method = proof.method
    order, q, trees_ = whole(w["order"], 0, 20), whole(w["q"]), counted(w["trees"])
    require(proof.low and proof.low == proof.high, "the order is not enclosed")
    p, identity_mode, nystrom = proof.low
    fits = order == p and nystrom == trees_ and (identity_mode or not method.pair)
    require(fits and q <= order, "the order of the series is not that of the method")
    series = Series.read(method, w, order, nystrom, identity_mode)
    check_series(method, series, order, nystrom)
    start = start_of(method)
    if nystrom in PATHS:
        check_start_along_paths(method, start, order, nystrom == "nystrom-paths")
    return q, order, series, start


def start_at_least(proof, w):
    """Rule start-at-least."""
    keys(w, "q order u eta trees")
    q, _, series, start = start_series(proof, w)
    for c, u in series.u.items() if q else ():
        equal(start.u[c], u, "u of the start")
    for tree in (t for n in range(1, q + 1) for t in pool_of(proof.method, n, proof.low[2])):
        equal(start.value(tree), series.eta_of(tree), f"the start at tree {show(tree)}")
    return q


def off_line(gap, u):
    """Tell whether a vector is shown to be no multiple of u."""
    return any(apart(gap[i] * u[j] - gap[j] * u[i]) for i in range(len(u)) for j in range(i))


def start_at_most(proof, w):
    """Rule start-at-most."""
    keys(w, "q order u eta tree", "value trees")
    q, order, series, start = start_series(proof, {"trees": "all", **w})
    colour = next(iter(series.u))
    if w["tree"] == "" and q != order:
        different = any(nonzero(x - y) for c, u in series.u.items()
                        for x, y in zip(start.u[c], u, strict=True))  # fmt: skip
        require(q == 0 and different, "u is that of the start")
        return q
    row, single = reading(proof.method, colour, series.u[colour]), (colour, ())
    same = order == 0 or dot(row, start.value(single)) == dot(row, series.eta_of(single))
    require(same, "eta does not agree with the start at the single vertex")
    if q == order:
        return q
    tree, place = named_tree(proof, w, q + 1, proof.low[2]), whole(w.get("value"), 1) - 1  # from 1
    gap = less(start.value(tree), series.eta_of(tree))
    require(place < len(gap), "there is no such value")
    if q + 1 == order and not proof.low[1]:
        m = proof.method.part(tree[0])
        still = kernel(kernel(minus(m.V, identity(m.r)))) if not proof.simple else []
        wrong = any(map(nonzero, apply(still, gap))) or (
            proof.simple and off_line(gap, series.u[tree[0]])
        )
    else:
        wrong = nonzero(gap[place])
    require(wrong, "the start is right at the tree")
    return q


def finish_defect(proof, tree):
    """Return (a b)(t), a the first value of the start and b the finish."""
    method = proof.method
    require(not method.pair, "pairs have no finish")
    require(not method.declared, "not covered: a finish of a method that declares an output")
    start, table = start_of(method), method.document.get("finishing")
    require(start.u["o"][0] == 1, "the first value of the start is not y0")
    keys(table, "A b", "name kind order", "finish")
    A, b = method.matrix("A", table), [method.list("b", table)]
    finish = Series.of_tables({"o": (A, b)})

    def first(t):
        return start.value(t)[0]

    return first(tree) + total(w * finish.value(s)[0] for s, w in cuts(tree, first).items())


def finish_at_least(proof, w):
    """Rule finish-at-least."""
    keys(w, "q")
    for tree in (
        t for n in range(1, whole(w["q"], 0, 12) + 1) for t in trees(proof.method.palette, n)
    ):
        require(vanishes(finish_defect(proof, tree)), f"the finish is wrong at {show(tree)}")
    return w["q"]


def finish_at_most(proof, w):
    """Rule finish-at-most: a tree, or the order of the method."""
    keys(w, "q", "tree")
    if "tree" not in w:
        whole(w["q"])
        require(proof.high and proof.low == proof.high, "the order is not enclosed")
        require(w["q"] == proof.high[0], "the finish has another order")
        return w["q"]
    tree = read_tree(w["tree"])
    require(tree in trees(proof.method.palette, whole(w["q"], 0, 12) + 1), "another order")
    require(nonzero(finish_defect(proof, tree)), "the finish is right at the tree")
    return w["q"]


# --------------------------------------------------------- section 5: polynomials and their roots


def trim(p):
    """Return p without leading zeros; constant first."""
    p = list(p)
    while p and not p[-1]:
        p.pop()
    return p


def multiply(p, q):
    """Return p q."""
    out = [Fraction(0)] * (len(p) + len(q) - 1) if p and q else []
    for i, a in enumerate(p):
        for j, b in enumerate(q):
            if a and b:
                out[i + j] = out[i + j] + a * b
    return trim(out)


def plus(p, q, factor=1):
    """Return p + factor q."""
    n = max(len(p), len(q))
    p, q = (list(x) + [Fraction(0)] * (n - len(x)) for x in (p, q))
    return trim([a + factor * b for a, b in zip(p, q, strict=True)])


def divide(p, q):
    """Return quotient and remainder."""
    p, q, unit, out = trim(p), trim(q), inverse(trim(q)[-1]), []
    out = [Fraction(0)] * max(len(p) - len(q) + 1, 0)
    while len(p) >= len(q):
        shift, factor = len(p) - len(q), p[-1] * unit
        out[shift] = factor
        p = trim([x - factor * q[i - shift] if i >= shift else x for i, x in enumerate(p)][:-1])
    return out, p


def gcd(p, q):
    """Return a monic greatest common divisor."""
    p, q = trim(p), trim(q)
    while q:
        p, q = q, divide(p, q)[1]
    return [inverse(p[-1]) * x for x in p]


def mirror(p):
    """Return p~, the coefficients conjugated and reversed."""
    return [conj(x) for x in reversed(p)]


def margins(p):
    """Yield |p_n|^2 - |p_0|^2 along the steps of Schur and Cohn, None where Cohn's step fails."""
    p = trim(p)
    require(p, "a polynomial is 0")
    while len(p) > 1:
        a, b = conj(p[-1]), p[0]
        if type(b) is not Interval and not b:
            p = p[1:]
            continue
        margin = squared(a) - squared(b)
        yield margin
        if margin:
            p = [a * x - b * y for x, y in zip(p, mirror(p), strict=True)][1:]
        elif vanishes([conj(a) * x - conj(b) * y for x, y in zip(mirror(p), p, strict=True)]):
            p = derivative(p)
        else:
            yield None
            return


def squared(x):
    """Return |x|^2."""
    return x * conj(x)


def is_schur(p):
    """Tell whether all roots lie inside the circle (Schur, Cohn)."""
    return all(sign(x) > 0 for x in margins(p))


def in_disc(p):
    """Tell whether all roots lie in the closed disc (Schur, Cohn)."""
    return all(x is not None and sign(x) >= 0 for x in margins(p))


def at_matrix(p, V):
    """Return p(V)."""
    value = scale(p[-1], identity(len(V)))
    for c in reversed(p[:-1]):
        value = combine(times(value, V), scale(c, identity(len(V))))
    return value


def characteristic(M):
    """Return det(x I - M), constant first (Faddeev, LeVerrier)."""
    n = len(M)
    require(n <= 40, "beyond the limits of this checker")
    coefficients, N = [Fraction(1)], [[Fraction(0)] * n for _ in range(n)]
    for k in range(1, n + 1):
        N = combine(times(M, N), scale(coefficients[-1], identity(n)))
        product_ = times(M, N)
        coefficients.append(total(product_[i][i] for i in range(n)) * Fraction(-1, k))
    return coefficients[::-1]


def polynomial(proof, texts):
    """Return a polynomial of a witness: its leading coefficient is not 0."""
    p = proof.method.numbers.vector(texts)
    require(nonzero(p[-1]), "a leading coefficient is 0")
    return p


def square_free(p):
    """Tell whether gcd(p, p') = 1."""
    return len(gcd(p, derivative(p))) == 1


def is_exact(M):
    """Tell whether no entry is an interval."""
    return not any(type(x) is Interval for row in M for x in row)


def blocks_of(V):
    """Return the diagonal blocks of V: exact zeros say in which order it is block triangular."""
    reach = [{j for j, x in enumerate(row) if not is_nil(x)} | {i} for i, row in enumerate(V)]
    for _ in V:
        reach = [set().union(*(reach[j] for j in x)) for x in reach]
    groups = {tuple(j for j in sorted(x) if i in reach[j]) for i, x in enumerate(reach)}
    return [[[V[i][j] for j in group] for i in group] for group in sorted(groups)]


def bounded(proof, w):
    """Rule bounded: the powers of V are bounded.

    Where V holds decimals: of its diagonal blocks those with decimals have all eigenvalues inside
    the circle, and so have the exact ones but at most one, which q and h are about.
    """
    keys(w, "which q h")
    V = proof.method.part(w["which"]).V
    if not is_exact(V):
        others = [block for block in blocks_of(V) if not is_schur(characteristic(block))]
        require(len(others) < 2, "several blocks have eigenvalues on the circle")
        V = others[0] if others else [[Fraction(0)]]
    q, h = polynomial(proof, w["q"]), polynomial(proof, w["h"])
    require(vanishes(at_matrix(multiply(q, h), V)), "q(V) h(V) is not 0")
    require(in_disc(q), "q has a root outside the disc")
    require(square_free(q), "q has a multiple root")
    require(is_schur(h), "h has a root that is not inside the circle")
    proof.stable.add(w["which"])


def is_left(q, h, V):
    """Tell whether rad(q)(V) h(V)^r is not 0: a root of q, which h shares none of, is defective."""
    M, inner = at_matrix(divide(q, gcd(q, derivative(q)))[0], V), at_matrix(h, V)
    for _ in V:
        M = times(M, inner)
    return any(nonzero(x) for row in M for x in row)


def unbounded(proof, w):
    """Rule unbounded: an eigenvalue outside, or a defective one on the circle, or of a block."""
    keys(w, "which value", "block")
    V, value, read = proof.method.part(w["which"]).V, as_object(w["value"]), proof.method.numbers
    if "block" in w:
        blocks = blocks_of(V)
        V = blocks[whole(w["block"], 0, len(blocks) - 1)]
    if "lambda" in value:
        keys(value, "lambda x", "y")
        z, x = read.number(value["lambda"]), read.vector(value["x"])
        require(any(map(nonzero, x)), "x is 0")
        equal(apply(V, x), [z * e for e in x], "V x = lambda x")
        if "y" not in value:
            require(sign(squared(z) - 1) > 0, "|lambda| is not above 1")
            return
        y = read.vector(value["y"])
        require(squared(z) == 1, "|lambda| is not 1")
        equal(apply(V, y), [z * a + b for a, b in zip(y, x, strict=True)], "V y = lambda y + x")
        return
    keys(value, "charpoly", "chain")
    require(value["charpoly"] is True, "charpoly is true")
    p = characteristic(V)
    if "chain" not in value:
        require(not in_disc(p), "the characteristic polynomial is in the disc")
        return
    chain = value["chain"]
    keys(chain, "q h")
    q, h = polynomial(proof, chain["q"]), polynomial(proof, chain["h"])
    require(plus(multiply(q, h), p, -1) == [], "q h is not the characteristic polynomial")
    on_circle = in_disc(q) and not squared(q[-1]) - squared(q[0])
    require(is_schur(h) and on_circle, "q or h has roots elsewhere")
    require(is_left(q, h, V), "rad(q)(V) h(V)^r is 0")


def eigen(proof, w):
    """Rule eigen: all eigenvalues of modulus 1 with their projections."""
    keys(w, "which parts h")
    m, read = proof.method.part(w["which"]), proof.method.numbers
    found, rest = [], identity(m.r)
    require(isinstance(w["parts"], list), "parts are a list")
    for part in w["parts"]:
        keys(part, "zeta W N", where="eigenvalue")
        z, W, N = read.number(part["zeta"]), read.matrix(part["W"]), read.matrix(part["N"])
        equal(times(m.V, N), scale(z, N), "V N = zeta N")
        equal(times(W, m.V), scale(z, W), "W V = zeta W")
        equal(times(W, N), identity(len(W)), "W N = I")
        require(squared(z) == 1, "an eigenvalue is not of modulus 1")
        require(all(nonzero(z - other) for other, _, _ in found), "an eigenvalue is there twice")
        found.append((z, W, N))
        rest = minus(rest, times(N, W))
    h = polynomial(proof, w["h"])
    require(is_schur(h), "h has a root that is not inside the circle")
    require(vanishes(times(at_matrix(h, m.V), rest)), "h(V) (I - sum N W) is not 0")
    require(w["which"] not in proof.eigen, "eigen is there twice")
    proof.eigen[w["which"]] = found


def half_turn(z):
    """Return 0 for arguments in [0, pi), 1 for [pi, 2 pi)."""
    if conj(z) == z:
        return 0 if sign(z) > 0 else 1
    return 0 if upper(z) else 1


def comes_before(y, z):
    """Tell whether arg y < arg z in [0, 2 pi), for numbers of modulus 1."""
    if half_turn(y) != half_turn(z):
        return half_turn(y) < half_turn(z)
    order = sign(real(y) - real(z))
    return order > 0 if half_turn(y) == 0 else order < 0


def growth_groups(proof):
    """Return for each eigenvalue of modulus 1 (zeta, matrices (1/zeta) W B U N).

    Pairs: for each shared eigenvalue but 1 the products of W_f B_f with U_k N_k and the like.
    """
    require(set(proof.eigen) == set(proof.method.parts), "eigen is missing for a component")
    for found in proof.eigen.values():
        for before, after in pairwise(found):
            require(comes_before(before[0], after[0]), "arguments do not increase")
    if not proof.method.pair:
        m = proof.method.single()
        return [(z, [scale(conj(z), times(W, m.B, m.U, N))]) for z, W, N in proof.eigen["o"]]
    groups, m = [], proof.method.parts
    children = dict(proof.method.palette)
    for z, *_ in proof.eigen["f"]:
        spaces = {c: next((e for e in proof.eigen[c] if not nonzero(e[0] - z)), None) for c in m}
        if not nonzero(z - 1) or spaces["k"] is None:
            continue
        simple = all(len(e[1]) == 1 for e in spaces.values())
        require(simple or proof.claim == "parasitism-free", "a shared eigenvalue is not simple")
        groups.append((z, [scale(conj(z), times(spaces[c][1], m[c].B, m[e].U, spaces[e][2]))
                           for c, others in children.items() for e in others
                           if e != c or proof.claim == "parasitism-free"]))  # fmt: skip
    return groups


def unshared(proof, w):
    """Rule unshared: V and V^ of a separable pair share the simple eigenvalue 1 and no other."""
    keys(w, "")
    require(proof.method.separable, "the pair is not separable")
    ends = [characteristic(m.V) for m in proof.method.parts.values()]
    require(gcd(*ends) == [-1, 1], "an eigenvalue other than 1 is shared, or none is")
    simple = all(nonzero(horner(derivative(p), Fraction(1))) for p in ends)
    require(simple, "the eigenvalue 1 is multiple")
    if proof.claim == "growth":
        none = not proof.claimed(proof.declared)
        require(none == proof.holds, "there are no growth parameters")


def from_roots(numbers):
    """Return the product of (x - mu)."""
    p = [Fraction(1)]
    for mu in numbers:
        p = plus([Fraction(0), *p], p, -mu)
    return p


def growth(proof, w):
    """Rule growth, for the claims growth and parasitism-free; pairs: all are 0."""
    keys(w, "list")
    groups, pair = growth_groups(proof), proof.method.pair
    free = proof.claim == "parasitism-free"
    if pair:
        declared = [] if free else proof.claimed(proof.declared)
        require(
            all_zero(proof, w["list"]), "not covered: growth parameters of pairs that are not 0"
        )
        require(vanishes(declared), "not covered: growth parameters of pairs that are not 0")
        require(free or len(declared) == sum(len(Ms) for _, Ms in groups), "another number of them")
        require(vanishes([M for _, Ms in groups for M in Ms]), "a growth parameter is not 0")
        return
    sizes = [len(M) - int(not nonzero(z - 1)) for z, (M,) in groups]
    zero = [[Fraction(0)] * n for n in sizes]
    if free:
        values = zero
        require(all_zero(proof, w["list"]), "a growth parameter is not 0")
    else:
        require(isinstance(w["list"], list) and len(w["list"]) == len(sizes), "list fits no parts")
        values = [proof.method.numbers.vector(x) if x else [] for x in w["list"]]
        given = declared_groups(proof, sizes)
        for mine, claimed in zip(values, given, strict=True):
            require(plus(from_roots(mine), from_roots(claimed), -1) == [], "other parameters")
    for (z, (M,)), mine in zip(groups, values, strict=True):
        require(growth_gap(z, M, mine) == [], "a list is not that of the eigenvalues")
        if free and (nonzero(z - 1) or len(M) > 1):
            require(rank(M) == int(not nonzero(z - 1)), "a growth matrix is not 0")


def all_zero(proof, given):
    """Tell whether a witness is "zero" or lists of zeros."""
    return given == "zero" or vanishes([proof.method.numbers.vector(x) for x in given if x])


def growth_gap(z, M, numbers):
    """Return det(x I - M) minus the product of (x - mu), times x - 1 for zeta = 1."""
    one = [] if nonzero(z - 1) else [Fraction(1)]
    if one and len(M) == 1 and not numbers:
        return []  # a simple eigenvalue 1 has no parasitic component
    return plus(characteristic(M), from_roots(numbers + one), -1)


def declared_groups(proof, sizes):
    """Return the declared list in groups of given sizes."""
    numbers = proof.claimed(proof.declared)
    require(len(numbers) == sum(sizes), "the declared list has another length")
    return [[numbers.pop(0) for _ in range(n)] for n in sizes]


def grows(proof, w):
    """Rule grows: the parameters of one part are other ones than declared."""
    keys(w, "part")
    free = proof.claim == "parasitism-free"
    if w["part"] == -1 and not proof.method.pair:  # the eigenvalues alone say how many there are
        count = sum(len(W) - int(not nonzero(z - 1)) for z, W, _ in proof.eigen["o"])
        require(not free and len(proof.declared) != count, "the number of parameters is right")
        return
    groups = growth_groups(proof)
    sizes = [sum(len(M) - int(not nonzero(z - 1)) for M in Ms) for z, Ms in groups]
    if w["part"] == -1:
        require(not free and len(proof.declared) != sum(sizes), "the number of parameters is right")
        return
    k = whole(w["part"], 0, len(groups) - 1)
    z, matrices = groups[k]
    if proof.method.pair:
        require(free or vanishes(declared_groups(proof, sizes)[k]), "not covered: pairs that grow")
        different = [x for M in matrices for row in M for x in row]
    elif free and nonzero(z - 1):
        different = [x for row in matrices[0] for x in row]
    else:
        mine = [Fraction(0)] * sizes[k] if free else declared_groups(proof, sizes)[k]
        different = growth_gap(z, matrices[0], mine)
        if free and is_exact(matrices[0]) and rank(matrices[0]) != 1:
            return
    require(any(map(apart, different)), "the growth parameters are as declared")


# ------------------------------------------------ section 5: quadratic forms, symmetry, structure


def form_defects(method, G, D):
    """Return left - right of each identity, by name; D is a list, for pairs (D_P, D_Q)."""
    if not method.pair:
        m = method.parts["o"]
        B, E = star(m.B), diagonal(D)
        return {"V": minus(G, times(star(m.V), G, m.V)),
                "U": minus(times(E, m.U), times(B, G, m.V)),
                "A": minus(combine(times(E, m.A), times(star(m.A), E)), times(B, G, m.B)),
                "real": [[x - conj(x) for x in D]], "hermitian": minus(G, star(G))}  # fmt: skip
    q, p, (D_P, D_Q) = method.parts["f"], method.parts["k"], map(diagonal, D)
    return {"V": minus(times(star(q.V), G, p.V), G),
            "P": minus(times(D_P, p.U), times(star(q.B), G, p.V)),
            "Q": minus(times(D_Q, q.U), times(star(p.B), star(G), q.V)),
            "A": minus(combine(times(D_P, p.A), times(star(q.A), D_Q)), times(star(q.B), G, p.B)),
            "real": [[x - conj(x) for x in D[0] + D[1]]]}  # fmt: skip


def energy(method, G):
    """Return u^* G u, for pairs u^* G u^."""
    first, last = next(iter(method.parts)), list(method.parts)[-1]
    return dot([conj(x) for x in method.u(first)], apply(G, method.u(last)))


def given_form(method):
    """Return (G, D) of the file; D is None where it gives none."""
    G = method.form() if "G" in method.document else None
    names = ("D_P", "D_Q") if method.pair else ("D",)
    if method.kind == "pair-sweep":
        return G, None
    D = [method.list(key) for key in names if key in method.document]
    return G, (None if len(D) < len(names) else tuple(D) if method.pair else D[0])


def form(proof, w):
    """Rule form: G and D satisfy the identities; they are those of the file if it has some."""
    method, read = proof.method, proof.method.numbers
    keys(w, "G D_P D_Q" if method.pair else "G D")
    G = read.matrix(w["G"])
    D = (read.vector(w["D_P"]), read.vector(w["D_Q"])) if method.pair else read.vector(w["D"])
    own_G, own_D = given_form(method)
    if own_G is not None:
        equal(G, own_G, "the G of the file")
    if own_D is not None:
        equal(list(map(list, D)) if method.pair else D, list(own_D), "the D of the file")
    for name, defect in form_defects(method, G, D).items():
        require(vanishes(defect), f"the identity {name} of the form does not hold")
    if method.pair and not method.separable:
        equal(D[0], D[1], "D_P = D_Q")
    require(nonzero(energy(method, G)), "u^* G u is 0")


def entry_of(M, place):
    """Return the entry [i, j] of a matrix."""
    require(isinstance(place, list) and len(place) == 2, "an entry is [i, j]")
    return M[whole(place[0], 0, len(M) - 1)][whole(place[1], 0, len(M[0]) - 1)]


def given_form_fails(proof, w):
    """Rule given-form-fails: with the G (and D) of the file one identity does not hold."""
    keys(w, "identity", "entry")
    method, name = proof.method, w["identity"]
    G, D = given_form(method)
    require(G is not None, "the file gives no G")
    if name == "solution":
        require(vanishes(energy(method, G)), "u^* G u is not 0")
        return
    if D is None:  # D = B^* G u, the only D that the second identity times u allows
        m, last = method.parts, list(method.parts)[-1]
        D = apply(star(next(iter(m.values())).B), apply(G, method.u(last)))
        if method.pair:
            D = D, apply(star(m["k"].B), apply(star(G), method.u("f")))
    defects = form_defects(method, G, D)
    if method.pair and not method.separable:
        defects["shared"] = [less(*D)]
    require(name in defects, f"no identity is called {name!r}")
    require(apart(entry_of(defects[name], w.get("entry"))), f"the entry of {name} is 0")


def no_form(proof, w):
    """Rule no-form, for real methods: a combination of the identities is u^* G u."""
    keys(w, "lambda")
    method, parts = proof.method, proof.method.parts.values()
    require("G" not in method.document, "the file gives a form")
    entries = [x for m in parts for M in (m.A, m.U, m.B, m.V) for row in M for x in row]
    if any(conj(x) != x for x in entries):
        not_covered("no-form for complex methods")
    terms = []
    require(isinstance(w["lambda"], list) and len(w["lambda"]) <= 10_000, "lambda is a list")
    for term in w["lambda"]:
        keys(term, "identity entry part factor", where="term of lambda")
        require(term["part"] == "re" and term["identity"] in ("V", "U", "A", "P", "Q"), "a term")
        factor = method.numbers.number(term["factor"])
        require(conj(factor) == factor, "a factor is not real")
        terms.append((term["identity"], term["entry"], factor))
    for G, D in unit_forms(method):
        defects = form_defects(method, G, D)
        require(all(name in defects for name, _, _ in terms), "no such identity")
        value = total(factor * entry_of(defects[name], at) for name, at, factor in terms)
        require(vanishes(value - energy(method, G)), "lambda does not give u^* G u")


def unit_forms(method):
    """Yield (G, D) through a basis: each G with D = 0, then each D with G = 0."""
    m, *others = method.parts.values()
    rows, columns, zero = m.r, (others[0].r if others else m.r), Fraction(0)
    slopes = [len(x.B[0]) for x in method.parts.values()]
    none = tuple([zero] * n for n in slopes)
    for i, j in product(range(rows), range(columns)):
        if others or i <= j:
            G = [[zero] * columns for _ in range(rows)]
            G[i][j] = Fraction(1)
            if not others:
                G[j][i] = Fraction(1)
            yield G, none if others else none[0]
    G = [[zero] * columns for _ in range(rows)]
    shared = method.pair and not method.separable
    for at in range(slopes[0] if not others or shared else sum(slopes)):
        places = (at, at + slopes[0]) if shared else (at,)
        flat = [Fraction(int(k in places)) for k in range(sum(slopes))]
        yield G, (flat[: slopes[0]], flat[slopes[0] :]) if others else flat


def weights_of(method):
    """Return (b, A, b^, A^) of a method that carries one value; a single one twice."""
    for m in method.parts.values():
        require(m.r == 1 and m.V == [[1]] and m.U == [[1]] * len(m.U), "not one value carried")
    first, last = method.parts[min(method.parts)], method.parts[max(method.parts)]
    return first.B[0], first.A, last.B[0], last.A


def quadratic_defect(method, i, j):
    """Return b_i a^_ij + b^_j a_ji - b_i b^_j."""
    b, A, b_hat, A_hat = weights_of(method)
    i, j = whole(i, 0, len(b) - 1), whole(j, 0, len(b_hat) - 1)
    return dot((b[i], b_hat[j], -b[i]), (A_hat[i][j], A[j][i], b_hat[j]))


def quadratic(proof, w):
    """Rule quadratic (claim symplectic)."""
    keys(w, "")
    b, _, b_hat, _ = weights_of(proof.method)
    for i, j in product(range(len(b)), range(len(b_hat))):
        require(vanishes(quadratic_defect(proof.method, i, j)), f"the identity ({i}, {j})")
    if proof.method.pair and not proof.method.separable:
        equal(b, b_hat, "b = b^")


def not_quadratic(proof, w):
    """Rule not-quadratic."""
    if "several-values" in w:
        keys(w, "several-values")
        several = any(m.r > 1 for m in proof.method.parts.values())
        require(w["several-values"] is True and several, "one value is carried")
        return
    if "weight" in w:
        keys(w, "weight")
        b, _, b_hat, _ = weights_of(proof.method)
        i = whole(w["weight"], 0, len(b) - 1)
        shared = proof.method.pair and not proof.method.separable
        require(shared and apart(b[i] - b_hat[i]), "b and b^ agree there")
        return
    keys(w, "entry")
    require(isinstance(w["entry"], list) and len(w["entry"]) == 2, "an entry is [i, j]")
    require(apart(quadratic_defect(proof.method, *w["entry"])), "the identity holds there")


def permutation(p, n):
    """Return a 0-based involution of n places."""
    fine = isinstance(p, list) and all(type(x) is int for x in p) and sorted(p) == list(range(n))
    require(fine and all(p[x] == k for k, x in enumerate(p)), "P is no involution")
    return p


def symmetric(proof, w):
    """Rule symmetric: L and P exchange a step with its reversal."""
    method, read = proof.method, proof.method.numbers
    if method.pair:
        keys(w, "L L_hat P_Q P_P")
        L = {"f": read.matrix(w["L"]), "k": read.matrix(w["L_hat"])}
        slopes, places = {"f": w["P_P"], "k": w["P_Q"]}, {"f": w["P_Q"], "k": w["P_P"]}
        require(method.separable or w["P_Q"] == w["P_P"], "P_Q and P_P differ")
    else:
        keys(w, "L P")
        L, slopes, places = {"o": read.matrix(w["L"])}, {"o": w["P"]}, {"o": w["P"]}
    for c, m in method.parts.items():
        J, back = L[c], inverse_matrix(m.V)
        P, R = permutation(slopes[c], len(m.B[0])), permutation(places[c], len(m.A))
        equal(times(J, J), identity(m.r), "L^2 = I")
        equal(times(J, back, J), m.V, "L V^-1 L = V")
        equal([[row[x] for x in P] for row in times(m.V, J, m.B)], m.B, "B = V L B P")
        mirrored = times(m.U, J, m.V)
        equal([mirrored[x] for x in R], m.U, "U = P U L V")
        moved = [[m.A[x][y] for y in P] for x in R]
        equal(combine(m.A, moved), times(m.U, back, m.B), "A + P A P = U V^-1 B")
    proof.reversal = L


def involutions(method):
    """Return all P with A + P A P = U V^-1 B, by backtracking; separable pairs: Q, then P."""
    blocks, kinds = [], None
    for m in method.parts.values():
        blocks.append((m.A, times(m.U, inverse_matrix(m.V), m.B)))
    n = len(blocks[0][0])
    if method.separable:
        (A, M), (A_hat, M_hat) = blocks
        n_P = len(A_hat)
        kinds = [0] * n + [1] * n_P
        blocks = [(corners(A, A_hat), corners(M, M_hat))]
        n += n_P
    found, steps = [], 0

    def place(P):
        nonlocal steps
        steps += 1
        require(steps <= 100_000, "beyond the limits of this checker")
        k = next((i for i, x in enumerate(P) if x is None), None)
        if k is None:
            found.append(list(P))
            return
        for x in range(k, n):
            if P[x] is None and (kinds is None or kinds[x] == kinds[k]):
                P[k], P[x] = x, k
                if fits_all(P, k):
                    place(P)
                P[k] = P[x] = None

    def fits_all(P, k):
        known = [i for i, x in enumerate(P) if x is not None]
        pairs = [(i, j) for e in (k, P[k]) for o in known for i, j in ((e, o), (o, e))]
        return all(
            may_vanish(A[i][j] + A[P[i]][P[j]] - M[i][j]) for A, M in blocks for i, j in pairs
        )

    place([None] * n)
    return found


def may_vanish(x):
    """Tell whether a number is 0, or an interval that holds 0."""
    return x.lo <= 0 <= x.hi if type(x) is Interval else not x


def corners(M, N):
    """Return the matrix with M right above and N left below."""
    zero = Fraction(0)
    return [[zero] * len(M) + row for row in M] + [row + [zero] * len(M[0]) for row in N]


def not_symmetric(proof, w):
    """Rule not-symmetric."""
    method = proof.method
    if "singular" in w:
        keys(w, "singular", "which")
        m = method.part(w.get("which", "o"))
        x = method.numbers.vector(w["singular"])
        require(vanishes(apply(m.V, x)) and any(map(nonzero, x)), "V x = 0 with x not 0")
    elif "trace" in w:
        keys(w, "trace")
        m = method.single()
        M = times(m.U, inverse_matrix(m.V), m.B)
        gap = total(2 * m.A[i][i] - M[i][i] for i in range(len(M)))
        require(w["trace"] is True and nonzero(gap), "the traces agree")
    elif "stages" in w:
        keys(w, "stages")
        require(w["stages"] is True and not involutions(method), "a permutation of stages exists")
    else:
        keys(w, "values")
        refute_values(method, w["values"])


def refute_values(method, given):
    """Refuse unless the P listed are all there are and none has an L."""
    found = involutions(method)
    require(isinstance(given, list), "values are a list")
    for entry in given:
        keys(entry, "P", "functional square", "value")
    listed = [entry["P"] for entry in given]
    require(all(P in found for P in listed), "a P that is listed does not fit")
    require(all(P in listed for P in found) and len(found) == len(listed), "a P is not listed")
    for P in found:
        require(any(no_reversal(method, c, P) for c in method.parts), "an involution L exists")


def no_reversal(method, c, P):
    """Tell whether the linear conditions on L contradict or have one solution, no involution."""
    m, back = method.part(c), inverse_matrix(method.part(c).V)
    n_Q = len(method.parts["f"].A) if method.separable else 0
    Q_of, P_of = (P[:n_Q], [x - n_Q for x in P[n_Q:]]) if method.separable else (P, P)
    stages, slopes = (P_of, Q_of) if c == "k" else (Q_of, P_of)
    left, right, r = times(m.U, back), times(back, m.B), m.r
    rows, values = [], []

    def condition(coefficients, value):
        row = [Fraction(0)] * (r * r)
        for (i, j), x in coefficients:
            row[i * r + j] = row[i * r + j] + x
        rows.append(row)
        values.append(value)

    for s, j in product(range(len(m.U)), range(r)):  # U V^-1 = P U L
        condition([((k, j), m.U[stages[s]][k]) for k in range(r)], left[s][j])
    for i, s in product(range(r), range(len(m.B[0]))):  # V^-1 B = L B P
        condition([((i, k), m.B[k][slopes[s]]) for k in range(r)], right[i][s])
    for i, j in product(range(r), range(r)):  # V L = L V^-1
        condition([((k, j), m.V[i][k]) for k in range(r)]
                  + [((i, k), -back[k][j]) for k in range(r)], Fraction(0))  # fmt: skip
    x, unique = solve(rows, values)
    if x is None:
        return True
    L = [x[i * r : i * r + r] for i in range(r)]
    return unique and not vanishes(minus(times(L, L), identity(r)))


def needs(method, surely=False):
    """Return {stage: stages it needs}, exact zeros left out; or those that it surely needs."""

    def counts(x):
        return not is_nil(x) and (not surely or apart(x))

    if not method.separable:
        n = len(next(iter(method.parts.values())).A)
        return {i: {j for j in range(n)
                    if any(counts(m.A[i][j]) for m in method.parts.values())}
                for i in range(n)}  # fmt: skip
    q, p = method.parts["f"], method.parts["k"]
    both = (("Q", "P", q.A), ("P", "Q", p.A))
    return {f"{x}{i}": {f"{y}{j}" for j, entry in enumerate(row, 1) if counts(entry)}
            for x, y, A in both for i, row in enumerate(A, 1)}  # fmt: skip


def stage_names(needed, names):
    """Return 0-based stages; a list without 0 that holds the number of stages counts from 1."""
    fine = isinstance(names, list) and names and all(type(x) in (int, str) for x in names)
    require(fine, "stages are a list")
    if 0 not in names and len(needed) in names:
        names = [x - 1 for x in names if type(x) is int]
    require(all(x in needed for x in names), "no such stage")
    return names


def explicit(proof, w):
    """Rule explicit: each stage needs earlier ones only."""
    keys(w, "order")
    needed = needs(proof.method)
    order = stage_names(needed, w["order"])
    require(len(order) == len(needed) == len(set(order)), "the order is not one of all stages")
    for k, stage in enumerate(order):
        require(needed[stage] <= set(order[:k]), f"stage {stage} needs a later one")


def implicit(proof, w):
    """Rule implicit: a cycle of stages, each needing the next."""
    keys(w, "cycle")
    needed = needs(proof.method, surely=True)
    cycle = stage_names(needed, w["cycle"])
    for stage, after in zip(cycle, cycle[1:] + cycle[:1], strict=True):
        require(after in needed[stage], f"stage {stage} is not shown to need {after}")


def abscissae_of(proof, w):
    """Return c = A 1 + U v of each part, with v_k = 0 at the first k with u_k not 0."""
    require(not proof.method.pair, "the abscissae of pairs")
    u, v = consistent(proof, {key: w.get(key) for key in ("u", "v")})
    found = []
    for c, m in proof.method.parts.items():
        row = reading(proof.method, c, u[c])
        require(vanishes(dot(row, v[c])), "v is not 0 in what is read as the solution")
        sums = apply(m.A, ones(len(m.A)))
        found += [x + y for x, y in zip(sums, apply(m.U, v[c]), strict=True)]
    return found


def abscissae(proof, w):
    """Rule abscissae."""
    keys(w, "u v")
    equal(abscissae_of(proof, w), proof.claimed(proof.declared), "the list of abscissae")


def other_abscissae(proof, w):
    """Rule other-abscissae."""
    keys(w, "", "u v stage")
    given = proof.claimed(proof.declared)
    if not w.get("u"):  # the c of a method in the intervals, where it has one
        proof.method.single()
        bounds = proof.bounds(True, False, 1)
        bounds.fill()
        c = bounds.stages(("o", ()))
    else:
        c = abscissae_of(proof, w)
    for m in proof.method.parts.values():
        require(rank(minus(identity(m.r), m.V)) == m.r - 1, "the rank of I - V is not r - 1")
    if len(c) != len(given):
        require(w.get("stage") in (None, -1), "the lengths differ")
        return
    stage = whole(w.get("stage"), 0, len(c) - 1)
    require(apart(c[stage] - given[stage]), "the abscissa is as declared")


def error_constant(proof, w, same=True):
    """Rules error-constant and other-error-constant."""
    keys(w, "order")
    require(proof.method.kind in ("lmm", "one-leg"), "only multistep methods have one")
    p, (alpha, beta) = whole(w["order"], -1, 40), proof.method.multistep()
    C = []
    for q in range(p + 2):
        value = dot(alpha, [Fraction(m**q) for m in range(len(alpha))])
        if q:
            value = value - q * dot(beta, [Fraction(m ** (q - 1)) for m in range(len(beta))])
        C.append(value * Fraction(1, factorial(q)))
    require(vanishes(C[:-1]) and nonzero(C[-1]), "the order is another one")
    if not same and vanishes(total(beta)):
        return  # no error constant
    gap = C[-1] * inverse(total(beta)) - proof.claimed([proof.declared])[0]
    require(vanishes(gap) if same else nonzero(gap), "the error constant is (not) the declared one")


def reducible(proof, w):
    """Rule reducible: a value that is never reached or never seen."""
    side = "x" if "x" in w else "y"
    keys(w, f"component {side}")
    m, z = proof.method.part(w["component"]), proof.method.numbers.vector(w[side])
    require(any(map(nonzero, z)), f"{side} is 0")
    V, M = (transpose(m.V), transpose(m.B)) if side == "x" else (m.V, m.U)
    if side == "x":
        for u in proof.method.vectors_to_one(w["component"]):
            require(vanishes(dot(z, u)), "x u is not 0")
    for _ in range(m.r):
        require(vanishes(apply(M, z)), "a power does not vanish")
        z = apply(V, z)


def irreducible(proof, w):
    """Rule irreducible: every value of both components is reached and seen."""
    keys(w, "")
    for c, m in proof.method.parts.items():
        reached, seen = [*proof.method.vectors_to_one(c), *transpose(m.B)], list(m.U)
        for _ in range(m.r - 1):
            reached += [apply(m.V, x) for x in reached[-len(m.B[0]) :]]
            seen += times(seen[-len(m.U) :], m.V)
        require(rank(reached) == rank(seen) == m.r, f"component {c} can be reduced")


def equivalent(proof, w):
    """Rule equivalent: the method with the same A and these U, B, V makes the same steps.

    U V^k B agree for k < r + r'. The parts that follow are about this method.
    """
    keys(w, "U B V")
    m, read = proof.method.single(), proof.method.numbers
    U, B, V = (read.matrix(w[key]) for key in "UBV")
    other = copy(proof.method)
    other.parts = {"o": Component(m.A, U, B, V)}
    other.check_shapes()
    left, right = m.U, U
    for _ in range(m.r + len(V)):
        equal(times(left, m.B), times(right, B), "U V^k B")
        left, right = times(left, m.V), times(right, V)
    proof.method = other


# --------------------------------------------------------------- section 5: linear stability


def interpolate(nodes, values):
    """Return the polynomial with these values at the nodes (Newton)."""
    p, basis, rest = [], [Fraction(1)], list(values)
    for k, node in enumerate(nodes):
        p = plus(p, basis, rest[0])
        basis = multiply(basis, [-node, Fraction(1)])
        steps = [y - x for x, y in zip(nodes, nodes[k + 1 :], strict=False)]
        rest = [(b - a) * (1 / step) for (a, b), step in zip(pairwise(rest), steps, strict=True)]
    return p


class OnAxis(Ring):
    """A polynomial in z = i y with real coefficients; its conjugate has -z in the place of z."""

    __slots__ = ("p",)

    def __init__(self, p):
        self.p = trim(p)

    def __bool__(self):
        return bool(self.p)

    def __add__(self, other):
        return OnAxis(plus(self.p, other.p))

    def __mul__(self, other):
        return OnAxis(multiply(self.p, other.p if isinstance(other, OnAxis) else [other]))

    __rmul__ = __mul__

    def conj(self):
        """Return the conjugate."""
        return OnAxis([-c if k % 2 else c for k, c in enumerate(self.p)])


def stability(m):
    """Return det(I - z A), nodes z where it is not 0, and its values and M(z) there."""
    below, nodes, found, z = characteristic(m.A)[::-1], [], [], Fraction(0)
    while len(nodes) <= len(m.A):
        value = horner(below, z)
        if nonzero(value):
            back = inverse_matrix(minus(identity(len(m.A)), scale(z, m.A)))
            nodes.append(z)
            found.append((value, combine(m.V, scale(z, times(m.B, back, m.U)))))
        z += 1
    return below, nodes, found


def stability_polynomial(m):
    """Return P(w, z) = det(w I - M(z)) det(I - z A): for each power of w a polynomial in z."""
    _, nodes, found = stability(m)
    columns = transpose([multiples(value, characteristic(M)) for value, M in found])
    return [interpolate(nodes, column) for column in columns]


def poles(m):
    """Return det(I - z A) without what it shares with all entries of M(z) det(I - z A)."""
    below, nodes, found = stability(m)
    common = below = trim(below)
    for i, j in product(range(m.r), range(m.r)):
        entry = interpolate(nodes, [value * M[i][j] for value, M in found])
        common = gcd(common, entry) if entry else common
    return divide(below, common)[0]


def poles_lie_right(m):
    """Rule a-stable (2): all poles have Re z > 0."""
    d = poles(m)
    n, q = len(d) - 1, []
    for k, c in enumerate(d):  # z = (x + 1) / (x - 1): Re z > 0 is |x| > 1
        term = [c]
        for factor in [[Fraction(1), Fraction(1)]] * k + [[Fraction(-1), Fraction(1)]] * (n - k):
            term = multiply(term, factor)
        q = plus(q, term)
    backwards = (q + [Fraction(0)] * (n + 1 - len(q)))[::-1]
    return bool(backwards[-1]) and is_schur(backwards)  # a pole at z = -1 makes the last one 0


def at_infinity(P):
    """Return the coefficient of the highest power of z in P, a polynomial in w."""
    high = max(len(p) for p in P) - 1
    return trim([p[high] if len(p) > high else Fraction(0) for p in P])


def on_imaginary_axis(P):
    """Return the differences of Schur and Cohn of P(w, i y), None where Cohn's step fails."""
    real_ = all(conj(c) == c for p in P for c in p)
    require(real_, "not covered: linear stability of complex methods")
    found = list(margins(map(OnAxis, P)))
    # a difference is its own conjugate: even in i y
    return [
        x and [c * (-1) ** (k // 2) for k, c in enumerate(x.p)] for x in found if x or x is None
    ]


def real_roots(p):
    """Return the number of different real roots of p (Sturm)."""
    chain = [trim(p), derivative(trim(p))]
    while trim(chain[-1]):
        chain.append([-x for x in divide(chain[-2], chain[-1])[1]])
    ends = []
    for side in (-1, 1):
        signs = [sign(q[-1]) * side ** (len(q) - 1) for q in map(trim, chain) if q]
        ends.append(sum(a != b for a, b in pairwise(signs)))
    return ends[0] - ends[1]


def nowhere_negative(p):
    """Tell whether p(y) >= 0 for all real y: no real root of odd multiplicity, a positive end."""
    p = trim(p)
    if sign(p[-1]) < 0 or len(p) % 2 == 0:
        return False
    common = gcd(p, derivative(p))  # Yun: factors of multiplicity 1, 2, ..
    first, rest, k = divide(p, common)[0], common, 1
    while len(first) > 1:
        shared = gcd(first, rest)
        factor = divide(first, shared)[0]
        if k % 2 and len(factor) > 1 and real_roots(factor):
            return False
        first, rest, k = shared, divide(rest, shared)[0], k + 1
    return True


def no_root_but_zero(p):
    """Tell whether p has no real root other than 0."""
    while p and not p[0]:
        p = p[1:]
    return len(p) <= 1 or not real_roots(p)


def a_stable(proof, w):
    """Rule a-stable; `bounded` for V is another part."""
    keys(w, "")
    m = proof.method.single()
    require("o" in proof.stable, "bounded is not part of the certificate")
    P = stability_polynomial(m)
    require(poles_lie_right(m), "(2): a pole does not lie in Re z > 0")
    last = at_infinity(P)
    require(len(last) == m.r + 1 and in_disc(last), "(3): an eigenvalue at infinity")
    found = on_imaginary_axis(P)
    require(None not in found, "(4): a step of Cohn fails")
    require(all(map(nowhere_negative, found)), "(4): a difference is negative somewhere")
    if m.r > 1 and not all(map(no_root_but_zero, found)):
        not_covered("(5) by the discriminant")


def at_imaginary(m, y):
    """Return M(i y) of a real method as a real matrix of twice the size, i as [[0, -1], [1, 0]]."""

    def twice(M, real_part):
        require(all(conj(x) == x for row in M for x in row), "not covered: a complex method")
        zero = [[Fraction(0)] * len(M[0]) for _ in M]
        first, second = (M, zero) if real_part else (zero, scale(y, M))
        above = [[*a, *(-x for x in b)] for a, b in zip(first, second, strict=True)]
        return above + [[*b, *a] for a, b in zip(first, second, strict=True)]

    A, B = twice(m.A, False), twice(m.B, False)
    back = inverse_matrix(minus(identity(len(A)), A))
    return combine(twice(m.V, True), times(B, back, twice(m.U, True)))


def is_defective(M):
    """Tell whether the powers of M are not bounded: a root outside, or a defective one."""
    p = characteristic(M)
    if not in_disc(p):
        return True
    h, q = p, [Fraction(1)]
    while not h[0]:
        h = h[1:]
    inside = p[: len(p) - len(h)]  # the roots 0, which the mirror image has at infinity
    while len(h) > 1 and len(shared := gcd(h, mirror(h))) > 1:
        h, q = divide(h, shared)[0], multiply(q, shared)
    require(is_schur(h), "a root on the circle is left")
    return is_left(q, inside + h, M)


def not_a_stable(proof, w):
    """Rule not-a-stable."""
    require(isinstance(w, dict) and len(w) == 1, "one reason is given")
    ((reason, value),) = w.items()
    m = proof.method.single()
    if reason in ("y", "defect"):
        require(is_defective(at_imaginary(m, rational(value))), "M(i y) is power-bounded")
        return
    require(reason in ("infinity", "pole", "axis", "start") and value is True, "no such reason")
    if reason == "infinity":
        last = at_infinity(stability_polynomial(m))
        require(len(last) < m.r + 1 or not in_disc(last), "(3) holds")
    elif reason == "pole":
        require(not poles_lie_right(m), "(2) holds")
    elif reason == "axis":
        found = on_imaginary_axis(stability_polynomial(m))
        out = any(x is None or not nowhere_negative(x) for x in found)
        require(out, "no difference is negative")
    else:
        require("unbounded" in proof.rules, "unbounded is not part of the certificate")


def l_limit(proof, w, wanted=True):
    """Rules l-limit and not-l-limit."""
    keys(w, "")
    m = proof.method.single()
    last = at_infinity(stability_polynomial(m))
    zero = len(last) == m.r + 1 and vanishes(last[:-1])
    if not wanted and len(last) == m.r + 1:
        zero = not any(map(nonzero, last[:-1]))
    require(zero == wanted, "the limit is (not) a multiple of w^r")


# ------------------------------------------------ section 6: intervals, and numbers with gradients

PLACES = 448  # binary places of an interval


class Interval(Ring):
    """A closed interval of real numbers with ends that are whole multiples of 2^-PLACES.

    Its truth value says that it excludes 0; where that is not decided the answer is a refusal, so
    that the rules for exact numbers can be used with intervals and prove nothing wrong.
    """

    __slots__ = ("hi", "lo")

    def __init__(self, lo, hi):
        self.lo, self.hi = lo, hi

    @classmethod
    def of(cls, x):
        """Return an interval around a number."""
        return x if type(x) is Interval else around(x)

    @classmethod
    def ends(cls, lo, hi):
        """Return the interval between two rationals, rounded outward."""
        return cls((lo * 2**PLACES).__floor__(), (hi * 2**PLACES).__ceil__())

    def __bool__(self):
        require(not self.lo <= 0 <= self.hi, "an interval holds 0: nothing is decided")
        return True

    def __add__(self, other):
        if type(other) is not Interval:
            if isinstance(other, Gradient):
                return NotImplemented
            other = around(other)
        return Interval(self.lo + other.lo, self.hi + other.hi)

    __radd__ = __add__

    def __neg__(self):
        return Interval(-self.hi, -self.lo)

    def __mul__(self, other):
        a, b = self.lo, self.hi
        if type(other) is not Interval:
            if isinstance(other, Gradient):
                return NotImplemented
            if not isinstance(other, Element):
                n, d = other.numerator, other.denominator
                a, b = (a * n, b * n) if n >= 0 else (b * n, a * n)
                return Interval(a // d, -(-b // d))
            other = around(other)
        c, d = other.lo, other.hi
        ends = (a * c, a * d, b * c, b * d)
        return Interval(min(ends) >> PLACES, -(-max(ends) >> PLACES))

    __rmul__ = __mul__

    def __eq__(self, other):
        raise Refused("intervals are not compared")

    __hash__ = None


@cache
def around(x):
    """Return an interval around an exact number, which must be real."""
    if not isinstance(x, Element):
        return Interval.ends(Fraction(x), Fraction(x))
    require(conj(x) == x, "a number that must be real is not")
    return Interval(*enclose(x, PLACES).re)


def apart(x):
    """Tell whether a number is shown not to be 0; an interval around 0 is not."""
    return not x.lo <= 0 <= x.hi if type(x) is Interval else nonzero(x)


class Gradient(Ring):
    """An interval with its derivatives by the unknowns, exact zeros left out."""

    __slots__ = ("by", "value")

    def __init__(self, value, by):
        self.value, self.by = value, by

    def __add__(self, other):
        if not isinstance(other, Gradient):
            return Gradient(self.value + other, self.by)
        by = dict(self.by)
        for k, x in other.by.items():
            by[k] = by[k] + x if k in by else x
        return Gradient(self.value + other.value, by)

    def __mul__(self, other):
        if not isinstance(other, Gradient):
            return Gradient(self.value * other, {k: x * other for k, x in self.by.items()})
        by = {k: x * other.value for k, x in self.by.items()}
        for k, x in other.by.items():
            by[k] = by[k] + x * self.value if k in by else x * self.value
        return Gradient(self.value * other.value, by)

    __radd__, __rmul__ = __add__, __mul__


class Linear(Ring):
    """An expression c_0 + sum c_k x_k in the unknowns, with exact coefficients; never a number."""

    __slots__ = ("terms",)

    def __init__(self, terms):
        self.terms = terms

    @classmethod
    def made(cls, terms):
        """Return the expression, or the number that it is."""
        terms = {k: x for k, x in terms.items() if x}
        return cls(terms) if set(terms) - {None} else terms.get(None, Fraction(0))

    def __add__(self, other):
        terms = dict(self.terms)
        for k, x in other.terms.items() if isinstance(other, Linear) else ((None, other),):
            terms[k] = terms.get(k, Fraction(0)) + x
        return Linear.made(terms)

    def __mul__(self, other):
        require(not isinstance(other, Linear), "a product of two expressions in the unknowns")
        return Linear.made({k: x * other for k, x in self.terms.items()})

    __radd__, __rmul__ = __add__, __mul__

    def __eq__(self, other):
        return is_nil(self - other)

    __hash__ = None


def at_values(thing, values):
    """Return expressions, in lists or not, at values of the unknowns."""
    if isinstance(thing, list):
        return [at_values(x, values) for x in thing]
    if not isinstance(thing, Linear):
        return as_real(thing)
    value = Fraction(0)
    for k, x in thing.terms.items():
        value = value + (as_real(x) if k is None else values[k] * as_real(x))
    return value


def as_real(x):
    """Return numbers, in lists or not, with intervals in place of irrational exact ones."""
    if isinstance(x, list):
        return [as_real(y) for y in x]
    return around(x) if isinstance(x, Element) else x


def decimal_number(text):
    """Return the rational of a decimal such as -1.25e-3."""
    found = isinstance(text, str) and re.fullmatch(r"-?[0-9]+(\.[0-9]+)?(e-?[0-9]{1,3})?", text)
    require(found and len(text) <= DIGITS, f"{str(text)[:40]!r} is no decimal")
    return Fraction(text)


def only_root(function, published, digits, proof):
    """Return intervals around the one root of `function` near the published numbers (Krawczyk).

    The box X has the half-width `radius` around the published numbers, the centre lies in it, Y
    is the matrix `inverse`. The root must be published rounded to nearest.
    """
    n, radius = len(published), decimal_number(proof["radius"])
    require(n and 0 < radius <= Fraction(1, 10**60), "the radius")
    centre, rows = proof["centre"], proof["inverse"]
    require(isinstance(centre, list) and len(centre) == n, "the centre")
    require(isinstance(rows, list) and len(rows) == n, "the inverse")
    centre = [decimal_number(x) for x in centre]
    away = [abs(x - y) for x, y in zip(centre, published, strict=True)]
    require(max(away) < radius, "the centre lies outside the box")
    Y = []
    for row in rows:
        require(isinstance(row, list) and len(row) == n, "the inverse")
        Y.append([round(decimal_number(x) * 2**80) for x in row])
    unit = around(Fraction(1))
    box = [Gradient(Interval.ends(x - radius, x + radius), {k: unit})
           for k, x in enumerate(published)]  # fmt: skip
    at_centre = [Interval.of(x) for x in function([around(x) for x in centre])]
    over_box = function(box)
    require(len(at_centre) == len(over_box) == n, "there are not as many equations as unknowns")
    by = [x.by if isinstance(x, Gradient) else {} for x in over_box]
    columns = [[(i, row[j].lo + row[j].hi, row[j].hi - row[j].lo)
                for i, row in enumerate(by) if j in row] for j in range(n)]  # fmt: skip
    whole, news, slacks = 1 << (PLACES + 81), [], []
    for i, row in enumerate(Y):
        low = high = slack = 0
        for y, value in zip(row, at_centre, strict=True):
            ends = y * value.lo, y * value.hi
            low, high = low + min(ends), high + max(ends)
        news.append(Fraction(max(abs(low), abs(high)), 1 << (PLACES + 80)))
        for j, column in enumerate(columns):
            middle, spread = whole if i == j else 0, 0
            for k, twice, width in column:
                middle -= row[k] * twice
                spread += abs(row[k]) * width
            slack += abs(middle) + spread
        slacks.append(Fraction(slack, whole))
    reach, worst = radius + max(away), max(slacks)
    for d, step_, slack in zip(away, news, slacks, strict=True):
        require(d + step_ + slack * reach < radius, "the image does not lie inside the box")
    require(worst < 1, "the map is no contraction")
    error = max(news) / (1 - worst)
    half = Fraction(1, 2 * 10**digits)
    require(max(away) + error <= half, "the digits are not those of the root, rounded")
    return [Interval.ends(x - error, x + error) for x in centre]


# ------------------------------------------------ section 6: trees whose root moves, and classes

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


@cache
def reduced(t, q):
    """Return the class of a tree at stage order q, and its factor."""
    children, factor = [], Fraction(1)
    for child in t[1]:
        if 1 < size(child) <= q:
            children += [LEAF] * size(child)
            factor /= gamma(child)
        else:
            below, times_ = reduced(child, q)
            children.append(below)
            factor *= times_
    return (t[0], tuple(sorted(children))), factor


@cache
def classes(n, q):
    """Return the trees of an order that are their own class."""
    return [t for t in trees((("o", "o"),), n) if reduced(t, q)[0] == t]


@cache
def pairs_of(n, q):
    """Return the unordered pairs of classes of total order n."""
    return [(t, u) for m in range(1, n // 2 + 1) for i, t in enumerate(classes(m, q))
            for j, u in enumerate(classes(n - m, q)) if m < n - m or i <= j]  # fmt: skip


def spread_of(t, u, q):
    """Return the coefficients of x(t * u) + x(u * t) in the values of x at the classes."""
    row = {}
    for grown in (attach(t, u), attach(u, t)):
        below, factor = reduced(grown, q)
        row[below] = row.get(below, 0) + factor
    return row


class Span:
    """Independent rows of rationals, by name of the column."""

    def __init__(self):
        self.rows = {}

    def add(self, row):
        """Add a row; return whether it was independent of the others."""
        rest = {k: Fraction(x) for k, x in row.items() if x}
        while rest:
            lead = min(rest, key=repr)
            if lead not in self.rows:
                self.rows[lead] = {k: x / rest[lead] for k, x in rest.items()}
                return True
            factor = rest[lead]
            for k, x in self.rows[lead].items():
                rest[k] = rest.get(k, 0) - factor * x
            rest = {k: x for k, x in rest.items() if x}
        return False


@cache
def plan(n, q, free):
    """Return (pairs that define zeta_1 at an even order, pairs left over, inverse matrix)."""
    unknown, span, defining, left, rows = classes(n, q), Span(), [], [], []
    for pair in pairs_of(n, q):
        row = spread_of(*pair, q)
        (defining if span.add(row) else left).append(pair)
    for t, u in defining:
        row = spread_of(t, u, q)
        rows.append([row.get(x, Fraction(0)) for x in unknown])
    for t in free:
        below, factor = reduced(t, q)
        require(span.add({below: factor}), f"zeta_1({show(t)}) is not free")
        rows.append([factor if x == below else Fraction(0) for x in unknown])
    require(len(rows) == len(unknown), f"the free trees of order {n} are not all given")
    return defining, left, inverse_matrix([list(map(Fraction, row)) for row in rows])


def cut_classes(t, q):
    """Return {class: weight} of what is left when branches are cut, t itself included."""
    found = {}
    for s, weight in cut(t):
        below, factor = reduced(s, q)
        found[below] = found.get(below, 0) + weight * factor
    return found


def conditions_follow(n, q, given, free):
    """Tell whether R = 0 at the given trees of an odd order n gives R = 0 at all of them (6.3)."""
    if n == 1:
        return LEAF in given
    left, span, count = plan(n - 1, q, free.get(n - 1, ()))[1], Span(), 0
    for t, u in pairs_of(n, q):
        row = spread_of(t, u, q)
        for a, x in cut_classes(t, q).items():
            for b, y in cut_classes(u, q).items():
                at = (a, b) if (a, b) in left else (b, a)
                if size(a) + size(b) == n - 1 and at in left:
                    row[at] = row.get(at, 0) - x * y
        count += span.add(row)
    for t in given:
        if size(t) == n:
            count += span.add({reduced(t, q)[0]: 1})
    return count == len(classes(n, q)) + len(left)


# ------------------------------------------------ section 6: sweeps with an enclosure

EQUATION = re.compile(r"(order|growth|explicit|defect|abscissa|start|identity) ([^=]+?)"
                      r"(?: = (.+))?")  # fmt: skip


def palindrome(row):
    """Return 1 or -1 where a row is its own mirror image up to this sign, else None."""
    for s in (1, -1):
        if all(x == y * s for x, y in zip(row, reversed(row), strict=True)):
            return s
    return None


def eigenvector(M, z):
    """Return the eigenvector of a simple eigenvalue."""
    basis = kernel(minus(M, diagonal([z] * len(M))))
    require(len(basis) == 1, "an eigenvalue of an equation is not simple")
    return basis[0]


def parasitic_form(v, other, seen):
    """Return H, Re(seen seen^*) / v^* other: a growth parameter is sum d_i x_i^T H x_i."""
    norm = dot([conj(x) for x in v], other)
    require(nonzero(norm) and conj(norm) == norm, "v^* G v is 0 or not real")
    unit = inverse(norm)
    return [[as_real(real(a * conj(b)) * unit) for b in seen] for a in seen]


def parameter(H, weights, rows):
    """Return the growth parameter of weights d_i and columns x_i of the rows."""
    return total(d * dot(x, apply(H, x)) for d, x in zip(weights, transpose(rows), strict=True))


def circle_is_named(V, named):
    """Return how many eigenvalues of modulus 1 but 1 are named, where these and 1 are all."""
    found = []
    for z in named:
        for x in (z, conj(z)):
            if nonzero(x - 1) and all(nonzero(x - y) for y in found):
                found.append(x)
    simple = all(squared(z) == 1 and rank(minus(V, diagonal([z] * len(V)))) == len(V) - 1
                 for z in found)  # fmt: skip
    return len(found) if simple and len(found) == len(V) - 1 else None


class Enclosed:
    """What sweeps and pairs have in common: the document, its unknowns, and the root.

    `halves` has by colour the weights and the rows that stand beside them.
    """

    halves, explicit_now = {}, frozenset()

    def __init__(self, document, numbers, proof):
        self.document, self.proof = document, proof
        keys(proof, "radius centre inverse", "free trees", "proof of the method")
        block = document.get("enclosure")
        keys(block, "equations", "radius xi", "enclosure")
        require("starting" not in block, "enclosure")
        self.unknowns = list(as_object(document.get("unknowns", {})))
        require(0 < len(self.unknowns) <= SIZE, "the unknowns")
        require(
            block.get("radius", "1e-60") == proof["radius"], "the radius is not that of the file"
        )
        self.digits = whole(document.get("digits", 75), 20, 400)
        symbols = {name: Linear({k: Fraction(1)}) for k, name in enumerate(self.unknowns)}
        self.numbers = numbers.changed(unknowns=symbols)
        self.exact = numbers
        self.texts = block["equations"]
        require(isinstance(self.texts, list) and len(self.texts) == len(self.unknowns), "equations")
        self.xi = {read_tree(t): self.numbers.parser(x, document).value
                   for t, x in as_object(block.get("xi", {})).items()}  # fmt: skip
        self.prepare()
        published = [published_decimal(document["unknowns"][x], self.digits) for x in self.unknowns]
        self.root = only_root(self.residuals, published, self.digits, proof)

    def matrix(self, key):
        """Return a matrix of the document, in the unknowns; a form may be its diagonal."""
        read = self.numbers.form if key == "G" else self.numbers.matrix
        return read(self.document[key], self.document)

    def number(self, text):
        """Return an exact number in the text of an equation."""
        return self.exact.parser(text, {}).value

    def at(self, values):
        """Return the method at values of the unknowns."""
        values = dict(zip(self.unknowns, values, strict=True))
        return Method(
            self.document, self.exact.changed(unknowns=values, explicit=self.explicit_now)
        )

    def suppose(self, names):
        """Read G and the V of these names, by colour; check what the theorems suppose of them."""
        self.V = {c: self.matrix(name) for c, name in names.items()}
        self.G = self.matrix("G")
        for M in (self.G, *self.V.values()):
            fixed = not any(isinstance(x, Linear) for row in M for x in row)
            require(fixed and all(conj(x) == x for row in M for x in row), "V or G is not real")
        self.first, self.last = self.V[min(names)], self.V[max(names)]
        equal(times(transpose(self.first), self.G, self.last), self.G, "V^T G V = G")
        for M in (self.G, *self.V.values()):
            border = [M[0][0] - 1, *M[0][1:], *(row[0] for row in M[1:])]
            require(vanishes(border), "the first row and column of V or G are not 1, 0, .., 0")

    def find_signs(self):
        """Return the diagonals of E by colour, after the checks of theorem 3, or None."""
        found = {c: [palindrome(row) for row in X] for c, (_, X) in self.halves.items()}
        mirrored = all(palindrome(weights) == 1 for weights, _ in self.halves.values())
        if not mirrored or any(None in x for x in found.values()):
            return None
        E = {c: diagonal([Fraction(x) for x in signs]) for c, signs in found.items()}
        pairs = [(times(E[min(E)], self.G, E[max(E)]), self.G)]
        pairs += [(times(E[c], inverse_matrix(V), E[c]), V) for c, V in self.V.items()]
        return found if all(vanishes(minus(M, N)) for M, N in pairs) else None

    def reversal(self):
        """Return L = V^-1 E of each component."""
        require(self.signs is not None, "the method is not symmetric")
        return {c: times(inverse_matrix(V), diagonal([Fraction(x) for x in self.signs[c]]))
                for c, V in self.V.items()}  # fmt: skip

    def growth_form(self, text, colour):
        """Return (colour, z, H): the growth parameter of z is sum d_i x_i^T H x_i."""
        z = self.number(text)
        v, w = eigenvector(self.first, z), eigenvector(self.last, z)
        seen = apply(self.G, w) if colour == min(self.V) else apply(transpose(self.G), v)
        return colour, z, parasitic_form(v, apply(self.G, w), seen)

    def zero_growths(self):
        """Return how many growth parameters there are, all 0, or None."""
        named = [e[2] for e in self.equations if e[0] == "growth"]
        counts = {circle_is_named(V, [z for half, z, _ in named if half == c])
                  for c, V in self.V.items()}  # fmt: skip
        return counts.pop() * len(self.V) if len(counts) == 1 and None not in counts else None


def published_decimal(text, digits):
    """Return the rational of an unknown that is given with this many places."""
    found = isinstance(text, str) and re.fullmatch(r"-?[0-9]+\.([0-9]+)", text)
    require(found and len(found[1]) == digits, "an unknown has another number of places")
    return Fraction(text)


class Sweep(Enclosed):
    """A file of class sweep with an enclosure: equations, theorems 1 to 3 of 6.2 and 6.3."""

    def prepare(self):
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
        self.free = {int(n): tuple(read_tree(t) for t in ts) for n, ts in given.items()}
        for n, ts in self.free.items():
            require(all(size(t) == n for t in ts), "a free tree has another order")
        require(all(t in self.free.get(size(t), ()) for t in self.xi), "a tree of xi is not free")
        self.explicit = {i for kind, i, *_ in self.equations if kind == "explicit"}
        self.explicit |= {self.s - 1 - i for i in self.explicit}
        self.order = max((size(e[2]) + (e[0] != "order") for e in self.equations
                          if e[0] in ("order", "identity", "defect")), default=2)  # fmt: skip

    def read(self, text):
        """Return an equation (kind, stage or value, tree or number)."""
        found = isinstance(text, str) and EQUATION.fullmatch(text)
        require(found, f"{str(text)[:40]!r} is no equation")
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

    def find_stage_order(self):
        """Return the stage order that the equations `defect` give."""
        have, q = {(i, t) for kind, i, t in self.equations if kind == "defect"}, 1
        while True:
            tree = ("o", (LEAF,) * q)
            half = self.s // 2 if (q + 1) % 2 else (self.s + 1) // 2
            if self.signs is None or any((i, tree) not in have for i in range(half)):
                return q
            q += 1

    def series(self, values, order):
        """Return the series by classes, with eta below the order (6.2)."""
        found = ByClasses(self, values)
        found.advance(order)
        return found

    def residuals(self, values):
        """Return left minus right of every equation."""
        series, found = self.series(values, self.order), []
        for kind, i, what in self.equations:
            if kind == "order":
                found.append(series.condition(what))
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

    def starts_at_two(self):
        """Tell whether equations `start K` give zeta(o) = 0 (6.3)."""
        if self.r == 1:
            return True
        L = self.reversal()["o"]
        basis = kernel([row[1:] for row in combine(L, identity(self.r))])
        values = [i for kind, i, t in self.equations if kind == "start" and t == LEAF]
        return len(basis) == 1 and any(k and nonzero(basis[0][k - 1]) for k in values)

    def abscissae(self):
        """Return the abscissae that the file fixes exactly, or None."""
        c = {}
        for kind, i, value in self.equations:
            if kind == "abscissa":
                c[i] = value
            elif kind == "explicit" and i == 0 and self.starts_at_two():
                c[0] = Fraction(0)
        for i, x in list(c.items()):
            c.setdefault(self.s - 1 - i, 1 - x)
        if self.s % 2:
            c.setdefault(self.s // 2, Fraction(1, 2))
        return [c[i] for i in range(self.s)] if len(c) == self.s else None

    def quadrature(self, power):
        """Tell whether sum d_i c_i^power = 1 / (power + 1) for all values of the unknowns."""
        c = self.abscissae()
        if c is None:
            return False
        return is_nil(total(d * x**power for d, x in zip(self.D, c, strict=True))
                      - Fraction(1, power + 1))  # fmt: skip

    def given_trees(self):
        """Return the trees whose conditions the file gives (6.3)."""
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

    def order_holds(self, p, identity_mode, nystrom):
        """Refuse unless the equations give order p."""
        require(not nystrom and self.signs is not None, "the method is not symmetric")
        given = self.given_trees()
        for n in range(1, p + 1, 2):
            require(conditions_follow(n, self.q, given, self.free), f"the conditions of order {n}")
        if identity_mode and p > 1:
            eta = self.series(self.root, p).eta
            require(all(is_nil(x[0]) for x in eta.values()), "a principal part may not be 0")

    def implies(self, claim):
        """Tell whether a claim that is true or false holds at the root."""
        if claim == "consistent":
            return LEAF in self.given_trees()
        if claim in ("preconsistent", "g-symplectic"):
            return True
        if claim == "symplectic":
            return self.r == 1
        return claim == "symmetric" and self.signs is not None

    def stage_order_holds(self, q, p):
        """Refuse unless every stage has order q."""
        require(1 <= q <= min(self.q, p), "the stages are not given")


# ------------------------------------------------ section 6: Runge-Kutta methods with an enclosure

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


# ------------------------------------------------ section 6: pairs with an enclosure

PAIR_EQUATION = re.compile(r"order (\S+)|growth ([qp]) (.+)|start (\S+) ([1-9][0-9]?)")
ALTERNATING = (("f", "k"), ("k", "f"))


@cache
def second_order(t):
    """Tell whether every vertex f of the free tree has two neighbours or fewer."""
    return len(t[1]) <= (2 if t[0] == "f" else size(t)) and all(map(is_nystrom, t[1]))


@cache
def listed(n, nystrom):
    """Return all alternating trees of an order, or those of second-order systems."""
    return [t for t in trees(ALTERNATING, n) if not nystrom or second_order(t)]


class Pair(Enclosed):
    """A file of class pair-sweep or splitting with an enclosure (6.4)."""

    def prepare(self):
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
            letters = doc["stages"]
            X += self.matrix("w") if doc["w"] else []
            Y += self.matrix("v") if doc["v"] else []
        self.halves = {"f": (self.b, X), "k": (self.c, Y)}
        require(isinstance(letters, str) and set(letters) <= {"P", "Q"}, "the stages")
        require(letters.count("P") == len(self.b) and letters.count("Q") == len(self.c), "stages")
        self.letters = letters
        self.word = [
            ("f" if x == "P" else "k", letters[:n].count(x)) for n, x in enumerate(letters)
        ]
        self.one_step = len(self.first) == len(self.last) == 1
        require(not self.xi and "free" not in self.proof, "pairs have zeta_1 = 0")
        require(self.proof.get("trees", "all") in ("all", "nystrom"), "trees")
        self.nystrom = self.proof.get("trees") == "nystrom"
        self.equations = [self.read(text) for text in self.texts]
        self.order = max((size(e[1]) + (e[0] == "start") for e in self.equations
                          if e[0] != "growth"), default=1)  # fmt: skip
        self.signs = self.find_signs() if letters == letters[::-1] else None
        require(self.identity_through(self.order - 1, self.nystrom), "a principal part is not 0")

    def read(self, text):
        """Return an equation: (order, tree), (growth, -, form) or (start, tree, value)."""
        found = isinstance(text, str) and PAIR_EQUATION.fullmatch(text)
        require(found, f"{str(text)[:40]!r} is no equation")
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

    def series(self, values, order, nystrom):
        """Return the series with principal parts 0, with eta below the order."""
        found = AlongWord(self, values, nystrom)
        found.advance(order)
        return found

    def residuals(self, values):
        """Return left minus right of every equation."""
        series, found = self.series(values, self.order, self.nystrom), []
        for kind, tree, *what in self.equations:
            if kind == "order":
                found.append(series.condition(tree))
            elif kind == "start":
                found.append(series.eta[tree][what[0]])
            else:
                half, _, H = what[0]
                found.append(parameter(H, *(at_values(x, values) for x in self.halves[half])))
        return found

    def is_zero_start(self, t, k, L):
        """Tell whether zeta_k(t) = 0 by an equation `start` or by parity."""
        if ("start", t, k) in self.equations:
            return True
        off = any(nonzero(x) for j, x in enumerate(L[t[0]][k]) if j != k)
        return not off and L[t[0]][k][k] == (-1) ** (size(t) + 1)

    def identity_through(self, n, nystrom):
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
                   if nonzero(self.G[k][l]))  # fmt: skip

    def flow(self):
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

    def covered(self, n, nystrom):
        """Tell whether the equations give all conditions of order n."""
        given = {e[1] for e in self.equations if e[0] == "order"}
        if n == 1:
            for root, weights in (("f", self.b), ("k", self.c)):
                if is_nil(total(weights) - 1):
                    given.add((root, ()))
        kind = self.flow()
        table = {versions(t) for t in listed(n, nystrom)}
        if kind is None:
            return all(any(t in given for t in free) for free in table)
        every, chosen = Span(), Span()
        for free in table:
            row = dict(enumerate(lie_images(min(free), kind)))
            every.add(row)
            if any(t in given for t in free):
                chosen.add(row)
        return len(chosen.rows) == len(every.rows)

    def order_holds(self, p, identity_mode, nystrom):
        """Refuse unless the equations give order p."""
        require(self.signs is not None or self.one_step, "the pair is not symmetric")
        require(self.identity_through(p - 1, nystrom), "a principal part is not shown to be 0")
        for n in range(1, p + 1, 2 if self.signs is not None else 1):
            require(self.covered(n, nystrom), f"the conditions of order {n}")

    def implies(self, claim):
        """Tell whether a claim that is true or false holds at the root."""
        if claim in ("g-symplectic", "symplectic"):
            weights = at_values(self.b, self.root) + at_values(self.c, self.root)
            require(all(map(apart, weights)), "a weight may be 0")
            return claim == "g-symplectic" or self.one_step
        if claim == "consistent":
            return self.covered(1, False)
        return claim == "preconsistent" or (claim == "symmetric" and self.signs is not None)

    def zero_start_holds(self, q, nystrom):
        """Refuse unless every value but the first is 0 on all trees through order q."""
        if self.one_step:
            return
        require(self.signs is not None, "the pair is not symmetric")
        L = self.reversal()
        fine = all(self.is_zero_start(t, k, L) for n in range(1, q + 1)
                   for t in listed(n, nystrom) for k in range(1, len(L[t[0]])))  # fmt: skip
        require(fine, "a value is not shown to start with 0")


@cache
def colour_words(t):
    """Return {colours of the vertices, children before parents: number of ways}."""
    found = {"": 1}
    for child in t[1]:
        more = {}
        for (x, m), (y, n) in product(found.items(), colour_words(child).items()):
            for word, count in shuffles(x, y).items():
                more[word] = more.get(word, 0) + m * n * count
        found = more
    return {word + t[0]: n for word, n in found.items()}


@cache
def shuffles(x, y):
    """Return the shuffles of two words, counted."""
    if not x or not y:
        return {x + y: 1}
    found = {}
    for rest, last in ((shuffles(x[:-1], y), x[-1]), (shuffles(x, y[:-1]), y[-1])):
        for word, n in rest.items():
            found[word + last] = found.get(word + last, 0) + n
    return found


def word_product(x, y, degree):
    """Return x y in the free algebra, through a degree."""
    found = {}
    for (u, a), (v, b) in product(x.items(), y.items()):
        if len(u) + len(v) <= degree:
            found[u + v] = found.get(u + v, 0) + a * b
    return {w: a for w, a in found.items() if a}


def word_sum(x, y, factor=1):
    """Return x + factor y."""
    found = dict(x)
    for w, a in y.items():
        found[w] = found.get(w, 0) + factor * a
    return {w: a for w, a in found.items() if a}


@cache
def verlet_logarithm(degree, outer):
    """Return log(exp(X/2) exp(Y) exp(X/2)) through a degree, X the letter `outer`."""

    def exponential(letter, scale_):
        return {letter * n: scale_**n / factorial(n) for n in range(degree + 1)}

    half = exponential(outer, Fraction(1, 2))
    whole_ = exponential("k" if outer == "f" else "f", Fraction(1))
    step_ = word_product(word_product(half, whole_, degree), half, degree)
    step_.pop("")
    value, power = {}, {"": Fraction(1)}
    for n in range(1, degree + 1):
        power = word_product(power, step_, degree)
        value = word_sum(value, power, Fraction((-1) ** (n + 1), n))
    return value


@cache
def lie_elements(n, kind):
    """Return elements that span degree n of the Lie algebra of a kind of method (6.4).

    All brackets [letter, element] of smaller degree: the right-nested ones span.
    """
    if kind == "splitting":
        letters = {1: [{"f": Fraction(1)}, {"k": Fraction(1)}]}
    else:
        log = verlet_logarithm(n, kind)
        letters = {m: [{w: a for w, a in log.items() if len(w) == m}] for m in range(1, n + 1, 2)}
    found, span = [], Span()
    for x in letters.get(n, []):
        if span.add(x):
            found.append(x)
    for m, some in letters.items():
        for x, y in product(some, lie_elements(n - m, kind) if m < n else ()):
            z = word_sum(word_product(x, y, n), word_product(y, x, n), -1)
            if span.add(z):
                found.append(z)
    return found


@cache
def lie_images(t, kind):
    """Return the residual of a tree for each element of the Lie algebra."""
    words = colour_words(t)
    return [sum((n * x.get(w, 0) for w, n in words.items()), Fraction(0))
            for x in lie_elements(size(t), kind)]  # fmt: skip


# ------------------------------------------------ section 6: starts and finishes in decimals


class Block:
    """A start or finish whose decimals are unknowns; equal decimals are one unknown."""

    def __init__(self, numbers):
        self.unknowns, self.numbers = {}, numbers.changed(decimal=self.unknown, unknowns={})

    def unknown(self, text):
        """Return the unknown that a decimal stands for."""
        require(len(text.partition(".")[2]) >= 20, "a decimal of a start has few places")
        return Linear({self.unknowns.setdefault(text, len(self.unknowns)): Fraction(1)})

    def matrix(self, rows):
        """Return the entries, expressions in the unknowns."""
        return self.numbers.matrix(rows, {"digits": 75})

    def root(self, function, digits, proof):
        """Return intervals around the one root."""
        for text in self.unknowns:
            published_decimal(text, digits)
        return only_root(function, [Fraction(x) for x in self.unknowns], digits, proof)


def partner(i):
    """Return the stage that h -> -h exchanges with stage i: 0 alone, then (1, 2), (3, 4), .."""
    return 0 if i == 0 else i + 1 if i % 2 else i - 1


def opposite(rows, images):
    """Refuse unless entry [i][partner j] of rows is minus entry [i][j] of images."""
    for row, image in zip(rows, images, strict=True):
        require(len(row) % 2 == 1, "a start with parity has an odd number of stages")
        fine = all(is_nil(row[partner(j)] + x) for j, x in enumerate(image))
        require(fine, "the stages have no parity")


def stage_series(A, q, base=None):
    """Return the series of Y_i = S + h sum A_ij f(Y_j) by classes, S with the series `base`."""
    U = [[Fraction(1)] if base else []] * len(A)
    found = Series({"o": Component(A, U, None, None)}.__getitem__, None,
                   lambda t: [base(t)] if base else [])  # fmt: skip
    found.q = q
    return found


def simplifies(A, most):
    """Return the largest q <= most with A c^(k-1) = c^k / k for k = 2..q, c = A 1."""
    c, q = [total(row) for row in A], 1
    while q < most and vanishes([x - y**(q + 1) * Fraction(1, q + 1) for x, y in
                                 zip(apply(A, [y**q for y in c]), c, strict=True)]):  # fmt: skip
        q += 1
    return q


def parts_of(L):
    """Return the rows f with f L = f or f L = -f, with the sign; e_1 comes first."""
    found = []
    for s in (1, -1):
        found += [(f, s) for f in kernel(minus(transpose(L), diagonal([Fraction(s)] * len(L))))]
    first = [x for x in found if nonzero(x[0][0])]
    fine = len(found) == len(L) and len(first) == 1 and vanishes(first[0][0][1:])
    require(fine and first[0][1] == 1, "L does not keep the first value apart")
    return first + [x for x in found if x is not first[0]]


def labels_of(proof, wanted):
    """Return the conditions in the order of the certificate, which must be all that are wanted."""
    given = proof["conditions"]
    require(isinstance(given, list), "the conditions")
    found = []
    for entry in given:
        require(isinstance(entry, list) and len(entry) == 2, "a condition")
        found.append((whole(entry[0], 0, SIZE), read_tree(entry[1])))
    require(len(set(found)) == len(found) and set(found) <= set(wanted), "a condition is twice")
    return found


def first_is_solution(numbers, texts, r):
    """Refuse a start whose multiples of y are not 1, 0, .., 0."""
    require(numbers.vector(texts) == [Fraction(int(k == 0)) for k in range(r)], "u of the start")


def start_with_parity(proof, numbers, document, series, L, order, q_most):
    """Return (block, root, rows) of the start; `series` gives zeta(t) for any tree (6.7)."""
    keys(proof, "radius centre inverse conditions", where="proof of the start")
    table, block, r = document["starting"], Block(numbers), len(L)
    keys(table, "A B u", "name kind order", "start")
    first_is_solution(numbers, table["u"], r)
    A, B = block.matrix(table["A"]), block.matrix(table["B"])
    n = len(A)
    require(len(A[0]) == len(B[0]) == n and len(B) == r, "shapes of the start")
    opposite(A, [A[partner(i)] for i in range(n)])
    images = [[dot(row, [b[j] for b in B]) for j in range(n)] for row in L]
    opposite(B, images)
    known = not any(isinstance(x, Linear) for row in A for x in row)
    q = simplifies(A, q_most) if known else 1
    rows = [(as_real(f), s) for f, s in parts_of(L)]
    wanted = [(k, t) for k, (_, s) in enumerate(rows) for m in range(1, order + (k > 0))
              if (m % 2 == 0) == (s > 0) for t in classes(m, q)]  # fmt: skip
    labels = labels_of(proof, wanted)
    fixed = stage_series(as_real(A), q) if known else None

    def gaps(labels, values):
        stages = fixed or stage_series(at_values(A, values), q)
        weights = at_values(B, values)
        return [dot(rows[k][0], less(apply(weights, stages.derivative(t)), series(t)))
                for k, t in labels]  # fmt: skip

    left = [x for x in wanted if x not in set(labels)]
    require(all(k == 0 for k, _ in left), "a condition is missing")
    digits = whole(document.get("digits", 75), 20, 400)
    root = block.root(lambda values: gaps(labels, values), digits, proof)
    require(all(map(is_nil, gaps(left, root))), "a condition is missing")
    return block, at_values(A, root), at_values(B, root)


def undoes(numbers, opening, closing):
    """Tell whether the finish undoes the first value of the start for all values of the digits."""
    block = Block(numbers)
    A, b = block.matrix(opening["A"]), block.matrix(opening["B"])[0]
    C, d = block.matrix(closing["A"]), block.matrix([closing["b"]])[0]
    needed = {j for j, x in enumerate(b) if not is_nil(x)}
    while True:
        more = {j for i in needed for j, x in enumerate(A[i]) if not is_nil(x)} | needed
        if more == needed:
            break
        needed = more
    stages = sorted(needed)
    if len(C) != len(stages):
        return False
    return all(is_nil(y + b[j]) for y, j in zip(d, stages, strict=True)) and all(
        is_nil(C[k][m] - (A[i][j] - b[j]))
        for k, i in enumerate(stages) for m, j in enumerate(stages))  # fmt: skip


def finish_with_parity(proof, numbers, document, A, b, order):
    """Refuse unless the finish has the order, after the start with stages A and weights b."""
    keys(proof, "radius centre inverse conditions", where="proof of the finish")
    closing, block, first = document["finishing"], Block(numbers), stage_series(A, 1)
    C, d = block.matrix(closing["A"]), block.matrix([closing["b"]])[0]
    require(len(C) == len(C[0]) == len(d), "shapes of the finish")
    opposite(C, [C[partner(i)] for i in range(len(C))])
    opposite([d], [d])
    wanted = [(0, t) for m in range(2, order + 1, 2) for t in classes(m, 1)]
    labels = labels_of(proof, wanted)
    require(len(labels) == len(wanted), "a condition is missing")
    base = cache(lambda t: dot(b, first.derivative(t)))

    def function(values):
        stages, weights = stage_series(at_values(C, values), 1, base), at_values(d, values)
        return [dot(weights, stages.derivative(t)) + base(t) for _, t in labels]

    block.root(function, whole(document.get("digits", 75), 20, 400), proof)


def even_start(proof, pair, numbers, document):
    """Return the orders (all trees, second-order systems) of the start of a pair (6.7)."""
    keys(proof, "radius centre inverse conditions orders", where="proof of the start")
    orders = proof["orders"]
    require(isinstance(orders, list) and len(orders) == 2, "orders")
    most, nystrom = (whole(x, 0, 12) for x in orders)
    require(pair.signs is not None, "the pair is not symmetric")
    for c, V in pair.V.items():
        equal(V, diagonal([Fraction(x) for x in pair.signs[c]]), "L = I")
    zeta = {}
    for order, kind in ((most, False), (nystrom, True)):
        if order:
            require(pair.identity_through(order - 1, kind), "a principal part is not shown to be 0")
            series = pair.series(pair.root, order, kind)
            series.fill()
            zeta.update(series.eta)
    table, block = document["starting"], Block(numbers)
    keys(table, "A B u A_hat B_hat u_hat", "name kind order", "start")
    tables = {}
    for c, hat in (("f", ""), ("k", "_hat")):
        first_is_solution(numbers, table["u" + hat], len(pair.V[c]))
        tables[c] = block.matrix(table["A" + hat]), block.matrix(table["B" + hat])
    sizes = {"f": len(tables["f"][0]), "k": len(tables["k"][0])}
    for c, other in (("f", "k"), ("k", "f")):
        A, B = tables[c]
        require(len(A[0]) == len(B[0]) == sizes[other] and len(B) == len(pair.V[c]), "shapes")
        require(all(map(is_nil, A[0] + B[0])), "the first stage and value are the solution")
        opposite(A, [A[partner(i)] for i in range(len(A))])
        opposite(B, B)
    wanted = [(k, t) for n in range(2, max(orders) + 1, 2) for t in trees(ALTERNATING, n)
              if n <= most or (n <= nystrom and is_nystrom(t))
              for k in range(1, len(pair.V[t[0]]))]  # fmt: skip
    labels = labels_of(proof, wanted)
    require(len(labels) == len(wanted), "a condition is missing")

    def function(values):
        start = Series.of_tables({c: at_values(list(x), values) for c, x in tables.items()})
        return [start.value(t)[k] - zeta[t][k] for k, t in labels]

    block.root(function, whole(document.get("digits", 75), 20, 400), proof)
    return most, max(most, nystrom)


# ------------------------------------------------ section 6: upper bounds from intervals


class Bounds(Series):
    """Intervals around the only starting series that a higher order would allow (6.6)."""

    def __init__(self, method, identity_mode, nystrom):
        self.method, self.free, self.nystrom = method, not identity_mode, nystrom
        self.W, self.lift, self.eta, self.k, parts = {}, {}, {}, {}, {}
        super().__init__(parts.__getitem__, {}, self.cut_value)
        for c, m in method.parts.items():
            exact_ = all(not isinstance(x, Interval) for row in m.V for x in row)
            require(exact_, "V holds decimals")
            (u,) = kernel(minus(m.V, identity(m.r))) or [None]
            k = first_place(u)
            left = kernel(minus(transpose(m.V), identity(m.r)))
            seen = sorted((x for x in apply(m.U, u) if apart(x)), key=lambda x: type(x) is Interval)
            scale_ = next(iter(seen), None)  # of order 1 is only a method with U u = 1
            require(len(left) == 1 and scale_ is not None, "the eigenvalue 1 is not simple")
            u = [inverse(scale_) * x for x in u]
            along = dot(left[0], u)
            require(nonzero(along), "the eigenvalue 1 is defective")
            w = reading(method, c, u)
            border = [[x * y for y in w] for x in u]
            back = inverse_matrix(combine(minus(identity(m.r), m.V), border))
            self.u[c], self.k[c] = [as_real(x) for x in u], None if c in method.declared else k
            self.W[c] = [as_real(x * inverse(along)) for x in left[0]]
            self.lift[c] = as_real(back)
            parts[c] = Component(*map(as_real, m[:3]), None)
        self.order = 0

    def cut_value(self, s):
        """Return eta at what is left of a tree, 0 at one that does not count where r = 1."""
        if s not in self.eta and self.method.kind == "rosenbrock":
            return [Fraction(0)]  # the one value is the solution
        return self.eta[s]

    def move(self, s, beta):
        """Add beta u to eta(s)."""
        self.eta[s] = [x + beta * u for x, u in zip(self.eta[s], self.u[s[0]], strict=True)]

    def settle(self):
        """Find the principal parts of the last order."""
        n, palette = self.order + 1, dict(self.method.palette)
        if n == 2:
            first, *others = trees(self.method.palette, 1)
            for s in others:
                self.move(s, dot(self.W[s[0]], self.residual((s[0], (first,)))))
            return
        found = {}
        leaf = {c: (children[0], ()) for c, children in palette.items()}
        level = pool_of(self.method, n - 1, self.nystrom)
        for s in sorted(level, key=lambda s: (-len(s[1]), -s[1].count(leaf[s[0]]))):
            t = (s[0], tuple(sorted((*s[1], leaf[s[0]]))))
            value, ways = dot(self.W[t[0]], self.residual(t)), 0
            for kept, weight in cut(t):
                if kept == s:
                    ways = weight
                elif kept in found:
                    value = value - found[kept] * weight
            found[s] = value * (1 / ways)
        for s, beta in found.items():
            if not is_nil(beta):
                self.move(s, beta)

    def advance(self, order):
        """Go on until the conditions of an order can be evaluated; eta is known below it."""
        while self.order < order:
            if self.order and self.free:
                self.settle()
            self.order += 1
            if self.order == order:
                return
            self.fill()

    def fill(self):
        """Find eta at the trees of the order that was reached, principal parts 0."""
        for t in self.pool(self.order):
            c, right = t[0], self.residual(t)
            self.eta[t] = [Fraction(0) if j == self.k[c] else dot(row, right)
                           for j, row in enumerate(self.lift[c])]  # fmt: skip

    def condition(self, t):
        """Return W R(t)."""
        return dot(self.W[t[0]], self.residual(t))

    def pool(self, order):
        """Return the trees of an order that count."""
        return pool_of(self.method, order, self.nystrom)


class ByClasses(Bounds):
    """The series of a sweep at values of its unknowns, by classes; zeta_1 by theorem 2 (6.2)."""

    def __init__(self, sweep, values):
        super().__init__(sweep.at(values), False, False)
        self.sweep, self.q, self.G = sweep, sweep.q, as_real(sweep.G)
        self.given = {t: at_values(x, values) for t, x in sweep.xi.items()}

    def pool(self, order):
        """Return the classes of an order."""
        return classes(order, self.q)

    def cut_value(self, s):
        """Return eta(s), that of its class times the factor."""
        below, factor = reduced(s, self.q)
        return self.eta[below] if factor == 1 else [x * factor for x in self.eta[below]]

    def condition(self, t):
        """Return R_1(t), that of its class times the factor."""
        below, factor = reduced(t, self.q)
        return super().condition(below) * factor

    def settle(self):
        """Find the principal parts of the last order, 0 where it is odd."""
        if self.order % 2:
            return
        free = self.sweep.free.get(self.order, ())
        defining, _, back = plan(self.order, self.q, free)
        right = [dot(self.eta[t], apply(self.G, self.eta[u])) for t, u in defining]
        right += [self.given.get(t, Fraction(0)) for t in free]
        for t, row_ in zip(classes(self.order, self.q), back, strict=True):
            self.move(t, dot(row_, right))


class AlongWord(Bounds):
    """The series of a pair at values of its unknowns: the stages one after another (6.4)."""

    def __init__(self, pair, values, nystrom):
        super().__init__(pair.at(values), True, nystrom)
        self.word, G = pair.word, as_real(pair.G)
        self.half = {c: at_values(list(x), values) for c, x in pair.halves.items()}
        (_, X), (_, Y) = self.half.values()
        self.readers = {"f": transpose(times(G, Y)), "k": times(transpose(X), G)}
        self.V = {c: as_real(V) for c, V in pair.V.items()}

    def pool(self, order):
        """Return the trees of an order, with those whose root moves."""
        return listed(order, self.nystrom)

    def stages(self, tree):
        """Return xi(t): what the stages of the other half see of the values on their way."""
        if tree not in self.known:
            (weights, rows), readers = self.half[tree[0]], self.readers[tree[0]]
            columns = transpose(rows)
            updates = [w * x for w, x in zip(weights, self.derivative(tree), strict=True)]
            now, found = apply(self.V[tree[0]], self.eta_of(tree)), []
            for half, i in self.word:
                if half == tree[0]:
                    now = [x if is_nil(y) else x + updates[i] * y
                           for x, y in zip(now, columns[i], strict=True)]  # fmt: skip
                else:
                    found.append(dot(readers[i], now))
            self.known[tree] = found
        return self.known[tree]


# ------------------------------------------------ section 6: rules


def implied_order(proof, w):
    """Rule implied-order."""
    keys(w, "order principal trees")
    identity_mode, nystrom = mode(w)
    p = whole(w["order"], 1, 14)
    require(nystrom not in PATHS, "paths decide for exact pairs")
    root = proof.root()
    more = (proof.row, proof.method) if isinstance(root, RungeKutta) else ()
    root.order_holds(p, identity_mode, nystrom, *more)
    proof.low = (p, identity_mode, nystrom)


def not_order(proof, w):
    """Rule not-order: order p + 1 is not reached by any method in the intervals."""
    keys(w, "order principal trees tree")
    identity_mode, nystrom = mode(w)
    p = whole(w["order"], 0, 11)
    require(nystrom not in PATHS, "paths decide for exact pairs")
    tree, bounds = named_tree(proof, w, p + 1, nystrom), proof.bounds(identity_mode, nystrom, p + 1)
    require(apart(bounds.condition(tree)), "the condition of the tree may hold")
    proof.high, proof.simple = (p, identity_mode, nystrom), True


def implied_stage_order(proof, w):
    """Rule implied-stage-order."""
    keys(w, "q")
    q = whole(w["q"], 1)
    require(proof.low is not None, "the order is not part of the certificate")
    root = proof.root()
    require(not isinstance(root, Pair), "the stage order of pairs")
    root.stage_order_holds(q, proof.low[0])
    return q


def not_stage_order(proof, w):
    """Rule not-stage-order."""
    keys(w, "q tree")
    q, (identity_mode, nystrom) = whole(w["q"]), proof.mode()
    tree = named_tree(proof, w, q + 1, nystrom)
    require(not proof.high or proof.low == proof.high, "the order is not enclosed")
    # a method with order q + 1 at least; where that is all one knows a multiple of ones is free
    p = proof.high[0] if proof.high else q + 1
    require(q < p, "the order is not above it")
    bounds = proof.bounds(identity_mode, nystrom, p)
    if q + 1 == p:
        bounds.fill()
    gap = stage_defect(bounds, tree, fixed_rows(proof, q + 1, p))
    require(any(map(apart, gap)), "the stages may be right at the tree")
    return q


def implied_start(proof, w):
    """Rule implied-start."""
    keys(w, "q")
    q = whole(w["q"], 1)
    require(proof.low is not None and q <= proof.low[0], "the order is not part of the certificate")
    table = proof.method.document.get("starting")
    if proof.method.pair:
        pair = proof.root()
        if table is None:
            pair.zero_start_holds(q, proof.low[2])
        else:
            orders = proof.even_orders()
            require(q <= orders[proof.low[2]], "the start has a lower order")
        return q
    require(q == proof.low[0] and table is not None, "the start has another order")
    proof.odd_start(q)
    return q


def not_start(proof, w):
    """Rule not-start: the order of the start is at most q."""
    keys(w, "q", "tree value")
    q = whole(w["q"])
    if "tree" not in w:
        require(proof.low and proof.low == proof.high and q == proof.low[0], "the order is open")
        return q
    method = proof.method
    identity_mode, nystrom = proof.mode()
    if not method.pair:  # the series may be moved along the flow: a multiple of u does not count
        keys(w, "q tree")
        require(q == 0, "the start of one method")
        bounds, start = proof.bounds(True, False, 1), start_of(method)
        bounds.fill()
        u, node = bounds.u["o"], ("o", ())
        if w["tree"] == "":
            require(any(apart(x - y) for x, y in zip(start.u["o"], u, strict=True)), "u fits")
            return q
        gap = less(start.value(node), bounds.eta[node])
        require(off_line(gap, u), "the start may be right at the tree")
        return q
    require(identity_mode, "for pairs only")
    tree = named_tree(proof, w, q + 1, nystrom)
    bounds = proof.bounds(True, nystrom, q + 1)
    bounds.fill()
    start, k = start_of(method), whole(w["value"], 1) - 1
    value = start.value(tree)[k] - bounds.eta[tree][k]
    require(apart(value), "the start may be right at the tree")
    return q


def implied_finish(proof, w):
    """Rule implied-finish."""
    keys(w, "q")
    q, document = whole(w["q"], 1), proof.method.document
    require(proof.low is not None and q == proof.low[0], "the order is not part of the certificate")
    opening, closing = document.get("starting"), document.get("finishing")
    require(closing is not None and opening is not None, "the file has no finish")
    keys(closing, "A b", "name kind order", "finish")
    if undoes(proof.method.numbers, opening, closing):
        return q
    A, B = proof.odd_start(q)
    block = proof.blocks.get("finishing")
    require(block is not None, "the proof of the finish is missing")
    finish_with_parity(block, proof.method.numbers, document, A, B[0], q)
    return q


def implied(proof, w):
    """Rule implied: what holds at the root of an enclosure."""
    keys(w, "")
    root, claim = proof.root(), proof.claim
    if claim in ("growth", "parasitism-free"):
        count = root.zero_growths()
        require(count is not None, "an eigenvalue has no equation")
        if claim == "growth":
            declared = proof.claimed(proof.declared)
            same = len(declared) == count and vanishes(declared)
            require(same == proof.holds, "the parameters are all 0")
    elif claim == "abscissae":
        require(isinstance(root, Sweep), "the abscissae of pairs")
        found = root.abscissae()
        require(found is not None, "an abscissa is not fixed")
        equal(found, proof.claimed(proof.declared), "the list of abscissae")
    else:
        require(root.implies(claim), f"{claim} does not follow")


def row(proof, w):
    """Rule row: the order of the method with the weights of an embedded row; return (name, p)."""
    keys(w, "row parts")
    rows, whole_method = proof.method.rows(), proof.method
    require(w["row"] in rows, "no row of embedded has the name")
    require(isinstance(w["parts"], list), "the parts of a row are a list")
    names = [part["rule"] for part in w["parts"]]
    pair, low, high = ["order-at-least", "order-at-most"], ["order-at-least"], ["not-order"]
    implied_pair = ["implied-order", "not-order"]
    own = [implied_pair] if proof.record.root is not None else [
        pair, ["no-order-1"], ["order-at-least", "not-order"]]  # fmt: skip
    own += [high] if proof.holds else [high, low]
    require(names in own, "the parts of a row")
    nystrom = whole_method.kind == "nystrom"
    proof.series = proof.low = proof.high = None
    proof.method = whole_method.with_row(rows[w["row"]][0]).for_claim("order")
    proof.row = w["row"]
    for part in w["parts"]:
        RULES[part["rule"]](proof, part["witness"])
    proof.method, proof.row = whole_method, None
    if names == ["no-order-1"]:
        return w["row"], range(1)
    kinds = (True, "nystrom-paths") if nystrom else (False,)
    fine = all(x is None or (x[1] is True and x[2] in kinds) for x in (proof.low, proof.high))
    require(fine, "an order of another kind")
    least = proof.low[0] if proof.low else 0
    most = proof.high[0] if proof.high else 20  # the largest order that a claim may name
    return w["row"], range(least, most + 1)


def check_rows(proof, found):
    """Refuse orders of rows that do not decide what is declared: of all rows, or of one."""
    orders, declared = dict(found), as_object(proof.declared)
    require(len(orders) == len(found) and set(declared) == set(proof.method.rows()), "rows")
    for p in declared.values():
        whole(p)
    if proof.holds:
        require(set(orders) == set(declared), "a row is missing")
        fits = all(x == range(declared[name], declared[name] + 1) for name, x in found)
        require(fits, "the order of a row is not shown to be this")
    else:
        require(any(declared[name] not in x for name, x in found), "the rows may have the orders")


def differences_of(method):
    """Return the sum of the weights of each estimate; of a Nystrom method those of q' left out.

    Of class glm return what each estimate is for y' = 0 and y' = 1, for all values that are exact.
    """
    require(method.rows(), "no rows are embedded")
    if method.kind == "glm":
        return [
            x for weights, _ in method.rows().values() for x in estimates(method, *weights["o"])
        ]
    return [total(w[1:] if method.kind == "nystrom" and c == "f" else w)
            for _, estimate in method.rows().values() for c, w in estimate.items()]  # fmt: skip


def estimates(method, b, v):
    """Return d u and x e 1 + d v of the row (b, v) for a basis of all (u, v, x).

    e = w B - b, d = w V - v; V u = u, U u = x 1, w u = x, x B 1 + V v = u + v. Return a 1 where no
    x is 1.
    """
    m, w = method.single(), method.declared.get("o")
    shift, nil = minus(m.V, identity(m.r)), [Fraction(0)] * m.r
    require(not any(type(x) is Interval for M in (m.U, m.B, m.V) for row in M for x in row),
            "values in decimals")  # fmt: skip
    outside = [[*row, Fraction(-1)] for row in [*m.U, *([w] if w else [])]]
    constants = kernel([[*row, Fraction(0)] for row in shift] + outside)
    slopes = zip(shift, identity(m.r), apply(m.B, ones(len(m.B[0]))), strict=True)
    both = kernel([[*row, *nil, Fraction(0)] for row in shift]
                  + [[*row[:-1], *nil, row[-1]] for row in outside]
                  + [[*(-x for x in unit), *row, x] for row, unit, x in slopes])  # fmt: skip
    if not any(x[-1] for x in both):
        return [Fraction(1)]
    if w is None:
        k = next(k for k in range(m.r) if any(x[k] for x in constants))
        u = next([y * inverse(x[-1]) for y in x] for x in constants if x[-1])
        require(vanishes([x[k] - u[k] * x[-1] for x in constants]), "the output is not fixed")
        w = [inverse(u[k]) if j == k else Fraction(0) for j in range(m.r)]
    require(len(b) == len(m.A) and len(v) == m.r, "embedded has another length")
    e, d = less(apply(transpose(m.B), w), b), less(apply(transpose(m.V), w), v)
    return [y for x in both
            for y in (dot(d, x[: m.r]), total(e) * x[-1] + dot(d, x[m.r : -1]))]  # fmt: skip


def gaps_of_rows(method):
    """Return A 1 - c, or of a Nystrom method 2 A 1 - c^2 and A' 1 - c."""
    if method.kind == "nystrom":
        A, c = method.matrix("A"), method.list("c")
        gaps = [2 * total(row) - x * x for row, x in zip(A, c, strict=True)]
        inner = method.matrix("A_prime") if "A_prime" in method.document else []
        return gaps + [total(row) - x for row, x in zip(inner, c, strict=False)]
    m = method.single()
    return less(apply(m.A, ones(len(m.A))), method.list("c"))


def gaps_of_end(method):
    """Return b(1) - b."""
    ends = [total(x) for x in method.matrix("dense")]
    return less(ends, method.single().B[0])


def all_zero_or_not(gaps, wanted):
    """Return the rule that the numbers are all zero, or that one is not."""

    def rule(proof, w):
        keys(w, "")
        values = gaps(proof.method)
        if wanted:
            require(vanishes(values), "a number is not 0")
        else:
            require(any(apart(x) for x in values), "the numbers are 0")

    return rule


def absent(proof, w):
    """Rule absent: the file has nothing that the claim is about, which settles the claim."""
    keys(w, "")
    require(proof.claim in ABSENT, "the claim is about the method itself")
    key, value = ABSENT[proof.claim]
    if proof.claim == "embedded-order":
        rows = set(proof.method.rows()) if proof.method.document.get(key) else set()
        other = not rows or rows != set(as_object(proof.declared))
        require(other and not proof.holds, "the rows are these")
        return
    require(not proof.method.document.get(key), f"the file has {key}")
    require(key != "starting" or not proof.method.pair, "a pair without a start has (y0, 0, ..)")
    same = type(proof.declared) is type(value) and proof.declared == value
    require(same == proof.holds, "the value is another")


def dense(proof, w, reached=True):
    """Rules dense and not-dense: the order of b(theta), power by power of theta, or a bound."""
    keys(w, "order tree")
    p, method = whole(w["order"]), proof.method
    require(method.system == "" and not method.pair, "c is A 1")
    m, columns = method.single(), transpose(method.matrix("dense"))
    require(len(columns[0]) == len(m.A), "dense has another length")

    series = Series.of_tables({"o": (m.A, m.B)})

    def gaps(tree):
        n = size(tree)
        found = apply(columns, series.derivative(tree))
        found += [Fraction(0)] * (n - len(found))
        found[n - 1] = found[n - 1] - Fraction(1, gamma(tree))
        return found

    for tree in (t for n in range(1, p + 1 if reached else 1) for t in trees(method.palette, n)):
        require(vanishes(gaps(tree)), f"the condition of tree {show(tree)}")
    tree = read_tree(w["tree"])
    require(size(tree) == p + 1 and tree in trees(method.palette, p + 1), "the tree")
    require(any(apart(x) for x in gaps(tree)), "the next order is reached")
    proof.high = (p, True, False)
    proof.low = proof.high if reached else None


class Sizes:
    """Conditions of a method that carries one value, in integers over 2^bits with their errors."""

    def __init__(self, method, bits):
        self.method, self.bits, self.known = method, bits, {}
        for m in method.parts.values():
            fine = all(x == 1 for row in (*m.U, *m.V) for x in row) and m.r == 1
            require(fine, "the value carried is not the solution")
        self.A = {c: [self.whole(row) for row in m.A] for c, m in method.parts.items()}
        self.width = {c: len(rows[0]) for c, rows in self.A.items()}
        self.norm = {c: max(sum(map(abs, x)) + len(x) for x in A) for c, A in self.A.items()}

    def whole(self, row):
        """Return the integers below 2^bits times rational numbers."""
        require(all(isinstance(x, (int, Fraction)) for x in row), "the entries are not rational")
        return [(Fraction(x) * 2**self.bits).__floor__() for x in row]

    def phi(self, tree, keep=True):
        """Return (values, error) of the product over the children of A Phi(child)."""
        if tree not in self.known:
            found = [1 << self.bits] * self.width[tree[0]], 0
            for child in tree[1]:
                found = self.product(found, self.below(child))
            if not keep:
                return found
            self.known[tree] = found
        return self.known[tree]

    def product(self, left, right):
        """Return the product place by place: |dx y + x dy + dx dy|, and 1 for the shift."""
        (x, dx), (y, dy) = left, right
        top = max(map(abs, x)) * dy + max(map(abs, y)) * dx + dx * dy
        return [a * b >> self.bits for a, b in zip(x, y, strict=True)], (top >> self.bits) + 2

    def below(self, tree):
        """Return A Phi(tree), A that of the colour of the root."""
        key = (tree, "below")
        if key not in self.known:
            x, dx = self.phi(tree)
            error = self.norm[tree[0]] * dx + sum(map(abs, x)) + len(x) * dx
            rows = [sum(a * b for a, b in zip(row, x, strict=True) if a) for row in self.A[tree[0]]]
            self.known[key] = [y >> self.bits for y in rows], (error >> self.bits) + 2
        return self.known[key]

    def residual(self, tree, b, keep=True):
        """Return bounds of |b Phi(tree) - 1 / gamma(tree)| for integers b."""
        x, dx = self.phi(tree, keep)
        error = sum(map(abs, b)) * dx + sum(map(abs, x)) + len(x) * dx
        gap = sum(u * v for u, v in zip(b, x, strict=True)) >> self.bits
        gap = abs(gap - (1 << self.bits) // gamma(tree))
        error = (error >> self.bits) + 3
        unit = Fraction(1, 1 << self.bits)
        return (gap - error) * unit, (gap + error) * unit

    def exactly(self, tree, b):
        """Return |b Phi(tree) - 1 / gamma(tree)| itself."""
        parts = {c: (m.A, m.B) for c, m in self.method.parts.items()}
        slopes = Series.of_tables(parts).derivative(tree)
        return abs(dot(b, slopes) - Fraction(1, gamma(tree)))


def two_digits(text):
    """Return the number of two digits and the one before it."""
    require(
        isinstance(text, str) and re.fullmatch(r"[1-9]\.[0-9]e-[1-9][0-9]{0,2}", text), "a size"
    )
    digits, _, power = text.partition("e")
    top, unit = int(digits.replace(".", "")), Fraction(1, 10 ** (1 - int(power)))
    return top * unit, (top - 1) * unit if top > 10 else Fraction(99, 10) * unit


class ToDigits:
    """The residuals of the rows of weights, and what is declared of them."""

    def __init__(self, proof):
        method, declared = proof.method, as_object(proof.declared)
        rows, self.nystrom = method.rows(), method.kind == "nystrom"
        require("b" not in rows, "a row has the name of the solution")
        require(set(declared) == {"b", *rows}, "other weights are declared")
        self.declared, exponent = {}, 0
        for name, value in declared.items():
            require(isinstance(value, list) and len(value) == 2, "an order and a size are declared")
            self.declared[name] = whole(value[0], 1, 14), *two_digits(value[1])
            exponent = max(exponent, int(value[1].partition("e-")[2]))
        self.base = method.for_claim("order")
        self.sizes, self.b, self.scaled = Sizes(self.base, 256 + 4 * exponent), {}, {}
        for name in declared:
            one = self.base if name == "b" else method.with_row(rows[name][0]).for_claim("order")
            carried = all(x == 1 for m in one.parts.values() for row in m.V for x in row)
            require(carried, "the row does not carry the solution")
            self.b[name] = {c: m.B[0] for c, m in one.parts.items()}
            self.scaled[name] = {c: self.sizes.whole(b) for c, b in self.b[name].items()}

    def counted(self, tree):
        """Tell whether the claim is about the condition of a tree."""
        return stands(tree, self.base.system) and (is_nystrom(tree) or not self.nystrom)

    def trees(self, order):
        """Return the trees of an order whose conditions are meant."""
        return filter(self.counted, trees(self.base.palette, order))

    def read(self, text, low, high):
        """Return a tree of a witness, whose order is one of these."""
        tree = read_tree(text)
        require(low <= size(tree) <= high and grows_in(self.base.palette, tree), "the tree")
        require(self.counted(tree), "the condition of the tree is not meant")
        return tree

    def residual(self, name, tree, *limits, keep=True):
        """Return bounds of a residual, itself where a limit is between them."""
        low, high = self.sizes.residual(tree, self.scaled[name][tree[0]], keep)
        if any(low <= x < high for x in limits):
            low = high = self.sizes.exactly(tree, self.b[name][tree[0]])
        return low, high


def to_digits(proof, w):
    """Rule to-digits: every residual through an order, the largest one, and one of the next."""
    keys(w, "rows")
    known, shown = ToDigits(proof), as_object(w["rows"])
    require(set(shown) == set(known.declared), "other weights are shown")
    for name, (order, most, least) in known.declared.items():
        keys(shown[name], "largest beyond")
        largest, seen = known.read(shown[name]["largest"], 1, order), False
        for n in range(1, order + 1):
            for tree in known.trees(n):
                low, high = known.residual(name, tree, most, least, keep=n < order)
                require(high <= most, f"the residual of tree {show(tree)}")
                seen = seen or (tree == largest and low > least)
        require(seen, "no residual is as large")
        tree = known.read(shown[name]["beyond"], order + 1, order + 1)
        low, _ = known.residual(name, tree, 1000 * most, keep=False)
        require(low > 1000 * most, "the residual of the tree beyond")


def not_to_digits(proof, w):
    """Rule not-to-digits: one residual is too large, or all are too small, or all of the next."""
    keys(w, "row", "tree order")
    require(("tree" in w) is not ("order" in w), "a tree or an order")
    known, name = ToDigits(proof), w["row"]
    require(name in known.declared, "no row of this name")
    order, most, least = known.declared[name]
    if "tree" in w:
        low, _ = known.residual(name, known.read(w["tree"], 1, order), most)
        require(low > most, "the residual of the tree")
        return
    beyond = whole(w["order"], order, order + 1) > order
    limit = 1000 * most if beyond else least
    for n in range(order + 1 if beyond else 1, w["order"] + 1):
        for tree in known.trees(n):
            _, high = known.residual(name, tree, limit, keep=n < w["order"])
            require(high <= limit, f"the residual of tree {show(tree)}")


def grows_in(palette, tree):
    """Tell whether the colours of a tree are those of a palette."""
    children = dict(palette)
    fine = tree[0] in children and all(x[0] in children[tree[0]] for x in tree[1])
    return fine and all(grows_in(palette, x) for x in tree[1])


# ------------------------------------------------ section 7: which parts prove which statement

RULES = {rule.__name__.replace("_", "-"): rule for rule in (
    order_at_least, order_at_most, preconsistent, consistent, stage_order_at_least,
    stage_order_at_most, start_at_least, start_at_most, finish_at_least, finish_at_most, bounded,
    unbounded, eigen, growth, grows, unshared, form, given_form_fails, no_form, quadratic,
    not_quadratic, symmetric, not_symmetric, explicit, implicit, abscissae, other_abscissae,
    error_constant, reducible, irreducible, equivalent, a_stable, not_a_stable, l_limit, implied,
    implied_order, not_order, implied_stage_order, not_stage_order, implied_start, not_start,
    implied_finish, row, dense, absent, to_digits, not_to_digits,
)} | {
    "no-order-1": lambda proof, w: contradiction(proof, w, False),
    "not-preconsistent": lambda proof, w: contradiction(proof, w, True),
    "other-error-constant": lambda proof, w: error_constant(proof, w, False),
    "not-l-limit": lambda proof, w: l_limit(proof, w, False),
    "not-dense": lambda proof, w: dense(proof, w, False),
    "differences": all_zero_or_not(differences_of, True),
    "no-differences": all_zero_or_not(differences_of, False),
    "row-sums": all_zero_or_not(gaps_of_rows, True),
    "no-row-sums": all_zero_or_not(gaps_of_rows, False),
    "dense-end": all_zero_or_not(gaps_of_end, True),
    "no-dense-end": all_zero_or_not(gaps_of_end, False),
}  # fmt: skip

ORDERS = ("order", "order-identity", "effective-order", "nystrom-order", "w-order")


PROVES = {
    "preconsistent": ("preconsistent", "not-preconsistent"),
    "consistent": ("consistent", "no-order-1"),
    "symplectic": ("quadratic", "not-quadratic"),
    "g-symplectic": (
        "preconsistent form|form",
        ("given-form-fails|preconsistent given-form-fails|no-form|preconsistent no-form|"
         "not-preconsistent")),
    "symmetric": ("symmetric", "not-symmetric"),
    "symmetric-reduced": ("equivalent irreducible symmetric",
                          "equivalent irreducible not-symmetric"),
    "explicit": ("explicit", "implicit"),
    "reducible": ("reducible", "irreducible"),
    "zero-stable": ("bounded*", "unbounded"),
    "a-stable": ("bounded a-stable", "not-a-stable|unbounded not-a-stable"),
    "l-stable": ("bounded a-stable l-limit", "not-a-stable|unbounded not-a-stable|not-l-limit"),
    "parasitism-free": ("eigen* growth|bounded* unshared", "eigen* grows|unbounded"),
    "growth": ("eigen* growth|bounded* unshared", "eigen* grows|unbounded|bounded* unshared"),
    "abscissae": ("abscissae", "other-abscissae|no-order-1"),
    "error-constant": ("error-constant", "other-error-constant"),
    "embedded-difference": ("differences", "no-differences"),
    "row-sums": ("row-sums", "no-row-sums"),
    "dense-end": ("dense-end", "no-dense-end"),
    "dense-order": ("dense|not-dense", "dense|not-dense"),
    "embedded-order": ("row+", "row+"),
    "order-to-digits": ("to-digits", "not-to-digits"),
}  # fmt: skip


SECOND = {"stage-order": "stage-order", "starting-order": "start",
          "nystrom-starting-order": "start", "finishing-order": "finish"}  # fmt: skip


VALUES = ("growth", "abscissae", "error-constant", "embedded-order", "order-to-digits")
ABSENT = {  # claim: key of the document that it is about, the value where there is none
    "embedded-order": ("embedded", {}), "embedded-difference": ("embedded", False),
    "row-sums": ("c", True), "dense-end": ("dense", False), "dense-order": ("dense", 0),
    "starting-order": ("starting", 0), "finishing-order": ("finishing", 0),
}  # fmt: skip


ADDITIVE = {  # claims of methods for a sum of right-hand sides
    "order", "order-identity", "effective-order", "stage-order", "preconsistent", "consistent",
    "zero-stable", "explicit", "embedded-order", "embedded-difference", "order-to-digits",
    "abscissae",
}  # fmt: skip
ROSENBROCK = {"order", "w-order", "a-stable", "l-stable", "embedded-order", "embedded-difference",
              "order-to-digits"}  # fmt: skip
LOOKS_AT = {  # rules, and keys of witnesses, that look at exact zeros or at these matrices only
    "explicit": "", "absent": "", "several-values": "", "bounded": "V", "unbounded": "V",
    "singular": "V", "unshared": "V",
    "preconsistent": "UV", "not-preconsistent": "UV", "consistent": "UBV",
}  # fmt: skip
#: Claims about decimals that the rules for exact numbers decide too, with intervals for numbers.
AS_EXACT = {
    "preconsistent", "consistent", "zero-stable", "symplectic", "g-symplectic", "symmetric",
    "parasitism-free", "growth", "abscissae", "embedded-difference", "row-sums", "dense-end",
    "dense-order", *ORDERS, *SECOND, "error-constant", "explicit", "reducible",
}  # fmt: skip


class Record:
    """The root of an enclosure and what was found from it, kept for the next certificate."""

    last = (None, None)

    def __init__(self, document, field, numbers):
        self.exact, self.numbers, self.root, self.memory = numbers, numbers, None, {}
        unknowns = as_object(document.get("unknowns", {}))
        if field["kind"] == "balls":
            digits = whole(document.get("digits"), 1, 400)

            def around_decimal(text):
                unit = Fraction(1, 10**digits)
                return Interval.ends(Fraction(text) - unit, Fraction(text) + unit)

            values = {}
            for name, text in unknowns.items():
                values[name] = around_decimal(published_decimal(text, digits))
            self.numbers = numbers.changed(decimal=around_decimal, unknowns=values)
        elif field["kind"] == "enclosure" and "method" in as_object(field["proofs"]):
            kinds = {"sweep": Sweep, "pair-sweep": Pair, "splitting": Pair, "rk": RungeKutta,
                     "rosenbrock": RungeKutta}  # fmt: skip
            require(document.get("class") in kinds, "an enclosure of another class")
            self.root = kinds[document["class"]](document, numbers, field["proofs"]["method"])
            weights = [row for row, _ in self.root.halves.values()]
            fine = all(apart(x) for row in weights for x in at_values(row, self.root.root))
            require(fine, "a weight may be 0")
            values = dict(zip(self.root.unknowns, self.root.root, strict=True))
            self.numbers = numbers.changed(unknowns=values)
            if isinstance(self.root, Sweep):
                self.root.explicit_now = self.numbers.explicit = frozenset(self.root.explicit)

    @classmethod
    def of(cls, document, field, numbers):
        """Return the record of a document, that of the last certificate where it is the same."""
        if field["kind"] in ("rational", "tower"):
            return cls(document, field, numbers)
        kept = {key: value for key, value in document.items() if key != "claims"}
        own = {key: value for key, value in field.items() if key != "proofs"}
        proof = as_object(field.get("proofs", {})).get("method")
        key = json.dumps([kept, own, proof], sort_keys=True)
        if cls.last[0] != key:
            cls.last = (None, None)
            cls.last = (key, cls(document, field, numbers))
        return cls.last[1]

    def known(self, key, make):
        """Return what was made before under this key; None keeps nothing."""
        if key is None:
            return make()
        if key not in self.memory:
            self.memory[key] = make()
        return self.memory[key]


def numbers_of(field):
    """Return the numbers of a field; the tower of the last certificate is used again."""
    require(isinstance(field, dict), "the field is no object")
    key = json.dumps({k: x for k, x in field.items() if k != "proofs"}, sort_keys=True)
    if numbers_of.last[0] != key:
        numbers_of.last = (key, Numbers(field))
    else:
        keys(field, "kind", "generators radicals proofs", "field")
    return numbers_of.last[1].changed()


numbers_of.last = (None, None)


class Proof:
    """One certificate while it is checked: the statement, the method, what is shown so far."""

    def __init__(self, certificate):
        keys(certificate, "format statement document field parts identities", "base", "certificate")
        require(certificate["format"] == FORMAT, "another format")
        statement, parts = certificate["statement"], certificate["parts"]
        keys(statement, "method claim declared verdict proof", where="statement")
        self.claim, self.declared = statement["claim"], statement["declared"]
        require(statement["verdict"] in ("holds", "fails"), "a verdict is holds or fails")
        require(isinstance(self.claim, str), "a claim is a string")
        self.holds = statement["verdict"] == "holds"
        texts = certificate["identities"]
        require(isinstance(texts, list) and all(isinstance(x, str) for x in texts), "identities")
        require(isinstance(parts, list) and 0 < len(parts) <= 20, "parts are a list")
        for part in parts:
            keys(part, "rule witness", "", "part")
            require(part["rule"] in RULES, f"no rule is called {part['rule']!r}")
        self.parts, self.rules = parts, [part["rule"] for part in parts]
        document = as_object(certificate["document"])
        require(document.get("name") == statement["method"], "the document is another method")
        claims = as_object(document.get("claims", {}))
        declared = claims.get(self.claim, self.declared)
        same = type(declared) is type(self.declared) and declared == self.declared
        require(same, "the document declares something else")
        numbers = numbers_of(certificate["field"])
        self.kind = certificate["field"]["kind"]
        self.blocks = as_object(certificate["field"].get("proofs", {}))
        self.record = Record.of(document, certificate["field"], numbers)
        self.method = Method(document, self.record.numbers, certificate.get("base"))
        self.method.check_shapes()
        if self.rules != ["absent"]:
            self.method = self.method.for_claim(self.claim)
        require(statement["proof"] in self.proofs(), "the proof is another")
        self.series = self.low = self.high = self.reversal = self.row = None
        self.simple, self.stable, self.eigen = False, set(), {}
        self.claim_text = f"{self.claim} = {self.declared}"

    def proofs(self):
        """Return what the proof may be called: exact where only exact entries are looked at."""
        if self.kind in ("rational", "tower"):
            return ["exact"]
        looked = set(self.rules)
        for part in self.parts:
            witness = as_object(part["witness"])
            looked |= {"several-values", "singular"} & set(witness)
            if witness.get("part") == -1:  # a number of eigenvalues
                looked = looked - {"eigen", "grows"} | {"bounded"}
            if part["rule"] == "no-order-1":
                looked = looked - {"no-order-1"} | {"consistent"}
        looked -= {"not-quadratic", "not-symmetric"} if looked & set(LOOKS_AT) else set()
        exact = looked <= set(LOOKS_AT) and all(
            is_exact(getattr(m, x))
            for m in self.method.parts.values()
            for x in set("".join(LOOKS_AT[rule] for rule in looked))
        )
        return ["exact", "enclosed"] if exact else ["enclosed"]

    def root(self):
        """Return the sweep or pair at the root of the equations."""
        require(self.record.root is not None, "the proof of the method is missing")
        return self.record.root

    def bounds(self, identity_mode, nystrom, order):
        """Return the series in intervals, ready for the conditions of an order."""
        found = self.record.known(("bounds", self.row, self.method.system, identity_mode, nystrom,
                                   order),
                                  lambda: Bounds(self.method, identity_mode, nystrom))  # fmt: skip
        found.advance(order)
        return found

    def even_orders(self):
        """Return the orders of the start of a pair."""
        require("starting" in self.blocks, "the proof of the start is missing")
        proof = self.blocks["starting"]
        return self.record.known(("start", json.dumps(proof)), lambda: even_start(
            proof, self.root(), self.record.exact, self.method.document))  # fmt: skip

    def odd_start(self, order):
        """Return A and B of the start of one method, proved to have the order."""
        require("starting" in self.blocks, "the proof of the start is missing")

        proof, numbers = self.blocks["starting"], self.record.exact

        def made():
            L, series, q = self.target(order)
            return start_with_parity(proof, numbers, self.method.document, series, L, order, q)[1:]

        key = ("start", order, json.dumps(proof)) if self.record.root is not None else None
        return self.record.known(key, made)

    def target(self, order):
        """Return (L, starting series, stage order) that a start has to meet."""
        if self.record.root is not None:
            sweep = self.root()
            series = sweep.series(sweep.root, order + 1).cut_value
            return sweep.reversal()["o"], series, sweep.q
        require(self.reversal is not None and self.series is not None, "symmetry is missing")
        L, eta = self.reversal["o"], self.series
        for t in (t for n in range(1, order + 1) for t in trees(self.method.palette, n)):
            sign_ = -1 if size(t) % 2 else 1
            equal(eta.eta_of(t), [sign_ * x for x in apply(L, eta.eta_of(t))], "eta(-h) = L eta(h)")
        return L, lambda t: [as_real(x) for x in eta.eta_of(t)], 1

    def claimed(self, texts):
        """Return declared numbers; claims use no constants."""
        require(isinstance(texts, list), "a list is declared")
        return [self.method.numbers.parser(text, {}).value for text in texts]

    def check(self):
        """Check that the parts are those of the statement (7), and each of them."""
        kind, about = self.method.kind, self.claim in ADDITIVE or not self.method.additive
        about = self.claim in ROSENBROCK if kind == "rosenbrock" else about
        require(about, f"{self.claim} has no meaning for an additive method")
        require(self.claim != "w-order" or kind == "rosenbrock", "a Rosenbrock method is needed")
        fine = self.rules == ["absent"] or self.rules in self.allowed()
        require(fine, f"these parts do not prove {self.claim}: {self.rules}")
        results = [RULES[part["rule"]](self, as_object(part["witness"])) for part in self.parts]
        if self.rules == ["absent"]:
            return
        if self.claim == "embedded-order":
            check_rows(self, results)
        elif self.claim in ORDERS or self.claim == "dense-order":
            self.check_order(self.low and self.low[0], self.high and self.high[0])
        elif self.claim in SECOND:
            low, high = ([value for rule, value in zip(self.rules, results, strict=True)
                          if rule in names] for names in self.both_ends())  # fmt: skip
            if self.rules == ["not-order"]:  # none of these orders is above that of the method
                high = self.high
            self.check_order(*(found[0] if found else None for found in (low, high)))
        if self.claim in ("zero-stable", "parasitism-free", "growth") and "bounded" in self.rules:
            require(self.stable == set(self.method.parts), "V of one component is missing")
        for shown in (self.low, self.high):
            if shown and (self.claim in ORDERS or self.claim in SECOND):
                found = shown[1], shown[2] in (True, "nystrom-paths")
                require(found == self.mode(), "principal or trees are not those of the claim")

    def both_ends(self):
        """Return the rules for the two bounds of an order that rests on the order."""
        name = SECOND[self.claim]
        return {f"{name}-at-least", f"implied-{name}"}, {f"{name}-at-most", f"not-{name}"}

    def mode(self):
        """Return (identity?, nystrom?) of the orders that a claim is about."""
        single = all(m.r == 1 for m in self.method.parts.values())
        nystrom = self.claim.startswith("nystrom")
        if self.claim in ("order", "stage-order", "finishing-order"):
            return single, False
        if self.claim == "starting-order":
            return self.method.pair, False
        return self.claim != "effective-order", nystrom

    def allowed(self):
        """Return the lists of rules that prove the statement (7)."""
        truth = self.holds
        if self.claim in (*ORDERS, *SECOND, "dense-order"):
            whole(self.declared)
        elif self.claim not in VALUES:
            require(type(self.declared) is bool, "the claim is true or false")
            truth = self.declared == self.holds
        balls = self.kind in ("balls", "enclosure")
        texts = self.chains_in_intervals(truth) if balls else ""
        if not balls or self.claim in AS_EXACT:
            texts += "|" + self.chains(truth)
        return [self.repeated(text.split()) for text in texts.split("|") if text]

    def repeated(self, names):
        """Return names of rules, each as often as there are components or rows."""
        times_ = {"*": len(self.method.parts), "+": len(self.method.document.get("embedded", ()))}
        return [x.rstrip("*+") for x in names for _ in range(times_.get(x[-1], 1))]

    def chains(self, truth):
        """Return the lists of rules for a statement about exact numbers."""
        pair = "order-at-least order-at-most"
        if self.claim in ORDERS:
            return f"{pair}|no-order-1" + ("" if truth else "|order-at-least|order-at-most")
        if self.claim in SECOND:
            low, high = (f"{SECOND[self.claim]}-at-{x}" for x in ("least", "most"))
            found = [f"{low} {high}"] + ([] if truth else [low, high])
            bare = found if self.claim == "finishing-order" else []
            return "|".join([*(f"{pair} {x}" for x in found), *bare, "no-order-1"])
        if self.claim not in PROVES:
            not_covered(f"the claim {self.claim[:40]!r}")
        return PROVES[self.claim][0 if truth else 1]

    def chains_in_intervals(self, truth):
        """Return the lists of rules for a statement about decimals, beside the exact ones."""
        root, none = self.record.root is not None, "not-order|not-preconsistent"
        if self.claim in ORDERS:
            low = "" if truth or not root else "|implied-order"
            return f"implied-order not-order|order-at-least not-order|{none}{low}"
        if self.claim in SECOND:
            name, none = SECOND[self.claim], none + "|no-order-1"
            if truth:
                pair = (
                    "implied-order not-order" if root else "order-at-least order-at-most symmetric"
                )
                top = "finish-at-most" if name == "finish" else f"not-{name}"
                more = f"|order-at-least {name}-at-least {top}" if name == "stage-order" else ""
                return f"{pair} implied-{name} {top}|{none}{more}"
            below = f"|implied-order implied-{name}" if root else ""
            more = f"|order-at-least {name}-at-least{below}" if name == "stage-order" else ""
            return none + (f"|not-{name}{more}" if name != "finish" else "")
        if self.claim == "embedded-order":
            return "row+" if truth else "row+|row"
        return "implied" if truth or self.claim == "growth" else ""

    def check_order(self, low, high):
        """Refuse bounds that do not decide the declared order."""
        if self.rules in (["no-order-1"], ["not-preconsistent"]):
            low = high = 0
        p = self.declared
        if low is None and high == 0:
            low = 0
        if low is not None and high is not None:
            decided = low == high and (low == p) == self.holds
        elif low is not None:
            decided = not self.holds and low > p
        else:
            decided = not self.holds and high < p
        require(decided, f"the parts show {low} <= order <= {high}")


# -------------------------------------------------------------------------------- the command


def no_float(text):
    """Refuse a JSON number that is not whole."""
    raise Refused(f"{text[:40]} is a JSON number that is not whole")


def no_twins(pairs):
    """Refuse an object that has a key twice."""
    found = dict(pairs)
    require(len(found) == len(pairs), "a key stands twice in one object")
    return found


def read(path):
    """Return the texts of the certificates in a file: one, or one on each line."""
    try:
        with open(path, "rb") as file:
            text = file.read(MEGABYTES * 2**20 + 1).decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise Unreadable(f"it cannot be read: {error}") from error
    lines = [line for line in text.splitlines() if line.strip()]
    several = len(lines) > 1 and all(line[0] == "{" and line[-1] == "}" for line in lines)
    return lines if several and len(text) <= MEGABYTES * 2**20 else [text]


def verdict(certificate):
    """Return (accepted, sentence) for the value of one JSON file."""
    try:
        proof = Proof(certificate)
        proof.check()
    except Refused as refused:
        return False, str(refused)
    except (RecursionError, MemoryError, OverflowError):
        return False, "beyond the limits of this checker"
    except (ValueError, TypeError, KeyError, IndexError, AttributeError) as error:
        return False, f"a part has another shape ({type(error).__name__})"
    name, word = proof.method.document["name"], "holds" if proof.holds else "fails"
    return True, f"{name}: {proof.claim_text} {word} ({', '.join(proof.rules)})"


def check(text):
    """Return (accepted, sentence) for one certificate, within the limits of time and size."""
    if hasattr(signal, "SIGALRM"):
        signal.signal(signal.SIGALRM, beyond)
        signal.alarm(SECONDS)
    try:
        require(len(text) <= MEGABYTES * 2**20, "beyond the limits of this checker")
        return verdict(json.loads(text, parse_float=no_float, parse_constant=no_float,
                                  object_pairs_hook=no_twins))  # fmt: skip
    except json.JSONDecodeError as error:
        raise Unreadable(f"no JSON: {error}") from error
    except Refused as refused:
        return False, str(refused)
    except (RecursionError, ValueError):
        return False, "beyond the limits of this checker"
    finally:
        if hasattr(signal, "SIGALRM"):
            signal.alarm(0)


def main(arguments=None):
    """Check the files named and return the exit code."""
    parser = argparse.ArgumentParser(description="Check certificates of glmref-certificate-1.")
    parser.add_argument("files", nargs="+", metavar="FILE", help="one certificate, or one a line")
    code = 0
    for path in parser.parse_args(arguments).files:
        try:
            for text in read(path):
                accepted, sentence = check(text)
                sys.stdout.write(f"{path}: {'yes' if accepted else 'no'}: {sentence}\n")
                code = code if accepted else 1
        except Unreadable as error:
            sys.stderr.write(f"{path}: {error}\n")
            return 2
    return code


if __name__ == "__main__":
    sys.exit(main())
