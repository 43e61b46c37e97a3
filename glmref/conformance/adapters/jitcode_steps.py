"""JiTCODE's right-hand sides, compiled from expressions, under scipy's explicit methods.

A huge tolerance lets every step of the size asked for pass.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

from collections.abc import Mapping
from contextlib import chdir
from tempfile import TemporaryDirectory
from typing import Any, ClassVar

import jitcode
import numpy as np
import symengine

from ...measure.peers import names_of

#: Name in the catalogue -> name in JiTCODE.
INTEGRATORS = {"bogacki-shampine-3": "RK23", "dormand-prince-5": "RK45", "dop853": "DOP853"}


class Adapter:
    """``jitcode.jitcode`` with RK23, RK45 and DOP853, forward in time only."""

    problems = ("pendulum", "kepler")
    methods: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        name: {"order": 8} if name == "dop853" else {} for name in INTEGRATORS
    }

    def __init__(self) -> None:
        self.compiled: dict[str, Any] = {}

    def _compiled(self, problem: Any) -> Any:
        if problem.name not in self.compiled:
            if problem.expressions is None:
                raise NotImplementedError("JiTCODE compiles expressions; f must be given so")
            state = [jitcode.y(k) for k in range(problem.dimension)]
            f = problem.f.on(names_of(symengine, mpf=symengine.sympify))
            made = jitcode.jitcode(list(f(jitcode.t, state)), n=problem.dimension, verbose=False)
            with TemporaryDirectory() as folder, chdir(folder):  # setuptools reads what lies here
                made.compile_C(extra_compile_args=["-O1"])
            self.compiled[problem.name] = made
        return self.compiled[problem.name]

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step of size h, whatever the error estimate says."""
        if h < 0:
            raise NotImplementedError("JiTCODE goes forward in time only")
        engine = self._compiled(problem)
        engine.set_integrator(
            INTEGRATORS[method], interpolate=False, first_step=h, max_step=h, rtol=1e-3, atol=1e10
        )
        engine.set_initial_value(np.array(y), t)
        return np.array(engine.integrate(t + h))
