"""The cost of a run besides its steps: ``python -m tools.measure.latency [--json FILE]``.

``--methods`` measures the first and the second run of every method that has a start or a finish, or
of those named after it, each in a process forked from one that has imported everything: the least
of so many processes, with a warm disk cache.

Each row is measured in fresh processes and given in milliseconds of processor time (medians):

* *first*: the first solve of a process with a warm disk cache, without the import of numpy;
* *second*, *third*: the same call again, without the steps themselves;
* *study*: 96 solves with different step sizes, without the steps;
* *compile*: the first solve of a problem of d components with an empty disk cache.

Python right-hand sides come in two kinds: arithmetic only, and with a branch on a value.
"""

from __future__ import annotations

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

METHODS = ("rk4", "gauss-3", "kahan-li-8", "pair-rkn-6-8b", "g6245-w3", "order8-s5-w3")
FUNCTIONS = {
    "arithmetic": "def f(t, y):\n    return [y[1], -math.sin(y[0])]\n",
    "with a branch": "def f(t, y):\n    k = 1.0 if y[0] < 50 else 2.0\n"
    "    return [y[1], -k*math.sin(y[0])]\n",
}
RING = """
def f(t, y):
    n = len(y) // 2
    out = np.zeros(2*n)
    for i in range(n):
        out[i] = y[n + i]
        for j in range(n):
            if j != i:
                r = y[j] - y[i]
                out[n + i] += r/(1.0 + r*r)**1.5
    return out
"""
HEAD = """
import json, math, sys, time
import numpy as np
begin = time.process_time()
from glmref import Problem, solve
def cost(*given, **options):
    before = time.process_time()
    run = solve(*given, **options)
    return 1e3*(time.process_time() - before - run.seconds)
"""
NAMES = """
steps = [cost("kepler", METHOD, h=0.01, steps=1000) for _ in range(4)]
first = 1e3*(time.process_time() - begin) - sum(steps[1:])
print(json.dumps([first, steps[1], min(steps[1:])]))
"""
CALLABLE = """
p = Problem(f=f, y0=(1.0, 0.0))
steps = [cost(p, METHOD, h=0.01, steps=1000) for _ in range(4)]
first = 1e3*(time.process_time() - begin) - sum(steps[1:])
print(json.dumps([first, steps[1], min(steps[1:])]))
"""
STUDY = """
from glmref import problem, load
names = ("rk4", "gauss-3", "pair-rkn-6-8b", "g6245-w3")
print(json.dumps([sum(cost("kepler", m, h=0.02/(1 + k/24), steps=50)
                      for m in names for k in range(24))]))
"""
LARGE = """
n = DIMENSION // 2
q = [0.1*i for i in range(n)]
if KIND == "n-body":
    from glmref import problem
    p = problem("n-body", bodies=max(2, DIMENSION // 6))
elif KIND == "H with sums":
    p = Problem.from_hamiltonian(
        "sum(p[i]**2/2 for i in range(n)) + sum(1 - cos(q[i+1] - q[i]) for i in range(n - 1))",
        {"q": q, "p": [0]*n})
else:
    p = Problem(f=f, y0=(*q, *[0.0]*n))
print(json.dumps([cost(p, "gauss-2", h=0.001, steps=2, solver="fixed-point")]))
"""


def child(text: str, cache: Path) -> list[float]:
    """Run a program in a process of its own and return the numbers it prints."""
    environment = {**os.environ, "GLMREF_CACHE": str(cache), "OMP_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", HEAD + text], capture_output=True, text=True, check=False,
        env=environment,
    )  # fmt: skip
    if done.returncode:
        sys.stderr.write(done.stderr.strip().splitlines()[-1] + "\n")
        return []
    return json.loads(done.stdout.splitlines()[-1])


def medians(text: str, repeats: int, cache: Path) -> list[float]:
    """Return medians over processes, after one that fills the cache."""
    child(text, cache)
    runs = [found for _ in range(repeats) if (found := child(text, cache))]
    return [round(statistics.median(column), 2) for column in zip(*runs, strict=True)]


def measured(repeats: int) -> dict[str, Any]:
    """Return all rows."""
    rows: dict[str, Any] = {"names": {}, "functions": {}, "compile": {}}
    with tempfile.TemporaryDirectory() as folder:
        cache = Path(folder)
        for method in METHODS:
            rows["names"][method] = medians(NAMES.replace("METHOD", repr(method)), repeats, cache)
        for kind, source in FUNCTIONS.items():
            for method in ("rk4", "gauss-3"):
                text = source + CALLABLE.replace("METHOD", repr(method))
                rows["functions"][f"{kind}, {method}"] = medians(text, repeats, cache)
        rows["study"] = medians(STUDY, repeats, cache)
    for kind in ("n-body", "H with sums", "Python loops"):
        source = RING if kind == "Python loops" else ""
        times = []
        for dimension in (12, 48, 102):
            text = LARGE.replace("KIND", repr(kind)).replace("DIMENSION", str(dimension))
            with tempfile.TemporaryDirectory() as folder:
                found = child(source + text, Path(folder))
            times.append(round(found[0], 1) if found else None)
        rows["compile"][kind] = times
    return rows


#: Steps whose own time is nothing beside what is measured.
_FEW = 10


def forked(method: str, folder: str) -> tuple[float, float]:
    """Return milliseconds of the first and the second run, of few steps, in a forked process."""
    from glmref import solve
    from glmref.errors import GlmrefError

    reading, writing = os.pipe()
    child = os.fork()
    if not child:
        os.environ["GLMREF_CACHE"] = folder
        found: list[float] = []
        try:
            for _ in range(4):
                begin = time.process_time()
                solve("kepler", method, h=0.01, steps=_FEW)
                found.append(1e3 * (time.process_time() - begin))
        except GlmrefError:
            found = [math.nan, math.nan]
        finally:
            os.write(writing, json.dumps([found[0], min(found[1:])]).encode())
            os._exit(0)
    os.close(writing)
    with os.fdopen(reading) as pipe:
        first, second = json.loads(pipe.read())
    os.waitpid(child, 0)
    return first, second


def every_method(wanted: list[str], repeats: int) -> dict[str, list[float]]:
    """Return the first and second run of methods, the slowest first run first."""
    import llvmlite.binding  # noqa: F401  imported where a kernel is loaded

    import glmref.engine.solve  # noqa: F401
    from glmref import load, names

    if not wanted:
        tables = ((name, load(name)) for name in names("methods"))
        wanted = [name for name, x in tables if x.starting is not None or x.finishing is not None]
    rows = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in wanted:
            forked(name, folder)
            runs = [forked(name, folder) for _ in range(repeats)]
            rows[name] = [round(min(column), 2) for column in zip(*runs, strict=True)]
    return dict(sorted(rows.items(), key=lambda row: -row[1][0]))


def main() -> None:
    """Measure and print, and write the rows where asked."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--methods", nargs="*", metavar="NAME")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    if given.methods is not None:
        rows: dict[str, Any] = every_method(given.methods, given.repeats)
    else:
        rows = measured(given.repeats)
    text = json.dumps(rows, indent=1)
    sys.stdout.write(text + "\n")
    if given.json is not None:
        given.json.write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
