"""What the rules of the kernel compute with: matrices, polynomials and permutations, decided.

Each function says what it proves. Over exact numbers everything here is decided; over balls the
answer ``None`` says that they leave it open.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..errors import ExactnessError
from ..exact import Exact, Scalar, linalg
from ..exact.expression import shown_number
from ..exact.linalg import Matrix, Vector
from ..method.stage_order import dependency_blocks
from ..theory import polynomials as poly
from ..theory.root_location import is_nonnegative, is_schur, real_roots
from ..theory.spectrum import power_bounded
from ..theory.stability import schur_cohn
from .ranges import Known

_ZERO, _ONE = Exact(0), Exact(1)


def all_of(answers: Sequence[bool | None]) -> bool | None:
    """Return conjunction in three values."""
    return False if False in answers else None if None in answers else True


def compared(
    found: Sequence[Scalar], declared: Sequence[Scalar], *, exact: bool, offset: int = 0
) -> Known:
    """Compare entry by entry: the first nonzero difference decides, or else one that is open."""
    differences = [x - y for x, y in zip(found, declared, strict=True)]
    answers = [d.is_zero() for d in differences]
    truth = all_of(answers)
    if truth is True:
        return Known(True, exact)
    at = answers.index(truth)
    size = max(d.magnitude() for d, a in zip(differences, answers, strict=True) if a is not True)
    exact = exact and all(isinstance(d, Exact) for d in differences)
    return Known(truth, exact, shown_number(found[at]), size, offset + at)


def vanishes(matrix: Sequence[Sequence[Scalar]]) -> bool | None:
    """Return whether all entries are 0: ``False`` where one excludes it, ``None`` if open."""
    return all_of([x.is_zero() for row in matrix for x in row])


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


def inside_circle(p: Any) -> bool | None:
    """Return whether all roots lie inside the circle; ``None`` where balls leave it open.

    ``False`` says that one lies outside the closed disc.

    Schur-Cohn: as long as |p_n| > |p_0| the step p -> (conj(p_n) p - p_0 p~) / x keeps the number
    of roots outside; |p_n| < |p_0| says that one is outside (Marden 1966, section 42).
    """
    p = tuple(p)
    try:
        while len(p) > 1:
            low, high = p[0], p[-1]
            if low.is_zero() is True:
                p = p[1:]
                continue
            sign = (high * high.conjugate() - low * low.conjugate()).real.sign()
            if sign < 0:
                return False  # the product of the roots is above 1: one lies outside
            if sign == 0:
                return None  # they may all lie on the circle
            mirrored = tuple(x.conjugate() for x in reversed(p))
            p = tuple(high.conjugate() * x - low * y for x, y in zip(p, mirrored, strict=True))[1:]
    except ExactnessError:
        return None
    return True


def bounded(V: Matrix) -> bool | None:
    """Return whether the powers of a matrix are bounded.

    Exact: see :func:`.spectrum.power_bounded`. Balls: V is block triangular in some order of its
    values, where exact zeros say so. The powers of V are bounded if every diagonal block has all
    eigenvalues inside the circle but at most one, which is exact and has bounded powers (the others
    have no eigenvalue in common with it on the circle, so V is similar to the direct sum); they are
    not if those of a block are not.
    """
    if is_exact(V):
        return power_bounded(V).holds
    answers: list[bool | None] = []
    on_circle = 0
    for block in diagonal_blocks(V):
        if is_exact(block):
            answer: bool | None = power_bounded(block).holds
            on_circle += not is_schur(poly.characteristic_polynomial(block))
        else:
            answer = inside_circle(poly.characteristic_polynomial(block))
        answers.append(answer)
    truth = all_of(answers)
    return None if truth is True and on_circle > 1 else truth


def diagonal_blocks(V: Matrix) -> list[Matrix]:
    """Return the diagonal blocks, values sorted so that V is block triangular by exact zeros."""
    return [tuple(tuple(V[a][b] for b in group) for a in group) for group in diagonal_values(V)]


def diagonal_values(V: Matrix) -> list[list[int]]:
    """Return the values that belong to each diagonal block."""
    blocks = dependency_blocks(len(V), lambda i, j: V[i][j].is_zero() is not True)
    return [list(block.stages) for block in blocks]


def full_rank(rows: Matrix, r: int) -> bool | None:
    """Return whether the rows span everything; ``None`` where balls leave it open."""
    full = len(linalg.independent_rows(rows, r)) == r
    return True if full else False if is_exact(rows) else None


def multiple_on_axis(P: Sequence[Any]) -> bool:
    """Return whether P(w, y) may have a multiple root w for some real y other than 0.

    The resultant of P and its derivative by w is a polynomial in y, of degree at most (2 r - 1) d;
    it is interpolated, and its squared modulus has a real zero where P has a multiple root.
    """
    r = len(P) - 1
    degree = (2 * r - 1) * max(len(p) - 1 for p in P)
    points = list(range(1, degree + 2))
    values = []
    for y in points:
        p = [poly.evaluate(c, y) for c in P]
        dp = [k * x for k, x in enumerate(p)][1:]
        rows = [(*((_ZERO,) * i), *p, *((_ZERO,) * (r - 2 - i))) for i in range(r - 1)]
        rows += [(*((_ZERO,) * i), *dp, *((_ZERO,) * (r - 1 - i))) for i in range(r)]
        values.append(poly.characteristic_polynomial(tuple(rows))[0])
    resultant = poly.trim(poly.interpolate(points, values))
    if not resultant:
        return True
    square = poly.mul(resultant, tuple(x.conjugate() for x in resultant))
    square = poly.trim(tuple(x.real for x in square))
    lowest = next(k for k, x in enumerate(square) if not x.is_zero())
    return real_roots(square[lowest:]) > 0


def escape(p: Any, where: str) -> str:
    """Return a sentence with the largest modulus of a root."""
    size = max((abs(x) for x in poly.approximate_roots(p)), default=float("inf"))
    return f"M(z) has an eigenvalue of modulus {size:.10g} {where}"


def in_right_half(p: Any) -> bool:
    """Return whether all zeros have Re z > 0: z = (x + 1)/(x - 1) takes that to |x| > 1."""
    p = poly.trim(p)
    if poly.evaluate(p, -1).is_zero() is not False:
        return False  # x = 0, which reversal below would lose
    return is_schur(poly.compose_moebius(p, 1, 1, 1, -1)[::-1])


def leaves_disc(q: Sequence[Any]) -> tuple[str | None, bool]:
    """Return why some root w of q(w, y) leaves the closed disc for some real y, or ``None``.

    The second answer says whether for y other than 0 the roots of modulus 1 are simple.

    Schur-Cohn with polynomials in y: the differences |q_n|^2 - |q_0|^2 must nowhere be negative
    (where one is, nearby y have the former ones positive). Where one vanishes identically, q must
    be its own mirror image, and its derivative by w takes its place (Cohn). Roots of modulus 1 are
    simple for y where all differences are positive and none vanishes but in degree 1.
    """
    strict = True
    for difference in schur_cohn(tuple(q)):
        if difference is None:
            return (
                "the eigenvalues of M(iy) are not mirrored in the unit circle and leave it",
                False,
            )
        if not difference:
            strict = False
            continue
        if not is_nonnegative(difference):
            return "for some y an eigenvalue of M(iy) lies outside the unit circle", False
        lowest = next(k for k, x in enumerate(difference) if not x.is_zero())
        strict = strict and real_roots(difference[lowest:]) == 0
    return None, strict
