"""What the records of work say: the evaluations *needed* for a tolerance, and means of them.

Errors are taken on a grid of step sizes, a third of an octave apart. What is needed is where the
error falls below the tolerance for good: between the last grid point above and the first after it,
interpolated in logarithms. So a lucky zero of the error at one step size counts for nothing.
"""

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

#: Problems on which no method of this project was trained: forty Hamiltonians with a start, and
#: how far each is solved; without H, the parameters of Kepler's problem.
PROBLEMS: Mapping[str, Mapping[str, Any]] = json.loads(
    Path(__file__).with_name("held_out_problems.json").read_text(encoding="utf-8")
)


def quadratic(case: str) -> bool:
    """Return whether T is quadratic in a case of this name."""
    return bool(PROBLEMS[case.removesuffix(", long")].get("quadratic", True))


def needed(
    entry: Mapping[str, Any], methods: Sequence[str], tolerance: str, what: str = "needed"
) -> tuple[str, float]:
    """Return the cheapest of some methods in a case and its cost (infinite if there is none)."""
    found = {x["method"]: x.get(what, {}).get(tolerance, math.inf) for x in entry["methods"]}
    name = min(methods, key=lambda x: found.get(x, math.inf), default="")
    return name, found.get(name, math.inf)


def mean(values: Sequence[float]) -> float:
    """Return the geometric mean of those that are numbers; NaN where none is."""
    logs = [math.log(x) for x in values if math.isfinite(x)]
    return math.exp(math.fsum(logs) / len(logs)) if logs else math.nan


def crossing(curve: Sequence[tuple[int, float]], tolerance: float) -> float | None:
    """Interpolate, in logarithms, the evaluations from which the error stays below a tolerance."""
    above = [k for k, (_, e) in enumerate(curve) if not e < tolerance]
    last = above[-1] if above else -1
    if last == len(curve) - 1:
        return None
    if last < 0:
        return float(curve[0][0])
    (n, e), (m, d) = curve[last], curve[last + 1]
    if not (math.isfinite(e) and d > 0):
        return float(m)
    part = math.log(e / tolerance) / math.log(e / d)
    return n * (m / n) ** part
