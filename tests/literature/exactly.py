"""Small exact tools the literature tests share: identities, step maps, expansions.

Everything here is exact arithmetic on :mod:`glmref.exact.linalg` matrices. A polynomial identity of
degree at most d in each of k variables is proved by evaluating it on a grid of (d + 1)^k points.
"""

import random
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product

from glmref.exact import Scalar, exact, linalg
from glmref.exact.linalg import Matrix, Vector
from glmref.method import GLM, Entry, as_matrix, as_vector
from glmref.theory.order import order_of
from glmref.theory.series import Series
from glmref.theory.symplectic import g_symplectic
from glmref.theory.trees import Tree, trees_up_to


def matrix(rows: Sequence[Sequence[Entry]]) -> Matrix:
    """Matrix of printed entries."""
    return as_matrix(rows, "rows")


def printed(rows: str) -> Matrix:
    """Matrix of entries as they stand in print, a row in each line."""
    return matrix([row.split() for row in rows.strip().splitlines()])


def vector(values: Sequence[Entry]) -> Vector:
    """Vector of printed entries."""
    return as_vector(values, "values")


def vanishes(a: Matrix) -> bool:
    """Whether every entry is an exact zero."""
    return all(x.is_zero() is True for _, _, x in linalg.entries(a))


def same(a: Matrix, b: Matrix) -> bool:
    """Whether two matrices of one shape agree exactly."""
    return vanishes(linalg.sub(a, b))


def grid(variables: int, degree: int) -> Iterator[tuple[Fraction, ...]]:
    """Points that decide a polynomial identity of this degree in each variable."""
    return product((Fraction(k) for k in range(degree + 1)), repeat=variables)


def J(n: int) -> Matrix:
    """The structure matrix ``[[0, I], [-I, 0]]`` of n degrees of freedom, below (1.4)."""
    one, zero = linalg.identity(n), linalg.zeros(n, n)
    top = tuple(z + i for z, i in zip(zero, one, strict=True))
    return top + tuple(tuple(-x for x in i) + z for z, i in zip(zero, one, strict=True))


def symplectic_defect(jacobian: Matrix) -> Matrix:
    """``X^T J X - J``: zero exactly when the linear map X is symplectic."""
    form = J(len(jacobian) // 2)
    return linalg.sub(linalg.matmul(linalg.transpose(jacobian), form, jacobian), form)


def random_matrix(rows: int, columns: int, numbers: random.Random) -> Matrix:
    """Matrix of small nonzero fractions."""
    nonzero = [k for k in range(-9, 10) if k]
    return matrix(
        [
            [Fraction(numbers.choice(nonzero), numbers.randint(1, 7)) for _ in range(columns)]
            for _ in range(rows)
        ]
    )


def step_matrix(method: GLM, z: Sequence[Entry]) -> Matrix:
    """``V + B Z (I - A Z)^-1 U`` with ``Z = diag(z)``: one step where stage i has slope ``z_i``.

    Distinct slopes make this separate any two methods that order conditions would separate.
    """
    Z = linalg.diagonal(vector(z))
    stages = linalg.solve(
        linalg.sub(linalg.identity(method.s), linalg.matmul(method.A, Z)), method.U
    )
    return linalg.add(method.V, linalg.matmul(method.B, Z, stages))


def g_symplectic_defects(method: GLM, G: Matrix, D: Sequence[Entry]) -> tuple[Matrix, ...]:
    """``V*GV - G``, ``DU - B*GV``, ``DA + A*D - B*GB``: theorem 3.0.6 with conjugate transposes."""
    D, star = linalg.diagonal(vector(D)), linalg.conjugate_transpose
    A, U, B, V = method.A, method.U, method.B, method.V
    return (
        linalg.sub(linalg.matmul(star(V), G, V), G),
        linalg.sub(linalg.matmul(D, U), linalg.matmul(star(B), G, V)),
        linalg.sub(
            linalg.add(linalg.matmul(D, A), linalg.matmul(star(A), D)), linalg.matmul(star(B), G, B)
        ),
    )


def is_g_symplectic(method: GLM, G: Matrix, D: Sequence[Entry]) -> bool:
    """Whether the three identities hold exactly for this G and D."""
    return all(vanishes(defect) for defect in g_symplectic_defects(method, G, D))


def has_a_form(method: GLM) -> bool:
    """Whether any G and D make the method G-symplectic: a nullspace, not the forms of a source."""
    found = g_symplectic(method.bare()).holds
    assert found is not None
    return found


def symplectic_matrix(A: Matrix, b: Vector) -> Matrix:
    """``M = diag(b) A + A^T diag(b) - b b^T`` of a Runge-Kutta method, section 1.3."""
    weighted = linalg.matmul(linalg.diagonal(b), A)
    return linalg.sub(
        linalg.add(weighted, linalg.transpose(weighted)), tuple(tuple(x * y for y in b) for x in b)
    )


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """Sum of products."""
    return linalg.dot(a, b)


def determinant(a: Matrix) -> Scalar:
    """Determinant by the first row; the matrices here are small."""
    if len(a) == 1:
        return a[0][0]
    total: Scalar = a[0][0] * 0
    for j, x in enumerate(a[0]):
        minor = tuple(row[:j] + row[j + 1 :] for row in a[1:])
        total = total + x * determinant(minor) * (-1) ** j
    return total


def order(method: GLM, principal: str = "free") -> int:
    """Order found by the theory, with the principal part of the starting series free by default."""
    return order_of(method, principal=principal).order


def after_step(method: GLM, start: Series) -> Series:
    """``M S``: the series of the values after one step that begins with the values of ``start``."""
    stages: dict[Tree, Vector] = {}
    values: dict[Tree, Vector] = {}
    for t in trees_up_to(start.order):
        slopes: Vector = vector([1] * method.s)
        for child in t.children:
            slopes = tuple(x * y for x, y in zip(slopes, stages[child], strict=True))
        known = tuple(x + exact(0) for x in start[t])  # a series may hold int zeros
        pairs = (linalg.matvec(method.A, slopes), linalg.matvec(method.U, known))
        stages[t] = tuple(x + y for x, y in zip(*pairs, strict=True))
        pairs = (linalg.matvec(method.B, slopes), linalg.matvec(method.V, known))
        values[t] = tuple(x + y for x, y in zip(*pairs, strict=True))
    return Series(values, start.empty(), start.order)


def component(series: Series, k: int) -> Series:
    """The series of one value of a vector-valued series."""
    values = {t: series[t][k] for t in trees_up_to(series.order)}
    return Series(values, series.empty()[k], series.order)


def first_difference(a: Series, b: Series, k: int) -> int:
    """Smallest order at which component k differs; one more than the series have if none."""
    for t in trees_up_to(a.order):
        if not (a[t][k] - b[t][k]).is_zero():
            return t.order
    return a.order + 1
