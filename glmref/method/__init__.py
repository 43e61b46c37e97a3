"""Methods as frozen records, the classical families, and forms they can be given in."""

from __future__ import annotations

from .additive import AdditiveGLM
from .component import Component, Method
from .glm import (
    GLM,
    Entries,
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
    "AdditiveGLM",
    "Component",
    "Entries",
    "Entry",
    "FinishingMethod",
    "Method",
    "PairStartingMethod",
    "PartitionedGLM",
    "Rows",
    "StartingMethod",
    "as_matrix",
    "as_vector",
]
