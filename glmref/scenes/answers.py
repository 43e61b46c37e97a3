"""The one-line answer of a scene, computed from its records and nothing else."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..catalogue.lookup import load
from ..errors import GlmrefError
from .labels import grouped, listed, method_of
from .model import Scene
from .run_answers import KINDS

Record = Mapping[str, Any]


def answer(scene: Scene, records: Sequence[Record]) -> str:
    """Return the scene's answer; it says so where the records do not hold one."""
    answers: dict[str, Callable[[Scene, Sequence[Record]], str]] = {
        "fastest": _fastest,
        "lost": _lost,
        "conserved": _conserved,
        **KINDS,
    }
    return answers[scene.answer.kind](scene, records)


def duration(seconds: float) -> str:
    """Return a duration with three digits and its unit."""
    for unit, size in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds * 1e9:.3g} ns"


# --- fastest --------------------------------------------------------------------------------------


def seconds_at(records: Sequence[Record], error: str, at: float) -> float | None:
    """Return the seconds one method needs to reach an error, linear between its log-log points.

    ``None`` where no run reaches it. A run that is more accurate than asked counts with its whole
    time where no less accurate one is cheaper.
    """
    points = []
    for record in records:
        value, seconds = record.get(f"{error}_error"), record.get("seconds")
        if record["outcome"] == "completed" and value is not None and seconds:
            points.append((max(value, 1e-300), max(seconds["median"], 1e-12)))
    reached = [seconds for value, seconds in points if value <= at]
    if not reached:
        return None
    best = min(reached)
    for e1, s1 in points:
        for e2, s2 in points:
            if e1 > at >= e2 and s1 < s2:
                part = (math.log(at) - math.log(e1)) / (math.log(e2) - math.log(e1))
                best = min(best, math.exp(math.log(s1) + part * (math.log(s2) - math.log(s1))))
    return best


def _fastest(scene: Scene, records: Sequence[Record]) -> str:
    error, at = scene.answer.error, scene.answer.at
    times: dict[str, float] = {}
    missed: list[str] = []
    for name, group in grouped(records).items():
        seconds = seconds_at(group, error, at)
        if seconds is None:
            missed.append(name)
        else:
            times[name] = seconds
    what = f"relative error {at:g} in the {error}"
    if not times:
        return f"no method reached a {what} at these step sizes"
    ranked = sorted(times, key=lambda name: times[name])
    best = times[ranked[0]]
    parts = [f"{ranked[0]} needs {duration(best)}"]
    parts += [f"{name} {_times(times[name] / best)}" for name in ranked[1:3]]
    carried = next((name for name in ranked if _carries_several(records, name)), None)
    if carried is not None and carried not in ranked[:3]:
        parts.append(
            f"the first method with several values, {carried}, {_times(times[carried] / best)}"
        )
    sentence = f"{what}: {', '.join(parts)}"
    return sentence + (f"; not reached by {listed(missed)}" if missed else "")


def _times(ratio: float) -> str:
    return f"{ratio:.3g} times that"


def _carries_several(records: Sequence[Record], name: str) -> bool:
    """Return whether a method carries more than one value from step to step."""
    task = next(record["task"] for record in records if method_of(record) == name)
    if task["kind"] == "peer":
        return False
    try:
        return load(task["file"] or task["method"]).r > 1
    except GlmrefError:
        return False


# --- lost -----------------------------------------------------------------------------------------


def _saturating(record: Record) -> str:
    if (level := record.get("saturates")) is None:
        return ""
    return f" (predicted: the energy error stays near {level:.1g})"


def _lost(scene: Scene, records: Sequence[Record]) -> str:
    lost, bounded, other = [], [], []
    for record in records:
        name = method_of(record)
        if record.get("lost") is not None:
            guess = record.get("predicted")
            said = _saturating(record) if guess is None else f" (predicted {guess:.4g})"
            lost.append(f"{name} at t = {record['lost']:.4g}{said}")
        elif record["outcome"] == "completed":
            bounded.append(f"{name}{_saturating(record)}")
        else:
            other.append(f"{name}: {record['outcome']}")
    ends = [x["task"]["t_end"] for x in records if "t_end" in x["task"]]  # of a changed copy, too
    end = f"t = {max(ends, default=scene.t_end):g}"
    steps = max((record.get("steps") or 0 for record in records), default=0)
    parts = [f"lost: {listed(lost)}" if lost else "none is lost"]
    if bounded:
        parts.append(f"bounded to {end} ({steps:,} steps): {listed(bounded)}")
    return "; ".join(parts + ([listed(other)] if other else []))


# --- conserved ------------------------------------------------------------------------------------


def _kept_drift(record: Record) -> float | None:
    """Return the largest drift of the G-forms.

    Where there are none, of the next best conserved quantities.
    """
    drifts = record.get("drifts") or []
    for kind in ("form", "quadratic", "invariant", "hamiltonian"):
        values = [one["largest"] for one in drifts if one["kind"] == kind]
        if values:
            break
    else:
        return None
    return None if None in values else max(values)


def _conserved(scene: Scene, records: Sequence[Record]) -> str:
    kept: dict[str, float] = {}
    drifting: dict[str, float] = {}
    other = []
    for record in records:
        drift, name = _kept_drift(record), method_of(record)
        if record["outcome"] != "completed" or drift is None:
            other.append(f"{name}: {record['outcome']}")
            continue
        where = kept if drift <= scene.answer.at else drifting
        where[name] = max(drift, where.get(name, 0.0))
    steps = max((record.get("steps") or 0 for record in records), default=0)
    parts = []
    if kept:
        worst = max(kept.values())
        parts.append(f"kept to {worst:.1e} over {steps:,} steps: {listed(list(kept))}")
    if drifting:
        told = [f"{name} ({value:.1e})" for name, value in drifting.items()]
        parts.append(f"not kept: {listed(told)}")
    return "; ".join(parts + ([listed(other)] if other else [])) or "no run was completed"
