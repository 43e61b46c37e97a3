"""Records that survive: one table of SQLite, with a row for each task.

A *task* is a JSON-ready mapping that says what to measure; its key is a hash of its canonical text.
A record is the task with what was measured, and a checksum over both. SQLite brings a record to the
disk before it counts, and undoes what a killed process or a full disk left half written. A record
whose checksum disagrees is measured again. Only the process that holds the lock writes. Records
that are JSON objects one a line, as ``--format jsonl`` prints them, are read as well.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

from ..catalogue.canonical import compact
from ..errors import DataError, UsageError
from ..system.files import make_folder, one_name, printable, read_bytes, require_regular

Record = dict[str, Any]

FORMAT = "glmref-record-1"
#: The field with the checksum of a record; a record in a line may lack it.
CHECKSUM = "sha256"
SUFFIX = ".sqlite"
#: Bytes of a record, and of a file of records in lines.
MAX_RECORD, MAX_BYTES = 1 << 26, 1 << 30
#: Seconds to wait for a reader that holds the file.
_PATIENCE = 30.0
_TABLE = "CREATE TABLE record (key TEXT PRIMARY KEY, record TEXT NOT NULL)"
#: What a damaged file raises: a message of SQLite may hold bytes of the file that are no text.
DAMAGE = (sqlite3.DatabaseError, UnicodeDecodeError)


def key_of(task: Mapping[str, Any]) -> str:
    """Return sixteen hexadecimal digits that depend only on the content of the task."""
    return hashlib.sha256(compact(task, sort_keys=True)).hexdigest()[:16]


def checksum(record: Mapping[str, Any]) -> str:
    """Return the SHA-256 of a record's canonical text without its checksum, in hexadecimal."""
    return hashlib.sha256(
        compact({k: x for k, x in record.items() if k != CHECKSUM}, sort_keys=True)
    ).hexdigest()


def finite(value: float | None) -> float | None:
    """Return a float that JSON can carry: ``None`` for NaN and infinities."""
    return None if value is None or not math.isfinite(value) else float(value)


def in_json(value: Any, number: Callable[[float], float | None] = finite) -> Any:
    """Return a dataclass, a mapping or a list in JSON's types, floats as ``number`` says."""
    if is_dataclass(value):
        return {field.name: in_json(getattr(value, field.name), number) for field in fields(value)}
    if isinstance(value, Mapping):
        return {key: in_json(x, number) for key, x in value.items()}
    if isinstance(value, tuple | list):
        return [in_json(x, number) for x in value]
    return number(value) if isinstance(value, float) else value


def made(task: Mapping[str, Any], measured: Mapping[str, Any]) -> Record:
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


def parsed(text: bytes) -> Record:
    """Return the record that a text holds.

    Raises
    ------
    ValueError
        For anything else; its text is the rest of a sentence that begins with "it".
    """
    try:
        record = json.loads(text.decode("utf-8"))
    except (ValueError, RecursionError, AttributeError):  # in a damaged table also what is no text
        raise ValueError("it is not JSON") from None
    if not isinstance(record, dict) or not record:
        raise ValueError("it is not a record")
    try:
        # two texts can be one number, so that the checksum agrees although a digit has changed
        damaged = CHECKSUM in record and (
            record[CHECKSUM] != checksum(record) or compact(record) != text.strip()
        )
    except ValueError:  # NaN, which is never written
        damaged = True
    if damaged:
        raise ValueError("it is damaged: its checksum does not agree with its content")
    if record.get("format") != FORMAT:
        raise ValueError(
            f"its format is {str(record.get('format'))[:40]!r}, and this version reads {FORMAT!r}"
        )
    if not isinstance(record.get("task"), dict):
        raise ValueError("it does not say what was run")
    return record


def lines_of(path: Path) -> Iterator[tuple[int, Record | None, str]]:
    """Read records one a line: its number from 1, the record, and why there is none.

    The reason is the rest of a sentence that begins with "it".

    Raises
    ------
    DataError
        For a file that cannot be read.
    """
    for number, line in enumerate(read_bytes(path, MAX_BYTES).splitlines(keepends=True), start=1):
        if line.strip():
            try:
                yield number, parsed(line), ""
            except ValueError as error:
                torn = not line.endswith((b"\n", b"\r"))
                why = "the run was stopped while it was written" if torn else str(error)
                yield number, None, why


