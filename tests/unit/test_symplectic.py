"""G-symplecticity: forms checked, forms found, trivial forms refused."""

from dataclasses import replace
from fractions import Fraction

import pytest

import glmref
from glmref.errors import UsageError
from glmref.exact import exact
from glmref.exact.linalg import identity
from glmref.method import GLM
from glmref.method.families import (
    adams_bashforth,
    adams_moulton,
    bdf,
    gauss,
    linear_multistep,
    lobatto_iiia,
    one_leg,
    one_leg_twin,
    radau_iia,
    runge_kutta,
)
from glmref.theory.equivalence import to_complex, to_real
from glmref.theory.symplectic import (
    check_g_symplectic,
    find_forms,
    g_symplectic,
    g_symplectic_residual,
    is_symplectic,
    symplectic_residual,
)

GSYMPLECTIC = [
    "gsymplectic-n",
    "gsymplectic-p",
    "thesis-3-8",
    "s4-symmetric",
    "g4123",
    "g6245",
    "g6245-w3",
    "g6245-w3-complex",
]


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


@pytest.mark.parametrize("s", range(1, 6))
def test_gauss_methods_are_symplectic(s):
    m = runge_kutta(*gauss(s))
    assert is_symplectic(m) is True
    found = g_symplectic(m)
    assert found.holds is True and found.G == ((1,),) and found.D == m.B[0]


@pytest.mark.parametrize("method", [radau_iia(2), lobatto_iiia(3), (((exact(0),),), (exact(1),))])
def test_other_runge_kutta_methods_are_not(method):
    m = runge_kutta(*method)
    assert is_symplectic(m) is False and g_symplectic(m).holds is False


def test_leapfrog_form_of_the_thesis():
    twin = one_leg(*one_leg_twin(["-1", "0", "1"], ["0", "2", "0"]))
    found = g_symplectic(twin)
    assert found.G == ((0, Fraction(1, 2)), (Fraction(1, 2), 0)) and found.D == (1,)


@pytest.mark.parametrize("coefficients", [bdf(2), adams_bashforth(2)])
def test_one_leg_twins_that_are_not_symmetric_conserve_nothing(coefficients):
    found = g_symplectic(one_leg(*one_leg_twin(*coefficients)))
    assert found.holds is False and found.dimension == 0


def test_form_of_the_trapezoidal_rule_lives_on_y_plus_half_h_f():
    # y + h f/2 is what the implicit midpoint rule conserves: G has rank one, and says so
    found = g_symplectic(linear_multistep(*adams_moulton(1)))
    half, quarter = Fraction(1, 2), Fraction(1, 4)
    assert found.holds is True and found.nondegenerate is False
    assert found.G == ((1, half), (half, quarter))
    assert g_symplectic(linear_multistep(*adams_moulton(2))).holds is False


def test_zero_form_satisfies_the_identities_and_does_not_count():
    m = runge_kutta(*radau_iia(2))
    zero = ((exact(0),),)
    assert all(
        x == 0 for _, r in g_symplectic_residual(m, zero, (0 * exact(1),) * 2) for s in r for x in s
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


def test_passenger_beside_a_symplectic_method_leaves_it_symplectic_with_many_forms():
    m = GLM(A=[["1/2"]], U=[["1", "0"]], B=[["1"], ["0"]], V=[["1", "0"], ["0", "-1"]])
    found = g_symplectic(m)
    assert found.holds is True and found.dimension == 2 and found.nondegenerate is True


def test_complex_form_needs_conjugate_transposes():
    m = glmref.load("g6245-w3-complex")
    assert g_symplectic(m).holds is True
    plain = m.bare(V=m.V, U=tuple(tuple(x.conjugate() for x in row) for row in m.U))
    assert g_symplectic(plain).holds is False


def test_real_and_complex_form_agree():
    real = glmref.load("thesis-3-8")
    back = to_real(to_complex(real))
    assert g_symplectic(to_complex(real).bare()).holds is True
    assert all(
        x == y for r, s in zip(back.V, real.V, strict=True) for x, y in zip(r, s, strict=True)
    )


def test_published_decimals_stay_open_with_the_width_as_residual():
    found = g_symplectic(glmref.load("s3-w3").bare())
    assert found.holds is None and found.residual < 1e-60 and found.dimension == 1


def test_decimals_with_a_wrong_digit_are_refuted():
    m = glmref.load("s3-w3")
    A = [list(row) for row in m.A]
    A[2][0] = A[2][0] + Fraction(1, 10**50)
    assert g_symplectic(m.bare(A=A)).holds is False


def test_symplectic_is_a_question_for_one_step_methods():
    with pytest.raises(UsageError, match="carries 2 values"):
        symplectic_residual(glmref.load("gsymplectic-n"))


def test_method_that_is_not_preconsistent_needs_a_nonsingular_form():
    m = GLM(A=[["1/2"]], U=[["2"]], B=[["1/2"]], V=[["-1"]])
    assert g_symplectic(m).holds is False  # D A + A D = B^2 G and D U = B G V: signs clash
    assert check_g_symplectic(m, identity(1), (exact(0),)).holds is False
