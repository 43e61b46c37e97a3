"""Superfluous stages and values are found and removed, and what is left computes the same."""

import pytest

from glmref.catalogue.lookup import load
from glmref.exact import Ball, exact, linalg
from glmref.method import GLM, as_matrix, as_vector
from glmref.method.families import linear_multistep, runge_kutta
from glmref.method.sweep import build_partitioned as build
from glmref.theory.equivalence import reduce
from glmref.theory.reduction import reduction
from glmref.theory.stability import stability_polynomial
from tests.shipped import multistep, tableau


@pytest.mark.parametrize(
    "base", [linear_multistep(*multistep("am-2")), runge_kutta(*tableau("gauss-2"))]
)
def test_what_was_added_without_influence_is_found_and_removed(base):
    base = reduce(base)
    s, r = base.s, base.r
    nil = exact(0)
    # stage 1 in two halves, one idle stage, a value nobody sees and one that nothing reaches
    order = [0, 0, *range(1, s)]
    A = [[x / 2 if j < 2 else x for j, x in enumerate([base.A[i][k] for k in order])] + [nil]
         for i in order]  # fmt: skip
    A.append([exact(k) for k in range(s + 2)])
    U = [[*base.U[i], nil, exact(i + 1)] for i in order]
    U[1] = U[0]
    U.append([exact(5)] * r + [nil, exact(5)])
    B = [[x / 2 if j < 2 else x for j, x in enumerate([row[k] for k in order])] + [nil]
         for row in base.B]  # fmt: skip
    B += [[exact(j) for j in range(s + 1)] + [nil], [nil] * (s + 2)]
    V = [[*row, nil, exact(1)] for row in base.V]
    V += [[exact(1)] * r + [exact(3), exact(2)], [nil] * (r + 1) + [exact(-1)]]
    big = GLM(A=A, U=U, B=B, V=V)
    mixing = [[exact(int(i == j) + (i + 1 == j) - 2 * (i == j + 2)) for j in range(r + 2)]
              for i in range(r + 2)]  # fmt: skip
    for m in (big, big.transform(as_matrix(mixing, "T"))):
        assert reduce(m) is not m
        small = reduce(m)
        assert (small.s, small.r) == (s, r)
        assert stability_polynomial(small) == stability_polynomial(base)
        assert reduction(m).seen == (m.r - 1,) and reduction(m).reached == (r + 1,)


# --- which values are needed ----------------------------------------------------------------------


SIGNS = as_matrix([["1", "0"], ["0", "-1"]], "V")


def pair(w, v, V=SIGNS):
    return build(
        as_vector(["1/2", "1/2"], "b"), as_vector([1], "c"), w=as_matrix([w], "w"),
        v=as_matrix([v], "v"), V=V, V_hat=V, G=linalg.identity(2), stages="PQP",
    )  # fmt: skip


def test_one_step_methods_need_their_one_value():
    for name in ("stormer-verlet", "forest-ruth-4", "lobatto-iiia-iiib-3"):
        assert reduction(load(name)).reducible is False


def test_a_value_that_no_stage_couples_is_never_reached_and_never_seen():
    found = reduction(pair([0, 0], [0]))
    assert found.reducible is True
    assert (found.reached, found.seen) == ((1, 1), (1, 1))
    assert "only 1 of the 2 values of q are ever reached" in found.witness


def test_a_value_is_needed_only_where_it_is_reached_and_seen():
    # q_2 is driven by f through w but no stage Q reads it: v = 0
    found = reduction(pair([1, -1], [0]))
    assert found.reducible is True
    assert (found.reached, found.seen) == ((2, 1), (1, 2))
    both = reduction(pair([1, -1], [1]))
    assert (both.reducible, both.witness) == (False, "")


def test_two_values_that_stages_see_only_as_their_sum_are_one():
    found = reduction(pair([1, 1], [1], V=linalg.identity(2)))
    assert found.reducible is True
    assert found.seen == (1, 1)


def test_the_published_pairs_are_not_partitioned_runge_kutta_methods():
    for name in ("pair-4-4", "pair-4-5", "pair-4-6", "pair-6-7", "pair-6-10"):
        found = reduction(load(name))
        assert (found.reducible, found.reached, found.seen) == (False, (2, 2), (2, 2))


def test_decimals_that_may_be_equal_leave_open_whether_a_value_is_needed():
    """Two stages read y1 + y2/2 as far as the decimals say: whether alike is not known."""

    def read(second):
        U = [["1", Ball.decimal("0.500", 3)], ["1", Ball.decimal(second, 3)]]
        V = [["1", "0"], ["0", "1"]]
        return reduction(GLM(A=[["0"] * 2] * 2, U=U, B=[["1/2", "1/2"], ["1", "-1"]], V=V))

    assert read("0.500").reducible is None
    assert read("0.502").reducible is None
    assert read("0.503").reducible is False
