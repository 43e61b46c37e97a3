"""Methods as frozen records, the classical families, and forms they can be given in."""

from __future__ import annotations

from .glm import (
    GLM,
    Entry,
    FinishingMethod,
    PairStartingMethod,
    PartitionedGLM,
    Rows,
    StartingMethod,
    as_matrix,
    as_vector,
)

__all__ = [
    "GLM",
    "Entry",
    "FinishingMethod",
    "PairStartingMethod",
    "PartitionedGLM",
    "Rows",
    "StartingMethod",
    "as_matrix",
    "as_vector",
]
