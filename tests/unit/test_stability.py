"""Linear stability decided exactly."""

from fractions import Fraction
from itertools import combinations, combinations_with_replacement

import pytest

import glmref
from glmref.errors import UsageError
from glmref.exact import exact
from glmref.method import GLM
from glmref.method.families import (
    composition,
    linear_multistep,
    one_leg,
    runge_kutta,
    splitting,
)
from glmref.prove.kernel import Kernel, Proposal
from glmref.theory import polynomials as poly
from glmref.theory.stability import (
    _through_powers,
    _through_values,
    divided,
    is_mirror_image,
    leading_part,
    only_zeros,
    oscillator,
    parasitic_curvature,
    schur_cohn,
    size_difference,
    stability_function,
    stability_matrix,
    stability_polynomial,
    vanishes_at_inverse,
)
from tests.classical import (
    adams_bashforth,
    adams_moulton,
    bdf,
    gauss,
    lobatto_iiia,
    lobatto_iiic,
    one_leg_twin,
    radau_iia,
)


def a_stability(m):
    """What the kernel knows of it."""
    return Kernel(m).known("a-stable", Proposal())


def is_a_stable(m):
    return a_stability(m).truth


def is_l_stable(m):
    return Kernel(m).known("l-stable", Proposal()).truth


TR_BDF2 = runge_kutta(
    [
        ["0", "0", "0"],
        ["1-sqrt(2)/2", "1-sqrt(2)/2", "0"],
        ["sqrt(2)/4", "sqrt(2)/4", "1-sqrt(2)/2"],
    ],
    ["sqrt(2)/4", "sqrt(2)/4", "1-sqrt(2)/2"],
)


def sdirk(gamma):
    return runge_kutta([[gamma, "0"], [f"1-2*{gamma}", gamma]], ["1/2", "1/2"])


def test_stability_function_of_gauss_2_is_the_pade_approximation():
    N, D = stability_function(runge_kutta(*gauss(2)))
    assert N == (1, Fraction(1, 2), Fraction(1, 12))
    assert D == (1, Fraction(-1, 2), Fraction(1, 12))


def test_common_factor_of_a_stability_function_cancels():
    # the first stage of the trapezoidal rule, doubled: a pole that is not there
    m = runge_kutta([["0", "0", "0"], ["1/2", "1/2", "0"], ["0", "0", "1/3"]], ["1/2", "1/2", "0"])
    assert stability_function(m) == ((1, Fraction(1, 2)), (1, Fraction(-1, 2)))


def test_stability_polynomial_of_leapfrog():
    P = stability_polynomial(linear_multistep(["-1", "0", "1"], ["0", "2", "0"]))
    assert P == ((-1,), (0, -2), (1,))  # w^2 - 2 z w - 1


@pytest.mark.parametrize("name", ["gsymplectic-n", "s4-symmetric", "g4123"])
def test_stability_polynomial_is_the_determinant_at_any_point(name):
    m = glmref.load(name)
    z = Fraction(3, 7)
    at_z = poly.trim([poly.evaluate(p, z) for p in stability_polynomial(m)])
    characteristic = poly.characteristic_polynomial(stability_matrix(m, z))
    assert poly.scale(1 / at_z[-1], at_z) == characteristic


def test_all_ways_to_the_stability_polynomial_agree():
    from glmref.theory.stability import _stage_by_stage, _through_stages, _through_values

    m = glmref.load("s4-symmetric")
    assert _through_stages(m) == _through_values(m)
    m = composition(sdirk("(3+sqrt(3))/6"), ["1/3", "2/5"])
    assert _through_stages(m) == _through_values(m) == _stage_by_stage(m)


@pytest.mark.parametrize("s", range(1, 6))
def test_gauss_is_a_stable_and_not_l_stable(s):
    m = runge_kutta(*gauss(s))
    assert is_a_stable(m) is True and is_l_stable(m) is False


@pytest.mark.parametrize(
    "method", [radau_iia(1), radau_iia(2), radau_iia(3), lobatto_iiic(2), lobatto_iiic(4)]
)
def test_radau_iia_and_lobatto_iiic_are_l_stable(method):
    assert is_l_stable(runge_kutta(*method)) is True


def test_lobatto_iiia_is_a_stable():
    assert is_a_stable(runge_kutta(*lobatto_iiia(4))) is True
    assert is_l_stable(runge_kutta(*lobatto_iiia(4))) is False


@pytest.mark.parametrize(("k", "expected"), [(1, True), (2, True), (3, False), (6, False)])
def test_bdf_is_a_stable_up_to_order_2(k, expected):
    m = linear_multistep(*bdf(k))
    assert is_a_stable(m) is expected and is_l_stable(m) is expected
    assert is_a_stable(one_leg(*one_leg_twin(*bdf(k)))) is expected


