"""Khan (2018), section 3.4 up to (3.17): the construction of order 6, as printed."""

import random
from fractions import Fraction

import pytest

from glmref.exact import Exact, exact, linalg, root_of_unity
from glmref.exact.linalg import Matrix, Vector
from glmref.method import GLM
from glmref.theory.order import order_of
from glmref.theory.series import Series, compose

from .exactly import (
    after_step,
    component,
    dot,
    first_difference,
    g_symplectic_defects,
    is_g_symplectic,
    matrix,
    order,
    same,
    vector,
)
from .thesis import B6, C6, ZETA3, gamma_matrix, order6, real_form, sweep

I = exact(-1).sqrt()
G6 = linalg.diagonal(vector(["1", "-1/2", "-1/2", "1"]))
Parts = tuple[Vector, Vector, Vector, Vector]


def random_parts(seed: int) -> Parts:
    """Random rational b, alpha, beta, gamma of five stages, without the symmetry pattern."""
    numbers = random.Random(seed)

    def five() -> Vector:
        return vector([Fraction(numbers.choice([-3, -2, -1, 1, 2, 5]), 7) for _ in range(5)])

    return five(), five(), five(), five()


def method_of(parts: Parts, z: Exact = ZETA3) -> GLM:
    """The sweep method of b, alpha, beta, gamma."""
    b, alpha, beta, gamma = parts
    return sweep(b, tuple(x + I * y for x, y in zip(alpha, beta, strict=True)), gamma, z)


def parts_of(method: GLM) -> Parts:
    """b, alpha, beta, gamma of a sweep method."""
    b = method.B[0]
    omega = [x / w for x, w in zip(method.B[1], b, strict=True)]
    gamma = tuple(x / w for x, w in zip(method.B[3], b, strict=True))
    return b, tuple(w.real for w in omega), tuple(w.imag for w in omega), gamma


def products(parts: Parts) -> Matrix:
    """W of (3.17): alpha alpha^T + beta beta^T - gamma gamma^T."""
    _, a, c, g = parts
    return tuple(tuple(a[i] * a[j] + c[i] * c[j] - g[i] * g[j] for j in range(5)) for i in range(5))


@pytest.mark.parametrize("z", [ZETA3, root_of_unity(1, 4)])
def test_printed_u_b_and_d_follow_from_3_10_and_3_11(z: Exact) -> None:
    # U columns 1, conj(omega) g z, omega g conj(z), -gamma; D = diag(b); B = X D.
    parts = random_parts(1)
    b, alpha, beta, gamma = parts
    method, g = method_of(parts, z), Fraction(-1, 2)
    omega = [x + I * y for x, y in zip(alpha, beta, strict=True)]
    printed = [
        [exact(1), w.conjugate() * z * g, w * z.conjugate() * g, -c]
        for w, c in zip(omega, gamma, strict=True)
    ]
    assert same(method.U, matrix(printed))
    assert is_g_symplectic(method, G6, b)
    first, second, _ = g_symplectic_defects(method, G6, [x * 2 for x in b])
    assert not same(second, linalg.zeros(5, 4))
    assert same(first, linalg.zeros(4, 4))


def test_chosen_g_becomes_a_real_diagonal_by_gamma() -> None:
    gamma = gamma_matrix(1)
    real = linalg.matmul(linalg.conjugate_transpose(gamma), G6, gamma)
    assert same(real, linalg.diagonal(vector(["1", "-1/4", "-1/4", "1"])))
    assert real_form(order6()).is_real


def test_symmetry_relations_of_u_exchange_the_two_complex_columns() -> None:
    # Printed: u_52 = u_12, u_53 = u_13. Right: u_(6-i)2 = -z^2 u_i3, u_(6-i)3 = -conj(z)^2 u_i2.
    z, U = ZETA3, order6().U
    for i in range(5):
        mirrored, row = U[4 - i], U[i]
        assert mirrored[1] == -z * z * row[2]
        assert mirrored[2] == -z.conjugate() * z.conjugate() * row[1]
        assert mirrored[3] == row[3]
    assert U[4][1] != U[0][1]
    assert U[4][2] != U[0][2]
    assert U[3][1] != U[3][2]  # the printed u_42 = u_43


