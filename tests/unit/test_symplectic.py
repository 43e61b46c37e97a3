"""G-symplecticity of methods and pairs: forms checked, forms found, trivial forms refused."""

from dataclasses import replace
from fractions import Fraction

import pytest

import glmref
from glmref.errors import UsageError
from glmref.exact import Ball, exact
from glmref.exact.linalg import identity
from glmref.method import GLM, PartitionedGLM
from glmref.method.families import linear_multistep, partitioned_runge_kutta, runge_kutta, splitting
from glmref.theory.symplectic import (
    GSymplecticity,
    check_g_symplectic,
    find_forms,
    form_identities,
    g_symplectic,
    judge_identities,
    quadratic_value,
)
from tests.build import same
from tests.shipped import multistep, tableau

GSYMPLECTIC = [
    "gsymplectic-n", "gsymplectic-p", "thesis-3-8", "s4-symmetric", "g4123", "g6245", "g6245-w3",
    "g6245-w3-complex",
]  # fmt: skip


@pytest.mark.parametrize("name", GSYMPLECTIC)
def test_published_form_is_the_only_one(name):
    m = glmref.load(name)
    given = g_symplectic(m)
    found = g_symplectic(m.bare())
    assert given.holds is True and found.holds is True
    assert found.dimension == 1 and found.nondegenerate is True
    scale = m.G[0][0]
    assert all(
        x * scale == y for r, s in zip(found.G, m.G, strict=True) for x, y in zip(r, s, strict=True)
    )
    assert all(x * scale == y for x, y in zip(found.D, m.D, strict=True))


@pytest.mark.parametrize("name", GSYMPLECTIC)
def test_one_wrong_entry_of_B_leaves_no_form(name):
    m = glmref.load(name).bare()
    B = [list(row) for row in m.B]
    B[-1][0] = B[-1][0] + Fraction(1, 10**30)
    found = g_symplectic(m.bare(B=B))
    assert found.holds is False and found.dimension == 0
    assert 0 < found.residual < 1e-25 and "entry (" in found.witness


def test_a_wrong_digit_in_a_given_form_fails_although_the_method_has_one():
    m = glmref.load("gsymplectic-n")
    D = (m.D[0] + Fraction(1, 100), m.D[1])
    found = g_symplectic(replace(m, D=D))
    assert found.holds is False and found.residual == pytest.approx(0.01)
    assert "entry (1, 1) of D U - B* G V" in found.witness


def test_form_of_the_trapezoidal_rule_lives_on_y_plus_half_h_f():
    # y + h f/2 is what the implicit midpoint rule conserves: G has rank one, and says so
    found = g_symplectic(linear_multistep(*multistep("am-1")))
    half, quarter = Fraction(1, 2), Fraction(1, 4)
    assert found.holds is True and found.nondegenerate is False
    assert found.G == ((1, half), (half, quarter))
    assert g_symplectic(linear_multistep(*multistep("am-2"))).holds is False


def test_zero_form_satisfies_the_identities_and_does_not_count():
    m = runge_kutta(*tableau("radau-iia-2"))
    zero = ((exact(0),),)
    assert all(
        x == 0 for _, r in form_identities(m, zero, (0 * exact(1),) * 2) for s in r for x in s
    )
    found = check_g_symplectic(m, zero, (exact(0), exact(0)))
    assert found.holds is False and "ignores the solution" in found.witness


def test_form_that_sees_a_passenger_only_does_not_count():
    # explicit Euler with a second value that only rotates: G on the passenger is conserved
    m = GLM(A=[["0"]], U=[["1", "0", "0"]], B=[["1"], ["0"], ["0"]],
            V=[["1", "0", "0"], ["0", "0", "-1"], ["0", "1", "0"]])  # fmt: skip
    space = find_forms(m)
    assert len(space.forms) == 1 and not space.principal
    assert g_symplectic(m).holds is False


def test_complex_form_needs_conjugate_transposes():
    m = glmref.load("g6245-w3-complex")
    assert g_symplectic(m).holds is True
    plain = m.bare(V=m.V, U=tuple(tuple(x.conjugate() for x in row) for row in m.U))
    assert g_symplectic(plain).holds is False


def test_decimals_with_a_wrong_digit_are_refuted():
    m = glmref.load("s3-w3")
    A = [list(row) for row in m.A]
    A[2][0] = A[2][0] + Fraction(1, 10**50)
    assert g_symplectic(m.bare(A=A)).holds is False


