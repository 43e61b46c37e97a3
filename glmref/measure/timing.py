"""Small tools of measurement: quartiles, repeated timing, and where it was measured."""

from __future__ import annotations

import os
import platform
import statistics
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import PackageNotFoundError, version
from time import perf_counter
from typing import Any, TypeVar

Result = TypeVar("Result")


@dataclass(frozen=True, slots=True)
class Timing:
    """Wall-clock seconds of repeated runs: median and quartiles."""

    median: float
    q25: float
    q75: float
    repeats: int

    @classmethod
    def of(cls, seconds: list[float]) -> Timing:
        """Summarize one or more durations."""
        if len(seconds) == 1:
            return cls(seconds[0], seconds[0], seconds[0], 1)
        q25, median, q75 = statistics.quantiles(seconds, n=4, method="inclusive")
        return cls(median, q25, q75, len(seconds))

    def as_json(self) -> dict[str, float | int]:
        """Return the record's ``seconds`` block."""
        return {"median": self.median, "q25": self.q25, "q75": self.q75, "repeats": self.repeats}


def repeat(
    run: Callable[[], Result], *, repeats: int = 5, budget: float = 2.0
) -> tuple[Result, Timing]:
    """Run something a few times, at least once; return its last result and the times.

    No further repetition starts after ``budget`` seconds.
    """
    seconds: list[float] = []
    begun = perf_counter()
    while True:
        start = perf_counter()
        result = run()
        seconds.append(perf_counter() - start)
        if len(seconds) >= repeats or perf_counter() - begun > budget:
            return result, Timing.of(seconds)


def circumstances() -> dict[str, Any]:
    """Return processor, system and versions, for the record: no host name, no path."""
    versions = {"python": platform.python_version()}
    for package in ("glmref", "numpy", "numba"):
        try:
            versions[package] = version(package)
        except PackageNotFoundError:
            continue
    return {
        "machine": platform.machine(),
        "system": platform.system(),
        "processor": _processor(),
        "cores": os.cpu_count(),
        **({"pinned": True} if _pinned() else {}),
        "versions": versions,
    }


def _pinned() -> bool:
    """Return whether this process stays on one core of several."""
    usable = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 0
    return usable == 1 and (os.cpu_count() or 1) > 1


def machine(where: Mapping[str, Any]) -> str:
    """Return the kind of machine from :func:`circumstances`: times of one kind compare."""
    given = [where.get(key) for key in ("processor", "machine", "system")]
    parts = [*map(str, filter(None, given)), f"{where.get('cores')} cores"]
    return ", ".join([*parts, *(["pinned"] if where.get("pinned") else [])])


def _processor() -> str:
    """Return the model name of the processor where the system tells it."""
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as stream:
            for line in stream:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    except OSError:
        pass
    return platform.processor() or platform.machine()
