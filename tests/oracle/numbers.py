"""Numbers of the oracle: entries evaluated with mpmath, and linear algebra that may say "I do not know".

What is below :attr:`Margin.low` counts as zero, what is above :attr:`Margin.high` does not; between
them :class:`Undecided` is raised.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

from mpmath import mp

Number = Any  # mpf or mpc
Vector = list[Number]
Matrix = list[Vector]
TOKEN = re.compile(r"\s*(?:(\d*\.\d+|\d+\.?)|([A-Za-z_]\w*)|(.))", re.ASCII)
DIGITS = 100


class Undecided(Exception):
    """The oracle has no opinion."""


class Margin:
    """When a number is zero.

    Parameters
    ----------
    low, high : float or mpf
        Numbers below ``low`` are zero, numbers above ``high`` are not.
    """

    def __init__(self, low: Number, high: Number) -> None:
        self.low, self.high = low, high

    def zero(self, x: Number) -> bool:
        """Return whether x is zero; raise :class:`Undecided` between the margins."""
        size = abs(x)
        if self.low < size <= self.high:
            raise Undecided(f"{mp.nstr(size, 3)} is too near to zero")
        return bool(size <= self.low)

    def zeros(self, values: Sequence[Number]) -> bool:
        """Return whether all are zero: one that surely is not decides."""
        if any(abs(x) > self.high for x in values):
            return False
        return all(self.zero(x) for x in values)

    def echelon(self, M: Matrix) -> tuple[Matrix, list[int]]:
        """Return the reduced rows of M and their pivot columns, by total search in each column."""
        rows, pivots, width = [list(x) for x in M], [], len(M[0]) if M else 0
        for j in range(width):
            top = len(pivots)
            if top == len(rows):
                break
            at = max(range(top, len(rows)), key=lambda i, j=j: abs(rows[i][j]))
            if self.zero(rows[at][j]):
                continue
            rows[top], rows[at] = rows[at], rows[top]
            head = rows[top][j]
            rows[top] = [x / head for x in rows[top]]
            for i, row in enumerate(rows):
                if i != top and row[j] != 0:
                    factor = row[j]
                    rows[i] = [x - factor * y for x, y in zip(row, rows[top], strict=True)]
            pivots.append(j)
        return rows[: len(pivots)], pivots

    def rank(self, M: Matrix) -> int:
        """Return the rank of M."""
        return len(self.echelon(M)[1])

    def null(self, M: Matrix) -> Matrix:
        """Return a basis of M x = 0."""
        rows, pivots = self.echelon(M)
        found = []
        for free in sorted(set(range(len(M[0]))) - set(pivots)):
            x = [mp.mpf(int(j == free)) for j in range(len(M[0]))]
            for row, j in zip(rows, pivots, strict=True):
                x[j] = -row[free]
            found.append(x)
        return found

    def solve(self, M: Matrix, y: Vector) -> Vector | None:
        """Return one x with M x = y, or None where there is none."""
        if not M:
            return []
        n = len(M[0])
        rows, pivots = self.echelon([[*row, b] for row, b in zip(M, y, strict=True)])
        if n in pivots:
            return None
        x = [mp.mpf(0)] * n
        for row, j in zip(rows, pivots, strict=True):
            x[j] = row[n]
        return x

    def inverse(self, M: Matrix) -> Matrix | None:
        """Return the inverse, or None of a singular matrix."""
        n = len(M)
        unit = eye(n)
        rows, pivots = self.echelon([[*a, *b] for a, b in zip(M, unit, strict=True)])
        return [row[n:] for row in rows] if pivots == list(range(n)) else None


def eye(n: int) -> Matrix:
    """Return the unit matrix."""
    return [[mp.mpf(int(i == j)) for j in range(n)] for i in range(n)]


def transposed(M: Matrix) -> Matrix:
    """Return the transpose."""
    return [list(x) for x in zip(*M, strict=True)]


def star(M: Matrix) -> Matrix:
    """Return the conjugate transpose."""
    return [[mp.conj(x) for x in row] for row in transposed(M)]


def dot(x: Sequence[Number], y: Sequence[Number]) -> Number:
    """Return the sum of x_i y_i, without the zeros."""
    return mp.fdot((a, b) for a, b in zip(x, y, strict=True) if a and b)


def at(M: Matrix, x: Sequence[Number]) -> Vector:
    """Return M x."""
    return [dot(row, x) for row in M]


def times(*factors: Matrix) -> Matrix:
    """Return a product of matrices."""
    found = factors[0]
    for M in factors[1:]:
        columns = transposed(M)
        found = [[dot(row, x) for x in columns] for row in found]
    return found


def plus(M: Matrix, N: Matrix, factor: Number = 1) -> Matrix:
    """Return M + factor N."""
    return [[a + factor * b for a, b in zip(x, y, strict=True)] for x, y in zip(M, N, strict=True)]


def flat(*matrices: Matrix) -> Vector:
    """Return all entries."""
    return [x for M in matrices for row in M for x in row]


class Reader:
    """Evaluate the entries of a document by the grammar of ``data/README.md``.

    Attributes
    ----------
    decimals : bool
        Whether a decimal other than 0 was read.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        self.names: dict[str, Number] = {"pi": mp.pi, "i": mp.mpc(0, 1)}
        self.decimals = False
        for name, text in {**document.get("unknowns", {}), **document.get("constants", {})}.items():
            self.names[name] = self(text)

    def __call__(self, text: str) -> Number:
        """Return the number of one entry."""
        tokens = [x for x in TOKEN.findall(text.strip()) if any(x)] + [("", "", "")]
        value, rest = self.sum(tokens)
        if rest != [("", "", "")]:
            raise ValueError(text)
        return value

    def vector(self, texts: Sequence[str]) -> Vector:
        """Return the numbers of a list."""
        return [self(x) for x in texts]

    def matrix(self, rows: Sequence[Sequence[str]]) -> Matrix:
        """Return the numbers of a matrix."""
        return [self.vector(x) for x in rows]

    def sum(self, tokens: list[Any]) -> tuple[Number, list[Any]]:
        """Read a sum."""
        value, tokens = self.product(tokens)
        while tokens[0][2] and tokens[0][2] in "+-":
            sign = 1 if tokens[0][2] == "+" else -1
            more, tokens = self.product(tokens[1:])
            value = value + sign * more
        return value, tokens

    def product(self, tokens: list[Any]) -> tuple[Number, list[Any]]:
        """Read a product."""
        value, tokens = self.factor(tokens)
        while tokens[0][2] and tokens[0][2] in "*/":
            symbol = tokens[0][2]
            more, tokens = self.factor(tokens[1:])
            value = value * more if symbol == "*" else value / more
        return value, tokens

    def factor(self, tokens: list[Any]) -> tuple[Number, list[Any]]:
        """Read a number, a name, a function or a sum in parentheses."""
        (number, name, symbol), tokens = tokens[0], tokens[1:]
        if symbol in ("+", "-"):
            value, tokens = self.factor(tokens)
            return (value if symbol == "+" else -value), tokens
        if number:
            value = mp.mpf(number)
            self.decimals = self.decimals or ("." in number and value != 0)
            return value, tokens
        if symbol == "(":
            value, tokens = self.sum(tokens)
            return value, tokens[1:]
        if tokens[0][2] != "(":
            return self.names[name], tokens
        value, tokens = self.sum(tokens[1:])
        if name == "root":
            power, tokens = self.sum(tokens[1:])
            return mp.root(value, int(power)), tokens[1:]
        return {"sqrt": mp.sqrt, "exp": mp.exp}[name](value), tokens[1:]
