"""Blocks: eigenvectors of V to 1, the solver for (I - V) x = R, vectors with certain zeros."""

from fractions import Fraction as F

import pytest

from glmref.catalogue.lookup import load
from glmref.exact import Ball, Exact, exact
from glmref.exact.linalg import identity, matmul, matvec, sub, transpose
from glmref.method import GLM, as_matrix
from glmref.theory.blocks import (
    NotPreconsistent,
    as_scalar,
    equal,
    kernel,
    make_block,
    present,
    principal_vectors,
    seen,
    tidy,
)
from glmref.theory.coefficients import apply


def block_of(method):
    return make_block(method.A, method.U, method.B, method.V)


@pytest.mark.parametrize("name", ["g4123", "g6245-w3", "ab-3", "bdf-4", "dimsim-2-type-2"])
def test_the_solver_solves_and_leaves_nothing_in_the_output(name):
    method = load(name)
    block = block_of(method)
    difference = sub(identity(method.r), method.V)
    right = matvec(difference, tuple(exact(3 * i * i + 1) for i in range(method.r)))
    x = tuple(map(as_scalar, apply(block.lift, right)))
    assert equal(matvec(difference, x), right)
    assert as_scalar(seen(block, x)).is_zero()
    assert equal(matvec(method.V, block.u), block.u)
    assert equal(matvec(method.U, block.u), (Exact(1),) * method.s)
    assert equal(apply(block.W, block.u), (Exact(1),))
    assert seen(block, block.u) == 1
    assert block.semisimple
    assert block.certain


def test_the_output_is_the_first_value_that_carries_the_solution():
    method = load("g4123").transform([[0, 1], [1, 0]])
    block = block_of(method)
    assert equal(block.u, (exact(0), exact(1)))
    assert equal(block.output, (exact(0), exact(1)))


def test_a_defective_eigenvalue_is_noticed():
    jordan = GLM(A=[[0]], U=[[1, 0]], B=[[1], [0]], V=[[1, 1], [0, 1]])
    block = block_of(jordan)
    assert not block.semisimple
    assert len(block.N) == 1


def test_u_is_chosen_by_consistency_where_several_will_do():
    rows = [["1/2", "1/2"]]
    u, N, W, certain = principal_vectors(
        as_matrix(rows, "U"), as_matrix([[2], [0]], "B"), identity(2)
    )
    assert [x.as_fraction() for x in u] == [2, 0]
    assert (len(N), len(W), certain) == (2, 2, True)
    # B 1 = (1, 0) is no such u: the first that U allows is taken, and order 1 will fail
    u = principal_vectors(as_matrix(rows, "U"), as_matrix([[1], [0]], "B"), identity(2))[0]
    assert sum(u, start=exact(0)) == 2


def test_what_is_not_preconsistent_says_why():
    with pytest.raises(NotPreconsistent, match="no eigenvalue"):
        principal_vectors(as_matrix([[1]], "U"), as_matrix([[1]], "B"), as_matrix([[2]], "V"))


def test_a_kernel_that_balls_leave_open_is_taken_and_said():
    third = Ball.decimal("0.3333333333", 10)
    matrix = ((third - 1, 1 - third), (third, -third))
    basis, certain = kernel(matrix)
    assert not certain
    assert len(basis) == 1
    assert all(x.is_zero() is not False for x in matvec(matrix, basis[0]))
    exact_matrix = as_matrix([["-2/3", "2/3"], ["1/3", "-1/3"]], "M")
    basis, certain = kernel(exact_matrix)
    assert certain
    assert matmul(exact_matrix, transpose((basis[0],))) == as_matrix([[0], [0]], "Z")
    assert kernel(identity(2)) == ([], True)


def test_vectors_with_certain_zeros():
    open_ball = Ball.decimal("0.5", 3) - F(1, 2)
    assert tidy((exact(0), F(0), 0)) == (0, 0, 0)
    assert not present(tidy((exact(0), F(0), 0)))
    assert present(tidy((exact(0), open_ball)))
    assert not equal((open_ball,), (0,))
    assert equal((exact(2), 0), (2, exact(0)))
