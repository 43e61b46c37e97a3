"""``python -m campaigns.mutation``: draw mutants, run their tests, record what came of each."""

import argparse
import json
import os
import random
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path

from .bench import ROOT, Bench
from .mutants import Mutant, mutants

#: Subpackage -> its modules: of a folder, or some files of one; ``-`` leaves one out.
SUBPACKAGES: dict[str, str] = {
    "exact": "exact/*",
    "readers": "catalogue/reader catalogue/strict_json catalogue/strict_toml catalogue/entries "
    "catalogue/keys scenes/reading",
    "prove": "prove/* -prove/kernel -prove/implications -prove/find_rows -prove/ranges",
    "kernel": "prove/kernel prove/implications prove/find_rows prove/ranges",
    "theory": "theory/*",
    "engine": "engine/*",
}
#: Quick tests that are collected, and beginnings of those that concern other subpackages.
TESTS = ("tests/unit", "tests/laws", "tests/adversary", "tests/literature", "tests/attack",
         "tests/suite/test_bad_input.py", "tests/suite/test_judge.py",
         "tests/suite/test_judge_catalogue.py", "tests/repo/test_coq.py")  # fmt: skip
OTHERS = (
    *("compute", "report", "cli", "campaigns", "pictures", "measure"),
    *("convergence", "typed", "audit", "peers"),
)
#: What tells a mutant in a record.
KEY = ("module", "line", "column", "before", "after")


def modules(subpackage: str) -> list[Path]:
    """Return modules of a subpackage, as paths in the tree."""
    names = SUBPACKAGES[subpackage].split()
    without = {ROOT / "glmref" / f"{x[1:]}.py" for x in names if x[0] == "-"}
    found = [p for x in names for p in sorted((ROOT / "glmref").glob(f"{x}.py"))]
    return [p.relative_to(ROOT) for p in found if p.stem != "__init__" and p not in without]


def drawn(subpackages: Sequence[str], count: int, seed: int) -> Iterator[tuple[str, Path, Mutant]]:
    """Draw mutants by turns of the subpackages; within one each is as likely as any other."""
    by_turns = []
    for subpackage in subpackages:
        every = [
            (subpackage, module, mutant)
            for module in modules(subpackage)
            for mutant in mutants((ROOT / module).read_text(encoding="utf-8"))
        ]
        most = min(-(-count // len(subpackages)), len(every))
        by_turns.append(random.Random(f"{seed} {subpackage}").sample(every, most))
    for turn in range(max(map(len, by_turns))):
        yield from (x[turn] for x in by_turns if turn < len(x))


def say(line: str) -> None:
    """Write a line now."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def run(bench: Bench, chosen: Sequence[tuple[str, Path, Mutant]], output: Path | None) -> None:
    """Run mutants; those recorded in the output are not run again."""
    counts: dict[str, Counter[str]] = {}
    done = {}
    if output is not None and output.exists():
        rows = map(json.loads, output.read_text(encoding="utf-8").splitlines())
        done = {tuple(x[name] for name in KEY): x for x in rows}
    for subpackage, module, mutant in chosen:
        place = str(module), mutant.line, mutant.column
        key = (*place, mutant.before[:300], mutant.after[:300])
        row = done.get(key)
        if row is None:
            outcome, first, seconds = bench.judged(module, mutant)
            row = {"subpackage": subpackage, "kind": mutant.kind, "function": mutant.function,
                   **dict(zip(KEY, key, strict=True)),
                   "outcome": outcome, "by": first, "seconds": round(seconds, 2)}  # fmt: skip
            if output is not None:
                with output.open("a", encoding="utf-8") as stream:
                    stream.write(json.dumps(row) + "\n")
        counts.setdefault(subpackage, Counter())[row["outcome"]] += 1
        if row["outcome"] == "survived":
            where = ":".join(map(str, place))
            say(f"{where}: {mutant.before!r} -> {mutant.after!r}")
    for subpackage, found in counts.items():
        noticed = found["killed"] + found["time"]
        say(f"{subpackage}: {noticed} of {found.total()} noticed, {noticed / found.total():.1%}")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a campaign."""
    parser = argparse.ArgumentParser(prog="python -m campaigns.mutation", description=__doc__)
    parser.add_argument("--subpackages", default="exact", help=f"some of {', '.join(SUBPACKAGES)}")
    parser.add_argument("--count", type=int, default=100, help="mutants to draw")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--output", type=Path, default=None, help="file of JSON Lines")
    parser.add_argument("--calls", type=Path, default=None, help="file that keeps what tests call")
    given = parser.parse_args(arguments)
    subpackages = given.subpackages.split(",")
    unknown = [x for x in subpackages if x not in SUBPACKAGES]
    if unknown:
        parser.error(f"there is no subpackage {unknown[0]!r}; known are {', '.join(SUBPACKAGES)}")
    os.chdir(ROOT)
    os.environ["CI"] = "1"  # the same examples for every mutant
    chosen = list(drawn(subpackages, given.count, given.seed))
    watched = [x for subpackage in SUBPACKAGES for x in modules(subpackage)]
    left = [f"--ignore-glob=*/test_{x}*" for x in OTHERS]
    with tempfile.TemporaryDirectory() as name:
        os.environ.setdefault("GLMREF_CACHE", str(Path(name) / "kernels"))
        run(Bench(Path(name), [*TESTS, *left], watched, given.calls), chosen, given.output)
    return 0


if __name__ == "__main__":
    sys.exit(main())
