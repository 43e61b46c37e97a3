"""Explicit multistep pairs for any Hamiltonian: evaluations, by the scenes of docs/nonseparable.

    python -m campaigns.partitioned.nonseparable data/measurements/nonseparable.json

Semi-separable systems are measured here, too. The rest of the record, a million steps and renewal
among it, is of closed studies: its notes name their commands and the commit that has them.
"""

import json
import math
import sys
import tomllib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out, complete
from campaigns.pages import ROOT, Pages, markdown, measured
from campaigns.partitioned.work import crossing
from glmref import solve
from glmref.engine.outcome import Solution
from glmref.engine.parasites import WINDOW
from glmref.measure.longtime import along
from glmref.measure.work_precision import energy_error, reference_state, state_error
from glmref.method import Method
from glmref.problems.model import Problem
from glmref.scenes.labels import method_of
from glmref.scenes.reading import load_scene
from glmref.scenes.running import run

#: An energy error that is a loss, also where it is only rounded to this.
LOST = 1e-3
#: Steps of a long run.
LONG = 10_000_000
TOLERANCES = (1e-6, 1e-9)
SCENES = ROOT / "docs" / "nonseparable"
#: Steps of the first run, most steps, and the factor between two runs.
_LEAST, _MOST, _FACTOR = 100, 4_000, 1.08
#: The first steps with which growth compares, and what rounding may make.
_FIRST, _ROUNDING = 3 * WINDOW, 2e-15


@cache
def scenes() -> dict[str, Path]:
    """Return the scene of each problem."""
    found = {x: tomllib.loads(x.read_text(encoding="utf-8")) for x in sorted(SCENES.glob("*.toml"))}
    return {scene["problem"]["name"]: x for x, scene in found.items() if "problem" in scene}


@cache
def ends() -> dict[str, float]:
    """Return the last time of each problem, as its scene has it; 20 is that of the others."""
    return {name: load_scene(path).t_end for name, path in scenes().items()}


def reached(curve: Sequence[tuple[int, float]], tolerance: float) -> bool:
    """Return whether the last two of (evaluations, error) are below the tolerance."""
    return len(curve) > 1 and all(error < tolerance for _, error in curve[-2:])


def needed(curve: Sequence[tuple[int, float]], tolerance: float) -> int | None:
    """Return the evaluations for a tolerance that (evaluations, error) reach twice in a row."""
    for k in range(2, len(curve) + 1):
        if reached(curve[:k], tolerance) and (count := crossing(curve[:k], tolerance)):
            return round(count)
    return None


