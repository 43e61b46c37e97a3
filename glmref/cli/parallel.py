"""Check many data files, in this process or in several, and lose none to another one's failure."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import partial
from multiprocessing import get_context
from threading import current_thread, main_thread
from time import perf_counter

from ..errors import GlmrefError
from ..findings import Finding
from ..system.process import end_with_parent
from ..views.tables import plain
from .output import internal_sentence

__all__ = ["Checked", "check", "check_all"]

#: Seconds that two new processes need before they give a first result (they import the package).
STARTUP = 1.0


@dataclass(frozen=True, slots=True)
class Checked:
    """What became of one data file.

    Attributes
    ----------
        name: name or path as it was asked for.
        findings: one for each claim.
        error: the sentence that says why there are none, or ``""``.
        internal: whether that is this program's fault.
        trace: the traceback of an internal error.
    """

    name: str
    findings: list[Finding] = field(default_factory=list)
    error: str = ""
    internal: bool = False
    trace: str = ""


Check = Callable[[str, Sequence[str]], Checked]


def check(name: str, only: Sequence[str] = (), budget: float | None = None) -> Checked:
    """Check one data file in a budget of processor time; every outcome is a record."""
    from ..verification.verifier import verify_file

    try:
        found = verify_file(name, only=only, budget=budget)
    except GlmrefError as error:
        return Checked(name, error=str(error))
    except Exception as error:
        import traceback

        text = "".join(traceback.format_exception(error))
        return Checked(name, error=internal_sentence(error, name), internal=True, trace=text)
    # only plain values travel between processes; the exact numbers behind them stay here
    return Checked(
        name, [replace(f, declared=plain(f.declared), value=plain(f.value)) for f in found]
    )


def check_all(
    names: Sequence[str],
    only: Sequence[str] = (),
    *,
    processes: int | None = None,
    budget: float | None = None,
) -> Iterator[Checked]:
    """Check data files in order.

    They are checked here until it is seen that what is left takes longer than starting processes.

    Args:
        names: names or paths.
        only: claims to check; all by default.
        processes: at most so many; as many as there are cores by default.
        budget: seconds of processor time for the proofs of each file, see
            :func:`~glmref.verification.verifier.verify_file`.
    """
    function = partial(check, budget=budget)
    processes = _cores() if processes is None else processes
    started = perf_counter()
    for done, name in enumerate(names):
        elapsed, left = perf_counter() - started, len(names) - done
        pays = done and elapsed > STARTUP / 2 and elapsed / done * left > 2 * STARTUP
        if processes > 1 and left > 2 and pays:
            yield from _in_processes(names[done:], only, min(processes, left), function=function)
            return
        yield function(name, only)


def _cores() -> int:
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _begin() -> None:
    """Leave Ctrl-C to the parent, and end with it, however it ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    end_with_parent()


@contextmanager
def _deaf_children() -> Iterator[None]:
    """Let processes started here be deaf to Ctrl-C from their first moment on, not only later."""
    if current_thread() is not main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)  # what is ignored is inherited
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _pool(processes: int) -> ProcessPoolExecutor:
    # spawn: the same on every system, and no thread of the parent can be caught half-way
    return ProcessPoolExecutor(processes, get_context("spawn"), _begin)


def _in_processes(
    names: Sequence[str], only: Sequence[str], processes: int, *, function: Check = check
) -> Iterator[Checked]:
    """Check in processes. A file that kills its process costs its own result, no other."""
    waiting = list(names)
    while waiting:
        pool = _pool(processes)
        try:
            with _deaf_children():
                results = pool.map(function, waiting, [only] * len(waiting))
            for checked in results:
                waiting.pop(0)
                yield checked
        except BrokenProcessPool:
            suspect = waiting.pop(0)
            yield _alone(suspect, only, function)
        finally:
            pool.shutdown(wait=False, cancel_futures=True)


def _alone(name: str, only: Sequence[str], function: Check) -> Checked:
    with _pool(1) as pool:
        try:
            with _deaf_children():
                future = pool.submit(function, name, only)
            return future.result()
        except BrokenProcessPool as error:
            return Checked(name, error=internal_sentence(error, name), internal=True)
