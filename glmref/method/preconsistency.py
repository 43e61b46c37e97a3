"""Which of the carried values is the solution: u, v, the abscissae c and the output functional.

The step of a general linear method ``Y = h A f(Y) + U y, y+ = h B f(Y) + V y`` says nothing of what
the r values stand for. Four vectors do, and they are computed here and nowhere else:

* the *preconsistency vector* u with ``V u = u`` and ``U u = 1``: the values are ``u y + O(h)``;
* the *output functional* w with ``w u = 1``: the solution is ``w y`` (a row, one number for each
  value). A method says it by its field ``output``. One that says nothing means the first value
  with a nonzero entry of u, divided by that entry; for nearly every method in print that is the
  first value itself;
* the *consistency vector* v with ``B 1 + V v = u + v`` and ``w v = 0``: the values are
  ``u y + h v y' + O(h^2)`` where the solution ``w y`` stands at the time of the step;
* the *abscissae* ``c = A 1 + U v``: stage i stands for the solution at ``t + c_i h``.

All of them follow a change of values ``T y``: u becomes ``T u``, v ``T v``, w ``w T^-1``, and c
stays. Without a declared output that is true for c only where T leaves the solution where the rule
above finds it, which is why :meth:`glmref.method.GLM.transform` writes the output down.

Theory works with these numbers as they are, exact or enclosed; an engine rounds them once.

References
----------
Butcher, "Numerical Methods for Ordinary Differential Equations" (2016), Definitions 510B and 510C.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Protocol

from ..errors import DataError, ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector
from .component import Component

_ZERO, _ONE = Exact(0), Exact(1)
#: Methods whose vectors are kept: theory, engine and measurements ask for them again and again.
_KEPT = 256


class Block(Protocol):
    """What the functions below take: a component, or a method of one.

    A (n, m), U (n, r), B (r, m), V (r, r), and the declared output (r,) or ``None``.
    """

    @property
    def A(self) -> Matrix:
        """Stages from slopes."""
        ...

    @property
    def U(self) -> Matrix:
        """Stages from values."""
        ...

    @property
    def B(self) -> Matrix:
        """Values from slopes."""
        ...

    @property
    def V(self) -> Matrix:
        """Values from values."""
        ...

    @property
    def output(self) -> Vector | None:
        """Declared output functional, or ``None``."""
        ...


@dataclass(frozen=True, eq=False)
class Preconsistency:
    """Solution of ``V u = u, U u = 1``."""

    u: Vector | None  #: (r,), or ``None`` where there is none.
    unique: bool = True  #: Whether u is the only solution.
    certain: bool = True  #: Whether no ball around zero was left out of the decision.
    witness: str = ""  #: One sentence naming the row that contradicts the others, or ``""``.


# --- u --------------------------------------------------------------------------------------------


def preconsistency(
    U: Matrix, V: Matrix, B: Matrix | None = None, output: Vector | None = None
) -> Preconsistency:
    """Solve ``V u = u, U u = 1``.

    Where several vectors solve it (V has the eigenvalue 1 more than once and the stages do not tell
    the eigenvectors apart), the one taken has ``output u = 1`` where an output is declared, and
    makes the method consistent (``B 1 = u + (I - V) v`` for some v), each if it can.

    Parameters
    ----------
    U : (s, r) stages from values.
    V : (r, r) values from values.
    B : (r, s) values from slopes, or ``None`` to leave consistency out.
    output : (r,) functional that reads off the solution, or ``None``.
    """
    r = len(V)
    rows = (*linalg.sub(V, linalg.identity(r)), *U)
    right = (_ZERO,) * r + (_ONE,) * len(U)
    found = linalg.solve_affine(rows, right)
    if found.failed is not None:
        k = found.failed
        name = f"row {k + 1} of V u = u" if k < r else f"row {k - r + 1} of U u = 1"
        return Preconsistency(
            None, witness=f"no vector u has V u = u and U u = 1: {name} contradicts the others"
        )
    if not found.directions:
        return Preconsistency(found.point, True, not found.undecided)
    for more in _choices(V, B, output):
        wide = tuple((*row, *((_ZERO,) * (len(more[0][0]) - r))) for row in rows)
        again = linalg.solve_affine((*wide, *more[0]), (*right, *more[1]))
        if again.failed is None:
            return Preconsistency(again.point[:r], False, not again.undecided)
    return Preconsistency(found.point, False, not found.undecided)


def _choices(V: Matrix, B: Matrix | None, output: Vector | None) -> list[tuple[Matrix, Vector]]:
    """Return equations in (u, v) that choose among several u, the most demanding first."""
    r = len(V)
    nothing = (_ZERO,) * r
    reads: tuple[Vector, ...] = () if output is None else ((*output, *nothing),)
    choices: list[tuple[Matrix, Vector]] = []
    if B is not None:
        gap = linalg.sub(linalg.identity(r), V)
        unit = linalg.identity(r)
        # u + (I - V) v = B 1
        consistent = tuple((*e, *g) for e, g in zip(unit, gap, strict=True))
        total = linalg.matvec(B, (_ONE,) * len(B[0]))
        if reads:
            choices.append(((*consistent, *reads), (*total, _ONE)))
        choices.append((consistent, total))
    if reads:
        choices.append((reads, (_ONE,)))
    return choices


@lru_cache(maxsize=_KEPT)
def preconsistency_of(m: Block) -> Preconsistency:
    """Solve ``V u = u, U u = 1`` for a method or a component."""
    return preconsistency(m.U, m.V, m.B, m.output)


def preconsistency_vector(m: Block) -> Vector | None:
    """Return u with ``V u = u`` and ``U u = 1``, or ``None`` where there is none."""
    return preconsistency_of(m).u


# --- the solution among the values ----------------------------------------------------------------


def first_functional(u: Sequence[Scalar]) -> Vector:
    """Return the default functional: the first value that carries the solution.

    Raises
    ------
    ExactnessError
        Where balls leave open which entries of u are zero.
    """
    first = next((k for k, x in enumerate(u) if x.is_zero() is False), None)
    if first is None:
        raise ExactnessError("no entry of u is certainly not zero; give more digits")
    return tuple(1 / x if k == first else _ZERO for k, x in enumerate(u))


@lru_cache(maxsize=_KEPT)
def output(m: Block) -> Vector:
    """Return w, (r,): the solution is ``w y``, y the values after a step.

    A method that is not preconsistent carries no solution; without a declared output its first
    value is taken, so that it can be stepped and found wrong.

    Raises
    ------
    DataError
        Where the declared output does not give 1 on u: what it reads is not the solution.
    ExactnessError
        Where balls leave open which entries of u are zero.
    """
    u, declared = preconsistency_vector(m), m.output
    if declared is None:
        return first_functional(linalg.identity(len(m.V))[0] if u is None else u)
    if u is not None:
        value = linalg.dot(declared, u)
        if (value - 1).is_zero() is False:
            raise DataError(
                f"`output` must read the solution off the values, output u = 1 for the u with "
                f"V u = u and U u = 1, got {complex(value).real:.6g}; divide by it, or take "
                f"another functional where it is 0"
            )
    return declared


def outputs(components: Iterable[Component]) -> tuple[Vector, ...]:
    """Return the output functional of each component of a method."""
    return tuple(map(output, components))


def unit_place(w: Vector) -> int | None:
    """Return k (from 0) where the functional w is the unit vector e_k: that value is the solution.

    ``None`` where it combines values or scales one.
    """
    places = [k for k, x in enumerate(w) if x.is_zero() is not True]
    alone = len(places) == 1 and (w[places[0]] - 1).is_zero() is True
    return places[0] if alone else None


# --- v and c --------------------------------------------------------------------------------------


@lru_cache(maxsize=_KEPT)
def consistency_vector(m: Block) -> Vector | None:
    """Return v with ``B 1 + V v = u + v`` and ``w v = 0``, or ``None`` where there is none."""
    u = preconsistency_vector(m)
    if u is None:
        return None
    r = len(m.V)
    try:
        pin = output(m)
    except ExactnessError:
        pin = linalg.identity(r)[0]
    rows = linalg.sub(linalg.identity(r), m.V)
    total = linalg.matvec(m.B, (_ONE,) * len(m.B[0]))
    right = tuple(b - x for b, x in zip(total, u, strict=True))
    found = linalg.solve_affine((*rows, pin), (*right, _ZERO))
    return None if found.failed is not None else found.point


@lru_cache(maxsize=_KEPT)
def abscissae(m: Block) -> Vector | None:
    """Return c = A 1 + U v, (n,), or ``None`` for a method that is not consistent."""
    v = consistency_vector(m)
    if v is None:
        return None
    sums = linalg.matvec(m.A, (_ONE,) * len(m.A[0]))
    return tuple(x + y for x, y in zip(sums, linalg.matvec(m.U, v), strict=True))


def stage_times(m: Block) -> Vector:
    """Return the c at which an integrator evaluates f: A 1 for a method that is not consistent.

    Such a method (a deliberately broken one) has no times of its own and must still be stepped.
    Where a file gives c apart from A 1, it is that.
    """
    c = getattr(m, "abscissae_given", None) or abscissae(m)
    return linalg.matvec(m.A, (_ONE,) * len(m.A[0])) if c is None else c
