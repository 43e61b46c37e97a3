"""Documents near every boundary, drawn at random, and claims about them."""

from __future__ import annotations

import random
from fractions import Fraction
from typing import Any

Document = dict[str, Any]
ENTRIES = ("0", "0", "0", "1", "1", "1/2", "1/2", "-1", "1/3", "2/3", "1/4", "2", "1/6")
NEAR = ("+1/1" + "0" * 30, "-1/1" + "0" * 55)
SPECTRA = (
    ("1",), ("1", "-1"), ("1", "1"), ("1", "0"), ("1", "1/2"), ("-1",), ("1", "1", "-1"), ("1", "-1", "-1"),
    ("1", "2"), ("1", "1", "1/2"), ("1", "0", "-1"), ("1", "1", "1"),
)  # fmt: skip


class Draw:
    """A stream of documents.

    Parameters
    ----------
    rng : random.Random
        The source of randomness.
    """

    def __init__(self, rng: random.Random) -> None:
        self.rng = rng

    def entry(self) -> Fraction:
        """Return a small number."""
        return Fraction(self.rng.choice(ENTRIES))

    def matrix(self, rows: int, columns: int, shape: str = "") -> list[list[Fraction]]:
        """Return a matrix: full, or strictly or weakly lower triangular."""
        last = {"<": 0, "<=": 1}.get(shape, columns)
        return [[self.entry() if j < i + last or shape == "" else Fraction(0) for j in range(columns)]
                for i in range(rows)]  # fmt: skip

    def text(self, value: Any) -> Any:
        """Return numbers as entries, now and then beside what they were."""
        if isinstance(value, list):
            return [self.text(x) for x in value]
        return f"{value}{self.rng.choice(NEAR)}" if self.rng.random() < 0.004 else str(value)

    def component(self) -> Document:
        """Return A, U, B, V: a spectrum in a random basis, U u = 1 and w B 1 = w u often."""
        rng, spectrum = self.rng, self.rng.choice(SPECTRA)
        r, s = len(spectrum), rng.choice((1, 1, 2, 2, 3))
        V = [
            [Fraction(x) if i == j else Fraction(0) for j in range(r)]
            for i, x in enumerate(spectrum)
        ]
        if r > 1 and rng.random() < 0.3:
            V[0][rng.randrange(1, r)] = self.entry()
        A = self.matrix(s, s, rng.choice(("", "<", "<=", "<=")))
        U, B = self.matrix(s, r), self.matrix(r, s)
        ones = [k for k, x in enumerate(spectrum) if x == "1"]
        if rng.random() < 0.85:
            for row in U:
                row[0] = Fraction(1)
            for k in ones:
                B[k][-1] += (1 if k == 0 else 0) - sum(B[k])
                if k:
                    B[k][-1] += rng.choice((0, 0, 1))
        if rng.random() < 0.3:
            self.adjoint(A, U, B, V)
        if r > 1 and rng.random() < 0.5:  # another basis
            i, j, x = *rng.sample(range(r), 2), Fraction(rng.choice((1, -1, 2, 5)))
            V[i] = [a + x * b for a, b in zip(V[i], V[j], strict=True)]
            B[i] = [a + x * b for a, b in zip(B[i], B[j], strict=True)]
            for row in (*V, *U):
                row[j] -= x * row[i]
        if rng.random() < 0.2:
            k, x = rng.randrange(r), Fraction(rng.choice((2, -1, 7, 1000)))
            V[k], B[k] = [a * x for a in V[k]], [a * x for a in B[k]]
            for row in (*V, *U):
                row[k] /= x
        return {"A": A, "U": U, "B": B, "V": V}

    def adjoint(self, A: Any, U: Any, B: Any, V: Any) -> None:
        """Make a method G-symplectic for G = diag(+-1): a sweep of weights b."""
        r, s, rng = len(V), len(A), self.rng
        if any(abs(V[k][k]) != 1 for k in range(r)) or any(V[0][1:]):
            return
        G = [Fraction(1)] + [Fraction(rng.choice((1, -1))) for _ in range(r - 1)]
        X = [[Fraction(1)] * s, *self.matrix(r - 1, s)]
        D = [Fraction(1, s)] * s
        for i in range(s):
            for j in range(s):
                inner = sum(G[k] * X[k][i] * X[k][j] for k in range(r))
                A[i][j] = inner * D[j] / (1 if j < i else 2) if j <= i else Fraction(0)
            U[i][:] = [X[k][i] * G[k] * V[k][k] for k in range(r)]
        for k in range(r):
            B[k][:] = [X[k][i] * D[i] for i in range(s)]

    def start(self, r: int) -> Document:
        """Return a start, often with values of the solution only."""
        m = self.rng.choice((1, 1, 2))
        u = [1] + [self.rng.choice((0, 0, 1, 2)) for _ in range(r - 1)]
        return {"A": self.matrix(m, m, "<"), "B": self.matrix(r, m), "u": u}

    def document(self) -> Document:
        """Return a document of any class."""
        kind = self.rng.choice(
            ("glm",) * 8
            + ("rk",) * 3
            + ("lmm", "lmm", "one_leg", "partitioned_rk", "splitting")
            + ("partitioned",) * 4
            + ("additive", "nystrom", "rosenbrock", "ends", "decimals")
        )
        found = getattr(self, "_" + kind)()
        return {"format": "glmref-method-2", "name": "drawn", **self._texts(found)}

    def _texts(self, value: Any, key: str = "") -> Any:
        if key in ("class", "name", "first", "base") or isinstance(value, bool) or key == "digits":
            return value
        if isinstance(value, dict):
            return {k: self._texts(x, k) for k, x in value.items()}
        if isinstance(value, list):
            return [self._texts(x) for x in value]
        return value if isinstance(value, str) else self.text(value)

    def _glm(self) -> Document:
        found = {"class": "glm", **self.component()}
        r, s, rng = len(found["V"]), len(found["A"]), self.rng
        if rng.random() < 0.15:
            found["G"] = [rng.choice((1, -1, 2)) for _ in range(r)]
            if rng.random() < 0.5:
                found["D"] = [self.entry() for _ in range(s)]
        if rng.random() < 0.3:
            found["starting"] = self.start(r)
            if rng.random() < 0.4:
                found["finishing"] = self._finish(found["starting"])
        return found

    def _finish(self, start: Document) -> Document:
        A, b = start["A"], start["B"][0]
        if self.rng.random() < 0.6:
            return {
                "A": [[x - y for x, y in zip(row, b, strict=True)] for row in A],
                "b": [-x for x in b],
            }
        m = len(A)
        return {"A": self.matrix(m, m, "<"), "b": self.matrix(1, m)[0]}

    def _rk(self) -> Document:
        s, rng = self.rng.choice((1, 2, 2, 3)), self.rng
        A, b = self.matrix(s, s, rng.choice(("", "<", "<="))), self.matrix(1, s)[0]
        if rng.random() < 0.7:
            b[-1] += 1 - sum(b)
        found: Document = {"class": "rk", "A": A, "b": b}
        if rng.random() < 0.25:
            found["c"] = [sum(row) if rng.random() < 0.7 else self.entry() for row in A]
        if rng.random() < 0.2:
            found["embedded"] = [{"name": "e", "b": self.matrix(1, s)[0]}]
        if rng.random() < 0.2:
            found["dense"] = self.matrix(s, 2)
        if rng.random() < 0.25 and "c" not in found:
            found["starting"] = {**self.start(1), "u": [rng.choice((1, 1, 2))]}
            found["finishing"] = self._finish(found["starting"])
        return found

    def _lmm(self) -> Document:
        k = self.rng.choice((1, 2, 2, 3))
        alpha = [*self.matrix(1, k)[0], Fraction(1)]
        alpha[0] -= sum(alpha) if self.rng.random() < 0.85 else 0
        beta = self.matrix(1, k + 1)[0]
        if self.rng.random() < 0.85:
            beta[0] += sum(m * x for m, x in enumerate(alpha)) - sum(beta)
        return {"class": "lmm", "alpha": alpha, "beta": beta}

    def _one_leg(self) -> Document:
        found = {**self._lmm(), "class": "one-leg"}
        found["beta"][0] += 1 - sum(found["beta"])
        return found

    def _partitioned_rk(self) -> Document:
        s, rng = self.rng.choice((1, 2)), self.rng
        A, b = self.matrix(s, s, rng.choice(("", "<="))), self.matrix(1, s)[0]
        b[-1] += 1 - sum(b)
        adjoint = [[y - x * y / z if z else self.entry() for x, y in zip(column, b, strict=True)]
                   for column, z in zip(zip(*A, strict=True), b, strict=True)]  # fmt: skip
        hat = adjoint if rng.random() < 0.6 else self.matrix(s, s)
        return {"class": "partitioned-rk", "A": A, "b": b, "A_hat": hat, "b_hat": b}

    def _partitioned(self) -> Document:
        q, rng = self.component(), self.rng
        p = q if rng.random() < 0.6 else self.component()
        found: Document = {"class": "partitioned", "q": q, "p": p, "separable": rng.random() < 0.6}
        same = len(q["A"]) == len(p["A"])
        if not same:
            found["p"] = p = q
        if rng.random() < 0.2:
            found["G"] = [rng.choice((1, -1)) for _ in q["V"]]
            for key in ("D_P", "D_Q"):
                if rng.random() < 0.5:
                    found[key] = [self.entry() for _ in q["A"]]
        if rng.random() < 0.3:
            a, b = self.start(len(q["V"])), self.start(len(p["V"]))
            b = b if len(a["A"]) == len(b["A"]) else a
            found["starting"] = {**a, **{f"{k}_hat": x for k, x in b.items()}}
        return found

    def _splitting(self) -> Document:
        n = self.rng.choice((1, 2, 3))
        a, b = self.matrix(1, n)[0], self.matrix(1, n - self.rng.choice((0, 1)) or 1)[0]
        for x in (a, b):
            if self.rng.random() < 0.8:
                x[-1] += 1 - sum(x)
            if self.rng.random() < 0.4:
                x[:] = [(y + z) / 2 for y, z in zip(x, reversed(x), strict=True)]
        return {"class": "splitting", "first": "q", "a": a, "b": b}

    def _additive(self) -> Document:
        s = self.rng.choice((1, 2))
        return {
            "class": "additive",
            "parts": [{"A": self.matrix(s, s), "b": self.one(s)} for _ in "12"],
        }

    def one(self, s: int) -> list[Fraction]:
        """Return weights that sum to 1 mostly."""
        b = self.matrix(1, s)[0]
        b[-1] += (1 - sum(b)) * (self.rng.random() < 0.8)
        return b

    def _nystrom(self) -> Document:
        s = self.rng.choice((1, 2))
        b = self.one(s)
        found = {"class": "nystrom", "A": self.matrix(s, s, "<"), "b": [x / 2 for x in self.one(s)], "b_prime": b,
                 "c": self.matrix(1, s)[0]}  # fmt: skip
        return {**found, "A_prime": self.matrix(s, s, "<")} if self.rng.random() < 0.4 else found

    def _rosenbrock(self) -> Document:
        s, g = self.rng.choice((1, 2)), self.entry()
        gamma = self.matrix(s, s, "<")
        for i in range(s):
            gamma[i][i] = g
        return {
            "class": "rosenbrock",
            "alpha": self.matrix(s, s, "<"),
            "gamma": gamma,
            "b": self.one(s),
        }

    def _ends(self) -> Document:
        """Return a multistep method whose output is another one than the first value."""
        found = self._glm()
        r = len(found["V"])
        w = [self.entry() for _ in range(r)]
        w[0] = Fraction(1) - sum(w[1:])
        return {**found, "output": w}

    def _decimals(self) -> Document:
        found = self._rk() if self.rng.random() < 0.5 else self._glm()
        for key in ("starting", "finishing", "embedded", "dense", "c"):
            found.pop(key, None)
        digits = self.rng.choice((6, 15, 40))
        for row in found["A"]:
            row[:] = [
                f"{float(x):.{min(digits, 15)}f}{'0' * (digits - min(digits, 15))}"
                if x.denominator in (1, 2, 4)
                else x
                for x in row
            ]
        return {**found, "digits": digits}