def test_printed_sign_of_beta_5_contradicts_3_21() -> None:
    parts = parts_of(order6())
    b, alpha, beta, gamma = parts
    assert beta[4] == beta[0] and alpha[4] == -alpha[0] and gamma[4] == gamma[0]
    assert beta[3] == beta[1] and alpha[3] == -alpha[1] and gamma[3] == gamma[1]
    assert alpha[2].is_zero()
    W = products(parts)
    assert all(x == W[4 - i][4 - j] for i, j, x in linalg.entries(W))
    printed = products((b, alpha, (*beta[:4], -beta[4]), gamma))
    assert printed[4][3] != printed[0][1]


def test_printed_list_of_a_ij_solves_3_12() -> None:
    # a_ij = (1 + conj(w_i) w_j g + w_i conj(w_j) g + c_i c_j) b_j, with 1/2 on the diagonal.
    b, alpha, beta, gamma = parts = random_parts(2)
    g, omega = Fraction(-1, 2), [x + I * y for x, y in zip(alpha, beta, strict=True)]
    printed = [[exact(0)] * 5 for _ in range(5)]
    for i in range(5):
        for j in range(i):
            cross = omega[i].conjugate() * omega[j] + omega[i] * omega[j].conjugate()
            printed[i][j] = (1 + cross * g + gamma[i] * gamma[j]) * b[j]
        square = omega[i] * omega[i].conjugate()
        printed[i][i] = (1 + square * g * 2 + gamma[i] * gamma[i]) * b[i] / 2
    assert same(method_of(parts).A, matrix(printed))
    # (3.12) is printed with A^T where general complex methods need A*: A is real, as b is
    assert all(x.is_real() for row in method_of(parts).A for x in row)
    assert not all(x.is_real() for row in method_of(parts).U for x in row)


def test_3_14_is_right_below_the_diagonal_and_3_15_lacks_one_half() -> None:
    b, *_ = parts = random_parts(3)
    method, W = method_of(parts), products(parts)
    below = all(method.A[i][j] == b[j] * (1 - W[i][j]) for i in range(5) for j in range(i))
    halves = all(method.A[i][i] == b[i] * (1 - W[i][i]) / 2 for i in range(5))
    assert below and halves
    printed = tuple(
        tuple(x * 2 if i == j else x for j, x in enumerate(row)) for i, row in enumerate(method.A)
    )
    assert not is_g_symplectic(method.bare(A=printed), G6, b)


def test_the_sum_in_3_17_carries_the_signs_of_g() -> None:
    # W = X^* (-G) X on the rows alpha, beta, gamma: with + gamma gamma^T (3.12) fails.
    b, _, _, gamma = parts = random_parts(4)
    W = products(parts)
    other = tuple(
        tuple(x + 2 * gamma[i] * gamma[j] for j, x in enumerate(row)) for i, row in enumerate(W)
    )
    A = method_of(parts).A
    assert A[4][0] == b[0] * (1 - W[4][0])
    assert A[4][0] != b[0] * (1 - other[4][0])


def test_printed_abscissae_and_weights_have_quadrature_order_exactly_6() -> None:
    moments = [dot(B6, [c**k for c in C6]) for k in range(7)]
    assert all(m == Fraction(1, k + 1) for k, m in enumerate(moments[:6]))
    assert moments[6] == Fraction(3839, 27000)


def test_four_printed_abscissae_cannot_have_the_required_moments() -> None:
    # C = [0, c2, 1 - c2, 1] without 1/2, weights (b1, b2, b2, b1), c2 = 1/15: three conditions.
    def moments(nodes: list[str]) -> list[list[Exact]]:
        c = vector(nodes)
        half = len(c) // 2
        rows = []
        for k in (0, 2, 4):
            powers = [x**k for x in c]
            row = [powers[i] + powers[len(c) - 1 - i] for i in range(half)]
            rows.append(row + ([powers[half]] if len(c) % 2 else []))
        return rows

    right = [exact(1), exact(1) / 3, exact(1) / 5]
    four = moments(["0", "1/15", "14/15", "1"])
    five = moments(["0", "1/15", "1/2", "14/15", "1"])
    assert (
        linalg.rank(four) == 2
        and linalg.rank([[*row, x] for row, x in zip(four, right, strict=True)]) == 3
    )  # no solution
    solution = linalg.solve(tuple(map(tuple, five)), tuple((x,) for x in right))
    assert all(row[0] == b for row, b in zip(solution, B6, strict=False))


