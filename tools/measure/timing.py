"""Competitors timed in turn, in processor seconds of the thread; load on the machine hits all."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping

#: Seconds of each repetition, by name of the competitor; the k-th ones ran one after the other.
Seconds = dict[str, list[float]]


def interleaved(runs: Mapping[str, Callable[[], object]], repeats: int) -> Seconds:
    """Time every run ``repeats`` times, taking turns; one turn before is not counted.

    Everything is to be compiled and loaded beforehand.
    """
    spent: Seconds = {name: [] for name in runs}
    for turn in range(repeats + 1):
        for name, run in runs.items():
            begin = time.thread_time()
            run()
            if turn:
                spent[name].append(time.thread_time() - begin)
    return spent


def quartiles(values: list[float]) -> tuple[float, float, float]:
    """Return lower quartile, median, upper quartile."""
    low, median, high = statistics.quantiles(values, n=4, method="inclusive")
    return low, median, high


def ratios(spent: Seconds, above: str, below: str) -> list[float]:
    """Return the ratio of the times of two competitors, turn by turn."""
    return [a / b for a, b in zip(spent[above], spent[below], strict=True)]
