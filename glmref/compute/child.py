"""A process that carries out one task at a time, under limits; whatever happens, a result is said.

The local back end has one such child for each task that runs; a Dask worker has one for each of its
threads. A task that hangs, takes too much memory or kills its process so ends in the same way
everywhere, and costs neither the worker nor another task.
"""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import time
import traceback
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import CancelledError, ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, replace
from multiprocessing import current_process, get_context, resource_tracker
from pathlib import Path
from threading import Lock
from time import perf_counter
from typing import Any

from ..errors import GlmrefError, UsageError
from ..system.files import reason
from ..system.process import end_with_parent

try:
    import resource
except ImportError:  # not POSIX: there are no limits of memory
    resource = None  # type: ignore[assignment]

Task = Mapping[str, Any]
#: What carries out a task: a function of a module, which another process can import.
Function = Callable[[Task], Any]

#: How a task can fail.
FAILED = "internal error"
KILLED = "process killed"
MEMORY = "memory exhausted"
REFUSED = "refused"
TIME_LIMIT = "time limit"

#: Libraries read these when they are loaded; a task has one thread, or cores would be shared.
_ONE_THREAD = (
    *("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"),
    *("VECLIB_MAXIMUM_THREADS", "BLIS_NUM_THREADS"),
)
#: An orphaned child, whose parent was killed, ends after this many limits.
_ABANDONED = 2.0
#: Seconds that a timed task waits for a core.
_WAIT = 20.0
_starting = Lock()


@dataclass(frozen=True, slots=True)
class Limits:
    """What a task may take."""

    seconds: float | None = None  #: Wall-clock time of one task; its process is killed then.
    memory: int | None = None  #: Bytes of data of its process (``RLIMIT_DATA``).
    retries: int = 2  #: How often a task whose process died is tried again.
    #: Whether it has a core of its own, on which no other such task of this user runs: for what is
    #: timed.
    pinned: bool = False


UNLIMITED = Limits()


@dataclass(frozen=True, slots=True)
class Done:
    """What became of a task."""

    value: Any = None  #: What the function returned.
    #: Why there is no value (:data:`FAILED`, :data:`KILLED`, :data:`MEMORY`, :data:`REFUSED`,
    #: :data:`TIME_LIMIT`), or ``""``.
    failure: str = ""
    #: One sentence on the failure; the traceback of an internal error.
    message: str = ""
    trace: str = ""
    attempts: int = 1  #: How often it was tried.
    seconds: float = 0.0  #: Wall-clock time of the last attempt.

    def as_record(self) -> dict[str, Any]:
        """Return the value, or the failure as a record."""
        if not self.failure:
            return self.value
        return {"outcome": self.failure, "message": self.message, "attempts": self.attempts}


#: Tasks that have ended since the last list, each with what became of it.
Results = list[tuple[Task, Done]]


def attempt(function: Function, task: Task) -> Done:
    """Carry out a task in this process; an exception becomes a failure."""
    begun = perf_counter()
    try:
        done = Done(function(task))
    except MemoryError:
        done = Done(failure=MEMORY, message="the memory did not suffice")
    except GlmrefError as error:
        done = Done(failure=REFUSED, message=str(error))
    except Exception as error:
        trace = "".join(traceback.format_exception(error))
        done = Done(failure=FAILED, message=f"{type(error).__name__}: {error}", trace=trace)
    return replace(done, seconds=perf_counter() - begun)


class Child:
    """A process for one task after another; it is started when it is needed, and again if it died.

    It is a pool of one: where several tasks share a pool, one that kills its process ends them all.
    Relative paths begin in ``folder``, if there is such a folder; by default as in this process.
    """

    def __init__(self, limits: Limits, folder: str = "") -> None:
        self.limits, self.folder = limits, folder
        self._pool: ProcessPoolExecutor | None = None
        self._ended = False

    def carry_out(self, function: Function, task: Task) -> Done:
        """Carry out a task; one whose process dies is tried again, as often as the limits say."""
        done = Done()
        for number in range(1, self.limits.retries + 2):
            done = replace(self._once(function, task), attempts=number)
            if done.failure != KILLED or self._ended:
                break
        return done

    def _once(self, function: Function, task: Task) -> Done:
        limit, begun = self.limits.seconds, perf_counter()
        failure = Done(failure=KILLED, message="the process of the task ended before it did")
        pool = self._pool or self._start()
        try:
            return pool.submit(_attempt_in, function, task, limit).result(limit)
        except TimeoutError:
            failure = Done(failure=TIME_LIMIT, message=f"stopped after {limit:g} s")
        except (BrokenProcessPool, CancelledError, RuntimeError):  # it died, or was ended
            pass
        except Exception as error:
            message = f"the result cannot be sent ({type(error).__name__}: {error})"
            return Done(failure=FAILED, message=message)
        self._kill()
        return replace(failure, seconds=perf_counter() - begun)

    def _start(self) -> ProcessPoolExecutor:
        try:
            os.chdir(os.getcwd())  # as the process will
        except OSError as error:
            raise UsageError(
                f"processes begin in the current folder, and that cannot be entered "
                f"({reason(error)}); go to another one"
            ) from None
        with _starting:
            _start_tracker()  # before the first semaphore, which would start it otherwise
        # spawn: the same on every system, and no thread of the parent can be caught half-way
        pool = ProcessPoolExecutor(1, get_context("spawn"), _begin, (self.limits, self.folder))
        self._pool = pool
        with _starting, _surroundings():
            ready = pool.submit(_ready, self.limits.pinned)
        try:
            if not self._ended and not ready.result():
                raise UsageError(
                    "timed tasks need a core each, and all cores have one; ask for fewer "
                    "processes, or wait until the other run has ended"
                )
        except (OSError, CancelledError, BrokenProcessPool, UsageError) as error:
            self._kill()
            if isinstance(error, BrokenProcessPool) and not self._ended:
                raise UsageError(
                    "a process for tasks cannot be started; a script that asks for processes needs "
                    "`if __name__ == '__main__':` before what it does"
                ) from None
            if not self._ended:
                raise
        if self._ended:  # while it was started: it may have been ended before a process existed
            _stop(pool)
        return pool

    def _kill(self) -> None:
        pool, self._pool = self._pool, None
        if pool is not None:
            _stop(pool)

    def end(self) -> None:
        """End the process, whatever it does; a task that it had is not tried again."""
        self._ended = True
        self._kill()


