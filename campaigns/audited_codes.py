"""Tables of docs/audit.md and docs/audit/tables.md from the records of ``data/audits``."""

from collections import Counter
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
    """Return the number of tables of each code by status; codes of one status share a row."""
    rows, alike, total = [], dict[str, list[str]](), Counter[str]()
    for code, record in audited_codes().items():
        count = {x: n for x, n in record["counts"].items() if n}
        total.update(count)
        if len(count) == 1:
            (status, number), *_ = count.items()
            alike.setdefault(status, []).append(f"{source(code, record)} ({number})")
        elif count:
            rows.append([source(code, record), numbers(count)])
    rows += [[", ".join(alike[x]), f"all {x}"] for x in STATUSES if x in alike]
    return markdown(["code", "tables"], [*rows, [f"all {sum(total.values())}", numbers(total)]])


def numbers(count: Mapping[str, int]) -> str:
    """Return the number of tables of each status that occurs."""
    return ", ".join(f"{count[x]} {x}" for x in STATUSES if count.get(x))


def without() -> str:
    """Return the codes that were read and in which no table is recognised, in one row."""
    known = audited_codes().items()
    found = [f"{source(code, x)} ({x['files']})" for code, x in known if not x["tables"]]
    return markdown(["no table is recognised (files read)"], [[", ".join(found)]])


def source(code: str, record: Mapping[str, Any]) -> str:
    """Return the name of a code, linked at its commit."""
    return f"[{code}]({record['source']['page']}/tree/{record['source']['commit']})"


def place(record: Mapping[str, Any], table: Mapping[str, Any]) -> str:
    """Return the path and line of a table, linked at its commit."""
    x, line = record["source"], f"{table['path']}:{table['line']}"
    return f"[`{line}`]({x['page']}/blob/{x['commit']}/{table['path']}#L{table['line']})"


def said(table: Mapping[str, Any]) -> str:
    """Return what is wrong with a table, without the remark that nothing says why."""
    remarks = [x for x in table.get("remarks", ()) if x != UNNAMED]
    return named({**table, "remarks": remarks})


def findings() -> str:
    """Return every table that is not right, the wrong ones first; places of like ones together."""
    rows: dict[tuple[str, ...], list[str]] = {}
    for status in ("wrong", "question", "digits"):
        for code, record in audited_codes().items():
            for x in record["tables"]:
                if x["status"] == status:
                    tree = f"`{x['tree']}`, {x['residual']}" if "tree" in x else ""
                    orders = [str(x.get(k, "")) for k in ("declared", "found")]
                    key = (f"{code}: {x['name']}", status, *orders, tree, said(x))
                    rows.setdefault(key, []).append(place(record, x))
    head = "table, source, status, declared, found"
    cells = [[key[0], ", ".join(places), *key[1:]] for key, places in rows.items()]
    return markdown([*head.split(", "), "tree, residual", "named"], cells)


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
    PAGE: {"audit-codes": counts, "audit-none": without, "audit-findings": findings},
}
