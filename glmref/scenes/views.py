"""What of a scene's records goes into a table, and what into a picture."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ..views.chart import Series
from ..views.paths import Cloud, one_each
from .answers import duration
from .labels import grouped, method_of
from .model import Scene
from .planning import SAMPLED

Record = Mapping[str, Any]


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
    """Columns of the table: those that the questions fill."""
    found = ["method", "h", "steps", "outcome"]
    if "state" in scene.ask:
        found.append("state error")
    if "energy" in scene.ask:
        found.append("energy error")
    if "invariants" in scene.ask:
        found += ["invariants", "G-form"]
    if "parasitic" in scene.ask:
        found += ["lost at", "predicted", "largest rest"]
    if "law" in scene.ask:
        found += ["law", "exponent", "largest"]
    return (*found, "seconds", "q25", "q75", "evaluations", "iterations", "start")


def rows(scene: Scene, records: Sequence[Record], *, raw: bool = False) -> list[dict[str, Any]]:
    """One mapping per record, column -> cell.

    Parameters
    ----------
    raw : bool
        Numbers as they are (``None`` where there is none), else short texts.
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
    plain = ("h", "lost at", "predicted", "exponent")
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
    """Pictures of a scene: error against run time and against evaluations, or size over time."""
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
    return [
        Chart("", scene.title, "seconds", label, _lines(groups, error, "seconds")),
        Chart(
            "-evaluations",
            scene.title,
            "right-hand-side evaluations",
            label,
            _lines(groups, error, "evaluations"),
        ),
    ]


def orbits(scene: Scene, records: Sequence[Record]) -> Orbits | None:
    """Paths of the runs that keep one, one a method, all in the plane of the first."""
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
    lines = []
    for name, group in groups.items():
        points, notes = [], []
        for record in group:
            value, spent = record.get(f"{error}_error"), record.get(cost)
            if cost == "seconds" and spent:
                spent = spent["median"]
            if value is None or spent is None or record["outcome"] != "completed":
                continue
            points.append((float(spent), float(value)))
            notes.append(f"h = {record['h']:.4g}" if "h" in record else "")
        # joined in the order of the step sizes: sorted by a time that is noisy, lines would cross
        lines.append(Series(name, tuple(points), tuple(notes)))
    return tuple(lines)
