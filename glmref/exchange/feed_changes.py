"""What changed between two feeds, and whether that breaks the promise of ``docs/feed.md``."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..catalogue.strict_json import parse_json, shown
from ..errors import DataError
from ..system.files import read_text
from .feed import VERSION

#: Keys of problems and vectors whose texts are for people.
_PROSE = frozenset({"about", "notes", "source", "what"})
#: Size of a file beyond which it is not read.
MOST_BYTES = 200_000_000
_Rows = Mapping[str, Mapping[str, Any]]


@dataclass
class Changes:
    """What differs between two feeds, one sentence each."""

    allowed: list[str] = field(default_factory=list)  #: What may change within v1.
    broken: list[str] = field(default_factory=list)  #: What breaks the promise of the page.


def changes(old: Path, new: Path) -> Changes:
    """Compare two feeds by the folders that were given as ``--output``.

    Raises
    ------
    DataError
        For a folder without a feed, and for a file of it that is not as ``glmref feed``
        writes it.
    """
    found = Changes()
    before, after = (_index(x / VERSION) for x in (old, new))
    corrected = set()
    for name in _common(before, after, found):
        if _errata(before[name]) != _errata(after[name]):
            corrected.add(name)
        _compare_methods(name, before[name], after[name], found)
    problems, later = (dict(_problems(x / VERSION)) for x in (old, new))
    for name in _common(problems, later, found):
        _compare(name, problems[name], later[name], found)
    vectors, later = (dict(_vectors(x / VERSION)) for x in (old, new))
    for name in _common(vectors, later, found):
        allowed = Changes(found.allowed, found.allowed)
        method = vectors[name]["method"]
        _compare(name, vectors[name], later[name], allowed if method in corrected else found)
    files, later = (_files(x / VERSION) for x in (old, new))
    found.broken.extend(f"{name}: gone" for name in sorted(files - later))
    tables, later = (dict(_tables(x / VERSION)) for x in (old, new))
    _compare_audits(tables, later, found)
    return found


def _common(before: _Rows, after: _Rows, found: Changes) -> list[str]:
    """Report the rows of only one feed, and return the names of the others."""
    for name in sorted(after.keys() - before.keys()):
        kind = after[name].get("class")
        found.allowed.append(f"{name}: new" + (f", {kind}" if kind else ""))
    found.broken.extend(f"{name}: gone" for name in sorted(before.keys() - after.keys()))
    return sorted(before.keys() & after.keys())


def _gone(name: str, a: Mapping[str, Any], b: Mapping[str, Any], found: Changes) -> None:
    found.broken.extend(f"{name}: the key {key} is gone" for key in sorted(a.keys() - b.keys()))


def _errata(row: Mapping[str, Any]) -> Any:
    return row["source"].get("errata")


def _compare_methods(name: str, a: Mapping[str, Any], b: Mapping[str, Any], found: Changes) -> None:
    _gone(name, a, b, found)
    for claim, verdict in a["verdicts"].items():
        if claim not in b["verdicts"]:
            found.broken.append(f"{name}: the claim {claim} is gone")
        elif b["verdicts"][claim] != verdict:
            found.broken.append(f"{name}: {claim} {verdict}, now {b['verdicts'][claim]}")
    found.allowed.extend(f"{name}: {x} is new" for x in b["verdicts"] if x not in a["verdicts"])
    if a["numbers"] != b["numbers"]:
        corrected = _errata(a) != _errata(b)
        (found.allowed if corrected else found.broken).append(
            f"{name}: other coefficients" + ("" if corrected else ", and no new erratum says why")
        )
    if a["source"] != b["source"]:
        found.allowed.append(f"{name}: the source is described in other words")


def _compare(name: str, a: Mapping[str, Any], b: Mapping[str, Any], found: Changes) -> None:
    """Compare two problems, or two cases of vectors: entries may be added to their lists."""
    _gone(name, a, b, found)
    for key in sorted(a.keys() & b.keys()):
        x, y = a[key], b[key]
        if x == y:
            continue
        if key in _PROSE:
            found.allowed.append(f"{name}: {key} is described in other words")
        elif key == "states" and isinstance(y, list) and all(state in y for state in x):
            found.allowed.append(f"{name}: more {key}")
        else:
            found.broken.append(f"{name}: other {key}")


def _compare_audits(before: _Rows, after: _Rows, found: Changes) -> None:
    """Report the tables that were judged otherwise; an audit may be repeated."""
    for name in sorted({*before, *after}):
        a, b = before.get(name, {}), after.get(name, {})
        old, new = (x.get("status", "not audited") for x in (a, b))
        keys = sorted(key for key in a.keys() | b.keys() if a.get(key) != b.get(key))
        if old != new:
            found.allowed.append(f"{name}: {old}, now {new}")
        elif keys:
            found.allowed.append(f"{name}: {old} as before, other {', '.join(keys)}")


def _read(path: Path, /, **members: type) -> dict[str, Any]:
    """Return the object of a file, in which these members have these types."""
    document = parse_json(_text(path), str(path), float)
    return _checked(path, "the file", document, members)


def _text(path: Path) -> str:
    if not path.is_file():
        raise DataError(f"{path} is missing; give the folder that `glmref feed --output` wrote")
    return read_text(path, MOST_BYTES)


def _checked(path: Path, what: str, row: Any, members: Mapping[str, type]) -> dict[str, Any]:
    if isinstance(row, dict):
        wrong = [key for key, kind in members.items() if not isinstance(row.get(key), kind)]
        if not wrong:
            return row
        what += f" has no `{wrong[0]}` of type {members[wrong[0]].__name__}"
    else:
        what += f" must be an object, got {shown(row)}"
    raise DataError(f"{path}: {what}; write the feed again with `glmref feed --output`")


def _rows(path: Path, key: str, /, **members: type) -> list[dict[str, Any]]:
    """Return the objects of a list in a file, each with these members."""
    rows = _read(path, **{key: list})[key]
    return [_checked(path, f"{key}[{i}]", row, members) for i, row in enumerate(rows)]


def _index(root: Path) -> dict[str, dict[str, Any]]:
    """Return the rows of the index by name, each with its coefficients."""
    rows = _rows(root / "index.json", "methods", name=str, path=str, source=dict, verdicts=dict)
    return {
        row["name"]: {**row, "numbers": _read(root / row["path"], blocks=dict)["blocks"]}
        for row in rows
    }


def _files(root: Path) -> set[str]:
    """Return the files of which only the place is promised."""
    return {
        name
        for name in (line.partition("  ")[2] for line in _text(root / "SHA256SUMS").splitlines())
        if name.startswith(("certificates/", "checkers/", "schema/", "tableaux/"))
    }


def _problems(root: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    for name in _read(root / "problems" / "index.json", names=list)["names"]:
        yield f"problem {name}", _read(root / "problems" / f"{name}.json")
    for row in _rows(root / "problems" / "trees.json", "problems", name=str):
        yield f"problem {row['name']}", row


def _vectors(root: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the cases of all methods and their problems, each with the method or None."""
    for path in sorted((root / "vectors").glob("*.json")):
        method = _read(path).get("method")
        rows = _rows(path, "cases", id=str) if method else _rows(path, "problems", name=str)
        for row in rows:
            key = row["id"] if method else f"problem {row['name']}"
            yield f"vectors, {key}", {"method": method, **row}


def _tables(root: Path) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield the audited tables; those of one name in one file are counted."""
    count: Counter[str] = Counter()
    for row in _rows(root / "audits.json", "tables", code=str, file=str, table=str):
        name = f"{row['code']} {row['file']} {row['table']}"
        count[name] += 1
        yield (name if count[name] == 1 else f"{name}, {count[name]}"), row
