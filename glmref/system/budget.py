"""A limit to the processor time of a proof, looked at wherever exact arithmetic is slow.

The time of the running thread counts, so that a busy machine changes nothing. One operation on
algebraic numbers is not interrupted: the limit takes effect when it returns. The command line has
the files of users decided in processes that are ended where it does not return (`process.apart`).
"""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from time import monotonic, thread_time

from ..errors import BudgetError, UndecidedError

#: Seconds of processor time that reading one file of a user may take.
READING = 2.0
#: Seconds of processor time that the proofs of one file of a user may take, unless asked otherwise.
PROVING = 60.0
#: Seconds of processor time after which an operation that exceeds a budget is ended.
EXCESS = 2.0
#: Most coefficients of a linear system that is written down; each takes up to 100 bytes.
CELLS = 20_000_000
#: Objects more than before at which cycles are looked for, where that takes a part of the time.
COLLECT_AFTER = 50_000


@dataclass(slots=True)
class _Limit:
    """A budget in force.

    A thread computes no longer than time passes, so that the clock of its processor time, which
    takes microseconds to read, is left alone until ``wake``.
    """

    until: float  # processor time of the thread at which the budget is spent
    seconds: float  # the whole budget
    wake: float = 0.0  # monotonic time before which it cannot be spent


_limit: ContextVar[_Limit | None] = ContextVar("limit", default=None)


@contextmanager
def limited(seconds: float | None, used: float = 0.0) -> Iterator[None]:
    """Let what is computed inside take at most so much processor time, ``used`` before included.

    ``None`` sets no limit of its own. A limit that is already there stays.

    Raises
    ------
    BudgetError
        From :func:`spend`, when it is spent.
    """
    outer = _limit.get()
    if seconds is None:
        yield
        return
    until = thread_time() + seconds - used
    inner = outer if outer is not None and outer.until <= until else _Limit(until, seconds)
    token = _limit.set(inner)
    try:
        yield
    finally:
        _limit.reset(token)


@contextmanager
def rarely_collected() -> Iterator[None]:
    """Look for cycles rarely: what is computed inside makes many objects, and leaves few cycles."""
    before = gc.get_threshold()
    gc.set_threshold(COLLECT_AFTER, *before[1:])
    try:
        yield
    finally:
        gc.set_threshold(*before)


def spend() -> None:
    """Look whether the budget is spent.

    Raises
    ------
    BudgetError
        When it is.
    """
    limit = _limit.get()
    if limit is None or (now := monotonic()) < limit.wake:
        return
    rest = limit.until - thread_time()
    if rest < 0:
        raise spent(limit.seconds)
    limit.wake = now + rest


def left() -> tuple[float, float] | tuple[None, None]:
    """Return seconds of processor time that are left, and of the budget.

    The result is ``None`` without a limit.
    """
    limit = _limit.get()
    return (None, None) if limit is None else (limit.until - thread_time(), limit.seconds)


def spent(seconds: float, where: str = "") -> BudgetError:
    """Return the error of a budget that is spent."""
    return BudgetError(f"the budget of {seconds:g} s of processor time is spent{where}")


def fits(unknowns: int, equations: int, what: str) -> None:
    """Look whether a linear system is small enough to be written down.

    Raises
    ------
    UndecidedError
        When it has more than :data:`CELLS` coefficients.
    """
    if unknowns * equations > CELLS:
        raise UndecidedError(
            f"the linear system for {what} has {unknowns} unknowns and {equations} equations, more "
            f"than is computed"
        )
