"""BibTeX for a method: what its source says, and the data file itself."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from .. import __version__
from ..catalogue.lookup import data_root, load, method_of, path_of
from ..errors import DataError
from ..method import GLM, AdditiveGLM, PartitionedGLM
from .show import Text
from .tables import one_line

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "~": r"\textasciitilde{}",
    "^": r"\textasciicircum{}",
    **{x: "\\" + x for x in "&%$#_"},
}
_YEAR = re.compile(r"\b(1[5-9]\d\d|20\d\d)\b")
#: What begins like an entry and is none; a preamble is TeX that is carried out.
_NO_ENTRIES = ("preamble", "string", "comment")
#: Commands of TeX that read, write, run or define something, and the notation that hides them.
_COMMANDS = re.compile(
    r"\\(?:immediate|write|input|include|openin|openout|read|catcode|csname|def|edef|gdef|xdef|let"
    r"|special|directlua|usepackage|newread|newwrite|loop|expandafter|everypar|shipout)(?![A-Za-z])"
    r"|\^\^"
)
_KEY = re.compile(r"@\s*(\w+)\s*\{\s*([^,\s]+)\s*,")


def escape(text: str) -> str:
    """Return a text with the characters TeX gives a meaning to made harmless."""
    return "".join(_SPECIAL.get(x, x) for x in one_line(text))


def source_entry(method: Mapping[str, Any]) -> str:
    """Return the BibTeX entry of a method's source: that of its file, or one made of its citation.

    Raises
    ------
    DataError
        For a bare tableau, which names no source; for an entry that is not one entry of BibTeX, or
        that holds what TeX would carry out beyond setting a text.
    """
    source = method.get("source", {})
    if not source:
        raise DataError(
            f"the method {method['name']!r} has no source to cite; add `source` with citation, "
            f"where and status to its file"
        )
    if source.get("bibtex", "").strip():
        return _checked(str(source["bibtex"]).strip(), str(method.get("name")))
    years = _YEAR.findall(source["citation"])
    fields = {"note": escape(source["citation"]), "howpublished": escape(source["where"])}
    if years:
        fields["year"] = years[-1]
    if source.get("doi"):
        fields["doi"] = re.sub(r"[{}\\%]", "", one_line(source["doi"]))
    return _entry("misc", f"{method['name']}-source", fields)


def file_entry(name: str | Path) -> str:
    """Return the BibTeX entry of a data file; its SHA-256 identifies it wherever it lies.

    Raises
    ------
    UsageError, DataError
        For a name or a file that cannot be read.
    """
    path, root = path_of(name), data_root()
    method = load(path).document or {}  # checked, and a bare tableau has its name
    shipped = path.is_relative_to(root)
    place = (
        f"glmref {__version__}, data/{path.relative_to(root).as_posix()}" if shipped else path.name
    )
    fields = {
        "author": "{The glmref authors}" if shipped else "",
        "title": f"{{{escape(method.get('title', method['name']))}: method data file "
        f"{escape(path.name)}}}",
        "howpublished": escape(place),
        "note": f"SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}",
    }
    return _entry("misc", f"glmref-{method['name']}", {k: x for k, x in fields.items() if x})


def cite(*methods: GLM | PartitionedGLM | AdditiveGLM | str | Path) -> Text:
    """Return BibTeX for methods: the source of each, and the data file itself where there is one.

    Parameters
    ----------
    *methods : GLM, PartitionedGLM, str or Path
        Methods, their names or their files. Of a method made by hand its ``source`` is cited.

    Returns
    -------
    str
        The entries, which an interpreter shows as they stand.

    Raises
    ------
    UsageError, DataError
        For a name or a file that cannot be read, and for a method that names no source.
    """
    named = [x for x in methods if isinstance(x, str | Path)]
    made = [method_of(x) for x in methods if not isinstance(x, str | Path)]
    own = [
        source_entry(x.document or {"name": x.name or "method", "source": x.source}) for x in made
    ]
    return Text("\n\n".join(dict.fromkeys([*entries(named), *own])))


def _checked(entry: str, name: str) -> str:
    """Return an entry as it stands, if it is one and harmless, as TeX will be run on it."""

    def refused(why: str) -> DataError:
        return DataError(f"{one_line(name, limit=120)}: `source.bibtex` {why}; correct the entry")

    head = _KEY.match(entry)
    if head is None or head[1].lower() in _NO_ENTRIES:
        raise refused("must be one entry of BibTeX such as @article{key, ...}")
    for line in entry.split("\n"):
        if one_line(line, limit=len(line) + 1) != re.sub(r"[ \t\r]+", " ", line).strip():
            raise refused("holds a control character")
    depth = 0
    for place, mark in enumerate(entry):
        if mark in "{}" and entry[place - 1] != "\\":
            depth += 1 if mark == "{" else -1
            if depth == 0 and place != len(entry) - 1:
                raise refused(f"goes on after the end of its entry, at character {place + 1}")
    if depth:
        raise refused("has braces that are not balanced")
    command = _COMMANDS.search(entry)
    if command is not None:
        raise refused(f"has the TeX command {command[0]!r}, which does more than set a text")
    return entry


def _entry(kind: str, key: str, fields: Mapping[str, str]) -> str:
    rows = "".join(f"  {name} = {{{text}}},\n" for name, text in fields.items())
    return f"@{kind}{{{key},\n{rows}}}"


def entries(names: Iterable[str | Path]) -> list[str]:
    """Return source and data file of each method; an entry that several share stands once.

    Two sources that differ and have the same key get different keys, since BibTeX refuses twins.

    Raises
    ------
    UsageError, DataError
        For a name or a file that cannot be read.
    """
    found: dict[str, str] = {}
    for name in names:
        # cite nothing that is not a method
        method = load(name).document
        assert method is not None
        for text in (source_entry(method), file_entry(name)):
            match = _KEY.match(text)
            key = match[2] if match else text
            if match and found.get(key, text) != text:
                key = f"{key}-{method['name']}"
                text = f"{text[: match.start(2)]}{key}{text[match.end(2) :]}"
            found.setdefault(key, text)
    return list(found.values())
