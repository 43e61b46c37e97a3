"""Functions that tests hand to executors: other processes import them from here."""

import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def behave(task: Mapping[str, Any]) -> dict[str, Any]:
    """Square a number; or hang, die, eat memory, fail, as the task says."""
    match task.get("how", "well"):
        case "hang":
            while True:
                pass
        case "die":
            os.kill(os.getpid(), signal.SIGKILL)
        case "die once":
            mark = Path(task["mark"])
            if not mark.exists():
                mark.touch()
                os.kill(os.getpid(), signal.SIGKILL)
        case "eat":
            _ = bytearray(task["bytes"])
        case "fail":
            raise ValueError("seven")
        case "sleep":
            time.sleep(task["seconds"])
    return {"outcome": "completed", "square": task["n"] ** 2}


def where(task: Mapping[str, Any]) -> dict[str, Any]:
    """Say on which cores this process may run, and how many threads libraries may have."""
    return {
        "cores": sorted(os.sched_getaffinity(0)),
        "threads": os.environ.get("OMP_NUM_THREADS"),
        "process": os.getpid(),
    }


def unsendable(task: Mapping[str, Any]) -> Any:
    """Return what no other process can receive."""
    return lambda: task
