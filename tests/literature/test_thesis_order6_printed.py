"""Khan (2018), section 3.4 from (3.18) on: the printed W, A, U and claims of the order-6 method."""

from fractions import Fraction
from itertools import pairwise

import pytest

from glmref.exact import exact, linalg
from glmref.exact.linalg import Matrix

from .exactly import determinant, dot, matrix, order, same, vector
from .thesis import (
    A6_PRINTED,
    B6,
    C6,
    W6_HAT_PRINTED,
    W6_PRINTED,
    W6_TILDE_PRINTED,
    a_of,
    one_value,
)

W, A, B, C = W6_PRINTED, A6_PRINTED, B6, C6
C2 = Fraction(1, 15)


def test_printed_w_satisfies_3_18_3_19_3_20_and_the_printed_3_22() -> None:
    assert W[0][0] == 1
    assert B[0] * (1 - W[0][1]) == C2 / 2
    assert B[1] * (1 - W[1][1]) == C2
    assert B[2] * (1 - W[2][2]) == C2
    assert B[2] * (1 - W[2][2]) != 1 - 2 * C2


def test_3_22_must_give_1_minus_2_c2_for_the_parasitism_sum_to_vanish() -> None:
    # sum b_i W_ii = sum b (|omega|^2 - gamma^2) = 0 with W_11 = W_55 = 1 and (3.20):
    # 2 b1 + 2 (b2 - c2) + b3 - b3 (1 - W33) = 0 and sum b = 1.
    needed = 2 * B[0] + 2 * (B[1] - C2) + B[2]
    assert needed == 1 - 2 * C2
    assert sum((B[i] * W[i][i] for i in range(5)), exact(0)) == Fraction(4, 5)
    assert Fraction(4, 5) == 1 - 2 * C2 - C2  # the gap is that of the two right sides


def test_five_printed_pairs_of_3_21_leave_w_41_and_w_52_free() -> None:
    printed = [(4, 3), (4, 4), (5, 3), (5, 4), (5, 5)]
    assert all(W[i - 1][j - 1] == W[5 - i][5 - j] for i, j in printed)
    unequal = [
        (i, j) for i in range(1, 6) for j in range(1, i + 1) if W[i - 1][j - 1] != W[5 - i][5 - j]
    ]
    assert unequal == [(4, 1), (5, 2)]


def test_printed_w_is_not_symmetric_about_the_other_diagonal() -> None:
    assert all(x == W[j][i] for i, j, x in linalg.entries(W))
    assert W[3][0] == Fraction(-466429841, 745875)
    assert W[4][1] == Fraction(36946367, 57375)
    assert W[3][0] != W[4][1]


def stage_sums(A: Matrix) -> tuple[list[Fraction | None], list[Fraction | None]]:
    """Left sides of (3.23) and (3.24) for i = 3, 4, 5."""
    rows = [A[i] for i in (2, 3, 4)]
    first = [dot(row, vector([1] * 5)) for row in rows]
    second = [dot(row, C) for row in rows]
    return [x.as_fraction() for x in first], [x.as_fraction() for x in second]


def test_printed_w_fails_3_23_and_3_24() -> None:
    first, second = stage_sums(a_of(W))
    assert first == [Fraction(1, 2), Fraction(34069669, 1711125), 1]
    assert second == [Fraction(1, 2), Fraction(16924562, 1711125), 1]
    assert [c.as_fraction() for c in C[2:]] == [Fraction(1, 2), Fraction(14, 15), 1]
    assert [Fraction(x) ** 2 / 2 for x in ("1/2", "14/15", "1")] == [
        Fraction(1, 8),
        Fraction(98, 225),
        Fraction(1, 2),
    ]
    # for i = 3 and 5 the right side used was c_i itself
    assert (second[0], second[2]) == (Fraction(1, 2), 1)


def test_printed_a_is_that_of_the_printed_w_except_a31() -> None:
    differing = [
        (i + 1, j + 1) for i, j, x in linalg.entries(linalg.sub(a_of(W), A)) if not x.is_zero()
    ]
    assert differing == [(3, 1)]
    assert a_of(W)[2][0] == Fraction(-407, 60)
    assert A[2][0] == Fraction(691, 105)


