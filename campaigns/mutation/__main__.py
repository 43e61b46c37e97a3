"""``python -m campaigns.mutation``: draw mutants, run their tests, record what came of each."""

from __future__ import annotations

import argparse
import json
import os
import random
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from .mutants import Mutant, mutants

ROOT = Path(__file__).resolve().parents[2]
#: Room -> its modules (of a folder, or some files of one), and the tests that should notice.
ROOMS: dict[str, tuple[str, str]] = {
    "exact": (
        "glmref/exact/*.py",
        "unit/test_exact unit/test_expression unit/test_linalg unit/test_polynomials",
    ),
    "readers": (
        "glmref/catalogue/reader.py glmref/catalogue/strict_json.py glmref/catalogue/entries.py",
        "unit/test_reader unit/test_strict_json unit/test_bare_tableau",
    ),
    "prove": ("glmref/prove/*.py", "adversary unit/test_certify unit/test_derive_enclosure"),
    "theory": (
        "glmref/theory/*.py",
        (
            "unit/test_order unit/test_symmetry unit/test_symplectic unit/test_stability "
            "unit/test_spectrum unit/test_parasitism unit/test_starting unit/test_reduction"
        ),
    ),
    "engine": ("glmref/engine/*.py", "unit/test_engine_solve unit/test_engine_agreement"),
}
#: Module -> more tests of its own, which take longer.
OWN: dict[str, str] = {
    "ball": "unit/test_exact", "jet": "unit/test_series", "number": "laws/test_number_laws",
    "relations": "unit/test_derive_recognise", "products": "laws/test_product_laws",
}  # fmt: skip
#: A mutant that loops is noticed: it takes this many times as long as the tests without it.
PATIENCE, LEAST = 4.0, 20.0
LEFT_OUT = (".git", "__pycache__", ".pytest_cache", ".ruff_cache", "docs/images", "site")


def modules(room: str) -> list[Path]:
    """Modules of a room, as paths in the tree."""
    found = [p for glob in ROOMS[room][0].split() for p in sorted(ROOT.glob(glob))]
    return [p.relative_to(ROOT) for p in found if p.name != "__init__.py"]


def tests_of(room: str, module: Path) -> list[str]:
    """Tests that should notice a change of a module; the long ones come last."""
    stems = [f"unit/test_{module.stem}", *ROOMS[room][1].split()]
    stems += OWN.get(module.stem, "").split()
    paths = [f"tests/{x}" if x == "adversary" else f"tests/{x}.py" for x in stems]
    return [x for x in dict.fromkeys(paths) if (ROOT / x).exists()]


def drawn(rooms: Sequence[str], count: int, seed: int) -> Iterator[tuple[str, Path, Mutant]]:
    """Draw mutants of the rooms; every mutant is as likely as any other."""
    every = [
        (room, module, mutant)
        for room in rooms
        for module in modules(room)
        for mutant in mutants((ROOT / module).read_text(encoding="utf-8"))
    ]
    draw = random.Random(seed)
    yield from draw.sample(every, min(count, len(every)))


def run(tree: Path, tests: Sequence[str], seconds: float) -> tuple[str, str, float]:
    """Run tests in a copy of the tree; what came of them, the first that failed, seconds."""
    started = time.monotonic()

    def limits() -> None:
        resource.setrlimit(resource.RLIMIT_CPU, (int(seconds), int(seconds) + 1))
        resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))

    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-x", "-q", "--no-header", "-p", "no:cacheprovider",
         "-p", "no:randomly", "--tb=no", *tests],
        cwd=tree, env={**os.environ, "PYTHONPATH": str(tree), "CI": "1"}, capture_output=True,
        text=True, check=False, preexec_fn=limits, timeout=60 * seconds,
    )  # fmt: skip
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    spent = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime
    failed = [x for x in done.stdout.splitlines() if x.startswith(("FAILED", "ERROR"))]
    if done.returncode == 0:
        outcome = "survived"
    elif done.returncode < 0 or time.monotonic() - started > 60 * seconds:
        outcome = "time"
    else:
        outcome = "killed"
    first = failed[0].split(" - ")[0].partition(" ")[2] if failed else ""
    return outcome, first, round(spent, 2)


def say(line: str) -> None:
    """Write a line now."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a campaign; the exit code is 1 where tests fail without any change."""
    parser = argparse.ArgumentParser(prog="python -m campaigns.mutation", description=__doc__)
    parser.add_argument("--rooms", default="exact", help=f"some of {', '.join(ROOMS)}")
    parser.add_argument("--count", type=int, default=100, help="mutants to draw")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=None, help="file of JSON Lines")
    given = parser.parse_args(arguments)
    rooms = given.rooms.split(",")
    unknown = [x for x in rooms if x not in ROOMS]
    if unknown:
        parser.error(f"there is no room {unknown[0]!r}; known are {', '.join(ROOMS)}")
    counts: Counter[str] = Counter()
    baseline: dict[tuple[str, ...], float] = {}
    with tempfile.TemporaryDirectory() as name:
        tree = Path(name) / "glmref"
        shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(*LEFT_OUT))
        for room, module, mutant in drawn(rooms, given.count, given.seed):
            tests = tests_of(room, module)
            if tuple(tests) not in baseline:
                outcome, first, seconds = run(tree, tests, 3600.0)
                if outcome != "survived":
                    sys.stderr.write(f"{first or tests[0]} fails without any change\n")
                    return 1
                baseline[tuple(tests)] = max(LEAST, PATIENCE * seconds)
            right = (tree / module).read_text(encoding="utf-8")
            (tree / module).write_text(mutant.source, encoding="utf-8")
            outcome, first, seconds = run(tree, tests, baseline[tuple(tests)])
            (tree / module).write_text(right, encoding="utf-8")
            counts[outcome] += 1
            row = {
                "module": str(module), "line": mutant.line, "kind": mutant.kind,
                "before": mutant.before[:300], "after": mutant.after[:300],
                "outcome": outcome, "by": first, "seconds": seconds,
            }  # fmt: skip
            if given.output is not None:
                with given.output.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(row) + "\n")
            if outcome == "survived":
                say(f"{module}:{mutant.line}: {mutant.before!r} -> {mutant.after!r}")
    noticed = counts["killed"] + counts["time"]
    say(f"{noticed} of {counts.total()} mutants noticed, seed {given.seed}, {dict(counts)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
