"""G-symplecticity: forms that a method conserves, checked when given and found when not.

A method is G-symplectic with a Hermitian G and a real diagonal D if

    G = V^* G V        D U = B^* G V        D A + A^* D = B^* G B

(plain transposes for real methods). Then every quadratic invariant Q of y' = f(y) is carried
exactly by ``sum g_ij y_i^T Q y_j``. Given the method the identities are linear in (G, D), so all
forms are found as a nullspace.

**What counts.** G = 0, or a form that ignores the principal solution, conserves nothing of
interest: ``holds`` asks for ``u^* G u != 0``, where ``V u = u, U u = 1``, and forms are scaled to
``u^* G u = 1``. That is enough. Multiplied by u the second identity gives ``d_i = b_i^* G u``, so
that D follows from G and, for a consistent method, ``sum d_i = u^* G u = 1``. And let K be the
kernel of G and suppose d_i = 0: V maps K into K and is an isometry of the quotient;
``b_i^* G V = 0`` then says that b_i lies in K, and the third identity that ``d_j a_ji = 0``. So the
stages with d_i = 0 and the values in K feed nothing back, and what is left is a method with
nonsingular G and D that carries the principal solution. ``nondegenerate`` says whether that is the
whole method. A method without u (not pre-consistent) is held to nonsingular G and D instead.

For pairs see :mod:`glmref.theory.partitioned_symplectic`.

Public names::

    g_symplectic_residual(m, G, D) -> (Matrix, Matrix, Matrix)
    find_forms(m) -> FormSpace                  check_g_symplectic(m, G, D) -> GSymplecticity
    g_symplectic(m) -> GSymplecticity           is_g_symplectic(m) -> bool | None
    symplectic_residual(m) -> Matrix            is_symplectic(m) -> bool | None   (one-step methods)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import ExactnessError, UsageError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector
from ..method import GLM
from ..method.solution_value import preconsistency_vector
from .affine import verdict_of
from .forms import Form, FormSpace, choose_form, cut_down, invariant_matrices, is_nondegenerate

__all__ = [
    "GSymplecticity",
    "check_g_symplectic",
    "find_forms",
    "g_symplectic",
    "g_symplectic_residual",
    "is_g_symplectic",
    "is_symplectic",
    "symplectic_residual",
]

_ZERO, _ONE = Exact(0), Exact(1)
NAMES = ("G - V* G V", "D U - B* G V", "D A + A* D - B* G B")


@dataclass(frozen=True, eq=False)
class GSymplecticity:
    """Whether a method is G-symplectic, and with which form.

    Attributes
    ----------
        holds: the decision; ``None`` where balls leave it open.
        G, D: the form that was checked or found, scaled to ``u^* G u = 1`` when found.
        dimension: of the space of all forms, or ``None`` where a given form was checked.
        nondegenerate: whether G is nonsingular and no d_i is zero.
        residual: largest entry of the identities, 0.0 when they hold exactly.
        witness: one sentence naming the entry that decides, or ``""``.
    """

    holds: bool | None
    G: Matrix | None = None
    D: Vector | None = None
    dimension: int | None = None
    nondegenerate: bool | None = None
    residual: float = 0.0
    witness: str = ""


def g_symplectic_residual(m: GLM, G: Matrix, D: Sequence[Scalar]) -> tuple[Matrix, Matrix, Matrix]:
    """``G - V^* G V``, ``D U - B^* G V`` and ``D A + A^* D - B^* G B``: all zero for a form of m.

    Args:
        G: (r, r) Hermitian. D: (s,) real.

    Returns
    -------
        Matrices (r, r), (s, r) and (s, s).

    References: Butcher and Hewitt, Numer. Algorithms 51 (2009) 33; Khan (2018), Theorem 3.0.6, with
    conjugate transposes for complex methods.
    """
    V_star, B_star = linalg.conjugate_transpose(m.V), linalg.conjugate_transpose(m.B)
    G_V = linalg.matmul(G, m.V)
    first = linalg.sub(G, linalg.matmul(V_star, G_V))
    second = linalg.sub(rows_scaled(D, m.U), linalg.matmul(B_star, G_V))
    D_A = rows_scaled(D, m.A)
    third = linalg.sub(
        linalg.add(D_A, linalg.conjugate_transpose(D_A)), linalg.matmul(B_star, G, m.B)
    )
    return first, second, third


def rows_scaled(D: Sequence[Scalar], a: Matrix) -> Matrix:
    return tuple(
        tuple(x if x.is_zero() is True else d * x for x in row) for d, row in zip(D, a, strict=True)
    )


def quadratic_value(G: Matrix, u: Vector, v: Vector | None = None) -> Scalar:
    """``u^* G v`` (``u^* G u`` when v is left out)."""
    return linalg.dot([x.conjugate() for x in u], linalg.matvec(G, u if v is None else v))


def _start_forms(m: GLM, u: Vector | None) -> list[Form]:
    """Forms with V^* G V = G; D follows from G where u is known, else it is free."""
    found = invariant_matrices(m.V, m.V, hermitian=True)
    if u is None:
        zero_D: Vector = (_ZERO,) * m.s
        units = [tuple(_ONE if i == k else _ZERO for i in range(m.s)) for k in range(m.s)]
        zero_G = linalg.zeros(m.r, m.r)
        return [Form(G, (zero_D,)) for G in found] + [Form(zero_G, (d,)) for d in units]
    B_star = linalg.conjugate_transpose(m.B)
    return [
        Form(G, (tuple(x.real for x in linalg.matvec(B_star, linalg.matvec(G, u))),)) for G in found
    ]


def find_forms(m: GLM) -> FormSpace:
    """Find every (G, D) with which the method is G-symplectic.

    Args:
        m: a method; V must be exact.

    Returns
    -------
        A basis over the reals; where it has a form with ``u^* G u != 0``, the first one is scaled
        to 1 and the others to 0. Over balls in A, U, B it is the only candidate there can be, and
        its residual is for the caller to check.

    Raises
    ------
        ExactnessError: when V holds balls.
    """
    u = preconsistency_vector(m)

    def identities(form: Form) -> list[tuple[str, Matrix]]:
        found = g_symplectic_residual(m, form.G, form.D[0])
        upper = tuple(  # the third is Hermitian: its lower part says nothing new
            tuple(x if j >= i else _ZERO for j, x in enumerate(row))
            for i, row in enumerate(found[2])
        )
        return [(NAMES[1], found[1]), (NAMES[2], upper)]

    principal = None if u is None else lambda form: quadratic_value(form.G, u).real
    return cut_down(_start_forms(m, u), identities, principal)


def check_g_symplectic(m: GLM, G: Matrix, D: Sequence[Scalar]) -> GSymplecticity:
    """Check a given form: Hermitian G, real D, the three identities, and that it is not trivial."""
    residuals = [("G - G*", linalg.sub(G, linalg.conjugate_transpose(G)))]
    residuals += [("the imaginary part of D", (tuple(x.imag for x in D),))]
    residuals += list(zip(NAMES, g_symplectic_residual(m, G, D), strict=True))
    holds, size, witness = judge_identities(residuals)
    form = Form(G, (tuple(D),))
    nondegenerate = is_nondegenerate(form)
    if holds is not False:
        seen = _sees_solution(m, form, nondegenerate=nondegenerate)
        if seen is False:
            return GSymplecticity(
                False, G, tuple(D), None, nondegenerate, size, "the form ignores the solution"
            )
        holds = holds if seen else None
    return GSymplecticity(holds, G, tuple(D), None, nondegenerate, size, witness)


def judge_identities(residuals: Sequence[tuple[str, Matrix]]) -> tuple[bool | None, float, str]:
    """Whether all residual matrices vanish, the largest entry, and the sentence that names it."""
    holds: bool | None = True
    size, witness = 0.0, ""
    for name, matrix in residuals:
        verdict = verdict_of(matrix)
        if verdict.holds is False and verdict.entry is not None:
            row, column = verdict.entry
            if holds is not False or verdict.residual > size:
                size = verdict.residual
                witness = f"entry ({row + 1}, {column + 1}) of {name} is {size:.6g} in size"
            holds = False
        elif verdict.holds is None and holds is not False:
            holds, size = None, max(size, verdict.residual)
            witness = f"the identities hold up to {size:.3g}, the width of the published digits"
    return holds, size, witness


def _sees_solution(m: GLM, form: Form, *, nondegenerate: bool | None) -> bool | None:
    u = preconsistency_vector(m)
    if u is None:
        return nondegenerate
    zero = quadratic_value(form.G, u).is_zero()
    return None if zero is None else not zero


def _given_form(m: GLM) -> tuple[Matrix, Vector] | None:
    """The form that comes with the method; D follows from G where only G is given."""
    if m.G is None:
        return None
    if m.D is not None:
        return m.G, m.D
    u = preconsistency_vector(m)
    if u is None:
        return None
    return m.G, linalg.matvec(linalg.conjugate_transpose(m.B), linalg.matvec(m.G, u))


def g_symplectic(m: GLM) -> GSymplecticity:
    """Decide G-symplecticity: with the form the method carries if it does, else with any form.

    Args:
        m: a method; ``m.G`` and ``m.D`` are checked where they are given.

    References: Butcher and Hewitt, Numer. Algorithms 51 (2009) 33; Khan (2018), Theorem 3.0.6.
    """
    given = _given_form(m)
    if given is not None:
        return check_g_symplectic(m, *given)
    try:
        space = find_forms(m)
    except ExactnessError as error:
        return GSymplecticity(None, witness=f"no form was looked for: {error}")
    dimension = len(space.forms)
    form = choose_form(space)
    has_u = preconsistency_vector(m) is not None
    if form is None or (has_u and not space.principal):
        return GSymplecticity(
            False,
            None,
            None,
            dimension,
            False,
            space.residual,
            space.witness or "only G = 0, D = 0",
        )
    checked = check_g_symplectic(m, form.G, form.D[0])
    return GSymplecticity(
        checked.holds,
        form.G,
        form.D[0],
        dimension,
        checked.nondegenerate,
        checked.residual,
        checked.witness,
    )


def is_g_symplectic(m: GLM) -> bool | None:
    """Whether the method is G-symplectic; ``None`` where balls leave it open."""
    return g_symplectic(m).holds


def symplectic_residual(m: GLM) -> Matrix:
    """``b_i a_ij + b_j a_ji - b_i b_j`` of a one-step method, (s, s): zero if it is symplectic.

    Raises
    ------
        UsageError: for a method that carries more than one value.

    References: Sanz-Serna, BIT 28 (1988) 877; Lasagni (1988); Suris (1988).
    """
    if m.r != 1:
        raise UsageError(f"`symplectic` is for one-step methods, and this one carries {m.r} values")
    return g_symplectic_residual(m, ((_ONE,),), m.B[0])[2]


def is_symplectic(m: GLM) -> bool | None:
    """Whether a one-step method is symplectic; ``None`` where balls leave it open."""
    return verdict_of(symplectic_residual(m)).holds
