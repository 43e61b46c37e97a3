"""What of a scene's records goes into a table, and what into a picture."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..views.chart import Series
from ..views.paths import Cloud, one_each
from .answers import duration
from .labels import grouped, method_of
from .model import Scene
from .planning import SAMPLED
from .run_answers import is_step

Record = Mapping[str, Any]
#: Errors below half a unit in the last place are drawn there: less is chance.
UNIT = 2.0**-54


@dataclass(frozen=True)
class Chart:
    """A picture to draw: its file's suffix, its words and its lines."""

    suffix: str
    title: str
    x_label: str
    y_label: str
    series: tuple[Series, ...]


@dataclass(frozen=True)
class Orbits:
    """A picture of paths in a plane, one for each method."""

    title: str
    x_label: str
    y_label: str
    clouds: tuple[Cloud, ...]


def columns_of(scene: Scene) -> tuple[str, ...]:
    """Return columns of the table: those that the questions fill."""
    found = ["method", "h", "steps", "outcome"]
    if "state" in scene.ask:
        found.append("state error")
    if "energy" in scene.ask:
        found.append("energy error")
    if "limit" in scene.ask:
        found.append("stable to")
    if "invariants" in scene.ask:
        found += ["invariants", "G-form"]
    if "parasitic" in scene.ask:
        found += ["lost at", "predicted", "largest rest"]
    if "law" in scene.ask:
        found += ["law", "exponent", "largest"]
    return (*found, "seconds", "q25", "q75", "evaluations", "iterations", "start")


def rows(scene: Scene, records: Sequence[Record], *, raw: bool = False) -> list[dict[str, Any]]:
    """Return one mapping per record, column -> cell.

    Cells are short texts; ``raw`` ones numbers as they are (``None`` where there is none).
    """
    return [
        {column: _cell(column, record, raw=raw) for column in columns_of(scene)}
        for record in records
    ]


def _cell(column: str, record: Record, *, raw: bool) -> Any:
    value = _value(column, record)
    if raw or isinstance(value, str):
        return value
    if value is None:
        return "-"
    if column in ("seconds", "q25", "q75"):
        return duration(value)
    if isinstance(value, int):
        return f"{value}"
    plain = ("h", "lost at", "predicted", "exponent", "stable to")
    return f"{value:.6g}" if column in plain else f"{value:.2e}"


def _value(column: str, record: Record) -> Any:
    task, seconds = record["task"], record.get("seconds") or {}
    if column == "method":
        return method_of(record)
    if column == "h":
        return task["h"] if task["kind"] == "method" else f"tol {task['tolerance']:g}"
    if column in ("seconds", "q25", "q75"):
        return seconds.get("median" if column == "seconds" else column)
    if column in ("law", "exponent", "largest"):
        return (record.get("law") or {}).get("kind" if column == "law" else column)
    if column in ("invariants", "G-form"):
        return _drift(record, form=column == "G-form")
    keys = {
        "state error": "state_error",
        "energy error": "energy_error",
        "lost at": "lost",
        "largest rest": "largest",
        "start": "start_evaluations",
        "stable to": "limit",
    }
    return record.get(keys.get(column, column))


def _drift(record: Record, *, form: bool) -> float | None:
    values = [
        one["largest"]
        for one in record.get("drifts") or []
        if (one["kind"] == "form") == form and one["largest"] is not None
    ]
    return max(values, default=None)


def charts(scene: Scene, records: Sequence[Record]) -> list[Chart]:
    """Draw a scene: error against run time and evaluations, or size over time."""
    groups = grouped(records)
    if SAMPLED & set(scene.ask):
        parasitic = "parasitic" in scene.ask
        what = "size of the values beyond the solution" if parasitic else "relative drift so far"
        lines = [
            Series(
                name if len(group) == 1 else f"{name}, h = {record['task']['h']:.3g}",
                tuple((t, v) for t, v in record.get("series") or []),
            )
            for name, group in groups.items()
            for record in group
        ]
        return [Chart("", scene.title, "time", what, tuple(lines))]
    asked = [e for e in (scene.answer.error, "state", "energy") if e in scene.ask]
    if not asked:
        return []
    error = asked[0]
    label = f"relative error in the {error}"
    costs = [
        ("", "seconds", "seconds"),
        ("-evaluations", "right-hand-side evaluations", "evaluations"),
    ]
    if "limit" in scene.ask:
        costs.append(("-h", "step size h", "h"))
    return [
        Chart(suffix, scene.title, words, label, _lines(groups, error, cost))
        for suffix, words, cost in costs
    ]


def orbits(scene: Scene, records: Sequence[Record]) -> Orbits | None:
    """Return paths of the runs that keep one, one a method, all in the plane of the first."""
    kept = [record for record in records if record.get("orbit")]
    if not kept:
        return None
    axes = kept[0]["orbit"]["axes"]
    clouds = one_each([_cloud(record) for record in kept if record["orbit"]["axes"] == axes])
    return Orbits(scene.title, axes[0], axes[1], tuple(clouds))


def _cloud(record: Record) -> Cloud:
    block = record["orbit"]
    points = tuple((x, y) for path in block["paths"] for _, x, y in path)
    return Cloud(method_of(record), points, block["ended"], record["task"]["h"])


def _lines(groups: Mapping[str, Sequence[Record]], error: str, cost: str) -> tuple[Series, ...]:
    """Return one line for each method, with its failures and its predicted limit where known."""
    lines = []
    for name, group in groups.items():
        if cost == "h" and not any("h" in record["task"] for record in group):
            continue  # a peer chooses its steps
        points, notes, failures = [], [], []
        for record in group:
            value, spent = record.get(f"{error}_error"), _spent(record, group, cost)
            h = f"h = {record['task']['h']:.4g}" if "h" in record["task"] else ""
            if spent is None:
                continue
            if record["outcome"] != "completed":
                failures.append((spent, ", ".join(filter(None, (h, str(record["outcome"]))))))
            elif value is not None:
                points.append((float(spent), max(float(value), UNIT)))
                notes.append(h)
        # joined in the order of the step sizes: sorted by a time that is noisy, lines would cross
        limit = group[0].get("limit")
        ends = _at_step(limit, group, cost) if is_step(limit) else None
        lines.append(Series(name, tuple(points), tuple(notes), tuple(failures), ends))
    return tuple(lines)


def _spent(record: Record, group: Sequence[Record], cost: str) -> float | None:
    """Return what a run cost; of one that failed what it would have cost, as far as others show."""
    if cost == "h" or (record["outcome"] != "completed" and "h" in record["task"]):
        h = record["task"].get("h")
        return None if h is None else _at_step(h, group, cost)
    spent = record.get(cost)
    return spent["median"] if cost == "seconds" and spent else spent


def _at_step(h: float, group: Sequence[Record], cost: str) -> float | None:
    """Return what a run of a method costs at a step size: per step as its completed runs do."""
    if cost == "h":
        return h
    done = [r for r in group if r["outcome"] == "completed" and r.get("steps") and r.get(cost)]
    each = [(r[cost]["median"] if cost == "seconds" else r[cost]) / r["steps"] for r in done]
    length = next((r["task"]["t_end"] for r in group), 0.0)
    return statistics.median(each) * length / h if each else None
