"""How much memory there is, so that what cannot fit is refused before it is requested."""

from __future__ import annotations

import os
from contextlib import suppress

#: Memory up to which Newton's matrices are formed: dense elimination beyond takes hours.
NEWTON_BYTES = 2**31

_UNKNOWN = 2**36  # bytes assumed where the system does not say


def gibibytes(count: float) -> str:
    """Return a number of bytes in words."""
    return f"{count / 2**30:.3g} GiB"


def memory() -> int:
    """Return the bytes a process may use: what the machine has, or less where limited."""
    found = _UNKNOWN
    with suppress(AttributeError, OSError, ValueError):
        found = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    with suppress(ImportError, OSError, ValueError):
        import resource  # not on every system

        limit = resource.getrlimit(resource.RLIMIT_AS)[0]
        if limit not in (resource.RLIM_INFINITY, -1):
            found = min(found, limit)
    return found
