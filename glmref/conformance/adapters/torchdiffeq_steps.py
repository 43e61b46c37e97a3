"""torchdiffeq's explicit Runge-Kutta methods, one step at a time, in double precision.

The adaptive ones take a first step of the size asked for, which a huge tolerance accepts.
"""

# pyright: reportMissingImports=false
from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import numpy as np
import torch
from torchdiffeq import odeint

_ANYTHING = 1e10
#: Name in the catalogue -> name in torchdiffeq, of methods at constant step size.
FIXED = {
    "euler": "euler",
    "midpoint-explicit": "midpoint",
    "heun-2": "heun2",
    "heun-3": "heun3",
    "rk38": "rk4",
}
#: The same of methods that choose their step.
ADAPTIVE = {
    "bogacki-shampine-3": "bosh3",
    "dormand-prince-5": "dopri5",
    "fehlberg2": "fehlberg2",
    "dopri8": "dopri8",
}


class Adapter:
    """``torchdiffeq.odeint``; its ``rk4`` is the 3/8 rule."""

    methods: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        **{key: {} for key in (*FIXED, "bogacki-shampine-3", "dormand-prince-5")},
        "fehlberg2": {"order": 2},
        "dopri8": {"order": 8},
    }

    # the end of an adaptive step is read off its interpolant, where a bit is lost
    epsilon = 2.0**-52

    def __init__(self) -> None:
        torch.set_num_threads(1)  # states of the suite are small: more threads wait for each other

    def step(self, method: str, problem: Any, t: float, y: np.ndarray, h: float) -> np.ndarray:
        """Take one step of size h, whatever the error estimate says."""

        def f(s: Any, x: Any) -> Any:
            return torch.from_numpy(np.array(problem.f(float(s), x.numpy())))

        if method in FIXED:
            options: dict[str, Any] = {"method": FIXED[method], "options": {"step_size": abs(h)}}
        else:
            options = {"method": ADAPTIVE[method], "options": {"first_step": abs(h)}}
            options |= {"rtol": 1e-3, "atol": _ANYTHING}
        times = torch.tensor([t, t + h], dtype=torch.float64)
        states: Any = odeint(f, torch.from_numpy(np.array(y)), times, **options)
        return states[-1].numpy()
