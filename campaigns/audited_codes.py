"""Tables of docs/audit.md and docs/audit/tables.md from the records of ``data/audits``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from campaigns.pages import ROOT, Pages, markdown
from glmref.catalogue.audits import STATUSES, audited_codes, named

SHORT = ROOT / "docs" / "audit.md"
PAGE = ROOT / "docs" / "audit" / "tables.md"
#: What a question says where nothing says why; the page defines the word so.
UNNAMED = "no single entry explains it: the label, or more than one entry"
#: Tables that the short page shows: code, name.
SHOWN_FIRST = (
    ("petsc", "TSARKIMEXBPR3"), ("openmodelica", "FEHLBERG12"),
    ("torchdiffeq", "_TSITOURAS_TABLEAU"), ("torchdiffeq", "_GAUSS_LEGENDRE_4_TABLEAU"),
    ("ordinarydiffeq.jl", "Feagin12"), ("ordinarydiffeq.jl", "Kvaerno3ESDIRKIMEXTableau"),
    ("ordinarydiffeq.jl", "SIR54ConstantCache"), ("ariadne", "CooperSayfy5"),
    ("desolver", "RadauIIA3"), ("principia", "Fine1987RKNG34"), ("nodepy", "Lambert65"),
    ("rungekutta.jl", "RK42"),
)  # fmt: skip


def counts() -> str:
    """Return the number of tables of each code by status, and of all."""
    rows, total = [], [0] * len(STATUSES)
    for code, record in audited_codes().items():
        found = [record["counts"].get(x, 0) for x in STATUSES]
        total = [x + y for x, y in zip(total, found, strict=True)]
        rows.append([code, source(record), sum(found), *(x or "" for x in found)])
    rows.append(["all", "", sum(total), *total])
    return markdown(["code", "source", "tables", *STATUSES], rows)


def source(record: Mapping[str, Any]) -> str:
    """Return the commit, date and licence of a code."""
    x = record["source"]
    return f"[{x['commit'][:7]}]({x['page']}/tree/{x['commit']}) {x['date']}, {x['licence']}"


def place(record: Mapping[str, Any], table: Mapping[str, Any]) -> str:
    """Return the path and line of a table, linked at its commit, with the date and licence."""
    x, line = record["source"], f"{table['path']}:{table['line']}"
    link = f"{x['page']}/blob/{x['commit']}/{table['path']}#L{table['line']}"
    return f"[`{line}`]({link}) {x['date']}, {x['licence']}"


def said(table: Mapping[str, Any]) -> str:
    """Return what is wrong with a table, without the remark that nothing says why."""
    remarks = [x for x in table.get("remarks", ()) if x != UNNAMED]
    return named({**table, "remarks": remarks})


def findings() -> str:
    """Return every table that is not right, the wrong ones first."""
    rows = []
    for status in ("wrong", "question", "digits"):
        for code, record in audited_codes().items():
            for x in record["tables"]:
                if x["status"] == status:
                    tree = f"`{x['tree']}`, {x['residual']}" if "tree" in x else ""
                    cells = [code, x["name"], place(record, x), status, x.get("declared", "")]
                    rows.append([*cells, x.get("found", ""), tree, said(x)])
    head = "code, table, source, status, declared, found"
    return markdown([*head.split(", "), "tree, residual", "named"], rows)


def first() -> str:
    """Return some wrong tables, each with the first thing that the audit names."""
    known, rows = audited_codes(), []
    for code, name in SHOWN_FIRST:
        found = next(
            x for x in known[code]["tables"] if x["name"] == name and x["status"] == "wrong"
        )
        first_said = named(found).partition("; ")[0]
        rows.append([code, name, found["declared"], found["found"], first_said])
    return markdown(["code", "table", "declared", "found", "named"], rows)


PAGES: Pages = {
    SHORT: {"audit-short": first},
    PAGE: {"audit-codes": counts, "audit-findings": findings},
}
