"""Tasks on a Dask cluster; Dask is imported when one is chosen.

Dask decides which worker takes which task, and gives the tasks of a lost worker to others. Each
thread of a worker has a :class:`~.child.Child` for its tasks, so that what a task does to its
process, the worker survives, and machine code that holds the interpreter does not silence it.
Results come back to this process, the only one that writes records. Short tasks travel together.
"""

from __future__ import annotations

import logging
import os
import sys
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from importlib import import_module
from importlib.util import find_spec
from itertools import count, islice
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Lock
from time import monotonic
from typing import Any
from uuid import uuid4

from ..errors import UsageError
from ..system.files import printable
from ..system.terminal import saying
from .child import KILLED, UNLIMITED, Child, Done, Function, Limits, Results, Task, cores
from .identity import difference, identity

#: Seconds of work that tasks which travel together may hold, and how many they may be. A parcel
#: costs client, scheduler and worker some 10 ms of processor time, whatever it holds.
TOGETHER, MOST = 0.5, 256
#: Seconds after which the scheduler is asked how many threads its workers have.
ASK = 5.0
#: What Dask notes for its developers in a cluster that is started here. By default a scheduler has
#: the profile of each of the last 1,000 s and 7,200 samples of the load of its machine, so that its
#: memory grows for an hour, whatever it does; and scheduler, nannies and workers each measure fifty
#: times a second how fast they answer, which takes a tenth of a core from the tasks.
QUIET = {
    "distributed.admin.tick.interval": "1s",
    "distributed.admin.system-monitor.interval": "2s",
    "distributed.admin.log-length": 1_000,
    "distributed.admin.low-level-log-length": 100,
    "distributed.admin.system-monitor.log-length": 100,
    "distributed.worker.profile.enabled": False,
}
#: Seconds to wait for a scheduler that does not answer, and for a worker where all have died.
PATIENCE = 30.0


# --- on a worker ----------------------------------------------------------------------------------

_idle: dict[tuple[Limits, str], list[Child]] = {}
_lock = Lock()


def carry_out(
    function: Function, tasks: Sequence[Task], limits: Limits, expected: dict[str, str], folder: str
) -> list[Done] | str:
    """Carry out tasks one after another in a child of this worker, in the client's folder.

    Returns
    -------
    list of Done, or str
        What became of the first tasks: the others are left, for any worker, where these took much
        longer than was expected. Or the sentence that refuses them all, where this worker is not
        what the client is.
    """
    if wrong := difference(identity(), expected):
        return wrong
    with _lock:
        wanted = (limits, folder)
        for other in [x for x in _idle if x != wanted]:  # timed and untimed tasks never mix
            for child in _idle.pop(other):
                child.end()
        children = _idle.setdefault(wanted, [])
        child = children.pop() if children else Child(limits, folder)
    try:
        until = monotonic() + 2 * TOGETHER
        done = [child.carry_out(function, tasks[0])]
        while len(done) < len(tasks) and monotonic() < until:
            done.append(child.carry_out(function, tasks[len(done)]))
        return done
    finally:
        with _lock:
            children.append(child)


# --- at the client --------------------------------------------------------------------------------


class Dask:
    """A Dask cluster.

    Parameters
    ----------
    client : distributed.Client
        Connected to its scheduler.
    name : str
        As it is chosen.
    """

    def __init__(self, client: Any, name: str) -> None:
        self.client, self.name, self.threads = client, name, 1
        self.dashboard: str = client.dashboard_link if find_spec("bokeh") else ""

    def run(
        self, function: Function, tasks: Iterable[Task], limits: Limits = UNLIMITED
    ) -> Iterator[Results]:
        """Carry out tasks; see :class:`~.executors.Executor`."""
        return _Run(self, function, limits).results(iter(tasks))


