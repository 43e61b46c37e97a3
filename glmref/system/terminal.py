"""One line on the terminal while something takes its time; nothing where stderr is no terminal."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress

_WIDTH = 78
_lines: list[str] = []


@contextmanager
def saying(text: str) -> Iterator[None]:
    """Show a line on stderr until the block is left, and then the line before it, or none.

    Parameters
    ----------
    text : str
        What is being done; it is cut at the width of a terminal.
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
