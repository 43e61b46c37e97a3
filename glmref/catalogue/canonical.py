"""The one way a JSON document of this project is written: the same document, the same bytes.

Objects have one key a line, in the order of :data:`KEY_ORDER` and then of the alphabet; a list of
plain values stands on one line, so that a matrix shows one row a line; sentences (:data:`PROSE`)
have a line each; a file ends with a newline. Constants keep their order (:data:`IN_ORDER`), because
a constant may use those above it, and so do rows of weights, the first of which steppers use. Only
the standard library is used, so that any script can format data without this package's
dependencies.

After a change of the data run ``python -m glmref.catalogue.canonical data``: it also lays out the
certificates of ``hostile/``, whose keys keep their order.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from ..system.terminal import escaped
from .claims import CLAIMS

#: Keys of method files in reading order: what it is, its coefficients, what is claimed, from where.
KEY_ORDER: tuple[str, ...] = (
    *("$schema", "$id", "format", "name", "title", "class", "field", "broken", "notes"),
    *("digits", "unknowns", "constants", "base", "first", "separable", "stages", "kind", "parts"),
    *("alpha", "beta", "a", "A", "U", "B", "V", "V_hat", "b", "w", "c", "v"),
    *("omega", "gamma", "q", "p", "A_hat", "B_hat", "b_hat", "A_prime", "b_prime", "error"),
    *(
        "u",
        "u_hat",
        "G",
        "D",
        "X",
        "D_P",
        "D_Q",
        "output",
        "dense",
        "embedded",
        "enclosure",
        "starting",
        "finishing",
        "claims",
    ),
    *CLAIMS,
    *("claim", "flag", "why", "found"),
    *("source", "citation", "doi", "where", "status", "errata", "bibtex"),
)
#: Objects whose keys keep the order they are given in.
IN_ORDER = frozenset(["constants", "unknowns", "embedded", "error"])
#: Lists of sentences.
PROSE = frozenset(["errata", "notes"])
_RANK: Mapping[str, int] = {key: rank for rank, key in enumerate(KEY_ORDER)}

#: Files that list the others and so cannot list themselves.
_SUMS, _PACKAGE = "SHA256SUMS", "datapackage.json"


def canonical(document: Mapping[str, Any]) -> str:
    """Return the text of a document; two equal documents have the same text, whatever their order.

    Raises
    ------
    TypeError
        For a value JSON does not have.
    ValueError
        For NaN or an infinity.
    """
    return _write(document, "\n", "  ", ranked=True) + "\n"


def laid_out(document: Mapping[str, Any]) -> str:
    """Return the text of a document with its keys in the order given, a row of numbers on a line.

    Raises
    ------
    TypeError, ValueError
        As :func:`canonical`.
    """
    return _write(document, "\n", " ", ranked=False) + "\n"


def one_line(document: object) -> str:
    """Return a document on one line, without its end; what is not seen is escaped.

    Raises
    ------
    TypeError, ValueError
        As :func:`canonical`.
    """
    return escaped(json.dumps(document, ensure_ascii=False, allow_nan=False))


def compact(document: object, *, sort_keys: bool = False) -> bytes:
    """Return a document without blanks, in ASCII: what is hashed, and what records are made of.

    Raises
    ------
    TypeError, ValueError
        As :func:`canonical`.
    """
    separators = (",", ":")
    return json.dumps(
        document, sort_keys=sort_keys, separators=separators, allow_nan=False
    ).encode()


def _write(value: Any, margin: str, step: str, name: str = "", *, ranked: bool) -> str:
    """Return the text of a value.

    ``margin`` is the end of line before it with what stands left of it.
    """
    deeper = margin + step
    if isinstance(value, Mapping) and value:
        keys = list(value)
        if ranked and name not in IN_ORDER:
            keys.sort(key=lambda key: (_RANK.get(key, len(_RANK)), key))
        rows = (
            f"{one_line(key)}: {_write(value[key], deeper, step, key, ranked=ranked)}"
            for key in keys
        )
        return f"{{{deeper}{f',{deeper}'.join(rows)}{margin}}}"
    if isinstance(value, list | tuple) and value:
        nested = any(isinstance(x, list | tuple | Mapping) for x in value)
        if nested or name in PROSE:
            rows = (_write(x, deeper, step, ranked=ranked) for x in value)
            return f"[{deeper}{f',{deeper}'.join(rows)}{margin}]"
    return one_line(value)


def _files(root: Path, *without: str) -> list[Path]:
    """Return every file of the data folder but hidden ones and those named, sorted by path."""
    found = (x for x in root.rglob("*") if x.is_file())
    shown = (x for x in found if not any(p[0] in "._" for p in x.relative_to(root).parts))
    places = {x.relative_to(root).as_posix(): x for x in shown}
    return [places[name] for name in sorted(places) if name not in without]


def checksums(root: Path) -> str:
    """Return the text of SHA256SUMS: what ``sha256sum -c SHA256SUMS`` reads, one line a file."""
    lines = (
        f"{hashlib.sha256(path.read_bytes()).hexdigest()}  {path.relative_to(root).as_posix()}\n"
        for path in _files(root, _SUMS)
    )
    return "".join(lines)


def datapackage(root: Path, head: Mapping[str, Any]) -> dict[str, Any]:
    """Return the datapackage document: its ``head`` and every file of the data with size and hash.

    The head may be an older document: its ``resources`` are replaced. Data Package (v2),
    https://datapackage.org/standard/data-package/.
    """
    resources = []
    for path in _files(root, _SUMS, _PACKAGE):
        content, place = path.read_bytes(), path.relative_to(root)
        resources.append(
            {
                "name": "-".join((*place.parent.parts, place.stem)).lower(),
                "path": place.as_posix(),
                "format": place.suffix.removeprefix(".") or "text",
                "bytes": len(content),
                "hash": f"sha256:{hashlib.sha256(content).hexdigest()}",
            }
        )
    return {**head, "resources": resources}


def refresh(root: Path) -> list[Path]:
    """Bring method files into canonical form, lay out the hostile ones, update the hashes.

    Returns the files that were written: those whose text was another one.

    Raises
    ------
    FileNotFoundError
        When the folder has no datapackage.json to take the head from.
    """
    written: list[Path] = []

    def put(path: Path, text: str) -> None:
        if not path.is_file() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")
            written.append(path)

    for folder in ("methods", "broken"):
        for path in sorted((root / folder).rglob("*.json")):
            put(path, canonical(json.loads(path.read_text(encoding="utf-8"))))
    for path in sorted((root / "hostile").glob("*.json")):
        put(path, laid_out(json.loads(path.read_text(encoding="utf-8"))))
    package = root / _PACKAGE
    head = json.loads(package.read_text(encoding="utf-8"))
    put(package, canonical(datapackage(root, head)))
    put(root / _SUMS, checksums(root))
    return written


if __name__ == "__main__":
    sys.stdout.writelines(f"wrote {path}\n" for path in refresh(Path(sys.argv[1])))
