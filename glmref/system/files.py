"""Files under faults: bounded reading, writing in one piece, and a lock that says who holds it.

What the system refuses (a full disk, a quota, a read-only folder, a folder where a file must be)
becomes a sentence that names the path and the reason. A file that is written whole is replaced in
one piece, so that a process killed at any instant leaves the old content or the new, never a part.
"""

from __future__ import annotations

import contextlib
import errno
import hashlib
import json
import os
import socket
import stat
from collections.abc import Iterator
from contextvars import ContextVar
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from ..errors import DataError, UsageError
from .arguments import shown

try:
    import fcntl
except ImportError:  # not POSIX: the lock is a file that is made exclusively
    fcntl = None  # type: ignore[assignment]

#: Windows changes ends of lines in files that are opened without it.
BINARY = getattr(os, "O_BINARY", 0)
#: What `flock` answers on a file system that has no locks.
_NO_LOCKS = {errno.ENOSYS, errno.ENOLCK, errno.EOPNOTSUPP, errno.ENOTSUP, errno.EINVAL}


def reason(error: OSError | ValueError) -> str:
    """Return why the system refused, in its words."""
    return getattr(error, "strerror", None) or shown(error, str, 200)


def printable(path: str | Path) -> str:
    """Return a path as a quoted text without control characters, for a message."""
    return shown(str(path), most=300)


def kind_of(mode: int) -> str:
    """Return what a file is that is not a regular one, from its mode."""
    kinds = {
        stat.S_IFDIR: "a folder",
        stat.S_IFIFO: "a named pipe",
        stat.S_IFCHR: "a device",
        stat.S_IFBLK: "a device",
        stat.S_IFSOCK: "a socket",
    }
    return kinds.get(stat.S_IFMT(mode), "not a regular file")


#: Checksums of the files read inside :func:`noting`, by path.
_noted: ContextVar[dict[str, str] | None] = ContextVar("noted", default=None)


@contextlib.contextmanager
def noting() -> Iterator[dict[str, str]]:
    """Note which files are read inside: path -> sha256 of the bytes that were read."""
    found: dict[str, str] = {}
    token = _noted.set(found)
    try:
        yield found
    finally:
        _noted.reset(token)


# --- reading --------------------------------------------------------------------------------------


def read_bytes(path: Path, most: int) -> bytes:
    """Read a regular file of bounded size.

    Parameters
    ----------
    path : Path
        The file. A named pipe or a device is refused at once, so that reading never hangs.
    most : int
        Largest number of bytes that is read.

    Raises
    ------
    DataError
        For a file that is missing, not regular, larger than `most`, or cannot be read.
    """
    name = one_name(path)
    try:
        # without O_NONBLOCK, opening a named pipe waits for a writer
        descriptor = os.open(path, os.O_RDONLY | BINARY | getattr(os, "O_NONBLOCK", 0))
    except (OSError, ValueError) as error:
        raise DataError(f"{name}: the file cannot be read ({reason(error)})") from None
    try:
        about = os.fstat(descriptor)
        if not stat.S_ISREG(about.st_mode):
            raise DataError(f"{name}: it is {kind_of(about.st_mode)}, and a regular file is needed")
        if about.st_size > most:
            raise DataError(
                f"{name}: the file has {about.st_size} bytes and at most {most} are read; "
                f"shorten it"
            )
        parts: list[bytes] = []
        size = 0
        while chunk := os.read(descriptor, 1 << 20):
            size += len(chunk)
            if size > most:
                raise DataError(f"{name}: the file is larger than {most} bytes; shorten it")
            parts.append(chunk)
    except OSError as error:
        raise DataError(f"{name}: the file cannot be read ({reason(error)})") from None
    finally:
        os.close(descriptor)
    content = b"".join(parts)
    noted = _noted.get()
    if noted is not None:
        noted[str(path)] = hashlib.sha256(content).hexdigest()
    return content


def read_text(path: Path, most: int) -> str:
    """Read a regular UTF-8 file of bounded size; see :func:`read_bytes`.

    Raises
    ------
    DataError
        As for :func:`read_bytes`, and for bytes that are not UTF-8.
    """
    content = read_bytes(path, most)
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        raise DataError(
            f"{one_name(path)}: byte {error.start} is not UTF-8; save the file as UTF-8"
        ) from None


def one_name(path: Path) -> str:
    """Return the last part of a path, without characters that a terminal obeys."""
    return shown(path.name, lambda name: repr(name)[1:-1], 300) or printable(path)


