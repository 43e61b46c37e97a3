"""Texts of others on a terminal, and one line while something takes its time."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

# controls, what has no width, and the marks that can make a line read as another one
_UNPRINTABLE = re.compile(
    "[\x00-\x1f\x7f-\x9f\u200b-\u200f\u2028-\u202e\u2060-\u206f\ufeff\ud800-\udfff]"
)
_WIDTH = 78
_lines: list[str] = []


def escaped(text: str) -> str:
    """Write what is not seen, or is obeyed, as it is written in JSON."""
    return _UNPRINTABLE.sub(lambda m: f"\\u{ord(m[0]):04x}", text)


@contextmanager
def saying(text: str) -> Iterator[None]:
    """Show a line on stderr until the block is left, and then the line before it, or none.

    It is cut at the width of a terminal.
    """
    _lines.append(text)
    _show()
    try:
        yield
    finally:
        _lines.remove(text)
        _show()


def _show() -> None:
    with suppress(OSError, ValueError, AttributeError):  # a stream that is closed, or is none
        if sys.stderr.isatty():
            line = "".join(c for c in _lines[-1] if c.isprintable())[:_WIDTH] if _lines else ""
            sys.stderr.write(f"\r\033[K{line}")
            sys.stderr.flush()
