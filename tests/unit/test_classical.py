"""Classical families: what defines each of them, exactly."""

from fractions import Fraction

import pytest

from glmref.exact import Exact
from glmref.exact.linalg import dot
from tests.classical import collocation, gauss, lobatto_iiia, lobatto_iiib, lobatto_iiic, radau_iia


def quadrature_order(A, b):
    """Largest p with ``sum b_i c_i^(k-1) = 1/k`` for k up to p."""
    c = [sum(row, Exact(0)) for row in A]
    p = 0
    while dot(b, [x**p for x in c]) == Fraction(1, p + 1):
        p += 1
    return p


def stage_order(A):
    """Largest q with ``sum_j a_ij c_j^(k-1) = c_i^k/k`` for k up to q (checked up to 8)."""
    c = [sum(row, Exact(0)) for row in A]
    q = 0
    while q < 8 and all(
        dot(row, [x**q for x in c]) == y ** (q + 1) / (q + 1) for row, y in zip(A, c, strict=True)
    ):
        q += 1
    return q


@pytest.mark.parametrize("s", range(1, 6))
def test_gauss_has_quadrature_order_2s_and_stage_order_s(s):
    A, b = gauss(s)
    assert quadrature_order(A, b) == 2 * s
    assert stage_order(A) == s


@pytest.mark.parametrize("s", range(1, 4))
def test_radau_iia_has_quadrature_order_2s_minus_1_and_is_stiffly_accurate(s):
    A, b = radau_iia(s)
    assert quadrature_order(A, b) == 2 * s - 1
    assert A[-1] == b


@pytest.mark.parametrize("s", range(2, 7))
def test_lobatto_methods_satisfy_what_defines_them(s):
    A, b = lobatto_iiia(s)
    B_A, _ = lobatto_iiib(s)
    C_A, _ = lobatto_iiic(s)
    assert quadrature_order(A, b) == 2 * s - 2
    assert A[-1] == b and all(x == 0 for x in A[0])
    assert all(row[0] == b[0] for row in B_A) and all(row[-1] == 0 for row in B_A)
    assert all(row[0] == b[0] for row in C_A) and C_A[-1] == b
    assert stage_order(A) == s and stage_order(C_A) == s - 1


def test_lobatto_iiib_3_is_the_printed_tableau():
    A, _ = lobatto_iiib(3)
    sixth, third = Fraction(1, 6), Fraction(1, 3)
    assert [list(row) for row in A] == [
        [sixth, -sixth, 0],
        [sixth, third, 0],
        [sixth, Fraction(5, 6), 0],
    ]


def test_collocation_at_the_ends_is_the_trapezoidal_rule():
    A, b = collocation([Exact(0), Exact(1)])
    assert A == ((0, 0), (Fraction(1, 2), Fraction(1, 2))) and b == A[1]
