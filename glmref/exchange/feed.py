"""The feed: methods, verdicts, audits, vectors and problems as a folder of static files.

The same commit gives the same bytes on every machine: there are no dates, every list is sorted,
numbers are strings (exact expressions, decimals of mpmath or of ball arithmetic, doubles in
hexadecimal) and all else is copied from ``data/``. ``docs/feed.md`` says what may change.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Iterable, Iterator, Mapping, Sequence
from math import floor, log10
from pathlib import Path
from typing import Any

import mpmath

from .. import __version__
from ..catalogue.audits import audited_codes
from ..catalogue.canonical import canonical, checksums, datapackage
from ..catalogue.claims import EMBEDDED_ORDER
from ..catalogue.files import data_root, names
from ..catalogue.lookup import load, path_of
from ..catalogue.strict_json import read_json
from ..errors import DataError, UsageError
from ..exact import Ball, Scalar
from ..method.rounding import as_double
from ..problems import about, problem
from ..problems import names as problem_names
from ..system.files import make_folder, write_text
from ..views.problem_page import described, formula_lines
from .documents import expression, fixed, held, places_of
from .numbers import decimal_of
from .tables import butcher
from .tree_problems import tree_problems

VERSION = "v1"
DIGITS = 40
#: Programs without dependencies that read tableaux, and the page of one of them.
CHECKERS = Path(__file__).with_name("checkers")
#: Components of the largest initial value that is written out.
MOST_COMPONENTS = 1000


def write_feed(folder: Path, chosen: Sequence[str] = ()) -> int:
    """Write the feed of shipped methods, all by default, into a folder ``v1``; return their number.

    Certificates of ``glmref certify`` are in its folder ``certificates`` already.

    Raises
    ------
    UsageError
        For an unknown name, or a folder that cannot be written.
    DataError
        Where a certificate and the stored verdict of a claim differ.
    """
    findings = _findings()
    rows = [_method(folder, name, findings.get(name, [])) for name in chosen or names("all")]
    rows.sort(key=lambda row: row["name"])
    _put(folder / "index.json", {"format": "glmref-feed-index-1", "methods": rows})
    _put(folder / "audits.json", {"format": "glmref-feed-audits-1", "tables": list(_audits())})
    listed = [*_problems(folder)]
    _put(folder / "problems" / "index.json", {"format": "glmref-feed-problems-1", "names": listed})
    trees = [x.as_json() for x in tree_problems()]
    _put(folder / "problems" / "trees.json", {"format": "glmref-feed-trees-1", "problems": trees})
    data = data_root()
    for place in ("vectors", "schema"):
        for path in sorted((data / place).iterdir()):
            _copy(path, folder / place / path.name)
    for path in sorted(CHECKERS.iterdir()):
        _copy(path, folder / "checkers" / path.name)
    head = {
        "$schema": "https://datapackage.org/profiles/2.0/datapackage.json",
        "name": "glmref-feed",
        "version": __version__,
        "licenses": json.loads((data / "datapackage.json").read_bytes())["licenses"],
    }
    _put(folder / "datapackage.json", datapackage(folder, head))
    write_text(folder / "SHA256SUMS", checksums(folder), sync=False)
    return len(rows)


def _put(path: Path, document: Mapping[str, Any]) -> None:
    make_folder(path.parent)
    write_text(path, canonical(document), sync=False)


def _copy(path: Path, target: Path) -> None:
    make_folder(target.parent)
    shutil.copyfile(path, target)


def _findings() -> dict[str, list[dict[str, Any]]]:
    """Return the stored verdicts by method, without their floats."""
    found: dict[str, list[dict[str, Any]]] = {}
    path = data_root() / "measurements" / "verification.json"
    for row in json.loads(path.read_bytes())["findings"]:
        kept = {k: x for k, x in row.items() if k not in ("method", "residual")}
        found.setdefault(row["method"], []).append(kept)
    return found


# --- methods --------------------------------------------------------------------------------------


def _method(folder: Path, name: str, findings: list[dict[str, Any]]) -> dict[str, Any]:
    """Write one method, and return its row of the index."""
    path, method = path_of(name), load(name)
    document = read_json(path)
    blocks = {key: _numbers(rows) for key, rows in held(method).items()}
    numbers = [x for rows in held(method).values() for row in rows for x in row]
    digits = min(map(_known, numbers))
    verdicts = [{**row, **_certificate(folder, name, row)} for row in findings]
    found = {row["claim"].removeprefix("refutes "): row["value"] for row in findings}
    place = f"methods/{name}.json"
    record = {
        "format": "glmref-feed-method-1",
        "name": name,
        "document": document,
        "known": digits,
        "blocks": blocks,
        "verdicts": verdicts,
    }
    _put(folder / place, record)
    row = {
        "name": name,
        "title": document.get("title", name),
        "class": document["class"],
        "broken": document.get("broken"),
        "order": found.get("order"),
        "stages": len(next(iter(method.components)).matrices[0]),
        "exact": all(x is not None for b in blocks.values() for r in b["exact"] for x in r),
        "known": digits,
        "embedded": found.get(EMBEDDED_ORDER.key) or {},
        "source": {k: x for k, x in document["source"].items() if k != "bibtex"},
        "path": place,
        "sha256": hashlib.sha256((folder / place).read_bytes()).hexdigest(),
        "verdicts": {x["claim"]: x["verdict"] for x in findings},
    }
    if document["class"] == "rk":
        row["tableau"] = f"tableaux/{name}.txt"
        make_folder(folder / "tableaux")
        write_text(folder / row["tableau"], tableau_text(method), sync=False)
    return row


def _certificate(folder: Path, name: str, finding: Mapping[str, Any]) -> dict[str, Any]:
    """Return where the certificate of a finding is, if there is one, after comparing the two."""
    claim = finding["claim"].removeprefix("refutes ")
    path = folder / "certificates" / f"{name}.{claim}.json"
    if not path.is_file():
        return {"certificate": None}
    stated = json.loads(path.read_bytes())["statement"]["verdict"]
    expected = "fails" if claim != finding["claim"] else finding["verdict"]
    if stated != expected:
        raise DataError(
            f"{path.name}: the certificate states that the claim {stated}, and the stored verdict "
            f"is {expected}; write data/measurements/verification.json again"
        )
    return {"certificate": f"certificates/{path.name}"}


def _known(x: Scalar) -> int:
    """Return how many significant digits of a number are known, at most :data:`DIGITS`."""
    radius = x.radius() if isinstance(x, Ball) else 0.0
    if radius == 0 or x.magnitude() == 0:
        return DIGITS
    return max(0, min(DIGITS, floor(log10(x.magnitude() / (2 * radius)))))


def _numbers(rows: Sequence[Sequence[Scalar]]) -> dict[str, Any]:
    """Return a block as exact text, decimals, and doubles in hexadecimal."""

    def parts(x: Scalar, text: Any) -> Any:
        return text(x) if x.is_real() is not False else [text(x.real), text(x.imag)]

    def decimal(x: Scalar) -> str:
        return decimal_of(x, max(1, _known(x)))

    def double(x: Scalar) -> str:
        return as_double(x).hex()

    return {
        "exact": [[expression(x) for x in row] for row in rows],
        "decimal": [[parts(x, decimal) for x in row] for row in rows],
        "double": [[parts(x, double) for x in row] for row in rows],
    }


def tableau_text(method: Any) -> str:
    """Return a Runge-Kutta tableau in the text that the small checkers read.

    Lines of entries apart by blanks: the rows of A, then those that a name and a colon begin,
    ``b:``, ``c:`` and ``b_hat NAME:``. After ``digits: N`` a number with a point is a decimal of
    which N digits after the point are known, to one unit of the last.
    """
    tab = butcher(method, "the text of a tableau")
    hats = [(f"b_hat {x.name}: ", x.solution(method.weights)[0][0]) for x in method.embedded]
    rows = [*(("", row) for row in tab.A), ("b: ", tab.b), *hats]
    if method.abscissae_given is not None:
        rows.append(("c: ", tab.c))
    rough = [x for _, row in rows for x in row if expression(x) is None]
    places = places_of(rough, None)
    lines = [f"# {method.name}", *([f"digits: {places}"] if rough else [])]
    for name, row in rows:
        lines.append(name + " ".join(expression(x) or fixed(x, places) for x in row))
    return "\n".join(lines) + "\n"


# --- audits and problems --------------------------------------------------------------------------


def _audits() -> Iterator[dict[str, Any]]:
    """Yield the tables of all audited codes; ``method`` is the one of the catalogue nearest."""
    for record in audited_codes().values():
        source = record["source"]
        for table in record["tables"]:
            row = {k: x for k, x in table.items() if k not in ("name", "path", "nearest")}
            yield {
                "code": record["name"],
                "commit": source["commit"],
                "page": source["page"],
                "table": table["name"],
                "file": table["path"],
                "method": table.get("nearest", {}).get("method"),
                **row,
            }


def _problems(folder: Path) -> Iterator[str]:
    """Write the problems that are no faults on purpose, and yield their names."""
    for name in problem_names():
        if not name.startswith("fault-"):
            _put(folder / "problems" / f"{name}.json", _problem(name))
            yield name


def _problem(name: str) -> dict[str, Any]:
    given = problem(name)
    context = mpmath.MPContext()
    context.dps = DIGITS + 20
    exact = given.on(context) if given.dimension <= MOST_COMPONENTS else None

    def texts(state: Iterable[Any]) -> list[str]:
        return [str(context.nstr(context.mpf(x), DIGITS)) for x in state]

    begin, end = (float(x).hex() for x in given.t_span)
    states = [
        {"t": str(x.t), "state": list(x.state), "generator": x.generator} for x in given.references
    ]
    if exact is not None and exact.exact is not None:
        at = context.mpf(given.t_span[1])
        closed = texts(exact.exact(at, exact.y0))
        states.append({"t": str(given.t_span[1]), "state": closed, "generator": "closed form"})
    facts = described(given, about(name))
    return {
        "format": "glmref-feed-problem-1",
        **{k: facts[k] for k in ("name", "about", "kind", "dimension", "parameters", "formulas")},
        "t_span": [begin, end],
        "y0": None if exact is None else texts(exact.y0),
        "quadratic": {
            key: [[i, j, str(x)] for (i, j), x in sorted(form.terms.items())]
            for key, form in given.quadratic.items()
        },
        "invariants": {k: formula_lines(x) for k, x in given.invariants.items()},
        "states": states,
        "source": given.source,
    }


def output_folder(output: Path) -> Path:
    """Return the folder of the version, which must be new: old files would stay in it.

    Raises
    ------
    UsageError
        Where it is there already.
    """
    root = output / VERSION
    if root.exists():
        raise UsageError(f"{root} is there already; remove it, or name another folder")
    return make_folder(root)
