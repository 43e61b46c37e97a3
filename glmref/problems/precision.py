"""Functions of a problem beyond double precision: mpmath contexts and closed forms."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np

from .formula import Number, to_number
from .user_functions import UserFunction

GUARD_DIGITS = 15  # beyond the digits asked, for cancellation in closed forms
DOUBLE_DIGITS = 40  # working digits of a closed form whose result is rounded to double


@dataclass(frozen=True)
class Flow:
    """An exact solution in closed form, evaluated in extended precision and rounded once."""

    #: ``function(t, y0, parameters, context)`` -> list of numbers of the mpmath context.
    function: Callable[..., Sequence[Any]]
    parameters: Mapping[str, Number]  #: Exact values.
    #: ``None``: arguments and result are doubles, each taken at its exact value.
    context: Any = field(default=None, compare=False, repr=False)

    def __call__(self, t: Any, y0: Any) -> np.ndarray:
        """Return the state at time t of the solution that starts at y0, shape (d,)."""
        import mpmath

        context = mpmath.MPContext()
        digits = DOUBLE_DIGITS if self.context is None else self.context.dps + GUARD_DIGITS
        # a phase of size t costs log10(t) digits
        context.dps = digits + max(0, int(math.log10(abs(float(t)) + 1)))
        time = to_number(t, context) if isinstance(t, Fraction) else context.mpf(t)
        numbers = {k: context.mpf(v) for k, v in self._parameters(context).items()}
        state = [context.mpf(x) for x in y0]
        result = self.function(time, state, numbers, context)
        if self.context is None:
            return np.array([float(x) for x in result])
        return np.array([self.context.mpf(x) for x in result], dtype=object)

    def _parameters(self, context: Any) -> dict[str, Any]:
        # in double precision the equation solved has the rounded parameters
        if self.context is None:
            return {k: float(v) for k, v in self.parameters.items()}
        return {k: to_number(v, context) for k, v in self.parameters.items()}

    def on(self, context: Any) -> Flow:
        """Return the solution evaluated in an mpmath context."""
        return replace(self, context=context)


def on_context(function: Any, context: Any) -> Any:
    """Return a problem's function evaluated in an mpmath context; ``None`` stays ``None``."""
    if function is None:
        return None
    if isinstance(function, UserFunction):
        return function.in_context(context)
    # a plain function of the package, such as the identity, serves every number type
    return function.on(context) if hasattr(function, "on") else function
