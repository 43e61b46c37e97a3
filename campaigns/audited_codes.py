"""Tables of docs/audit.md from the records of ``data/audits``: counts by code, and what is wrong.

``python -m campaigns.audited_codes`` writes them into the page.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from campaigns.driver import arguments
from campaigns.pages import write

ROOT = Path(__file__).parents[1]
AUDITS = ROOT / "data" / "audits"
PAGE = ROOT / "docs" / "audit.md"
STATUSES = ("right", "digits", "found", "wrong", "question", "unread")
#: Entries unlike those of the nearest method that are written one by one, at most.
SHOWN = 7


def records() -> dict[str, Mapping[str, Any]]:
    """Records by the name of their code."""
    return {x.stem: json.loads(x.read_text("utf-8")) for x in sorted(AUDITS.glob("*.json"))}


def row(cells: Sequence[object]) -> str:
    """One row of a table in Markdown."""
    return "| " + " | ".join(str(x).replace("|", "\\|") for x in cells) + " |"


def counts() -> str:
    """Number of tables of each code by status, and of all."""
    lines = [row(["code", "source", "tables", *STATUSES]), "|---" * (len(STATUSES) + 3) + "|"]
    total = [0] * len(STATUSES)
    for code, record in records().items():
        found = [record["counts"].get(x, 0) for x in STATUSES]
        total = [x + y for x, y in zip(total, found, strict=True)]
        lines.append(row([code, source(record), sum(found), *found]))
    return "\n".join([*lines, row(["all", "", sum(total), *total])])


def named(table: Mapping[str, Any]) -> str:
    """What the audit says is wrong: the entry, else remarks, else what the nearest method has."""
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


def source(record: Mapping[str, Any]) -> str:
    """Commit, date and licence of a code."""
    x = record["source"]
    return f"[{x['commit'][:7]}]({x['page']}/tree/{x['commit']}) of {x['date']}, {x['licence']}"


def findings() -> str:
    """Every table that is not right, the wrong ones first."""
    lines = [
        row(["code", "table", "place", "source", "status", "declared", "found", "tree, residual",
             "named"]),
        "|---" * 9 + "|",
    ]  # fmt: skip
    for status in ("wrong", "question", "digits"):
        for code, record in records().items():
            for x in record["tables"]:
                if x["status"] == status:
                    tree = f"`{x['tree']}`, {x['residual']}" if "tree" in x else ""
                    place = f"`{x['path']}`:{x['line']}"
                    cells = [code, x["name"], place, source(record), status, x.get("declared", "")]
                    lines.append(row([*cells, x.get("found", ""), tree, named(x)]))
    return "\n".join(lines)


#: Name of a table of the page -> what writes it.
TABLES = {"audit-codes": counts, "audit-findings": findings}


def main(given: Sequence[str]) -> None:
    """Write the tables into the page."""
    if given:
        raise SystemExit("python -m campaigns.audited_codes takes no arguments")
    write({PAGE: TABLES})


if __name__ == "__main__":
    main(arguments(sys.argv[1:]))