class Records:
    """The records of a file, by the content of their tasks.

    Reading changes nothing. Writing happens under a lock, which a run holds from its first task to
    its last. The file is created with its folder when something is written. Where it is missing,
    sound records of ``NAME.jsonl`` are taken over; without a path records are in memory only.
    ``notices`` are sentences on what was damaged.

    Raises
    ------
    DataError
        For a file that cannot be read, or that holds something else than records.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path
        self.notices: list[str] = []
        self._memory: dict[str, Record] = {}
        self._file: sqlite3.Connection | None = None
        self._held = False
        if path is not None and not self._open() and os.path.lexists(path.with_suffix(".jsonl")):
            self._take_over(path.with_suffix(".jsonl"))

    def _take_over(self, path: Path) -> None:
        """Have the records of a file in lines in memory, until the table is made."""
        faults = []
        for number, record, why in lines_of(path):
            if record is None:
                faults.append(f"{one_name(path)}: line {number}: {why}")
            else:
                self._memory.setdefault(key_of(record["task"]), record)
        if faults and not self._memory:
            raise DataError(f"{faults[0]}; move the file away to measure again")
        if faults:
            more = f", and {len(faults) - 1} lines more" if faults[1:] else ""
            self._notice(f"{faults[0]}{more}; what cannot be read is measured again")

    def _notice(self, text: str) -> None:
        if text not in self.notices:
            self.notices.append(text)

    # --- reading

    def _open(self) -> sqlite3.Connection | None:
        """Return a connection that reads, or ``None`` where there is no table yet."""
        if self._file is None and self.path is not None and os.path.lexists(self.path):
            file = _connected(self.path, "ro")
            if file.execute("SELECT count(*) FROM sqlite_schema").fetchone() == (0,):
                file.close()  # its writer was stopped before it made the table
            else:
                self._file = file
        return self._file

    def close(self) -> None:
        """Close the file; it is opened again where it is needed."""
        if self._file is not None:
            self._file.close()
            self._file = None

    def __del__(self) -> None:
        self.close()

    def _rows(self, question: str, *values: str) -> Iterator[tuple[Any, ...]]:
        file = self._open()
        try:
            yield from file.execute(question, values) if file is not None else ()
        except DAMAGE as error:
            raise self._damaged(error) from None

    def _damaged(self, why: object) -> DataError:
        return DataError(
            f"{one_name(self.path or Path())} is damaged ({why}); save what can be read with "
            f"`.recover` of the program sqlite3, or move it away to measure again"
        )

    def _sound(self, text: bytes) -> Record | None:
        """Return the record in a row, ``None`` where it is damaged."""
        with contextlib.suppress(ValueError):
            if CHECKSUM in (record := parsed(text)):
                return record
        self._notice(f"{one_name(self.path or Path())}: a record is damaged and is measured again")
        return None

    def find(self, task: Mapping[str, Any]) -> Record | None:
        """Return the record of a task, if there is a sound one."""
        key = key_of(task)
        if key in self._memory:
            return self._memory[key]
        rows = self._rows("SELECT record FROM record WHERE key = ?", key)
        return next((self._sound(text) for (text,) in rows), None)

    def missing(self, tasks: Iterable[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
        """Yield the tasks without a record, in order."""
        return (task for task in tasks if self.find(task) is None)

    def __iter__(self) -> Iterator[Record]:
        """Yield the sound records in the order in which they were written."""
        yield from list(self._memory.values())
        for (text,) in self._rows("SELECT record FROM record ORDER BY rowid"):
            if (record := self._sound(text)) and key_of(record["task"]) not in self._memory:
                yield record

    def __len__(self) -> int:
        """Return the number of records in the file and in memory."""
        return len(self._memory) + sum(n for (n,) in self._rows("SELECT count(*) FROM record"))

    # --- writing

    @contextlib.contextmanager
    def exclusive(self) -> Iterator[None]:
        """Hold the lock, and be the only writer.

        Raises
        ------
        UsageError
            Where another process holds the lock, and where the folder cannot be written.
        DataError
            For a file that is damaged.
        """
        if self.path is None or self._held:
            yield
            return
        make_folder(self.path.parent)
        with locked(Path(os.path.realpath(self.path))):  # one lock, whatever link leads to it
            self.close()
            self._file = file = _connected(self.path, "rwc")
            self._held = True
            try:
                self._begin(file)
                yield
            finally:
                self._held = False
                with contextlib.suppress(sqlite3.Error):  # a file at rest has no other beside it
                    file.execute("PRAGMA journal_mode = DELETE")
                self.close()

    def _begin(self, file: sqlite3.Connection) -> None:
        try:
            (found,) = file.execute("PRAGMA integrity_check(1)").fetchone()
        except DAMAGE as error:
            raise self._damaged(error) from None
        if found != b"ok":
            raise self._damaged(printable(found.decode("utf-8", "replace")))
        try:
            file.execute("PRAGMA journal_mode = WAL")
            file.execute("PRAGMA synchronous = FULL")
            file.execute(_TABLE.replace("TABLE", "TABLE IF NOT EXISTS"))
        except sqlite3.Error as error:
            raise self._refusal(error) from None
        self._insert(self._memory.values())
        self._memory.clear()

    def _refusal(self, error: object) -> UsageError:
        kept = "records"
        with contextlib.suppress(sqlite3.Error, DataError):
            kept = f"{len(self)} records"
        return UsageError(
            f"{printable(self.path or '')}: the record of a task cannot be written ({error}); the "
            f"{kept} before it are kept, so make room and run the same command again"
        )

    def _insert(self, records: Iterable[Record]) -> None:
        """Write records in one transaction."""
        assert self._file is not None and self.path is not None
        if not self.path.exists():
            raise UsageError(
                f"{printable(self.path)}: another program has moved or deleted the file while this "
                f"one was writing it; run the same command again"
            )
        rows = [
            (key_of(x["task"]), compact({**x, CHECKSUM: checksum(x)}).decode()) for x in records
        ]
        try:
            with self._file as file:
                file.executemany("INSERT OR REPLACE INTO record VALUES (?, ?)", rows)
        except sqlite3.Error as error:
            raise self._refusal(error) from None

    def append(self, task: Mapping[str, Any], measured: Mapping[str, Any]) -> Record:
        """Add one record; see :meth:`append_all`."""
        return self.append_all([(task, measured)])[0]

    def append_all(
        self, results: Iterable[tuple[Mapping[str, Any], Mapping[str, Any]]]
    ) -> list[Record]:
        """Add records, all or none, and bring them to the disk before returning them.

        Raises
        ------
        ValueError
            For NaN or an infinity, which JSON lacks; nothing is written then.
        UsageError
            Where the system refuses to write; the records before are kept.
        """
        records = [made(task, measured) for task, measured in results]
        if self.path is None:
            self.remember(*records)
        elif records:
            with self.exclusive():
                self._insert(records)
        return records

    def remember(self, *records: Record) -> None:
        """Have records in memory only."""
        self._memory |= {key_of(record["task"]): record for record in records}


def _connected(path: Path, mode: str) -> sqlite3.Connection:
    """Open a file of records, or an empty one, to read (``"ro"``) or to write it (``"rwc"``).

    Raises
    ------
    DataError
        For a file that is not regular, cannot be read, or holds something else.
    """
    name = one_name(path)
    try:
        if os.path.lexists(path):
            require_regular(path, os.stat(path).st_mode)
        uri = f"{path.absolute().as_uri()}?mode={mode}"
        file = sqlite3.connect(uri, timeout=_PATIENCE, uri=True, check_same_thread=False)
    except (sqlite3.Error, OSError, ValueError) as error:
        raise DataError(f"{name}: the file cannot be read ({error})") from None
    file.text_factory = bytes
    file.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_RECORD)
    try:
        # nothing but this table: a view or a trigger of somebody would be run
        schema = file.execute("SELECT sql FROM sqlite_schema WHERE sql IS NOT NULL").fetchall()
        if schema in ([(_TABLE.encode(),)], []):
            return file
        why: object = "it has other tables"
    except DAMAGE as error:
        why = error
    file.close()
    if mode == "ro" and getattr(why, "sqlite_errorname", "").startswith("SQLITE_READONLY"):
        return _connected(path, "rw")  # what a killed process had begun is taken back first
    if getattr(why, "sqlite_errorname", "SQLITE_NOTADB") in ("SQLITE_NOTADB", "SQLITE_CORRUPT"):
        raise DataError(f"{name} is not a file of records ({why}); move it away to measure again")
    raise DataError(f"{name}: the file cannot be read ({why})")


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of a record file, which the system ends with the process.

    It keeps two runs from measuring the same; that they do not damage the file is SQLite's to see
    to. So it does no harm that a lock can be taken twice in the moment in which it is given back.

    Raises
    ------
    UsageError
        Where another process holds it, or the folder cannot be written.
    """
    place = path.with_name(f".{path.name}.lock")
    try:
        if os.path.lexists(place):
            require_regular(place, os.lstat(place).st_mode)  # what a link leads to is not ours
        lock = sqlite3.connect(place, timeout=0.0)
        with contextlib.ExitStack() as opened:
            opened.callback(lock.close)
            lock.execute("BEGIN EXCLUSIVE")
            opened.pop_all()
    except (DataError, OSError, sqlite3.Error) as error:
        if getattr(error, "sqlite_errorname", "") == "SQLITE_BUSY":
            raise UsageError(
                f"the record file {printable(path)} is in use by another process; wait until it "
                f"has ended, or name another --output"
            ) from None
        raise UsageError(
            f"the output folder {printable(path.parent)} cannot be written ({error}); name "
            f"another --output"
        ) from None
    try:
        yield
    finally:
        with contextlib.suppress(OSError):  # Windows deletes no file that is open
            place.unlink()
        lock.close()
