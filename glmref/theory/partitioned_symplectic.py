"""G-symplecticity of pairs: the bilinear form that the two halves conserve together.

For q' = f(p), p' = k(q) with stages P (where f is evaluated) and Q (where k is evaluated) a pair
conserves ``sum G_ij q_i^T S p_j`` for every bilinear invariant ``q^T S p`` if there are a matrix G
(r, r^) and real diagonals D_P, D_Q with

    V^* G V^ = G    D_P U^ = B^* G V^    D_Q U = B^^* G^* V    D_P A^ + A^* D_Q = B^* G B^

Where the stages are shared (systems that are not separable) D_P = D_Q is asked as well; r = r^ = 1
is then the condition of symplectic partitioned Runge-Kutta methods. ``holds`` asks for
``u^* G u^ != 0`` as for single methods, and forms are scaled to 1 there.

Public names::

    pair_symplectic_residual(pair, G, D_P, D_Q) -> tuple of four matrices
    find_pair_forms(pair) -> FormSpace
    check_pair_symplectic(pair, G, D_P, D_Q) -> PairSymplecticity
    pair_symplectic(pair) -> PairSymplecticity          is_pair_symplectic(pair) -> bool | None
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector
from ..method import PartitionedGLM
from ..method.solution_value import halves, preconsistency_vector
from .forms import Form, FormSpace, choose_form, cut_down, invariant_matrices, is_nondegenerate
from .symplectic import judge_identities, quadratic_value, rows_scaled

__all__ = [
    "PairSymplecticity",
    "check_pair_symplectic",
    "find_pair_forms",
    "is_pair_symplectic",
    "pair_symplectic",
    "pair_symplectic_residual",
]

_ZERO, _ONE = Exact(0), Exact(1)
NAMES = (
    "G - V* G V^",
    "D_P U^ - B* G V^",
    "D_Q U - B^* G* V",
    "D_P A^ + A* D_Q - B* G B^",
)


@dataclass(frozen=True, eq=False)
class PairSymplecticity:
    """Whether a pair is G-symplectic, and with which form.

    Attributes
    ----------
        holds: the decision; ``None`` where balls leave it open.
        G, D_P, D_Q: the form that was checked or found, scaled to ``u^* G u^ = 1`` when found.
        dimension: of the space of all forms, or ``None`` where a given form was checked.
        nondegenerate: whether G is square and nonsingular and no entry of a diagonal is zero.
        residual: largest entry of the identities, 0.0 when they hold exactly.
        witness: one sentence naming the entry that decides, or ``""``.
    """

    holds: bool | None
    G: Matrix | None = None
    D_P: Vector | None = None
    D_Q: Vector | None = None
    dimension: int | None = None
    nondegenerate: bool | None = None
    residual: float = 0.0
    witness: str = ""


def pair_symplectic_residual(
    pair: PartitionedGLM, G: Matrix, D_P: Sequence[Scalar], D_Q: Sequence[Scalar]
) -> tuple[Matrix, Matrix, Matrix, Matrix]:
    """``G - V^* G V^`` and the three identities of the module docstring, left minus right.

    Args:
        G: (r, r^). D_P: (n_P,). D_Q: (n_Q,).

    Returns
    -------
        Matrices (r, r^), (n_P, r^), (n_Q, r) and (n_P, n_Q).
    """
    star = linalg.conjugate_transpose
    B_star = star(pair.B)
    G_V_hat = linalg.matmul(G, pair.V_hat)
    mixed = linalg.add(
        rows_scaled(D_P, pair.A_hat), linalg.transpose(rows_scaled(D_Q, _conjugate(pair.A)))
    )
    return (
        linalg.sub(G, linalg.matmul(star(pair.V), G_V_hat)),
        linalg.sub(rows_scaled(D_P, pair.U_hat), linalg.matmul(B_star, G_V_hat)),
        linalg.sub(rows_scaled(D_Q, pair.U), linalg.matmul(star(pair.B_hat), star(G), pair.V)),
        linalg.sub(mixed, linalg.matmul(B_star, G, pair.B_hat)),
    )


def _conjugate(a: Matrix) -> Matrix:
    return tuple(tuple(x.conjugate() for x in row) for row in a)


def _principal_vectors(pair: PartitionedGLM) -> tuple[Vector | None, Vector | None]:
    q, p = halves(pair)
    return preconsistency_vector(q), preconsistency_vector(p)


def _diagonals(pair: PartitionedGLM, G: Matrix, u: Vector, u_hat: Vector) -> tuple[Vector, Vector]:
    """D_P and D_Q as they follow from G: the second and third identity multiplied by u^ and u."""
    star = linalg.conjugate_transpose
    return (
        linalg.matvec(star(pair.B), linalg.matvec(G, u_hat)),
        linalg.matvec(star(pair.B_hat), linalg.matvec(star(G), u)),
    )


def _real_parts(vectors: tuple[Vector, Vector]) -> tuple[Vector, Vector]:
    first, second = vectors
    return tuple(x.real for x in first), tuple(x.real for x in second)


def _start_forms(pair: PartitionedGLM, u: Vector | None, u_hat: Vector | None) -> list[Form]:
    found = invariant_matrices(pair.V, pair.V_hat, hermitian=False)
    n_p, n_q = pair.n_P, pair.n_Q
    if u is not None and u_hat is not None:
        return [Form(G, _real_parts(_diagonals(pair, G, u, u_hat))) for G in found]
    no_P, no_Q, no_G = (_ZERO,) * n_p, (_ZERO,) * n_q, linalg.zeros(pair.r, pair.r_hat)

    def units(n: int) -> list[Vector]:
        return [tuple(_ONE if i == k else _ZERO for i in range(n)) for k in range(n)]

    return (
        [Form(G, (no_P, no_Q)) for G in found]
        + [Form(no_G, (d, no_Q)) for d in units(n_p)]
        + [Form(no_G, (no_P, d)) for d in units(n_q)]
    )


def find_pair_forms(pair: PartitionedGLM) -> FormSpace:
    """Find every (G, D_P, D_Q) with which the pair is G-symplectic.

    Raises
    ------
        ExactnessError: when V or V^ holds balls.
    """
    u, u_hat = _principal_vectors(pair)

    def identities(form: Form) -> list[tuple[str, Matrix]]:
        found = pair_symplectic_residual(pair, form.G, *form.D)
        named = list(zip(NAMES, found, strict=True))[1:]
        return named + _shared_stages(pair, form.D[0], form.D[1])

    def principal(form: Form) -> Scalar:
        return quadratic_value(form.G, u or (), u_hat).real

    has_u = u is not None and u_hat is not None
    return cut_down(_start_forms(pair, u, u_hat), identities, principal if has_u else None)


def _shared_stages(
    pair: PartitionedGLM, D_P: Sequence[Scalar], D_Q: Sequence[Scalar]
) -> list[tuple[str, Matrix]]:
    """Ask for one diagonal where f and k are evaluated at the same stages."""
    if pair.separable:
        return []
    return [("D_P - D_Q", (tuple(x - y for x, y in zip(D_P, D_Q, strict=True)),))]


def check_pair_symplectic(
    pair: PartitionedGLM, G: Matrix, D_P: Sequence[Scalar], D_Q: Sequence[Scalar]
) -> PairSymplecticity:
    """Check a given form: real diagonals, the identities, and that it sees the solution."""
    residuals = [
        ("the imaginary part of D_P and D_Q", (tuple(x.imag for x in (*D_P, *D_Q)),)),
        *zip(NAMES, pair_symplectic_residual(pair, G, D_P, D_Q), strict=True),
        *_shared_stages(pair, D_P, D_Q),
    ]
    holds, size, witness = judge_identities(residuals)
    form = Form(G, (tuple(D_P), tuple(D_Q)))
    nondegenerate = is_nondegenerate(form)
    if holds is not False:
        u, u_hat = _principal_vectors(pair)
        if u is None or u_hat is None:
            seen = nondegenerate
        else:
            zero = quadratic_value(G, u, u_hat).is_zero()
            seen = None if zero is None else not zero
        if seen is False:
            holds, witness = False, "the form ignores the solution"
        holds = holds if seen else (False if seen is False else None)
    return PairSymplecticity(holds, G, form.D[0], form.D[1], None, nondegenerate, size, witness)


def _given_form(pair: PartitionedGLM) -> tuple[Matrix, Vector, Vector] | None:
    if pair.G is None:
        return None
    if pair.D_P is not None and pair.D_Q is not None:
        return pair.G, pair.D_P, pair.D_Q
    u, u_hat = _principal_vectors(pair)
    if u is None or u_hat is None:
        return None
    D_P, D_Q = _diagonals(pair, pair.G, u, u_hat)
    return pair.G, pair.D_P or D_P, pair.D_Q or D_Q


def pair_symplectic(pair: PartitionedGLM) -> PairSymplecticity:
    """Decide G-symplecticity of a pair: with its given form if it has one, else with any form.

    References: for r = 1, Sun, J. Comput. Math. 11 (1993) 365 and Hairer, Lubich and Wanner,
    "Geometric Numerical Integration" (2006), Theorem VI.4.6; for single methods, Butcher and
    Hewitt, Numer. Algorithms 51 (2009) 33: here the form is taken between the two halves.
    """
    given = _given_form(pair)
    if given is not None:
        return check_pair_symplectic(pair, *given)
    try:
        space = find_pair_forms(pair)
    except ExactnessError as error:
        return PairSymplecticity(None, witness=f"no form was looked for: {error}")
    dimension = len(space.forms)
    form = choose_form(space)
    has_u = None not in _principal_vectors(pair)
    if form is None or (has_u and not space.principal):
        witness = space.witness or "only G = 0, D_P = 0, D_Q = 0"
        return PairSymplecticity(False, None, None, None, dimension, False, space.residual, witness)
    checked = check_pair_symplectic(pair, form.G, *form.D)
    return PairSymplecticity(
        checked.holds,
        form.G,
        form.D[0],
        form.D[1],
        dimension,
        checked.nondegenerate,
        checked.residual,
        checked.witness,
    )


def is_pair_symplectic(pair: PartitionedGLM) -> bool | None:
    """Whether the pair is G-symplectic; ``None`` where balls leave it open."""
    return pair_symplectic(pair).holds
