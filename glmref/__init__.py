"""glmref: general linear methods checked exactly and measured honestly.

The public names are resolved on first use, so that ``import glmref`` loads nothing heavy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .catalogue.lookup import load, names
    from .engine.solve import Solution, solve
    from .errors import DataError, ExactnessError, GlmrefError, UsageError
    from .exchange.export import export
    from .findings import Finding, Proof, Verdict
    from .method import (
        GLM,
        FinishingMethod,
        PairStartingMethod,
        PartitionedGLM,
        StartingMethod,
    )
    from .problems import Problem, problem
    from .verification.analysis import Analysis, analyze
    from .verification.verifier import verify

__version__ = "0.1.0"

_HOMES = {
    "catalogue.lookup": ("load", "names"),
    "engine.solve": ("Solution", "solve"),
    "errors": ("DataError", "ExactnessError", "GlmrefError", "UsageError"),
    "exchange.export": ("export",),
    "findings": ("Finding", "Proof", "Verdict"),
    "method": (
        "GLM",
        "FinishingMethod",
        "PairStartingMethod",
        "PartitionedGLM",
        "StartingMethod",
    ),
    "problems": ("Problem", "problem"),
    "verification.analysis": ("Analysis", "analyze"),
    "verification.verifier": ("verify",),
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
    "export",
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
