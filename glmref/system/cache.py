"""What can be computed again: kernels, forms of methods, verdicts of ``verify``.

One folder of the user has all of it. An entry is a file with the checksum of its content, written
in one piece: a damaged one counts as missing.
"""

from __future__ import annotations

import hashlib
import json
import os
import stat
import sys
import tempfile
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from .files import BINARY, replace_whole

#: Variable that names the cache folder; by default the platform's user cache.
CACHE_VARIABLE = "GLMREF_CACHE"


def cache_folder() -> Path | None:
    """Return the folder for generated kernels: ``$GLMREF_CACHE``, else the platform's user cache.

    Where that cannot be written (a read-only home, no home), a folder below the temporary
    directory; ``None`` where that cannot be written either, or where ``$GLMREF_CACHE`` cannot:
    kernels are then compiled again in each process.
    """
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named) if _writable(Path(named)) else None
    base = _user_cache()
    if base is not None and _writable(base / "glmref" / "kernels"):
        return base / "glmref" / "kernels"
    # code is read from there and run: the folder must be this user's only
    user = str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME") or "user"
    fallback = Path(tempfile.gettempdir()) / f"glmref-{user}"
    return fallback if _writable(fallback, private=True) else None


def _user_cache() -> Path | None:
    """Return the platform's folder for caches; ``None`` for a user without a home."""
    try:
        home = Path.home()
    except RuntimeError:
        return None
    if sys.platform == "darwin":
        return home / "Library" / "Caches"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", home / "AppData" / "Local"))
    return Path(os.environ.get("XDG_CACHE_HOME") or home / ".cache")


def _writable(folder: Path, *, private: bool = False) -> bool:
    try:
        folder.mkdir(0o700 if private else 0o777, parents=True, exist_ok=True)
        if private and hasattr(os, "getuid"):
            about = folder.lstat()
            if not stat.S_ISDIR(about.st_mode) or about.st_uid != os.getuid():
                return False
            if about.st_mode & 0o022:
                return False
    except (OSError, ValueError):
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def private_folder(name: str) -> Path | None:
    """Return a folder in :func:`cache_folder` that only this user can write, or ``None``."""
    base = cache_folder()
    return base / name if base is not None and _writable(base / name, private=True) else None


# --- entries --------------------------------------------------------------------------------------

#: Bytes of an entry at the most.
_MOST = 1 << 26


def read_entry(path: Path) -> bytes | None:
    """Return the content of an entry, ``None`` where it is missing, damaged or of another user."""
    try:
        # without O_NONBLOCK, opening a named pipe waits for a writer
        descriptor = os.open(path, os.O_RDONLY | BINARY | getattr(os, "O_NONBLOCK", 0))
        with open(descriptor, "rb") as stream:
            about = os.fstat(stream.fileno())
            if hasattr(os, "getuid") and about.st_uid != os.getuid():
                return None
            digest, content = stream.read(32), stream.read(_MOST)
    except OSError:
        return None
    return content if hashlib.sha256(content).digest() == digest else None


def write_entry(path: Path, content: bytes) -> None:
    """Write an entry; where that is refused, the content is computed again next time."""
    with suppress(OSError):
        replace_whole(path, hashlib.sha256(content).digest() + content, umask=0o077)


def read_value(path: Path) -> Any:
    """Return the JSON value of an entry, ``None`` as :func:`read_entry`."""
    content = read_entry(path)
    with suppress(ValueError, RecursionError):
        return None if content is None else json.loads(content)
    return None


def write_value(path: Path, value: Any) -> None:
    """Write a JSON value as an entry; one that JSON does not have is not written."""
    with suppress(TypeError, ValueError):
        write_entry(path, json.dumps(value, allow_nan=False).encode())


#: Endings of what the package reads of itself.
_READ = (".py", ".toml", ".json", ".in")


@cache
def sources(*parts: str) -> str:
    """Return the checksum of modules of this package, and of the tables that they read.

    They are subpackages and modules, as paths below the package; without any all but the catalogue,
    which an installed package holds as `data`.
    """
    package = Path(__file__).parents[1]
    catalogue = package / "data"
    found = hashlib.sha256()
    for place in (package / part for part in parts or (".",)):
        inside = sorted(
            x for x in place.rglob("*") if x.suffix in _READ and catalogue not in x.parents
        )
        for path in inside if place.is_dir() else [place]:
            content = path.read_bytes()
            found.update(f"{path.relative_to(package).as_posix()} {len(content)} ".encode())
            found.update(content)
    return found.hexdigest()
