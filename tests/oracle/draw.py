"""Documents near every boundary, drawn at random, and claims about them."""

import random
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

Document = dict[str, Any]
Array = Any
ENTRIES = [Fraction(x) for x in "0 0 0 1 1 1/2 1/2 -1 1/3 2/3 1/4 2 1/6".split()]
NEAR = ("+1/1" + "0" * 30, "-1/1" + "0" * 55)
#: Eigenvalues of V, or V with a turn or a Jordan block.
SPECTRA = (
    "1", "1 -1", "1 1", "1 0", "1 1/2", "-1", "1 1 -1", "1 -1 -1", "1 2", "1 1 1/2", "1 0 -1", "1 1 1", "1 9/8",
    "1 1;0 1", "1 0 0;0 0 -1;0 1 0", "1 0 0;0 -1 1;0 0 -1", "1 0 0;0 1/2 1;0 0 1/2", "1 0 0;0 0 1;0 0 0",
)  # fmt: skip
KINDS = [
    *["glm"] * 8, *["rk"] * 3, *["lmm"] * 2, *["partitioned"] * 4, "one_leg", "partitioned_rk", "splitting",
    "additive", "nystrom", "rosenbrock", "ends", "decimals",
]  # fmt: skip
ONE = """preconsistent consistent zero-stable explicit symplectic g-symplectic symmetric symmetric-reduced
    parasitism-free a-stable l-stable conjugate-symplectic order order-identity stage-order hamiltonian-to-order
    conjugate-symplectic-order energy-order second-order-growth growth abscissae""".split()
TWO = """preconsistent consistent zero-stable explicit symplectic g-symplectic symmetric parasitism-free reducible
    order order-identity stage-order starting-order growth""".split()
#: Claims that a class can make, and those that a document with a key can.
CLAIMS = {
    "rosenbrock": ["order", "w-order", "a-stable", "l-stable"],
    "additive": ["order", "stage-order", "consistent", "explicit", "preconsistent"],
    "partitioned": TWO, "partitioned-rk": TWO, "splitting": TWO,
    "nystrom": [*TWO, "nystrom-order", "row-sums"],
    "rk": [*ONE, "effective-order"], "glm": ONE,
    "lmm": [*ONE, "error-constant"], "one-leg": [*ONE, "error-constant"],
}  # fmt: skip
OF_KEYS = {
    "starting": ["starting-order"], "finishing": ["finishing-order"], "c": ["row-sums"],
    "dense": ["dense-order", "dense-end"], "embedded": ["embedded-difference"],
}  # fmt: skip


