"""Answers about how runs ended, how accurate they were, and how their errors behave.

Each takes a scene and its records and returns one line; see :mod:`.answers`.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from typing import Any, TypeGuard

from .labels import grouped, listed, method_of, name_of
from .model import Scene

Record = Mapping[str, Any]


#: Relative energy error of a run that is no longer about the same motion.
LOST = 1.0


def ended(scene: Scene, records: Sequence[Record]) -> str:
    """Tell how the runs ended: methods by outcome or, at several step sizes, how far each goes."""
    if len(scene.grid) > 1:
        return _reach(records)
    outcomes: dict[str, list[str]] = {}
    for record in records:
        outcomes.setdefault(_outcome(record), []).append(method_of(record))
    ranked = sorted(outcomes, key=lambda word: (word != "completed", word))
    return "; ".join(f"{word}: {listed(outcomes[word])}" for word in ranked) or "nothing was run"


def _outcome(record: Record) -> str:
    """Return the outcome of a run.

    One that was completed with an energy error of its own size is lost.
    """
    error = record.get("energy_error")
    far = record["outcome"] == "completed" and error is not None and error >= LOST
    return "lost" if far else str(record["outcome"])


def _reach(records: Sequence[Record]) -> str:
    """Return for each method the largest good step size, or those at which it failed."""
    parts = []
    for name, group in grouped(records).items():
        runs = sorted((r["task"].get("h") or r["task"]["tolerance"], _outcome(r)) for r in group)
        good = [h for h, outcome in runs if outcome == "completed"]
        bad = [(h, outcome) for h, outcome in runs if outcome != "completed"]
        if not bad:
            parts.append(f"{name} at every h")
        elif not good:
            parts.append(f"{name} at none ({bad[0][1]})")
        elif max(good) < bad[0][0]:
            parts.append(f"{name} to h = {max(good):.3g} ({bad[0][1]} at {bad[0][0]:.3g})")
        else:
            told = listed([f"{h:.3g}" for h, _ in bad])
            parts.append(f"{name} but for h = {told} ({bad[0][1]})")
    return f"completed: {listed(parts, most=12)}" if parts else "nothing was run"


def accurate(scene: Scene, records: Sequence[Record]) -> str:
    """Tell which methods reach an error at one of the step sizes, fewest evaluations first."""
    error, at = scene.answer.error, scene.answer.at
    reached: dict[str, int] = {}
    missed: dict[str, float] = {}
    other: dict[str, str] = {}
    for name, group in grouped(records).items():
        errors = [
            (float(r[f"{error}_error"]), _cost(r))
            for r in group
            if r["outcome"] == "completed" and r.get(f"{error}_error") is not None
        ]
        good = [cost for value, cost in errors if value <= at]
        if good:
            reached[name] = min(good)
        elif errors:
            missed[name] = min(value for value, _ in errors)
        else:
            other[name] = group[-1]["outcome"]
    what = f"relative error {at:g} in the {error}"
    ranked = sorted(reached, key=lambda name: reached[name])
    told = [f"{name} ({_count(reached[name])})" for name in ranked]
    parts = [f"{what} (evaluations): {listed(told)}" if told else f"no method reached a {what}"]
    if missed:
        worse = sorted(missed, key=lambda name: missed[name])
        parts.append(f"not by {listed([f'{name} ({missed[name]:.1e})' for name in worse])}")
    return "; ".join(parts + _others(other) + _failures(scene, records))


def _failures(scene: Scene, records: Sequence[Record]) -> list[str]:
    """Return methods that failed at large steps only: the smallest such h, and the predicted."""
    told = []
    for name, group in grouped(records).items() if "limit" in scene.ask else ():
        good = [r["task"]["h"] for r in group if r["outcome"] == "completed" and "h" in r["task"]]
        bad = [r["task"]["h"] for r in group if r["outcome"] != "completed" and "h" in r["task"]]
        above = [h for h in bad if good and h > min(good)]
        if above:
            limit = group[0].get("limit")
            said = f", predicted from {limit:.2g}" if is_step(limit) else ""
            told.append(f"{name} (h = {min(above):.2g}{said})")
    return [f"fails at larger steps, down to: {listed(told, most=12)}"] if told else []


def is_step(limit: Any) -> TypeGuard[float]:
    """Return whether a record's limit is a step size: ``"none"`` says that there is no limit."""
    return isinstance(limit, float)


def _cost(record: Record) -> int:
    """Return evaluations of a run; a peer that does not count them comes last."""
    spent = record.get("evaluations")
    return 2**62 if spent is None else int(spent)


def _count(number: int) -> str:
    return "not counted" if number == 2**62 else f"{number:,}"


def order(scene: Scene, records: Sequence[Record]) -> str:
    """Return order that the errors of neighbouring step sizes show: the median over the pairs."""
    found: dict[str, float] = {}
    other: dict[str, str] = {}
    for name, group in grouped(records).items():
        points = [
            (math.log(abs(r["h"])), math.log(r["state_error"]))
            for r in group
            # an error as large as the state belongs to a run that is lost
            if r["outcome"] == "completed" and 0 < (r.get("state_error") or 0) < LOST
        ]
        slopes = [(y2 - y1) / (x2 - x1) for (x1, y1), (x2, y2) in pairwise(points) if x1 != x2]
        if slopes:
            found[name] = statistics.median(slopes)
        else:
            other[name] = group[-1]["outcome"]
    ranked = sorted(found, key=lambda name: -found[name])
    told = [f"{name} {found[name]:.1f}" for name in ranked]
    parts = [f"order seen: {listed(told, most=20)}"] if told else []
    return "; ".join(parts + _others(other)) or "no order was seen"


def law(scene: Scene, records: Sequence[Record]) -> str:
    """Return methods by the law of their deviation, with exponents."""
    laws: dict[str, list[str]] = {}
    other: dict[str, str] = {}
    for record in records:
        found, name = record.get("law"), name_of(record, with_h=len(scene.grid) > 1)
        if found is None:
            other[name] = record["outcome"]
            continue
        exponent = found["exponent"]
        said = name if exponent is None else f"{name} (t^{exponent:.2f}, {found['largest']:.1e})"
        laws.setdefault(found["kind"], []).append(said)
    kinds = ("bounded", "random walk", "linear", "quadratic", "blow-up")
    parts = [f"{kind}: {listed(laws[kind])}" for kind in kinds if kind in laws]
    return "; ".join(parts + _others(other)) or "no run was sampled"


def _others(other: Mapping[str, str]) -> list[str]:
    """Return named outcomes of methods that gave no number, in one part."""
    return [listed([f"{name}: {outcome}" for name, outcome in other.items()])] if other else []


KINDS: Mapping[str, Callable[[Scene, Sequence[Record]], str]] = {
    "ended": ended,
    "accurate": accurate,
    "order": order,
    "law": law,
}