class _Run:
    """One call of :meth:`Dask.run`."""

    def __init__(self, dask: Dask, function: Function, limits: Limits) -> None:
        self.dask, self.client, self.function, self.limits = dask, dask.client, function, limits
        self.ended: SimpleQueue[Any] = SimpleQueue()
        self.sent: dict[tuple[str, int], tuple[Any, list[Task], int]] = {}
        self.prefix, self.numbers = f"glmref-{uuid4().hex}", count()
        self.waiting: deque[Task] = deque()
        self.mean: float | None = None
        self.lost = False
        self.asked_at, self.alive_at = -ASK, monotonic()

    def results(self, waiting: Iterator[Task]) -> Iterator[Results]:
        """Keep every thread busy, with one parcel of tasks more behind the one that it has."""
        try:
            while True:
                self._count_threads()
                while len(self.sent) < 2 * self.dask.threads and (parcel := self._parcel(waiting)):
                    self._send(parcel, 1)
                if not self.sent:
                    return
                if results := self._collect():
                    yield results
        finally:
            with suppress(Exception):
                if not self.lost:  # a scheduler that does not answer would be waited for
                    self.client.cancel([future for future, _, _ in self.sent.values()])

    def _count_threads(self) -> None:
        if monotonic() - self.asked_at > ASK:
            known = self._answer(self.client.scheduler.ncores)
            self.dask.threads, self.asked_at = max(1, sum(known.values())), monotonic()
            self.alive_at = self.asked_at if known else self.alive_at
            # a scheduler of the user's own may wait for workers as long as it wants
            if self.client.cluster is not None and self.asked_at - self.alive_at > PATIENCE:
                raise UsageError(
                    "all workers of the Dask cluster died, and none was started again; what had "
                    "ended is kept, so run the same command again"
                )
            # Dask keeps the last 100,000 keys in it, half a kilobyte each
            if (utils := sys.modules.get("dask.utils")) is not None:
                getattr(utils.key_split, "cache_clear", bool)()

    def _answer(self, ask: Callable[[], Any]) -> Any:
        """Return the answer of the scheduler; mention on the terminal that it is late.

        Parameters
        ----------
        ask : callable
            Returns what is awaited; it is called again where there is no answer after ``ASK`` s.

        Raises
        ------
        UsageError
            When the connection is lost, or there is no answer within ``PATIENCE`` s more.
        """
        try:
            try:
                return self.client.sync(ask, callback_timeout=ASK)
            except TimeoutError:
                with saying(f"the Dask scheduler does not answer; waiting for {PATIENCE:g} s ..."):
                    return self.client.sync(ask, callback_timeout=PATIENCE)
        except Exception:
            raise self._lost() from None

    def _parcel(self, waiting: Iterator[Task]) -> list[Task]:
        """Tasks that travel together: as many as take :data:`TOGETHER` seconds, fewer at the end.

        What is left is divided among the threads, so that none has work long after the others.
        """
        most, parts = 1, 2 * self.dask.threads
        if self.mean is not None and not self.limits.pinned:
            most = max(1, min(MOST, int(TOGETHER / max(self.mean, 1e-6))))
        self.waiting.extend(islice(waiting, max(0, most * parts - len(self.waiting))))
        size = min(most, -(-len(self.waiting) // parts))
        return [self.waiting.popleft() for _ in range(size)]

    def _send(self, parcel: list[Task], number: int) -> None:
        # one group of tasks for the whole run: the scheduler never forgets one
        key = (self.prefix, next(self.numbers))
        try:
            future = self.client.submit(
                carry_out, self.function, parcel, self.limits, identity(), os.getcwd(),
                key=key, pure=False,
            )  # fmt: skip
        except Exception:
            raise self._lost() from None
        self.sent[key] = (future, parcel, number)
        future.add_done_callback(self.ended.put)

    def _collect(self) -> Results:
        """Wait for a parcel, take those that have ended as well, and fetch their results."""
        try:
            futures = [self.ended.get(timeout=1.0)]
        except Empty:
            if self.client.status not in ("running", "connecting"):
                raise self._lost() from None
            return []
        with suppress(Empty):
            while True:
                futures.append(self.ended.get_nowait())
        if any(future.status in ("cancelled", "lost") for future in futures):
            raise self._lost()
        good = [future for future in futures if future.status == "finished"]
        found = self._answer(lambda: self.client.gather(good, asynchronous=True))
        values = dict(zip([x.key for x in good], found, strict=True))
        results: Results = []
        for future in futures:
            _, parcel, number = self.sent.pop(future.key)
            if future.key in values:
                results += self._results_of(parcel, values[future.key])
            else:
                results += self._failed(future, parcel, number)
        return results

    def _results_of(self, parcel: list[Task], value: list[Done] | str) -> Results:
        if isinstance(value, str):
            raise UsageError(f"a worker of {self.client.scheduler.address} {value}")
        for done in value:
            self.mean = done.seconds if self.mean is None else 0.9 * self.mean + 0.1 * done.seconds
        self.waiting.extendleft(reversed(parcel[len(value) :]))
        return list(zip(parcel, value, strict=False))

    def _failed(self, future: Any, parcel: list[Task], number: int) -> Results:
        """Try a parcel whose workers died again, task by task; after the retries say so."""
        error = future.exception()
        if isinstance(error, UsageError):
            raise error
        if type(error).__name__ != "KilledWorker":
            raise UsageError(
                f"the workers of {self.client.scheduler.address} cannot carry out a task "
                f"({type(error).__name__}: {error}); install the same glmref there"
            )
        if number <= self.limits.retries:
            for task in parcel:
                self._send([task], number + 1)
            return []
        message = f"the workers that had the task died, {number} times"
        return [(task, Done(failure=KILLED, message=message, attempts=number)) for task in parcel]

    def _lost(self) -> UsageError:
        self.lost = True
        return UsageError(
            "the connection to the scheduler of the Dask cluster was lost; what had ended is kept, "
            "so start the scheduler again and run the same command"
        )


@contextmanager
def cluster(where: str) -> Iterator[Dask]:
    """Connect to a cluster, or start one on this machine.

    Parameters
    ----------
    where : str
        Empty or a number: workers of a cluster that is started here and closed in the end. The
        address of a scheduler, or the file that it wrote.

    Raises
    ------
    UsageError
        Where Dask is not installed, or no scheduler answers.
    """
    local = not where or where.isdecimal()
    number = (int(where[:5]) if where else len(cores())) if local else 0
    if local and not 0 < number < 10_000:
        raise UsageError("a cluster needs one worker or more, and has 9999 at the most")
    try:
        distributed = import_module("distributed")
    except ImportError:
        raise UsageError(
            "--on dask needs Dask, which is not installed; install it with "
            "`pip install 'glmref[cluster]'`"
        ) from None
    level = logging.DEBUG if os.environ.get("GLMREF_DEBUG") else logging.CRITICAL
    for logger in ("distributed", "distributed.client"):  # Dask gives the second a level, too
        logging.getLogger(logger).setLevel(level)
    if local:
        with import_module("dask").config.set(QUIET), ExitStack() as opened:
            try:
                made = opened.enter_context(
                    distributed.LocalCluster(
                        n_workers=number,
                        threads_per_worker=1,
                        processes=True,
                        silence_logs=level,  # of its workers
                        memory_limit=0,  # tasks have processes of their own, with their limits
                        dashboard_address=":0",  # any free port: another may have the usual one
                    )
                )
            except RuntimeError as error:
                raise UsageError(
                    f"no Dask cluster can be started here ({error}); a script that asks for one "
                    f"needs `if __name__ == '__main__':` before what it does"
                ) from None
            yield Dask(opened.enter_context(distributed.Client(made)), f"dask:{number}")
        return
    is_file = "://" not in where and not where.rpartition(":")[2].isdecimal()
    if is_file and not Path(where).is_file():
        raise UsageError(
            f"there is no file {printable(where)}; name the file of a Dask scheduler, or its "
            f"address as in dask:tcp://HOST:8786"
        )
    given = {"scheduler_file": where} if is_file else {"address": where}
    try:
        client = distributed.Client(**given, timeout=PATIENCE)
    except (OSError, TimeoutError, ValueError) as error:
        raise UsageError(
            f"no Dask scheduler answers at {where} ({error or type(error).__name__}); start one "
            f"with `dask scheduler`, or look whether the network lets it through"
        ) from None
    with client:
        yield Dask(client, f"dask:{where}")
