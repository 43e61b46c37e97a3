"""Pre-consistency, consistency, abscissae and zero-stability of a general linear method.

``V u = u, U u = 1`` (pre-consistency) lets the method reproduce constants, and
``B 1 + V v = u + v`` (consistency) the solution of y' = 1. Then ``c = A 1 + U v`` are the
abscissae.

Public names::

    preconsistency_residual(m, u) -> Matrix            (r + s, 1)
    consistency_residual(m, u, v) -> Matrix            (r, 1)
    preconsistency_vector(m) -> Vector | None
    consistency(m) -> Consistency                      u, v, c and what failed
    is_preconsistent(m), is_consistent(m) -> bool | None
    abscissae(m) -> Vector | None
    zero_stability(m) -> Boundedness                   is_zero_stable(m) -> bool | None
    halves(pair) -> (GLM-like q half, GLM-like p half) the two methods of a pair
    pair_consistency(pair) -> (Consistency, Consistency)
"""

from __future__ import annotations

from dataclasses import dataclass

from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector
from ..method import GLM, PartitionedGLM
from .affine import solve_affine, verdict_of
from .spectrum import Boundedness, power_bounded

__all__ = [
    "Blocks",
    "Consistency",
    "abscissae",
    "consistency",
    "consistency_residual",
    "halves",
    "is_consistent",
    "is_preconsistent",
    "is_zero_stable",
    "pair_consistency",
    "preconsistency_residual",
    "preconsistency_vector",
    "zero_stability",
]

_ZERO, _ONE = Exact(0), Exact(1)


@dataclass(frozen=True, eq=False)
class Blocks:
    """One half of a pair seen as a method: A (n, m), U (n, r), B (r, m), V (r, r)."""

    A: Matrix
    U: Matrix
    B: Matrix
    V: Matrix


@dataclass(frozen=True, eq=False)
class Consistency:
    """Pre-consistency and consistency of a method.

    Attributes
    ----------
        preconsistent, consistent: the decisions; ``None`` where balls leave them open.
        u: (r,) with V u = u, U u = 1, or ``None``.
        v: (r,) with B 1 + V v = u + v, or ``None``. It is fixed up to multiples of u: the entry
            at the first place where u is not zero is taken as 0, so that where that u is 1 the
            carried value is the solution itself up to order 1.
        c: (s,) abscissae A 1 + U v, or ``None``.
        unique: whether u is the only solution (1 is then a simple eigenvalue where it matters).
        residual: largest entry of the conditions that fail or stay open, 0.0 when all hold.
        witness: one sentence naming the condition that fails, or ``""``.
    """

    preconsistent: bool | None
    consistent: bool | None
    u: Vector | None = None
    v: Vector | None = None
    c: Vector | None = None
    unique: bool = True
    residual: float = 0.0
    witness: str = ""


def _column(values: Vector) -> Matrix:
    return tuple((x,) for x in values)


def preconsistency_residual(m: GLM | Blocks, u: Vector) -> Matrix:
    """``V u - u`` over ``U u - 1``, shape (r + s, 1)."""
    first = [x - y for x, y in zip(linalg.matvec(m.V, u), u, strict=True)]
    return _column((*first, *(x - 1 for x in linalg.matvec(m.U, u))))


def consistency_residual(m: GLM | Blocks, u: Vector, v: Vector) -> Matrix:
    """``B 1 + V v - u - v``, shape (r, 1)."""
    total = linalg.matvec(m.B, (_ONE,) * len(m.B[0]))
    image = linalg.matvec(m.V, v)
    return _column(tuple(b + x - y - z for b, x, y, z in zip(total, image, u, v, strict=True)))


def _find_u(m: GLM | Blocks) -> tuple[Vector | None, bool, str]:
    """Solve V u = u, U u = 1: the vector, whether it is the only one, what failed."""
    r = len(m.V)
    rows = (*linalg.sub(m.V, linalg.identity(r)), *m.U)
    solution = solve_affine(rows, (_ZERO,) * r + (_ONE,) * len(m.U))
    if solution.failed is None:
        return solution.point, not solution.directions, ""
    k = solution.failed
    name = f"row {k + 1} of V u = u" if k < r else f"row {k - r + 1} of U u = 1"
    return None, True, f"no vector u has V u = u and U u = 1: {name} contradicts the others"


