"""Published symmetric multistep methods in the one-step form of the new ones."""

from __future__ import annotations

from fractions import Fraction
from functools import cache

import numpy as np

from campaigns.partitioned.error_front import angles_of
from glmref.catalogue.lookup import load
from glmref.catalogue.reader import load_document
from glmref.derive.multistep import multistep_document
from glmref.method import Method

#: Published symmetric multistep methods.
SYMMETRIC = (
    *("quinlan-tremaine-8", "quinlan-tremaine-10", "quinlan-tremaine-12"),
    *("quinlan-tremaine-14", "quinlan-8a", "quinlan-8b"),
)


@cache
def twin(name: str) -> Method:
    """Return a published symmetric multistep method in the one-step form of the new ones.

    The same formula for the positions, up to the rounding of the cosines of its roots: the engine
    steps it by the same kernel, which a comparison of times has to do. Its file keeps the published
    form. Other methods are returned as they are.
    """
    if name not in SYMMETRIC:
        return load(name)
    of_p = cosines(name)
    return load_document(multistep_document(f"{name}-in-one-step-form", [], of_p, title=name))


def cosines(name: str) -> list[Fraction]:
    """Return cosines of the pairs of roots of a symmetric multistep method, to nine digits."""
    return [Fraction(float(c)).limit_denominator(10**9) for c in np.cos(angles_of(name))[::-1]]