class Draw:
    """A stream of documents, in which so many entries stand beside what they were."""

    def __init__(self, rng: random.Random, near: float = 0.004) -> None:
        self.rng, self.near = rng, near

    def chance(self, x: float) -> bool:
        return self.rng.random() < x

    def entry(self) -> Fraction:
        return self.rng.choice(ENTRIES)

    def matrix(self, rows: int, columns: int, shapes: str = " ") -> Array:
        """Return a matrix: full, or strictly or weakly lower triangular."""
        found = np.array([[self.entry() for _ in range(columns)] for _ in range(rows)])
        shape = self.rng.choice(shapes)
        return found if shape == " " else np.tril(found, "<=".index(shape) - 1)

    def weights(self, s: int, chance: float = 0.8) -> Array:
        """Return weights that sum to 1 mostly."""
        b = self.matrix(1, s)[0]
        b[-1] += (1 - b.sum()) * self.chance(chance)
        return b

    def text(self, value: Any, key: str = "") -> Any:
        """Return numbers as entries."""
        if isinstance(value, dict):
            return {k: self.text(x, k) for k, x in value.items()}
        if isinstance(value, np.ndarray | list):
            return [self.text(x) for x in value]
        if key in ("class", "name", "first", "digits", "separable") or isinstance(value, str):
            return value
        return f"{value}{self.rng.choice(NEAR)}" if self.chance(self.near) else str(value)

    def component(self, s: int = 0, slopes: int = 0, spectrum: str = "") -> Document:
        """Return A, U, B, V: a spectrum in a random basis, U u = 1 and w B 1 = w u often."""
        rng, rows = self.rng, (spectrum or self.rng.choice(SPECTRA)).split(";")
        V = np.array([[Fraction(x) for x in row.split()] for row in rows])
        V = V if len(rows) > 1 else np.diag(V[0])
        r, s, ones = len(V), s or rng.choice((1, 1, 2, 2, 3)), np.flatnonzero(np.diag(V) == 1)
        n = slopes or s
        T, inverse = (np.eye(r, dtype=object) * Fraction(1) for _ in "TI")
        if r > 1 and self.chance(0.3):
            V[0, rng.randrange(1, r)] = self.entry()
        A, U, B = self.matrix(s, n, " <=="), self.matrix(s, r), self.matrix(r, n)
        if self.chance(0.85):
            U[:, 0] = Fraction(1)
            for k in ones:
                B[k, -1] += rng.choice((0, 0, 1)) * (k > 0) + int(k == 0) - B[k].sum()
        if s == n and self.chance(0.3) and (abs(V) == np.eye(r)).all():
            # G-symplectic for G = diag(+-1): a sweep of equal weights
            G = np.diag([Fraction(1)] + [Fraction(rng.choice((1, -1))) for _ in range(r - 1)])
            X = np.vstack([[Fraction(1)] * s, self.matrix(r - 1, s).reshape(r - 1, s)])
            S = X.T @ G @ X / s
            A, U, B = np.tril(S, -1) + np.diag(np.diag(S) / 2), X.T @ G @ V, X / s
        if r > 1 and self.chance(0.5):  # another basis
            i, j, x = *rng.sample(range(r), 2), rng.choice((1, -1, 2, 5))
            T[i, j], inverse[i, j] = Fraction(x), Fraction(-x)
        if self.chance(0.2):
            k, x = rng.randrange(r), rng.choice((2, -1, 7, 1000))
            T[k], inverse[:, k] = T[k] * x, inverse[:, k] / x
        return {"A": A, "U": U @ inverse, "B": T @ B, "V": T @ V @ inverse}

    def halves(self) -> tuple[Document, Document]:
        """Return two components, of which each calls the slopes of the other's stages."""
        n, m = self.rng.choice(((1, 1), (1, 1), (2, 2), (2, 2), (3, 3), (2, 1), (1, 2)))
        q = self.component(n, m, spectrum := self.rng.choice(SPECTRA))
        if n == m and self.chance(0.5):
            return q, q
        return q, self.component(m, n, spectrum if self.chance(0.5) else "")

    def start(self, r: int) -> Document:
        """Return a start, often with values of the solution only."""
        m = self.rng.choice((1, 1, 2))
        u = [1] + [self.rng.choice((0, 0, 1, 2)) for _ in range(r - 1)]
        return {"A": self.matrix(m, m, "<"), "B": self.matrix(r, m), "u": u}

    def finish(self, start: Document) -> Document:
        """Return a finish, often the start undone where its first value is the solution."""
        A, b = start["A"], start["B"][0]
        if self.chance(0.6):
            return {"A": A - b, "b": -b}
        return {"A": self.matrix(*A.shape, "<"), "b": self.matrix(1, len(b))[0]}

    def document(self, kinds: Sequence[str] = KINDS) -> Document:
        """Return a document of one of these kinds."""
        found = getattr(self, "_" + self.rng.choice(kinds))()
        return {"format": "glmref-method-2", "name": "drawn", **self.text(found)}

    def _glm(self) -> Document:
        found = {"class": "glm", **self.component()}
        (r, s), rng = found["B"].shape, self.rng
        if self.chance(0.15):
            found["G"] = [rng.choice((1, -1, 2)) for _ in range(r)]
            if self.chance(0.5):
                found["D"] = self.matrix(1, s)[0]
        if self.chance(0.3):
            found["starting"] = self.start(r)
            if self.chance(0.4):
                found["finishing"] = self.finish(found["starting"])
        return found

    def _rk(self) -> Document:
        s = self.rng.choice((1, 2, 2, 3))
        found: Document = {"class": "rk", "A": self.matrix(s, s, " <="), "b": self.weights(s, 0.7)}
        if self.chance(0.25):
            found["c"] = [sum(row) if self.chance(0.7) else self.entry() for row in found["A"]]
        if self.chance(0.2):
            found["embedded"] = [{"name": "e", "b": self.matrix(1, s)[0]}]
        if self.chance(0.2):
            found["dense"] = self.matrix(s, 2)
        if self.chance(0.25) and "c" not in found:
            found["starting"] = {**self.start(1), "u": [self.rng.choice((1, 1, 2))]}
            found["finishing"] = self.finish(found["starting"])
        return found

    def _lmm(self) -> Document:
        k = self.rng.choice((1, 2, 2, 3))
        alpha = np.array([*self.matrix(1, k)[0], Fraction(1)])
        alpha[0] -= alpha.sum() * self.chance(0.85)
        beta = self.matrix(1, k + 1)[0]
        beta[0] += (alpha @ range(k + 1) - beta.sum()) * self.chance(0.85)
        return {"class": "lmm", "alpha": alpha, "beta": beta}

    def _one_leg(self) -> Document:
        found = {**self._lmm(), "class": "one-leg"}
        found["beta"][0] += 1 - found["beta"].sum()
        return found

    def _partitioned_rk(self) -> Document:
        s = self.rng.choice((1, 2))
        A, b, hat = self.matrix(s, s, " ="), self.weights(s, 1), self.matrix(s, s)
        if self.chance(0.6):  # symplectic
            hat = np.array(
                [b - row * b / z if z else old for row, z, old in zip(A.T, b, hat, strict=True)]
            )
        return {"class": "partitioned-rk", "A": A, "b": b, "A_hat": hat, "b_hat": b}

    def _partitioned(self) -> Document:
        (q, p), rng = self.halves(), self.rng
        separable = q["A"].shape != p["A"].shape or self.chance(0.6)
        found: Document = {"class": "partitioned", "q": q, "p": p, "separable": separable}
        if self.chance(0.2):
            found["G"] = [rng.choice((1, -1)) for _ in q["V"]]
            for key, half in (("D_P", q), ("D_Q", p)):
                if self.chance(0.5):
                    found[key] = self.matrix(1, half["B"].shape[1])[0]
        if self.chance(0.3):
            a, b = self.start(len(q["V"])), self.start(len(p["V"]))
            b = b if len(a["A"]) == len(b["A"]) else a
            found["starting"] = {**a, **{f"{k}_hat": x for k, x in b.items()}}
        return found

    def _splitting(self) -> Document:
        n = self.rng.choice((1, 2, 3))
        a, b = self.weights(n), self.weights(n - self.rng.choice((0, 1)) or 1)
        a, b = ((x + x[::-1]) / 2 if self.chance(0.4) else x for x in (a, b))
        return {"class": "splitting", "first": "q", "a": a, "b": b}

    def _additive(self) -> Document:
        s = self.rng.choice((1, 2))
        parts = [{"A": self.matrix(s, s), "b": self.weights(s)} for _ in "12"]
        return {"class": "additive", "parts": parts}

    def _nystrom(self) -> Document:
        s = self.rng.choice((1, 2))
        found = {"class": "nystrom", "A": self.matrix(s, s, "<"), "c": self.matrix(1, s)[0],
                 "b": self.weights(s) / 2, "b_prime": self.weights(s)}  # fmt: skip
        return {**found, "A_prime": self.matrix(s, s, "<")} if self.chance(0.4) else found

    def _rosenbrock(self) -> Document:
        s = self.rng.choice((1, 2))
        gamma = self.matrix(s, s, "<") + np.diag([self.entry()] * s)
        return {
            "class": "rosenbrock",
            "alpha": self.matrix(s, s, "<"),
            "gamma": gamma,
            "b": self.weights(s),
        }

    def _ends(self) -> Document:
        """Return a multistep method whose output is another one than the first value."""
        found = self._glm()
        w = self.matrix(1, len(found["V"]))[0]
        w[0] = 1 - w[1:].sum()
        return {**found, "output": w}

    def _decimals(self) -> Document:
        found = self._rk() if self.chance(0.5) else self._glm()
        digits = self.rng.choice((6, 15, 40))
        texts = [[f"{float(x):.{min(digits, 15)}f}".ljust(digits + 2 + (x < 0), "0") if x.denominator in (1, 2, 4) else x
                  for x in row] for row in found["A"]]  # fmt: skip
        for key in ("starting", "finishing", "embedded", "dense", "c"):
            found.pop(key, None)
        return {**found, "A": texts, "digits": digits}


def claims_of(document: Document, rng: random.Random) -> dict[str, Any]:
    """Return claims that a document of this class can make, with values that may be right."""
    keys = CLAIMS[document["class"]] + [
        x for key, more in OF_KEYS.items() if key in document for x in more
    ]
    found: dict[str, Any] = {}
    for key in dict.fromkeys(keys):
        if key == "second-order-growth":
            found[key] = ["0", "0"]
        elif "order" in key:
            found[key] = rng.choice((0, 1, 1, 2, 2, 3))
        elif key == "growth":
            found[key] = rng.choice(
                [["0"] * rng.choice((0, 0, 1, 1, 2))] * 14 + [["1"], ["-1"]] * 3
            )
        elif key == "abscissae":
            rows = document.get("A") or [["1"]]
            try:
                found[key] = [str(sum(map(Fraction, row))) for row in rows]
            except ValueError:
                found[key] = ["0"] * len(rows)
        elif key == "error-constant":
            found[key] = rng.choice(("1/2", "-1/2", "1/12", "-1/12", "0", "1"))
        else:
            found[key] = True
    return found