def test_summed_parasitism_equation_admits_a_method_that_grows() -> None:
    # b = (1/2, 1/2), omega = (1, -1), gamma = sqrt(1/2)(1, 1): the printed sum g (z + conj z)
    # sum b |omega|^2 - sum b gamma^2 = 1/2 - 1/2 vanishes; both growth parameters are nonzero.
    b, omega = vector(["1/2", "1/2"]), vector(["1", "-1"])
    gamma = vector(["sqrt(1/2)", "sqrt(1/2)"])
    method = sweep(b, omega, gamma, ZETA3)
    BU = linalg.matmul(method.B, method.U)
    assert (BU[1][1] + BU[2][2] + BU[3][3]).is_zero()
    assert BU[1][1] / ZETA3 == Fraction(-1, 2)
    assert -BU[3][3] == Fraction(1, 2)


def test_parasitism_needs_both_sums_to_vanish_and_order_6_with_c2_one_third_has_them() -> None:
    method = order6()
    b, alpha, beta, gamma = parts_of(method)
    assert dot(b, [x * x + y * y for x, y in zip(alpha, beta, strict=True)]).is_zero()
    assert dot(b, [x * x for x in gamma]).is_zero()
    BU = linalg.matmul(method.B, method.U)
    assert all(BU[k][k].is_zero() for k in (1, 2, 3))


def printed_u(method: GLM) -> Matrix:
    """U as printed: columns -i/2 conj(omega), i/2 omega, -gamma, whatever z is."""
    _, alpha, beta, gamma = parts_of(method)
    omega = [x + I * y for x, y in zip(alpha, beta, strict=True)]
    return matrix(
        [
            [exact(1), w.conjugate() * I * Fraction(-1, 2), w * I * Fraction(1, 2), -c]
            for w, c in zip(omega, gamma, strict=True)
        ]
    )


def test_printed_u_is_right_for_z_equal_to_i() -> None:
    method = order6(root_of_unity(1, 4))
    assert same(method.U, printed_u(method))
    assert order(method) == 6


def test_printed_u_is_not_g_symplectic_for_the_chosen_z() -> None:
    method = order6()
    mixed = method.bare(U=printed_u(method), G=G6)
    assert not is_g_symplectic(mixed, G6, method.B[0])
    real = real_form(mixed)
    assert real.G is not None
    _, second, _ = g_symplectic_defects(real, real.G, method.B[0])
    assert 0.1761 < linalg.largest(second) < 0.1762


def test_printed_u_has_order_5_for_the_chosen_z_where_the_right_u_has_6() -> None:
    method = order6()
    assert order(method.bare(U=printed_u(method))) == 5
    assert order(method) == 6


def test_last_entry_of_the_printed_u_is_that_of_the_fifth_stage() -> None:
    # Printed -gamma_4 in the fifth row; by (3.11) it is -gamma_5.
    method = order6()
    gamma = parts_of(method)[3]
    assert method.U[4][3] == -gamma[4]
    assert gamma[4] != gamma[3]


@pytest.mark.slow
def test_same_construction_with_c2_one_third_is_symplectic_and_of_order_exactly_6() -> None:
    for z in (ZETA3, root_of_unity(1, 4)):
        method = order6(z)
        assert is_g_symplectic(method, G6, method.B[0])
        assert order(method) == 6
        assert order(method, "identity") == 6


@pytest.mark.slow
def test_enhanced_start_gains_one_order_in_each_pass() -> None:
    # S_{k+1} = S_k + (I - V)^-1 [M S_k - S_k((M S_k)_1)] on the components 2..4, as B-series on
    # all 37 trees: S_0 = (y, 0, 0, 0) is the starting series through order 2, S_4 through 6.
    method = real_form(order6())
    wanted = order_of(method, principal="identity").eta
    assert wanted is not None and wanted.order == 6
    rest = linalg.sub(linalg.identity(4), method.V)
    back = linalg.inverse(tuple(row[1:] for row in rest[1:]))
    u, nothing = vector([1, 0, 0, 0]), vector([0, 0, 0, 0])
    start = Series(dict.fromkeys(wanted, nothing), u, 6)
    for k in range(5):
        assert {first_difference(start, wanted, i) for i in (1, 2, 3)} == {3 + k}
        after = after_step(method, start)
        moved = compose(component(after, 0), start)
        values = {}
        for t in wanted:
            gap = [after[t][i] - moved[t][i] for i in (1, 2, 3)]
            pairs = zip(start[t][1:], linalg.matvec(back, gap), strict=True)
            values[t] = (exact(0), *(x + y for x, y in pairs))
        start = Series(values, u, 6)
