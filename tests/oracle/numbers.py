"""Numbers of the oracle: entries read with mpmath, and linear algebra that may say "I do not know"."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from mpmath import mp

Number = Any  # mpf or mpc
TOKEN = re.compile(r"[A-Za-z_]\w*|(\d*\.\d+|\d+\.?)", re.ASCII)


class Undecided(Exception):
    """The oracle has no opinion."""


class Array(np.ndarray):
    """Numbers of mpmath; in products zeros are skipped, and every entry is rounded once."""

    def __matmul__(self, other: Any) -> Any:
        pairs = ((row, column) for row in np.atleast_2d(self) for column in np.atleast_2d(other.T))
        found = [mp.fdot((x, y) for x, y in zip(*p, strict=True) if x and y) for p in pairs]
        found = np.array(found, dtype=object).reshape(self.shape[:-1] + other.shape[1:])
        return found.view(Array)[()]

    def __rmatmul__(self, other: Any) -> Any:
        return array(other) @ self

    def __array_wrap__(self, found: Any, *_: Any) -> Any:
        return np.asarray(found).view(Array)[()]  # sums are numbers

    @property
    def star(self) -> Array:
        """The conjugate transpose."""
        return self.conj().T


def array(value: Any) -> Array:
    """Return numbers, lists or arrays as numbers of mpmath."""
    return np.array(value, dtype=object).view(Array) * mp.mpf(1)


def zeros(*shape: int) -> Array:
    return array(np.zeros(shape, dtype=int))


def eye(n: int) -> Array:
    return array(np.eye(n, dtype=int))


class Margin:
    """Numbers below ``low`` are zero, numbers above ``high`` are not; between them nobody knows."""

    def __init__(self, low: Number, high: Number) -> None:
        self.low, self.high = low, high

    def zero(self, x: Number) -> bool:
        """Return whether x is zero; raise :class:`Undecided` between the margins."""
        size = abs(x)
        if self.low < size <= self.high:
            raise Undecided(f"{mp.nstr(size, 3)} is too near to zero")
        return bool(size <= self.low)

    def zeros(self, values: Iterable[Number]) -> bool:
        """Return whether all are zero: one that surely is not decides."""
        values = list(np.ravel(values))
        return not any(abs(x) > self.high for x in values) and all(map(self.zero, values))

    def echelon(self, M: Any) -> tuple[Array, list[int]]:
        """Return the reduced rows of M and their pivot columns, by total search in each column."""
        M, pivots = array(M), []
        for j in range(M.shape[1]):
            top = len(pivots)
            best = max(range(top, len(M)), key=lambda i, j=j: abs(M[i, j]), default=None)
            if best is None or self.zero(M[best, j]):
                continue
            M[[top, best]] = M[[best, top]]
            M[top] = M[top] / M[top, j]
            for i in range(len(M)):
                if i != top and M[i, j]:
                    M[i] = M[i] - M[top] * M[i, j]
            pivots.append(j)
        return M[: len(pivots)], pivots

    def rank(self, M: Any) -> int:
        return len(self.echelon(M)[1])

    def general(self, M: Any, y: Any) -> tuple[Array | None, Array]:
        """Return one x with M x = y, ``None`` where there is none, and a basis of M x = 0 by rows."""
        n = M.shape[1]
        rows, pivots = self.echelon(np.hstack([M, y.reshape(len(M), *(y.shape[1:] or (1,)))]))
        held = [j for j in pivots if j < n]
        free = [j for j in range(n) if j not in held]
        null, x = eye(n)[free], zeros(n, rows.shape[1] - n)
        null[:, held] = -rows[: len(held), free].T
        x[held] = rows[: len(held), n:]
        return None if len(held) < len(pivots) else x.reshape(n, *y.shape[1:]), null

    def solve(self, M: Any, y: Any) -> Array | None:
        return self.general(M, y)[0]

    def null(self, M: Any) -> Array:
        return self.general(M, zeros(len(M)))[1]

    def inverse(self, M: Any) -> Array | None:
        """Return the inverse, or None of a singular matrix."""
        return self.solve(M, eye(len(M)))


class Reader(dict[str, Number]):
    """Evaluate entries by the grammar of ``data/README.md``, which is the one of Python here.

    Attributes
    ----------
    decimals : bool
        Whether a decimal other than 0 was read.
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        super().__init__(pi=+mp.pi, i=mp.mpc(0, 1), sqrt=mp.sqrt, exp=mp.exp,
                         root=lambda x, n: mp.root(x, int(n)))  # fmt: skip
        self.decimals = False
        for name, text in {**document.get("unknowns", {}), **document.get("constants", {})}.items():
            self[name] = self[text]

    def __missing__(self, text: str) -> Number:
        if (token := TOKEN.fullmatch(text)) is None:
            code = TOKEN.sub(lambda found: f"names[{found[0]!r}]", text)
            self[text] = eval(f"({code})", {"names": self, "__builtins__": {}})
        elif token[1] is None:
            raise KeyError(text)
        else:
            self[text] = mp.mpf(text)
            self.decimals = self.decimals or ("." in text and self[text] != 0)
        return self[text]

    def __call__(self, value: Any) -> Any:
        """Return the numbers of a list or a matrix."""
        return self[value] if isinstance(value, str) else array([self(x) for x in value])
