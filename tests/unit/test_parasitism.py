"""Growth parameters of parasitic components."""

from fractions import Fraction as F

import pytest

import glmref
from glmref.errors import ExactnessError
from glmref.exact import exact
from glmref.exact.linalg import diagonal
from glmref.method import GLM, PartitionedGLM
from glmref.theory.parasitism import _parasitic, growth
from tests.build import refused


def growth_parameters(m):
    return tuple(g.mu for g in growth(m).growths)


def test_one_sign_of_one_weight_makes_it_grow():
    m = glmref.load("g4123")
    B = [list(row) for row in m.B]
    B[1][2] = -B[1][2]
    found = growth(m.bare(B=B))
    assert found.free is False and "eigenvalue -1 of V is" in found.witness


def test_block_of_b_u_need_not_vanish_where_growth_does():
    m = glmref.load("thesis-3-8")
    assert growth(m).free is True
    entry = sum((m.B[1][i] * m.U[i][1] for i in range(m.s)), exact(0))
    assert float(entry) == pytest.approx(-0.0441501, abs=5e-8)  # ERRATA of the thesis: 7 digits
    n = GLM(A=m.A, U=m.U, B=[m.B[0], m.B[1], [exact(0)] * 4], V=m.V)
    assert growth(n).free is False


def test_repeated_eigenvalue_has_a_growth_matrix():
    m = GLM(A=[["0", "0"], ["0", "0"]], U=[["1", "0"], ["1", "1"]],
            B=[["1", "0"], ["0", "1"]], V=[["1", "0"], ["0", "1"]])  # fmt: skip
    found = growth(m)
    (one,) = found.growths
    assert found.free is False and one.multiplicity == 1 and one.eigenvalue == 1
    twice = GLM(A=m.A, U=[["1", "1", "0"], ["1", "0", "1"]],
                B=[["1/2", "1/2"], ["1", "0"], ["0", "1"]],
                V=[["1", "0", "0"], ["0", "-1", "0"], ["0", "0", "-1"]])  # fmt: skip
    (minus,) = growth(twice).growths
    assert minus.multiplicity == 2 and minus.mu is None and minus.matrix == ((-1, 0), (0, -1))


def test_pair_of_n_grows_like_n():
    n = glmref.load("gsymplectic-n")
    found = growth(glmref.load("gsymplectic-n-pair"))
    assert found.free is False and found.growths[0].matrices["mu_q"] == (
        (growth_parameters(n)[0],),
    )


def separable_pair(w, v):
    """P_0 Q_0 P_1 with a second value carried: mu_q is sum b w^2, mu_p is sum c v^2, up to sign."""
    b, c = [exact(1) / 2, exact(1) / 2], [exact(1)]
    return PartitionedGLM(
        A=[[b[0] * (1 + v[0] * w[0]), 0]], U=[[1, -v[0]]],
        B=[b, [b[0] * w[0], b[1] * w[1]]], V=[[1, 0], [0, -1]],
        A_hat=[[0], [c[0] * (1 + w[1] * v[0])]], U_hat=[[1, -w[0]], [1, -w[1]]],
        B_hat=[c, [c[0] * v[0]]], V_hat=[[1, 0], [0, -1]], separable=True,
    )  # fmt: skip


def test_coupled_growth_of_a_separable_pair():
    two, three = exact(2), exact(3)
    found = growth(separable_pair([-two, two], [three]))
    (g,) = found.growths
    assert g.matrices["mu_q"] == ((4,),) and g.matrices["mu_p"] == ((9,),) and len(g.matrices) == 2
    assert growth(separable_pair([exact(0)] * 2, [exact(0)])).free is True


@pytest.mark.parametrize(
    ("values", "expected"),
    [((1, -1), [-1]), ((1, -1, -1), [-1]), ((-1, -1), [-1]), ((1, F(1, 2)), []), ((1, 1), None),
     ((1, 1, -1), None)],
)  # fmt: skip
def test_parasitic_values_of_a_half_are_all_but_a_simple_one(values, expected):
    V = diagonal([exact(x) for x in values])
    if expected is None:
        refused(ExactnessError, "1 is a multiple eigenvalue of V", _parasitic, V)
    else:
        assert _parasitic(V) == [exact(x) for x in expected]
