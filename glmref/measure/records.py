"""Records that survive: one JSON object a line, appended and synced, resumed by key.

A *task* is a JSON-ready mapping that says what to measure; its key is a hash of its canonical text.
A record is the task with what was measured. A file killed in the middle of a line loses that line
only, and a second run measures just what is missing.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import DataError

__all__ = ["FORMAT", "RecordFile", "finite", "key_of", "read_records"]

FORMAT = "glmref-record-1"


def key_of(task: Mapping[str, Any]) -> str:
    """Sixteen hexadecimal digits that depend on the task's content alone."""
    text = json.dumps(task, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def finite(value: float | None) -> float | None:
    """A float that JSON can carry: NaN and infinities become ``None``."""
    return None if value is None or not math.isfinite(value) else float(value)


def read_records(path: Path) -> list[dict[str, Any]]:
    """Read the whole records of a file; a torn last line is passed over.

    Raises
    ------
    DataError: for a line in the middle that is not a record.
    """
    if not path.exists():
        return []
    lines = path.read_text(encoding="utf-8").split("\n")
    records: list[dict[str, Any]] = []
    for number, line in enumerate(lines, start=1):
        if not line.strip():
            continue
        try:
            record = json.loads(line)
        except json.JSONDecodeError:
            if number == len(lines):  # no newline after it: the writer was killed here
                break
            raise DataError(
                f"{path.name}: line {number} is not a JSON record; delete that line"
            ) from None
        found = record.get("format") if isinstance(record, dict) else None
        if found != FORMAT or "key" not in record or "task" not in record:
            what = (
                f"is a record of format {found!r}, and this version reads {FORMAT!r}; move the file"
                if isinstance(found, str) and found != FORMAT
                else f"is not a record of format {FORMAT}; move the file"
            )
            raise DataError(f"{path.name}: line {number} {what} away to measure anew")
        records.append(record)
    return records


def _drop_torn_line(path: Path) -> None:
    """Cut what a killed writer left after the last newline, so that appending starts clean."""
    if not path.exists():
        return
    content = path.read_bytes()
    whole = content.rfind(b"\n") + 1
    if whole < len(content):
        with path.open("r+b") as stream:
            stream.truncate(whole)


class RecordFile:
    """Append records to a file; know which tasks it already holds.

    Args:
        path: the file, created with its folder when missing. ``None`` keeps records in memory only.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.records: list[dict[str, Any]] = []
        if path is not None:
            path.parent.mkdir(parents=True, exist_ok=True)
            _drop_torn_line(path)
            self.records = read_records(path)
        self._by_key = {record["key"]: record for record in self.records}

    def find(self, task: Mapping[str, Any]) -> dict[str, Any] | None:
        """Return the record of a task, if it is there."""
        return self._by_key.get(key_of(task))

    def missing(self, tasks: Iterable[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
        """Tasks without a record, in order."""
        return (task for task in tasks if self.find(task) is None)

    def append(self, task: Mapping[str, Any], measured: Mapping[str, Any]) -> dict[str, Any]:
        """Add one record and make sure that it is on the disk before returning it.

        Raises
        ------
            ValueError: for NaN or an infinity, which JSON lacks; nothing is written then.
        """
        record = {"format": FORMAT, "key": key_of(task), "task": dict(task), **measured}
        line = json.dumps(record, allow_nan=False, separators=(",", ":")) + "\n"
        if self.path is not None:
            with self.path.open("a", encoding="utf-8") as stream:
                stream.write(line)
                stream.flush()
                os.fsync(stream.fileno())
        self.records.append(record)
        self._by_key[record["key"]] = record
        return record
