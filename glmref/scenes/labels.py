"""Words that answers and tables share: names of methods, lists, groups of records."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

Record = Mapping[str, Any]
#: Names listed in full; more are counted.
LISTED = 6


def method_of(record: Record) -> str:
    """Return the name of the method or the peer of a record."""
    task = record["task"]
    return task["peer"] if task["kind"] == "peer" else task["method"]


def name_of(record: Record, *, with_h: bool) -> str:
    """Return the name of a run: its method, and its step size where asked."""
    task, name = record["task"], method_of(record)
    return f"{name} h = {task['h']:.3g}" if with_h and task["kind"] == "method" else name


def listed(names: Sequence[str], *, most: int = LISTED) -> str:
    """Return the first names with commas; the rest is counted."""
    if len(names) <= most:
        return ", ".join(names)
    return f"{', '.join(names[:most])} and {len(names) - most} more"


def grouped(records: Sequence[Record]) -> dict[str, list[Record]]:
    """Return records by method or peer, in order."""
    groups: dict[str, list[Record]] = {}
    for record in records:
        groups.setdefault(method_of(record), []).append(record)
    return groups
