"""An audit: every table of a checkout, one record each; nothing stops it."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from ..errors import GlmrefError, UsageError
from .judge import judge
from .nearest import Library
from .readers import FORMATS, SUFFIXES, declared_orders, read

__all__ = ["FORMAT", "audit", "files"]

FORMAT = "glmref-audit-1"
#: A file without any of these holds no table of the format.
_MARKS: Mapping[str, str] = {
    "json": r'"(?:A|alpha|parts)"',
    "csv": r"\bb\b",
    "sundials": "ARK_BUTCHER_TABLE",
    "petsc": "TSRKRegister|TSDIRKRegister|TSARKIMEXRegister|TSRosWRegister|TSGLEERegister",
    "julia": "Tableau|Butcher|ConstantCache",
    "python": r"ButcherTableau|RungeKutta|tableau_intermediate|construct_|\bA\b.*=",
    "openmodelica": "setButcherTableau",
    "eigen": "aCoefficients",
    "rklib": r"call me%f\(",
    "kpp": "ros_Alpha",
    "principia": "FixedVector<double",
    "gsl": r"_order\s*\(\s*void",
    "odeint": "class",
}
_MOST = 60_000_000  # characters of a file


def files(source: Path, form: str) -> list[Path]:
    """Files of a checkout that may hold tables of a format, in the order of their paths.

    Raises
    ------
    UsageError
        Where there is nothing to read.
    """
    if source.is_file():
        return [source]
    if not source.is_dir():
        raise UsageError(f"{source} is no file and no folder; give a file or a checkout")
    found = [x for x in sorted(source.rglob("*")) if x.suffix in SUFFIXES[form] and x.is_file()]
    if not found:
        raise UsageError(f"{source} holds no file {' or '.join(SUFFIXES[form])} to read as {form}")
    return found


def _text(path: Path) -> str | None:
    try:
        if path.stat().st_size > _MOST:
            return None
        return path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return None


def audit(
    source: Path, form: str, *, search: bool = True, compare: bool = True
) -> Iterator[dict[str, Any]]:
    """Read and judge all tables of a checkout.

    Parameters
    ----------
    source : Path
        A file or a folder.
    form : str
        One of :data:`~.readers.FORMATS`.
    search : bool
        Whether wrong entries are looked for.
    compare : bool
        Whether the catalogue is compared with.

    Yields
    ------
    dict
        The record of :func:`~.judge.judge` with its ``path``. A file or table that is not
        understood has the status ``unread`` and says where.
    """
    if form not in FORMATS:
        raise UsageError(f"there is no reader for {form!r}; one of {', '.join(FORMATS)}")
    paths = files(source, form)
    root = source if source.is_dir() else source.parent
    texts = {path: _text(path) for path in paths}
    declared: dict[str, int] = {}
    for text in texts.values():
        declared |= declared_orders(text) if text else {}
    library = Library() if compare else None
    for path in paths:
        text, name = texts[path], str(path.relative_to(root))
        if text is None:
            yield {"path": name, "line": 1, "name": path.name, "status": "unread",
                   "remarks": ["the file cannot be read"]}  # fmt: skip
            continue
        if not re.search(_MARKS[form], text):
            continue
        try:
            for table in read(text, form, declared):
                yield {"path": name, **judge(table, library, search=search)}
        except (GlmrefError, ValueError, KeyError, IndexError, TypeError, AttributeError,
                RecursionError) as error:  # fmt: skip
            yield {"path": name, "line": 1, "name": path.name, "status": "unread",
                   "remarks": [f"the rest of the file is not understood: {error}"]}  # fmt: skip
