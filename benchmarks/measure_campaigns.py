"""What a task costs besides itself: executors under many small tasks.

    python -m benchmarks.measure_campaigns FILE [TASKS]

Empty tasks for the overhead; tasks that sleep 50 ms for the gain of a second worker; and a campaign
of many tiny tasks with their records on the disk (a million by default), during which the memory
of this process, in which the scheduler runs, is noted as tasks end.
"""

from __future__ import annotations

import json
import resource
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from glmref.compute import RecordFolder, executor, measure
from glmref.measure.timing import circumstances

EMPTY, SLEEPING, SECONDS = 10_000, 200, 0.05
MILLION = 1_000_000


def nothing(task: Mapping[str, Any]) -> dict[str, Any]:
    """Answer at once."""
    return {"outcome": "completed", "n": task["n"]}


def sleep(task: Mapping[str, Any]) -> dict[str, Any]:
    """Take some time, and no processor."""
    time.sleep(SECONDS)
    return {"outcome": "completed"}


def tasks(count: int, first: int = 0) -> Iterator[dict[str, int]]:
    """Tasks that differ in a number."""
    return ({"n": first + k} for k in range(count))


def overhead(on: str, count: int = EMPTY) -> dict[str, Any]:
    """Seconds of an empty task."""
    with executor(on) as where:
        list(where.run(nothing, tasks(50)))  # processes have started
        begun, spent = time.perf_counter(), _processor_seconds()
        done, last = 0, spent
        for part in where.run(nothing, tasks(count)):
            done += len(part)
            if done > 0.99 * count:
                last = _processor_seconds()  # the processes are still there
        seconds = time.perf_counter() - begun
    assert done == count
    return {
        "on": on,
        "tasks": count,
        "ms_a_task": 1e3 * seconds / count,
        "processor_ms_a_task": 1e3 * (last - spent) / count,
    }


def gain(kind: str) -> dict[str, Any]:
    """How much faster two workers are than one."""
    took = []
    for workers in (1, 2):
        with executor(f"{kind}:{workers}") as where:
            list(where.run(sleep, tasks(4)))
            begun = time.perf_counter()
            list(where.run(sleep, tasks(SLEEPING)))
            took.append(time.perf_counter() - begun)
    return {"on": kind, "seconds": took, "gain": took[0] / took[1]}


def many(on: str, count: int) -> dict[str, Any]:
    """A campaign of tiny tasks: rate, bytes of a record, memory as it goes."""
    seen: list[list[float]] = []
    done = 0

    def advance(task: object, record: object) -> None:
        nonlocal done
        done += 1
        if done % max(1, count // 20) == 0:
            seen.append([done, round(time.perf_counter() - begun, 2), _resident()])
            sys.stderr.write(f"{seen[-1]}\n")

    with tempfile.TemporaryDirectory() as name, executor(on) as where:
        store = RecordFolder(Path(name), each=10_000)
        begun, spent = time.perf_counter(), _processor_seconds()
        measure(nothing, tasks(count), store, where, advance=advance)
        seconds, spent = time.perf_counter() - begun, _processor_seconds() - spent
        size = sum(path.stat().st_size for path in store.files())
        again = time.perf_counter()
        left = sum(1 for _ in RecordFolder(Path(name)).missing(tasks(count)))
        again = time.perf_counter() - again
    assert left == 0
    return {
        "on": on,
        "tasks": count,
        "ms_a_task": 1e3 * seconds / count,
        "processor_ms_a_task": 1e3 * spent / count,
        "bytes_a_record": size / count,
        "seconds_to_see_that_nothing_is_left": again,
        "done_seconds_resident_mb": seen,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
    }


def _processor_seconds() -> float:
    """Processor time of this process and all below it; beside other programs it says more."""
    psutil = import_module("psutil")  # it comes with Dask
    own = psutil.Process()
    spent = [p.cpu_times() for p in (own, *own.children(recursive=True))]
    return sum(x.user + x.system for x in spent)


def _resident() -> float:
    """Memory of this process, in MB; Linux says it in kB."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1e3
    return float("nan")


def main(path: Path, count: int) -> None:
    """Measure and write the file."""
    document = {
        "format": "glmref-measurement-1",
        "name": path.stem,
        "title": "What a task of a campaign costs besides itself",
        "how": "python -m benchmarks.measure_campaigns FILE",
        "where": circumstances(),
        "overhead": [overhead(on) for on in ("here", "local:2", "dask:2")],
        "gain": [gain(kind) for kind in ("local", "dask")],
        "many": many("dask:2", count),
    }
    path.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    from benchmarks.measure_campaigns import main as measure_all  # tasks are imported by name

    measure_all(Path(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else MILLION)
