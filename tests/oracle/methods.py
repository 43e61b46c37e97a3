"""From a document to the matrices of its components, class by class as ``data/README.md`` has them."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from mpmath import mp

from .numbers import Array, Margin, Reader, Undecided, array, eye, zeros

Tree = tuple[str, tuple[Any, ...]]
DIGITS = 100


@dataclass
class Part:
    """One component: Y = h A f + U y, y+ = h B f + V y."""

    A: Array
    U: Array
    B: Array
    V: Array

    def __post_init__(self) -> None:
        self.A, self.U, self.B, self.V = map(array, (self.A, self.U, self.B, self.V))

    @property
    def r(self) -> int:
        """Number of values carried."""
        return len(self.V)


@dataclass(frozen=True)
class Method:
    """Components by colour.

    ``children`` are the colours that may stand below a colour; ``counts`` tells which trees count;
    stages of separable pairs evaluate the slopes of the other component.
    """

    parts: Mapping[str, Part]
    children: Mapping[str, str]
    separable: bool = False
    output: Mapping[str, Array] = field(default_factory=dict)
    counts: Callable[[Tree], bool] = lambda tree: True

    @property
    def pair(self) -> bool:
        """Whether there are two components that act on different variables."""
        return set(self.parts) == {"f", "k"}

    @property
    def one(self) -> bool:
        """Whether every component carries one value."""
        return all(m.r == 1 for m in self.parts.values())


def runge_kutta(A: Array, b: Array) -> Part:
    return Part(A, zeros(len(A), 1) + 1, b[None, :], eye(1))


def single(part: Part, **more: Any) -> Method:
    return Method({"o": part}, {"o": "o"}, **more)


def pair(q: Part, p: Part, separable: bool, **more: Any) -> Method:
    children = {"f": "k", "k": "f"} if separable else {"f": "fk", "k": "fk"}
    return Method({"f": q, "k": p}, children, separable, **more)


def of_second_order(tree: Tree) -> bool:
    """Return whether no vertex f has two children or a child f."""
    below = "".join(x[0] for x in tree[1])
    return (tree[0] != "f" or below in ("", "k")) and all(map(of_second_order, tree[1]))


def of_rosenbrock(tree: Tree) -> bool:
    """Return whether no vertex J has two children, and no vertex f - J has exactly one."""
    n = len(tree[1])
    return (n < 2 if tree[0] == "2" else n != 1) and all(map(of_rosenbrock, tree[1]))


def of_time(tree: Tree) -> bool:
    """Return whether the clock depends on nothing."""
    return (tree[0] != "k" or not tree[1]) and all(map(of_time, tree[1]))


class File:
    """A document: its numbers, the margins that follow from its digits, and its method.

    A composition needs its base, too.
    """

    def __init__(self, document: Mapping[str, Any], base: Mapping[str, Any] | None = None) -> None:
        digits = int(document.get("digits", 0))
        if base and "digits" in base:
            digits = min(digits or base["digits"], base["digits"])
        mp.dps = max(DIGITS, digits + 40)
        self.document, self.base, self.read = document, base, Reader(document)
        self.kind = document["class"]
        made = getattr(self, self.kind.replace("-", "_"))()
        self.method: Method = made if isinstance(made, Method) else single(made)
        for block in (document.get("starting", {}), document.get("finishing", {})):
            for rows in block.values():
                if isinstance(rows, list):
                    self.read(rows)
        self.rounded = self.read.decimals or bool(base and "digits" in base)
        if not self.rounded:
            self.margin = Margin(mp.mpf(10) ** -75, mp.mpf(10) ** -60)
        elif "enclosure" in document or document.get("starting") or digits > 40:
            self.margin = Margin(mp.mpf(10) ** (15 - digits), mp.mpf(10) ** (25 - digits))
        else:  # nothing is zero that was rounded
            self.margin = Margin(mp.mpf(0), mp.mpf(10) ** (3 - digits))

    def get(self, *names: str) -> Any:
        """Return arrays of the document."""
        found = [self.read(self.document[x]) for x in names]
        if not all(map(len, found)):
            raise ValueError("an empty list")
        return found if len(names) > 1 else found[0]

    def form(self) -> Array:
        """Return G, which may be written as its diagonal."""
        G = self.get("G")
        return np.diag(G).view(Array) if G.ndim == 1 else G

    def blocks(self, source: Mapping[str, Any]) -> Part:
        return Part(*(self.read(source[key]) for key in "AUBV"))

    def finish(self, block: Mapping[str, Any]) -> Part:
        return runge_kutta(self.read(block["A"]), self.read(block["b"]))

    def glm(self) -> Method:
        output = {"o": self.get("output")} if "output" in self.document else {}
        return single(self.blocks(self.document), output=output)

    def rk(self) -> Part:
        return runge_kutta(*self.get("A", "b"))

    def composition(self) -> Part:
        if self.base is None:
            raise ValueError("a composition needs its base")
        if "c" in self.base:
            raise Undecided("a base with c apart")
        steps, (A, b) = self.get("gamma"), map(Reader(self.base), (self.base["A"], self.base["b"]))
        before = np.tril(np.outer(zeros(len(steps)) + 1, steps), -1)
        return runge_kutta(
            np.kron(np.diag(steps), A) + np.kron(before, np.tile(b, (len(b), 1))), np.kron(steps, b)
        )

    def lmm(self) -> Part:
        """Return the form with the values y and h f that the formula needs, newest first."""
        alpha, beta = self.get("alpha", "beta")
        k = len(alpha) - 1
        alpha, beta = alpha / alpha[k], beta / alpha[k]
        implicit = int(beta[k] != 0)
        last = k - 2 + implicit
        oldest = min([m for m in range(k) if alpha[m]], default=k - 1)
        first = min([m for m in range(k + 1) if beta[m]], default=k)
        names = [("y", m) for m in range(k - 1, oldest - 1, -1)]
        names += [("f", m) for m in range(last, first - 1, -1)]
        formula = array([-alpha[m] if x == "y" else beta[m] for x, m in names])
        V, B = array(np.eye(len(names), k=-1, dtype=int)), zeros(len(names), 1)
        V[0], B[0] = formula, beta[k] if implicit else beta[k - 1]
        for n in (n for n, x in enumerate(names) if n and x == ("f", last)):
            V[n], B[n] = 0, 1
        return Part(beta[k:][None], formula[None] if implicit else eye(len(names))[:1], B, V)

    def one_leg(self) -> Part:
        alpha, beta = self.get("alpha", "beta")
        k = len(alpha) - 1
        V = array(np.eye(k, k=-1, dtype=int))
        V[0] = -alpha[k - 1 :: -1] / alpha[k]
        U = beta[k - 1 :: -1] + V[0] * beta[k]
        return Part(beta[k:][None] / alpha[k], U[None], eye(k)[:, :1] / alpha[k], V)

    def sweep(self) -> Part:
        (X, D, V), G = self.get("X", "D", "V"), self.form()
        texts = self.document.get("enclosure", {}).get("equations", ())
        named = [int(x.split()[1]) - 1 for x in texts if x.startswith("explicit")]
        S = X.star @ G @ X * D
        diagonal = np.diag(S) / 2
        diagonal[named] = 0
        return Part(np.tril(S, -1) + np.diag(diagonal), X.star @ G @ V, X * D, V)

    def partitioned(self) -> Method:
        d, ends = self.document, {"f": self.document["q"], "k": self.document["p"]}
        output = {c: self.read(x["output"]) for c, x in ends.items() if "output" in x}
        return pair(*map(self.blocks, ends.values()), d.get("separable") is True, output=output)

    def partitioned_rk(self) -> Method:
        hat = runge_kutta(*self.get("A_hat", "b_hat"))
        return pair(self.rk(), hat, self.document.get("separable") is True)

    def splitting(self) -> Method:
        a, b = self.get("a", "b")
        i, j, head = np.arange(len(a)), np.arange(len(b))[:, None], self.document["first"] == "q"
        before = array((i <= j if head else i < j).astype(int))  # a_i stands before b_j
        return pair(runge_kutta(before * a, a), runge_kutta((1 - before).T * b, b), True)

    def pair_sweep(self) -> Method:
        d, (b, c, V, W) = self.document, self.get("b", "c", "V", "V_hat")
        P, Q = (np.array([n for n, y in enumerate(d["stages"]) if y == x]) for x in "PQ")
        G, pairs = self.form(), ((b, self.read(d["w"])), (c, self.read(d["v"])))
        X, Y = (np.vstack([x * 0 + 1, *y]).view(Array) for x, y in pairs)
        S, before = X.T @ G @ Y, array((P[:, None] < Q).astype(int))
        return pair(Part((S * before).T * b, Y.T @ G.T @ V, X * b, V),
                    Part(S * (1 - before) * c, X.T @ G @ W, Y * c, W), True)  # fmt: skip

    def additive(self) -> Method:
        parts = {str(n): runge_kutta(self.read(x["A"]), self.read(x["b"]))
                 for n, x in enumerate(self.document["parts"], 1)}  # fmt: skip
        return Method(parts, dict.fromkeys(parts, "".join(parts)))

    def nystrom(self, row: Mapping[str, Any] | None = None) -> Method:
        """Return the pair with the weights of a row: stages P_0 = p and P_l = p + h g_l."""
        row = row or self.document
        (A, c), b, b_p = self.get("A", "c"), self.read(row["b"]), self.read(row["b_prime"])
        s = len(c)
        A_q, A_p = np.column_stack([c - A.sum(axis=1), A]), np.vstack([zeros(s), eye(s)])
        b_q = array([1 - b.sum(), *b])
        if "A_prime" in self.document:
            A_p = np.vstack([A_p, self.get("A_prime")])
            A_q = np.pad(A_q, ((s + 1, 0), (0, s)))
            A_p = np.pad(A_p, ((0, 0), (s + 1, 0)))
            b_q, b_p = np.pad(b_q, (0, s)), np.pad(b_p, (s + 1, 0))
        return pair(runge_kutta(A_q, b_q), runge_kutta(A_p, b_p), "A_prime" not in self.document)

    def rosenbrock(self, row: Mapping[str, Any] | None = None,
                    counts: Callable[[Tree], bool] = of_rosenbrock) -> Method:  # fmt: skip
        """Return the additive method with the weights of a row, stages of f - J before those of J."""
        alpha, gamma = self.get("alpha", "gamma")
        rows, weights, n = (
            np.vstack([alpha, alpha + gamma]),
            self.read((row or self.document)["b"]),
            len(alpha),
        )
        parts = {c: runge_kutta(np.pad(rows, ((0, 0), x)), np.pad(weights, x))
                 for c, x in (("1", (0, n)), ("2", (n, 0)))}  # fmt: skip
        return Method(parts, {"1": "12", "2": "12"}, counts=counts)

    def timed(self, method: Method) -> Method:
        """Return a Runge-Kutta method with the time as a second variable, where c is not A 1."""
        if self.kind != "rk" or "c" not in self.document:
            return method
        m, c = method.parts["o"], self.get("c")
        if self.margin.zeros(m.A.sum(axis=1) - c):
            return method
        first = eye(len(c))[0]
        return pair(m, runge_kutta(np.outer(c, first), first), False, counts=of_time)

    def linear(self) -> Part:
        """Return the method that a linear equation y' = z y sees."""
        if self.kind == "rosenbrock":
            alpha, gamma, b = self.get("alpha", "gamma", "b")
            return runge_kutta(alpha + gamma, b)
        return self.method.parts["o"]

    def embedded(self) -> dict[str, Method]:
        """Return the method of each embedded row, the solution of class glm apart."""
        return {row["name"]: self._row(row) for row in self.document.get("embedded", ())}

    def _row(self, row: Mapping[str, Any]) -> Method:
        if self.kind == "nystrom":
            return self.nystrom(row)
        if self.kind == "rosenbrock":
            return self.rosenbrock(row)
        parts = self.method.parts
        if self.kind == "additive":
            rows = dict(zip(parts, map(self.read, row["b"]), strict=True))
        else:
            rows = {"o": self.read(row["b"]) if "b" in row
                    else parts["o"].B[0] - self.read(row["error"])}  # fmt: skip
        new = {c: runge_kutta(m.A, rows[c]) for c, m in parts.items()}
        return self.timed(replace(self.method, parts=new))

    @cached_property
    def exact_V(self) -> bool:
        """Whether V has no decimals but zeros."""
        if not self.rounded or self.kind not in ("glm", "sweep", "pair-sweep"):
            return not self.rounded or self.method.one
        probe = Reader({})
        try:
            probe(self.document["V"] + self.document.get("V_hat", []))
        except KeyError:
            return False
        return not probe.decimals
