"""One colour's method prepared for the order conditions: eigenvectors of V to 1 and a solver.

Also the few vector operations the conditions are made of. Vectors are tuples; a zero that is
certain is written as the int 0 and costs nothing from then on.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.linalg import Matrix, Vector
from ..method import Component
from ..method.preconsistency import first_functional, preconsistency
from .coefficients import Rows, apply, is_zero, plus, sparse, times


class NotPreconsistent(Exception):
    """There is no u with V u = u and U u = 1; the text says why."""


@dataclass(frozen=True, eq=False)
class Block:
    """One colour's method, prepared: the eigenvectors of V to 1 and a solution of (I - V) x = R."""

    #: Nonzero entries by row.
    A: Rows
    U: Rows
    B: Rows
    stages: int  #: Number of stage values X.
    slopes: int  #: Number of F.
    u: Vector  #: (r,) with V u = u, U u = 1.
    #: Eigenvectors of V to the eigenvalue 1, the first is u when it is the only one.
    N: tuple[Vector, ...]
    W: Rows  #: Left eigenvectors, one row each, with W N = I where the eigenvalue is semisimple.
    output: Vector  #: (r,) functional with output u = 1 that reads off the solution.
    lift: Rows  #: (r, r), R -> the solution x of (I - V) x = R with output x = 0.
    semisimple: bool  #: Whether the eigenvalue 1 has as many eigenvectors as its multiplicity.
    certain: bool  #: Whether ranks were decided (False where balls only leave them possible).


def kernel(matrix: Matrix) -> tuple[list[Vector], bool]:
    """Nullspace, and whether its dimension is certain.

    Where balls leave the rank open, what may be zero is taken as zero: that is the only case in
    which the method can be preconsistent at all.
    """
    try:
        return linalg.nullspace(matrix), True
    except ExactnessError:
        pass
    rows, columns = [list(row) for row in matrix], len(matrix[0])
    pivots: list[int] = []
    while len(pivots) < len(rows):
        top = len(pivots)
        places = [
            (_lower(rows[i][j]), i, j)
            for i in range(top, len(rows))
            for j in range(columns)
            if j not in pivots and is_zero(rows[i][j]) is False
        ]
        if not places:
            break
        _, i, j = max(places)
        rows[top], rows[i] = rows[i], rows[top]
        lead = rows[top][j]
        rows[top] = [x / lead for x in rows[top]]
        for other in range(len(rows)):
            if other != top:
                factor = rows[other][j]
                rows[other] = [x - factor * y for x, y in zip(rows[other], rows[top], strict=True)]
        pivots.append(j)
    basis = []
    for free in (j for j in range(columns) if j not in pivots):
        vector: list[Scalar] = [Exact(int(j == free)) for j in range(columns)]
        for row, pivot in zip(rows, pivots, strict=False):
            vector[pivot] = -row[free]
        basis.append(tuple(vector))
    return basis, False


def as_scalar(x: Any) -> Scalar:
    """Turn an int or a Fraction into an exact number; pass every other number through."""
    return Exact(x) if isinstance(x, int | Fraction) else x


def equal(a: tuple[Any, ...], b: tuple[Any, ...]) -> bool:
    """Whether two vectors are certainly equal; stops at the first entry that differs."""
    return all(is_zero(plus(x, times(-1, y))) is True for x, y in zip(a, b, strict=True))


def tidy(vector: tuple[Any, ...]) -> tuple[Any, ...]:
    """Replace exact zeros by the int 0, which costs nothing from then on."""
    return tuple(0 if is_zero(x) is True else x for x in vector)


def present(vector: tuple[Any, ...]) -> bool:
    """Whether a tidy vector has an entry that is not an exact zero."""
    return any(not isinstance(x, int) or x != 0 for x in vector)


def _lower(x: Scalar) -> float:
    return x.magnitude() if isinstance(x, Exact) else x.lower_magnitude()


