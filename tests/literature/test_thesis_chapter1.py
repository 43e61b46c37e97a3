"""Khan (2018), sections 1.0 to 1.2: differential equations and Hamiltonian systems, as printed."""

from fractions import Fraction
from math import factorial

import pytest

from glmref.exact import exact, linalg
from glmref.method import GLM

from .exactly import (
    J,
    dot,
    grid,
    has_a_form,
    is_g_symplectic,
    matrix,
    order,
    same,
    symplectic_defect,
    vanishes,
)
from .exactly import vector as vec
from .thesis import D_N, G_N, euler, method_n, one_value, order4


def test_highest_derivative_on_the_right_leaves_two_solutions_through_one_point() -> None:
    # y' = f(x, y, y') with f = (y')^2, as the printed form allows: y = 0 and y = x both solve it
    # and both pass through the origin. With f = f(x, y) a Lipschitz f has one solution.
    for slope in (Fraction(0), Fraction(1)):
        assert slope == slope**2
    assert Fraction(2) != Fraction(2) ** 2


def test_euler_form_has_order_exactly_1() -> None:
    assert order(euler()) == 1


def test_runge_kutta_form_is_the_general_linear_form_with_one_value() -> None:
    # y_n = y_{n-1} + h sum b_i f(Y_i): U and V are ones; leaving y_{n-1} out is not preconsistent.
    heun = one_value([["0", "0"], ["1", "0"]], ["1/2", "1/2"])
    assert order(heun) == 2
    without = GLM(A=heun.A, U=[["0"], ["0"]], B=heun.B, V=heun.V)
    assert linalg.matvec(without.U, (exact(1),)) != (exact(1), exact(1))


def test_multistep_form_with_the_adams_coefficients_has_the_adams_order() -> None:
    # values y_{n+1}, h f_n of sum alpha_m y_{n+m} = h sum b_m f_{n+m}, alpha = (0, -1, 1).
    adams2 = GLM(
        A=[["0"]], U=[["1", "0"]], B=[["3/2"], ["1"]], V=[["1", "-1/2"], ["0", "0"]], name="AB2"
    )
    assert order(adams2) == 2


def test_stage_derivatives_number_s_and_not_r() -> None:
    # The printed vector ends in h f(Y_r). For (3.8), s = 4 and r = 3: B takes four slopes.
    method = order4()
    assert (method.s, method.r) == (4, 3)
    linalg.matvec(method.B, vec([1] * method.s))
    with pytest.raises(ValueError, match="zip"):
        linalg.matvec(method.B, vec([1] * method.r))


def test_printed_first_entry_of_the_slope_vector_breaks_consistency() -> None:
    # y' = 1, y(0) = 2, Euler: y + h f(Y) = y + h is exact; the printed h Y gives y + 2 h.
    start, h = Fraction(2), Fraction(1, 10)
    assert start + h * 1 == start + h
    assert start + h * start != start + h


def test_printed_two_value_stage_equations_are_not_g_symplectic() -> None:
    # Both printed stages use u11 y1 + a12 y2. With the coefficients of N: U = [[1, 0], [1, 0]].
    n = method_n()
    printed = GLM(A=n.A, U=[["1", n.A[0][1]], ["1", n.A[0][1]]], B=n.B, V=n.V)
    assert is_g_symplectic(n, G_N, D_N)
    assert not has_a_form(printed)
    assert (order(n), order(printed)) == (4, 3)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_hamilton_equations_are_j_inverse_times_the_gradient(n: int) -> None:
    # (1.3), (1.4) with y = (p, q): p' = -H_q, q' = H_p, linear in the gradient (H_p, H_q).
    one, zero = linalg.identity(n), linalg.zeros(n, n)
    right = linalg.add(
        linalg.block_diagonal(zero, zero), linalg.scale(-1, J(n))
    )  # rows: p' = -H_q, q' = +H_p
    assert same(right[:n], tuple((*z, *(-x for x in i)) for z, i in zip(zero, one, strict=True)))
    assert same(linalg.inverse(J(n)), right)
    assert not same(J(n), right)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_energy_derivative_vanishes_because_j_inverse_is_skew(n: int) -> None:
    # (1.5): dH/dt = g^T J^-1 g with g the gradient, and a skew matrix gives zero for every g.
    back = linalg.inverse(J(n))
    assert same(back, linalg.scale(-1, linalg.transpose(back)))
    for gradient in grid(2 * n, 1):
        assert dot(vec(gradient), linalg.matvec(back, vec(gradient))).is_zero()


def rotation(cosine: object, sine: object) -> linalg.Matrix:
    """Flow of the harmonic oscillator on (p, q)."""
    return matrix([[cosine, f"-({sine})"], [sine, cosine]])


ANGLES = [("1/2", "sqrt(3)/2"), ("sqrt(3)/2", "1/2"), ("sqrt(2)/2", "sqrt(2)/2"), ("3/5", "4/5")]


@pytest.mark.parametrize(("cosine", "sine"), ANGLES)
def test_symplectic_flow_does_not_conserve_the_product_of_p_and_q(cosine: str, sine: str) -> None:
    flow = rotation(cosine, sine)
    p, q = vec([2, 1])
    p_next, q_next = linalg.matvec(flow, (p, q))
    assert vanishes(symplectic_defect(flow))
    assert p_next * q_next != p * q


