"""Error constants: residuals one order beyond as one number."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt

from ..exact import Scalar
from .trees import Tree


def error_norm(residuals: Mapping[Tree, Scalar]) -> float:
    """Return euclidean norm of ``residual / sigma`` over the trees of order p + 1.

    The local error is ``h^(p+1)`` times the sum of ``residual / sigma`` times the elementary
    differential, so this is the usual principal error norm (Hairer, Norsett, Wanner (1993), II.1).

    Parameters
    ----------
    residuals : Mapping[Tree, Scalar]
        Of an :class:`.order.OrderResult`.
    """
    sizes = [x.magnitude() / t.symmetry for t, x in residuals.items()]
    return sqrt(sum(x * x for x in sizes))  # a square that is beyond doubles is infinite