def principal_vectors(
    U: Matrix, B: Matrix, V: Matrix, output: Vector | None = None
) -> tuple[Vector, Matrix, Matrix, bool]:
    """Find u, the right and the left eigenvectors of V to 1, and whether ranks are certain.

    The vector u is that of :func:`glmref.method.preconsistency.preconsistency`.

    Raises
    ------
    NotPreconsistent
        With the reason.
    """
    difference = linalg.sub(V, linalg.identity(len(V)))
    right, certain = kernel(difference)
    left, same = kernel(linalg.transpose(difference))
    if not right or not left:
        raise NotPreconsistent("V has no eigenvalue 1")
    if len(right) == len(left) == 1:
        image = linalg.matvec(U, right[0])
        at = next((x for x in image if is_zero(x) is False), None)
        if at is None:
            raise NotPreconsistent("the eigenvector u of V to the eigenvalue 1 has U u = 0")
        _check_stages(U, tuple(x / at for x in right[0]))
    found = preconsistency(U, V, B, output)
    if found.u is None:
        raise NotPreconsistent("no eigenvector u of V to the eigenvalue 1 has U u = 1")
    if len(right) == len(left) == 1:
        return found.u, (found.u,), tuple(left), certain and same
    return found.u, tuple(right), tuple(left), certain and same and found.certain


def _check_stages(U: Matrix, u: Vector) -> None:
    for i, x in enumerate(linalg.matvec(U, u)):
        if is_zero(x - 1) is False:
            raise NotPreconsistent(
                f"row {i + 1} of U u is {_say(x)} instead of 1, u the eigenvector of V to 1"
            )


def _say(x: Scalar) -> str:
    value = complex(x)
    return f"{value.real:.6g}" if value.imag == 0 else f"{value:.6g}"


def make_block(A: Matrix, U: Matrix, B: Matrix, V: Matrix, output: Vector | None = None) -> Block:
    """Prepare one colour's method.

    Parameters
    ----------
    output : Vector or None
        Functional that reads the solution off the values, ``None`` for the first value that carries
        it: see :mod:`glmref.method.preconsistency`.

    Raises
    ------
    NotPreconsistent
        When there is no u with V u = u and U u = 1.
    ExactnessError
        When balls leave a rank open that matters.
    """
    u, N, W, certain = principal_vectors(U, B, V, output)
    pairing = linalg.matmul(W, linalg.transpose(N))
    semisimple = len(pairing) == len(pairing[0]) and not _singular(pairing)
    if semisimple:
        W = linalg.matmul(linalg.inverse(pairing), W)
    output = first_functional(u) if output is None else output
    return Block(
        A=sparse(A), U=sparse(U), B=sparse(B),
        stages=len(A), slopes=len(A[0]), u=u, N=N, W=sparse(W), output=output,
        lift=sparse(_lift(V, u, N, W, output)), semisimple=semisimple, certain=certain,
    )  # fmt: skip


def block_of(m: Component) -> Block:
    """Prepare a component: see :func:`make_block`."""
    return make_block(m.A, m.U, m.B, m.V, m.output)


def seen(block: Block, value: Sequence[Any]) -> Any:
    """Return the principal part of a vector: what the output functional sees of it."""
    return apply(sparse((block.output,)), value)[0]


def _singular(matrix: Matrix) -> bool:
    try:
        return linalg.rank(matrix) < len(matrix)
    except ExactnessError:
        return True


def _lift(V: Matrix, u: Vector, N: Matrix, W: Matrix, output: Vector) -> Matrix:
    """Matrix of R -> x with (I - V) x = R up to the part of R that W sees, and output x = 0.

    The bordered matrix ((I - V, Y), (Z, 0)) is invertible, Z picking the pivots of N and Y those of
    W: it holds one unknown more for each condition.
    """
    r, d = len(V), len(N)
    if len(W) != d:
        raise ExactnessError("the rank of V - I is not decided; give more digits or exact entries")
    rows = [
        (
            *(Exact(int(i == j)) - V[i][j] for j in range(r)),
            *(W[k][i].conjugate() for k in range(d)),
        )
        for i in range(r)
    ]
    rows += [(*(x.conjugate() for x in N[k]), *([Exact(0)] * d)) for k in range(d)]
    full = linalg.inverse(tuple(rows))
    solve = tuple(row[:r] for row in full[:r])
    shadow = linalg.vecmat(output, solve)
    return tuple(
        tuple(x - u[i] * y for x, y in zip(row, shadow, strict=True)) for i, row in enumerate(solve)
    )
