"""Files of data as sources: JSON, YAML, TOML, notebooks, and rows of numbers, line by line.

What is written is a text of a language that is read, with the same lines, so that the general
reader sees the same tables in a file of data as in a source.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from contextlib import suppress
from itertools import pairwise
from pathlib import Path

from .entries import of_subject
from .lexer import ROWS

#: Characters of a file of data that holds tables.
_MOST = 2_000_000
_KEY = re.compile(r"""(\s*)(- +)?["']?([\w.-]+)["']?\s*:(?:\s+(.*))?$""")
_NUMBERS = re.compile(r"\s*[-+]?[\d.][-+\d.eE/]*(?:[\s,;|]+[-+]?[\d.][-+\d.eE/]*)*[\s,;]*$")
_SECTION = re.compile(r"\s*\[\[?([\w.\"-]+)\]?\]\s*(?:#.*)?$")


def _of_json(text: str) -> str:
    return f"data = {text}" if text.lstrip()[:1] in ("{", "[") else text


def _of_notebook(text: str) -> str:
    """Return the code of a notebook, whose lines are strings of their own."""
    rows, code = [], False
    for row in text.split("\n"):
        said = ""
        if '"cell_type"' in row:
            code = '"code"' in row
        elif code:
            with suppress(ValueError):
                found = json.loads(row.strip().rstrip(",").removeprefix('"source": ['))
                said = found.rstrip("\n") if isinstance(found, str) else ""
        rows.append(said)
    return "\n".join(rows)


def _of_toml(text: str) -> str:
    """Return sections as blocks."""
    rows, opened = [], ""
    for row in text.split("\n"):
        section = _SECTION.match(row)
        if section:
            row, opened = f"{opened}class {section[1].rpartition('.')[2]} {{", "} "
        rows.append(row)
    return "\n".join(rows) + opened


def _of_yaml(text: str) -> str:
    """Return mappings as blocks, and lists, item by item, in brackets."""
    rows = [re.sub(r"(^|\s)#.*$", "", x) for x in text.split("\n")]
    live = [k for k, x in enumerate(rows) if x.strip() and not x.startswith("---")]
    after = dict(pairwise(live))
    made = [""] * len(rows)
    opened: list[tuple[int, str]] = []  # depth and end of what is open

    def depth(k: int) -> int:
        return len(rows[k]) - len(rows[k].lstrip())

    for k in live:
        key, here, end = _KEY.match(rows[k]), depth(k), ""
        item = rows[k].lstrip().startswith("- ")
        # items may stand as deep as the key of their list
        while opened and (here < opened[-1][0] or (
                here == opened[-1][0] and (opened[-1][1] == "}" or not item))):  # fmt: skip
            end += opened.pop()[1]
        said = rows[k].strip()
        if item and key is None:
            said = f"{said[2:].strip()},"
            nested = re.match(r"- (.*),$", said)
            said = f"[{nested[1]}," if nested else said
            opened += [(here + 2, "],")] if nested else []
        elif key is not None:
            follows = after.get(k)
            value = (key[4] or "").strip()
            if value:
                said = f"{key[3]} = {value}"
            elif follows is not None and rows[follows].lstrip().startswith("- ") and not _KEY.match(
                    rows[follows]):  # fmt: skip
                said = f"{key[3]} = ["
                opened.append((depth(follows), "]"))
            else:
                said = f"class {key[3]} {{"
                opened.append((here, "}"))
        made[k] = end + (";" if end.endswith("]") else "") + said
    return "\n".join(made) + "".join(x for _, x in reversed(opened))


def _of_numbers(text: str) -> str:
    """Return rows of numbers as one matrix; other lines are comments."""
    given = ((x, re.split(r"[\s,;|]+", x.strip(" ,;"))) for x in text.split("\n"))
    rows = [f"[{', '.join(y)}]," if _NUMBERS.match(x) else f"# {x}" for x, y in given]
    places = [k for k, x in enumerate(rows) if x.startswith("[")]
    if places:
        rows[places[-1]] += "]"
        rows[places[0]] = f"table = [{rows[places[0]]}"
    return "\n".join(rows)


#: What makes a source of the text of a file, by its ending, and the language of it.
FORMS: Mapping[str, tuple[str, Callable[[str], str]]] = {
    ".json": ("javascript", _of_json),
    ".ipynb": ("python", _of_notebook),
    ".toml": ("toml", _of_toml),
    ".yaml": ("toml", _of_yaml),
    ".yml": ("toml", _of_yaml),
    **dict.fromkeys(ROWS, ("python", _of_numbers)),
}


def as_source(path: Path, text: str) -> str:
    """Return the text of a file of data as a source, ``""`` where it holds no table."""
    if len(text) > _MOST or (path.suffix in ROWS and not of_subject(path.name)):
        return ""
    return FORMS[path.suffix][1](text)