def _stop(pool: ProcessPoolExecutor) -> None:
    """Kill the processes of a pool, which takes no task any more on return."""
    for process in list((pool._processes or {}).values()):
        process.kill()
    pool.shutdown(wait=False, cancel_futures=True)


# --- inside of the child --------------------------------------------------------------------------


def _begin(limits: Limits, folder: str) -> None:
    """Leave Ctrl-C to the parent, end with it, however it ends, and take on the limits."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if hasattr(signal, "pthread_sigmask"):
        signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})
    end_with_parent()
    if folder:
        with contextlib.suppress(OSError):
            os.chdir(folder)
    if limits.memory is not None and resource is not None:
        with contextlib.suppress(OSError, ValueError):
            _, most = resource.getrlimit(resource.RLIMIT_DATA)
            resource.setrlimit(resource.RLIMIT_DATA, (limits.memory, most))


def _attempt_in(function: Function, task: Task, limit: float | None) -> Done:
    if limit is None or not hasattr(signal, "setitimer"):
        return attempt(function, task)
    # the parent ends what takes too long; this timer, which needs no interpreter, serves where
    # the parent is gone and machine code holds the interpreter, so that no thread runs
    signal.setitimer(signal.ITIMER_REAL, _ABANDONED * limit + 1)
    try:
        return attempt(function, task)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)


#: What holds the core of this process, until it ends.
_core: list[socket.socket] = []


def _ready(pinned: bool) -> bool:
    """Stay on a physical core that no other timed task of this user has; wait a while for one.

    A core is held by a name among the local sockets of Linux, which ends with its process and is no
    file. Nothing is sent. False where there is no core; elsewhere than on Linux, and where no core
    is needed, always true.
    """
    if not pinned or not hasattr(os, "sched_setaffinity"):
        return True
    mine, until = physical_cores(), perf_counter() + _WAIT
    while perf_counter() < until:
        for core in mine:
            holder = socket.socket(socket.AF_UNIX)
            try:
                holder.bind(f"\0glmref-{os.getuid()}-core-{core}")
            except OSError:
                holder.close()
                continue
            _core.append(holder)
            os.sched_setaffinity(0, {core})
            return True
        time.sleep(0.1)
    return False


# --- around the start of a child ------------------------------------------------------------------


def _start_tracker() -> None:
    """Start the process of Python that unlinks the semaphores that this process leaves.

    A process that a signal ends leaves its semaphores to it; users need no warning of that.
    """
    if not hasattr(signal, "pthread_sigmask"):
        return
    before = os.environ.get("PYTHONWARNINGS")
    os.environ["PYTHONWARNINGS"] = f"{before or ''},ignore:resource_tracker"
    try:
        resource_tracker.ensure_running()
    finally:
        if before is None:
            del os.environ["PYTHONWARNINGS"]
        else:
            os.environ["PYTHONWARNINGS"] = before


@contextlib.contextmanager
def _surroundings() -> Iterator[None]:
    """Set what a child inherits: one thread, and Ctrl-C ignored from its first moment on."""
    before = {name: os.environ[name] for name in _ONE_THREAD if name in os.environ}
    os.environ.update(dict.fromkeys(_ONE_THREAD, "1"))
    # a worker that Dask's nanny started counts as a daemon, and such may have no children; ours
    # end with their parent whatever happens to it
    config = current_process()._config  # type: ignore[attr-defined]
    daemon, config["daemon"] = config.get("daemon"), False
    heard = None
    if hasattr(signal, "pthread_sigmask"):
        # spawning would start it otherwise, which unblocks SIGINT before the child is there
        _start_tracker()
        heard = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        if heard is not None:
            signal.pthread_sigmask(signal.SIG_SETMASK, heard)
        config["daemon"] = daemon
        for name in _ONE_THREAD:
            del os.environ[name]
        os.environ.update(before)


def cores() -> list[int]:
    """Return the logical cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return sorted(os.sched_getaffinity(0))
    return list(range(os.cpu_count() or 1))


def physical_cores() -> list[int]:
    """Return one of the usable logical cores for each physical core."""
    kept: dict[str, int] = {}
    for core in cores():
        place = Path(f"/sys/devices/system/cpu/cpu{core}/topology/thread_siblings_list")
        try:
            siblings = place.read_text(encoding="ascii").strip()
        except OSError:
            siblings = str(core)
        kept.setdefault(siblings, core)
    return list(kept.values())
