"""Pre-consistency, consistency, abscissae."""

from fractions import Fraction

import pytest

import glmref
from glmref.exact import exact
from glmref.method import GLM
from glmref.method.families import linear_multistep, runge_kutta
from glmref.method.preconsistency import preconsistency_of
from glmref.prove.facts import facts_of
from glmref.theory.consistency import consistency, consistency_residual, preconsistency_residual
from tests.shipped import multistep


def truths(m):
    """What the judge says: whether a method is preconsistent, and consistent."""
    facts = facts_of(m)
    return facts.truth("preconsistent"), facts.truth("consistent")


def test_multistep_vectors_say_what_is_carried():
    m = linear_multistep(*multistep("am-2"))
    found = consistency(m)
    assert truths(m) == (True, True) and preconsistency_of(m).unique
    assert found.u == (1, 0, 0) and found.v == (0, 1, 1) and found.c == (1,)


def test_vectors_satisfy_the_conditions():
    m = glmref.load("g6245-w3")
    found = consistency(m)
    residuals = preconsistency_residual(m, found.u) + consistency_residual(m, found.u, found.v)
    assert all(x == 0 for row in residuals for x in row)
    assert found.c == (0, Fraction(1, 3), Fraction(1, 2), Fraction(2, 3), 1)


def test_a_wrong_stage_row_is_named():
    m = glmref.load("g6245")
    U = [list(row) for row in m.U]
    U[3][0] = exact(2)
    found = consistency(m.bare(U=U))
    assert truths(m.bare(U=U)) == (False, False) and found.u is None
    assert "row 4 of U u = 1" in found.witness and found.residual == 1


def test_weights_that_do_not_sum_to_one_are_inconsistent():
    m = runge_kutta([["0"]], ["1/2"])
    found = consistency(m)
    assert truths(m) == (True, False) and found.v is None
    assert found.residual == 0.5 and "do not sum to 1" in found.witness


def test_balls_keep_the_weights_open_and_the_exact_part_decided():
    found = consistency(glmref.load("s3-w3"))
    assert truths(glmref.load("s3-w3")) == (True, None)
    assert 0 < found.residual < 1e-60


@pytest.mark.parametrize("name", ["stormer-verlet", "gsymplectic-n-pair"])
def test_both_halves_of_a_pair_are_consistent(name):
    assert truths(glmref.load(name)) == (True, True)


def test_residuals_are_rows_of_the_conditions():
    m = GLM(A=[[0]], U=[[1, 2]], B=[[3], [4]], V=[[1, 5], [0, 6]])
    u, v = (exact(1), exact(7)), (exact(2), exact(-1))
    assert preconsistency_residual(m, u) == ((35,), (35,), (14,))
    assert consistency_residual(m, u, v) == ((3 - 3 - 3,), (4 - 6 - 7 + 1,))
