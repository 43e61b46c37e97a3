"""Eigenvalues on the unit circle and power-boundedness."""

from fractions import Fraction as F
from math import gcd

import pytest

from glmref.errors import ExactnessError
from glmref.exact import Ball, exact, root_of_unity
from glmref.exact.expression import parse
from glmref.exact.linalg import block_diagonal, diagonal, dot, matvec, vecmat
from glmref.method import as_matrix
from glmref.theory import polynomials as poly
from glmref.theory.spectrum import Boundedness, eigenvectors, power_bounded, unimodular_eigenvalues
from tests.build import refused


@pytest.mark.parametrize("n", [3, 5, 8, 10, 12])
def test_roots_of_unity_are_found_in_fields_that_hold_them(n):
    """All of one order but the first, beside an irrational number: no polynomial is rational."""
    turns = [root_of_unity(k, n) for k in range(2, n) if gcd(k, n) == 1]
    found = unimodular_eigenvalues(diagonal([*turns, exact(2).sqrt() - 1]))
    assert [e.value for e in found] == turns


def test_eigenvectors_are_scaled_to_each_other():
    V = as_matrix([["1", "1"], ["0", "-1"]], "V")
    (w,), (v,) = eigenvectors(V, exact(-1))
    assert matvec(V, v) == tuple(-x for x in v) and vecmat(w, V) == tuple(-x for x in w)
    assert dot(w, v) == 1


def test_published_decimals_leave_the_eigenvalues_open():
    V = ((Ball.decimal("0.5", 20),),)
    assert power_bounded(V).holds is None
    refused(ExactnessError, "exact entries only", unimodular_eigenvalues, V)


def test_multiple_eigenvalues_with_all_their_eigenvectors_are_bounded():
    nil, shear, quarter, rotation = (
        as_matrix(V, "V")
        for V in ([["0", "1"], ["0", "0"]], [["1", "1"], ["0", "1/2"]], [["0", "-1"], ["1", "0"]],
                  [["3/5", "-4/5"], ["4/5", "3/5"]])
    )  # fmt: skip
    for V in (nil, shear, block_diagonal(quarter, quarter), block_diagonal(rotation, rotation),
              block_diagonal(rotation, nil), diagonal([exact(x) for x in (1, 1, -1, -1, 0, 0)])):  # fmt: skip
        assert power_bounded(V) == Boundedness(True, "")


def test_four_eigenvalues_of_a_palindromic_polynomial_are_found():
    # (w^2 - 6 w/5 + 1)(w^2 + 10 w/13 + 1): the roots have modulus 1 and are no roots of unity
    p = poly.mul(
        tuple(map(exact, (1, F(-6, 5), 1))), tuple(map(exact, (1, F(10, 13), 1)))
    )  # fmt: skip
    companion = tuple(
        tuple(exact(int(j == i + 1)) if i < 3 else -p[j] for j in range(4)) for i in range(4)
    )
    i = exact(-1).sqrt()
    found = unimodular_eigenvalues(companion)
    expected = [(3 + 4 * i) / 5, (-5 + 12 * i) / 13, (-5 - 12 * i) / 13, (3 - 4 * i) / 5]
    assert [(e.value, e.multiplicity) for e in found] == [(x, 1) for x in expected]


def test_mirrored_eigenvalues_off_the_circle_are_left_out():
    rotation = as_matrix([["3/5", "-4/5"], ["4/5", "3/5"]], "V")
    i = exact(-1).sqrt()
    found = unimodular_eigenvalues(block_diagonal(rotation, diagonal([exact(2), exact(F(1, 2))])))
    assert [e.value for e in found] == [(3 + 4 * i) / 5, (3 - 4 * i) / 5]
    assert unimodular_eigenvalues(diagonal([exact(2), exact(F(1, 2))])) == ()
    turns = [
        as_matrix([[f"{a}/{c}", f"-{b}/{c}"], [f"{b}/{c}", f"{a}/{c}"]], "V")
        for a, b, c in ((3, 4, 5), (5, 12, 13), (8, 15, 17))
    ]
    with pytest.raises(ExactnessError, match="6 eigenvalues of modulus 1 that are neither"):
        unimodular_eigenvalues(block_diagonal(*turns))


@pytest.mark.parametrize("turns", [
    ["3+4*i"], ["3+4*i", "3-4*i"], ["3+4*i", "3+4*i"], ["3+4*i", "5-12*i"],
    ["3+4*i", "3-4*i", "5+12*i", "5-12*i"],
])  # fmt: skip
def test_values_of_modulus_one_that_were_put_in_are_found(turns):
    values = [x / (x * x.conjugate()).sqrt() for x in map(parse, turns)]
    V = [list(row) for row in diagonal([exact(1), exact(F(1, 2)), *values])]
    V[0][2] = exact(7)  # not diagonal, with the same eigenvalues
    found = unimodular_eigenvalues(as_matrix(V, "V"))
    assert sum(e.multiplicity for e in found) == 1 + len(values)
    for e in found:
        assert e.multiplicity == [exact(1), *values].count(e.value) > 0
    assert power_bounded(as_matrix(V, "V")).holds is True
    V[2][0] = exact(2)  # with 7 beyond the diagonal, an eigenvalue outside of the circle
    assert power_bounded(as_matrix(V, "V")).holds is False
