"""Eigenvalues on the unit circle and power-boundedness."""

import pytest

from glmref.errors import ExactnessError
from glmref.exact import Ball, exact, root_of_unity
from glmref.exact.linalg import diagonal, dot, matvec, vecmat
from glmref.method import as_matrix
from glmref.method.families import bdf, linear_multistep
from glmref.theory.spectrum import eigenvectors, power_bounded, unimodular_eigenvalues


def test_eigenvalues_come_by_increasing_argument():
    values = [root_of_unity(k, 8) for k in (7, 4, 0, 1)] + [exact(0)]
    found = unimodular_eigenvalues(diagonal(values))
    assert [e.value for e in found] == [root_of_unity(k, 8) for k in (0, 1, 4, 7)]


def test_eigenvalues_that_are_no_roots_of_unity_are_found():
    # rotation by arccos(3/5): of modulus one, and no root of unity
    found = unimodular_eigenvalues(as_matrix([["3/5", "-4/5"], ["4/5", "3/5"]], "V"))
    i = exact(-1).sqrt()
    assert [e.value for e in found] == [(3 + 4 * i) / 5, (3 - 4 * i) / 5]


def test_multiplicities_are_counted():
    V = as_matrix([["1", "1", "0"], ["0", "1", "0"], ["0", "0", "-1"]], "V")
    assert [(float(e.value), e.multiplicity) for e in unimodular_eigenvalues(V)] == [
        (1, 2),
        (-1, 1),
    ]


def test_eigenvectors_are_scaled_to_each_other():
    V = as_matrix([["1", "1"], ["0", "-1"]], "V")
    (w,), (v,) = eigenvectors(V, exact(-1))
    assert matvec(V, v) == tuple(-x for x in v) and vecmat(w, V) == tuple(-x for x in w)
    assert dot(w, v) == 1


@pytest.mark.parametrize("k", range(1, 7))
def test_bdf_up_to_6_is_power_bounded(k):
    assert power_bounded(linear_multistep(*bdf(k)).V).holds is True


@pytest.mark.parametrize("k", [7, 8])
def test_bdf_from_7_on_is_not(k):
    found = power_bounded(linear_multistep(*bdf(k)).V)
    assert found.holds is False and "outside the unit circle" in found.witness


@pytest.mark.parametrize(
    ("V", "expected"),
    [
        ([["1", "0"], ["0", "1"]], True),
        ([["1", "1"], ["0", "1"]], False),
        ([["1", "1"], ["0", "1/2"]], True),
        ([["0", "1"], ["0", "0"]], True),
        ([["3/5", "-4/5"], ["4/5", "3/5"]], True),
        ([["2", "0"], ["0", "1/2"]], False),
        # two equal rotations, coupled: defective; uncoupled: bounded
        (
            [
                ["0", "-1", "1", "0"],
                ["1", "0", "0", "1"],
                ["0", "0", "0", "-1"],
                ["0", "0", "1", "0"],
            ],
            False,
        ),
        (
            [
                ["0", "-1", "0", "0"],
                ["1", "0", "0", "0"],
                ["0", "0", "0", "-1"],
                ["0", "0", "1", "0"],
            ],
            True,
        ),
        (
            [
                ["3/5", "-4/5", "1", "0"],
                ["4/5", "3/5", "0", "1"],
                ["0", "0", "3/5", "-4/5"],
                ["0", "0", "4/5", "3/5"],
            ],
            False,
        ),
    ],
)
def test_power_boundedness_is_decided(V, expected):
    found = power_bounded(as_matrix(V, "V"))
    assert found.holds is expected
    assert bool(found.witness) is not expected


def test_published_decimals_leave_the_eigenvalues_open():
    V = ((Ball.decimal("0.5", 20),),)
    assert power_bounded(V).holds is None
    with pytest.raises(ExactnessError, match="exact entries only"):
        unimodular_eigenvalues(V)
