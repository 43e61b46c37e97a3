"""Records that survive: one JSON object a line, with a checksum, appended, synced, resumed by key.

A *task* is a JSON-ready mapping that says what to measure; its key is a hash of its canonical text.
A record is the task with what was measured, and a checksum over both. Whatever happens to a file (a
writer killed in the middle of a line, a full disk, a bit that flips, two writers at once, lines of
another program) costs the lines that it hit and no others: they are moved to a file beside it, one
sentence says so, and their tasks are measured again. Only the process that holds the lock writes.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..catalogue.canonical import compact
from ..errors import DataError, UsageError
from ..system.files import (
    BINARY,
    Lock,
    lines_of,
    make_folder,
    printable,
    read_bytes,
    reason,
    sync_folder,
)
from ..system.files import write_bytes as replace_file

FORMAT = "glmref-record-1"
#: The field with the checksum of a record; records of version 0.1.0 and before have none.
CHECKSUM = "sha256"
#: A record file is read as a whole; this many bytes are some million records.
MAX_BYTES = 1 << 30

_HEXADECIMAL = re.compile("[0-9a-f]{64}")
_BEGIN = re.compile(r'\{\s*"format"\s*:\s*"')
#: What begins as a record in a damaged line, and is none, so many times.
_TRIES = 100


def key_of(task: Mapping[str, Any]) -> str:
    """Sixteen hexadecimal digits that depend on the task's content alone."""
    return hashlib.sha256(compact(task, sort_keys=True)).hexdigest()[:16]


def checksum(record: Mapping[str, Any]) -> str:
    """SHA-256 of a record's canonical text without its checksum, in hexadecimal digits."""
    return hashlib.sha256(
        compact({k: x for k, x in record.items() if k != CHECKSUM}, sort_keys=True)
    ).hexdigest()


def wrong_checksum(record: Mapping[str, Any]) -> bool:
    """Whether a record has a checksum that its content contradicts; an old record has none."""
    if CHECKSUM not in record:
        return _has_checksum(record)
    try:
        return record[CHECKSUM] != checksum(record)
    except ValueError:  # NaN, which is never written
        return True


def _has_checksum(record: Mapping[str, Any]) -> bool:
    """Whether there is a checksum, be it under a name that was damaged."""
    last = record[next(reversed(list(record)))] if record else None
    return CHECKSUM in record or (
        isinstance(last, str) and _HEXADECIMAL.fullmatch(last) is not None
    )


def finite(value: float | None) -> float | None:
    """A float that JSON can carry: NaN and infinities become ``None``."""
    return None if value is None or not math.isfinite(value) else float(value)


# --- reading --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Fault:
    """A line that is no record."""

    line: int  #: Its number, from 1.
    why: str  #: What is wrong, as the end of a sentence that begins with "it".
    raw: bytes  #: Its content.
    foreign: bool = False  #: Whether it is sound JSON of something else.
    second: bool = False  #: Whether it is a sound record of a task that has one already.


@dataclass(frozen=True)
class Content:
    """What a file of records holds."""

    records: list[dict[str, Any]]  #: Sound records in order, the first of each task.
    kept: list[bytes]  #: Their lines.
    faults: list[Fault]  #: The other lines.
    #: Number of the last line, where its writer was stopped in the middle of it.
    torn: int | None = None
    whole: int = 0  #: Bytes up to the end of the last line that has one.
    unended: bool = False  #: Whether the last record is sound and has lost the end of its line.


class _NotARecord(Exception):
    """Why a line is no record."""

    def __init__(self, why: str, *, foreign: bool = False) -> None:
        super().__init__(why)
        self.foreign = foreign


def _record(raw: bytes) -> dict[str, Any]:
    """Read one line."""
    try:
        record = json.loads(raw.decode("utf-8"))
    except (ValueError, RecursionError):
        raise _NotARecord("is not a JSON record") from None
    sound = _sound(record)
    # two texts can be one number, so that the checksum agrees although a digit has changed
    if CHECKSUM in sound and compact(sound) != raw.strip():
        raise _NotARecord("is not as it was written")
    return sound


def _sound(record: Any) -> dict[str, Any]:
    """Check what a line holds."""
    form = record.get("format") if isinstance(record, dict) else None
    if not isinstance(record, dict) or not isinstance(form, str):
        foreign = not isinstance(record, dict) or not _has_checksum(record)
        raise _NotARecord(f"is not a record of format {FORMAT}", foreign=foreign)
    # sound JSON is somebody's, unless it has a checksum that shows that it was changed
    foreign = not _has_checksum(record) or not wrong_checksum(record)
    if form != FORMAT:
        raise _NotARecord(
            f"is a record of format {form[:40]!r}, and this version reads {FORMAT!r}",
            foreign=foreign,
        )
    if "key" not in record or not isinstance(record.get("task"), dict):
        raise _NotARecord(f"is not a record of format {FORMAT}", foreign=foreign)
    if wrong_checksum(record):
        raise _NotARecord("is damaged: its checksum does not agree with its content")
    try:
        key = key_of(record["task"])
    except ValueError:
        key = ""
    if record["key"] != key:
        raise _NotARecord("is damaged: its key does not agree with its task")
    return record


