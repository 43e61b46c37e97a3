"""Records that survive: one table of SQLite, with a row for each task.

A *task* is a JSON-ready mapping that says what to measure; its key is a hash of its canonical text.
A record is the task with what was measured, and a checksum over both. SQLite brings a record to the
disk before it counts, and undoes what a killed process or a full disk left half written. A record
whose checksum disagrees is measured again; where the file itself is damaged, what can be read of it
is moved to a new one. Only the process that holds the lock writes. The records of earlier versions,
JSON objects one a line, are taken over.
"""

from __future__ import annotations

import contextlib
import hashlib
import json
import math
import os
import re
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ..catalogue.canonical import compact
from ..errors import DataError, UsageError
from ..system.files import (
    make_folder,
    one_name,
    printable,
    read_bytes,
    require_regular,
    write_bytes,
)

Record = dict[str, Any]

FORMAT = "glmref-record-1"
#: The field with the checksum of a record; records of version 0.1.0 and before have none.
CHECKSUM = "sha256"
SUFFIX = ".sqlite"
#: Bytes of a record, and of a file of records in lines.
MAX_RECORD, MAX_BYTES = 1 << 26, 1 << 30
#: Bytes that a record has at least: its format, its key and its checksum.
_LEAST = 150
#: Seconds to wait for a reader that holds the file.
_PATIENCE = 30.0
_TABLE = "CREATE TABLE record (key TEXT PRIMARY KEY, record TEXT NOT NULL)"
_INSERT = "INSERT OR REPLACE INTO record VALUES (?, ?)"
_HEXADECIMAL = re.compile("[0-9a-f]{64}")

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


# --- reading a text -------------------------------------------------------------------------------


def parsed(text: bytes) -> Record:
    """Return the record that a text holds; one of version 0.1.0 has no checksum.

    Raises
    ------
    ValueError
        For anything else; its text is the rest of a sentence that begins with "it".
    """
    try:
        record = json.loads(text.decode("utf-8"))
    except (ValueError, RecursionError):
        raise ValueError("it is not JSON") from None
    if not isinstance(record, dict) or not record:
        raise ValueError("it is not a record")
    last = record[next(reversed(record))]
    # a checksum of which the name is damaged
    summed = CHECKSUM in record or (isinstance(last, str) and _HEXADECIMAL.fullmatch(last))
    if record.get("format") != FORMAT and not summed:
        raise ValueError(
            f"its format is {str(record.get('format'))[:40]!r}, and this version reads {FORMAT!r}"
        )
    try:
        # two texts can be one number, so that the checksum agrees although a digit has changed
        changed = summed and (
            record.get(CHECKSUM) != checksum(record) or compact(record) != text.strip()
        )
    except ValueError:  # NaN, which is never written
        changed = True
    if changed:
        raise ValueError("it is damaged: its checksum does not agree with its content")
    if record.get("format") != FORMAT:
        raise ValueError(
            f"its format is {str(record.get('format'))[:40]!r}, and this version reads {FORMAT!r}"
        )
    if not isinstance(record.get("task"), dict):
        raise ValueError("it does not say what was run")
    return record


