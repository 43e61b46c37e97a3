"""Check certificates of format glmref-certificate-1 with Python's standard library only.

``python checker/glmref_check.py FILE...`` says ``yes`` or ``no`` and why for every certificate. The
sections below are those of docs/certificates.md; each function names the section it implements.
Exit code: 0 when all are accepted, 1 when one is refused, 2 when a file cannot be read.
"""

import argparse
import ast
import cmath
import json
import os
import pathlib
import re
import signal
import sys
from collections import namedtuple
from copy import copy
from fractions import Fraction
from functools import cache, lru_cache
from itertools import pairwise, product
from math import factorial

SECONDS = 60  # wall clock for one certificate
MEGABYTES = 32  # size of a file
TREES = 40_000  # trees of one order
DIMENSION = 64  # of a tower over the rationals
SIZE = 200  # rows and columns of a matrix of the document
DIGITS = 4000  # characters of an entry
PLACES = 448  # binary places of an interval
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
    """Tell whether a number does not reduce to the exact zero; an interval counts."""
    return type(x) in (Interval, Element) or bool(x)


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
        require(bool(alpha[-1]), "alpha_k is 0")
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

    def vectors_to_one(self, colour, consistent=False):
        """Return (u, whether it is the only one) with V u = u and U u = 1, u None where none is.

        Of a `consistent` method also B 1 + V v = u + v for some v: w u = w B 1 for all w = w V.
        """
        m = self.part(colour)
        shift = minus(m.V, identity(m.r))
        N, rows, right = kernel(shift), list(m.U), ones(len(m.U))
        if consistent:
            left = kernel(transpose(shift))
            rows, right = rows + left, right + apply(left, apply(m.B, ones(len(m.B[0]))))
        if not N:
            return None, True
        c, unique = solve([apply(N, row) for row in rows], right)
        return (None if c is None else apply(transpose(N), c)), unique

    def u(self, colour):
        """Return the u with V u = u and U u = 1, which must be the only one."""
        u, unique = self.vectors_to_one(colour)
        require(u is not None and unique, "there is not one u with V u = u, U u = 1")
        return u


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

    def __bool__(self):
        """Tell that the number is not 0; what does not reduce to 0 may be, in a ring."""
        box = enclose(self)
        return apart(box.re) or apart(box.im) or inverse(self) is not None

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
        # the same terms are another number in another tower
        return getattr(other, "tower", self.tower) is self.tower and vanishes(self - other)

    def __hash__(self):
        return hash(frozenset(self.terms.items()))


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

    def middle(self):
        """Return the midpoint, an interval without width."""
        return Interval((self.lo + self.hi) // 2, (self.lo + self.hi) // 2)

    def inside(self, other):
        """Tell whether the interval lies in the interior of another."""
        return other.lo < self.lo and self.hi < other.hi

    def meet(self, other):
        """Return the intersection."""
        return Interval(max(self.lo, other.lo), min(self.hi, other.hi))

    def __bool__(self):
        require(not self.lo <= 0 <= self.hi, "an interval holds 0: nothing is decided")
        return True

    def __add__(self, other):
        if type(other) is not Interval:
            if isinstance(other, Gradient | Box):
                return NotImplemented
            other = around(other)
        return Interval(self.lo + other.lo, self.hi + other.hi)

    __radd__ = __add__

    def __neg__(self):
        return Interval(-self.hi, -self.lo)

    def __mul__(self, other):
        a, b = self.lo, self.hi
        if type(other) is not Interval:
            if isinstance(other, Gradient | Box):
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
def rounded(x):
    """Return an interval around a rational."""
    return Interval.ends(Fraction(x), Fraction(x))


def around(x):
    """Return an interval around an exact number, which must be real."""
    if not isinstance(x, Element):
        return rounded(x)
    balls = x.tower.balls  # kept with the tower: each certificate has its own
    if x not in balls:
        require(conj(x) == x, "a number that must be real is not")
        balls[x] = enclose(x).re
    return balls[x]


class Box(Ring):
    """A closed rectangle: intervals around the real and the imaginary part."""

    __slots__ = ("im", "re")

    def __init__(self, re, im=Fraction(0)):
        self.re, self.im = Interval.of(re), Interval.of(im)

    def __add__(self, other):
        other = other if type(other) is Box else Box(other)
        return Box(self.re + other.re, self.im + other.im)

    def __mul__(self, other):
        if type(other) is not Box:
            return Box(self.re * other, self.im * other)
        (a, b), (c, d) = (self.re, self.im), (other.re, other.im)
        return Box(a * c - b * d, a * d + b * c)

    __radd__, __rmul__ = __add__, __mul__

    def conj(self):
        """Return the rectangle of the conjugates."""
        return Box(self.re, -self.im)

    def middle(self):
        """Return the midpoint, a rectangle without width."""
        return Box(self.re.middle(), self.im.middle())

    def inside(self, other):
        """Tell whether the rectangle lies in the interior of another."""
        return self.re.inside(other.re) and self.im.inside(other.im)

    def meet(self, other):
        """Return the intersection."""
        return Box(self.re.meet(other.re), self.im.meet(other.im))


def horner(coefficients, x):
    """Return the value of a polynomial, constant first."""
    value = coefficients[-1]
    for c in reversed(coefficients[:-1]):
        value = value * x + c
    return value


def derivative(p):
    """Return p' of a list of coefficients, constant first."""
    return [k * c for k, c in enumerate(p)][1:] or [Fraction(0)]


def root_in(p, box):
    """Return the one root of p in an interval or a rectangle, by the operator of Krawczyk.

    It maps the box into its interior: m - Y p(m) + (1 - Y p'(X)) (X - m), Y about 1 / p'(m).
    """
    slopes = derivative(p)
    for step in range(12):
        m = box.middle()
        Y = inverse(horner(slopes, m).middle())
        image = m - Y * horner(p, m) + (1 - Y * horner(slopes, box)) * (box - m)
        require(step or image.inside(box), "a box is not shown to hold one root")
        box = image.meet(box)
    return box


class Tower:
    """The rationals with generators; arithmetic by reduction, enclosures by bisection (2)."""

    def __init__(self, generators=()):
        self.names, self.degrees, self.polynomials, self.roots = [], [], [], []
        self.real, self.conjugates, self.inverses, self.starts = [], [], {}, []
        self.tables, self.basis, self.index, self.balls = {}, [()], {(): 0}, {}
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
        real_, p = ends[1] == [0, 0], [enclose(x) for x in [*self.polynomials[-1], Fraction(1)]]
        box = Box(*(Interval.ends(*x) for x in ends))
        if real_:
            fine = all(x.im.lo == 0 == x.im.hi for x in p)
            require(fine, "the polynomial of a real generator is not real")
            p, box = [x.re for x in p], box.re
        self.starts.append(box)
        box = root_in(p, box)
        self.roots.append(Box(box) if real_ else box)
        self.real.append(real_)
        self.names.append(entry["name"])
        self.degrees.append(degree)
        old = self.basis
        self.basis = [(*e, k) for k in range(degree) for e in old]  # old indices keep their place
        self.index = {e: k for k, e in enumerate(self.basis)}
        self.tables, self.inverses = {}, {}

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
        return parse(text, names.get, radical)

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
        require(not self.real[k], "a real generator is its own conjugate")
        value = self.parse(entry["conjugate"])
        mirrored = [conj(c) for c in self.polynomials[k]] + [Fraction(1)]
        require(vanishes(horner(mirrored, value)), f"the conjugate of {name} is no conjugate root")
        mirror, box = self.starts[k], enclose(value)
        require(box.inside(mirror.conj()), f"the conjugate of {name} is another root")
        self.conjugates.append(value)


def enclose(x):
    """Return a rectangle around a number."""
    if not isinstance(x, Element):
        return Box(x)
    value = Box(Fraction(0))
    for k, c in x.terms.items():
        term = Box(c)
        for root, power in zip(x.tower.roots, x.tower.basis[k], strict=True):
            for _ in range(power):
                term = term * root
        value = value + term
    return value


def conj(x):
    """Return the conjugate of a number."""
    return x.conj() if isinstance(x, Element | OnAxis | Box) else x


def inverse(x):
    """Return 1 / x."""
    if type(x) is Box:
        return x.conj() * inverse(x.re * x.re + x.im * x.im)
    if isinstance(x, Element):
        return x.tower.inverse(x)
    require(x, "a division by 0")
    if type(x) is Interval:
        return Interval(4**PLACES // x.hi, -(-(4**PLACES) // x.lo))
    return 1 / Fraction(x)


def sign(x):
    """Return the sign of a number that is its own conjugate."""
    if isinstance(x, Element):
        require(conj(x) == x, "a sign is asked of a number that is not real")
        x = enclose(x).re
    if type(x) is Interval:
        return 1 if x and x.lo > 0 else -1
    return (x > 0) - (x < 0)


def real(x):
    """Return the real part."""
    return (x + conj(x)) * Fraction(1, 2)


def upper(x):
    """Tell whether the imaginary part is shown to be positive."""
    return enclose(x).im.lo > 0


def rational(text):
    """Return a rational number written as a string."""
    found = isinstance(text, str) and re.fullmatch(r"-?[0-9]+(/[0-9]+)?", text)
    require(found and len(text) <= DIGITS, f"{str(text)[:40]!r} is no rational number")
    top, _, bottom = text.partition("/")
    require(int(bottom or 1), "a division by 0")
    return Fraction(int(top), int(bottom or 1))


FUNCTIONS = ("sqrt", "root", "exp")
CHARACTERS = r"[-+*/(),.0-9A-Za-z_]+"
BLANK = r"[ \t\n\r\f\v]"
OPERATIONS = {
    ast.Add: lambda x, y: x + y, ast.Sub: lambda x, y: x - y, ast.Mult: lambda x, y: x * y,
    ast.Div: lambda x, y: x * inverse(y), ast.UAdd: lambda x: x, ast.USub: lambda x: -x,
}  # fmt: skip


def plain(text):
    """Return an entry without blanks and without zeros that begin a number, as in 01."""
    return re.sub(r"(?<![.\w])0+(?=[0-9])", "", re.sub(BLANK, "", text))


def parse(text, name, radical=None, written_out=str, decimal=None):
    """Return the number that an entry stands for (data contract).

    It depends on the number of a name, of the text of a radical with all constants `written_out`,
    and of a decimal.
    """
    require(isinstance(text, str) and 0 < len(text) <= DIGITS, "an entry is no short string")
    require(not re.search(rf"[.\w]{BLANK}+[.\w]", text), "a blank stands inside a number or a name")
    text = plain(text)
    require(re.fullmatch(CHARACTERS, text), f"{text[:40]!r} is no entry")

    def value(node):
        kind, own = type(node), text[node.col_offset : node.end_col_offset]
        if kind is ast.Constant and own.isdigit():
            return Fraction(int(own))
        if kind is ast.Constant and re.fullmatch(r"[0-9]*\.[0-9]*", own):
            require(decimal, "a decimal is no exact number")
            return decimal(own)
        if own == "i" or (kind is ast.Call and getattr(node.func, "id", "") in FUNCTIONS):
            require(radical, "a radical stands where none may")
            return radical(written_out(own))
        if kind is ast.Name:
            found = name(own)
            require(found is not None, f"nothing is called {own[:40]!r}")
            return found
        known = kind in (ast.BinOp, ast.UnaryOp) and type(node.op) in OPERATIONS
        require(known, "an entry breaks the grammar")
        inner = (node.left, node.right) if kind is ast.BinOp else (node.operand,)
        return OPERATIONS[type(node.op)](*map(value, inner))

    try:
        return value(ast.parse(text, mode="eval").body)
    except SyntaxError:
        raise Refused(f"{text[:40]!r} is no entry") from None


class Numbers:
    """The field of a certificate: reads entries and checks radicals (2)."""

    def __init__(self, field):
        kind = field.get("kind") if isinstance(field, dict) else None
        more = {"rational": "", "tower": "generators radicals", "balls": "generators radicals",
                "enclosure": "generators radicals"}  # fmt: skip
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
        require(x**power == parse(inner, lambda name: None, self.radical), wrong)
        if not x:
            return
        half = vanishes(real(x)) and upper(x) if kind == "sqrt" else False
        require(half or (enclose(x).re.lo > 0 and (kind == "sqrt" or conj(x) == x)), wrong)

    @staticmethod
    def check_root_of_unity(inner, x, wrong):
        """Refuse x unless x^n = 1 and x is nearer to the angle than other roots are."""
        turns = parse(inner, {"pi": Fraction(1, 2)}.get, lambda text: Fraction(1))
        factors = sorted(re.findall("[a-z]+", inner)) if turns else ["i", "pi"]
        fine = factors == ["i", "pi"] and not re.search(r"/\D|[\w)][-+]", inner)  # no sum
        require(fine, f"not covered: the angle {inner[:40]}")
        n, box = turns.denominator, enclose(x)
        require(n <= 100 and x**n == 1, wrong)
        # the n-th roots are 4/n apart at least, so that floating-point numbers tell which one it is
        middle = complex(box.re.middle().lo / 2**PLACES, box.im.middle().lo / 2**PLACES)
        require(abs(middle - cmath.exp(2j * cmath.pi * float(turns % 1))) * n < 1, wrong)

    def name(self, document, name):
        """Return the value of a constant or unknown of the document."""
        memory = self.memory.setdefault(id(document), (document, {}))[1]  # keeps the object
        if name not in memory:
            memory[name] = None  # a constant that uses itself finds nothing
            own = document.get("constants", {})
            require(isinstance(own, dict), "constants are an object")
            if name in document.get("unknowns", {}):
                require(name in self.unknowns and name not in own, "an unknown")
                memory[name] = self.unknowns[name]
            elif name in own:
                above = {*list(own)[: list(own).index(name)], *document.get("unknowns", {})}
                memory[name] = self.entry(own[name], document, above)
        return memory[name]

    def entry(self, text, document, allowed=None):
        """Return the number of an entry of a document."""
        constants = document.get("constants", {})

        def known(name):
            return self.name(document, name) if allowed is None or name in allowed else None

        def written_out(text):
            text = re.sub(r"[A-Za-z_][A-Za-z_0-9]*", lambda m: f"({written_out(constants[m[0]])})"
                          if m[0] in constants else m[0], plain(text))  # fmt: skip
            require(len(text) <= DIGITS, "beyond the limits of this checker")
            return text

        def decimal(number):
            if not Fraction(number):
                return Fraction(0)  # 0.000 of a table is 0
            require(self.decimal is not None, "a decimal is no exact number")
            return self.decimal(number)

        return parse(text, known, self.radical, written_out,
                     decimal if "digits" in document else None)  # fmt: skip

    def vector(self, texts, document=None):
        """Return a list of entries of the document, or of a witness."""
        require(isinstance(texts, list) and 0 < len(texts) <= SIZE, "a list of numbers is missing")
        if document is None:
            return [self.number(text) for text in texts]
        return [self.entry(text, document) for text in texts]

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
    place = next((k for k, x in enumerate(u) if bool(x)), None)
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


def through(method, order, nystrom):
    """Return the trees through an order that count."""
    return [t for n in range(1, order + 1) for t in pool_of(method, n, nystrom)]


def check_start_along_paths(method, start, p, nystrom):
    """Refuse unless the values of a start use stages that are the solution far enough (4)."""
    if "starting" not in method.document:
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


def as_object(value):
    """Return an object of the certificate."""
    require(isinstance(value, dict), "an object is missing")
    return value


def preconsistent(proof, w, consistent=False):
    """Rules preconsistent and consistent."""
    for c in proof.method.parts:
        require(proof.method.vectors_to_one(c, consistent)[0] is not None, "u does not exist")


def not_preconsistent(proof, w, consistent=False):
    """Rules not-preconsistent and no-order-1."""
    require(proof.method.vectors_to_one(w["colour"], consistent)[0] is None, "u may exist")


def asked(proof, w):
    """Return (order, identity?, which trees) of a witness."""
    identity_mode, nystrom = mode(w)
    return whole(w["order"], 0, 20 if nystrom in PATHS else 14), identity_mode, nystrom


def order_at_least(proof, w):
    """Rule order-at-least: U u = 1, and W R(t) = 0 for every tree through the order."""
    p, identity_mode, nystrom = asked(proof, w)
    series = proof.series(identity_mode, nystrom, p)
    for c, u in series.u.items():
        m = proof.method.part(c)
        equal(apply(m.U, u), ones(len(m.U)), f"U u = 1 ({c})")
    for tree in through(proof.method, p, nystrom):
        require(vanishes(series.condition(tree)), f"the condition of tree {show(tree)}")
    if nystrom in PATHS:  # stages are the solution on the paths below the order
        require(proof.method.separable and series.simple, "paths decide for separable pairs")
        for colour in PATHS[nystrom] if p > 1 else "":
            reached = min(path_orders(proof.method, series, colour, p - 1))
            require(reached >= p - 1, f"a stage of {colour} is not the solution")
    proof.low = p, identity_mode, nystrom


def order_at_most(proof, w):
    """Rule order-at-most: W R(t) is not 0 for a tree of order p + 1."""
    p, identity_mode, nystrom = asked(proof, w)
    series = proof.series(identity_mode, nystrom, p + 1)
    if nystrom in PATHS:
        require(proof.low == (p, identity_mode, nystrom), "paths prove both bounds, or none")
        gaps = [x for t in pool_of(proof.method, p + 1, nystrom) for x in series.condition(t)]
        gaps = gaps if identity_mode else [total(gaps)]  # beta may be added to one, and taken away
    elif not series.simple and p:
        require(series.last == p and not series.loose, "the next order may hold")
        gaps = [1]
    else:
        gaps = series.condition(named_tree(proof, w, p + 1, nystrom))
    require(any(map(apart, gaps)), "the conditions of the next order may hold")
    proof.high = p, identity_mode, nystrom


def named_tree(proof, w, order, nystrom):
    """Return the tree of a witness, which must be one of this order."""
    tree = read_tree(w.get("tree"))
    require(tree in pool_of(proof.method, order, nystrom), "the tree has another order")
    return tree


def known_order(proof, q):
    """Return the order that the series of a bound q rests on; without one, an order above it."""
    require(not proof.high or proof.low == proof.high, "the order is not enclosed")
    p = proof.high[0] if proof.high else q + 1
    require(q <= p, "the bound is above the order")
    return p


def stage_defect(series, tree, last):
    """Return xi(t) - c^|t| / gamma(t), z times it at the `last` order: U N beta may be added there.

    z are the rows with z U N = 0.
    """
    c, method = series.stages((tree[0], ())), series.method
    gap = less(series.stages(tree), [x ** size(tree) * Fraction(1, gamma(tree)) for x in c])
    if not last or not series.free or all(m.r == 1 for m in method.parts.values()):
        return gap
    N, U = series.N[tree[0]], method.part(tree[0]).U
    moved = [apply(U, n) for n in N] if len(N) > 1 else [ones(len(U))]  # U u = 1
    require(is_exact(moved), "not covered: decimals in U where the eigenvalue 1 of V is multiple")
    return apply(kernel(moved), gap)


def stage_order_at_least(proof, w):
    """Rule stage-order-at-least; c is what the stages are at the single vertices."""
    q = whole(w["q"])
    require(proof.low and q <= proof.low[0], "the stage order is above the order")
    p, *kind = proof.low
    known = proof.low == proof.high or (proof.high and q < p) or (proof.low[1] and proof.mode()[0])
    require(known, "the order is not enclosed")
    series = proof.series(*kind, q, filled=True)
    for tree in through(proof.method, q, kind[1]):
        fine = size(tree) == 1 or vanishes(stage_defect(series, tree, size(tree) == p))
        require(fine, f"the stages are wrong at tree {show(tree)}")
    return q


def stage_order_at_most(proof, w):
    """Rule stage-order-at-most: where the order is not known, a multiple of ones is free."""
    q, kind = whole(w["q"]), proof.mode()
    p = known_order(proof, q)
    if q == p:
        require(proof.high, "the order is not part of the certificate")
        return q
    tree, series = named_tree(proof, w, q + 1, kind[1]), proof.series(*kind, q + 1, filled=True)
    require(not series.loose, "other principal parts may be right")
    gap = stage_defect(series, tree, q + 1 == p)
    require(any(map(apart, gap)), "the stages may be right at the tree")
    return q


def start_of(method):
    """Return the series of the file's start; a pair without one has (y0, 0, ..)."""
    table = method.document.get("starting")
    if table is None:
        require(method.pair, "the file has no start")
        zero = [[Fraction(0)]]
        tables = {c: (zero, zero * m.r) for c, m in method.parts.items()}
        u = {c: [Fraction(int(k == 0)) for k in range(m.r)] for c, m in method.parts.items()}
        return Series.of_tables(tables, u)
    hats = {"o": ""} if not method.pair else {"f": "", "k": "_hat"}
    keys(table, " ".join(f"A{h} B{h} u{h}" for h in hats.values()), "name kind order", "start")
    tables = {c: (method.matrix("A" + h, table), method.matrix("B" + h, table))
              for c, h in hats.items()}  # fmt: skip
    u = {c: method.list("u" + h, table) for c, h in hats.items()}
    for c, (_, B) in tables.items():
        require(len(B) == len(u[c]) == method.part(c).r, "the start has another number of values")
    return Series.of_tables(tables, u)


def start_gap(proof, order, p, nystrom):
    """Return the function that gives start(t) - eta(t) through an order.

    Of one method eta is moved along the flow, so that it agrees with the start in what is read at
    the single vertex, and at order p it may be moved by eigenvectors N beta.
    """
    method, start = proof.method, start_of(proof.method)
    free = not method.pair
    require(not free or not method.system, "a start of a Rosenbrock method")
    series = proof.series(not free, nystrom, order, filled=True)
    if nystrom in PATHS:
        check_start_along_paths(method, start, p, nystrom == "nystrom-paths")

    def gap(tree):
        found = less(start.value(tree), series.eta_of(tree))
        if free:
            found = less(found, series.shift(tree, sigma))
        if free and size(tree) == p:
            W, N = series.W["o"], series.N["o"]
            return less(found, apply(transpose(N), apply(W, found)))
        return found

    sigma = Fraction(0)
    if free and order:
        single = less(start.value(LEAF), series.eta_of(LEAF))
        sigma = dot(reading(method, "o", series.u["o"]), single)
    return start, series, gap


def start_at_least(proof, w):
    """Rule start-at-least."""
    q = whole(w["q"])
    require(proof.low and proof.low == proof.high and q <= proof.low[0], "the order is open")
    p, _, nystrom = proof.low
    start, series, gap = start_gap(proof, q, p, nystrom)
    for c, u in series.u.items() if q else ():
        equal(start.u[c], u, "u of the start")
    for tree in through(proof.method, q, nystrom):
        require(vanishes(gap(tree)), f"the start at tree {show(tree)}")
    return q


def start_at_most(proof, w):
    """Rule start-at-most: a tree at which the start is wrong, or q is the order."""
    q, nystrom = whole(w["q"]), proof.low[2] if proof.low else proof.mode()[1]
    p = known_order(proof, q)
    if q == p:
        require(proof.high, "the order is not part of the certificate")
        return q
    require(proof.high or q == 0 or proof.method.pair, "the order is not known")
    start, series, gap = start_gap(proof, min(q + 1, p), p if proof.high else q + 2, nystrom)
    require(not series.loose, "other principal parts may be right")
    if w["tree"] == "":
        gaps = [x - y for c, u in series.u.items() for x, y in zip(start.u[c], u, strict=True)]
        require(q == 0, "u belongs to order 0")
    else:
        gaps = gap(named_tree(proof, w, q + 1, nystrom))
    require(any(map(apart, gaps)), "the start may be right at the tree")
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
    require(proof.low and whole(w["q"]) <= proof.low[0], "the finish is above the order")
    for tree in through(proof.method, w["q"], False):
        require(vanishes(finish_defect(proof, tree)), f"the finish is wrong at {show(tree)}")
    return w["q"]


def finish_at_most(proof, w):
    """Rule finish-at-most: a tree, or the order of the method."""
    q = whole(w["q"], 0, 14)
    if "tree" in w:
        gap = finish_defect(proof, named_tree(proof, w, q + 1, False))
        require(bool(gap), "the finish is right at the tree")
    else:
        require(proof.high and q == known_order(proof, q), "the finish has another order")
    return q


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
            if not (is_nil(a) or is_nil(b)):
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


def is_unbounded(M):
    """Tell whether the powers of M are not bounded: a root outside, or a defective one on it.

    What the characteristic polynomial shares with its mirror image is q, the rest is h.
    """
    p = characteristic(M)
    if not in_disc(p):
        return True
    h, q = p, [Fraction(1)]
    while not live(h[0]):
        h = h[1:]
    inside = p[: len(p) - len(h)]  # the roots 0, which the mirror image has at infinity
    while len(h) > 1 and len(shared := gcd(h, mirror(h))) > 1:
        h, q = divide(h, shared)[0], multiply(q, shared)
    require(is_schur(h), "a root on the circle is left")
    left = at_matrix(divide(q, gcd(q, derivative(q)))[0], M)
    rest = at_matrix(inside + h, M)
    for _ in M:  # rad(q)(M) h(M)^r is 0 where no root of q is defective
        left = times(left, rest)
    return not vanishes(left)


def bounded(proof, w):
    """Rule bounded: the powers of V are bounded.

    Where V holds decimals: of its diagonal blocks those with decimals have all eigenvalues inside
    the circle, and so have the exact ones but at most one.
    """
    V = proof.method.part(w["which"]).V
    if not is_exact(V):
        others = [block for block in blocks_of(V) if not is_schur(characteristic(block))]
        require(len(others) < 2, "several blocks have eigenvalues on the circle")
        V = others[0] if others else [[Fraction(0)]]
    require(not is_unbounded(V), "an eigenvalue is outside the circle, or defective on it")
    proof.stable.add(w["which"])


def unbounded(proof, w):
    """Rule unbounded: an eigenvalue outside, or a defective one on the circle, or of a block."""
    V = proof.method.part(w["which"]).V
    if "block" in w:
        blocks = blocks_of(V)
        V = blocks[whole(w["block"], 0, len(blocks) - 1)]
    require(is_unbounded(V), "the powers of V are bounded")


def eigen(proof, w):
    """Rule eigen: all eigenvalues of modulus 1, semisimple; the rest of det(x I - V) is Schur."""
    V, found = proof.method.part(w["which"]).V, []
    h = characteristic(V)
    require(is_exact(V) and isinstance(w["zeta"], list), "the eigenvalues are a list, V is exact")
    for z in map(proof.method.numbers.number, w["zeta"]):
        require(squared(z) == 1, "an eigenvalue is not of modulus 1")
        require(all(bool(z - other) for other, _, _ in found), "an eigenvalue is there twice")
        shift = minus(V, diagonal([z] * len(V)))
        N, W = kernel(shift), kernel(transpose(shift))
        require(N, "an eigenvalue is none")
        W = times(inverse_matrix(times(W, transpose(N))), W)
        for _ in N:
            h, rest = divide(h, [-z, Fraction(1)])
            require(vanishes(rest), "an eigenvalue is none")
        found.append((z, W, transpose(N)))
    require(is_schur(h), "another eigenvalue is not inside the circle")
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
    single = all(len(W) == 1 for found in proof.eigen.values() for z, W, _ in found if not z - 1)
    left, right = ([z for z, *_ in proof.eigen[c] if all(z - e[0] for e in proof.eigen[d])]
                    for c, d in ("fk", "kf"))  # fmt: skip
    known = single and (proof.method.separable or not left + right)
    one_grows = proof.claim == "parasitism-free" and "grows" in proof.rules
    require(known or one_grows, "1 is multiple, or other eigenvalues meet in shared stages")
    children = dict(proof.method.palette)
    for z, *_ in proof.eigen["f"]:
        spaces = {c: next((e for e in proof.eigen[c] if not bool(e[0] - z)), None) for c in m}
        if not bool(z - 1) or spaces["k"] is None:
            continue
        simple = all(len(e[1]) == 1 for e in spaces.values())
        require(simple or proof.claim == "parasitism-free", "a shared eigenvalue is not simple")
        groups.append((z, [scale(conj(z), times(spaces[c][1], m[c].B, m[e].U, spaces[e][2]))
                           for c, others in children.items() for e in others
                           if e != c or proof.claim == "parasitism-free"]))  # fmt: skip
    return groups


def unshared(proof, w):
    """Rule unshared: V and V^ of a separable pair share the simple eigenvalue 1 and no other."""
    require(proof.method.separable, "the pair is not separable")
    ends = [characteristic(m.V) for m in proof.method.parts.values()]
    require(gcd(*ends) == [-1, 1], "an eigenvalue other than 1 is shared, or none is")
    simple = all(bool(horner(derivative(p), Fraction(1))) for p in ends)
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
    groups, free = growth_groups(proof), proof.claim == "parasitism-free"
    given = declared_groups(proof, groups)
    for (z, matrices), mine in zip(groups, given, strict=True):
        require(vanishes(growth_gap(proof, z, matrices, mine)), "a parameter is another one")
        if free and not proof.method.pair and (bool(z - 1) or len(matrices[0]) > 1):
            require(rank(matrices[0]) == int(not bool(z - 1)), "a growth matrix is not 0")


def growth_gap(proof, z, matrices, numbers):
    """Return numbers that are all 0 where the parameters at an eigenvalue are these.

    One method: det(x I - M) minus the product of (x - mu), times x - 1 for zeta = 1. Pairs: M.
    """
    if proof.method.pair:
        require(vanishes(numbers), "not covered: growth parameters of pairs that are not 0")
        return [x for M in matrices for row in M for x in row]
    one = [] if bool(z - 1) else [Fraction(1)]
    if one and len(matrices[0]) == 1 and not numbers:
        return []  # a simple eigenvalue 1 has no parasitic component
    return plus(characteristic(matrices[0]), from_roots(numbers + one), -1)


def declared_groups(proof, groups):
    """Return the declared list in groups; for parasitism-free zeros."""
    sizes = [sum(len(M) - int(not bool(z - 1)) for M in Ms) for z, Ms in groups]
    if proof.claim == "parasitism-free":
        return [[Fraction(0)] * n for n in sizes]
    numbers = proof.claimed(proof.declared)
    require(len(numbers) == sum(sizes), "the declared list has another length")
    return [[numbers.pop(0) for _ in range(n)] for n in sizes]


def grows(proof, w):
    """Rule grows: the parameters of one part are other ones than declared."""
    free, single = proof.claim == "parasitism-free", not proof.method.pair
    if w["part"] == -1:
        if single:  # the eigenvalues alone say how many there are
            count = sum(len(W) - int(not bool(z - 1)) for z, W, _ in proof.eigen["o"])
        else:
            count = sum(len(M) for _, Ms in growth_groups(proof) for M in Ms)
        require(not free and len(proof.declared) != count, "the number of parameters is right")
        return
    groups = growth_groups(proof)
    k = whole(w["part"], 0, len(groups) - 1)
    z, matrices = groups[k]
    gaps = growth_gap(proof, z, matrices, declared_groups(proof, groups)[k])
    if free and single:
        gaps = gaps if not bool(z - 1) else [x for row in matrices[0] for x in row]
        if not bool(z - 1) and is_exact(matrices[0]) and rank(matrices[0]) != 1:
            return
    require(any(map(apart, gaps)), "the growth parameters are as declared")


# ------------------------------------------------ section 5: quadratic forms, symmetry, structure


def form_defects(method, G, D, star_=star):
    """Return left - right of each identity; D is a list, for pairs (D_P, D_Q)."""
    if not method.pair:
        m = method.parts["o"]
        B, E = star_(m.B), diagonal(D)
        return [minus(G, times(star_(m.V), G, m.V)), minus(times(E, m.U), times(B, G, m.V)),
                minus(combine(times(E, m.A), times(star_(m.A), E)), times(B, G, m.B)),
                minus([D], star_(transpose([D]))),
                minus(G, star_(G))]  # fmt: skip
    q, p, (D_P, D_Q) = method.parts["f"], method.parts["k"], map(diagonal, D)
    shared = [] if method.separable else [[less(*D)]]
    return [minus(times(star_(q.V), G, p.V), G), minus(times(D_P, p.U), times(star_(q.B), G, p.V)),
            minus(times(D_Q, q.U), times(star_(p.B), star_(G), q.V)), *shared,
            minus(combine(times(D_P, p.A), times(star_(q.A), D_Q)), times(star_(q.B), G, p.B)),
            minus([D[0] + D[1]], star_(transpose([D[0] + D[1]])))]  # fmt: skip


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
    require(vanishes(form_defects(method, G, D)), "an identity of the form does not hold")
    require(bool(energy(method, G)), "u^* G u is 0")


def given_form_fails(proof, w):
    """Rule given-form-fails: with the G (and D) of the file one identity does not hold."""
    method = proof.method
    G, D = given_form(method)
    require(G is not None, "the file gives no G")
    if D is None:  # D = B^* G u, the only D that the second identity times u allows
        m, last = method.parts, list(method.parts)[-1]
        D = apply(star(next(iter(m.values())).B), apply(G, method.u(last)))
        if method.pair:
            D = D, apply(star(m["k"].B), apply(star(G), method.u("f")))
    fails = any(map(apart, entries(form_defects(method, G, D))))
    require(fails or vanishes(energy(method, G)), "the identities may hold")


def entries(matrices):
    """Return the entries of matrices."""
    return [x for M in matrices for row in M for x in row]


def no_form(proof, w):
    """Rule no-form, for real methods: every form that satisfies the identities has u^* G u = 0."""
    method = proof.method
    require("G" not in method.document, "the file gives a form")
    if any(conj(x) != x for x in entries(M for m in method.parts.values() for M in m)):
        not_covered("no-form for complex methods")
    units = list(unit_forms(method))
    # a combination of the equations is u^* G u
    combination, _ = solve([entries(form_defects(method, *x)) for x in units],
                           [energy(method, G) for G, _ in units])  # fmt: skip
    require(combination is not None, "there is a form")


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


def quadratic_defects(method):
    """Return the defects of the form G = 1, D = b of a method with one value (claim symplectic)."""
    for m in method.parts.values():
        require(m.r == 1 and m.V == [[1]] and m.U == [[1]] * len(m.U), "not one value carried")
    D = [m.B[0] for m in method.parts.values()]
    return entries(form_defects(method, [[Fraction(1)]], D if method.pair else D[0], transpose))


def quadratic(proof, w):
    """Rule quadratic."""
    require(vanishes(quadratic_defects(proof.method)), "an identity does not hold")


def not_quadratic(proof, w):
    """Rule not-quadratic."""
    several = any(m.r > 1 for m in proof.method.parts.values())
    require(several or "several-values" not in w, "one value is carried")
    require(several or any(map(apart, quadratic_defects(proof.method))), "the identities may hold")


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
    """Rule not-symmetric: a V is singular, or no P that the stages allow has an L."""
    method = proof.method
    if "singular" in w:
        V = method.part(w["singular"]).V
        require(rank(V) < len(V), "V is regular")
        return
    for P in involutions(method):
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


def later(needed):
    """Return the stages left over when one after another is evaluated: each needs one of them."""
    done = set()
    while ready := {stage for stage, x in needed.items() if x <= done} - done:
        done |= ready
    return set(needed) - done


def explicit(proof, w):
    """Rule explicit: each stage needs earlier ones only, in some order."""
    require(not later(needs(proof.method)), "a stage needs a later one")


def implicit(proof, w):
    """Rule implicit: some stages surely need each other."""
    require(later(needs(proof.method, surely=True)), "the stages may be explicit")


def abscissae_of(proof):
    """Return c = A 1 + U v of each part, v with 0 in what is read as the solution."""
    require(not proof.method.pair, "the abscissae of pairs")
    series = proof.series(True, False, 1, filled=True)
    return [x for c in proof.method.parts for x in series.stages((c, ()))]


def abscissae(proof, w):
    """Rule abscissae, of a consistent method."""
    preconsistent(proof, w, consistent=True)
    equal(abscissae_of(proof), proof.claimed(proof.declared), "the list of abscissae")


def other_abscissae(proof, w):
    """Rule other-abscissae: 1 is a simple eigenvalue, so that c is the only one there may be."""
    c, given = abscissae_of(proof), proof.claimed(proof.declared)
    simple = proof.series(True, False, 1).simple
    fine = len(c) != len(given) or (simple and any(map(apart, less(c, given))))
    require(fine, "the abscissae may be as declared")


def error_constant(proof, w, same=True):
    """Rules error-constant and other-error-constant."""
    require(proof.method.kind in ("lmm", "one-leg"), "only multistep methods have one")
    alpha, beta = proof.method.multistep()
    for q in range(40):
        C = dot(alpha, [Fraction(m**q) for m in range(len(alpha))])
        if q:
            C = C - q * dot(beta, [Fraction(m ** (q - 1)) for m in range(len(beta))])
        if C:
            break
    require(C, "the order is another one")
    if not same and vanishes(total(beta)):
        return  # no error constant
    C = C * Fraction(1, factorial(q)) * inverse(total(beta))
    gap = C - proof.claimed([proof.declared])[0]
    require(vanishes(gap) if same else bool(gap), "the error constant is (not) the declared one")


def ranks_are_less(method, c):
    """Tell whether a value is never seen, and never reached, None where intervals leave it open."""
    m, seen = method.part(c), list(method.part(c).U)
    for _ in range(m.r - 1):
        seen += times(seen[-len(m.U) :], m.V)

    def reached():
        u, _ = method.vectors_to_one(c)  # the difference of two is never seen
        rows = ([u] if u else []) + transpose(m.B)
        for _ in range(m.r - 1):
            rows += [apply(m.V, x) for x in rows[-len(m.B[0]) :]]
        return rows

    for rows in (lambda: seen, reached):
        try:
            yield rank(rows()) < m.r
        except Refused:
            yield None


def reducible(proof, w, wanted=True):
    """Rules reducible and irreducible: whether a value is never reached or never seen."""
    found = {x for c in proof.method.parts for x in ranks_are_less(proof.method, c)}
    require(True in found if wanted else found == {False}, "the method is reducible, or is not")


def equivalent(proof, w):
    """Rule equivalent: the method with the same A and these U, B, V makes the same steps.

    U V^k B agree for k < r + r'. The parts that follow are about this method.
    """
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
        if bool(value):
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


def not_a_stable(proof, w):
    """Rule not-a-stable."""
    require(isinstance(w, dict) and len(w) == 1, "one reason is given")
    ((reason, value),) = w.items()
    m = proof.method.single()
    if reason == "y":
        require(is_unbounded(at_imaginary(m, rational(value))), "M(i y) is power-bounded")
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
    m = proof.method.single()
    last = at_infinity(stability_polynomial(m))
    zero = len(last) == m.r + 1 and vanishes(last[:-1])
    if not wanted and len(last) == m.r + 1:
        zero = not any(map(bool, last[:-1]))
    require(zero == wanted, "the limit is (not) a multiple of w^r")


# ------------------------------------------------ section 6: intervals, and numbers with gradients


def apart(x):
    """Tell whether a number is shown not to be 0; an interval around 0 is not."""
    return not x.lo <= 0 <= x.hi if type(x) is Interval else bool(x)


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
        terms = {k: x for k, x in terms.items() if not is_nil(x)}
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
    require(bool(norm) and conj(norm) == norm, "v^* G v is 0 or not real")
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
            if bool(x - 1) and all(bool(x - y) for y in found):
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
        self.xi = {read_tree(t): self.numbers.entry(x, document)
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
        return self.exact.entry(text, {})

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

    def starts_at_two(self):
        """Tell whether equations `start K` give zeta(o) = 0 (6.3)."""
        if self.r == 1:
            return True
        L = self.reversal()["o"]
        basis = kernel([row[1:] for row in combine(L, identity(self.r))])
        values = [i for kind, i, t in self.equations if kind == "start" and t == LEAF]
        return len(basis) == 1 and any(k and bool(basis[0][k - 1]) for k in values)

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
        """Return the series with principal parts 0, with eta below the order; the root moves."""
        found = Solved(self.at(values), True, nystrom)
        found.pool = lambda n: listed(n, nystrom)
        found.advance(order)
        return found

    def residuals(self, values):
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

    def is_zero_start(self, t, k, L):
        """Tell whether zeta_k(t) = 0 by an equation `start` or by parity."""
        if ("start", t, k) in self.equations:
            return True
        off = any(bool(x) for j, x in enumerate(L[t[0]][k]) if j != k)
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
                   if bool(self.G[k][l]))  # fmt: skip

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
    """A start or finish whose decimals are unknowns, equal decimals one unknown, with its proof."""

    def __init__(self, numbers, document, proof=None, more=""):
        self.unknowns, self.numbers = {}, numbers.changed(decimal=self.unknown, unknowns={})
        self.digits, self.proof = document.get("digits", 75), proof
        if proof is not None:
            keys(proof, "radius centre inverse conditions" + more, where="proof")

    def unknown(self, text):
        """Return the unknown that a decimal stands for."""
        require(len(text.partition(".")[2]) >= 20, "a decimal of a start has few places")
        return Linear({self.unknowns.setdefault(text, len(self.unknowns)): Fraction(1)})

    def matrix(self, rows):
        """Return the entries, expressions in the unknowns."""
        return self.numbers.matrix(rows, {"digits": 75})

    def root(self, gaps, wanted, may_lack=lambda label: False):
        """Return intervals around the one root of the conditions, in the order of the proof.

        They are all that are `wanted`, less some that hold exactly, where these may be missing.
        """
        labels = [(whole(k, 0, SIZE), read_tree(t)) for k, t in self.proof["conditions"]]
        left = [x for x in wanted if x not in set(labels)]
        fine = len(set(labels)) == len(labels) == len(wanted) - len(left)
        require(fine and all(map(may_lack, left)), "the conditions are other ones")
        digits = whole(self.digits, 20, 400)
        published = [published_decimal(text, digits) for text in self.unknowns]
        root = only_root(lambda values: gaps(labels, values), published, digits, self.proof)
        require(all(map(is_nil, gaps(left, root))), "a condition is missing")
        return root


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
    first = [x for x in found if bool(x[0][0])]
    fine = len(found) == len(L) and len(first) == 1 and vanishes(first[0][0][1:])
    require(fine and first[0][1] == 1, "L does not keep the first value apart")
    return first + [x for x in found if x is not first[0]]


def first_is_solution(numbers, texts, r):
    """Refuse a start whose multiples of y are not 1, 0, .., 0."""
    require(numbers.vector(texts) == [Fraction(int(k == 0)) for k in range(r)], "u of the start")


def start_with_parity(proof, numbers, document, series, L, order, q_most):
    """Return (block, root, rows) of the start; `series` gives zeta(t) for any tree (6.7)."""
    table, block, r = document["starting"], Block(numbers, document, proof), len(L)
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
    fixed = stage_series(as_real(A), q) if known else None

    def gaps(labels, values):
        stages = fixed or stage_series(at_values(A, values), q)
        weights = at_values(B, values)
        return [dot(rows[k][0], less(apply(weights, stages.derivative(t)), series(t)))
                for k, t in labels]  # fmt: skip

    root = block.root(gaps, wanted, lambda label: label[0] == 0)
    return block, at_values(A, root), at_values(B, root)


def undoes(numbers, opening, closing):
    """Tell whether the finish undoes the first value of the start for all values of the digits."""
    block = Block(numbers, {})
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
    closing, first = document["finishing"], stage_series(A, 1)
    block = Block(numbers, document, proof)
    C, d = block.matrix(closing["A"]), block.matrix([closing["b"]])[0]
    require(len(C) == len(C[0]) == len(d), "shapes of the finish")
    opposite(C, [C[partner(i)] for i in range(len(C))])
    opposite([d], [d])
    wanted = [(0, t) for m in range(2, order + 1, 2) for t in classes(m, 1)]
    base = cache(lambda t: dot(b, first.derivative(t)))

    def gaps(labels, values):
        stages, weights = stage_series(at_values(C, values), 1, base), at_values(d, values)
        return [dot(weights, stages.derivative(t)) + base(t) for _, t in labels]

    block.root(gaps, wanted)


def even_start(proof, pair, numbers, document):
    """Return the orders (all trees, second-order systems) of the start of a pair (6.7)."""
    table, block = document["starting"], Block(numbers, document, proof, " orders")
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

    def gaps(labels, values):
        start = Series.of_tables({c: at_values(list(x), values) for c, x in tables.items()})
        return [start.value(t)[k] - zeta[t][k] for k, t in labels]

    block.root(gaps, wanted)
    return most, max(most, nystrom)


# ------------------------------------------------ section 6: upper bounds from intervals


class Solved(Series):
    """The starting series that an order needs, found order by order (4).

    (I - V) eta(t) = R(t) leaves N beta(t) open, V N = N. The principal parts beta are 0, or those
    with which the conditions W R(t) = 0 of the next order hold.
    """

    def __init__(self, method, identity_mode, nystrom):
        self.method, self.nystrom = method, nystrom
        self.free, self.last, self.order, self.filled = not identity_mode, None, 0, 0
        self.loose = False  # whether principal parts of a lower order are not the only ones
        self.W, self.N, self.lift, self.eta, self.k, self.w, parts = {}, {}, {}, {}, {}, {}, {}
        self.gaps = {}
        super().__init__(parts.__getitem__, {}, self.cut_value)
        plain = as_real if method.numbers.unknowns else lambda x: x
        for c, m in method.parts.items():
            require(is_exact(m.V), "V holds decimals")
            shift = minus(m.V, identity(m.r))
            N, W = kernel(shift), kernel(transpose(shift))
            require(N, "V u = u has no solution")
            if len(N) == 1:
                seen = sorted((x for x in apply(m.U, N[0]) if apart(x)),
                              key=lambda x: type(x) is Interval)  # fmt: skip
                require(seen, "U u is 0")  # of order 1 is only a method with U u = 1
                N = [multiples(inverse(seen[0]), N[0])]
                u = N[0]
            else:
                u, unique = method.vectors_to_one(c, consistent=True)
                require(u is not None and unique, "u is not determined")
            W = times(inverse_matrix(times(W, transpose(N))), W)
            w = reading(method, c, u)
            border = times(transpose(N), [w] if len(N) == 1 else W)
            lift = inverse_matrix(combine(scale(-1, shift), border))
            first = None if c in method.declared or len(N) > 1 else first_place(u)
            self.u[c], self.k[c], self.w[c] = plain(u), first, plain(w)
            self.W[c], self.N[c], self.lift[c] = plain(W), plain(N), plain(lift)
            parts[c] = Component(*map(plain, m[:3]), None)
        self.simple = all(len(N) == 1 for N in self.N.values())

    def cut_value(self, s):
        """Return eta at what is left of a tree, 0 at one that does not count where r = 1."""
        if s not in self.eta and self.method.system:
            return [Fraction(0)]  # the one value is the solution
        return self.eta[s]

    def move(self, s, beta):
        """Add N beta to eta(s)."""
        for b, n in zip(beta, self.N[s[0]], strict=True):
            self.eta[s] = [x + b * y for x, y in zip(self.eta[s], n, strict=True)]

    def settle(self):
        """Find the principal parts of the last order, where 1 is a simple eigenvalue of each V."""
        n, palette = self.order + 1, dict(self.method.palette)
        if n == 2:
            first, *others = trees(self.method.palette, 1)
            for s in others:
                self.move(s, self.condition((s[0], (first,))))
            return
        found = {}
        leaf = {c: (children[0], ()) for c, children in palette.items()}
        level = pool_of(self.method, n - 1, self.nystrom)
        for s in sorted(level, key=lambda s: (-len(s[1]), -s[1].count(leaf[s[0]]))):
            t = (s[0], tuple(sorted((*s[1], leaf[s[0]]))))
            (value,), ways = self.condition(t), 0
            for kept, weight in cut(t):
                if kept == s:
                    ways = weight
                elif kept in found:
                    value = value - found[kept] * weight
            found[s] = value * (1 / ways)
        for s, beta in found.items():
            if not is_nil(beta):
                self.move(s, [beta])

    def settle_all(self):
        """Find the principal parts of the last order from all conditions of the next one.

        They are the only ones, at order 1 up to the flow; `last` is the order where there are none.
        """
        method, m = self.method, self.method.parts
        place, units = {}, []
        for s in pool_of(method, self.order, self.nystrom):
            d, reads = len(self.N[s[0]]), apply(self.N[s[0]], self.w[s[0]])
            if not self.free:  # eta(s) is not read as the solution
                read = dot(self.w[s[0]], self.eta[s])
                self.move(s, [-read * x for x in apply(self.W[s[0]], self.u[s[0]])])
            basis = identity(d) if self.free else kernel([reads])
            place[s] = range(len(units), len(units) + len(basis))
            units += basis
        rows, right = [], []
        for t in pool_of(method, self.order + 1, self.nystrom):
            block = [[Fraction(0)] * len(units) for _ in self.W[t[0]]]
            for s, weight in [*cut(t), *((s, None) for s in t[1][:1] if len(t[1]) == 1)]:
                for j in place.get(s, ()):
                    e = apply(transpose(self.N[s[0]]), units[j])
                    image = units[j] if weight else apply(
                        times(self.W[t[0]], m[t[0]].B, m[s[0]].U), e)  # fmt: skip
                    for row, x in zip(block, image, strict=True):
                        row[j] = row[j] + (-weight * x if weight else x)
            rows, right = rows + block, right + [-x for x in self.condition(t)]
        beta, unique = solve(rows, right) if units else ([], True)
        if beta is None or (not units and not vanishes(right)):
            self.last = self.order
            return
        line = self.order == 1 and self.free and len(units) - rank(rows) == 1
        self.loose = self.loose or not (unique or line)
        for s, at in place.items():
            for j in at:
                self.move(s, [beta[j] * x for x in units[j]])

    def advance(self, order):
        """Go on until the conditions of an order can be evaluated; eta is known below it."""
        while self.order < order and self.last is None:
            if self.order:
                self.fill()
                if not self.simple:
                    self.settle_all()
                    self.known = {t: x for t, x in self.known.items() if size(t) < self.order}
                elif self.free:
                    self.settle()
            if self.last is None:
                self.order += 1

    def fill(self):
        """Find eta at the trees of the order that was reached, principal parts 0."""
        while self.filled < self.order:
            self.filled += 1
            for t in self.pool(self.filled):
                c, right = t[0], self.residual(t)
                self.gaps[t] = apply(self.W[c], right)
                self.eta[t] = [Fraction(0) if j == self.k[c] else dot(row, right)
                               for j, row in enumerate(self.lift[c])]  # fmt: skip

    def condition(self, t):
        """Return W R(t)."""
        return self.gaps[t] if t in self.gaps else apply(self.W[t[0]], self.residual(t))

    def pool(self, order):
        """Return the trees of an order that count."""
        return pool_of(self.method, order, self.nystrom)

    def shift(self, t, sigma):
        """Return what eta(t) gains by the flow through sigma, for one method."""
        gain = [x * sigma ** size(t) * Fraction(1, gamma(t)) for x in self.u["o"]]
        for s, weight in cut(t):
            if s != t:
                factor = weight * sigma ** (size(t) - size(s))
                gain = [x + factor * y for x, y in zip(gain, self.eta_of(s), strict=True)]
        return gain


class ByClasses(Solved):
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
        return multiples(factor, super().condition(below))

    def settle(self):
        """Find the principal parts of the last order, 0 where it is odd."""
        if self.order % 2:
            return
        free = self.sweep.free.get(self.order, ())
        defining, _, back = plan(self.order, self.q, free)
        right = [dot(self.eta[t], apply(self.G, self.eta[u])) for t, u in defining]
        right += [self.given.get(t, Fraction(0)) for t in free]
        for t, row_ in zip(classes(self.order, self.q), back, strict=True):
            self.move(t, [dot(row_, right)])


# ------------------------------------------------ section 6: rules


def implied_order(proof, w):
    """Rule implied-order."""
    identity_mode, nystrom = mode(w)
    p = whole(w["order"], 1, 14)
    require(nystrom not in PATHS, "paths decide for exact pairs")
    root = proof.root()
    more = (proof.row, proof.method) if isinstance(root, RungeKutta) else ()
    root.order_holds(p, identity_mode, nystrom, *more)
    proof.low = (p, identity_mode, nystrom)


def implied_stage_order(proof, w):
    """Rule implied-stage-order."""
    q = whole(w["q"], 1)
    require(proof.low is not None, "the order is not part of the certificate")
    root = proof.root()
    require(not isinstance(root, Pair), "the stage order of pairs")
    root.stage_order_holds(q, proof.low[0])
    return q


def implied_start(proof, w):
    """Rule implied-start."""
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


def implied_finish(proof, w):
    """Rule implied-finish."""
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
    rows, whole_method = proof.method.rows(), proof.method
    require(w["row"] in rows, "no row of embedded has the name")
    require(isinstance(w["parts"], list), "the parts of a row are a list")
    names = [part["rule"] for part in w["parts"]]
    low, high = ["order-at-least"], ["order-at-most"]
    own = ([["implied-order", *high]] if proof.record.root is not None
           else [low + high, ["no-order-1"]])  # fmt: skip
    own += [high] if proof.holds else [high, low, ["implied-order"]]
    require(names in own, "the parts of a row")
    nystrom = whole_method.kind == "nystrom"
    proof.low = proof.high = None
    proof.method = whole_method.with_row(rows[w["row"]][0]).for_claim("order")
    proof.row = w["row"]
    for part in w["parts"]:
        apply_rule(proof, part)
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
        values = gaps(proof.method)
        if wanted:
            require(vanishes(values), "a number is not 0")
        else:
            require(any(apart(x) for x in values), "the numbers are 0")

    return rule


def absent(proof, w):
    """Rule absent: the file has nothing that the claim is about, which settles the claim."""
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
    p, method = whole(w["order"]), proof.method
    own = reached and "c" in method.document and not vanishes(gaps_of_rows(method))
    require(not own and not method.pair, "c is not A 1")
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
    order_at_least, order_at_most, preconsistent, stage_order_at_least,
    stage_order_at_most, start_at_least, start_at_most, finish_at_least, finish_at_most, bounded,
    unbounded, eigen, growth, grows, unshared, form, given_form_fails, no_form, quadratic,
    not_quadratic, symmetric, not_symmetric, explicit, implicit, abscissae, other_abscissae,
    error_constant, reducible, equivalent, a_stable, not_a_stable, l_limit, implied,
    implied_order, implied_stage_order, implied_start, implied_finish, row, dense, absent,
    to_digits, not_to_digits, not_preconsistent,
)} | {
    "consistent": lambda proof, w: preconsistent(proof, w, True),
    "no-order-1": lambda proof, w: not_preconsistent(proof, w, True),
    "irreducible": lambda proof, w: reducible(proof, w, False),
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

WITNESS = {  # keys of a witness, after the bar those that may be missing; of form, symmetric: there
    "order-at-least": "order principal trees", "order-at-most": "order principal trees | tree",
    "stage-order-at-least": "q", "stage-order-at-most": "q | tree", "start-at-least": "q",
    "start-at-most": "q | tree", "finish-at-least": "q", "finish-at-most": "q | tree",
    "not-preconsistent": "colour", "no-order-1": "colour", "bounded": "which",
    "unbounded": "which | block", "eigen": "which zeta", "grows": "part",
    "not-quadratic": "| several-values", "not-symmetric": "| singular", "equivalent": "U B V",
    "not-a-stable": "| y infinity pole axis start", "implied-order": "order principal trees",
    "implied-stage-order": "q", "implied-start": "q", "implied-finish": "q", "row": "row parts",
    "dense": "order tree", "not-dense": "order tree", "to-digits": "rows",
    "not-to-digits": "row | tree order", "form": "G | D D_P D_Q",
    "symmetric": "L | P L_hat P_Q P_P",
}  # fmt: skip


def apply_rule(proof, part):
    """Check one part, and return the bound that it proves, if any."""
    keys(part["witness"], *WITNESS.get(part["rule"], "").split("|"))
    return RULES[part["rule"]](proof, part["witness"])


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
    "embedded-order": ("row+", "row+|row"),
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
    "dense-order", "error-constant", "explicit", "reducible", "embedded-order",
}  # fmt: skip


