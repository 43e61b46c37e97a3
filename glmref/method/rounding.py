"""From exact coefficients to floating point: rounded once, the residue kept.

A kernel can compensate the residue (Hairer, McLachlan, Razakarivony 2008, section 3) and a test can
bound it.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from math import isinf
from typing import TYPE_CHECKING

from ..errors import DataError
from ..exact import Scalar
from ..exact.linalg import Matrix

if TYPE_CHECKING:
    import numpy as np

Rows = tuple[tuple[float, ...], ...]
#: A number this close to an integer or to zero counts as one in doubles.
CLOSE = 1e-40


def split_float(value: Scalar) -> tuple[float, float]:
    """Round to the nearest double and return it with the residue ``value - rounded``, rounded.

    Raises
    ------
    DataError
        For a number beyond double precision.
    """
    rounded = as_double(value)
    return rounded, float(value - Fraction(rounded))


def as_double(value: Scalar | str) -> float:
    """Round a coefficient, or its decimal, to the nearest double.

    Raises
    ------
    DataError
        For a number beyond double precision.
    """
    rounded = float(value)
    if isinf(rounded):
        raise DataError("a coefficient is beyond double precision, 1.8e308; the method stays exact")
    return rounded


@dataclass(frozen=True, eq=False)
class FloatGLM:
    """A GLM rounded to double precision once, with what the rounding lost.

    Attributes
    ----------
    A, U, B, V : np.ndarray
        float64 (or complex128) arrays of shapes (s, s), (s, r), (r, s), (r, r).
    A_residue, U_residue, B_residue, V_residue : np.ndarray
        Exact minus rounded, themselves rounded.
    G : np.ndarray or None
        (r, r) or ``None``.
    D : np.ndarray or None
        (s,) or ``None``.
    """

    A: np.ndarray
    U: np.ndarray
    B: np.ndarray
    V: np.ndarray
    A_residue: np.ndarray
    U_residue: np.ndarray
    B_residue: np.ndarray
    V_residue: np.ndarray
    G: np.ndarray | None = None
    D: np.ndarray | None = None
    name: str = ""


def split_rows(matrix: Matrix) -> tuple[Rows, Rows]:
    """Round a real matrix; return its rows and their rounding residuals."""
    pairs = [[split_float(x) for x in row] for row in matrix]
    first, second = (tuple(tuple(pair[k] for pair in row) for row in pairs) for k in (0, 1))
    return first, second


def float_arrays(matrix: Matrix) -> tuple[np.ndarray, np.ndarray]:
    """Round a matrix: the array and the array of residues."""
    import numpy as np

    if all(x.is_real() for row in matrix for x in row):
        first, second = (np.array(x, dtype=float) for x in split_rows(matrix))
        return first, second
    rounded = np.array([[complex(x) for x in row] for row in matrix])
    return rounded, np.zeros_like(rounded)
