"""Integrators with tables that were published in code and are wrong, and with the right tables.

``real_defects.json`` states each table as it stands in the file named there (``where``, at the
version ``commit``), what it declares, the order it has (``found``) and what is right: the entries to
change, another order, or a table; ``caught`` has the claim that fails in the conformance suite, and
words of its messages. Only numbers are taken over.
"""

import copy
import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np

from glmref.exact.expression import parse

DEFECTS: dict[str, dict[str, Any]] = {
    x["name"]: x for x in json.loads((Path(__file__).parent / "real_defects.json").read_text())
}


def number(text: str) -> float:
    """Return a decimal, a fraction or an expression with roots as a double."""
    return float(parse(text) if "sqrt" in text else Fraction(text))


def matrix(entries: list[list[Any]], rows: int, columns: int) -> np.ndarray:
    """Matrix of the entries ``[i, j, text]``, which count from one; the others are zero."""
    found = np.zeros((rows, columns))
    for i, j, text in entries:
        found[i - 1, j - 1] = number(text)
    return found


def vector(texts: list[str]) -> np.ndarray:
    return np.array([number(x) for x in texts])


class Explicit:
    """A Runge-Kutta method with stages one after the other; diagonal entries by Newton."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.b, self.c = vector(table["b"]), vector(table["c"])
        self.A = matrix(table["A"], len(self.b), len(self.b))

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        slopes: list[np.ndarray] = []
        for i, row in enumerate(self.A):
            time = t + self.c[i] * h
            where = base = y + h * sum(row[j] * k for j, k in enumerate(slopes))
            if row[i]:
                where = base + h * row[i] * problem.f(time, base)
                for _ in range(30):
                    gap = base + h * row[i] * problem.f(time, where) - where
                    system = np.eye(len(y)) - h * row[i] * problem.jacobian(time, where)
                    where = where + np.linalg.solve(system, gap)
                    if np.abs(gap).max() < 1e-15:
                        break
            slopes.append(problem.f(time, where))
        return y + h * sum(b * k for b, k in zip(self.b, slopes, strict=True))


class Separable:
    """An integrator for q' = dq(p), p' = dp(q) only."""

    methods: dict[str, Any]
    problems: tuple[str, ...]
    tolerance = 0.0

    def halves(self, problem: Any, y: Any) -> tuple[Any, Any]:
        if not problem.separable:
            raise NotImplementedError("separable problems only")
        return y[: len(y) // 2], y[len(y) // 2 :]


class Additive(Separable):
    """An additive method: q' = dq(p) with the explicit table, p' = dp(q) with the implicit one."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.b = vector(table["b"])
        self.A, self.implicit = (matrix(table[x], len(self.b), len(self.b))
                                 for x in ("A", "A_implicit"))  # fmt: skip

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        q, p = self.halves(problem, y)
        F, K = np.zeros((2, len(self.b), len(q)))
        for i in range(len(self.b)):
            K[i] = problem.dp(q + h * self.A[i] @ F)
            F[i] = problem.dq(p + h * self.implicit[i] @ K)
        return np.concatenate([q + h * self.b @ F, p + h * self.b @ K])


class Splitting(Separable):
    """Kicks and drifts in turn."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.drift, self.kick = vector(table["drift"]), vector(table["kick"])

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        q, p = self.halves(problem, y)
        for i, kick in enumerate(self.kick):
            p = p + h * kick * problem.dp(q)
            if i < len(self.drift):
                q = q + h * self.drift[i] * problem.dq(p)
        return np.concatenate([q, p])


class Glee:
    """A general linear method of two solutions that start as one; the first is the result."""

    def __init__(self, table: dict[str, Any]) -> None:
        s = max(i for i, _, _ in table["A"])
        self.A, self.U = matrix(table["A"], s, s), matrix(table["U"], s, 2)
        self.B, self.c = matrix(table["B"], 2, s), matrix(table["A"], s, s).sum(axis=1)

    def solve(self, method: str, problem: Any, h: float, steps: int) -> Any:
        values = np.array([problem.y0, problem.y0], dtype=float)
        for n in range(steps):
            t, slopes = problem.t_span[0] + n * h, np.zeros((len(self.A), values.shape[1]))
            for i, row in enumerate(self.A):
                slopes[i] = problem.f(t + self.c[i] * h, h * row @ slopes + self.U[i] @ values)
            values = h * self.B @ slopes + values
        return values[0]


class Rosenbrock:
    """A Rosenbrock method: (1 - h gamma J) k_i = f(Y_i) + J sum gamma_ij h k_j + h gamma_i f_t."""

    def __init__(self, table: dict[str, Any]) -> None:
        self.b = vector(table["b"])
        self.A, self.G = (matrix(table[x], len(self.b), len(self.b)) for x in ("A", "Gamma"))

    def step(self, method: str, problem: Any, t: float, y: Any, h: float) -> Any:
        J, slopes = self.jacobian(problem, t, y), np.zeros((len(self.b), len(y)))
        by_time = self.by_time(problem, t, y)
        for i, row in enumerate(self.A):
            right = problem.f(t + row.sum() * h, y + h * row @ slopes)
            right = right + h * J @ (self.G[i] @ slopes) + h * self.G[i].sum() * by_time
            slopes[i] = np.linalg.solve(np.eye(len(y)) - h * self.G[i, i] * J, right)
        return y + h * self.b @ slopes

    def jacobian(self, problem: Any, t: float, y: Any) -> Any:
        return problem.jacobian(t, y)

    def by_time(self, problem: Any, t: float, y: Any) -> Any:
        """Derivative of f by t."""
        return np.array([1.0, 2 * t - y[0]]) if problem.name == "forced" else 0.0


KINDS: dict[str, Any] = {
    "rk": Explicit, "dirk": Explicit, "additive": Additive, "splitting": Splitting,
    "glee": Glee, "rosenbrock": Rosenbrock,
}  # fmt: skip


def published(name: str) -> Any:
    """Return the integrator with the table as published, claiming what is declared."""
    entry = DEFECTS[name]
    made: Any = KINDS[entry["kind"]](entry["table"])
    made.methods = {name: {"order": entry["declared"]}}
    # what depends on time is not separable; one problem of each kind shows these defects
    made.problems = ("pendulum",) if isinstance(made, Separable) else ("pendulum", "forced")
    if "abscissae" in entry:
        made.methods[name]["abscissae"] = [number(x) for x in entry["abscissae"]]
    return made


def mended(name: str) -> Any:
    """Return the integrator with the table that is right, or that claims the order it has."""
    entry = DEFECTS[name]
    table, right = copy.deepcopy(entry["table"]), entry["right"]
    table = right.get("table", table)
    for block, i, *rest in right.get("changes", ()):
        if block == "c":
            table["c"][i - 1] = rest[0]
        else:
            j, text = rest
            table[block] = [x for x in table[block] if x[:2] != [i, j]] + [[i, j, text]]
    table["b"] = right.get("b", table.get("b"))
    made: Any = KINDS[entry["kind"]](table)
    claims = published(name)
    made.methods, made.problems = claims.methods, claims.problems
    made.methods[name]["order"] = right.get("order", entry["declared"])
    return made