def lines_of(path: Path) -> Iterator[tuple[int, Record | None, str]]:
    """Read a file of records one a line.

    Yields
    ------
    tuple of int, dict or None, str
        The number of a line from 1, its record, and why it has none, as the rest of a sentence
        that begins with "it".

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
                whole = line.endswith((b"\n", b"\r"))
                yield (
                    number,
                    None,
                    str(error) if whole else "the run was stopped while it was written",
                )


def earlier(path: Path) -> list[Path]:
    """Return the files in lines that the records of a path were kept in by earlier versions."""
    base = path.with_suffix("")
    found = [base.with_suffix(".jsonl")]
    with contextlib.suppress(OSError, ValueError):
        parts = re.compile(re.escape(base.name) + r"-\d{6}\.jsonl")
        found += sorted(x for x in path.parent.iterdir() if parts.fullmatch(x.name))
    return [x for x in found if os.path.lexists(x)]


# --- the file -------------------------------------------------------------------------------------


class Records:
    """The records of a file, by the content of their tasks.

    Reading changes nothing. Writing happens under a lock, which a run holds from its first task to
    its last.

    Parameters
    ----------
    path : Path or None
        The file, created with its folder when something is written. For ``NAME.jsonl``, where an
        earlier version kept records in lines, it is ``NAME.sqlite``. ``None`` keeps records in
        memory only.

    Attributes
    ----------
    notices : list of str
        Sentences on what was damaged.

    Raises
    ------
    DataError
        For a file that cannot be read, or that holds something else than records.
    """

    def __init__(self, path: Path | None) -> None:
        self.path = path.with_suffix(SUFFIX) if path and path.suffix == ".jsonl" else path
        self.notices: list[str] = []
        self._memory: dict[str, Record] = {}
        self._file: sqlite3.Connection | None = None
        self._held = False
        self._place: tuple[int, int] | None = None  # device and inode while the lock is held
        if self.path is not None and not self._open():
            for lines in earlier(self.path):
                self._take_over(lines)

    def _take_over(self, path: Path) -> None:
        """Have the records of a file in lines in memory, until the table is made."""
        first, faults = "", 0
        for number, record, why in lines_of(path):
            if record is None:
                first, faults = first or f"{path.name}: line {number}: {why}", faults + 1
            else:
                self._memory.setdefault(key_of(record["task"]), record)
        if faults and not self._memory and "stopped" not in first:  # somebody's
            raise DataError(f"{first}; move the file away to measure anew")
        if faults:
            more = f", and {faults - 1} lines more" if faults > 1 else ""
            self._notice(f"{first}{more}; what cannot be read is measured again")

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

    def find(self, task: Mapping[str, Any]) -> Record | None:
        """Return the record of a task, if there is a sound one."""
        key = key_of(task)
        if key in self._memory or (file := self._open()) is None:
            return self._memory.get(key)
        try:
            row = file.execute("SELECT record FROM record WHERE key = ?", (key,)).fetchone()
            return None if row is None else parsed(row[0])
        except (sqlite3.Error, ValueError) as error:
            self._damaged(error)
            return None

    def missing(self, tasks: Iterable[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
        """Yield the tasks without a record, in order."""
        return (task for task in tasks if self.find(task) is None)

    def __iter__(self) -> Iterator[Record]:
        """Yield the sound records in the order in which they were written."""
        yield from list(self._memory.values())
        if (file := self._open()) is not None:
            for record in _rows(file):
                if record is None:
                    self._damaged("")
                elif key_of(record["task"]) not in self._memory:
                    yield record

    def __len__(self) -> int:
        """Return the number of records in the file and in memory."""
        try:
            file = self._open()
            count = "SELECT count(*) FROM record"
            return len(self._memory) + (file.execute(count).fetchone()[0] if file else 0)
        except DAMAGE:
            return sum(1 for _ in self)

    def _damaged(self, why: object) -> None:
        assert self.path is not None
        self._notice(f"{one_name(self.path)} is damaged; what cannot be read is measured again")

    # --- writing

    @contextlib.contextmanager
    def exclusive(self) -> Iterator[None]:
        """Hold the lock, repair what is damaged, and be the only writer.

        Raises
        ------
        UsageError
            Where another process holds the lock, and where the folder cannot be written.
        """
        if self.path is None or self._held:
            yield
            return
        make_folder(self.path.parent)
        with locked(Path(os.path.realpath(self.path))):  # one lock, whatever link leads to it
            self.close()
            self._held = True
            try:
                self._begin(self.path)
                yield
            finally:
                self._held = False
                with contextlib.suppress(sqlite3.Error):  # a file at rest has no other beside it
                    if self._file is not None:
                        self._file.execute("PRAGMA user_version = 0")
                        self._file.execute("PRAGMA journal_mode = DELETE")
                self.close()

    def _begin(self, path: Path) -> None:
        """Open the file for writing, a repaired one where it is damaged."""
        try:
            self._file = file = _connected(path, "rwc")
            try:
                sound = file.execute("PRAGMA integrity_check(1)").fetchone() == (b"ok",)
            except DAMAGE:
                sound = False
            if not sound:
                self._damaged("")
                _rewrite(path, file)
                self._file = file = _connected(path, "rwc")
            file.execute("PRAGMA journal_mode = WAL")
            file.execute("PRAGMA synchronous = FULL")
            file.execute(_TABLE.replace("TABLE", "TABLE IF NOT EXISTS"))
            file.execute(f"PRAGMA user_version = {os.getpid()}")
            _insert(file, self._memory.values())
        except (sqlite3.Error, OSError) as error:
            raise self._refusal(error) from None
        self._memory.clear()
        self._place = _place(path)

    def _refusal(self, error: object) -> UsageError:
        kept = "records"
        with contextlib.suppress(sqlite3.Error, DataError):
            kept = f"{len(self)} records"
        return UsageError(
            f"{printable(self.path or '')}: the record of a task cannot be written ({error}); the "
            f"{kept} before it are kept, so make room and run the same command again"
        )

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
                if _place(self.path) != self._place:
                    raise UsageError(
                        f"{printable(self.path)}: another program has moved or deleted the file "
                        f"while this one was writing it; run the same command again"
                    )
                assert self._file is not None
                try:
                    _insert(self._file, records)
                except sqlite3.Error as error:
                    raise self._refusal(error) from None
        return records

    def remember(self, *records: Record) -> None:
        """Have records in memory only."""
        self._memory |= {key_of(record["task"]): record for record in records}


def _connected(path: Path, mode: str) -> sqlite3.Connection:
    """Open a file of records, or an empty one.

    Parameters
    ----------
    path : Path
        The file.
    mode : str
        ``"ro"``, or ``"rwc"`` to write it.

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
        file.text_factory = bytes
        file.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MAX_RECORD)
    except (sqlite3.Error, OSError, ValueError) as error:
        raise DataError(f"{name}: the file cannot be read ({error})") from None
    try:
        # nothing but this table: a view or a trigger of somebody would be run
        schema = file.execute("SELECT sql FROM sqlite_schema WHERE sql IS NOT NULL").fetchall()
    except DAMAGE as error:
        file.close()
        name_of_error = getattr(error, "sqlite_errorname", "SQLITE_CORRUPT")
        if name_of_error in ("SQLITE_NOTADB", "SQLITE_CORRUPT"):
            raise _foreign(name, error) from None
        raise DataError(f"{name}: the file cannot be read ({error})") from None
    if schema not in ([(_TABLE.encode(),)], []):
        file.close()
        raise _foreign(name, "it has other tables")
    return file