@pytest.mark.parametrize(("k", "expected"), [(0, True), (1, True), (2, False), (3, False)])
def test_adams_moulton_is_a_stable_up_to_order_2(k, expected):
    assert is_a_stable(linear_multistep(*adams_moulton(k))) is expected


@pytest.mark.parametrize(
    "m",
    [
        runge_kutta([["0"]], ["1"]),
        linear_multistep(*adams_bashforth(2)),
        linear_multistep(["-1", "0", "1"], ["0", "2", "0"]),
    ],
)
def test_explicit_methods_are_not_a_stable(m):
    found = a_stability(m)
    assert found.truth is False and "grows without bound" in found.reason


def test_sdirk_methods_are_a_stable_for_one_of_the_two_order_3_coefficients():
    # Norsett: A-stable for gamma = (3 + sqrt 3)/6, not for (3 - sqrt 3)/6
    assert is_a_stable(sdirk("(3+sqrt(3))/6")) is True
    found = a_stability(sdirk("(3-sqrt(3))/6"))
    assert found.truth is False and "modulus 2.73205" in found.reason


@pytest.mark.parametrize(("gamma", "expected"), [("1/4", True), ("249/1000", False), ("1", True)])
def test_a_stability_limit_of_order_2_sdirk_is_sharp(gamma, expected):
    # |R| <= 1 on the axis exactly for gamma >= 1/4 (Hairer and Wanner, IV.3)
    assert is_a_stable(sdirk(gamma)) is expected


def test_tr_bdf2_is_l_stable_although_its_first_stage_is_explicit():
    assert only_zeros(*leading_part(stability_polynomial(TR_BDF2)))
    assert is_l_stable(TR_BDF2) is True


def test_composition_with_a_negative_step_has_a_pole_on_the_left():
    found = a_stability(composition(runge_kutta(*gauss(1)), ["2", "-3", "2"]))
    assert found.truth is False and "pole" in found.reason


def test_g_symplectic_method_with_definite_form_is_a_stable_and_with_indefinite_form_not():
    assert is_a_stable(glmref.load("gsymplectic-p")) is True
    found = a_stability(glmref.load("gsymplectic-n"))
    assert found.truth is False and "z = 3 i" in found.reason


def test_behaviour_at_infinity_of_the_midpoint_rule():
    leading, unbounded = leading_part(stability_polynomial(runge_kutta(*gauss(1))))
    assert poly.monic(leading) == P(1, 1) and unbounded == 0  # M tends to -1


def test_published_decimals_are_open_with_a_reason():
    found = a_stability(glmref.load("s3-w3"))
    assert found.truth is None and "published decimals" in found.reason


def test_repeated_passenger_of_modulus_one_is_left_open():
    m = GLM(A=[["1"]], U=[["1", "0", "0"]], B=[["1"], ["0"], ["0"]],
            V=[["1", "0", "0"], ["0", "-1", "0"], ["0", "0", "-1"]])  # fmt: skip
    found = a_stability(m)
    assert found.truth is None and "may be multiple" in found.reason


def test_stability_function_is_for_one_step_methods():
    with pytest.raises(UsageError, match="r = 2"):
        stability_function(glmref.load("gsymplectic-n"))


def test_oscillator_of_verlet_has_trace_2_minus_y_squared():
    P = stability_polynomial(oscillator(splitting(["1/2", "1/2"], ["1"])))
    assert P == ((1,), (-2, 0, 1), (1,))


def test_oscillator_matches_the_step_by_hand():
    m = oscillator(splitting(["1"], ["1"], first="q"))  # symplectic Euler
    y = exact(Fraction(1, 3))
    M = stability_matrix(m, y)
    # q+ = q + y p, p+ = p - y q+
    assert M == ((1, y), (-y, 1 - y * y))


def shuffled(m, order):
    """The same method with its stages in another order."""
    A = [[m.A[i][j] for j in order] for i in order]
    return GLM(
        A=A, U=[m.U[i] for i in order], B=[[row[j] for j in order] for row in m.B], V=m.V
    )  # fmt: skip


def test_powers_and_values_give_the_same_polynomial_whatever_the_order_of_the_stages():
    halves = [f"{k}/28" for k in range(1, 8)], [f"{k}/21" for k in range(1, 7)]  # both sum to 1
    m = oscillator(splitting(*halves))
    assert m.s == 13
    assert _through_powers(m) == _through_values(m) == stability_polynomial(m)
    other = shuffled(m, [*range(1, 13, 2), *range(12, -1, -2)])
    assert _through_powers(other) == _through_powers(m)
    # near miss: one stage that needs itself, or two that need each other
    assert other.is_explicit
    itself = [[*row] for row in other.A]
    itself[3][3] = exact(1)
    each = [[*row] for row in other.A]
    i, j = next((i, j) for i in range(13) for j in range(13) if not other.A[i][j].is_zero())
    each[j][i] = exact(1)
    assert not other.bare(A=itself).is_explicit
    assert not other.bare(A=each).is_explicit


