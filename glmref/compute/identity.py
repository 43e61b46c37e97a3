"""What a process computes with: two that agree here give the same results."""

from __future__ import annotations

import platform
from functools import cache
from importlib.metadata import PackageNotFoundError, version

from .. import __version__
from ..system.cache import sources


@cache
def identity() -> dict[str, str]:
    """Return versions of Python and of what computes, and a hash of the sources of this package."""
    found = {"python": platform.python_version(), "glmref": __version__}
    for name in ("numpy", "python-flint", "mpmath", "numba", "llvmlite"):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            continue
    return {**found, "the sources of glmref": sources()[:12]}


def difference(mine: dict[str, str], expected: dict[str, str]) -> str:
    """Return what differs, as the end of a sentence about this process; ``""`` if nothing does."""
    for name in {**expected, **mine}:
        here, there = mine.get(name, "none"), expected.get(name, "none")
        if here != there:
            return (
                f"has {here} for {name} and the client {there}; give both the same environment, "
                f"so that results do not depend on who computed them"
            )
    return ""
