"""What a run is asked for: arguments checked, times turned into step numbers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import GLM, PartitionedGLM
from ..problems.model import Problem

__all__ = [
    "ARITHMETIC",
    "Plan",
    "check_arithmetic",
    "notices_of",
    "plan_of",
    "resolved",
    "step_size",
]

ARITHMETIC = ("strict", "fused", "compensated", "naive")

_WHOLE = 1e-9  # how far (t_end - t0) / h may be from an integer, per step


@dataclass(frozen=True)
class Plan:
    """Which steps are taken and which are kept.

    Attributes
    ----------
        steps: how many steps.
        every: record every so many, 0 for none.
        rows: step numbers to keep, in order.
        limited: whether a step limit cut the run short.
    """

    steps: int
    every: int
    rows: tuple[int, ...] | range
    limited: bool


def check_arithmetic(arithmetic: str) -> None:
    """Refuse a word that names no arithmetic, see :func:`.kernel.prepare`.

    Raises
    ------
        UsageError: for anything but one of :data:`ARITHMETIC`.
    """
    if arithmetic not in ARITHMETIC:
        raise UsageError(f"`arithmetic` must be one of {', '.join(ARITHMETIC)}, got {arithmetic!r}")


def resolved(problem: Any, method: Any) -> tuple[Problem, GLM | PartitionedGLM]:
    """Return problem and method, either given by name.

    Raises
    ------
        UsageError: for anything else, a problem moved to another precision, or the name of a
            method that is wrong on purpose: such a one is taken as an object only.
    """
    if isinstance(problem, str):
        from ..problems import problem as by_name

        problem = by_name(problem)
    if isinstance(method, str):
        from ..catalogue.lookup import is_broken, load

        if is_broken(method):
            raise UsageError(
                f"the method {method!r} is wrong on purpose; to run it all the same give "
                f"glmref.load({method!r})"
            )
        method = load(method)
    if not isinstance(problem, Problem):
        raise UsageError(f"`problem` must be a Problem or its name, got {type(problem).__name__}")
    if not isinstance(method, GLM | PartitionedGLM):
        raise UsageError(f"`method` must be a method or its name, got {type(method).__name__}")
    if problem.context is not None:
        raise UsageError("`problem` must be the one in double precision; give `digits` instead")
    return problem, method


def notices_of(method: GLM | PartitionedGLM) -> list[str]:
    """Return what is to be said of every run with a method: that it is wrong on purpose."""
    broken = (method.document or {}).get("broken")
    return [f"{method.name} is wrong on purpose: {broken['why']}"] if broken else []


def step_size(h: Any) -> float:
    """Return h as a number, finite and not zero.

    Raises
    ------
        UsageError: when it is not.
    """
    try:
        value = float(h)
    except (TypeError, ValueError):
        raise UsageError(f"`h` must be a number, got {h!r}") from None
    if not math.isfinite(value) or value == 0.0:
        raise UsageError(f"`h` must be finite and not zero, got {h!r}")
    return value


def _whole(x: float, what: str, h: float) -> int:
    n = round(x) if math.isfinite(x) else -1
    if n < 0 or abs(x - n) > _WHOLE * max(1, n):
        hint = f"; with h = {h * x / max(1, round(x))!r} it would be" if x > 0.5 else ""
        raise UsageError(f"{what} is not a whole number of steps of h = {h!r}{hint}")
    return n


def plan_of(
    problem: Problem, h: float, t_end: Any, steps: Any, every: Any, times: Any, limit: Any
) -> Plan:
    """Check what is asked for and turn it into step numbers; the arguments are those of ``solve``.

    Raises
    ------
        UsageError: for arguments that do not fit each other or the step size.
    """
    for name, value in (("steps", steps), ("every", every), ("step_limit", limit)):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if value is not None and not (whole and value >= 0):
            raise UsageError(f"`{name}` must be a whole number >= 0, got {value!r}")
    if times is not None:
        if every or steps is not None or t_end is not None:
            raise UsageError("give `times`, or `every` with `t_end` or `steps`, not both")
        t0 = float(problem.t_span[0])
        marks = tuple(_whole((float(t) - t0) / h, f"t = {float(t)!r}", h) for t in times)
        if not marks or any(b <= a for a, b in pairwise(marks)):
            raise UsageError("`times` must be a nonempty list in the direction of h")
    else:
        marks = (_total(problem, h, t_end, steps),)
    total = marks[-1] if limit is None else min(marks[-1], int(limit))
    limited = total < marks[-1]
    if every:
        grid = range(0, total + 1, every)
        rows = (*grid, total) if total % every else grid
    else:
        rows = (*(n for n in marks if n < total), total) if limited else marks
    return Plan(total, int(every), rows, limited)


def _total(problem: Problem, h: float, t_end: Any, steps: Any) -> int:
    """Number of steps, from itself or from the final time."""
    if steps is not None:
        if t_end is not None:
            raise UsageError("give `steps` or `t_end`, not both")
        return int(steps)
    if t_end is None and h < 0:
        raise UsageError("going back in time needs `t_end` or `steps`")
    t0, end = float(problem.t_span[0]), float(problem.t_span[1] if t_end is None else t_end)
    return _whole((end - t0) / h, f"t_end - t0 = {end - t0!r}", h)