def _find_v(m: GLM | Blocks, u: Vector) -> tuple[Vector | None, str]:
    r = len(m.V)
    anchor = next((i for i, x in enumerate(u) if x.is_zero() is False), 0)
    rows = linalg.sub(linalg.identity(r), m.V)
    total = linalg.matvec(m.B, (_ONE,) * len(m.B[0]))
    right = tuple(b - x for b, x in zip(total, u, strict=True))
    pin = tuple(_ONE if j == anchor else _ZERO for j in range(r))
    solution = solve_affine((*rows, pin), (*right, _ZERO))
    if solution.failed is None:
        return solution.point, ""
    return None, (
        "no vector v has B 1 + V v = u + v: the weights along the eigenvalue 1 of V do not sum to 1"
    )


def consistency(m: GLM | Blocks) -> Consistency:
    """Find u, v and c, and say which condition fails.

    Args:
        m: a method, or one half of a pair (:func:`halves`).

    References: Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), Definitions
    510B and 510C.
    """
    u, unique, witness = _find_u(m)
    if u is None:
        size = linalg.largest(preconsistency_residual(m, _first_guess(m)))
        return Consistency(False, False, residual=size, witness=witness)
    first = verdict_of(preconsistency_residual(m, u))
    v, witness = _find_v(m, u)
    if v is None:
        zero = (_ZERO,) * len(u)
        size = linalg.largest(consistency_residual(m, u, zero))
        return Consistency(first.holds, False, u, unique=unique, residual=size, witness=witness)
    second = verdict_of(consistency_residual(m, u, v))
    ones = (_ONE,) * len(m.A[0])
    c = tuple(x + y for x, y in zip(linalg.matvec(m.A, ones), linalg.matvec(m.U, v), strict=True))
    both = False if False in (first.holds, second.holds) else second.holds if first.holds else None
    residual = max(first.residual, second.residual)
    return Consistency(first.holds, both, u, v, c, unique, residual)


def _first_guess(m: GLM | Blocks) -> Vector:
    """The vector (1, 0, .., 0), for the size of a residual where no u exists."""
    return tuple(_ONE if j == 0 else _ZERO for j in range(len(m.V)))


def preconsistency_vector(m: GLM | Blocks) -> Vector | None:
    """Return u with V u = u and U u = 1, or ``None`` where there is none."""
    return _find_u(m)[0]


def is_preconsistent(m: GLM | Blocks) -> bool | None:
    """Whether constants are reproduced; ``None`` where balls leave it open."""
    return consistency(m).preconsistent


def is_consistent(m: GLM | Blocks) -> bool | None:
    """Whether y' = 1 is solved exactly; ``None`` where balls leave it open."""
    return consistency(m).consistent


def abscissae(m: GLM | Blocks) -> Vector | None:
    """Abscissae c = A 1 + U v, or ``None`` for a method that is not consistent."""
    return consistency(m).c


def zero_stability(m: GLM | Blocks) -> Boundedness:
    """Decide whether V is power-bounded.

    References: Butcher (2016), Definition 510A.
    """
    return power_bounded(m.V)


def is_zero_stable(m: GLM | Blocks) -> bool | None:
    """Whether V is power-bounded; ``None`` where balls leave it open."""
    return power_bounded(m.V).holds


def halves(pair: PartitionedGLM) -> tuple[Blocks, Blocks]:
    """Split a pair into the method for q (stages Q, driven by f at P) and the method for p."""
    q = Blocks(pair.A, pair.U, pair.B, pair.V)
    return q, Blocks(pair.A_hat, pair.U_hat, pair.B_hat, pair.V_hat)


def pair_consistency(pair: PartitionedGLM) -> tuple[Consistency, Consistency]:
    """Consistency of both halves. The abscissae of q are those of the stages Q, of p those of P."""
    q, p = halves(pair)
    return consistency(q), consistency(p)


def principal_left_vector(V: Matrix, u: Vector) -> Vector | None:
    """Return w with w V = w and w u = 1 where 1 is a simple eigenvalue, else ``None``."""
    shifted = linalg.sub(V, linalg.identity(len(V)))
    left = linalg.nullspace(linalg.transpose(shifted))
    if len(left) != 1:
        return None
    product: Scalar = linalg.dot(left[0], u)
    return None if product.is_zero() is not False else tuple(x / product for x in left[0])
