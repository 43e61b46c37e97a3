"""Spaces of quadratic forms cut down by linear identities: the machinery behind G-symplecticity.

A form is G with its diagonals D. A space of forms is a list of them, combined with real numbers.
Identities are matrices of residuals, linear in the form; entry by entry they cut the space down,
and the entry that takes away the last form that sees the principal solution is the witness.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector, solve_affine
from ..judge.rules_symplectic import unit_matrices as judged_units
from ..system.budget import fits, spend

_ZERO, _ONE = Exact(0), Exact(1)


@dataclass(frozen=True, eq=False)
class Form:
    """A bilinear form G with the diagonals that go with it: (D,) or (D_P, D_Q)."""

    G: Matrix
    D: tuple[Vector, ...]


@dataclass(frozen=True, eq=False)
class FormSpace:
    """All forms that satisfy the identities."""

    #: A basis over the real numbers. Where a form sees the principal solution the first one has the
    #: value 1 on it and the others 0.
    forms: tuple[Form, ...]
    principal: bool  #: Whether the first form has that value 1.
    residual: float = 0.0  #: Size of the entry named in ``witness``, for the last candidate.
    witness: str = ""  #: The entry that left no form with a principal part, or ``""``.


def combine(factors: Sequence[Scalar | int], forms: Sequence[Form]) -> Form:
    """Return linear combination of forms."""
    G = linalg.scale(factors[0], forms[0].G)
    D = [tuple(factors[0] * x for x in d) for d in forms[0].D]
    for t, form in zip(factors[1:], forms[1:], strict=True):
        G = linalg.add(G, linalg.scale(t, form.G))
        D = [
            tuple(x + t * y for x, y in zip(d, e, strict=True))
            for d, e in zip(D, form.D, strict=True)
        ]
    return Form(G, tuple(D))


def unit_matrices(rows: int, columns: int, *, hermitian: bool, is_real: bool) -> Iterator[Matrix]:
    """Yield a basis of the matrices over the reals, or of the Hermitian ones.

    For real methods only real ones are taken: an imaginary part says nothing about real solutions.

    Raises
    ------
    UndecidedError
        When they are more than are written down.
    """
    fits(rows * columns, rows * columns, "the form")
    for (a, b), (c, d) in judged_units(rows, columns, hermitian):
        for factor in (_ONE,) if is_real or (hermitian and a == b) else (_ONE, Exact(-1).sqrt()):
            spend()
            found = [[_ZERO] * columns for _ in range(rows)]
            found[a][b] = factor
            if hermitian:
                found[c][d] = factor.conjugate()
            yield tuple(map(tuple, found))


def _real_rows(identities: list[Sequence[tuple[str, Matrix]]]) -> Iterator[tuple[str, Vector]]:
    """Yield each entry of each identity as a row over the forms, with its name.

    Complex entries give two rows.
    """
    for which, (name, first) in enumerate(identities[0]):
        for i, row in enumerate(first):
            for j in range(len(row)):
                values = [found[which][1][i][j] for found in identities]
                label = f"entry ({i + 1}, {j + 1}) of {name}"
                yield label, tuple(x.real for x in values)
                if not all(x.is_real() for x in values):
                    yield label, tuple(x.imag for x in values)


def solved(
    forms: Sequence[Form],
    identities: Callable[[Form], Sequence[tuple[str, Matrix]]],
    principal: Callable[[Form], Scalar] | None,
) -> FormSpace:
    """Return all combinations of forms for which all identities hold.

    Parameters
    ----------
    forms : sequence of Form
        Spanning forms, linearly independent.
    identities : callable
        Names and residual matrices, linear in the form.
    principal : callable or None
        Value of a form on the principal solution (linear, real), or ``None``.

    Over balls an entry that may be zero is not used: the caller checks the residual of the result.
    """
    labels, rows = zip(*_real_rows(list(map(identities, forms))), strict=True)
    fits(len(rows), len(forms), "the form")
    residual, witness = 0.0, ""
    if principal:
        rows, right = (tuple(map(principal, forms)), *rows), (_ONE, *(_ZERO,) * len(rows))
        found = solve_affine(rows, right)
        at = found.failed
        if at is None:
            whole = (found.point, *found.directions)
            return FormSpace(tuple(combine(x, forms) for x in whole), True)
        witness = "no form sees the solution"
        if at:
            before = solve_affine(rows[:at], right[:at])
            residual = linalg.dot(rows[at], before.point).magnitude()
            witness = (
                f"{labels[at - 1]} leaves no form G with a principal part"
                if before.directions
                else f"{labels[at - 1]} is {residual:.6g} in size for the only form G left, 1 on "
                "the solution"
            )
    free = solve_affine(rows[bool(principal) :], (_ZERO,) * len(labels)).directions
    return FormSpace(tuple(combine(x, forms) for x in free), False, residual, witness)


def is_nondegenerate(form: Form) -> bool | None:
    """Return whether G is square and nonsingular and no diagonal has a zero.

    The result is ``None`` if balls hide it.
    """
    zeros = [x.is_zero() for d in form.D for x in d]
    if True in zeros or len(form.G) != len(form.G[0]):
        return False
    try:
        full = linalg.rank(form.G) == len(form.G)
    except ExactnessError:
        return None
    return False if not full else (None if None in zeros else True)


def choose_form(space: FormSpace) -> Form | None:
    """Pick the form to show: the one with principal value 1, nondegenerate if one is found nearby.

    The forms without principal part are added with the whole numbers 0, 1, -1, 2, ... as factors
    until G is nonsingular and no diagonal entry is zero; the first candidate is taken if none is.
    """
    if not space.forms:
        return None
    if not space.principal:
        return space.forms[0]
    first, rest = space.forms[0], space.forms[1:]
    if len(rest) > 3:  # too many directions to walk: the plain candidate, or the sum of all
        candidates: list[tuple[int, ...]] = [(0,) * len(rest), (1,) * len(rest)]
    else:
        candidates = sorted(
            product((0, 1, -1, 2, -2, 3), repeat=len(rest)), key=lambda t: sum(map(abs, t))
        )
    for factors in candidates:
        form = combine((1, *factors), (first, *rest)) if rest else first
        if is_nondegenerate(form) is not False:
            return form
    return first
