"""Rows about many cases, carried out where ``--on`` says, or ``GLMREF_EXECUTOR``.

A case is a mapping in JSON: a method, or a method and a claim. What a run has measured is kept
beside the file that it writes until that is complete, so that the same command goes on where it was
stopped. Where a file keeps rows, each carries the fingerprint of what it depends on; where that has
changed, the row is measured again.
"""

import hashlib
import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from glmref.catalogue.lookup import document
from glmref.compute import Done, Limits, Records, executor, measure
from glmref.compute.executors import ENVIRONMENT
from glmref.compute.identity import identity
from glmref.compute.records import key_of
from glmref.errors import UsageError
from glmref.measure.timing import circumstances
from tools.measured_json import write_json

#: Claims of order, on which the runs and the numbers depend.
ORDERS = ("order", "order-identity", "effective-order")
#: What is timed has a core of its own, but for ``here``.
TIMED = Limits(pinned=True)
#: Keys of a method file that nothing depends on; orders are seen in runs that start by iteration.
_WORDS = frozenset(
    {"$schema", "format", "name", "title", "claims", "source", "notes", "enclosure"}
    | {"starting", "finishing"}
)
Case = Mapping[str, Any]


def arguments(given: Sequence[str]) -> list[str]:
    """Take ``--on WHERE`` out of the arguments of a campaign, and have it hold for this process.

    Alone, ``--help`` shows what the campaign says of itself.
    """
    rest = list(given)
    if rest in (["-h"], ["--help"]):
        sys.stdout.write(f"{(sys.modules['__main__'].__doc__ or '').strip()}\n")
        raise SystemExit(0)
    if "--on" in rest:
        at = rest.index("--on")
        if at + 1 == len(rest):
            raise UsageError("--on needs a word: here, local:N, dask:N or a scheduler")
        os.environ[ENVIRONMENT] = rest[at + 1]
        del rest[at : at + 2]
    return rest


def carried_out(
    function: Callable[[Case], Any],
    cases: Iterable[Case],
    *,
    beside: Path | None = None,
    limits: Limits | None = None,
) -> list[Any]:
    """Return what a function of a module gives for each case, in order.

    No two cases have the same content. Beside the file that will hold the results they are kept as
    they end, until all are there; what other sources or versions have measured is measured again.
    Of what is timed the limits are :data:`TIMED`.

    Raises
    ------
    UsageError
        Where it fails on one of them; what had ended is kept.
    """
    module = function.__module__
    if module == "__main__":  # other processes know it by the name under which it was started
        module = sys.modules[module].__spec__.name  # type: ignore[union-attr]
    what = {"function": f"{module}:{function.__qualname__}", "with": _sources()}
    tasks = [{**what, "case": dict(case)} for case in cases]
    store = Records(None if beside is None else _kept(beside, function.__name__))
    number = sum(1 for _ in store.missing(tasks))

    def record(task: Mapping[str, Any], done: Done) -> dict[str, Any]:
        if done.failure:
            sys.stderr.write(done.trace)
            raise UsageError(f"{task['case']}: {done.failure}: {done.message}")
        return {"value": done.value}

    def advance(task: Mapping[str, Any], _: object) -> None:
        nonlocal number
        number -= 1
        sys.stderr.write(f"{len(tasks) - number} of {len(tasks)}: {task['case']}\n")

    with executor() as where:
        measure(_one, tasks, store, where, limits or Limits(), record=record, advance=advance)
    return [one["value"] for one in map(store.find, tasks) if one is not None]


def head_of(module: str, name: str, title: str, **said: Any) -> dict[str, Any]:
    """Return how the document of a measurement begins.

    ``module`` is what follows ``python -m campaigns.`` in the command that measures it, without the
    file.
    """
    return {
        "format": "glmref-measurement-1", "name": name, "title": title,
        "how": f"python -m campaigns.{module} FILE", **said,
    }  # fmt: skip


def record_of(module: str, name: str, title: str, *notes: str, **rest: Any) -> dict[str, Any]:
    """Return the document of a measurement with what was measured; see :func:`head_of`."""
    return head_of(module, name, title, notes=list(notes), where=circumstances(), **rest)


def three_digits(x: float) -> float | None:
    """Round to three digits; ``None`` for what is not finite."""
    return float(f"{x:.2e}") if math.isfinite(x) else None


def complete(path: Path, document: Mapping[str, Any]) -> None:
    """Write the file of a campaign, and let go what was kept beside it."""
    write_json(path, document)
    for kept in path.parent.glob(_kept(path, "*").name):
        kept.unlink()


def _kept(path: Path, what: str) -> Path:
    return path.with_name(f".{path.stem}.{what}.sqlite")


def _one(task: Mapping[str, Any]) -> Any:
    module, _, name = task["function"].partition(":")
    return getattr(import_module(module), name)(task["case"])


@cache
def _sources() -> str:
    """Return a hash of what a row depends on besides its case: this package and what it uses."""
    digest = hashlib.sha256(json.dumps(identity(), sort_keys=True).encode())
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def fingerprint(name: str) -> str:
    """Return a hash of the coefficients of a method and of the orders it claims."""
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
    """Bring a file up to date; return how many rows of its field were measured.

    ``head`` are the keys before the rows. A case holds keys and values by which a row is known to
    be of this case and current, among them its ``fingerprint``; ``row``, a function of a module,
    measures the rest of it. ``where`` says on what the last ones were measured.
    """
    file = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    stored = file.get(field, [])
    known = [
        (case, next((x for x in stored if all(x.get(k) == v for k, v in case.items())), None))
        for case in cases
    ]
    missing = [case for case, found in known if found is None]
    new = iter(carried_out(row, missing, beside=path))
    rows = [found if found is not None else {**case, **next(new)} for case, found in known]
    where = circumstances() if missing else file.get("where")
    complete(path, {**head, "where": where, field: rows})
    return len(missing)
