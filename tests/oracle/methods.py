"""From a document to the matrices of its components, class by class as ``data/README.md`` has them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from mpmath import mp

from .numbers import (
    DIGITS,
    Margin,
    Matrix,
    Reader,
    Undecided,
    Vector,
    eye,
    flat,
    plus,
    star,
    times,
    transposed,
)

Tree = tuple[str, tuple[Any, ...]]


@dataclass(frozen=True)
class Part:
    """One component: Y = h A f + U y, y+ = h B f + V y."""

    A: Matrix
    U: Matrix
    B: Matrix
    V: Matrix

    @property
    def r(self) -> int:
        """Number of values carried."""
        return len(self.V)


@dataclass(frozen=True)
class Method:
    """Components by colour.

    ``children`` are the colours that may stand below a colour; ``counts`` tells which trees count;
    ``stages`` maps a colour to the colours whose slopes are evaluated at its stages.
    """

    parts: Mapping[str, Part]
    children: Mapping[str, str]
    separable: bool = False
    output: Mapping[str, Vector] = field(default_factory=dict)
    counts: Callable[[Tree], bool] = lambda tree: True

    @property
    def pair(self) -> bool:
        """Whether there are two components that act on different variables."""
        return set(self.parts) == {"f", "k"}

    @property
    def one(self) -> bool:
        """Whether every component carries one value."""
        return all(m.r == 1 for m in self.parts.values())


def runge_kutta(A: Matrix, b: Vector) -> Part:
    """Return a Runge-Kutta method."""
    return Part(A, [[mp.mpf(1)] for _ in A], [list(b)], [[mp.mpf(1)]])


def single(part: Part, **more: Any) -> Method:
    """Return a method with one component."""
    return Method({"o": part}, {"o": "o"}, **more)


def pair(q: Part, p: Part, separable: bool, **more: Any) -> Method:
    """Return a partitioned method."""
    children = {"f": "k", "k": "f"} if separable else {"f": "fk", "k": "fk"}
    return Method({"f": q, "k": p}, children, separable, **more)


def of_second_order(tree: Tree) -> bool:
    """Return whether no vertex f has two children or a child f."""
    colours = [x[0] for x in tree[1]]
    fine = tree[0] != "f" or (len(colours) < 2 and "f" not in colours)
    return fine and all(map(of_second_order, tree[1]))


def of_rosenbrock(tree: Tree) -> bool:
    """Return whether no vertex J has two children, and no vertex f - J has exactly one."""
    n = len(tree[1])
    return (n < 2 if tree[0] == "2" else n != 1) and all(map(of_rosenbrock, tree[1]))


def of_time(tree: Tree) -> bool:
    """Return whether the clock depends on nothing."""
    return (tree[0] != "k" or not tree[1]) and all(map(of_time, tree[1]))


class File:
    """A document: its numbers, the margins that follow from its digits, and its method.

    Parameters
    ----------
    document : Mapping[str, Any]
        A file of ``data/README.md``.
    base : Mapping[str, Any] or None
        The base of a composition.
    """

    def __init__(self, document: Mapping[str, Any], base: Mapping[str, Any] | None = None) -> None:
        digits = int(document.get("digits", 0))
        if base and "digits" in base:
            digits = min(digits or base["digits"], base["digits"])
        mp.dps = max(DIGITS, digits + 40)
        self.document, self.base, self.read = document, base, Reader(document)
        self.kind = document["class"]
        made = getattr(self, "_" + self.kind.replace("-", "_"))()
        self.method: Method = made if isinstance(made, Method) else single(made)
        for block in (document.get("starting", {}), document.get("finishing", {})):
            for rows in (x for x in block.values() if isinstance(x, list)):
                self.read.vector([y for x in rows for y in (x if isinstance(x, list) else [x])])
        self.rounded = self.read.decimals or bool(base and "digits" in base)
        if not self.rounded:
            self.margin = Margin(mp.mpf(10) ** -75, mp.mpf(10) ** -60)
        elif "enclosure" in document or document.get("starting") or digits > 40:
            self.margin = Margin(mp.mpf(10) ** (15 - digits), mp.mpf(10) ** (25 - digits))
        else:  # nothing is zero that was rounded
            self.margin = Margin(mp.mpf(0), mp.mpf(10) ** (3 - digits))

    def form(self, key: str = "G") -> Matrix:
        """Return a matrix that may be written as its diagonal."""
        value = self.document[key]
        if isinstance(value[0], str):
            return [[x * int(i == j) for j in range(len(value))]
                    for i, x in enumerate(self.read.vector(value))]  # fmt: skip
        return self.read.matrix(value)

    def blocks(self, source: Mapping[str, Any]) -> Part:
        """Return A, U, B, V as they stand."""
        return Part(*(self.read.matrix(source[key]) for key in "AUBV"))

    def _glm(self) -> Method:
        d = self.document
        output = {"o": self.read.vector(d["output"])} if "output" in d else {}
        return single(self.blocks(d), output=output)

    def _rk(self) -> Part:
        return runge_kutta(
            self.read.matrix(self.document["A"]), self.read.vector(self.document["b"])
        )

    def _composition(self) -> Part:
        if self.base is None:
            raise ValueError("a composition needs its base")
        if "c" in self.base:
            raise Undecided("a base with c apart")
        inner = Reader(self.base)
        A, b = inner.matrix(self.base["A"]), inner.vector(self.base["b"])
        steps, s = self.read.vector(self.document["gamma"]), len(b)
        rows = []
        for k in range(len(steps)):
            for i in range(s):
                row = []
                for j, h in enumerate(steps):
                    row += [h * x for x in (b if j < k else A[i] if j == k else [mp.mpf(0)] * s)]
                rows.append(row)
        return runge_kutta(rows, [h * x for h in steps for x in b])

    def _lmm(self) -> Part:
        """Return the form with the values y and h f that the formula needs, newest first."""
        alpha, beta = (self.read.vector(self.document[x]) for x in ("alpha", "beta"))
        k = len(alpha) - 1
        alpha, beta = [x / alpha[k] for x in alpha], [x / alpha[k] for x in beta]
        oldest = min([m for m in range(k) if alpha[m] != 0], default=k - 1)
        solutions = list(range(k - 1, oldest - 1, -1))
        last = k - 1 if beta[k] != 0 else k - 2
        first = min([m for m in range(k + 1) if beta[m] != 0], default=k)
        slopes = list(range(last, first - 1, -1))
        names = [("y", m) for m in solutions] + [("f", m) for m in slopes]
        formula = [-alpha[m] if x == "y" else beta[m] for x, m in names]
        zero, one = mp.mpf(0), mp.mpf(1)
        V, B = [], []
        for n, (x, m) in enumerate(names):
            fresh = n == 0 or (x, m) == ("f", last)
            V.append(
                formula if n == 0 else [one * (not fresh and j == n - 1) for j in range(len(names))]
            )
            new = beta[k] if beta[k] != 0 else beta[k - 1]
            B.append([new if n == 0 else one if fresh else zero])
        U = formula if beta[k] != 0 else [one * (j == 0) for j in range(len(names))]
        return Part([[beta[k]]], [U], B, V)

    def _one_leg(self) -> Part:
        alpha, beta = (self.read.vector(self.document[x]) for x in ("alpha", "beta"))
        k = len(alpha) - 1
        back = range(k - 1, -1, -1)
        lead = [-alpha[m] / alpha[k] for m in back]
        V = [lead, *([mp.mpf(int(j == i)) for j in range(k)] for i in range(k - 1))]
        U = [beta[m] + beta[k] * x for m, x in zip(back, lead, strict=True)]
        B = [[1 / alpha[k]], *([mp.mpf(0)] for _ in range(k - 1))]
        return Part([[beta[k] / alpha[k]]], [U], B, V)

    def _sweep(self) -> Part:
        d = self.document
        X, D, V, G = (
            self.read.matrix(d["X"]),
            self.read.vector(d["D"]),
            self.read.matrix(d["V"]),
            self.form(),
        )
        S, texts = times(star(X), G, X), d.get("enclosure", {}).get("equations", ())
        named = {int(x.split()[1]) - 1 for x in texts if x.startswith("explicit")}
        A = [[D[j] * x if j < i else D[j] * x / 2 if j == i and i not in named else mp.mpf(0)
              for j, x in enumerate(row)] for i, row in enumerate(S)]  # fmt: skip
        return Part(
            A, times(star(X), G, V), [[x * y for x, y in zip(row, D, strict=True)] for row in X], V
        )

    def _partitioned(self) -> Method:
        d = self.document
        output = {c: self.read.vector(d[x]["output"]) for c, x in (("f", "q"), ("k", "p"))
                  if "output" in d[x]}  # fmt: skip
        return pair(
            self.blocks(d["q"]), self.blocks(d["p"]), d.get("separable") is True, output=output
        )

    def _partitioned_rk(self) -> Method:
        d = self.document
        hat = runge_kutta(self.read.matrix(d["A_hat"]), self.read.vector(d["b_hat"]))
        return pair(self._rk(), hat, d.get("separable") is True)

    def _splitting(self) -> Method:
        d = self.document
        a, b = self.read.vector(d["a"]), self.read.vector(d["b"])
        head = d["first"] == "q"
        A = [[x if (i <= j if head else i < j) else mp.mpf(0) for i, x in enumerate(a)]
             for j in range(len(b))]  # fmt: skip
        A_hat = [[x if (j < i if head else j <= i) else mp.mpf(0) for j, x in enumerate(b)]
                 for i in range(len(a))]  # fmt: skip
        return pair(runge_kutta(A, a), runge_kutta(A_hat, b), True)

    def _pair_sweep(self) -> Method:
        d, one = self.document, mp.mpf(1)
        order = {x: [n for n, y in enumerate(d["stages"]) if y == x] for x in "PQ"}
        b, c, G = self.read.vector(d["b"]), self.read.vector(d["c"]), self.form()
        X = [[one] * len(b), *self.read.matrix(d["w"])]
        Y = [[one] * len(c), *self.read.matrix(d["v"])]
        V, W = self.read.matrix(d["V"]), self.read.matrix(d["V_hat"])
        S = times(transposed(X), G, Y)
        A = [[b[i] * S[i][j] if order["P"][i] < m else one * 0 for i in range(len(b))]
             for j, m in enumerate(order["Q"])]  # fmt: skip
        A_hat = [[c[j] * S[i][j] if order["Q"][j] < n else one * 0 for j in range(len(c))]
                 for i, n in enumerate(order["P"])]  # fmt: skip
        scaled = [[[x * y for x, y in zip(row, d_, strict=True)] for row in M]
                  for M, d_ in ((X, b), (Y, c))]  # fmt: skip
        return pair(Part(A, times(transposed(Y), transposed(G), V), scaled[0], V),
                    Part(A_hat, times(transposed(X), G, W), scaled[1], W), True)  # fmt: skip

    def _additive(self) -> Method:
        parts = {str(n): runge_kutta(self.read.matrix(x["A"]), self.read.vector(x["b"]))
                 for n, x in enumerate(self.document["parts"], 1)}  # fmt: skip
        return Method(parts, dict.fromkeys(parts, "".join(parts)))

    def _nystrom(self) -> Method:
        return self.nystrom_with(self.document)

    def nystrom_with(self, row: Mapping[str, Any]) -> Method:
        """Return the pair with the weights of a row: stages P_0 = p and P_l = p + h g_l."""
        d, zero, one = self.document, mp.mpf(0), mp.mpf(1)
        A, c = self.read.matrix(d["A"]), self.read.vector(d["c"])
        b, b_prime, s = self.read.vector(row["b"]), self.read.vector(row["b_prime"]), len(c)
        A_q = [[x - sum(y), *y] for x, y in zip(c, A, strict=True)]
        A_p = [[zero] * s, *eye(s)]
        weights_q, weights_p = [one - sum(b), *b], b_prime
        if "A_prime" in d:
            A_q = [[zero] * (2 * s + 1)] * (s + 1) + [[*x, *([zero] * s)] for x in A_q]
            A_p = [[zero] * (s + 1) + x for x in [*A_p, *self.read.matrix(d["A_prime"])]]
            weights_q, weights_p = weights_q + [zero] * s, [zero] * (s + 1) + weights_p
        return pair(runge_kutta(A_q, weights_q), runge_kutta(A_p, weights_p), "A_prime" not in d)

    def _rosenbrock(self) -> Method:
        return self.rosenbrock_with(self.document["b"], of_rosenbrock)

    def rosenbrock_with(self, b: list[str], counts: Callable[[Tree], bool]) -> Method:
        """Return the additive method with these weights, stages of f - J before those of J."""
        alpha, gamma = (self.read.matrix(self.document[x]) for x in ("alpha", "gamma"))
        none, weights = [mp.mpf(0)] * len(alpha), self.read.vector(b)
        rows = alpha + plus(alpha, gamma)
        parts = {"1": runge_kutta([x + none for x in rows], weights + none),
                 "2": runge_kutta([none + x for x in rows], none + weights)}  # fmt: skip
        return Method(parts, {"1": "12", "2": "12"}, counts=counts)

    def timed(self, method: Method) -> Method:
        """Return a Runge-Kutta method with the time as a second variable, where c is not A 1."""
        if self.kind != "rk" or "c" not in self.document:
            return method
        m, c = method.parts["o"], self.read.vector(self.document["c"])
        if self.margin.zeros([sum(row) - x for row, x in zip(m.A, c, strict=True)]):
            return method
        clock = runge_kutta(
            [[x, *([mp.mpf(0)] * (len(c) - 1))] for x in c],
            [mp.mpf(1)] + [mp.mpf(0)] * (len(c) - 1),
        )
        return pair(m, clock, False, counts=of_time)

    def linear(self) -> Part:
        """Return the method that a linear equation y' = z y sees."""
        if self.kind == "rosenbrock":
            rows = plus(*(self.read.matrix(self.document[x]) for x in ("alpha", "gamma")))
            return runge_kutta(rows, self.read.vector(self.document["b"]))
        return self.method.parts["o"]

    def embedded(self) -> dict[str, Method]:
        """Return the method of each embedded row, the solution of class glm apart."""
        found = {}
        for row in self.document.get("embedded", ()):
            if self.kind == "rk":
                b = (
                    self.read.vector(row["b"])
                    if "b" in row
                    else [
                        x - y
                        for x, y in zip(
                            self.method.parts["o"].B[0], self.read.vector(row["error"]), strict=True
                        )
                    ]
                )
                found[row["name"]] = self.timed(single(runge_kutta(self.method.parts["o"].A, b)))
            elif self.kind == "additive":
                parts = {
                    c: runge_kutta(m.A, self.read.vector(b))
                    for (c, m), b in zip(self.method.parts.items(), row["b"], strict=True)
                }
                found[row["name"]] = replace(self.method, parts=parts)
            elif self.kind == "nystrom":
                found[row["name"]] = self.nystrom_with(row)
            elif self.kind == "rosenbrock":
                found[row["name"]] = self.rosenbrock_with(row["b"], of_rosenbrock)
        return found

    def exact(self, *matrices: str) -> bool:
        """Return whether the blocks of these names hold no decimals but zeros."""
        if not self.rounded:
            return True
        probe = Reader({})
        if self.kind in ("glm", "sweep", "pair-sweep"):
            names = {"V": ("V", "V_hat")}
            texts = [
                t
                for x in matrices
                for key in names.get(x, (x,))
                for row in self.document.get(key, ())
                for t in row
            ]
            try:
                probe.vector(texts)
            except KeyError:
                return False
            return not probe.decimals
        return all(x == "V" for x in matrices) and self.method.one


def unequal(M: Matrix, N: Matrix) -> Vector:
    """Return the entries of M - N."""
    return flat(plus(M, N, -1))
