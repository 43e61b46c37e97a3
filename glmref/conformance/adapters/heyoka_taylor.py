"""heyoka's Taylor method, at the fixed order that belongs to a tolerance and at fixed step size.

heyoka chooses its step by the tolerance and never exceeds it; steps that are larger are refused.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

from typing import Any

import heyoka
import numpy as np

from ...measure.peers import heyoka_system
from ..vector_problems import problems


class Adapter:
    """``heyoka.taylor_adaptive``, with a tolerance from which it derives the order."""

    problems = ("pendulum", "kepler")

    def __init__(self, tolerance: float = 1e-4) -> None:
        self.accuracy = tolerance
        self.engines: dict[str, Any] = {}
        self.methods = {"taylor": {"order": self._engine(problems()["pendulum"].problem).order}}

    def _engine(self, problem: Any) -> Any:
        if problem.name not in self.engines:
            if problem.expressions is None:
                raise NotImplementedError("heyoka differentiates expressions; f must be given so")
            system, start = heyoka_system(problem), [0.5] * problem.dimension
            self.engines[problem.name] = heyoka.taylor_adaptive(system, start, tol=self.accuracy)
        return self.engines[problem.name]

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step of size h, or a refusal."""
        engine = self._engine(problem)
        engine.time = t
        engine.state[:] = y
        outcome, taken = engine.step(max_delta_t=h)
        if outcome != heyoka.taylor_outcome.time_limit:
            raise ArithmeticError(f"heyoka takes steps of {taken:.3g} at most, not {h:.3g}")
        return engine.state.copy()
