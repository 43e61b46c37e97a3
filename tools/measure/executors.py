"""What a task costs besides itself: executors under many small tasks.

    python -m tools.measure.executors [FILE] [--only gain] [--tasks N] [--minutes M]

One table. Empty tasks for the overhead; tasks of 50 ms, which sleep or keep a processor busy, for
the gain of a second worker, one and two in turn and the best of five rounds; and a campaign of many
tiny tasks with their records on the disk (a million, or what the minutes allow), during which the
memory of this process, in which the scheduler runs, is noted.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from importlib import import_module
from pathlib import Path
from typing import Any

from glmref.compute import Records, executor, measure
from glmref.measure.timing import circumstances

EMPTY, FIFTY, SECONDS, ROUNDS = 2_000, 100, 0.05, 5
MILLION = 1_000_000


def nothing(task: Mapping[str, Any]) -> dict[str, Any]:
    """Answer at once."""
    return {"outcome": "completed", "n": task["n"]}


def sleep(task: Mapping[str, Any]) -> dict[str, Any]:
    """Take some time, and no processor."""
    time.sleep(SECONDS)
    return {"outcome": "completed"}


def busy(task: Mapping[str, Any]) -> dict[str, Any]:
    """Take so much time of a processor."""
    until = time.process_time() + SECONDS
    while time.process_time() < until:
        pass
    return {"outcome": "completed"}


def tasks(count: int, first: int = 0) -> Iterator[dict[str, int]]:
    """Yield tasks that differ in a number."""
    return ({"n": first + k} for k in range(count))


def overhead(on: str, count: int = EMPTY) -> dict[str, Any]:
    """Return seconds of an empty task."""
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


def gain(kind: str, function: Callable[[Mapping[str, Any]], Any]) -> dict[str, Any]:
    """Return how much faster two workers are than one: the best of rounds, one and two in turn."""
    took: dict[int, list[float]] = {1: [], 2: []}
    with ExitStack() as stack:
        on = {n: stack.enter_context(executor(f"{kind}:{n}")) for n in took}
        for where in on.values():
            list(where.run(function, tasks(4)))
        for _ in range(ROUNDS):
            for workers, where in on.items():
                begun = time.perf_counter()
                # processes of `local` start with each run: the time begins when all have answered
                done, first, count = 0, 0, 2 * workers + FIFTY
                for part in where.run(function, tasks(count)):
                    if done < 2 * workers <= done + len(part):
                        begun, first = time.perf_counter(), done + len(part)
                    done += len(part)
                took[workers].append((time.perf_counter() - begun) / (count - first))
    best = [min(x) for x in took.values()]
    return {
        "on": kind,
        "task": function.__name__,
        "ms_a_task": [1e3 * x for x in best],
        "gain": best[0] / best[1],
    }


def many(on: str, count: int, limit: float) -> dict[str, Any]:
    """Run a campaign of tiny tasks, at most so long: rate, bytes of a record, memory as it goes."""
    seen: list[list[float]] = []
    done = 0

    def advance(task: object, record: object) -> None:
        nonlocal done
        done += 1
        now = time.perf_counter() - begun
        if now > len(seen) * limit / 24 or done == count:
            seen.append([done, round(now, 2), _resident()])
            sys.stderr.write(f"{seen[-1]}\n")

    with tempfile.TemporaryDirectory() as name, executor(on) as where:
        file = Path(name, "records.sqlite")
        store = Records(file)
        begun, spent = time.perf_counter(), _processor_seconds()
        measure(
            nothing, tasks(count), store, where,
            advance=advance, stop=lambda: time.perf_counter() - begun > limit,
        )  # fmt: skip
        seconds, spent = time.perf_counter() - begun, _processor_seconds() - spent
        size = file.stat().st_size
        again = time.perf_counter()
        left = sum(1 for _ in Records(file).missing(tasks(done)))
        again = time.perf_counter() - again
    assert left == 0
    return {
        "on": on,
        "tasks": done,
        "ms_a_task": 1e3 * seconds / done,
        "processor_ms_a_task": 1e3 * spent / done,
        "hours_for_a_million": MILLION * seconds / done / 3600,
        "bytes_a_record": size / done,
        "seconds_to_see_that_nothing_is_left": again,
        "done_seconds_resident_mb": seen,
        "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3,
    }


def _processor_seconds() -> float:
    """Return the processor time of this process and all below it.

    Beside other programs it says more.
    """
    psutil = import_module("psutil")  # it comes with Dask
    own = psutil.Process()
    spent = [p.cpu_times() for p in (own, *own.children(recursive=True))]
    return sum(x.user + x.system for x in spent)


def _resident() -> float:
    """Return the memory of this process, in MB; Linux says it in kB."""
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1]) / 1e3
    return float("nan")


def table(document: Mapping[str, Any]) -> str:
    """Return the figures in lines, for a terminal."""
    lines: list[str] = []
    if "overhead" in document:
        lines.append(f"{'empty tasks':<24}{'ms a task':>12}{'of processor time':>20}")
    lines += [
        f"{x['on']:<14}{x['tasks']:>10,}{x['ms_a_task']:>12.2f}{x['processor_ms_a_task']:>20.2f}"
        for x in document.get("overhead", ())
    ]
    if "gain" in document:
        lines += ["", f"{'tasks of 50 ms':<24}{'one worker, ms':>16}{'two, ms':>10}{'gain':>8}"]
    lines += [
        f"{x['on']:<14}{x['task']:>10}{x['ms_a_task'][0]:>16.1f}{x['ms_a_task'][1]:>10.1f}"
        f"{x['gain']:>8.2f}"
        for x in document.get("gain", ())
    ]
    if many_tasks := document.get("many"):
        lines += ["", f"{'tasks with records':<20}{'seconds':>10}{'memory, MB':>12}"]
        lines += [
            f"{done:>20,}{seconds:>10.0f}{memory:>12.1f}"
            for done, seconds, memory in many_tasks["done_seconds_resident_mb"]
        ]
        lines.append(f"a million at this rate: {many_tasks['hours_for_a_million']:.2f} h")
    return "\n".join(lines) + "\n"


#: What is measured -> how.
PARTS: dict[str, Callable[[argparse.Namespace], Any]] = {
    "overhead": lambda given: [overhead(on) for on in ("here", "local:2", "dask:2")],
    "gain": lambda given: [gain(x, task) for x in ("local", "dask") for task in (sleep, busy)],
    "many": lambda given: many("dask:2", given.tasks, given.minutes * 60),
}


def main(arguments: Sequence[str]) -> None:
    """Measure, print a table, and write the file."""
    parser = argparse.ArgumentParser(prog="python -m tools.measure.executors")
    parser.add_argument("file", type=Path, nargs="?", help="where the figures go, in JSON")
    parser.add_argument("--only", choices=PARTS, action="append", help="a part of the table")
    parser.add_argument("--tasks", type=int, default=MILLION, help="of the long campaign")
    parser.add_argument("--minutes", type=float, default=90.0, help="that it may take")
    given = parser.parse_args(arguments)
    document = {
        "format": "glmref-measurement-1",
        "name": given.file.stem if given.file else "campaigns",
        "title": "What a task of a campaign costs besides itself",
        "how": "python -m tools.measure.executors FILE",
        "where": circumstances(),
        **{part: PARTS[part](given) for part in given.only or PARTS},
    }
    sys.stdout.write(table(document))
    if given.file:
        given.file.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    from tools.measure.executors import main as measure_all  # tasks are imported by name

    measure_all(sys.argv[1:])
