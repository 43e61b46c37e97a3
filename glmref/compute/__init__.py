"""Many tasks: where they are carried out, under which limits, and records that survive.

A task is a mapping that JSON can hold, and so is its result. Functions that carry out tasks are
given by the subpackages above.

Public names::

    executor("local:4") -> Executor     in this process, in processes, on a Dask cluster
    Limits(seconds=, memory=, ...)      what a task may take
    Records(path)                       results on the disk, by content of their task
    measure(function, tasks, store)     carry out what the store lacks
"""

from __future__ import annotations

from .child import Done, Limits
from .executors import Executor, executor, in_order
from .records import Records
from .running import measure

__all__ = ["Done", "Executor", "Limits", "Records", "executor", "in_order", "measure"]
