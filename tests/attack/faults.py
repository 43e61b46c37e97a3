"""Runs that are killed at random instants, run two at once, and short of disk, with any seed.

After each fault the same command is run again. The records must be those of an undisturbed run bit
for bit, but for timings; none may be there twice, and none be lost.
"""

import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from tests.evidence.faulty_runs import Runs
from tests.evidence.test_records_faults import fill_disk, kill_at_random, run_pairs

from .tally import Tally

#: Kills; a third as many pairs of runs, and as many sizes of a full disk.
COUNT = 30


def attack(count: int, seed: int) -> Tally:
    """Run all faults and count what comes of them."""
    tally = Tally()
    some = max(1, count // 3)
    with tempfile.TemporaryDirectory() as folder:
        runs = Runs(Path(folder))
        faults: dict[str, tuple[int, Callable[[], int | None]]] = {
            "killed": (count, lambda: kill_at_random(runs, count, seed)),
            "two at once": (some, lambda: run_pairs(runs, some)),
            "disk full": (some, lambda: fill_disk(runs, some, seed)),
        }
        for name, (number, fault) in faults.items():
            begun = time.monotonic()
            try:
                hit = fault()
            except AssertionError as error:
                tally.violations.append(f"{name}: {str(error)[:2000]}")
                continue
            tally.outcomes[f"{name}, records as undisturbed"] += number
            words = {"killed": f"{hit} died of it", "two at once": f"{hit} second runs refused"}
            print(f"{name}: {words.get(name, 'all')}, {time.monotonic() - begun:.0f} s", flush=True)
    return tally


def main(count: int = COUNT, seed: int = 1) -> int:
    """Print counts and violations; 1 where there is a violation."""
    print(f"seed {seed}")
    return attack(count, seed).printed()
