"""What finders ask of matrices."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ..exact import Exact


def is_exact(*matrices: Sequence[Sequence[Any]]) -> bool:
    """Return whether no ball stands in the matrices."""
    return all(isinstance(x, Exact) for m in matrices for row in m for x in row)