def _salvaged(raw: bytes) -> list[dict[str, Any]]:
    """Find the records of a line that is damaged: those alone whose checksum agrees."""
    found: list[dict[str, Any]] = []
    decoder, text = json.JSONDecoder(), raw.decode("utf-8", "replace")
    failed = 0
    for begin in _BEGIN.finditer(text):
        try:
            record = _sound(decoder.raw_decode(text, begin.start())[0])
        except (ValueError, RecursionError, _NotARecord):
            failed += 1
            if failed == _TRIES:  # each takes as long as the line
                break
            continue
        if CHECKSUM in record:
            found.append(record)
    return found


def scan(path: Path) -> Content:
    """Read a file of records, and tell sound lines from others.

    Raises
    ------
    DataError
        For a file that cannot be read, or that holds something else than records.
    """
    try:
        content = read_bytes(path, MAX_BYTES) if os.path.lexists(path) else b""
    except DataError:
        if not os.path.lexists(path):  # deleted between the two calls
            return Content([], [], [])
        raise
    records: dict[str, dict[str, Any]] = {}
    kept: list[bytes] = []
    faults: list[Fault] = []
    torn, whole, unended = None, 0, False
    for number, (raw, ended) in enumerate(lines_of(content), start=1):
        whole += len(raw) + 1 if ended else 0
        if not raw.strip():
            continue
        try:
            rows = [(_record(raw), raw)]
            if not ended and CHECKSUM not in rows[0][0]:
                raise _NotARecord("is not ended")
            unended = not ended
        except _NotARecord as error:
            rows = [(record, compact(record)) for record in _salvaged(raw)]
            if ended or rows:
                faults.append(Fault(number, str(error), raw, error.foreign))
            else:
                torn = number
        for record, line in rows:
            if record["key"] in records:
                why = "is a second record of the same task"
                faults.append(Fault(number, why, line, second=True))
            else:
                records[record["key"]] = record
                kept.append(line)
    return Content(list(records.values()), kept, faults, torn, whole, unended)


def _refuse_foreign(path: Path, content: Content) -> None:
    """Refuse a file without a single record that holds something else: it is somebody's."""
    foreign = next((fault for fault in content.faults if fault.foreign), None)
    if foreign is not None and not content.records:
        raise DataError(
            f"{path.name}: line {foreign.line} {foreign.why}; move the file away to measure anew"
        )


def read_records(path: Path) -> list[dict[str, Any]]:
    """Read the records of a sound file; a torn last line is passed over.

    Raises
    ------
    DataError
        For a line in the middle that is not a record, and for a second record of a task.
    """
    content = scan(path)
    _refuse_foreign(path, content)
    for fault in content.faults:
        raise DataError(f"{path.name}: line {fault.line} {fault.why}; delete that line")
    return content.records


# --- writing --------------------------------------------------------------------------------------