def named_in(folder: Path, name: object, key: str, what: str = "the file that names it") -> Path:
    """Return the file that a document names: one of the document's folder or below it.

    The only rule for which files a scene, a problem, a campaign or a checkout can make glmref open
    or execute. Links are followed first, so that one that leads out of the folder is refused.

    Parameters
    ----------
    folder : Path
        Where the document lies.
    name : object
        What the document says; its path is relative to `folder`.
    key : str
        The entry of the document, for the sentence.
    what : str
        The document, for the sentence.

    Raises
    ------
    UsageError
        For a path that is absolute, leads out of the folder, or cannot be followed.
    """
    try:
        path = Path(str(name))
        found = (folder / path).resolve()
        inside = not path.is_absolute() and found.is_relative_to(folder.resolve())
    except (OSError, ValueError, RuntimeError):  # a loop of links, a zero byte
        inside = False
    if not inside:
        raise UsageError(
            f"`{key}` must lie in the folder of {what} or below it, got {shown(name)}; move the "
            f"file there"
        )
    return found


# --- writing --------------------------------------------------------------------------------------


def make_folder(path: Path) -> Path:
    """Make a folder with its parents, where it is missing.

    Raises
    ------
    UsageError
        Where it cannot be made: the sentence names the part of the path that is in the way.
    """
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (OSError, ValueError) as error:
        for part in (path, *path.parents):
            with contextlib.suppress(OSError, ValueError):
                mode = part.stat().st_mode
                if not stat.S_ISDIR(mode):
                    kind = "a file" if stat.S_ISREG(mode) else kind_of(mode)
                    raise UsageError(
                        f"the output folder {printable(path)} cannot be made: {printable(part)} is "
                        f"{kind}; name another folder"
                    ) from None
                break
        raise UsageError(
            f"the output folder {printable(path)} cannot be made ({reason(error)}); name another "
            f"folder"
        ) from None
    return path


def write_text(path: Path, text: str, *, sync: bool = True) -> None:
    """Write a text as UTF-8, in one piece; see :func:`write_bytes`.

    Half a surrogate pair, which JSON can carry and UTF-8 cannot, is written as its escape.
    """
    write_bytes(path, text.encode("utf-8", "backslashreplace"), sync=sync)


def write_bytes(path: Path, content: bytes, *, sync: bool = True) -> None:
    """Write a file in one piece: beside it first, then moved over it.

    Parameters
    ----------
    path : Path
        The file; its folder must exist. What is no regular file is not replaced.
    content : bytes
        The whole content.
    sync : bool
        Whether it is on the disk on return. Without, a file that can be made again costs less.

    Raises
    ------
    UsageError
        Where the system refuses; the file then has its old content, or is still missing.
    """
    try:
        target = path.resolve()  # a link stays a link
        mode = target.stat().st_mode if target.exists() else None
    except (OSError, ValueError, RuntimeError) as error:
        raise UsageError(f"{printable(path)} cannot be written ({shown(error, str)})") from None
    if mode is not None and not stat.S_ISREG(mode):
        raise UsageError(f"{printable(path)} is {kind_of(mode)}; name a regular file to write")
    if not target.parent.is_dir():
        raise UsageError(
            f"{printable(path)} cannot be written: there is no folder {printable(target.parent)}; "
            f"make it, or name another place"
        )
    aside = target.with_name(f".{target.name[:100]}.{os.getpid()}.tmp")
    try:
        with aside.open("wb") as stream:
            stream.write(content)
            stream.flush()
            if sync:
                os.fsync(stream.fileno())
            if mode is not None:
                os.chmod(aside, stat.S_IMODE(mode))
        os.replace(aside, target)
        if sync:
            sync_folder(target.parent)
    except OSError as error:
        raise UsageError(
            f"{printable(path)} cannot be written ({reason(error)}); make room there, or name "
            f"another place"
        ) from None
    finally:
        with contextlib.suppress(OSError):
            aside.unlink()  # gone already where it was moved


def sync_folder(folder: Path) -> None:
    """Bring the names in a folder to the disk, where the system can."""
    with contextlib.suppress(OSError):
        descriptor = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)


# --- lock -----------------------------------------------------------------------------------------


