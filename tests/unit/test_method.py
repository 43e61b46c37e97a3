"""method.py: shapes are checked, transformations are equivalences, rounding keeps its residue."""

from dataclasses import FrozenInstanceError
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.errors import DataError
from glmref.exact import linalg
from glmref.method import GLM, PartitionedGLM, as_matrix
from tests.build import refused, same

HALF: dict[str, Any] = {"A": [["1/2"]], "U": [["1"]], "B": [["1"]], "V": [["1"]]}


def midpoint(**changes: Any) -> GLM:
    return GLM(**{**HALF, **changes})


def test_a_method_is_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        midpoint().A = ()  # type: ignore[misc]


def test_which_stages_are_implicit() -> None:
    g4123 = load("g4123")
    assert g4123.is_diagonally_implicit
    assert len(g4123.implicit_stages) == 1
    assert not g4123.is_explicit
    gauss, euler = load("gauss-2"), load("euler")
    assert gauss.implicit_stages == (1, 2)
    assert not gauss.is_diagonally_implicit
    assert euler.is_explicit


def test_exact_real_and_decimal_methods_are_told_apart() -> None:
    assert midpoint().is_exact
    assert midpoint().is_real
    assert not midpoint(B=[["i"]]).is_real
    digits = load("gauss-2-seven-digits")
    assert not digits.is_exact
    assert digits.is_real


def test_transformation_there_and_back_is_the_identity() -> None:
    method = load("gsymplectic-n")
    T = as_matrix([["1", "sqrt(2)"], ["1", "-1"]], "T")
    back = method.transform(T).transform(linalg.inverse(T))
    for letter in "AUBVG":
        assert same(getattr(back, letter), getattr(method, letter))
    assert method.transform(T).claims == method.claims
    assert method.transform(T).document is None
    assert method.transform(T).U[0][1] != method.U[0][1]


def test_permutation_of_stages_moves_rows_and_columns_together() -> None:
    method = load("rk4")
    turned = method.permute_stages([3, 1, 2, 0])
    assert turned.A[0][2] == method.A[3][2]
    assert turned.B[0][0] == method.B[0][3]
    assert not turned.is_diagonally_implicit
    again = turned.permute_stages([3, 1, 2, 0])
    assert same(again.A, method.A)
    for wrong in ([0, 1, 2], [0, 0, 1, 2], [1, 2, 3, 4]):
        refused(DataError, "must be a permutation of", method.permute_stages, wrong)


def test_rounding_happens_once_and_its_residue_is_kept() -> None:
    method = load("gauss-2")
    rounded = method.to_float()
    assert rounded.A.dtype == np.float64
    for i in range(2):
        for j in range(2):
            error = method.A[i][j] - Fraction(float(rounded.A[i, j]))
            # correctly rounded: at most half a unit of the last place, 2^-54 for numbers below 1/2
            # and 2^-53 for those below 1
            assert error.magnitude() <= 2.0**-53
            assert float(error) == pytest.approx(rounded.A_residue[i, j], rel=1e-12, abs=1e-40)
    assert rounded.A_residue[0, 1] != 0.0  # 1/4 - sqrt(3)/6 is no double
    assert rounded.A_residue[0, 0] == 0.0  # 1/4 is


def pair(**changes: Any) -> PartitionedGLM:
    hats = {f"{key}_hat": value for key, value in HALF.items()}
    return PartitionedGLM(**{**HALF, **hats, **changes})
