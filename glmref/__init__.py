"""glmref: general linear methods checked exactly and measured honestly.

The public names are resolved on first use, so that ``import glmref`` loads nothing heavy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .audit import CheckFailed, assert_tableau, check
    from .catalogue.lookup import load, names
    from .engine.outcome import Interrupted, Solution
    from .engine.solve import solve
    from .errors import DataError, ExactnessError, GlmrefError, UsageError
    from .exchange.export import export
    from .findings import Finding, Proof, Verdict
    from .measure.prediction import Prediction, predict
    from .method import (
        GLM,
        AdditiveGLM,
        FinishingMethod,
        PairStartingMethod,
        PartitionedGLM,
        StartingMethod,
    )
    from .method.families import linear_multistep as from_lmm
    from .method.families import one_leg as from_one_leg
    from .method.families import runge_kutta as from_rk
    from .method.families import splitting as from_splitting
    from .problems import Problem, problem
    from .problems.sundman import time_transformed
    from .prove.analysis import Analysis, analyze
    from .prove.verifier import verify
    from .scenes.comparing import Comparison, compare
    from .scenes.modified import Modified, modified
    from .theory.series import Series
    from .theory.starting_series import StartingSeries
    from .theory.trees import Tree
    from .views.bibtex import cite
    from .views.plot import plot
    from .views.show import show

__version__ = "1.0.0rc1"

_HOMES = {
    "audit": ("CheckFailed", "assert_tableau", "check"),
    "catalogue.lookup": ("load", "names"),
    "engine.outcome": ("Interrupted", "Solution"),
    "engine.solve": ("solve",),
    "errors": ("DataError", "ExactnessError", "GlmrefError", "UsageError"),
    "exchange.export": ("export",),
    "findings": ("Finding", "Proof", "Verdict"),
    "method": (
        "GLM",
        "AdditiveGLM",
        "FinishingMethod",
        "PairStartingMethod",
        "PartitionedGLM",
        "StartingMethod",
    ),
    "measure.prediction": ("Prediction", "predict"),
    "scenes.modified": ("Modified", "modified"),
    "problems": ("Problem", "problem"),
    "problems.sundman": ("time_transformed",),
    "theory.series": ("Series",),
    "theory.starting_series": ("StartingSeries",),
    "theory.trees": ("Tree",),
    "scenes.comparing": ("Comparison", "compare"),
    "prove.analysis": ("Analysis", "analyze"),
    "prove.verifier": ("verify",),
    "views.bibtex": ("cite",),
    "views.plot": ("plot",),
    "views.show": ("show",),
}
_HOME_OF = {name: (home, name) for home, public in _HOMES.items() for name in public}
#: Own methods from the coefficients of a family; the name says from what.
_HOME_OF |= {
    "from_lmm": ("method.families", "linear_multistep"),
    "from_one_leg": ("method.families", "one_leg"),
    "from_rk": ("method.families", "runge_kutta"),
    "from_splitting": ("method.families", "splitting"),
}

__all__ = [
    "GLM",
    "AdditiveGLM",
    "Analysis",
    "CheckFailed",
    "Comparison",
    "DataError",
    "ExactnessError",
    "Finding",
    "FinishingMethod",
    "GlmrefError",
    "Interrupted",
    "Modified",
    "PairStartingMethod",
    "PartitionedGLM",
    "Prediction",
    "Problem",
    "Proof",
    "Series",
    "Solution",
    "StartingMethod",
    "StartingSeries",
    "Tree",
    "UsageError",
    "Verdict",
    "__version__",
    "analyze",
    "assert_tableau",
    "check",
    "cite",
    "compare",
    "export",
    "from_lmm",
    "from_one_leg",
    "from_rk",
    "from_splitting",
    "load",
    "modified",
    "names",
    "plot",
    "predict",
    "problem",
    "show",
    "solve",
    "time_transformed",
    "verify",
]


def __getattr__(name: str) -> Any:
    if name not in _HOME_OF:
        raise AttributeError(f"module 'glmref' has no attribute {name!r}")
    home, inside = _HOME_OF[name]
    value = getattr(import_module(f".{home}", __name__), inside)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted(__all__)
