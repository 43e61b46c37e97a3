"""Write documents of measurements: JSON with a line for each row of a table."""

from __future__ import annotations

import json
from pathlib import Path

from glmref.system.files import make_folder, write_text

_WIDEST = 200  # letters of a list or an object that is written on one line


def write_json(path: Path, document: object) -> None:
    """Write a document of measurements, in a folder that is made where it is missing.

    A list or an object that fits on a line is written on one, so that a row of a table is a line.

    Raises
    ------
    ValueError
        For NaN or an infinity, which JSON has not; the file stays as it was.
    """
    text = _lines(document, "\n")
    make_folder(path.parent)
    write_text(path, text + "\n")


def _lines(value: object, margin: str) -> str:
    """Return the text of a value.

    ``margin`` is the end of line before it with the blanks to its left.
    """
    line = json.dumps(value, allow_nan=False, ensure_ascii=False)
    deeper = margin + " "
    if len(line) <= _WIDEST or not isinstance(value, dict | list | tuple):
        return line
    if isinstance(value, dict):
        rows = [
            f"{json.dumps(str(key), ensure_ascii=False)}: {_lines(x, deeper)}"
            for key, x in value.items()
        ]
        return f"{{{deeper}{f',{deeper}'.join(rows)}{margin}}}"
    return f"[{deeper}{f',{deeper}'.join(_lines(x, deeper) for x in value)}{margin}]"
