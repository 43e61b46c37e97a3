"""Files under faults: bounded reading, and writing in one piece.

What the system refuses (a full disk, a quota, a read-only folder, a folder where a file must be)
becomes a sentence that names the path and the reason. A file that is written whole is replaced in
one piece, so that a process killed at any instant leaves the old content or the new, never a part.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import stat
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path

from ..errors import DataError, UsageError
from .arguments import shown

#: Windows changes ends of lines in files that are opened without it.
BINARY = getattr(os, "O_BINARY", 0)


def reason(error: Exception) -> str:
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


def require_regular(path: Path, mode: int) -> None:
    """Refuse a folder, a named pipe, a device or a socket by its mode, as ``os.stat`` returns it.

    Raises
    ------
    DataError
        For what is not a regular file.
    """
    if not stat.S_ISREG(mode):
        raise DataError(f"{one_name(path)}: it is {kind_of(mode)}, and a regular file is needed")


def read_bytes(path: Path, most: int) -> bytes:
    """Read a regular file of at most so many bytes.

    A named pipe or a device is refused at once, so that reading never hangs.

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
        require_regular(path, about.st_mode)
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
    ``key`` is the entry of the document, and ``what`` the document, for the sentence.

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


def given_file(name: str, suffix: str, named: str, what: str) -> Path | None:
    """Return the file that a user gives; ``None`` for a word that is no file's name here.

    ``named`` is the name in a sentence, and ``what`` says what to give instead.

    Raises
    ------
    UsageError
        For a file that is missing, not regular, or cannot be read.
    """
    path = Path(name)
    try:
        mode = path.stat().st_mode if name else None
    except FileNotFoundError:
        mode = None
    except (OSError, ValueError) as error:  # a name too long, a folder one may not enter
        raise UsageError(f"the file {named} cannot be read ({reason(error)})") from None
    if mode is not None and stat.S_ISREG(mode):
        return path
    if mode is None and path.suffix != suffix and path.parent == Path():
        return None
    found = "does not exist" if mode is None else f"is {kind_of(mode)}"
    raise UsageError(f"the file {named} {found}; give {what}")


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
    """Write a file in one piece: beside it first, then moved over it; its folder must exist.

    What is no regular file is not replaced. With ``sync`` it is on the disk on return; without, a
    file that can be made again costs less.

    Raises
    ------
    UsageError
        Where the system refuses; the file then has its old content, or is still missing.
    """
    try:
        target = path.resolve()  # a link stays a link
        mode = target.stat().st_mode if target.exists() else None
    except (OSError, ValueError, RuntimeError) as error:
        raise UsageError(f"{printable(path)} cannot be written ({reason(error)})") from None
    if mode is not None and not stat.S_ISREG(mode):
        raise UsageError(f"{printable(path)} is {kind_of(mode)}; name a regular file to write")
    if not target.parent.is_dir():
        raise UsageError(
            f"{printable(path)} cannot be written: there is no folder {printable(target.parent)}; "
            f"make it, or name another place"
        )
    try:
        replace_whole(target, content, sync=sync, mode=mode)
    except OSError as error:
        raise UsageError(
            f"{printable(path)} cannot be written ({reason(error)}); make room there, or name "
            f"another place"
        ) from None


def replace_whole(
    path: Path, content: bytes, *, sync: bool = False, mode: int | None = None, umask: int = 0
) -> None:
    """Write a file in one piece, whatever stands there; see :func:`write_bytes`.

    ``mode`` are permissions, by default those of a new file, which gets none of ``umask``, in
    addition to those the user has excluded.

    Raises
    ------
    OSError
        Where the system refuses.
    """
    # another process or thread may be writing the same: no two have the same name
    aside = path.with_name(f".{path.name[:100]}.{os.urandom(6).hex()}.tmp")
    descriptor = os.open(aside, os.O_WRONLY | os.O_CREAT | os.O_EXCL | BINARY, 0o666 & ~umask)
    try:
        with open(descriptor, "wb") as stream:
            stream.write(content)
            stream.flush()
            if sync:
                os.fsync(descriptor)
        if mode is not None:
            os.chmod(aside, stat.S_IMODE(mode))
        os.replace(aside, path)
    except BaseException:
        with contextlib.suppress(OSError):
            aside.unlink()
        raise
    if sync:
        with contextlib.suppress(OSError):  # the names in the folder, where the system can
            descriptor = os.open(path.parent, os.O_RDONLY)
            try:
                os.fsync(descriptor)
            finally:
                os.close(descriptor)
