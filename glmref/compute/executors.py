"""Where tasks are carried out: in this process, in processes of this machine, on a Dask cluster.

An executor takes a function of a module and tasks in JSON, and yields what became of each in the
order in which they end. Few tasks are taken ahead, so that a million of them needs no more memory
than ten. A text chooses one::

    here                      in this process, one after another
    local, local:4            as many processes as there are cores, or four
    dask, dask:4              a Dask cluster on this machine, with a worker a core, or four
    dask:tcp://HOST:8786      the Dask cluster with this scheduler
    dask:scheduler.json       the same, by the file that its scheduler wrote
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from contextlib import contextmanager
from itertools import islice
from queue import SimpleQueue
from typing import Protocol

from ..errors import UsageError
from .child import (
    UNLIMITED,
    Child,
    Done,
    Function,
    Limits,
    Results,
    Task,
    attempt,
    cores,
    physical_cores,
)
from .cluster import cluster

#: The environment variable that chooses where nothing else does.
ENVIRONMENT = "GLMREF_EXECUTOR"


class Executor(Protocol):
    """Something that carries out tasks."""

    name: str  #: As it is chosen.
    dashboard: str  #: The address of a page that shows what happens, or ``""``.
    threads: int  #: How many tasks can run at the same time.

    def run(
        self, function: Function, tasks: Iterable[Task], limits: Limits = UNLIMITED
    ) -> Iterator[Results]:
        """Carry out tasks, which are read when needed, and yield those that have ended.

        The function, of a module, makes of a task what JSON can hold. Each task comes once.

        Raises
        ------
        UsageError
            When the executor itself fails: then some tasks have no result.
        """
        ...


class Here:
    """Tasks one after another in this process. A limit of time or memory cannot be held here."""

    name, dashboard, threads = "here", "", 1

    def run(
        self, function: Function, tasks: Iterable[Task], limits: Limits = UNLIMITED
    ) -> Iterator[Results]:
        """Carry out tasks; see :class:`Executor`."""
        for task in tasks:
            yield [(task, attempt(function, task))]


class Local:
    """Processes on this machine, one task each at a time.

    By default as many as there are cores, physical ones where tasks are pinned.
    """

    dashboard = ""

    def __init__(self, processes: int | None = None) -> None:
        self.processes = processes
        self.threads = processes or len(cores())
        self.name = "local" if processes is None else f"local:{processes}"

    def run(
        self, function: Function, tasks: Iterable[Task], limits: Limits = UNLIMITED
    ) -> Iterator[Results]:
        """Carry out tasks; see :class:`Executor`."""
        usable = physical_cores() if limits.pinned else cores()
        count = self.processes or len(usable)
        if limits.pinned and count > len(usable):
            raise UsageError(
                f"timed tasks need a core each, {count} processes were requested and there are "
                f"{len(usable)} cores; use --on local:{len(usable)}"
            )
        children = [Child(limits) for _ in range(count)]
        idle: SimpleQueue[Child] = SimpleQueue()
        for child in children:
            idle.put(child)

        def carry_out(task: Task) -> Done:
            child = idle.get()
            try:
                return child.carry_out(function, task)
            finally:
                idle.put(child)

        waiting = iter(tasks)
        threads = ThreadPoolExecutor(count)
        running: dict[Future[Done], Task] = {}
        try:
            while True:
                for task in islice(waiting, 2 * count - len(running)):
                    running[threads.submit(carry_out, task)] = task
                if not running:
                    return
                ended, _ = wait(running, return_when=FIRST_COMPLETED)
                yield [(running.pop(one), one.result()) for one in ended]
        finally:
            threads.shutdown(wait=False, cancel_futures=True)
            for child in children:
                child.end()


def in_order(results: Iterable[Results], tasks: Iterable[Task]) -> Iterator[tuple[Task, Done]]:
    """Give results the order of their tasks; what comes early is kept until its turn.

    The executor was given exactly these tasks, the same objects.
    """
    early: dict[int, Done] = {}
    waiting = iter(results)
    for task in tasks:
        while id(task) not in early:
            early |= {id(one): done for one, done in next(waiting)}
        yield task, early.pop(id(task))


@contextmanager
def executor(text: str | None = None) -> Iterator[Executor]:
    """Open the executor that a text chooses (see the module), and close it in the end.

    By default that of :data:`ENVIRONMENT`, else ``"here"``.

    Raises
    ------
    UsageError
        For a text that chooses nothing, a cluster that does not answer, or Dask where it is
        not installed.
    """
    asked = text or os.environ.get(ENVIRONMENT) or "here"
    kind, _, rest = asked.partition(":")
    if kind == "dask":
        with cluster(rest) as found:
            yield found
    elif kind == "local" and (not rest or (rest.isdecimal() and len(rest) < 5 and int(rest))):
        yield Local(int(rest) if rest else None)
    elif asked == "here":
        yield Here()
    else:
        raise UsageError(
            f"there is no executor {asked[:100]!r}; write here, local, local:N, dask, dask:N, "
            f"dask:tcp://HOST:PORT or dask:FILE with the file of a scheduler"
        )
