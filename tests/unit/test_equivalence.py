"""Superfluous stages and values are removed, and what is left computes the same."""

import pytest

import glmref
from glmref.errors import UsageError
from glmref.exact import exact
from glmref.method import GLM, as_matrix
from glmref.method.families import linear_multistep, runge_kutta
from glmref.theory.equivalence import drop_idle_stages, merge_equal_stages, reduce
from glmref.theory.reduction import reduction
from glmref.theory.stability import stability_polynomial
from tests.shipped import multistep, tableau


def test_published_decimals_cannot_be_compared():
    m = glmref.load("s3-w3")
    with pytest.raises(UsageError, match="exact methods only"):
        reduce(m)


def test_trapezoidal_rule_reduces_to_one_value():
    m = linear_multistep(*multistep("am-1"))
    assert reduction(m).seen == (m.r - 1,)
    small = reduce(m)
    assert (small.s, small.r) == (1, 1)
    assert small.A == tableau("gauss-1")[0]


def test_milne_simpson_reduces_to_two_values():
    small = reduce(linear_multistep(["-1", "0", "1"], ["1/3", "4/3", "1/3"]))
    assert (small.s, small.r) == (1, 2) and reduce(small) is small


def test_irreducible_methods_stay_as_they_are():
    for name in ("gsymplectic-n", "g4123", "g6245"):
        m = glmref.load(name)
        assert reduce(m) is m


def test_idle_stages_are_dropped():
    m = runge_kutta([["1/2", "0"], ["7", "3"]], ["1", "0"])
    assert drop_idle_stages(m).A == ((exact(1) / 2,),)
    used = runge_kutta([["1/2", "1"], ["7", "3"]], ["1", "0"])
    assert drop_idle_stages(used) is used


def test_equal_stages_are_merged():
    m = runge_kutta([["1/4", "1/4"], ["1/2", "0"]], ["1/3", "2/3"])
    small = merge_equal_stages(m)
    assert small.A == ((exact(1) / 2,),) and small.B == ((1,),)
    other = runge_kutta([["1/4", "1/4"], ["1/2", "1"]], ["1/3", "2/3"])
    assert merge_equal_stages(other) is other


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
