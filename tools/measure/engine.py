"""Measure the engine: ``python -m tools.measure.engine [--write] [COMPARISON ...]``.

Four comparisons: ``c`` and ``sweep`` of :mod:`tools.measure.compare_c`, ``lanes`` of
:mod:`tools.measure.compare_lanes` and ``kepler`` of :mod:`tools.measure.compare_kepler`; where
some are named, only these are measured, and the rows of the others are those of the record. Prints
the tables; with ``--write`` it stores them in data/measurements/engine.json and in
tools/measure/README.md, docs/engine.md and campaigns/partitioned/README.md; without names
also the table of :mod:`tools.measure.compare_textbook`, so that one command renews the pages. Needs
a C compiler, heyoka, scipy.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from campaigns import pages
from glmref.measure.timing import circumstances
from tools.measure import compare_c, compare_kepler, compare_lanes, compare_textbook
from tools.measure.engine_tables import PAGES, TABLES
from tools.measured_json import write_json

ROOT = Path(__file__).resolve().parents[2]
RECORD = ROOT / "data" / "measurements" / "engine.json"

MEASURED = (
    "Processor time of one thread; competitors take turns within one run; quartiles and medians "
    "over the turns. `nanoseconds`: of one step of one trajectory (`force`: of one evaluation). "
    "`c_over_engine`: time of the hand-written C loop of the same arithmetic, at the optimisation "
    "level `level`, the faster of -O3 and -O2, over that of the engine, turn by turn. "
    "`contracted_over_fused`: the same with products and sums fused on both sides, C by "
    "-ffp-contract=fast, the engine by arithmetic='fused'. `engine_over_force`: time "
    "of a step over that of its evaluations of the force alone, one after the other, in C. "
    "`reference_over_engine`: the numpy reference engine. `gain`: one by one over in lanes. "
    "`goal`: relative energy error, the largest of 97 samples "
    "over 1000 periods; `setting`: steps per period, or the tolerance of a peer. The comparisons "
    "`c`, `sweep`, `lanes` and `kepler` may come from runs of their own on the same machine."
)


def plain(value: Any) -> Any:
    """Return numbers with four digits, and no number where there is none."""
    if isinstance(value, float):
        return float(f"{value:.4g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: plain(x) for key, x in value.items()}
    return [plain(x) for x in value] if isinstance(value, list | tuple) else value


def kepler() -> list[compare_kepler.Row]:
    """Find the settings for Kepler's problem, then time all integrators at theirs."""
    return compare_kepler.measure_all(compare_kepler.settings())


#: Name of a comparison in the record -> what measures it.
COMPARISONS: dict[str, Callable[[], Sequence[Any]]] = {
    "c": compare_c.measure_all,
    "sweep": compare_c.measure_sweeps,
    "lanes": compare_lanes.measure_all,
    "kepler": kepler,
}


def circumstances_now() -> dict[str, Any]:
    """Return machine, versions and compiler flags."""
    where = circumstances()
    where["versions"] |= {name: version(name) for name in ("llvmlite", "scipy", "heyoka")}
    return where | {"compiler": compare_c.compiler_version(), "flags": " ".join(compare_c.FLAGS)}


def record(wanted: Sequence[str], known: dict[str, Any]) -> dict[str, Any]:
    """Measure everything and return the document that is stored.

    Raises
    ------
    SystemExit
        Where rows would be kept that were measured under other circumstances.
    """
    where, rows = circumstances_now(), []
    others = [row for row in known.get("rows", []) if row["comparison"] not in wanted]
    if others and known["where"] != where:
        raise SystemExit("other machine, versions or flags than those of the record: measure all")
    for name, measured in COMPARISONS.items():
        if name not in wanted:
            rows += [row for row in others if row["comparison"] == name]
            continue
        sys.stderr.write(f"{name}\n")
        rows += plain([{"comparison": name, **asdict(row)} for row in measured()])
    return {
        "format": "glmref-measurement-1",
        "name": "engine",
        "question": "How fast are the compiled kernels against hand-written C, evaluations alone, "
        "the reference engine and other people's integrators?",
        "command": "python -m tools.measure.engine --write",
        "problem": "Kepler (e = 3/5), Hénon-Heiles, outer solar system, pendulum",
        "measured": MEASURED,
        "where": where,
        "rows": rows,
    }


def main() -> None:
    """Measure, print, and store where asked to."""
    wanted = [name for name in sys.argv[1:] if name != "--write"] or list(COMPARISONS)
    unknown = [name for name in wanted if name not in COMPARISONS]
    if unknown:
        raise SystemExit(f"{unknown[0]!r} is none of the comparisons {', '.join(COMPARISONS)}")
    known = json.loads(RECORD.read_text(encoding="utf-8")) if RECORD.exists() else {}
    document = record(wanted, known)
    for write in TABLES.values():
        sys.stdout.write(write(document["rows"]) + "\n\n")
    if "--write" in sys.argv[1:]:
        write_json(RECORD, document)
        pages.write(PAGES)
        if len(wanted) == len(COMPARISONS):
            compare_textbook.main(write=True)


if __name__ == "__main__":
    main()