def test_printed_w_has_rank_5_where_alpha_beta_gamma_give_at_most_3() -> None:
    assert linalg.rank(W) == 5
    three = matrix([[1, 2, 3], [0, 1, 5], [2, 2, 1], [7, 0, 1], [1, 1, 1]])
    signs = linalg.diagonal(vector([1, 1, -1]))
    assert linalg.rank(linalg.matmul(three, signs, linalg.transpose(three))) == 3


def test_eigenvalues_of_the_printed_w_lie_in_five_intervals() -> None:
    # det(W - x I) changes sign across each; five sign changes are all the roots of degree 5.
    ends = ["-2159", "-2158.8", "-39.3", "-39.2", "0.2", "0.21", "37.9", "38", "2164.4", "2164.6"]
    signs = []
    for end in ends:
        shift = linalg.scale(exact(Fraction(end)), linalg.identity(5))
        signs.append(determinant(linalg.sub(W, shift)).sign())
    brackets = list(zip(signs[::2], signs[1::2], strict=True))
    assert all(left == -right != 0 for left, right in brackets)
    assert all(a[1] == b[0] for a, b in pairwise(brackets))  # and no change in between


GAMMA_HAT = matrix([["1/2", 0], [0, "1/2"], [0, 0], [0, "-1/2"], ["-1/2", 0]])
GAMMA_TILDE = matrix([["1/2", 0, 0], [0, "1/2", 0], [0, 0, 1], [0, "1/2", 0], ["1/2", 0, 0]])


def test_printed_hat_and_tilde_matrices_follow_from_the_printed_w() -> None:
    hat = linalg.matmul(linalg.transpose(GAMMA_HAT), W, GAMMA_HAT)
    tilde = linalg.matmul(linalg.transpose(GAMMA_TILDE), W, GAMMA_TILDE)
    assert same(hat, W6_HAT_PRINTED)
    assert same(tilde, W6_TILDE_PRINTED)
    with pytest.raises(ValueError, match="zip"):
        linalg.matmul(GAMMA_TILDE, W)  # the printed factor order for the second


def test_printed_hat_matrix_is_indefinite_of_rank_2_where_rank_1_is_needed() -> None:
    # printed as alphatilde alphatilde^T, with alphahat defined: gammahat^T leaves alphahat of alpha
    # and nothing of beta and gamma
    take = linalg.transpose(GAMMA_HAT)
    alpha, even = vector([2, 5, 0, -5, -2]), vector([2, 5, 7, 5, 2])
    assert [x.as_fraction() for x in linalg.matvec(take, alpha)] == [2, 5]
    assert [x.as_fraction() for x in linalg.matvec(take, even)] == [0, 0]
    hat = W6_HAT_PRINTED
    value = determinant(hat)
    assert value == Fraction(-55795492455172729, 556329515625)
    assert linalg.rank(hat) == 2
    assert hat[0][0].sign() == -1  # alpha_1^2 would be negative
    for low, high in (("-976.5", "-976.4"), ("102.6", "102.8")):
        ends = [
            determinant(
                linalg.sub(hat, linalg.scale(exact(Fraction(x)), linalg.identity(2)))
            ).sign()
            for x in (low, high)
        ]
        assert ends[0] == -ends[1]


def test_printed_tilde_matrix_has_rank_3_where_rank_2_is_needed() -> None:
    assert linalg.rank(W6_TILDE_PRINTED) == 3


def test_printed_weights_and_a_fail_the_second_order_condition() -> None:
    # (3.23) makes A 1 the abscissae, so that b^T A 1 = 1/2 is the condition of order 2.
    for used in (A, a_of(W)):
        sums = linalg.matvec(used, vector([1] * 5))
        assert dot(B, sums) != Fraction(1, 2)
    good = one_value([["1/2"]], ["1"])
    assert dot(good.B[0], linalg.matvec(good.A, vector([1]))) == Fraction(1, 2)


def test_printed_a_and_b_alone_have_order_exactly_1() -> None:
    assert order(one_value(A, B)) == 1
    assert order(one_value(a_of(W), B)) == 1
