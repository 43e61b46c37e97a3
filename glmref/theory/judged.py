"""Matrices of methods as the judge has them, for its functions that need no document."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

from ..exact.judging import as_numbers, fast_judge
from ..method import Method
from ..method.preconsistency import Block


def judged_component(c: Block) -> Any:
    """Return A, U, B, V in numbers of :func:`~glmref.exact.judging.fast_judge`."""
    return fast_judge().document.Component(*map(as_numbers, (c.A, c.U, c.B, c.V)))


@lru_cache(maxsize=8)
def judged_parts(m: Method) -> Any:
    """Return a method of the judge that has these components, and no document."""
    found = object.__new__(fast_judge().document.Method)
    parts = {c.colour: judged_component(c) for c in m.components}
    pair = set(parts) == {"f", "k"}
    found.__dict__.update(parts=parts, pair=pair, separable=pair and not m.shared, declared={})
    return found
