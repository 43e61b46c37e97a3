"""Files of rows about every method: measure what such a file lacks, keep what it has.

A row belongs to a case (a method, or a method and a claim) and carries the fingerprint of what it
depends on; where that has changed, the row is measured again.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar

from glmref.catalogue.lookup import document
from glmref.catalogue.strict_json import write_json
from glmref.measure.records import key_of
from glmref.measure.timing import circumstances

__all__ = ["ORDERS", "fingerprint", "renew"]

#: Claims of order, on which the runs and the numbers depend.
ORDERS = ("order", "order-identity", "effective-order")
#: Keys of a method file that nothing depends on; orders are seen in runs that start by iteration.
_WORDS = frozenset(
    {"$schema", "format", "name", "title", "claims", "source", "notes", "enclosure"}
    | {"starting", "finishing"}
)
Case = TypeVar("Case")


def fingerprint(name: str) -> str:
    """Hash of the coefficients of a method and of the orders it claims."""
    doc = document(name)
    parts: dict[str, Any] = {key: x for key, x in doc.items() if key not in _WORDS}
    parts["claims"] = {kind: doc["claims"].get(kind) for kind in ORDERS}
    if "base" in doc:
        parts["base"] = fingerprint(doc["base"])
    return key_of(parts)


def renew(
    path: Path,
    head: Mapping[str, Any],
    field: str,
    cases: Iterable[Case],
    identity: Callable[[Case], Mapping[str, Any]],
    row: Callable[[Case], Mapping[str, Any]],
) -> int:
    """Bring a file up to date.

    Args:
        path: the file; it need not exist.
        head: the keys before the rows.
        field: key of the rows.
        cases: what there is to be a row about.
        identity: keys and values of a row by which it is known to be of this case and current;
            among them its ``fingerprint``.
        row: measures the row of a case, without its identity.

    Returns
    -------
        How many rows were measured; ``where`` says on what the last ones were.
    """
    file = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    stored = file.get(field, [])
    rows, measured = [], 0
    for case in cases:
        mine = identity(case)
        known = next((x for x in stored if all(x.get(k) == v for k, v in mine.items())), None)
        measured += known is None
        rows.append(known if known is not None else {**mine, **row(case)})
    where = circumstances() if measured else file.get("where")
    write_json(path, {**head, "where": where, field: rows})
    return measured
