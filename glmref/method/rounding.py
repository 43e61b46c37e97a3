"""From exact coefficients to floating point: rounded once, the residue kept.

A kernel can compensate the residue (Hairer, McLachlan, Razakarivony 2008, section 3) and a test can
bound it.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from ..exact import Scalar
from ..exact.linalg import Matrix

if TYPE_CHECKING:
    import numpy as np

__all__ = ["FloatGLM", "float_arrays", "split_float"]


def split_float(value: Scalar) -> tuple[float, float]:
    """Round to the nearest double and return it with the residue ``value - rounded``, rounded."""
    rounded = float(value)
    return rounded, float(value - Fraction(rounded))


@dataclass(frozen=True, eq=False)
class FloatGLM:
    """A GLM rounded to double precision once, with what the rounding lost.

    Attributes
    ----------
        A, U, B, V: float64 (or complex128) arrays of shapes (s, s), (s, r), (r, s), (r, r).
        A_residue, U_residue, B_residue, V_residue: exact minus rounded, themselves rounded.
        G: (r, r) or ``None``; D: (s,) or ``None``.
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


def float_arrays(matrix: Matrix) -> tuple[np.ndarray, np.ndarray]:
    """Round a matrix: the array and the array of residues."""
    import numpy as np

    if all(x.is_real() for row in matrix for x in row):
        pairs = [[split_float(x) for x in row] for row in matrix]
        both = np.array(pairs, dtype=float).reshape(len(matrix), len(matrix[0]), 2)
        return both[..., 0].copy(), both[..., 1].copy()
    rounded = np.array([[complex(x) for x in row] for row in matrix])
    return rounded, np.zeros_like(rounded)