def claims_of(document: Document, rng: random.Random) -> dict[str, Any]:
    """Return claims that a document of this class can make, with values that may be right."""
    kind = document["class"]
    if kind == "rosenbrock":
        keys = ["order", "w-order", "a-stable", "l-stable"]
    elif kind == "additive":
        keys = ["order", "stage-order", "consistent", "explicit", "preconsistent"]
    elif kind in ("partitioned", "partitioned-rk", "splitting", "nystrom"):
        keys = ["order", "order-identity", "stage-order", "starting-order", "preconsistent", "consistent", "explicit",
                "zero-stable", "symplectic", "g-symplectic", "symmetric", "parasitism-free", "reducible", "growth"]  # fmt: skip
        keys += ["nystrom-order", "row-sums"] if kind == "nystrom" else []
    else:
        keys = ["order", "order-identity", "stage-order", "preconsistent", "consistent", "zero-stable", "explicit",
                "symplectic", "g-symplectic", "symmetric", "symmetric-reduced", "parasitism-free", "growth", "a-stable",
                "l-stable", "abscissae", "conjugate-symplectic", "conjugate-symplectic-order",
                "hamiltonian-to-order", "energy-order", "second-order-growth"]  # fmt: skip
        keys += ["effective-order"] if kind == "rk" else []
        keys += ["error-constant"] if kind in ("lmm", "one-leg") else []
        keys += [
            x
            for x, y in (("starting-order", "starting"), ("finishing-order", "finishing"))
            if y in document
        ]
        keys += ["row-sums"] if "c" in document else []
        keys += ["dense-order", "dense-end"] if "dense" in document else []
        keys += ["embedded-difference"] if "embedded" in document else []
    found: dict[str, Any] = {}
    for key in keys:
        if key == "second-order-growth":
            found[key] = ["0", "0"]
        elif "order" in key:
            found[key] = rng.choice((0, 1, 1, 2, 2, 3))
        elif key == "growth":
            found[key] = (
                ["0"] * rng.choice((0, 0, 1, 1, 2))
                if rng.random() < 0.7
                else [rng.choice(("1", "-1"))]
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
