"""Methods by their names: files of the catalogue, and of users, read into methods."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import BudgetError, DataError, UsageError
from ..exact.linalg import row_sums
from ..method import GLM, AdditiveGLM, PartitionedGLM
from ..system.budget import READING, limited
from .files import data_root, document, is_broken, names, path_of
from .reader import load_document

if TYPE_CHECKING:
    from ..system.process import Said

__all__ = [
    "data_root",
    "document",
    "is_broken",
    "is_shipped",
    "load",
    "method_of",
    "names",
    "path_of",
    "read_method",
    "unread",
]


def load(name: str | Path) -> GLM | PartitionedGLM | AdditiveGLM:
    """Load a method by name or path.

    Raises
    ------
    UsageError
        For an unknown name or a missing file.
    DataError
        For a file that is not what it must be.
    """
    path = path_of(name)
    method = read_method(path)[1]
    times = getattr(method.claims, "times", None)
    for n, c in enumerate(times or (), 1):
        sums = row_sums(method.components[n - 1].A)
        if c is not None and any((x - y).is_zero() is False for x, y in zip(sums, c, strict=True)):
            raise DataError(
                f"{path.name}: `parts[{n}].c` is not A 1; `glmref verify` judges its order, other "
                f"commands take additive methods with c = A 1"
            )
    return method


def method_of(given: Any) -> GLM | PartitionedGLM | AdditiveGLM:
    """Return the method that a name, a path or a method stands for.

    Raises
    ------
    UsageError
        For an unknown name, a missing file, or anything else.
    DataError
        For a file that is not what it must be.
    """
    if isinstance(given, str | Path):
        return load(given)
    if not isinstance(given, GLM | PartitionedGLM | AdditiveGLM):
        raise UsageError(
            f"`method` must be a method, its name or its file, got {type(given).__name__}"
        )
    return given


def is_shipped(path: Path) -> bool:
    """Return whether a file is one of the package, for which no budget is needed."""
    return path.resolve().is_relative_to(data_root().resolve())


def read_method(path: Path) -> tuple[dict[str, Any], Any]:
    """Read an existing method file, and a user's in bounded time.

    Raises
    ------
    DataError
        For a file that is not what it must be, or takes too long to be read.
    """
    doc = document(path)
    try:
        with limited(None if is_shipped(path) else READING):
            return doc, load_document(doc, where=path.name)
    except BudgetError as error:
        raise _slow(path, error) from None


def _slow(path: Path, error: Exception) -> DataError:
    return DataError(
        f"{path.name}: the entries take more than {READING:g} s of processor time to read "
        f"({error}); write them with fewer roots, or as decimals with `digits`"
    )


def unread(path: Path, said: Said) -> Exception:
    """Return why a file was not read in a process of its own, which was ended."""
    error = said.error(READING)
    return _slow(path, error) if isinstance(error, BudgetError) else error