class Lock:
    """A lock between processes, as a file that says who holds it.

    The lock itself is the system's (``flock``): it ends with the process that holds it, however
    that ends, so that neither a crash nor a process number that is used again can leave it behind.
    The file's content (host, process, when that process began, since when) serves the sentence for
    those who come second. Where the system has no such locks the file itself is the lock, made
    exclusively; then one left by a crash has to be deleted, and the sentence says so.

    Parameters
    ----------
    path : Path
        The lock's file; it is deleted when the lock is given back.
    what : str
        What is locked, for the sentence.
    """

    def __init__(self, path: Path, what: str) -> None:
        self.path, self.what = path, what
        self._descriptor: int | None = None

    def acquire(self) -> None:
        """Take the lock, or say who has it.

        Raises
        ------
        UsageError
            Where another process holds it.
        OSError
            Where the file cannot be made, as in a folder that is read-only.
        """
        for _ in range(100):
            # what a link of that name leads to is not ours to write
            flags = os.O_RDWR | os.O_CREAT | getattr(os, "O_NOFOLLOW", 0)
            descriptor = os.open(self.path, flags, 0o644)
            try:
                able = self._flock(descriptor)
                # the one who held it may have deleted the file between our two calls
                if able and self._is_current(descriptor):
                    self._sign(descriptor)
                    self._descriptor, descriptor = descriptor, -1
                    return
            finally:
                if descriptor >= 0:
                    os.close(descriptor)
            if not able:
                self._acquire_without_flock()
                return
        raise UsageError(self._held())

    def _flock(self, descriptor: int) -> bool:
        """Ask the system for the lock; ``False`` where it has none to give."""
        if fcntl is None:
            return False
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
                raise UsageError(self._held()) from None
            if error.errno in _NO_LOCKS:
                return False
            raise
        return True

    def _acquire_without_flock(self) -> None:
        """Make a second file exclusively: the first may be what another one has just made."""
        with contextlib.suppress(OSError):
            self.path.unlink()
        self.path = self.path.with_name(f"{self.path.name}ed")
        try:
            descriptor = os.open(self.path, os.O_RDWR | os.O_CREAT | os.O_EXCL, 0o644)
        except FileExistsError:
            raise UsageError(
                f"{self._held()}; if that process is gone, delete {printable(self.path)}"
            ) from None
        self._sign(descriptor)
        self._descriptor = descriptor

    def _is_current(self, descriptor: int) -> bool:
        try:
            now = os.stat(self.path)
        except FileNotFoundError:
            return False
        mine = os.fstat(descriptor)
        return (now.st_dev, now.st_ino) == (mine.st_dev, mine.st_ino)

    def _sign(self, descriptor: int) -> None:
        """Write who holds the lock; on a full disk it is held all the same."""
        owner = {
            "host": socket.gethostname(),
            "pid": os.getpid(),
            "started": started(os.getpid()),
            "since": datetime.now(UTC).isoformat(timespec="seconds"),
        }
        with contextlib.suppress(OSError):
            os.ftruncate(descriptor, 0)
            os.write(descriptor, json.dumps(owner).encode() + b"\n")

    def owner(self) -> dict[str, Any]:
        """Return what the holder wrote of itself; empty where nothing can be read."""
        try:
            found = json.loads(read_bytes(self.path, 4096))
        except (DataError, ValueError, RecursionError):
            return {}
        return found if isinstance(found, dict) else {}

    def _held(self) -> str:
        owner = self.owner()
        pid, host = owner.get("pid"), owner.get("host")
        who = "another process"
        here = host == socket.gethostname()
        if isinstance(pid, int) and not (here and started(pid) != owner.get("started")):
            who = f"process {pid}" + ("" if here else f" on {str(host)[:80]!r}")
            who += f" since {str(owner.get('since'))[:40]}"
        return f"{self.what} is in use by {who}; wait until it has ended, or name another --output"

    def release(self) -> None:
        """Give the lock back and delete its file."""
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is None:
            return
        ours = False
        with contextlib.suppress(OSError):
            ours = self._is_current(descriptor)
        if fcntl is None:  # Windows deletes no file that is open
            os.close(descriptor)
        with contextlib.suppress(OSError):
            if ours:
                self.path.unlink()  # before a lock of the system ends: nobody can have taken it yet
        if fcntl is not None:
            os.close(descriptor)

    def __enter__(self) -> Lock:
        self.acquire()
        return self

    def __exit__(self, *exception: object) -> None:
        self.release()


def started(pid: int) -> str | None:
    """Return when a process began, as the system counts; ``None`` where it is gone or untold.

    With the boot it tells a process from another one that has got its number later. It is no time
    of the clock: a clock that jumps does not change it.
    """
    try:
        line = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
        boot = Path("/proc/sys/kernel/random/boot_id").read_text(encoding="ascii").strip()
    except OSError:
        return None
    # the name, in brackets, may hold blanks and brackets; the time is field 22
    return f"{boot} {line.rpartition(')')[2].split()[19]}"


def lines_of(content: bytes) -> Iterator[tuple[bytes, bool]]:
    """Yield the lines of a file without their ends, and whether each has one."""
    start = 0
    while start < len(content):
        end = content.find(b"\n", start)
        if end < 0:
            yield content[start:], False
            return
        yield content[start:end], True
        start = end + 1
