"""The user's folder for what can be computed again: kernels, and verdicts of ``verify``."""

from __future__ import annotations

import os
import stat
import sys
import tempfile
from pathlib import Path

#: Variable that names the cache folder; by default the platform's user cache.
CACHE_VARIABLE = "GLMREF_CACHE"


def cache_folder() -> Path | None:
    """Folder for generated kernels: ``$GLMREF_CACHE``, else the platform's user cache.

    Where that cannot be written (a read-only home, no home), a folder below the temporary
    directory; ``None`` where that cannot be written either, or where ``$GLMREF_CACHE`` cannot:
    kernels are then compiled anew in each process.
    """
    named = os.environ.get(CACHE_VARIABLE)
    if named:
        return Path(named) if _writable(Path(named)) else None
    base = _user_cache()
    if base is not None and _writable(base / "glmref" / "kernels"):
        return base / "glmref" / "kernels"
    # code is read from there and run: the folder must be this user's, and nobody else's
    fallback = _temporary()
    return fallback if _writable(fallback, private=True) else None


def lock_folder() -> Path | None:
    """Return a folder for locks between the processes of this user that only this user can write.

    It does not depend on ``$GLMREF_CACHE``, since locks of a machine must be the same for all runs.

    Returns
    -------
    Path or None
        ``None`` where neither the platform's user cache nor the temporary directory has one.
    """
    base = _user_cache()
    places = [_temporary()] if base is None else [base / "glmref" / "locks", _temporary()]
    return next((place for place in places if _writable(place, private=True)), None)


def _temporary() -> Path:
    """Return the folder of this user below the temporary directory; it may be missing."""
    user = str(os.getuid()) if hasattr(os, "getuid") else os.environ.get("USERNAME") or "user"
    return Path(tempfile.gettempdir()) / f"glmref-{user}"


def _user_cache() -> Path | None:
    """The platform's folder for caches; ``None`` for a user without a home."""
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
    """Folder of that name in :func:`cache_folder` that nobody else can write, or ``None``."""
    base = cache_folder()
    return base / name if base is not None and _writable(base / name, private=True) else None
