"""Time ``glmref verify`` over the whole catalogue: ``python -m tools.measure.verify [FILE]``.

Prints the document of the measurement, or writes it to a file.
"""

from __future__ import annotations

import json
import os
import resource
import statistics
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

from glmref.catalogue.lookup import names
from glmref.measure.timing import circumstances
from tools.measured_json import write_json

RUNS = 5
NOTE = (
    "`wall`: seconds from a cold start to the end. `cpu`: processor seconds of all its processes, "
    "as many as there are cores. `load`: processes that wanted a core in the minute before the "
    "run; other work on the machine makes both figures larger."
)


def run() -> dict[str, float]:
    """Run once from a cold start: seconds by the clock, of all its processes, and the load."""
    command = [sys.executable, "-m", "glmref", "verify", "--no-cache", "--format", "csv"]
    load = os.getloadavg()[0]
    before, started = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    subprocess.run(command, check=True, capture_output=True)
    wall = time.perf_counter() - started
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return {"wall": round(wall, 2), "cpu": round(cpu, 2), "load": round(load, 2)}


def measured() -> dict[str, Any]:
    """Return the document: every run, and the medians."""
    runs = [run() for _ in range(RUNS)]
    return {
        "format": "glmref-measurement-1",
        "name": "verify-time",
        "title": "What it takes to check the whole catalogue",
        "how": "python -m tools.measure.verify FILE",
        "notes": [NOTE],
        "files": len(names("all")),
        "wall": statistics.median(x["wall"] for x in runs),
        "cpu": statistics.median(x["cpu"] for x in runs),
        "runs": runs,
        "where": circumstances(),
    }


if __name__ == "__main__":
    if len(sys.argv) > 1:
        write_json(Path(sys.argv[1]), measured())
    else:
        sys.stdout.write(json.dumps(measured(), indent=1) + "\n")
