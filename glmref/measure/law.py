"""By which law an error grows.

The law is read from the root mean square of the deviation over dyadic stretches of time: exponent 0
is bounded, 1/2 a random walk, 1 linear, 2 quadratic; a run whose deviation reaches its own unit, or
ends early, has blown up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..compute.records import in_json
from ..engine.outcome import Solution
from ..errors import UsageError
from ..method import Method
from ..method.rounding import float_arrays
from ..problems.model import Problem
from .longtime import exponent, quantities

#: Laws, and the exponents up to which they are taken: halfway to the next one.
KINDS = {"bounded": 0.25, "random walk": 0.75, "linear": 1.5, "quadratic": 2.5}
BLOW_UP = "blow-up"
#: Relative deviation at which a run has blown up.
LOST = 1.0


@dataclass(frozen=True)
class Law:
    """How a deviation grew."""

    kind: str  #: One of :data:`KINDS` or ``"blow-up"``.
    exponent: float  #: Slope of log rms against log t; NaN where there is nothing to fit.
    largest: float  #: Largest deviation.
    last: float  #: Root mean square over the last half of the time.
    time: float  #: Length of the run; of a blow-up, when the deviation reached :data:`LOST`.

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types."""
        return in_json(self)


def fit_law(t: np.ndarray, deviation: np.ndarray, *, ended: bool = False) -> Law:
    """Fit the law of relative deviations (m,), the first of them zero, at times (m,).

    ``ended`` says whether the run ended before its time.
    """
    elapsed = np.abs(np.asarray(t, dtype=float) - float(t[0]))
    sizes = np.abs(np.asarray(deviation, dtype=float))
    over = np.flatnonzero(~(sizes < LOST))
    if len(over) or ended:
        time = float(elapsed[over[0]]) if len(over) else float(elapsed[-1])
        good = sizes[np.isfinite(sizes)]
        return Law(BLOW_UP, math.nan, float(np.max(good, initial=0.0)), math.nan, time)
    found = exponent(elapsed, sizes)
    late = sizes[elapsed > elapsed[-1] / 2]
    rms = float(np.sqrt(np.mean(late**2))) if len(late) else 0.0
    kind = "bounded"
    if not math.isnan(found):
        kind = next((name for name, most in KINDS.items() if found < most), BLOW_UP)
    return Law(kind, found, float(np.max(sizes)), rms, float(elapsed[-1]))


def samples_of(problem: Problem, method: Method, solution: Solution, quantity: str) -> np.ndarray:
    """Return the relative deviation of one conserved quantity along a solution, (m,).

    It is ``"energy"``, the name of an invariant, or ``"form of NAME"``: the form G of all values of
    a quadratic invariant.

    Raises
    ------
    UsageError
        For a quantity that the problem, or the method, does not have.
    """
    G = None
    if quantity.startswith("form of ") and len(method.components) == 1 and method.G is not None:
        G, _ = float_arrays(method.G)
    known: list[str] = []
    with np.errstate(all="ignore"):
        for name, kind, values, scale in quantities(problem, solution, G=G):
            known.append(f"form of {name}" if kind == "form" else name)
            if known[-1] == quantity:
                unit = scale if kind == "hamiltonian" else abs(values[0])
                return (values - values[0]) / (unit or 1.0)
    there = ", ".join(known) or "none"
    raise UsageError(
        f"{method.name} on {problem.name} conserves no {quantity!r}; there are {there}"
    )
