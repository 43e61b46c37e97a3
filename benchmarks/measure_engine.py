"""Measure the engine: ``python -m benchmarks.measure_engine [--write]``.

Three comparisons, :mod:`benchmarks.compare_c`, :mod:`benchmarks.compare_lanes` and
:mod:`benchmarks.compare_kepler`. Prints their tables; with ``--write`` stores what was measured in
data/measurements/engine.json and the tables in docs/engine.md. Needs a C compiler, heyoka, scipy.
"""

from __future__ import annotations

import math
import sys
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

from benchmarks import compare_c, compare_kepler, compare_lanes
from benchmarks.engine_tables import TABLES, filled
from glmref.experiments.measure import circumstances
from glmref.strict_json import write_json

ROOT = Path(__file__).resolve().parents[1]
RECORD = ROOT / "data" / "measurements" / "engine.json"
PAGE = ROOT / "docs" / "engine.md"

MEASURED = (
    "Processor time of one thread; competitors take turns within one run; quartiles and medians "
    "over the turns. `nanoseconds`: of one step of one trajectory (`force`: of one evaluation). "
    "`c_over_engine`: time of the hand-written C loop of the same arithmetic over that of the "
    "engine, turn by turn. `engine_over_force`: time of a step over that of its evaluations of the "
    "force alone, one after the other, in C. `reference_over_engine`: the numpy reference engine. "
    "`gain`: one by one over in lanes. `goal`: relative energy error, the largest of 97 samples "
    "over 1000 periods; `setting`: steps per period, or the tolerance of a peer."
)


def plain(value: Any) -> Any:
    """Numbers with four digits, and no number where there is none."""
    if isinstance(value, float):
        return float(f"{value:.4g}") if math.isfinite(value) else None
    if isinstance(value, dict):
        return {key: plain(x) for key, x in value.items()}
    return [plain(x) for x in value] if isinstance(value, list | tuple) else value


def record() -> dict[str, Any]:
    """Everything measured, as the document that is stored."""
    tell = sys.stderr.write
    tell("settings for Kepler\n")
    settings = compare_kepler.settings()
    tell("against C\n")
    rows: list[dict[str, Any]] = [{"comparison": "c", **asdict(x)} for x in compare_c.measure_all()]
    tell("lanes\n")
    rows += [{"comparison": "lanes", **asdict(x)} for x in compare_lanes.measure_all()]
    tell("Kepler\n")
    rows += [{"comparison": "kepler", **asdict(x)} for x in compare_kepler.measure_all(settings)]
    where = circumstances()
    where["versions"] |= {name: version(name) for name in ("llvmlite", "scipy", "heyoka")}
    where |= {"compiler": compare_c.compiler_version(), "flags": " ".join(compare_c.FLAGS)}
    return {
        "format": "glmref-measurement-1",
        "name": "engine",
        "question": "How fast are the compiled kernels against hand-written C, evaluations alone, "
        "the reference engine and other people's integrators?",
        "command": "python -m benchmarks.measure_engine --write",
        "problem": "Kepler (e = 3/5), Hénon-Heiles, outer solar system",
        "measured": MEASURED,
        "where": where,
        "rows": plain(rows),
    }


def main() -> None:
    """Measure, print, and store where asked to."""
    document = record()
    for write in TABLES.values():
        sys.stdout.write(write(document["rows"]) + "\n\n")
    if "--write" in sys.argv[1:]:
        write_json(RECORD, document)
        page = filled(PAGE.read_text(encoding="utf-8"), document["rows"])
        PAGE.write_text(page, encoding="utf-8")


if __name__ == "__main__":
    main()
