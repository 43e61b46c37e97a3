"""Methods as frozen records, the classical families, and forms they can be given in."""

from __future__ import annotations

from .additive import AdditiveGLM
from .component import Component
from .embedded import EmbeddedRow
from .entries import Entries, Entry, Rows, as_matrix, as_vector
from .glm import GLM, PartitionedGLM
from .model import Method
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
