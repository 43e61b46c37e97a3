"""extensisq's explicit Runge-Kutta methods, which are solvers in the interface of scipy."""

# pyright: reportMissingImports=false
from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

import extensisq

from .scipy_steps import Adapter as Scipy


class Adapter(Scipy):
    """``extensisq``: BS5, CK5, Me4, Pr7, Pr8, Pr9 and Ts5 at constant step size."""

    solvers: ClassVar[Mapping[str, type]] = {
        "cash-karp-5": extensisq.CK5,
        "merson-4": extensisq.Me4,
        "bs5": extensisq.BS5,
        "ts5": extensisq.Ts5,
        "pr7": extensisq.Pr7,
        "pr8": extensisq.Pr8,
        "pr9": extensisq.Pr9,
    }
    methods: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        name: {} for name in ("cash-karp-5", "merson-4")
    } | {name: {"order": int(name[-1])} for name in ("bs5", "ts5", "pr7", "pr8", "pr9")}
    tolerance: ClassVar[float | Mapping[str, float]] = 1e-14
