"""Equivalent tableaux, superfluous parts, real and complex form."""

import pytest

import glmref
from glmref.errors import UsageError
from glmref.exact import exact, root_of_unity
from glmref.exact.linalg import diagonal
from glmref.method import GLM, as_matrix
from glmref.method.classical import adams_moulton, gauss
from glmref.method.families import linear_multistep, runge_kutta
from glmref.theory.complex_form import complex_pairs, rotation_pairs, to_complex, to_real
from glmref.theory.equivalence import (
    drop_idle_stages,
    equivalence,
    equivalent,
    merge_equal_stages,
    reachable_values,
    reduce,
)
from glmref.theory.reduction import reduction

T4 = as_matrix(
    [["1", "2", "0", "1"], ["0", "1", "0", "-3"], ["1", "0", "2", "0"], ["0", "0", "1", "1"]], "T"
)


def same(a, b):
    return all(x == y for r, s in zip(a, b, strict=True) for x, y in zip(r, s, strict=True))


@pytest.mark.slow
def test_transformation_and_order_of_stages_are_found():
    m = glmref.load("g6245")
    other = m.transform(T4).permute_stages([3, 1, 4, 0, 2])
    found = equivalence(m, other)
    assert found is not None and found.stages == (3, 1, 4, 0, 2) and same(found.T, T4)
    again = m.transform(found.T).permute_stages(found.stages)
    assert all(same(getattr(again, x), getattr(other, x)) for x in "AUBV")


@pytest.mark.parametrize("letter", "AUBV")
def test_one_changed_entry_is_no_longer_equivalent(letter):
    m = glmref.load("gsymplectic-n")
    rows = [list(row) for row in getattr(m, letter)]
    rows[1][0] = rows[1][0] + exact(1) / 10**20
    assert equivalent(m, m.bare(**{letter: rows})) is None


def test_n_and_p_are_not_equivalent():
    assert equivalent(glmref.load("gsymplectic-n"), glmref.load("gsymplectic-p")) is None


def test_methods_of_different_size_are_not_equivalent():
    assert equivalent(runge_kutta(*gauss(1)), runge_kutta(*gauss(2))) is None


def test_equivalence_finds_a_nonsingular_matrix_where_many_are_allowed():
    m = GLM(A=[["1/2"]], U=[["1", "0"]], B=[["1"], ["0"]], V=[["1", "0"], ["0", "-1"]])
    assert equivalent(m, m) is not None


def test_published_decimals_cannot_be_compared():
    m = glmref.load("s3-w3")
    with pytest.raises(UsageError, match="exact methods only"):
        equivalent(m, m)
    with pytest.raises(UsageError, match="exact methods only"):
        reduce(m)


def test_complex_form_becomes_the_real_one_of_the_thesis():
    z = root_of_unity(1, 3)
    m = glmref.load("g6245-w3-complex")
    assert complex_pairs(m) == [1]
    real = to_real(m)
    assert real.is_real
    half, root = exact(1) / 2, exact(3).sqrt() / 2
    assert real.V[1][1:3] == (-half, -root) and real.V[2][1:3] == (root, -half)
    assert rotation_pairs(real) == [1]
    back = to_complex(real)
    assert back.V[1][1] == z and same(back.V, m.V) and same(back.U, m.U) and same(back.B, m.B)


def test_g_goes_along_to_the_real_form():
    m = glmref.load("g6245-w3-complex")
    real = to_real(m)
    if m.G is not None:
        assert real.G[1][1] == m.G[1][1] / 2 and real.G[1][2] == 0  # gamma^* G gamma


def test_trapezoidal_rule_reduces_to_one_value():
    m = linear_multistep(*adams_moulton(1))
    assert reduction(m).seen == (m.r - 1,)
    small = reduce(m)
    assert (small.s, small.r) == (1, 1)
    assert equivalent(small, runge_kutta(*gauss(1))) is not None


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


def test_values_out_of_reach_are_removed():
    m = GLM(A=[["1/2"]], U=[["1", "1"]], B=[["1"], ["0"]], V=[["1", "0"], ["0", "-1"]])
    assert len(reachable_values(m)) == 1
    small = reduce(m)
    assert small.r == 1 and equivalent(small, runge_kutta(*gauss(1))) is not None


def test_conjugate_pairs_become_rotations_wherever_they_stand_and_back():
    i, one, nil = exact(-1).sqrt(), exact(1), exact(0)
    z, w = (3 + 4 * i) / 5, (5 - 12 * i) / 13
    values = [one, z, z.conjugate(), w, w.conjugate()]
    B = ((one,), (1 + i,), (1 - i,), (2 * i,), (-2 * i,))
    m = GLM(
        A=((nil,),), U=((one, i, -i, 3 - i, 3 + i),), B=B, V=diagonal(values),
    )  # fmt: skip
    assert complex_pairs(m) == [1, 3]
    real = to_real(m)
    assert real.is_real and rotation_pairs(real) == [1, 3]
    assert real.B == ((1,), (2,), (2,), (0,), (4,))  # 2 Re and 2 Im of each pair
    assert real.V[1][1] == exact(3) / 5 and abs(complex(real.V[1][2])) == 0.8
    back = to_complex(real)
    for letter in "AUBV":
        assert same(getattr(back, letter), getattr(m, letter))
    assert complex_pairs(real) == [] and complex_pairs(glmref.load("rk4")) == []
    assert same(to_real(m, [1, 3]).V, real.V) and not to_real(m, [3]).is_real


@pytest.mark.parametrize("base", [linear_multistep(*adams_moulton(2)), runge_kutta(*gauss(2))])
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
        assert (small.s, small.r) == (s, r) and equivalent(small, base) is not None
        assert reduction(m).seen == (m.r - 1,) and len(reachable_values(m)) == r + 1
