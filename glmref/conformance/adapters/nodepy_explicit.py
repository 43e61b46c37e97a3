"""Explicit Runge-Kutta methods of nodepy that the catalogue has under a name of its own."""

# pyright: reportMissingImports=false
from __future__ import annotations

from typing import Any

import numpy as np
from nodepy import rk

#: Name in the catalogue -> name in nodepy.
NAMES = {
    "euler": "FE",
    "rk4": "RK44",
    "midpoint-explicit": "Mid22",
    "heun-3": "Heun33",
    "ssp-rk3": "SSP33",
    "merson-4": "Merson43",
    "bogacki-shampine-3": "BS3",
    "cash-karp-5": "CK5",
    "dormand-prince-5": "DP5",
    "rkf45-5": "Fehlberg45",
}


class Adapter:
    """nodepy's own step, with the coefficients of its tables."""

    def __init__(self) -> None:
        tables = rk.loadRKM()
        self.tables = {ours: tables[theirs].__num__() for ours, theirs in NAMES.items()}
        self.methods = tuple(self.tables)

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step by the Butcher coefficients."""
        return self.tables[method].__step__(problem.f, t, y, h, use_butcher=True)