@pytest.mark.slow
def test_published_decimals_keep_their_digits_through_49_stages():
    m = oscillator(glmref.load("pair-8-24"))
    assert m.s == 49
    radii = [x.ball().radius() for p in _through_powers(m) for x in p]
    # 75 digits, amplified by at most 1e15 in products of matrices with entries below 100
    assert max(radii) < 1e-60


def test_only_a_power_of_w_at_infinity_has_zeros_only():
    for leading, unbounded, zeros in (
        ((0, 0, 1), 0, True), ((0, 0, 1), 1, False), ((0, 1, 1), 0, False), ((1, 0, 1), 0, False),
        ((3,), 0, True),
    ):  # fmt: skip
        assert only_zeros(tuple(map(exact, leading)), unbounded) is zeros


def P(*coefficients):
    return poly.trim([exact(x) for x in coefficients])


def test_the_reduction_of_schur_and_cohn_decides_like_the_roots():
    i = exact(-1).sqrt()
    values = [exact(0), exact(1), exact(-1), exact(Fraction(1, 2)), 2 * i, i, exact(3), -i / 3]
    for roots in [*combinations_with_replacement(values, 2), *combinations(values, 3),
                  (i, i, -i, -i), (2 * i, i / 2, exact(1)), (i, i, exact(3))]:  # fmt: skip
        q = tuple((x,) for x in poly.from_roots(roots))
        inside = all(d is not None and (not d or d[0].sign() >= 0) for d in schur_cohn(q))
        assert inside is all((x * x.conjugate() - 1).sign() <= 0 for x in roots)


def test_the_differences_of_the_reduction_are_polynomials_along_the_axis():
    # w^2 - y w + 4 y^2: 1 - 16 y^4, then (1 - 4 y^2)^2 ((1 + 4 y^2)^2 - y^2) without what divides
    first, second = schur_cohn((P(0, 0, 4), P(0, -1), P(1)))
    assert first == P(1, 0, 0, 0, -16)
    for y in (Fraction(1, 3), Fraction(1), Fraction(2, 5)):
        truth = (1 - 16 * y**4) ** 2 - (y * (1 - 4 * y**2)) ** 2
        assert poly.evaluate(second, y) == truth
    assert list(schur_cohn((P(2), P(1)))) == [P(-3)] and list(schur_cohn((P(-1), P(1)))) == []
    assert list(schur_cohn((P(), P(), P(1, 1)))) == []
    assert list(schur_cohn((P(1), P(1, 2), P(-1)))) == [None]


def test_what_divides_all_coefficients_is_divided_out():
    a, b, factor = P(1, 2), P(-3, 0, 1), P(1, 1)
    q = (poly.mul(a, factor), poly.mul(b, factor))
    assert divided(q, factor) == (a, b)
    assert divided(q, P(2, 1)) == q and divided(q, P(7)) == q
    assert size_difference(P(1, 2), P(0, 3)) == P(1, 4, -5)
    assert is_mirror_image((P(1), P(0, 3), P(1))) and not is_mirror_image((P(1), P(0, 3), P(2)))
    assert vanishes_at_inverse(P(-1, 2), exact(2)) and not vanishes_at_inverse(P(-1, 2), exact(1))
    leading, unbounded = leading_part((P(1, 0, 5), P(3), P(0, 0, 2), P(1, 1)))
    assert leading == P(5, 0, 2) and unbounded == 1


def test_a_pole_that_cancels_leaves_the_stability_function_of_what_is_left():
    lower = glmref.from_rk([["1/2", 0], [0, "1/3"]], [1, 0])
    full = glmref.from_rk([["1/2", 0, 0], [0, "1/3", "1/7"], [0, "1/5", "1/3"]], [1, 0, 0])
    for m in (lower, full):
        numerator, denominator = stability_function(m)
        assert (numerator, denominator) == (P(1, Fraction(1, 2)), P(1, Fraction(-1, 2)))


def test_the_curvature_is_asked_of_explicit_pairs_with_the_eigenvalues_1_and_minus_1():
    with pytest.raises(UsageError, match="must carry two values of q and two of p"):
        parasitic_curvature(splitting(["1"], ["1"], first="q"))
    with pytest.raises(UsageError, match="must be explicit"):
        parasitic_curvature(glmref.load("gsymplectic-n-pair"))
