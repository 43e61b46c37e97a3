"""linalg.py: exact matrices, pivots never guessed."""

from fractions import Fraction

import pytest

from glmref.catalogue.entries import Entries
from glmref.errors import BudgetError, ExactnessError
from glmref.exact import Ball, Exact, exact, linalg
from glmref.exact.expression import parse, to_text
from glmref.method import as_matrix
from glmref.system.budget import limited
from glmref.theory import polynomials
from tests.build import refused


def matrix(*rows: str) -> linalg.Matrix:
    return as_matrix([row.split() for row in rows], "matrix")


def test_shapes_that_do_not_fit_are_errors() -> None:
    refused(ValueError, "argument 2 is", linalg.matmul, matrix("1 2"), matrix("1 2"))
    refused(ValueError, "argument 2 is", linalg.add, matrix("1 2"), matrix("1"))


def test_inverse_of_a_matrix_whose_determinant_hides_its_zero() -> None:
    hidden = matrix("sqrt(2) sqrt(3)", "2 sqrt(6)")
    assert linalg.rank(hidden) == 1
    refused(ExactnessError, "size 2 and rank 1", linalg.inverse, hidden)
    (vector,) = linalg.nullspace(hidden)
    assert all(x.is_zero() for x in linalg.matvec(hidden, vector))


def test_a_ball_around_zero_is_never_taken_for_a_pivot_nor_for_zero() -> None:
    doubtful: tuple[tuple[Ball | Exact, ...], ...] = ((Ball.decimal("0.000", 3),),)
    refused(ExactnessError, "its rank is not decided", linalg.rank, doubtful)
    certain = ((parse("0.500", digits=3),),)
    assert linalg.rank(certain) == 1
    assert linalg.inverse(certain)[0][0].contains(2)


def test_complex_balls_and_irrational_numbers_stand_in_one_matrix() -> None:
    i, root = parse("i"), parse("root(2,3)*exp(2*pi*i/7)")
    near = Ball.around(Exact(0).ball(), Fraction(1, 10**40)) + i
    x = linalg.solve(((near, root), (root, exact(1))), ((exact(1),), (root,)))
    true = linalg.solve(((i, root), (root, exact(1))), ((exact(1),), (root,)))
    for row, other in zip(x, true, strict=True):
        assert isinstance(row[0], Ball) and row[0].contains(other[0])
        assert not row[0].contains(other[0] + Fraction(1, 10**38))


def test_inverse_over_balls_encloses_the_exact_one() -> None:
    decimals = as_matrix(
        [
            [parse(x, digits=6) for x in row]
            for row in (("0.333333", "0.250000"), ("0.200000", "0.166667"))
        ],
        "a",
    )
    true = ((Fraction(1, 3), Fraction(1, 4)), (Fraction(1, 5), Fraction(1, 6)))
    back = linalg.inverse(as_matrix(true, "true"))
    for row, exact_row in zip(linalg.inverse(decimals), back, strict=True):
        for x, y in zip(row, exact_row, strict=True):
            assert x.contains(y)
            assert not x.contains(y + 1)


def test_no_rows_have_no_independent_ones() -> None:
    assert linalg.independent_rows([]) == []
    assert linalg.independent_rows(matrix("0 0", "1 2", "2 4", "0 1", "1 1"), 2) == [1, 3]


def test_work_on_matrices_and_polynomials_looks_at_the_budget() -> None:
    a, b = matrix("1 2", "3 4"), matrix("1", "1")
    root = exact(2).sqrt()
    for work in (
        lambda: linalg.solve(a, b),
        lambda: linalg.solve_affine(a, (exact(1), exact(1))),
        lambda: linalg.independent_rows(a),
        lambda: linalg.conjugate_transpose(a),
        lambda: linalg.matmul(a, b),
        lambda: linalg.sub(a, a),
        lambda: polynomials.mul(a[0], a[1]),
        lambda: polynomials.divide((root, exact(1)), a[0]),
        lambda: root * root,
        root.is_zero,
        lambda: to_text(exact(2)),
        lambda: Entries({}, "it.json").scalar("1", "b"),
    ):
        with limited(-1.0), pytest.raises(BudgetError):
            work()