class Record:
    """The root of an enclosure and what was found from it, kept for the next certificate."""

    def __init__(self, document, field, block, numbers):
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
        elif block is not None:
            kinds = {"sweep": Sweep, "pair-sweep": Pair, "splitting": Pair, "rk": RungeKutta,
                     "rosenbrock": RungeKutta}  # fmt: skip
            require(document.get("class") in kinds, "an enclosure of another class")
            self.root = kinds[document["class"]](document, numbers, block)
            weights = [row for row, _ in self.root.halves.values()]
            fine = all(apart(x) for row in weights for x in at_values(row, self.root.root))
            require(fine, "a weight may be 0")
            values = dict(zip(self.root.unknowns, self.root.root, strict=True))
            self.numbers = numbers.changed(unknowns=values)
            if isinstance(self.root, Sweep):
                self.root.explicit_now = self.numbers.explicit = frozenset(self.root.explicit)

    def known(self, key, make):
        """Return what was made before under this key; None keeps nothing."""
        if key is None:
            return make()
        if key not in self.memory:
            self.memory[key] = make()
        return self.memory[key]


@lru_cache(maxsize=1)
def numbers_of(field):
    """Return the numbers of the text of a field."""
    return Numbers(json.loads(field))


@lru_cache(maxsize=1)
def record_of(text):
    """Return the record of the text of a document, a base, a field and the proof of the method."""
    document, _, field, block = json.loads(text)
    return Record(document, field, block, numbers_of(json.dumps(field)).changed())


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
        field = dict(as_object(certificate["field"]))
        require(("proofs" in field) == (field.get("kind") == "enclosure"), "proofs of a method")
        base, self.blocks, self.kind = (
            certificate.get("base"),
            field.pop("proofs", {}),
            field["kind"],
        )
        keys(self.blocks, "", "method starting finishing", "proofs")
        kept = {key: value for key, value in document.items() if key != "claims"}
        self.record = record_of(json.dumps([kept, base, field, self.blocks.get("method")]))
        self.method = Method(document, self.record.numbers, base)
        self.method.check_shapes()
        if self.rules != ["absent"]:
            self.method = self.method.for_claim(self.claim)
        require(statement["proof"] in self.proofs(), "the proof is another")
        self.low = self.high = self.reversal = self.row = None
        self.stable, self.eigen = set(), {}
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

    def series(self, identity_mode, nystrom, order, filled=False):
        """Return the series that an order needs, ready for its conditions or `filled` with eta."""
        identity_mode = identity_mode or nystrom in PATHS
        fine = identity_mode and all(m.r == 1 for m in self.method.parts.values())
        require(fine or not self.method.system, "several values are carried")
        found = self.record.known(("series", self.row, self.method.system, *self.method.parts,
                                   identity_mode, nystrom),
                                  lambda: Solved(self.method, identity_mode, nystrom))  # fmt: skip
        if found.order > order:
            return found
        found.advance(order)
        if filled:
            found.fill()
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
        require(self.reversal is not None and self.low is not None, "symmetry is missing")
        L, eta = self.reversal["o"], self.series(*self.low[1:], order, filled=True)
        for t in through(self.method, order, False):
            sign_ = -1 if size(t) % 2 else 1
            equal(eta.eta_of(t), [sign_ * x for x in apply(L, eta.eta_of(t))], "eta(-h) = L eta(h)")
        return L, lambda t: [as_real(x) for x in eta.eta_of(t)], 1

    def claimed(self, texts):
        """Return declared numbers; claims use no constants."""
        require(isinstance(texts, list), "a list is declared")
        return [self.method.numbers.entry(text, {}) for text in texts]

    def check(self):
        """Check that the parts are those of the statement (7), and each of them."""
        kind, about = self.method.kind, self.claim in ADDITIVE or not self.method.additive
        about = self.claim in ROSENBROCK if kind == "rosenbrock" else about
        require(about, f"{self.claim} has no meaning for an additive method")
        require(self.claim != "w-order" or kind == "rosenbrock", "a Rosenbrock method is needed")
        fine = self.rules == ["absent"] or self.fits()
        require(fine, f"these parts do not prove {self.claim}: {self.rules}")
        results = [apply_rule(self, part) for part in self.parts]
        if self.rules == ["absent"]:
            return
        if self.claim == "embedded-order":
            check_rows(self, results)
        elif self.claim in ORDERS or self.claim == "dense-order":
            self.check_order(self.low and self.low[0], self.high and self.high[0])
        elif self.claim in SECOND:
            low, high = ([value for rule, value in zip(self.rules, results, strict=True)
                          if rule in names] for names in self.both_ends())  # fmt: skip
            if self.rules == ["order-at-most"]:  # none of these orders is above that of the method
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
        name = SECOND.get(self.claim, "order")
        return {f"{name}-at-least", f"implied-{name}"}, {f"{name}-at-most"}

    def mode(self):
        """Return (identity?, nystrom?) of the orders that a claim is about."""
        single = all(m.r == 1 for m in self.method.parts.values())
        nystrom = self.claim.startswith("nystrom")
        if self.claim in ("order", "stage-order", "finishing-order"):
            return single, False
        if self.claim == "starting-order":
            return self.method.pair, False
        return self.claim != "effective-order", nystrom

    def fits(self):
        """Tell whether the parts are such as prove statements of this kind (7)."""
        claim, rules, truth = self.claim, self.rules, self.holds
        if claim in (*ORDERS, *SECOND):  # any bounds: what they show is compared with the claim
            whole(self.declared)
            names = {"order-at-least", "implied-order", "order-at-most", "no-order-1"}
            names |= {"not-preconsistent"}.union(*self.both_ends())
            known = "order-at-most" in rules or not any(x.startswith("implied") for x in rules)
            fine = set(rules) <= names | {"symmetric"} and len(set(rules)) == len(rules)
            return fine and (known or not self.holds)
        if claim == "dense-order":
            whole(self.declared)
        elif claim not in VALUES:
            require(type(self.declared) is bool, "the claim is true or false")
            truth = self.declared == self.holds
        exact = self.kind in ("rational", "tower")
        texts = PROVES.get(claim, ("", ""))[not truth] if exact or claim in AS_EXACT else ""
        if not exact and (truth or claim == "growth"):
            texts += "|implied"
        often = {"*": len(self.method.parts), "+": len(self.method.document.get("embedded", ()))}
        return rules in ([x.rstrip("*+") for x in text.split() for _ in range(often.get(x[-1], 1))]
                         for text in texts.split("|") if text)  # fmt: skip

    def check_order(self, low, high):
        """Refuse bounds that do not decide the declared order; no order is below 0."""
        if {"no-order-1", "not-preconsistent"} & set(self.rules):
            low = high = 0
        low, p = low or 0, self.declared
        decided = low == p == high if self.holds else p < low or (high is not None and high < p)
        require(decided, f"the parts show {low} <= order <= {high}")


