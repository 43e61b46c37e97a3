"""Carry out what a store of records lacks, and write each result before it counts."""

from __future__ import annotations

import contextlib
from array import array
from bisect import bisect_left
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Protocol

from ..errors import DataError, UsageError
from ..system.files import Lock, make_folder, printable, reason
from .child import UNLIMITED, Done, Function, Limits, Task
from .executors import Executor, Here
from .records import RecordFile, key_of, read_records

Record = dict[str, Any]


class Store(Protocol):
    """What keeps records."""

    def exclusive(self) -> contextlib.AbstractContextManager[None]:
        """Hold the store's lock, and repair what is damaged."""
        ...

    def missing(self, tasks: Iterable[Task]) -> Iterator[Task]:
        """Tasks without a record, in order."""
        ...

    def append_all(self, results: Iterable[tuple[Task, Mapping[str, Any]]]) -> list[Record]:
        """Add records and make sure that they are on the disk before returning them."""
        ...


def measure(
    function: Function,
    tasks: Iterable[Task],
    store: Store,
    executor: Executor | None = None,
    limits: Limits = UNLIMITED,
    *,
    record: Callable[[Task, Done], Mapping[str, Any]] = lambda task, done: done.as_record(),
    advance: Callable[[Task, Record], None] | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> int:
    """Carry out the tasks that a store lacks, and return their number.

    This process alone writes. Results that have ended together are written together, with one call
    that brings them to the disk, and are counted after it.

    Parameters
    ----------
    function, executor, limits
        See :class:`~.executors.Executor`; in this process by default.
    tasks : iterable of mapping
        No two with the same content.
    store : Store
        A :class:`~.records.RecordFile` or a :class:`RecordFolder`.
    record : callable
        Makes the record of what became of a task.
    advance : callable, optional
        Called with each task and its record when it is on the disk.
    stop : callable
        Asked before a task is handed out: whether no more shall be.

    Raises
    ------
    UsageError
        Where another process writes to the store, a record cannot be written, or the executor
        fails; the records up to then are kept.
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


class RecordFolder:
    """Records in a folder of files, of which only the keys are in memory.

    Eight bytes for each record that was there when the lock was taken, and the records of one file:
    the memory does not grow with what is carried out.

    Parameters
    ----------
    path : Path
        The folder; it is made when something is written.
    each : int
        Records of a file.

    Attributes
    ----------
    notices : list of str
        Sentences on what was damaged.
    """

    def __init__(self, path: Path, *, each: int = 2_000) -> None:
        self.path, self.each = path, each
        self.notices: list[str] = []
        self._keys: array[int] = array("Q")
        self._current: RecordFile | None = None
        self._held = contextlib.ExitStack()  # the lock of the current file
        self._load()

    def files(self) -> list[Path]:
        """The files with records, in the order in which they were made."""
        return sorted(self.path.glob("records-*.jsonl"))

    def records(self) -> Iterator[Record]:
        """Every record, one file in memory at a time."""
        for path in self.files():
            yield from read_records(path)

    def __len__(self) -> int:
        return len(self._keys)

    def _load(self, *, repair: bool = False) -> None:
        keys: set[int] = set()
        last: RecordFile | None = None
        for path in self.files():
            last = RecordFile(path)
            if repair:
                with last.exclusive():
                    self.notices += last.notices
            found = {int(record["key"], 16) for record in last.records}
            if twice := len(found & keys):
                raise DataError(
                    f"{path.name}: {twice} of its records are of tasks that a file before it has "
                    f"records of; move this file away"
                )
            keys |= found
        self._keys = array("Q", sorted(keys))
        self._current = last

    def missing(self, tasks: Iterable[Task]) -> Iterator[Task]:
        """Tasks without a record when the lock was taken, in order."""
        for task in tasks:
            key = int(key_of(task), 16)
            at = bisect_left(self._keys, key)
            if at == len(self._keys) or self._keys[at] != key:
                yield task

    @contextlib.contextmanager
    def exclusive(self) -> Iterator[None]:
        """Hold the folder's lock, repair what is damaged, and be the only writer.

        Raises
        ------
        UsageError
            Where another process holds the lock, or the folder cannot be written.
        """
        make_folder(self.path)
        lock = Lock(self.path / ".lock", f"the folder of records {printable(self.path)}")
        try:
            lock.acquire()
        except OSError as error:
            raise UsageError(
                f"the folder of records {printable(self.path)} cannot be written "
                f"({reason(error)}); name another --output"
            ) from None
        try:
            self._load(repair=True)
            if self._current is not None:
                self._held.enter_context(self._current.exclusive())
            yield
        finally:
            self._held.close()
            lock.release()

    def append_all(self, results: Iterable[tuple[Task, Mapping[str, Any]]]) -> list[Record]:
        """Add records to the last file, or to a new one; see :meth:`.RecordFile.append_all`.

        The lock must be held: a file is read when its own is taken, and not for each record.
        """
        rows, written = list(results), list[Record]()
        while rows:
            file = self._current
            if file is None or len(file.records) >= self.each:
                number = len(self.files()) + 1
                while (path := self.path / f"records-{number:06}.jsonl").exists():
                    number += 1  # one of those before it was deleted
                file = self._current = RecordFile(path)
                self._held.close()
                self._held.enter_context(file.exclusive())
            room = self.each - len(file.records)
            written += file.append_all(rows[:room])
            rows = rows[room:]
        return written
