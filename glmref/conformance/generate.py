"""Make the vectors: mpmath at 60 digits, confirmed in ball arithmetic, wrong results beside them.

``python -m glmref.conformance.generate`` writes ``data/vectors`` again; with names, these files
only; ``GLMREF_EXECUTOR`` says where they are made. The result depends on nothing but the method
files, the problems and this package: the same bytes come out on every machine, and a test makes
them again.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ..catalogue.canonical import laid_out
from ..catalogue.lookup import load
from ..compute import executor, in_order
from ..errors import DataError
from ..method.preconsistency import preconsistency_vector
from .bench import DIGITS, SHOWN, Bench
from .faults import NOTES
from .run_cases import RunCases
from .step_cases import StepCases
from .vector_problems import FORMAT, problems

#: Methods with a vector file.
METHODS = (
    *("rk4", "dormand-prince-5", "gauss-2", "gauss-3", "sdirk-3", "radau-iia-2", "radau-iia-3"),
    *("ab-2", "bdf-2", "leapfrog", "gsymplectic-n", "gsymplectic-p", "thesis-3-8"),
    *("s4-symmetric", "g6245", "g6245-w3", "g4123"),
    *("symplectic-euler-a", "stormer-verlet", "forest-ruth-4", "lobatto-iiia-iiib-3", "pair-4-4"),
)


def document_of(method: Any, name: str) -> dict[str, Any]:
    """Return the vector document of a method.

    Raises
    ------
    DataError
        For a method whose vectors cannot be made: complex, or not pre-consistent.
    """
    if method.parts == 1 and not method.is_real:
        raise DataError(f"{name}: vectors are made for real methods; take its real form")
    if method.parts == 1 and preconsistency_vector(method.components[0]) is None:
        raise DataError(f"{name}: the method is not pre-consistent, so nothing can be started")
    bench = Bench(method, name)
    cases = list(_cases(bench))
    used = [flag for flag in NOTES if any(flag in case["flags"] for case in cases)]
    return {
        "format": FORMAT,
        "method": name,
        "generator": {"module": "glmref.conformance.generate", "digits": DIGITS, "version": 1},
        "digits": SHOWN,
        "values": bench.r,
        "coefficients": bench.coefficients(),
        "notes": {flag: dict(zip(("bug", "effect"), NOTES[flag], strict=True)) for flag in used},
        "cases": cases,
    }


def _cases(bench: Bench) -> Iterator[dict[str, Any]]:
    """Yield every case of a file, in order."""
    steps, runs = StepCases(bench), RunCases(bench)
    usable = [x for x in problems().values() if x.separable or not bench.pair]
    for task in usable:
        yield steps.step("step" if task.autonomous else "abscissae", task, bench.size(task))
    cubic = problems()["cubic"]
    yield steps.step("backward", cubic, -bench.size(problems()["forced"]))  # not dyadic
    if bench.L is not None or (bench.pair and bench.r == 1 and bench.facts.symmetry.holds):
        yield steps.reversed(cubic)
    for task in (problems()["pendulum"], problems()["forced"]):
        if not bench.pair and bench.method.starting is not None:
            yield steps.start(task)
        if bench.method.finishing is not None:
            yield steps.finish(task)
    for name in ("pendulum", "kepler", "forced"):
        if problems()[name] in usable:
            yield runs.trajectory(problems()[name])
    yield runs.order(problems()["pendulum"])


# --- files --------------------------------------------------------------------------------------


def checksums(folder: Path) -> str:
    """Return the text of SHA256SUMS for the JSON files of a folder."""
    paths = sorted(folder.glob("*.json"))
    return "".join(
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.name}\n" for path in paths
    )


def write(folder: Path, names: Sequence[str] = METHODS, on: str | None = None) -> None:
    """Make the files of these methods again, and the list of hashes.

    Raises
    ------
    DataError
        Where the vectors of a method cannot be made; those before it are written.
    """
    tasks = [{"kind": "vectors", "method": name} for name in names]
    with executor(on) as where:
        for task, done in in_order(where.run(text_of, tasks), tasks):
            if done.failure:
                raise DataError(f"{task['method']}: {done.message}")
            (folder / f"{task['method']}.json").write_text(done.value, encoding="utf-8")
    (folder / "SHA256SUMS").write_text(checksums(folder), encoding="utf-8")


def text_of(task: Mapping[str, Any]) -> str:
    """Return the text of the vector file of a method."""
    return laid_out(document_of(load(task["method"]), task["method"]))


if __name__ == "__main__":
    # by its name: other processes cannot import a function of what runs as `__main__`
    from glmref.conformance.generate import write as write_files

    from .vector_problems import folder as home

    write_files(home(), sys.argv[1:] or METHODS)
