"""Our compiled engine, through its door :func:`glmref.solve`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ...catalogue.lookup import load
from ...engine.outcome import Solution
from ...engine.solve import solve
from ..vectors import file_names


class Adapter:
    """The compiled engine as some methods, by default all that have vectors.

    The options are further arguments of :func:`glmref.solve`, such as ``arithmetic``.
    """

    def __init__(self, methods: Sequence[str] | None = None, **options: Any) -> None:
        self.methods = tuple(file_names() if methods is None else methods)
        self.options = {"engine": "compiled", **options}
        self._known: dict[str, Any] = {}

    def _run(self, method: str, problem: Any, h: float, steps: int, **options: Any) -> Solution:
        if method not in self._known:
            self._known[method] = load(method)
        run = solve(problem, self._known[method], h=h, steps=steps, **self.options, **options)
        if not run.completed:
            raise ArithmeticError(run.message)
        return run

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step: a run of one step from values that are given."""
        values = y.reshape(-1, problem.dimension)
        moved = problem if problem.t_span[0] == t else replace(problem, t_span=(t, t + abs(h)))
        return self._run(method, moved, h, 1, start=values).values

    def solve(
        self, method: str, problem: Any, h: float, steps: int, start: np.ndarray | None = None
    ) -> np.ndarray:
        """Start, steps and finish."""
        return self._run(method, problem, h, steps, start=start, every=1).y
