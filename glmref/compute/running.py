"""Carry out what a store of records lacks, and write each result before it counts."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from .child import UNLIMITED, Done, Function, Limits, Task
from .executors import Executor, Here
from .records import Record, Records


def measure(
    function: Function,
    tasks: Iterable[Task],
    store: Records,
    executor: Executor | None = None,
    limits: Limits = UNLIMITED,
    *,
    record: Callable[[Task, Done], Mapping[str, Any]] = lambda task, done: done.as_record(),
    advance: Callable[[Task, Record], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> int:
    """Carry out the tasks that a store lacks, and return their number.

    This process alone writes. Results that have ended together are written together, with one call
    that brings them to the disk, and are counted after it. No two tasks have the same content.
    ``record`` makes the record of what became of a task, ``advance`` is called with each task and
    its record when it is on the disk, and ``stop`` is asked before a task is handed out whether no
    more shall be.

    Raises
    ------
    UsageError
        Where another process writes to the store, a record cannot be written, or the
        executor fails; the records up to then are kept.
    """
    number = 0
    with store.exclusive():
        todo = _until(stop, store.missing(tasks))
        for results in (executor or Here()).run(function, todo, limits):
            written = store.append_all([(task, record(task, done)) for task, done in results])
            number += len(written)
            if advance is not None:
                for (task, _), one in zip(results, written, strict=True):
                    advance(task, one)
    return number


def _until(stop: Callable[[], bool], tasks: Iterable[Task]) -> Iterator[Task]:
    for task in tasks:
        if stop():
            return
        yield task
