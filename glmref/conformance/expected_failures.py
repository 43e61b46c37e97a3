"""Known failures: a file of check ids, each with the reason why it fails.

One line each, ``id: reason``; blank lines and lines that begin with ``#`` are skipped::

    order8/dop853/pendulum: the step size control cannot be switched off
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from ..errors import DataError, UsageError, did_you_mean
from ..system.files import read_text

MAX_BYTES = 1_000_000


def read_known_failures(path: str | Path, ids: Iterable[str]) -> dict[str, str]:
    """Read the file; return id -> reason.

    Raises
    ------
    UsageError
        For a file that cannot be read, a line without a reason, an id given twice, or an id that no
        check has.
    """
    known, ids = {}, list(ids)
    try:
        text = read_text(Path(path), MAX_BYTES)
    except DataError as error:
        raise UsageError(f"the known failures {str(path)!r} cannot be read ({error})") from None
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        name, _, reason = (part.strip() for part in line.partition(":"))
        where = f"{path}, line {number}"
        if not reason:
            raise UsageError(f"{where}: {name!r} needs a reason; write `id: reason`")
        if name in known:
            raise UsageError(f"{where}: {name!r} occurs twice")
        if name not in ids:
            hint = did_you_mean(name, ids, "; ")
            raise UsageError(f"{where}: no check has the id {name!r}{hint}")
        known[name] = reason
    return known
