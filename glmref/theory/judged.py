"""Matrices of methods as the judge has them, for its functions that need no document."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from ..exact.judging import as_numbers, fast_judge
from ..method import Component, Method


def judged_component(c: Component) -> Any:
    """Return A, U, B, V in numbers of :func:`~glmref.exact.judging.fast_judge`."""
    return fast_judge().document.Component(*map(as_numbers, c.matrices))


def judged_parts(m: Method) -> SimpleNamespace:
    """Return the components by colour, and whether they are a pair, one that is separable."""
    parts = {c.colour: judged_component(c) for c in m.components}
    pair = set(parts) == {"f", "k"}
    return SimpleNamespace(parts=parts, pair=pair, separable=pair and not m.shared)
