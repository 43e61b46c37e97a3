"""Pre-consistency, consistency and abscissae of a general linear method.

``V u = u, U u = 1`` (pre-consistency) lets the method reproduce constants, and
``B 1 + V v = u + v`` (consistency) the solution of y' = 1. Then ``c = A 1 + U v`` are the
abscissae. The vectors themselves come from :mod:`glmref.method.preconsistency`, and the judge says
whether they exist; here it is said which condition fails.
"""

from __future__ import annotations

from dataclasses import dataclass

from ..exact import Exact, linalg
from ..exact.linalg import Matrix, Vector
from ..method.preconsistency import (
    Block,
    abscissae,
    consistency_vector,
    preconsistency_of,
)

_ZERO, _ONE = Exact(0), Exact(1)
_NO_V = "no vector v has B 1 + V v = u + v: the weights along the eigenvalue 1 of V do not sum to 1"


@dataclass(frozen=True, eq=False)
class Consistency:
    """The vectors of consistency of a component, as far as there are any."""

    u: Vector | None = None  #: (r,) with V u = u, U u = 1, or ``None``.
    #: (r,) with B 1 + V v = u + v, or ``None``. It is fixed up to multiples of u: the output
    #: functional w has w v = 0, so that the solution w y stands at the time of the step.
    v: Vector | None = None
    c: Vector | None = None  #: (s,) abscissae A 1 + U v, or ``None``.
    #: Largest entry of the conditions that fail or stay open, 0.0 when all hold.
    residual: float = 0.0
    witness: str = ""  #: One sentence naming the condition that fails, or ``""``.


def _column(values: Vector) -> Matrix:
    return tuple((x,) for x in values)


def preconsistency_residual(m: Block, u: Vector) -> Matrix:
    """Return ``V u - u`` over ``U u - 1``, shape (r + s, 1)."""
    first = [x - y for x, y in zip(linalg.matvec(m.V, u), u, strict=True)]
    return _column((*first, *(x - 1 for x in linalg.matvec(m.U, u))))


def consistency_residual(m: Block, u: Vector, v: Vector) -> Matrix:
    """Return ``B 1 + V v - u - v``, shape (r, 1)."""
    total = linalg.matvec(m.B, (_ONE,) * len(m.B[0]))
    image = linalg.matvec(m.V, v)
    return _column(tuple(b + x - y - z for b, x, y, z in zip(total, image, u, v, strict=True)))


def consistency(m: Block) -> Consistency:
    """Find u, v and c, and say which condition fails.

    References: Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), Definitions
    510B and 510C.
    """
    found = preconsistency_of(m)
    u, v = found.u, consistency_vector(m)
    if u is None:
        guess = linalg.identity(len(m.V))[0]  # for the size of a residual where no u exists
        size = linalg.largest(preconsistency_residual(m, guess))
        return Consistency(residual=size, witness=found.witness)
    if v is None:
        size = linalg.largest(consistency_residual(m, u, (_ZERO,) * len(u)))
        return Consistency(u, residual=size, witness=f"{_NO_V}; {_row_off(m, u)}")
    residuals = preconsistency_residual(m, u), consistency_residual(m, u, v)
    return Consistency(u, v, abscissae(m), max(map(linalg.largest, residuals)))


def _row_off(m: Block, u: Vector) -> str:
    """Say which row of ``B 1 + V v = u + v`` contradicts the others, and by how much."""
    rows = list(linalg.sub(linalg.identity(len(u)), m.V))
    total = linalg.matvec(m.B, (_ONE,) * len(m.B[0]))
    right = [b - x for b, x in zip(total, u, strict=True)]
    k = linalg.solve_affine(tuple(rows), tuple(right)).failed
    if k is None:
        return "the rows are not decided"
    row, value = rows.pop(k), right.pop(k)
    v = linalg.solve_affine(tuple(rows), tuple(right)).point if rows else (_ZERO,) * len(u)
    off = value - linalg.dot(row, v)
    where = " where the others hold" if rows else ""
    return f"row {k + 1} is off by {complex(off).real:.6g}{where}"
