"""Vectors and blocks of matrices that finders use; over balls ``None`` says what is left open."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector

_ZERO, _ONE = Exact(0), Exact(1)


def all_of(answers: Sequence[bool | None]) -> bool | None:
    """Return conjunction in three values."""
    return False if False in answers else None if None in answers else True


def is_exact(*matrices: Sequence[Sequence[Any]]) -> bool:
    """Return whether no ball stands in the matrices."""
    return all(isinstance(x, Exact) for m in matrices for row in m for x in row)


def constants(U: Matrix, V: Matrix, output: Vector | None = None) -> list[Vector]:
    """Return a basis of the (u, x) with V u = u and U u = x 1, output u = x where one is given.

    Those with x = 1 are the preconsistency vectors; there is none where x is 0 in the whole basis.
    """
    D = linalg.sub(V, linalg.identity(len(V)))
    rows = [(*row, _ZERO) for row in D]
    rows += [(*row, Exact(-1)) for row in (*U, *(() if output is None else (output,)))]
    return linalg.nullspace(tuple(rows))


def consistent_values(
    U: Matrix, B: Matrix, V: Matrix, output: Vector | None = None
) -> list[Vector]:
    """Return a basis of the (u, v, x), (u, x) of :func:`constants`, x B 1 + V v = u + v."""
    r = len(V)
    D, nil = linalg.sub(V, linalg.identity(r)), (_ZERO,) * r
    total = linalg.matvec(B, (_ONE,) * len(B[0]))
    rows = [(*row, *nil, _ZERO) for row in D]
    rows += [(*row, *nil, Exact(-1)) for row in (*U, *(() if output is None else (output,)))]
    for i, row in enumerate(D):
        minus = tuple(Exact(-int(i == j)) for j in range(r))
        rows.append((*minus, *row, total[i]))
    return linalg.nullspace(tuple(rows))


def _with_one(basis: list[Vector]) -> Vector | None:
    """Return the first basis vector whose last entry is not 0, scaled by it and without it."""
    whole = next((x for x in basis if not x[-1].vanishes()), None)
    return None if whole is None else tuple(x / whole[-1] for x in whole[:-1])


def first_value(basis: list[Vector]) -> Vector | None:
    """Return the output of a method that declares none, the same for every u of :func:`constants`.

    It is the first value in which u is not 0, divided by u there; ``None`` where that value, or u
    there, is not the same for all u with x = 1.
    """
    r = len(basis[0]) - 1
    for k in range(r):
        if all(y[k].is_zero() for y in basis):
            continue
        u = _with_one(basis)
        if u is None or any((y[k] - u[k] * y[-1]).is_zero() is not True for y in basis):
            return None
        return tuple(1 / x if j == k else _ZERO for j, x in enumerate(u))
    return None