class RecordFile:
    """Append records to a file; know which tasks it already holds.

    Reading changes nothing. Writing happens under a lock, which a run holds from its first task to
    its last; what is damaged is repaired when the lock is taken.

    Parameters
    ----------
    path : Path or None
        The file, created with its folder when something is written. ``None`` keeps records in
        memory only.

    Attributes
    ----------
    records : list of dict
        The records, in the order of the file.
    notices : list of str
        Sentences on what was damaged.
    faulty : bool
        Whether the file has lines that are no records.

    Raises
    ------
    DataError
        For a file that holds something else than records.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.records: list[dict[str, Any]] = []
        self.notices: list[str] = []
        self.faulty = False
        self._by_key: dict[str, dict[str, Any]] = {}
        self._holds = 0
        self._size = 0  # bytes of the file, as long as the lock is held
        if path is not None:
            self._take(self._read(path))

    @staticmethod
    def _read(path: Path) -> Content:
        content = scan(path)
        _refuse_foreign(path, content)
        return content

    def _take(self, content: Content) -> None:
        self.records = content.records
        self._by_key = {record["key"]: record for record in self.records}
        self.faulty = bool(content.faults) or content.torn is not None

    def find(self, task: Mapping[str, Any]) -> dict[str, Any] | None:
        """Return the record of a task, if it is there."""
        return self._by_key.get(key_of(task))

    def missing(self, tasks: Iterable[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
        """Tasks without a record, in order."""
        return (task for task in tasks if self.find(task) is None)

    @contextlib.contextmanager
    def exclusive(self) -> Iterator[None]:
        """Hold the file's lock: read it anew, repair what is damaged, and be the only writer.

        Raises
        ------
        UsageError
            Where another process holds the lock, and where the folder cannot be written.
        """
        if self.path is None or self._holds:
            self._holds += 1
            try:
                yield
            finally:
                self._holds -= 1
            return
        make_folder(self.path.parent)
        target = Path(os.path.realpath(self.path))  # one lock for a file, whatever leads to it
        lock = Lock(
            target.with_name(f".{target.name}.lock"),
            f"the record file {printable(self.path)}",
        )
        try:
            lock.acquire()
        except OSError as error:
            raise UsageError(
                f"the output folder {printable(self.path.parent)} cannot be written "
                f"({reason(error)}); name another --output"
            ) from None
        try:
            self._holds = 1
            self._repair(self.path)
            yield
        finally:
            self._holds = 0
            lock.release()

    def _repair(self, path: Path) -> None:
        """Move what is no record to a file beside this one, and end the last line."""
        content = self._read(path)
        self._take(content)
        if content.torn is not None:
            self.notices.append(
                f"{path.name}: line {content.torn} was not written to its end; its task is "
                f"measured again"
            )
        try:
            if content.faults:
                aside = path.with_name(f"{path.name}.aside")
                _append(aside, b"".join(fault.raw + b"\n" for fault in content.faults))
                replace_file(path, b"".join(line + b"\n" for line in content.kept))
                self.notices += _told(path.name, aside.name, content.faults)
            elif content.torn is not None:
                os.truncate(path, content.whole)
            elif content.unended:
                _append(path, b"\n")
            self._size = path.stat().st_size if path.exists() else 0
        except OSError as error:
            raise self._refusal(path, error) from None
        self.faulty = False

    def _refusal(self, path: Path, error: OSError) -> UsageError:
        what = "the record of a task" if self._holds else "a repaired record file"
        return UsageError(
            f"{printable(path)}: {what} cannot be written ({reason(error)}); the "
            f"{len(self.records)} records before it are kept, so make room and run the same "
            f"command again"
        )

    def append(self, task: Mapping[str, Any], measured: Mapping[str, Any]) -> dict[str, Any]:
        """Add one record; see :meth:`append_all`."""
        return self.append_all([(task, measured)])[0]

    def append_all(
        self, results: Iterable[tuple[Mapping[str, Any], Mapping[str, Any]]]
    ) -> list[dict[str, Any]]:
        """Add records and make sure that they are on the disk before returning them.

        Raises
        ------
        ValueError
            For NaN or an infinity, which JSON lacks; nothing is written then.
        UsageError
            Where the system refuses to write; the file then ends with the record before.
        """
        records = [self.made(task, measured) for task, measured in results]
        if records:
            with self.exclusive():
                if self.path is not None:
                    self._write(self.path, b"".join(compact(x) + b"\n" for x in records))
                for record in records:
                    self.remember(record)
        return records

    @staticmethod
    def made(task: Mapping[str, Any], measured: Mapping[str, Any]) -> dict[str, Any]:
        """Return the record of a task, with its checksum.

        Raises
        ------
        ValueError
            For NaN or an infinity.
        """
        record = {"format": FORMAT, "key": key_of(task), "task": dict(task), **measured}
        # what is read back: tuples are lists and keys are texts there, and the sum is over that
        record = json.loads(json.dumps(record, allow_nan=False))
        return {**record, CHECKSUM: checksum(record)}

    def remember(self, record: dict[str, Any]) -> None:
        """Have a record in memory alone."""
        if record["key"] not in self._by_key:
            self.records.append(record)
        self._by_key[record["key"]] = record

    def _write(self, path: Path, lines: bytes) -> None:
        try:
            if (path.stat().st_size if path.exists() else 0) != self._size:
                raise UsageError(
                    f"{printable(path)}: another program has changed, moved or deleted the file "
                    f"while this one was writing it; run the same command again"
                )
            self._size = _append(path, lines)
        except OSError as error:
            raise self._refusal(path, error) from None


def _append(path: Path, content: bytes) -> int:
    """Append to a file on the disk, or leave it as it was; return its size.

    Raises
    ------
    OSError
        Where the system refuses.
    """
    new = not path.exists()
    # without O_NONBLOCK, opening a named pipe waits for a reader
    flags = os.O_WRONLY | os.O_APPEND | os.O_CREAT | BINARY | getattr(os, "O_NONBLOCK", 0)
    descriptor = os.open(path, flags, 0o666)
    try:
        size = os.fstat(descriptor).st_size
        try:
            rest = memoryview(content)
            while rest:
                rest = rest[os.write(descriptor, rest) :]
            os.fsync(descriptor)
        except OSError:
            # on a full disk part of a line may have been written
            with contextlib.suppress(OSError):
                os.ftruncate(descriptor, size)
            raise
    finally:
        os.close(descriptor)
    if new:
        sync_folder(path.parent)
    return size + len(content)


def _told(name: str, aside: str, faults: list[Fault]) -> list[str]:
    """Sentences on lines that were moved."""
    told: list[str] = []
    twice = [fault for fault in faults if fault.second]
    other = [fault for fault in faults if not fault.second]
    if other:
        more = f", and {len(other) - 1} lines more" if len(other) > 1 else ""
        told.append(
            f"{name}: line {other[0].line} {other[0].why}{more}; moved to {aside}, and what "
            f"cannot be read in them is measured again"
        )
    if twice:
        told.append(
            f"{name}: {len(twice)} of the lines repeat a task, the first at line "
            f"{twice[0].line}; the first record of each task is kept, the others moved to {aside}"
        )
    return told
