"""The arguments of a run: checked, times turned into step numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, overload

from ..catalogue.lookup import is_broken, method_of
from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from ..system.arguments import listed, number, one_of, shown, whole
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


def check_arithmetic(arithmetic: str) -> str:
    """Return a word that names an arithmetic, see :func:`.kernel.prepare`.

    Raises
    ------
    UsageError
        For anything but one of :data:`ARITHMETIC`.
    """
    return one_of("arithmetic", arithmetic, ARITHMETIC)


def check_callable(name: str, given: Any) -> None:
    """Refuse what is neither a function nor ``None``.

    Raises
    ------
    UsageError
        For it.
    """
    if given is not None and not callable(given):
        raise UsageError(f"`{name}` must be a function, got {shown(given)}")


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
    value = number("h", h)
    if value == 0.0:
        raise UsageError(f"`h` must be finite and not zero, got {shown(h)}")
    return value


def check_direction(time: float, t0: float, what: str, h: float) -> None:
    """Refuse a time that steps of h from t0 lead away from.

    Raises
    ------
    UsageError
        Naming the time as ``what``.
    """
    if (time - t0) * math.copysign(1, h) < 0:
        raise UsageError(
            f"{what} is {'before' if h > 0 else 'after'} t0 = {t0!r}, which steps of h = {h!r} do "
            f"not reach; change the sign of h"
        )


def _whole(time: float, t0: float, what: str, h: float) -> int:
    """Return steps of h from t0 to a time."""
    span = time - t0
    x = span / h
    if not abs(x) <= MOST_STEPS:
        raise UsageError(
            f"{what} is {abs(x):.3g} steps of h = {h!r} away from t0 = {t0!r}; at most 2**53 can "
            f"be counted, give another h"
        )
    n = round(x)
    if n < 0:
        check_direction(time, t0, what, h)
    if abs(x - n) > _WHOLE * max(1, n):
        hint = f"; with h = {span / max(1, round(x))!r} it would be" if x > 0.5 else ""
        raise UsageError(
            f"{what} is {span!r} from t0, which is not a whole number of steps of h = {h!r}{hint}"
        )
    return n


def plan_of(
    problem: Problem, h: float, t_end: Any, steps: Any, every: Any, times: Any, limit: Any
) -> Plan:
    """Check the arguments of ``solve`` and turn them into step numbers.

    Raises
    ------
    UsageError
        For arguments that do not fit each other or the step size.
    """
    given = (("steps", steps), ("every", every), ("step_limit", limit))
    steps, every, limit = (None if x is None else whole(name, x) for name, x in given)
    t0 = float(problem.t_span[0])
    if times is not None:
        if every or steps is not None or t_end is not None:
            raise UsageError("give `times`, or `every` with `t_end` or `steps`, not both")
        marks = _marks(times, t0, h)
    else:
        marks = (_total(problem, h, t_end, steps),)
    total = marks[-1] if limit is None else min(marks[-1], limit)
    limited = total < marks[-1]
    _advances(t0, h, total)
    if every:
        # a longer stride than the run is one beyond its end; a kernel counts in 64 bits
        every = min(every, total + 1)
        rows: Sequence[int] = Grid(total, every)
    else:
        rows = (*(n for n in marks if n < total), total) if limited else marks
    return Plan(total, every or 0, rows, limited)


def _total(problem: Problem, h: float, t_end: Any, steps: int | None) -> int:
    """Return the number of steps, from itself or from the final time."""
    if steps is not None:
        if t_end is not None:
            raise UsageError("give `steps` or `t_end`, not both")
        if steps > MOST_STEPS:
            raise UsageError(f"`steps` must be at most 2**53, got {_short(steps)}")
        return steps
    if t_end is None and h < 0:
        raise UsageError("going back in time needs `t_end` or `steps`")
    t0 = float(problem.t_span[0])
    end = number("t_end", problem.t_span[1] if t_end is None else t_end)
    total = _whole(end, t0, "t_end", h)
    if not total and end != t0:
        raise UsageError(f"t_end is {end!r}, less than a step of h = {h!r} from t0 = {t0!r}")
    return total


def _marks(times: Any, t0: float, h: float) -> tuple[int, ...]:
    """Return step numbers of the times asked for."""
    marks: list[int] = []
    last = t0
    for value in listed("times", times):
        t = number("times", value)
        n = _whole(t, t0, f"t = {t!r}", h)
        if marks and n <= marks[-1]:
            raise UsageError(
                f"`times` must be a nonempty list in the direction of h, each time once; "
                f"{t!r} comes after {last!r}"
            )
        marks.append(n)
        last = t
    if not marks:
        raise UsageError("`times` must be a nonempty list in the direction of h")
    return tuple(marks)


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
