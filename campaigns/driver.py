"""Rows about many cases, carried out where ``GLMREF_EXECUTOR`` says; what a file has is kept.

A row belongs to a case (a method, or a method and a claim), which is a mapping in JSON, and carries
the fingerprint of what it depends on; where that has changed, the row is measured again.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

from glmref.catalogue.lookup import document
from glmref.catalogue.strict_json import write_json
from glmref.compute import executor, in_order
from glmref.compute.records import key_of
from glmref.errors import UsageError
from glmref.measure.timing import circumstances

__all__ = ["ORDERS", "carried_out", "fingerprint", "renew"]

#: Claims of order, on which the runs and the numbers depend.
ORDERS = ("order", "order-identity", "effective-order")
#: Keys of a method file that nothing depends on; orders are seen in runs that start by iteration.
_WORDS = frozenset(
    {"$schema", "format", "name", "title", "claims", "source", "notes", "enclosure"}
    | {"starting", "finishing"}
)
Case = Mapping[str, Any]


def carried_out(function: Callable[[Case], Any], cases: Iterable[Case]) -> Iterator[Any]:
    """Yield what a function of a module gives for each case, in order.

    Raises
    ------
    UsageError
        Where it fails on one of them.
    """
    tasks = list(cases)
    with executor() as where:
        for number, (task, done) in enumerate(in_order(where.run(function, tasks), tasks), 1):
            if done.failure:
                sys.stderr.write(done.trace)
                raise UsageError(f"{dict(task)}: {done.failure}: {done.message}")
            sys.stderr.write(f"{number} of {len(tasks)}: {dict(task)}\n")
            yield done.value


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
    row: Callable[[Case], Mapping[str, Any]],
) -> int:
    """Bring a file up to date.

    Parameters
    ----------
    path : Path
        The file; it need not exist.
    head : Mapping[str, Any]
        The keys before the rows.
    field : str
        Key of the rows.
    cases : Iterable[Case]
        What there is to be a row about: keys and values by which a row is known to be of this case
        and current; among them its ``fingerprint``.
    row : Callable[[Case], Mapping[str, Any]]
        A function of a module; measures the row of a case, without the case.

    Returns
    -------
    int
        How many rows were measured; ``where`` says on what the last ones were.
    """
    file = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    stored = file.get(field, [])
    known = [
        (case, next((x for x in stored if all(x.get(k) == v for k, v in case.items())), None))
        for case in cases
    ]
    missing = [case for case, found in known if found is None]
    new = carried_out(row, missing)
    rows = [found if found is not None else {**case, **next(new)} for case, found in known]
    where = circumstances() if missing else file.get("where")
    write_json(path, {**head, "where": where, field: rows})
    return len(missing)
