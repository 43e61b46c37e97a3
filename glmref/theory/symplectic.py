"""G-symplecticity: forms that a method conserves, checked when given and found when not.

A method is G-symplectic with a Hermitian G and a real diagonal D if

    G = V^* G V        D U = B^* G V        D A + A^* D = B^* G B

(plain transposes for real methods). Then every quadratic invariant Q of y' = f(y) is carried
exactly by ``sum g_ij y_i^T Q y_j``. A partitioned method for q' = f(p), p' = k(q) carries
``sum G_ij q_i^T S p_j`` for every bilinear invariant ``q^T S p`` if there are G (r, r^) and real
diagonals D_P, D_Q with the same identities between its two components::

    V^* G V^ = G    D_P U^ = B^* G V^    D_Q U = B^^* G^* V    D_P A^ + A^* D_Q = B^* G B^

Where its stages are shared D_P = D_Q is asked as well; r = r^ = 1 is then the condition of
symplectic partitioned Runge-Kutta methods. A single method is the case without hats, where the
second and the third identity say the same. Given the method the identities are linear in G and the
diagonals, so all forms are found as a nullspace.

**What counts.** G = 0, or a form that ignores the principal solution, conserves nothing of
interest: ``holds`` asks for ``u^* G u^ != 0``, where ``V u = u, U u = 1``, and forms are scaled to
``u^* G u^ = 1``. That is enough. Multiplied by u the second identity gives ``d_i = b_i^* G u``, so
that D follows from G and, for a consistent method, ``sum d_i = u^* G u = 1``. And let K be the
kernel of G and suppose d_i = 0: V maps K into K and is an isometry of the quotient;
``b_i^* G V = 0`` then says that b_i lies in K, and the third identity that ``d_j a_ji = 0``. So the
stages with d_i = 0 and the values in K feed nothing back, and what is left is a method with
nonsingular G and D that carries the principal solution. ``nondegenerate`` says whether that is the
whole method. A method without u (not pre-consistent) is held to nonsingular G and D instead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..errors import ExactnessError, UsageError
from ..exact import Exact, Scalar, linalg
from ..exact.judging import consulted, inward, outward
from ..exact.linalg import Matrix, Vector
from ..method import Component, Method
from ..method.preconsistency import preconsistency_vector
from .forms import Form, FormSpace, choose_form, is_nondegenerate, solved, unit_matrices
from .judged import judged_parts
from .residuals import verdict_of

_ZERO, _ONE = Exact(0), Exact(1)


@dataclass(frozen=True, eq=False)
class GSymplecticity:
    """Whether a method is G-symplectic, and with which form."""

    holds: bool | None  #: The decision; ``None`` where balls leave it open.
    #: The form that was checked or found, scaled to ``u^* G u^ = 1`` when found. Of a single method
    #: there is one diagonal D, of a partitioned one there are D_P and D_Q.
    G: Matrix | None = None
    diagonals: tuple[Vector, ...] = ()
    #: Of the space of all forms, or ``None`` where a given form was checked.
    dimension: int | None = None
    #: Whether G is square and nonsingular and no entry of a diagonal is zero.
    nondegenerate: bool | None = None
    residual: float = 0.0  #: Largest entry of the identities, 0.0 when they hold exactly.
    witness: str = ""  #: One sentence naming the entry that decides, or ``""``.

    @property
    def D(self) -> Vector | None:
        """The diagonal of a single method, D_P of a partitioned one."""
        return self.diagonals[0] if self.diagonals else None

    @property
    def D_P(self) -> Vector | None:
        """The diagonal over the stages where f is evaluated."""
        return self.D

    @property
    def D_Q(self) -> Vector | None:
        """The diagonal over the stages where k is evaluated."""
        return self.diagonals[-1] if self.diagonals else None


def _ends(m: Method) -> tuple[Component, Component]:
    """Return the components between which the form is taken: f and k, or the only one twice."""
    if m.additive:
        raise UsageError("forms are looked for in single and partitioned methods only")
    return m.components[0], m.components[-1]


#: Names of what :func:`form_identities` returns, of one method and of a pair.
_OF_ONE = (
    *("G - G*", "the imaginary part of D"),
    *("G - V* G V", "D U - B* G V", "D A + A* D - B* G B"),
)
_OF_A_PAIR = (
    *("the imaginary part of D_P and D_Q", "G - V* G V^", "D_P U^ - B* G V^"),
    *("D_Q U - B^* G* V", "D_P A^ + A* D_Q - B* G B^", "D_P - D_Q"),
)


def form_identities(m: Method, G: Matrix, *diagonals: Sequence[Scalar]) -> list[tuple[str, Matrix]]:
    """Return what a form satisfies, left minus right, with names: D real, G Hermitian, and more.

    Of a partitioned method with shared stages D_P = D_Q comes last, instead of a Hermitian G.

    Parameters
    ----------
    G : Matrix
        (r, r^).
    diagonals : Sequence[Scalar]
        D, or D_P (n_P,) and D_Q (n_Q,).

    References: Butcher and Hewitt, Numer. Algorithms 51 (2009) 33; Khan (2018), Theorem 3.0.6, with
    conjugate transposes for complex methods. For r = 1, Sun, J. Comput. Math. 11 (1993) 365 and
    Hairer, Lubich and Wanner, "Geometric Numerical Integration" (2006), Theorem VI.4.6.
    """
    single = len({id(c) for c in _ends(m)}) == 1
    with consulted() as judge:
        x = judge.rules_symplectic.form_defects(judged_parts(m), *inward([G, diagonals]))
        found = [*x.real, *x.kept, *x.outside, *x.inside]
        matrices = outward([*x.alike, *found] if single else [*found, *x.alike])
    return list(zip(_OF_ONE if single else _OF_A_PAIR, matrices, strict=False))


def quadratic_value(G: Matrix, u: Vector, v: Vector | None = None) -> Scalar:
    """Return ``u^* G v`` (``u^* G u`` when v is left out)."""
    return linalg.dot([x.conjugate() for x in u], linalg.matvec(G, u if v is None else v))


def _principal_vectors(m: Method) -> tuple[Vector | None, Vector | None]:
    f, k = _ends(m)
    return preconsistency_vector(f), preconsistency_vector(k)


def _diagonals(m: Method, G: Matrix, u: Vector, u_hat: Vector) -> tuple[Vector, ...]:
    """Return the diagonals as they follow from G: the identities with U multiplied by u^ and u."""
    f, k = _ends(m)
    star = linalg.conjugate_transpose
    D_P = linalg.matvec(star(f.B), linalg.matvec(G, u_hat))
    return (D_P,) if f is k else (D_P, linalg.matvec(star(k.B), linalg.matvec(star(G), u)))


def _start_forms(m: Method, u: Vector | None, u_hat: Vector | None) -> list[Form]:
    """Return forms that span all; the diagonals follow from G where u is known, else are free."""
    f, k = _ends(m)
    found = unit_matrices(len(f.V), len(k.V), hermitian=f is k, is_real=m.is_real)
    if u is not None and u_hat is not None:
        return [
            Form(G, tuple(tuple(x.real for x in d) for d in _diagonals(m, G, u, u_hat)))
            for G in found
        ]
    nil: list[Vector] = [(_ZERO,) * len(c.U) for c in ((k,) if f is k else (k, f))]
    forms = [Form(G, tuple(nil)) for G in found]
    no_G = linalg.zeros(len(f.V), len(k.V))
    for which, d in enumerate(nil):
        for unit in linalg.identity(len(d)):
            forms.append(Form(no_G, tuple(unit if i == which else x for i, x in enumerate(nil))))
    return forms


def find_forms(m: Method) -> FormSpace:
    """Find every form with its diagonals with which the method is G-symplectic.

    Returns
    -------
    FormSpace
        A basis over the reals; where it has a form with ``u^* G u^ != 0``, the first one is scaled
        to 1 and the others to 0. Over balls in A, U, B it is the only candidate there can be, and
        its residual is for the caller to check.

    Raises
    ------
    ExactnessError
        When V holds balls.
    """
    if not all(isinstance(x, Exact) for c in _ends(m) for row in c.V for x in row):
        raise ExactnessError("V holds published decimals")
    u, u_hat = _principal_vectors(m)

    def identities(form: Form) -> list[tuple[str, Matrix]]:
        return form_identities(m, form.G, *form.D)

    def principal(form: Form) -> Scalar:
        return quadratic_value(form.G, u or (), u_hat).real

    has_u = u is not None and u_hat is not None
    return solved(_start_forms(m, u, u_hat), identities, principal if has_u else None)


def check_g_symplectic(m: Method, G: Matrix, *diagonals: Sequence[Scalar]) -> GSymplecticity:
    """Check a given form: real diagonals (of one method Hermitian G), and what it sees."""
    holds, size, witness = judge_identities(form_identities(m, G, *diagonals))
    form = Form(G, tuple(map(tuple, diagonals)))
    nondegenerate = is_nondegenerate(form)
    if holds is not False:
        u, u_hat = _principal_vectors(m)
        seen = nondegenerate
        if u is not None and u_hat is not None:
            zero = quadratic_value(G, u, u_hat).is_zero()
            seen = None if zero is None else not zero
        if seen is False:
            holds, witness = False, "the form ignores the solution"
        elif seen is None:
            holds = None
    return GSymplecticity(holds, G, form.D, None, nondegenerate, size, witness)


def judge_identities(residuals: Sequence[tuple[str, Matrix]]) -> tuple[bool | None, float, str]:
    """Return whether all residuals vanish, the largest entry, and the sentence that names it."""
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


def _given_form(m: Method) -> tuple[Matrix, tuple[Vector, ...]] | None:
    """Return the form that comes with the method.

    Diagonals follow from G where they are not given.
    """
    if m.G is None:
        return None
    known = tuple(d for d in m.diagonals if d is not None)
    if len(known) == len(m.diagonals):
        return m.G, known
    u, u_hat = _principal_vectors(m)
    if u is None or u_hat is None:
        return None
    found = _diagonals(m, m.G, u, u_hat)
    return m.G, tuple(d or e for d, e in zip(m.diagonals, found, strict=True))


def g_symplectic(m: Method) -> GSymplecticity:
    """Decide G-symplecticity: with the form the method carries if it does, else with any form.

    Parameters
    ----------
    m : Method
        A single or a partitioned method; its G and diagonals are checked where they are given.

    References: Butcher and Hewitt, Numer. Algorithms 51 (2009) 33; Khan (2018), Theorem 3.0.6.
    """
    given = _given_form(m)
    if given is not None:
        return check_g_symplectic(m, given[0], *given[1])
    try:
        space = find_forms(m)
    except ExactnessError as error:
        return GSymplecticity(None, witness=f"no form was looked for: {error}")
    dimension = len(space.forms)
    form = choose_form(space)
    has_u = None not in _principal_vectors(m)
    if form is None or (has_u and not space.principal):
        zeros = "D = 0" if len(m.components) == 1 else "D_P = 0, D_Q = 0"
        witness = space.witness or f"only G = 0, {zeros}"
        return GSymplecticity(False, None, (), dimension, False, space.residual, witness)
    return replace(check_g_symplectic(m, form.G, *form.D), dimension=dimension)
