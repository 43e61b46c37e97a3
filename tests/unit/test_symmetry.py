"""Time-reversal symmetry: L and P found, and never concluded from B = L B P alone."""

from fractions import Fraction
from types import SimpleNamespace

import pytest

import glmref
from glmref.exact import Ball, ball, exact
from glmref.exact.linalg import block_diagonal, diagonal, identity, inverse, matmul
from glmref.method import GLM, families
from glmref.theory.symmetry import _better, symmetry, symmetry_as_given
from tests.build import same
from tests.shipped import multistep, one_leg_twin, tableau

HALF, ROOT = exact(1) / 2, exact(3).sqrt() / 2
BLOCK = ((HALF, ROOT), (ROOT, -HALF))


ONE, MINUS = ((exact(1),),), ((exact(-1),),)
FLIP = ((exact(0), exact(1)), (exact(1), exact(0)))
EXPECTED = {
    "gsymplectic-n": identity(2),
    "gsymplectic-p": identity(2),
    "s4-symmetric": block_diagonal(ONE, BLOCK),
    "g6245-w3": block_diagonal(ONE, BLOCK, MINUS),
    "g6245": block_diagonal(ONE, FLIP, MINUS),
}


@pytest.mark.parametrize("name", EXPECTED)
def test_involution_of_the_literature_is_found(name):
    m = glmref.load(name)
    found = symmetry(m)
    assert found.holds is True and found.residual == 0 and not found.reduced
    assert found.P == tuple(range(m.s))[::-1]
    assert same(found.L, EXPECTED[name])


def test_thesis_3_8_passes_b_equals_l_b_p_and_is_not_symmetric():
    m = glmref.load("thesis-3-8")
    L_out = diagonal([exact(1), exact(-1), exact(-1)])
    reversed_B = tuple(row[::-1] for row in m.B)
    assert same(m.B, matmul(L_out, reversed_B))
    found = symmetry(m)
    assert found.holds is False and found.residual == 1.5
    assert "entry (2, 2) of L L - I" in found.witness
    assert "allow one matrix L only" in found.witness
    # the only matrix the linear conditions allow is V^-1 L_out
    assert same(found.L, matmul(inverse(m.V), L_out))


@pytest.mark.parametrize("method", [tableau("radau-iia-2"), (((exact(0),),), (exact(1),))])
def test_one_sided_methods_are_not_symmetric(method):
    found = symmetry(families.runge_kutta(*method))
    assert found.holds is False and found.L is None and "no exchange of stages" in found.witness


def test_symmetric_one_leg_methods_are_symmetric():
    for alpha, beta in (
        (["-1", "0", "1"], ["0", "2", "0"]),
        (["-1", "0", "1"], ["1/3", "4/3", "1/3"]),
    ):
        found = symmetry(families.one_leg(*one_leg_twin(alpha, beta)))
        assert found.holds is True and found.L == ((0, 1), (1, 0))
    assert symmetry(families.one_leg(*one_leg_twin(*multistep("bdf-2")))).holds is False


def test_wrong_digits_are_refuted_among_published_decimals():
    m = glmref.load("s3-w3")
    A = [list(row) for row in m.A]
    A[1][0] = A[1][0] + exact(1) / 10**40
    assert symmetry(m.bare(A=A)).holds is False


def test_verlet_exchanges_sweeps_and_symplectic_euler_does_not():
    for first, a, b in (("q", ["1/2", "1/2"], ["1"]), ("p", ["1"], ["1/2", "1/2"])):
        found = symmetry(families.splitting(a, b, first=first))
        assert found.holds is True
        assert found.exchanges == {"f": tuple(range(len(b)))[::-1], "k": tuple(range(len(a)))[::-1]}
    assert symmetry(families.splitting(["1"], ["1"])).holds is False
    assert symmetry(families.splitting(["1/3", "2/3"], ["1"])).holds is False


def test_an_open_finding_is_preferred_to_one_that_fails_and_to_no_other():
    fails, open_, holds = (SimpleNamespace(holds=x) for x in (False, None, True))
    assert _better(None, fails) is fails
    assert _better(fails, open_) is open_
    for best, found in ((fails, holds), (fails, fails), (open_, open_), (holds, open_)):
        assert _better(best, found) is best


@pytest.mark.parametrize(("a", "holds"), [("1/2", True), ("0", False)])
def test_a_value_without_a_mirror_image_that_no_stage_sees_is_left_out(a, holds):
    # V L = L V^-1 leaves no entry of L to the second value, and L B = V^-1 B asks for one
    m = GLM(A=[[a]], U=[["1", "0"]], B=[["1"], ["1"]], V=[["1", "0"], ["0", "2"]])
    found = symmetry(m)
    assert found.holds is holds and found.reduced is holds
    digits = m.bare(A=((Ball.around(ball(Fraction(a)), Fraction(1, 10**30)),),))
    found = symmetry(digits)  # rounded methods are taken as they stand
    assert found.holds is False
    if holds:
        assert found.witness == "no matrix L satisfies the linear conditions"


def test_a_search_that_is_cut_off_leaves_symmetry_open(monkeypatch):
    """Of stages that are alike all 4 or 10 exchanges fit A, and V = diag(1, 2) has no L."""

    def alike(n: int) -> GLM:
        return GLM(
            A=[[f"1/{2 * n}"] * n] * n, U=[["1", "0"]] * n, B=[[f"1/{n}"] * n, ["0"] * n],
            V=[["1", "0"], ["0", "2"]],
        )  # fmt: skip

    assert symmetry_as_given(alike(3)).holds is False
    monkeypatch.setattr("glmref.theory.symmetry.MAX_PERMUTATIONS", 5)
    assert symmetry_as_given(alike(3)).holds is False
    assert symmetry_as_given(alike(4)).holds is None