def _foreign(name: str, why: object) -> DataError:
    return DataError(f"{name} is not a file of records ({why}); move it away to measure anew")


def _insert(file: sqlite3.Connection, records: Iterable[Record]) -> None:
    """Write records in one transaction."""
    rows = [
        (key_of(x["task"]), compact(x if CHECKSUM in x else {**x, CHECKSUM: checksum(x)}).decode())
        for x in records
    ]
    with file:
        file.executemany(_INSERT, rows)


def _rows(file: sqlite3.Connection) -> Iterator[Record | None]:
    """Yield the records in order, ``None`` for what is damaged."""
    pages, size = (file.execute(f"PRAGMA {x}").fetchone()[0] for x in ("page_count", "page_size"))
    most = pages * size // _LEAST
    try:
        most = min(most, file.execute("SELECT max(rowid) FROM record").fetchone()[0] or 0)
    except DAMAGE:
        yield None
    for number in range(1, most + 1):  # one by one: a scan ends at the first damaged page
        try:
            row = file.execute("SELECT record FROM record WHERE rowid = ?", (number,)).fetchone()
            if row is not None:
                yield parsed(row[0])
        except (sqlite3.DatabaseError, ValueError):
            yield None


def _rewrite(path: Path, file: sqlite3.Connection) -> None:
    """Move what can be read of a damaged file to a new one; the old one stays beside it."""
    records = [x for x in _rows(file) if x is not None]
    file.close()
    new = path.with_name(f".{path.name}.new")
    new.unlink(missing_ok=True)
    fresh = sqlite3.connect(new)
    try:
        fresh.execute(_TABLE)
        _insert(fresh, records)
    finally:
        fresh.close()
    write_bytes(path.with_name(f"{path.name}.damaged"), path.read_bytes())
    for end in ("-wal", "-shm"):
        path.with_name(path.name + end).unlink(missing_ok=True)
    os.replace(new, path)


def _place(path: Path) -> tuple[int, int] | None:
    """Return device and inode of a file, ``None`` where there is none."""
    try:
        about = os.stat(path)
    except OSError:
        return None
    return about.st_dev, about.st_ino


@contextlib.contextmanager
def locked(path: Path) -> Iterator[None]:
    """Hold the lock of a record file, which the system ends with the process.

    Raises
    ------
    UsageError
        Where another process holds it, or the folder cannot be written.
    """
    place = path.with_name(f".{path.name}.lock")
    lock, before = None, None
    # the one who held it may have deleted the file between two of these calls
    while lock is None or before is None or _place(place) != before:
        if lock is not None:
            lock.close()
            lock = None
        try:
            with contextlib.suppress(FileExistsError):
                place.touch(exist_ok=False)
            before = _place(place)
            require_regular(place, os.lstat(place).st_mode)  # what a link leads to is not ours
            lock = _begun(place)
        except (DataError, OSError, sqlite3.Error) as error:
            if getattr(error, "sqlite_errorname", "") == "SQLITE_BUSY":
                raise UsageError(
                    f"the record file {printable(path)} is in use by {_holder(path)}; wait until "
                    f"it has ended, or name another --output"
                ) from None
            if isinstance(error, FileNotFoundError) or _place(place) != before:
                continue
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


def _begun(place: Path) -> sqlite3.Connection:
    """Return a connection that holds its file, or fail with nothing left open."""
    lock = sqlite3.connect(place, timeout=0.0)
    try:
        lock.execute("BEGIN EXCLUSIVE")
    except sqlite3.Error:
        lock.close()
        raise
    return lock


def _holder(path: Path) -> str:
    """Return which process writes a file; it is noted in its head."""
    with contextlib.suppress(sqlite3.Error, DataError), contextlib.closing(
        _connected(path, "ro")
    ) as file:  # fmt: skip
        number = file.execute("PRAGMA user_version").fetchone()[0]
        if number:
            return f"process {number}"
    return "another process"
