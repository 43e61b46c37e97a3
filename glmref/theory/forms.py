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
from ..exact.linalg import Matrix, Vector
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


#: The identities of a form: pairs of a name and a residual matrix.
Identities = Callable[[Form], Sequence[tuple[str, Matrix]]]


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


def invariant_matrices(V: Matrix, W: Matrix, *, hermitian: bool) -> list[Matrix]:
    """Return a basis, over the reals, of the matrices with ``V^* G W = G`` (or Hermitian ones).

    For real V and W only real G are taken: an imaginary part says nothing about real solutions.

    Parameters
    ----------
    V : Matrix
        (r, r).
    W : Matrix
        (q, q), equal to V where Hermitian G are requested.

    Raises
    ------
    ExactnessError
        When balls leave the dimension open.
    """
    rows, columns = len(V), len(W)
    fits(rows * columns, rows * columns, "the form")
    is_real = all(x.is_real() for m in (V, W) for row in m for x in row)
    units = list(_unit_matrices(rows, columns, hermitian=hermitian, is_real=is_real))
    V_star = linalg.conjugate_transpose(V)
    defects = [linalg.sub(linalg.matmul(V_star, G, W), G) for G in units]
    equations: list[Vector] = []
    for i, j in product(range(rows), range(columns)):
        if hermitian and j < i:
            continue
        entries = [defect[i][j] for defect in defects]
        equations.append(tuple(x.real for x in entries))
        if not is_real:
            equations.append(tuple(x.imag for x in entries))
    equations = [e for e in equations if any(x.is_zero() is not True for x in e)]
    if not equations:
        return units
    basis = linalg.nullspace(tuple(equations))
    return [_weighted_sum(weights, units) for weights in basis]


def _weighted_sum(weights: Vector, matrices: list[Matrix]) -> Matrix:
    total = linalg.zeros(len(matrices[0]), len(matrices[0][0]))
    for t, m in zip(weights, matrices, strict=True):
        if t.is_zero() is not True:
            total = linalg.add(total, linalg.scale(t, m))
    return total


def _unit_matrices(rows: int, columns: int, *, hermitian: bool, is_real: bool) -> Iterator[Matrix]:
    i = Exact(-1).sqrt()
    factors = (_ONE,) if is_real else (_ONE, i)
    for a, b in product(range(rows), range(columns)):
        if hermitian and (b < a):
            continue
        for factor in factors:
            spend()
            if hermitian and a == b and factor is i:
                continue
            other = factor.conjugate()
            yield tuple(
                tuple(
                    factor
                    if (k, m) == (a, b)
                    else other
                    if hermitian and (m, k) == (a, b)
                    else _ZERO
                    for m in range(columns)
                )
                for k in range(rows)
            )


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


def _subtract(a: Vector, factor: Scalar, b: Vector) -> Vector:
    return tuple(x - factor * y for x, y in zip(a, b, strict=True))


def cut_down(
    forms: list[Form], identities: Identities, principal: Callable[[Form], Scalar] | None
) -> FormSpace:
    """Keep the combinations of forms for which all identities hold.

    Parameters
    ----------
    forms : list[Form]
        Spanning forms, linearly independent.
    identities : Identities
        Residual matrices, linear in the form.
    principal : Callable[[Form], Scalar] or None
        Value of a form on the principal solution (linear, real), or ``None``.

    Over balls an entry that may be zero is not used: the caller checks the residual of the result.
    """
    if not forms:
        return FormSpace((), False, 0.0, "no form G other than 0 has V^* G V = G")
    values = [principal(f) for f in forms] if principal else [_ZERO] * len(forms)
    basis: list[Vector] = [
        tuple(_ONE if a == b else _ZERO for b in range(len(forms))) for a in range(len(forms))
    ]
    basis = _principal_first(basis, values)
    sees = principal is not None and _sees(basis[0], values)
    residual, witness = 0.0, "" if sees or principal is None else "no form sees the solution"
    for label, row in _real_rows([identities(f) for f in forms]):
        hits = [linalg.dot(row, b) for b in basis]
        at = max((k for k, x in enumerate(hits) if x.is_zero() is False), default=None)
        if at is None:
            continue
        if sees and at == 0:  # every other form passes this entry and the principal one does not
            residual = hits[0].magnitude()
            witness = (
                f"{label} is {residual:.6g} in size for the only form G left, 1 on the solution"
                if len(basis) == 1
                else f"{label} leaves no form G with a principal part"
            )
            sees = False
        pivot = basis[at]
        basis = [
            b if h.is_zero() is True else _subtract(b, h / hits[at], pivot)
            for k, (b, h) in enumerate(zip(basis, hits, strict=True))
            if k != at
        ]
        if not basis:
            break
    return FormSpace(tuple(combine(b, forms) for b in basis), sees, residual, witness)


def _sees(weights: Vector, values: Sequence[Scalar]) -> bool:
    return linalg.dot(weights, values).is_zero() is False


def _principal_first(basis: list[Vector], values: Sequence[Scalar]) -> list[Vector]:
    """Put a form of principal value 1 first and take that value out of the others."""
    at = next((k for k, x in enumerate(values) if x.is_zero() is False), None)
    if at is None:
        return basis
    first = tuple(x / values[at] for x in basis[at])
    rest = [
        _subtract(b, x, first) if x.is_zero() is not True else b
        for k, (b, x) in enumerate(zip(basis, values, strict=True))
        if k != at
    ]
    return [first, *rest]


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
