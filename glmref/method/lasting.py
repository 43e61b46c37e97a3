"""Parasitic roots whose part of a solution lasts long enough to be seen beside the solution."""

from __future__ import annotations

import cmath
from collections.abc import Iterable

#: Modulus up to which a parasitic part is gone in a few steps.
LEAST = 0.5
#: Angle up to which it cannot be told from the solution.
_ANGLE = 1e-6


def lasting(roots: Iterable[complex]) -> list[complex]:
    """Return those eigenvalues of V that are neither small nor positive."""
    return [z for z in roots if abs(z) > LEAST and abs(cmath.phase(z)) > _ANGLE]
