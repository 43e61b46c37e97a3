"""The audits of other codes: one record a code, and what it says is wrong with a table."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .files import data_root
from .strict_json import read_json

#: What a table of a code can be, as `glmref audit` says it.
STATUSES = ("right", "digits", "found", "wrong", "question", "unread")
#: Entries unlike those of the nearest method that are written one by one, at most.
SHOWN = 7


def audited_codes() -> dict[str, Mapping[str, Any]]:
    """Return the records of the audits by the name of their code, in the order of the names."""
    folder = data_root() / "audits"
    return {x.stem: read_json(x) for x in sorted(folder.glob("*.json"))}


def named(table: Mapping[str, Any]) -> str:
    """Return what is wrong with a table: the entry, else remarks, else what the nearest method has.

    Names of entries and of methods stand in backquotes.
    """
    said = [f"`{x['entry']}` is {x['is']}, should be {x['should be']}" for x in
            table.get("correction", ())]  # fmt: skip
    said = [" or ".join(said)] if said else []
    said += table.get("remarks", ())
    near = table.get("nearest", {})
    if near.get("entries") and not table.get("correction"):
        entries = ", ".join(f"`{x['entry']}` = {x['there']}" for x in near["entries"])
        few = near["differing"] <= SHOWN
        said.append(f"`{near['method']}` has {entries if few else 'other entries'}")
    return "; ".join(said)
