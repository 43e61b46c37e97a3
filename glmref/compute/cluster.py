"""Tasks on a Dask cluster; Dask is imported when one is chosen.

Dask decides which worker takes which task, and gives the tasks of a lost worker to others. Each
thread of a worker has a :class:`~.child.Child` for its tasks, so that what a task does to its
process, the worker survives, and machine code that holds the interpreter does not silence it.
Results come back to this process, the only one that writes records.
"""

from __future__ import annotations

import logging
import os
import threading
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager, suppress
from importlib import import_module
from importlib.util import find_spec
from itertools import count, islice
from pathlib import Path
from queue import Empty, SimpleQueue
from time import monotonic
from typing import Any
from uuid import uuid4

from ..errors import UsageError
from ..system.files import printable
from .child import KILLED, UNLIMITED, Child, Done, Function, Limits, Results, Task, cores
from .identity import difference, identity

#: Seconds after which the scheduler is asked for its threads again.
ASK = 5.0
#: Seconds to wait for a scheduler that does not answer, and for a worker where all have died.
PATIENCE = 30.0

#: The child of each thread of a worker.
_mine = threading.local()


def carry_out(
    function: Function, task: Task, limits: Limits, expected: dict[str, str], folder: str
) -> Done | str:
    """Carry out a task in the child of this thread of a worker, in the client's folder.

    A text is the end of the sentence that refuses it, where this worker is not what the client is.
    """
    if wrong := difference(identity(), expected):
        return wrong
    child: Child | None = getattr(_mine, "child", None)
    if child is None or (child.limits, child.folder) != (limits, folder):
        if child is not None:
            child.end()
        child = _mine.child = Child(limits, folder)
    return child.carry_out(function, task)


class Dask:
    """A Dask cluster, by a client that is connected to its scheduler, and how it is chosen."""

    def __init__(self, client: Any, name: str) -> None:
        self.client, self.name, self.threads = client, name, 1
        self.dashboard: str = client.dashboard_link if find_spec("bokeh") else ""
        self._alive = 0.0  # when a worker was there

    def run(
        self, function: Function, tasks: Iterable[Task], limits: Limits = UNLIMITED
    ) -> Iterator[Results]:
        """Carry out tasks, two for each thread at a time; see :class:`~.executors.Executor`."""
        waiting, prefix, numbers = iter(tasks), f"glmref-{uuid4().hex}", count()
        common = limits, identity(), os.getcwd()
        sent: dict[tuple[str, int], tuple[Any, Task]] = {}
        ended: SimpleQueue[Any] = SimpleQueue()
        self._alive, asked = monotonic(), -ASK
        try:
            while True:
                if monotonic() - asked >= ASK:
                    answers = False
                    self._count_threads()
                    answers, asked = True, monotonic()
                for task in islice(waiting, max(0, 2 * self.threads - len(sent))):
                    # one group of tasks for the whole run: the scheduler never forgets one
                    key = prefix, next(numbers)
                    future = self.client.submit(
                        carry_out, function, task, *common, key=key, pure=False
                    )
                    sent[key] = future, task
                    future.add_done_callback(ended.put)
                if not sent:
                    return
                futures = []
                with suppress(Empty):
                    futures.append(ended.get(timeout=ASK))
                    while True:
                        futures.append(ended.get_nowait())
                if futures:
                    yield [(sent.pop(x.key)[1], self._result(x)) for x in futures]
        finally:
            with suppress(Exception):
                if answers:  # one that does not would be waited for
                    self.client.cancel([future for future, _ in sent.values()])

    def _count_threads(self) -> None:
        try:
            ask = self.client.scheduler.ncores
            known = self.client.sync(ask, callback_timeout=PATIENCE)
        except Exception:
            raise _lost() from None
        self.threads = max(1, sum(known.values()))
        if known:
            self._alive = monotonic()
        # a scheduler of the user's own may wait for workers indefinitely
        elif self.client.cluster is not None and monotonic() - self._alive > PATIENCE:
            raise UsageError(
                "all workers of the Dask cluster died, and none was started again; what had "
                "ended is kept, so run the same command again"
            )

    def _result(self, future: Any) -> Done:
        if future.status in ("cancelled", "lost"):
            raise _lost()
        try:
            value = future.result(timeout=PATIENCE)
        except UsageError:
            raise
        except Exception as error:
            if type(error).__name__ == "KilledWorker":
                return Done(failure=KILLED, message="the workers that had the task died")
            if future.status != "error":
                raise _lost() from None
            raise UsageError(
                f"the workers of {self.client.scheduler.address} cannot carry out a task "
                f"({type(error).__name__}: {error}); install the same glmref there"
            ) from None
        if isinstance(value, str):
            raise UsageError(f"a worker of {self.client.scheduler.address} {value}")
        return value


def _lost() -> UsageError:
    return UsageError(
        "the connection to the scheduler of the Dask cluster was lost; what had ended is kept, "
        "so start the scheduler again and run the same command"
    )


@contextmanager
def cluster(where: str) -> Iterator[Dask]:
    """Connect to a cluster, or start one on this machine.

    ``where`` is empty or a number, for workers of a cluster that is started here and closed in the
    end, or the address of a scheduler, or the file that it wrote.

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
        with ExitStack() as opened:
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
