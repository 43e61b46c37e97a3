"""Methods as frozen records, the classical families, and forms they can be given in."""

from __future__ import annotations

from .additive import AdditiveGLM
from .component import Component, Method
from .embedded import EmbeddedRow
from .glm import GLM, Entries, Entry, PartitionedGLM, Rows, as_matrix, as_vector
from .nystrom import nystrom
from .rosenbrock import RosenbrockGLM
from .starting import FinishingMethod, PairStartingMethod, StartingMethod

__all__ = [
    "GLM",
    "AdditiveGLM",
    "Component",
    "EmbeddedRow",
    "Entries",
    "Entry",
    "FinishingMethod",
    "Method",
    "PairStartingMethod",
    "PartitionedGLM",
    "RosenbrockGLM",
    "Rows",
    "StartingMethod",
    "as_matrix",
    "as_vector",
    "nystrom",
]
