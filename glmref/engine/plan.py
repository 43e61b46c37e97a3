"""What a run is asked for: arguments checked, times turned into step numbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, overload

import numpy as np

from ..catalogue.lookup import is_broken, method_of
from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from . import kept

ARITHMETIC = ("strict", "fused", "quick", "compensated", "naive")

#: Numbers of steps that a double holds exactly, as t0 + n h needs them.
MOST_STEPS = 2**53

_WHOLE = 1e-9  # how far (t_end - t0) / h may be from an integer, per step


@dataclass(frozen=True)
class Grid(Sequence[int]):
    """Numbers 0, every, 2 every, ... up to ``last``, and ``last``; none of them is stored."""

    last: int
    every: int

    def __len__(self) -> int:
        return -(-self.last // self.every) + 1

    @overload
    def __getitem__(self, index: int) -> int: ...
    @overload
    def __getitem__(self, index: slice) -> list[int]: ...
    def __getitem__(self, index: int | slice) -> int | list[int]:
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        place = index if index >= 0 else len(self) + index
        if not 0 <= place < len(self):
            raise IndexError(index)
        return min(place * self.every, self.last)

    def __contains__(self, n: object) -> bool:
        return isinstance(n, int) and 0 <= n <= self.last and (not n % self.every or n == self.last)


@dataclass(frozen=True)
class Plan:
    """Which steps are taken and which are kept."""

    steps: int  #: How many steps.
    every: int  #: Record every so many, 0 for none.
    rows: Sequence[int]  #: Step numbers to keep, in order.
    limited: bool  #: Whether a step limit cut the run short.


def check_arithmetic(arithmetic: str) -> None:
    """Refuse a word that names no arithmetic, see :func:`.kernel.prepare`.

    Raises
    ------
    UsageError
        For anything but one of :data:`ARITHMETIC`.
    """
    if arithmetic not in ARITHMETIC:
        raise UsageError(f"`arithmetic` must be one of {', '.join(ARITHMETIC)}, got {arithmetic!r}")


def resolved(problem: Any, method: Any) -> tuple[Problem, Any]:
    """Return problem and method, either given by name.

    Raises
    ------
    UsageError
        For anything else, a problem moved to another precision, or the name of a method that is
        wrong on purpose: such a one is taken as an object only.
    """
    if isinstance(problem, str):
        problem = kept.problem_of(problem)
    if isinstance(method, str | Path):
        if is_broken(method):
            raise UsageError(
                f"the method {str(method)!r} is wrong on purpose; to run it all the same give "
                f"glmref.load({str(method)!r})"
            )
        method = kept.method_of(method)
    method = method_of(method)
    if not isinstance(problem, Problem):
        raise UsageError(
            f"`problem` must be a Problem or its name, got {type(problem).__name__}; "
            f"glmref.Problem(f=..., y0=...) makes one of a function f(t, y)"
        )
    if problem.context is not None:
        raise UsageError("`problem` must be the one in double precision; give `digits` instead")
    return problem, method


def notices_of(method: Method) -> list[str]:
    """Return what is to be said of every run with a method: that it is wrong on purpose."""
    broken = (method.document or {}).get("broken")
    return [f"{method.name} is wrong on purpose: {broken['why']}"] if broken else []


def step_size(h: Any) -> float:
    """Return h as a number, finite and not zero.

    Raises
    ------
    UsageError
        When it is not.
    """
    try:
        value = float(h)
    except (TypeError, ValueError):
        raise UsageError(f"`h` must be a number, got {h!r:.60}") from None
    except OverflowError:
        raise UsageError("`h` must be finite, got a number beyond double precision") from None
    if not math.isfinite(value) or value == 0.0:
        raise UsageError(f"`h` must be finite and not zero, got {h!r}")
    return value


def _time(value: Any, name: str) -> float:
    """Read a time: a finite number."""
    try:
        time = float(value)
    except (TypeError, ValueError, OverflowError):
        raise UsageError(f"`{name}` must be a number, got {value!r:.60}") from None
    if not math.isfinite(time):
        raise UsageError(f"`{name}` must be finite, got {value!r}")
    return time


def _whole(time: float, t0: float, what: str, h: float) -> int:
    """Steps of h from t0 to a time."""
    span = time - t0
    x = span / h
    if not abs(x) <= MOST_STEPS:
        raise UsageError(
            f"{what} is {abs(x):.3g} steps of h = {h!r} away from t0 = {t0!r}; at most 2**53 can "
            f"be counted, give another h"
        )
    n = round(x)
    if x < 0 and n < 0:
        raise UsageError(
            f"{what} is {'before' if h > 0 else 'after'} t0 = {t0!r}, which steps of h = {h!r} do "
            f"not reach; change the sign of h"
        )
    if n < 0 or abs(x - n) > _WHOLE * max(1, n):
        hint = f"; with h = {span / max(1, round(x))!r} it would be" if x > 0.5 else ""
        raise UsageError(
            f"{what} is {span!r} from t0, which is not a whole number of steps of h = {h!r}{hint}"
        )
    return n


def plan_of(
    problem: Problem, h: float, t_end: Any, steps: Any, every: Any, times: Any, limit: Any
) -> Plan:
    """Check what is asked for and turn it into step numbers; the arguments are those of ``solve``.

    Raises
    ------
    UsageError
        For arguments that do not fit each other or the step size.
    """
    for name, value in (("steps", steps), ("every", every), ("step_limit", limit)):
        whole = isinstance(value, int | np.integer) and not isinstance(value, bool)
        if value is not None and not (whole and value >= 0):
            raise UsageError(f"`{name}` must be a whole number >= 0, got {value!r:.60}")
    t0 = float(problem.t_span[0])
    if times is not None:
        if every or steps is not None or t_end is not None:
            raise UsageError("give `times`, or `every` with `t_end` or `steps`, not both")
        marks = _marks(times, t0, h)
    else:
        marks = (_total(problem, h, t_end, steps),)
    total = marks[-1] if limit is None else min(marks[-1], int(limit))
    limited = total < marks[-1]
    _advances(t0, h, total)
    if every:
        # a longer stride than the run is one beyond its end; a kernel counts in 64 bits
        every = min(int(every), total + 1)
        rows: Sequence[int] = Grid(total, every)
    else:
        rows = (*(n for n in marks if n < total), total) if limited else marks
    return Plan(total, int(every or 0), rows, limited)


def _total(problem: Problem, h: float, t_end: Any, steps: Any) -> int:
    """Number of steps, from itself or from the final time."""
    if steps is not None:
        if t_end is not None:
            raise UsageError("give `steps` or `t_end`, not both")
        if steps > MOST_STEPS:
            raise UsageError(f"`steps` must be at most 2**53, got {_short(steps)}")
        return int(steps)
    if t_end is None and h < 0:
        raise UsageError("going back in time needs `t_end` or `steps`")
    t0 = float(problem.t_span[0])
    end = _time(problem.t_span[1] if t_end is None else t_end, "t_end")
    return _whole(end, t0, "t_end", h)


def _marks(times: Any, t0: float, h: float) -> tuple[int, ...]:
    """Step numbers of the times asked for."""
    alone = isinstance(times, np.ndarray) and times.ndim == 0  # which Python calls iterable
    if isinstance(times, str) or alone or not isinstance(times, Iterable):
        raise UsageError(f"`times` must be a list of numbers, got {times!r:.60}")
    wanted = [_time(t, "times") for t in times]
    marks = tuple(_whole(t, t0, f"t = {t!r}", h) for t in wanted)
    if not marks:
        raise UsageError("`times` must be a nonempty list in the direction of h")
    for (a, m), (b, n) in pairwise(zip(wanted, marks, strict=True)):
        if n <= m:
            raise UsageError(
                f"`times` must be a nonempty list in the direction of h, each time once; "
                f"{b!r} comes after {a!r}"
            )
    return marks


def _advances(t0: float, h: float, total: int) -> None:
    """Refuse a run whose time stands still or leaves the range of doubles."""
    if not total:
        return
    end = t0 + total * h
    if not math.isfinite(end):
        raise UsageError(
            f"{total} steps of h = {h!r} from t0 = {t0!r} lead beyond the range of double "
            f"precision; take fewer or smaller steps"
        )
    if t0 + h == t0 or end - h == end:
        where = t0 if t0 + h == t0 else end
        raise UsageError(
            f"h = {h!r} is lost in rounding when it is added to t = {where!r}; "
            f"give a larger h, or begin nearer to t = 0"
        )


def _short(n: int) -> str:
    return str(n) if n < 10**30 else f"a number of {n.bit_length()} bits"
