"""What it costs to start: the package, its commands, one proof; numpy beside them as a scale."""

from __future__ import annotations

import subprocess
import sys
import time


def seconds(code: str, repeat: int = 5) -> float:
    """Return the best of a few fresh interpreters, less the time of an empty one."""

    def best(text: str) -> float:
        times = []
        for _ in range(repeat):
            started = time.perf_counter()
            subprocess.run([sys.executable, "-c", text], check=True, capture_output=True)
            times.append(time.perf_counter() - started)
        return min(times)

    return max(best(code) - best("pass"), 1e-6)


class Import:
    """Each in a fresh interpreter, by asv's own timer of raw code."""

    timeout = 60

    def timeraw_package(self) -> str:
        return "import glmref"

    def timeraw_catalogue(self) -> str:
        return "import glmref; glmref.load"

    def timeraw_help(self) -> str:
        return "from glmref.cli import main; main(['--help'])"

    def timeraw_numpy(self) -> str:
        return "import numpy"


class Ratio:
    """The bound this project holds itself to: below 1.5 times the import of numpy."""

    unit = "ratio"
    timeout = 120

    def track_package_over_numpy(self) -> float:
        return seconds("import glmref") / seconds("import numpy")


class Verify:
    """One method, and all of them, from a cold start, as a user waits for it."""

    timeout = 300

    def time_one_method(self) -> None:
        command = [sys.executable, "-m", "glmref", "verify", "gsymplectic-n"]
        subprocess.run(command, check=True, capture_output=True)

    def time_whole_catalogue(self) -> None:
        command = [sys.executable, "-m", "glmref", "verify", "--format", "csv"]
        subprocess.run(command, check=True, capture_output=True)