def evaluations(case: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Run the scene of a problem: evaluations, start included, by tolerance and method.

    A code that chooses its steps need not reach a tolerance twice: its last run may be the first.
    """
    scene = load_scene(scenes()[case["problem"]])
    curves: dict[str, list[tuple[int, float]]] = {}
    for x in run(scene):
        error = x["state_error"] if x["outcome"] == "completed" else None
        count = (x.get("evaluations") or 0) + x.get("start_evaluations", 0)
        made = curves.setdefault(method_of(x), [])
        made.append((count, math.inf if error is None else float(error)))
    found = {
        tolerance: {name: needed(curve, tolerance) for name, curve in curves.items()}
        for tolerance in TOLERANCES
    }
    for tolerance, counts in found.items():
        for name in scene.peers:
            last = crossing(curves[name], tolerance)
            counts[name] = counts[name] or (round(last) if last else None)
    return [
        {"problem": case["problem"], "tolerance": tolerance, "methods": counts}
        for tolerance, counts in found.items()
    ]


def _energy(one: Problem, found: Solution) -> float | None:
    """Return the largest relative error of the energy at the samples, ``None`` beyond range."""
    size = energy_error(one, found) if found.completed else math.inf
    return float(f"{size:.2g}") if math.isfinite(size) else None


def step_of(method: Method, one: Problem, steps: int = _LEAST) -> tuple[float, int] | None:
    """Return the first of two step sizes on end that give 1e-9, and the evaluations with start.

    The first one is that of so many ``steps``.
    """
    end, before = ends().get(one.name, 20.0), 0
    exact = reference_state(one, end)
    curve: list[tuple[int, float]] = []
    while steps <= _MOST:
        found = solve(one, method, h=end / steps, steps=steps, every=steps)
        error = state_error(found.y[-1], exact) if found.completed else math.inf
        curve.append((found.evaluations + found.start_evaluations, error))
        if (count := needed(curve, TOLERANCES[-1])) is not None:
            return float(f"{end / before:.3g}"), count
        before, steps = steps, math.ceil(steps * _FACTOR)
    return None


def long_run(name: str, one: Problem, h: float, steps: int, renew: int = 0) -> dict[str, Any]:
    """Return the largest relative error of the energy over 1,000 samples, and the notice's time."""
    found = solve(one, name, h=h, steps=steps, every=steps // 1000, renew=renew)
    reported = None if found.suspect is None else float(f"{found.suspect:.6g}")
    return {"energy": _energy(one, found), "reported": reported}


def growth(one: Problem, method: str, h: float, end: float, renew: int) -> float:
    """Return the largest median of the energy error in a window, up to a time, over the first one.

    The first one is the largest error of the first steps. At a close encounter the error of a sound
    orbit is large for a moment, too.
    """
    found = solve(one, method, h=h, steps=round(end / h), every=1, renew=renew)
    energy = along(one.hamiltonian, found.y)  # type: ignore[arg-type]
    error = np.abs(energy - energy[0])
    whole = np.median(error[: len(error) // WINDOW * WINDOW].reshape(-1, WINDOW), axis=1)
    rounding = _ROUNDING * abs(energy[0])
    return float(f"{whole.max(initial=0.0) / max(error[: _FIRST + 1].max(), rounding):.2g}")


def main(path: Path) -> None:
    """Count evaluations on the problems of the record, and write them into it."""
    record = json.loads(path.read_text(encoding="utf-8"))
    general, semi = (
        list(dict.fromkeys(x["problem"] for x in rows))
        for rows in (record["evaluations"], record["semi-separable"]["evaluations"])
    )
    counted = carried_out(evaluations, [{"problem": x} for x in [*general, *semi]], beside=path)
    rows = [x for found in counted for x in found]
    record["evaluations"] = [x for x in rows if x["problem"] in general]
    record["semi-separable"]["evaluations"] = [x for x in rows if x["problem"] in semi]
    complete(path, record)


def count_of(n: int | None) -> str:
    """Return a number of evaluations as the tables have it."""
    return "—" if n is None else f"{n:,}"


def count_table(rows: Sequence[Mapping[str, Any]], names: Sequence[str]) -> str:
    """Return the evaluations at 1e-9 of methods, the best Gauss and DOP853, in Markdown."""
    lines = []
    for x in rows:
        found = x["methods"]
        if x["tolerance"] == 1e-9:
            gauss = min(n for name, n in found.items() if name.startswith("gauss") and n)
            shown = [*(found[name] for name in names), gauss, found["scipy-dop853"]]
            lines.append([x["problem"], *map(count_of, shown)])
    return markdown(["problem", *(f"`{x}`" for x in names), "best Gauss", "DOP853"], lines)


def long_table(
    rows: Sequence[Mapping[str, Any]], columns: Sequence[tuple[str, int]], lost: float
) -> str:
    """Return the energy errors of long runs, or when they were reported, in Markdown.

    A column is a method and the steps between renewals. An error beyond ``lost`` is a loss.
    """
    found = {(x["problem"], x["method"], x.get("renew", 0)): x for x in rows}

    def cell(x: Mapping[str, Any]) -> str:
        if x.get("h") is None:
            return "—"
        if x["energy"] is None or x["energy"] >= lost:
            return f"lost, {x['reported']:g}"
        return f"{x['energy']:.1e}" + (f", notice {x['reported']:g}" if x["reported"] else "")

    lines = [
        [name, *(cell(found[name, *column]) for column in columns)]
        for name in dict.fromkeys(x["problem"] for x in rows)
    ]
    heads = [f"`{name}`" + (f", `renew={n}`" if n else "") for name, n in columns]
    return markdown(["problem", *heads], lines)


def _semi(what: str) -> list[dict[str, Any]]:
    found: list[dict[str, Any]] = measured("nonseparable")["semi-separable"][what]
    return found


#: The methods for semi-separable systems that the page has.
_KINETIC = tuple(f"multistep-kinetic-{order}" for order in (8, 10, 12))
_DOCS = ROOT / "docs"
PAGES: Pages = {
    _DOCS / "velocities.md": {
        "semi-separable": lambda: count_table(_semi("evaluations"), _KINETIC),
        "semi-separable-long": lambda: long_table(_semi("long"), [(m, 0) for m in _KINETIC], LOST),
    }
}


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
