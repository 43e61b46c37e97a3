"""The catalogue: one method, one JSON file, one source."""

from __future__ import annotations

from pathlib import Path

from ..method import GLM, PartitionedGLM
from .files import data_root, document, is_broken, names, path_of
from .reader import load_document

__all__ = ["data_root", "document", "is_broken", "load", "names", "path_of"]


def load(name: str | Path) -> GLM | PartitionedGLM:
    """Load a method by name or path.

    Raises
    ------
        UsageError: for an unknown name or a missing file.
        DataError: for a file that is not what it must be.
    """
    path = path_of(name)
    return load_document(document(path), where=path.name)