@pytest.mark.parametrize("half", ["1/2", "1", "-3/7"])
def test_method_that_is_not_preconsistent_has_the_diagonal_of_its_form(half):
    # y+ = -y + h b F with Y = u y + h a F: D u = -b G and 2 a D = b^2 G, so that u = -2 a / b
    a, b = Fraction(half), Fraction(2, 3)
    m = GLM(A=[[a]], U=[[-2 * a / b]], B=[[b]], V=[[-1]])
    space, found = find_forms(m), g_symplectic(m)
    assert len(space.forms) == 1 and not space.principal
    assert found.holds is True and found.dimension == 1
    assert found.D[0] == found.G[0][0] * b * b / (2 * a)
    pair = glmref.PartitionedGLM(m.A, m.U, m.B, m.V, m.A, m.U, m.B, m.V)
    assert g_symplectic(pair).holds is True
    assert check_g_symplectic(pair, found.G, found.D, found.D).holds is True


def test_stages_that_nothing_reads_have_a_form_of_their_own():
    m = GLM(A=[["0", "0"], ["0", "1"]], U=[["0"], ["0"]], B=[["0", "0"]], V=[["2"]])
    space = find_forms(m)
    assert len(space.forms) == 1  # the first stage is 0 for ever: any weight of it is conserved
    assert space.forms[0].G == ((0,),) and space.forms[0].D[0][0] != 0
    assert g_symplectic(m).holds is False


def test_the_entry_that_decides_is_the_largest_one_that_fails():
    def M(*rows):
        return tuple(tuple(x if isinstance(x, Ball) else exact(x) for x in row) for row in rows)

    wide, wider = Ball.decimal("0.00", 2), Ball.decimal("0.0", 1)
    assert judge_identities([("X", M([0]))]) == (True, 0.0, "")
    failed = judge_identities([("X", M([0, 2])), ("Y", M([0], [-3])), ("Z", M([1]))])
    assert failed == (False, 3.0, "entry (2, 1) of Y is 3 in size")
    for order in ((wide, wider), (wider, wide)):
        holds, size, witness = judge_identities([("X", M([x])) for x in order])
        assert holds is None and size == wider.magnitude() and "hold up to 0.1" in witness
    for order in ([("X", M([wider])), ("Y", M([Fraction(1, 100)]))], [("Y", M([Fraction(1, 100)])), ("X", M([wider]))]):  # fmt: skip
        assert judge_identities(order) == (False, 0.01, "entry (1, 1) of Y is 0.01 in size")


def test_a_form_is_real_on_the_diagonal_and_hermitian_and_sees_the_solution():
    midpoint, i = runge_kutta(*tableau("gauss-1")), exact(-1).sqrt()
    one = ((exact(1),),)
    found = check_g_symplectic(midpoint, one, (exact(1),))
    assert found.holds is True and found.nondegenerate is True and found.dimension is None
    assert (found.D, found.D_P, found.D_Q) == ((1,), (1,), (1,))
    found = check_g_symplectic(midpoint, ((i,),), (i,))
    assert found.holds is False and found.witness == "entry (1, 1) of G - G* is 2 in size"
    found = check_g_symplectic(midpoint, one, (1 + i,))
    assert found.holds is False and "the imaginary part of D" in found.witness
    found = check_g_symplectic(midpoint, ((exact(0),),), (exact(0),))
    assert (found.holds, found.witness) == (False, "the form ignores the solution")
    assert GSymplecticity(None).D is None and GSymplecticity(None).D_Q is None
    assert quadratic_value(((exact(2), i), (-i, exact(3))), (exact(1), i)) == 3


def test_diagonals_that_are_not_given_follow_from_G():
    m = glmref.load("gsymplectic-n")
    bare = replace(m, D=None)
    found = g_symplectic(bare)
    assert found.holds is True and all(x == y for x, y in zip(found.D, m.D, strict=True))
    assert g_symplectic(replace(m, D=None, G=identity(2))).holds is False
    none = g_symplectic(runge_kutta([["0"]], ["1"]))
    assert none.holds is False and none.dimension == 0 and none.nondegenerate is False
    with pytest.raises(UsageError, match="single and partitioned methods only"):
        form_identities(glmref.load("ars-1-2-2"), ((exact(1),),), (exact(1),))


# --- pairs ----------------------------------------------------------------------------------------


def pair_of(q, p, *, separable=False):
    return PartitionedGLM(
        A=q.A, U=q.U, B=q.B, V=q.V, A_hat=p.A, U_hat=p.U, B_hat=p.B, V_hat=p.V,
        separable=separable,
    )  # fmt: skip


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
    assert same(found.G, n.G)


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
