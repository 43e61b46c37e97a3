"""Pairs: the form between the two halves."""

from dataclasses import replace

import pytest

import glmref
from glmref.exact import exact
from glmref.method import PartitionedGLM
from glmref.method.families import partitioned_runge_kutta, splitting
from glmref.theory.symplectic import find_forms, g_symplectic
from tests.shipped import tableau


def pair_of(q, p, *, separable=False):
    return PartitionedGLM(
        A=q.A, U=q.U, B=q.B, V=q.V, A_hat=p.A, U_hat=p.U, B_hat=p.B, V_hat=p.V,
        separable=separable,
    )  # fmt: skip


def test_symplectic_euler_is_symplectic_and_two_explicit_eulers_are_not():
    good = partitioned_runge_kutta([["0"]], ["1"], [["1"]], ["1"])
    bad = partitioned_runge_kutta([["0"]], ["1"], [["0"]], ["1"])
    assert g_symplectic(good).holds is True
    found = g_symplectic(bad)
    assert found.holds is False and found.residual == 1
    assert "entry (1, 1) of D_P A^ + A* D_Q - B* G B^" in found.witness


@pytest.mark.parametrize("s", [2, 3, 4])
def test_lobatto_iiia_iiib_is_symplectic_and_iiia_alone_is_not(s):
    found = g_symplectic(
        partitioned_runge_kutta(*tableau(f"lobatto-iiia-{s}"), *tableau(f"lobatto-iiib-{s}"))
    )
    assert found.holds is True and found.D_P == found.D_Q == tableau(f"lobatto-iiia-{s}")[1]
    assert (
        g_symplectic(
            partitioned_runge_kutta(*tableau(f"lobatto-iiia-{s}"), *tableau(f"lobatto-iiia-{s}"))
        ).holds
        is False
    )


@pytest.mark.parametrize("first", ["q", "p"])
def test_every_splitting_is_symplectic_with_its_weights(first):
    found = g_symplectic(splitting(["1/3", "2/3"], ["2/5", "3/5"], first=first))
    assert found.holds is True and found.G == ((1,),)
    assert found.D_P == (exact(1) / 3, exact(2) / 3) and found.D_Q == (exact(2) / 5, exact(3) / 5)


def test_unequal_weights_need_separate_diagonals():
    # b != b_hat: conserved for separable systems only
    A, A_hat = [["0", "0"], ["0", "0"]], [["1/4", "3/4"], ["1/4", "3/4"]]
    shared = partitioned_runge_kutta(A, ["1/2", "1/2"], A_hat, ["1/4", "3/4"])
    assert g_symplectic(shared).holds is False
    assert g_symplectic(replace(shared, separable=True)).holds is True


def test_a_method_paired_with_itself_has_its_own_form():
    n = glmref.load("gsymplectic-n")
    found = g_symplectic(pair_of(n, n))
    assert found.holds is True
    assert all(x == y for r, s in zip(found.G, n.G, strict=True) for x, y in zip(r, s, strict=True))


@pytest.mark.parametrize("separable", [False, True])
def test_p_with_n_conserves_nothing(separable):
    p, n = glmref.load("gsymplectic-p"), glmref.load("gsymplectic-n")
    found = g_symplectic(pair_of(p, n, separable=separable))
    assert found.holds is False and found.dimension == 0


def test_wrong_given_form_fails():
    n = glmref.load("gsymplectic-n")
    pair = replace(pair_of(n, n), G=n.G, D_P=n.D, D_Q=(n.D[0], n.D[1] * 2))
    assert g_symplectic(pair).holds is False
    assert g_symplectic(replace(pair, D_Q=n.D)).holds is True


def test_forms_of_gauss_with_itself_are_one_dimensional():
    assert (
        len(find_forms(partitioned_runge_kutta(*tableau("gauss-3"), *tableau("gauss-3"))).forms)
        == 1
    )
