"""Result files of asv (airspeed velocity), read as records: error and run time side by side.

asv keeps one JSON file for each commit, machine and environment, and never draws one benchmark
against another. The benchmarks of one class that share their parameters (``time_run``,
``track_error``, ``track_evaluations``) belong together cell by cell; here they are joined. Only the
files are read (their format 2, asv 0.6), none of asv's Python.
"""

from __future__ import annotations

import ast
import json
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import product
from pathlib import Path
from typing import Any

from ..compute.records import in_json
from ..errors import DataError
from ..system.files import read_text

_FORMAT = 2
_MOST = 1 << 28  # bytes of a file


@dataclass(frozen=True)
class Cell:
    """One combination of parameters of one class of benchmarks, measured at one commit."""

    benchmark: str  #: Class, with its module.
    parameters: Mapping[str, str]  #: Name -> value, both as strings.
    #: Function (``time_run``, ``track_error``...) -> number, seconds for ``time_``; ``None`` where
    #: it failed, was skipped or is not finite.
    values: Mapping[str, float | None]
    #: Function -> (25 %, 75 %), seconds, where asv gives them.
    quartiles: Mapping[str, tuple[float, float]]
    commit: str
    date: str  #: Of the commit, ISO 8601.
    #: Where it was measured.
    machine: str
    python: str

    def as_json(self) -> dict[str, Any]:
        """Return the cell as a JSON object."""
        return in_json(self)


def read_results(folder: Path) -> list[Cell]:
    """Read every result file below asv's folder of results.

    Raises
    ------
    DataError
        For a file that is not what asv 0.6 writes, naming it.
    """
    names = _parameter_names(folder / "benchmarks.json")
    files = [path for path in sorted(folder.glob("*/*.json")) if path.name != "machine.json"]
    cells = [cell for path in files for cell in _cells(path, names)]
    return sorted(cells, key=lambda cell: cell.date)


def _load(path: Path) -> dict[str, Any]:
    try:
        document = json.loads(read_text(path, _MOST))
    except (DataError, RecursionError, ValueError) as error:
        raise DataError(f"{path.name}: no result file of asv ({error}); run asv again") from None
    if not isinstance(document, dict):
        raise DataError(f"{path.name}: no result file of asv: it holds no object; run asv again")
    return document


def _parameter_names(path: Path) -> dict[str, list[str]]:
    """Return parameter names by benchmark; empty where asv has not yet listed its benchmarks."""
    if not path.is_file():
        return {}
    return {
        name: list(entry.get("param_names", ()))
        for name, entry in _load(path).items()
        if isinstance(entry, dict)
    }


def _cells(path: Path, names: Mapping[str, list[str]]) -> Iterator[Cell]:
    document = _load(path)
    if document.get("version") != _FORMAT:
        raise DataError(
            f"{path.name}: format {document.get('version')!r} of asv's result files is unknown; "
            f"this version reads {_FORMAT}"
        )
    try:
        yield from _joined(document, names)
    except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
        raise DataError(
            f"{path.name}: not what asv writes ({type(error).__name__}: {error}); run asv again"
        ) from None


def _joined(document: Mapping[str, Any], names: Mapping[str, list[str]]) -> Iterator[Cell]:
    """Put the functions of one class with the same parameters together, cell by cell."""
    columns = document["result_columns"]
    together: dict[tuple[str, str], dict[str, dict[str, Any]]] = {}
    for benchmark, row in document["results"].items():
        home, _, function = benchmark.rpartition(".")
        entry = dict(zip(columns, row, strict=False))
        key = (home, json.dumps(entry["params"]))
        together.setdefault(key, {})[function] = entry
    moment = datetime.fromtimestamp(document["date"] / 1000, tz=UTC).isoformat()
    where = {
        "commit": document["commit_hash"],
        "date": moment,
        "machine": document["params"]["machine"],
        "python": document["python"],
    }
    for (home, parameters), functions in together.items():
        combinations = list(product(*json.loads(parameters)))
        titles = _titles(names, home, functions, len(combinations[0]))
        for number, combination in enumerate(combinations):
            values = {f: _number(e["result"], number) for f, e in functions.items()}
            quartiles = {
                f: pair for f, e in functions.items() if (pair := _pair(e, number)) is not None
            }
            shown = dict(zip(titles, map(_plain, combination), strict=True))
            yield Cell(home, shown, values, quartiles, **where)


def _titles(
    names: Mapping[str, list[str]], home: str, functions: Mapping[str, Any], count: int
) -> list[str]:
    """Return names of the parameters, numbered where asv has no list of them."""
    listed: Sequence[str] = names.get(f"{home}.{next(iter(functions))}", ())
    return list(listed) if len(listed) == count else [f"parameter {k + 1}" for k in range(count)]


def _plain(text: str) -> str:
    """Take off the quotes that asv's repr puts around a string parameter."""
    try:
        value = ast.literal_eval(text)
    except (ValueError, SyntaxError):
        return text
    return value if isinstance(value, str) else text


def _number(results: Sequence[Any] | None, at: int) -> float | None:
    """Return one finite result; asv writes NaN for skipped and null for failed ones."""
    value = None if results is None else results[at]
    return float(value) if value is not None and math.isfinite(value) else None


def _pair(entry: Mapping[str, Any], at: int) -> tuple[float, float] | None:
    low, high = (_number(entry.get(key), at) for key in ("stats_q_25", "stats_q_75"))
    return None if low is None or high is None else (low, high)