def test_unit_determinant_is_symplectic_for_one_degree_of_freedom() -> None:
    # X^T J X = det(X) J for every 2 x 2 matrix: degree at most 2 in each of the four entries.
    for a, b, c, d in grid(4, 2):
        X = matrix([[a, b], [c, d]])
        assert same(
            linalg.matmul(linalg.transpose(X), J(1), X), linalg.scale(exact(a * d - b * c), J(1))
        )


def test_unit_determinant_is_not_symplectic_for_two_degrees_of_freedom() -> None:
    X = linalg.diagonal(vec(["2", "2", "1/4", "1"]))
    assert X[0][0] * X[1][1] * X[2][2] * X[3][3] == 1
    assert not vanishes(symplectic_defect(X))
    assert vanishes(symplectic_defect(linalg.diagonal(vec(["2", "2", "1/2", "1/2"]))))


def test_three_of_four_entries_of_the_expanded_product_are_wrong() -> None:
    # section 1.2.2, with a = d phat/dp, b = d qhat/dp, c = d phat/dq, d = d qhat/dq.
    agree = [[True, True], [True, True]]
    for a, b, c, d in grid(4, 2):
        X = matrix([[a, b], [c, d]])
        product = linalg.matmul(linalg.transpose(X), J(1), X)
        printed = matrix([[a * b - c * b, a * d - c * d], [c * b - a * d, c * d - a * d]])
        D = a * d - b * c
        assert same(product, matrix([[0, D], [-D, 0]]))
        for i, j, x in linalg.entries(linalg.sub(product, printed)):
            agree[i][j] = agree[i][j] and x.is_zero() is True
    assert agree == [[False, False], [True, False]]


def test_oscillator_flow_is_the_rotation_and_symplectic_at_every_time() -> None:
    # R^T J R = (c^2 + s^2) J as polynomials in c = cos t and s = sin t, so J for every t.
    for c, s in grid(2, 2):
        R = matrix([[c, -s], [s, c]])
        assert same(
            linalg.matmul(linalg.transpose(R), J(1), R), linalg.scale(exact(c * c + s * s), J(1))
        )


def test_printed_oscillator_map_is_the_vector_field_and_the_flow_at_a_quarter_turn_only() -> None:
    printed = matrix([[0, -1], [1, 0]])
    assert same(printed, linalg.inverse(J(1)))  # the vector field J^-1 grad H, grad H = (p, q)
    assert same(printed, rotation("0", "1"))
    assert not any(same(printed, rotation(c, s)) for c, s in ANGLES)


@pytest.mark.parametrize("cosine", ["1", "1/2", "sqrt(3)/2", "0", "-1"])
def test_pendulum_map_multiplies_j_by_the_cosine(cosine: str) -> None:
    # gamma' = [[0, -cos q], [1, 0]] at q = 0, pi/3, pi/6, pi/2, pi: symplectic at q = 0 only.
    derivative = matrix([[0, f"-({cosine})"], [1, 0]])
    product = linalg.matmul(linalg.transpose(derivative), J(1), derivative)
    value = matrix([[cosine]])[0][0]
    assert same(product, linalg.scale(value, J(1)))
    assert vanishes(symplectic_defect(derivative)) is (value == 1)


def test_pendulum_field_satisfies_the_condition_for_a_symplectic_flow() -> None:
    # f'^T J + J f' = 0, degree 1 in cos q; a damped pendulum p' = -sin q - p breaks it.
    for (cosine,) in grid(1, 1):
        for damping in (0, 1):
            field = matrix([[-damping, -cosine], [1, 0]])
            sum_ = linalg.add(
                linalg.matmul(linalg.transpose(field), J(1)), linalg.matmul(J(1), field)
            )
            assert vanishes(sum_) is (damping == 0)


def test_pendulum_energy_gives_the_pendulum_equations() -> None:
    # H = p^2/2 - cos q: the Taylor coefficients of dH/dq are those of sin q, through q^20.
    degree = 20
    cosine = [Fraction((-1) ** (k // 2), factorial(k)) * (k % 2 == 0) for k in range(degree + 2)]
    sine = [Fraction((-1) ** (k // 2), factorial(k)) * (k % 2) for k in range(degree + 1)]
    derivative = [-(k + 1) * cosine[k + 1] for k in range(degree + 1)]
    assert derivative == sine
    assert [-x for x in derivative] != sine  # the other sign of cos q fails


def test_quadratic_invariant_needs_its_matrix_in_the_condition() -> None:
    # H = (p^2 + 4 q^2)/2: C = diag(1, 4)/2 gives y^T C f = 0, and <y, f> does not vanish.
    for p, q in grid(2, 2):
        y, field = vec([p, q]), vec([-4 * q, p])
        C = linalg.diagonal(vec(["1/2", "2"]))
        assert dot(y, linalg.matvec(C, field)).is_zero()
        assert dot(y, field).is_zero() is (p * q == 0)


def test_both_printed_matrices_of_the_oscillator_invariant_satisfy_the_condition() -> None:
    # The text defines C = diag(1/2, 1/2) and then uses the identity: they differ by the factor 1/2.
    for p, q in grid(2, 2):
        for entry in ("1/2", "1"):
            C = linalg.diagonal(vec([entry, entry]))
            assert dot(vec([p, q]), linalg.matvec(C, vec([-q, p]))).is_zero()