# -------------------------------------------------------------------------------- the command


def printed(text):
    """Return a text of others on one line that a terminal does not obey."""
    return "".join(x if x.isprintable() else ascii(x)[1:-1] for x in text)


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
        # a pipe of the shell has no name; one that has may have no writer, and opening it waits
        if pathlib.Path(os.path.realpath(path)).is_fifo():
            raise Unreadable("it cannot be read: it is a named pipe")
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
    except (Refused, ArithmeticError, LookupError, MemoryError, RecursionError, TypeError,
            ValueError, AttributeError) as error:  # fmt: skip
        record_of.cache_clear()  # a series may have been left half made
        if isinstance(error, Refused):
            return False, str(error)
        if isinstance(error, RecursionError | MemoryError | ArithmeticError):
            return False, "beyond the limits of this checker"
        return False, f"a part has another shape ({type(error).__name__})"
    name, claim = str(proof.method.document["name"])[:100], proof.claim_text[:300]
    word = "holds" if proof.holds else "fails"
    return True, f"{name}: {claim} {word} ({', '.join(proof.rules)})"


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
                answer = f"{path}: {'yes' if accepted else 'no'}: {sentence}"
                sys.stdout.write(f"{printed(answer)}\n")
                code = code if accepted else 1
        except Unreadable as error:
            sys.stderr.write(f"{printed(f'{path}: {error}')}\n")
            return 2
    return code


if __name__ == "__main__":
    sys.exit(main())
