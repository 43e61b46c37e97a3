"""glmref: general linear methods checked exactly and measured honestly.

The public names are resolved on first use, so that ``import glmref`` loads nothing heavy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .analysis import Analysis, analyze
    from .catalogue import load, names
    from .claims import DataError, ExactnessError, Finding, GlmrefError, Proof, UsageError, Verdict
    from .engine.solve import Solution, solve
    from .method import (
        GLM,
        FinishingMethod,
        PairStartingMethod,
        PartitionedGLM,
        StartingMethod,
    )
    from .problems import Problem, problem
    from .verification import verify

__version__ = "0.1.0"

_HOMES = {
    "analysis": ("Analysis", "analyze"),
    "catalogue": ("load", "names"),
    "claims": (
        "DataError",
        "ExactnessError",
        "Finding",
        "GlmrefError",
        "Proof",
        "UsageError",
        "Verdict",
    ),
    "engine.solve": ("Solution", "solve"),
    "method": (
        "GLM",
        "FinishingMethod",
        "PairStartingMethod",
        "PartitionedGLM",
        "StartingMethod",
    ),
    "problems": ("Problem", "problem"),
    "verification": ("verify",),
}
_HOME_OF = {name: home for home, public in _HOMES.items() for name in public}

__all__ = [
    "GLM",
    "Analysis",
    "DataError",
    "ExactnessError",
    "Finding",
    "FinishingMethod",
    "GlmrefError",
    "PairStartingMethod",
    "PartitionedGLM",
    "Problem",
    "Proof",
    "Solution",
    "StartingMethod",
    "UsageError",
    "Verdict",
    "__version__",
    "analyze",
    "load",
    "names",
    "problem",
    "solve",
    "verify",
]


def __getattr__(name: str) -> Any:
    home = _HOME_OF.get(name)
    if home is None:
        raise AttributeError(f"module 'glmref' has no attribute {name!r}")
    value = getattr(import_module(f".{home}", __name__), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
