"""The overview of all methods, and one page for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from markupsafe import Markup

from ..catalogue.advice import ADVICE, SHORT, Advice
from ..catalogue.claims import (
    FINISHING_ORDER,
    G_SYMPLECTIC,
    GROWTH,
    NYSTROM_ORDER,
    ORDER,
    ORDER_IDENTITY,
    PARASITISM_FREE,
    SOLUTION,
    STARTING_ORDER,
    SYMMETRIC,
    SYMPLECTIC,
    stated_orders,
)
from ..catalogue.errata import find_errata, load_errata
from ..catalogue.files import names as shipped_names
from ..catalogue.lookup import document, load
from ..catalogue.reader import load_document
from ..method import Method
from ..views.bibtex import source_entry
from ..views.show import parts
from .markup import Column, Page, Site, Table, number, render, wrapped
from .measurements import title_of
from .runs import about, answer_of, tab_of
from .stability import stability
from .store import Record, Results, method_of
from .typeset import typeset, typeset_table

#: Classes of methods as a menu has them.
_CLASSES = {
    "rk": "Runge-Kutta", "composition": "compositions", "lmm": "linear multistep",
    "one-leg": "one-leg", "glm": "general linear", "sweep": "general linear, symmetric sweeps",
    "splitting": "splittings", "partitioned-rk": "partitioned Runge-Kutta",
    "partitioned": "partitioned general linear", "pair-sweep": "explicit pairs",
    "additive": "additive (IMEX)",
    "nystrom": "Runge-Kutta-Nystrom",
    "rosenbrock": "Rosenbrock",
}  # fmt: skip

_COLUMNS = (
    Column("method", "method"),
    Column("class", "class"),
    Column("order", "order"),
    Column("measured", "order seen"),
    Column("proof", "proof"),
    Column("stages", "stages"),
    Column("implicit", "implicit stages"),
    Column("values", "values carried"),
    Column("conserves", "G-symplectic"),
    Column("symmetric", "symmetric"),
    Column("free", "parasitism free"),
    Column("growth", "growth parameters"),
    Column("cost", "evaluations a step"),
    Column("verified", "claims that hold"),
)


def overview(site: Site, results: Results, names: Sequence[str], *, catalogue: bool) -> Page:
    """Return the first page: every run, and of the catalogue every method in one table."""
    table = None
    if catalogue:
        evaluations = _evaluations(results)
        cells = [_row(site, results, name, evaluations) for name in names]
        table = Table("methods", f"{len(cells)} methods", _COLUMNS, cells, sortable=True)
    runs = [(site.link(tab_of(run), about(run)[0]), about(run)[1], answer_of(run))
            for run in results.runs]  # fmt: skip
    measured = [
        (site.link(f"measured-{x}", x), title_of(x, doc))
        for x, doc in sorted(results.measurements.items())
    ]
    needs = [
        (one.need, [_taken(site, one, x) for x in one.take if x in names], one.why)
        for one in ADVICE
    ]
    body = render(
        "index.html",
        site=site,
        table=table,
        runs=runs,
        measured=measured,
        needs=[row for row in needs if row[1]] if catalogue else [],
        own=[site.link(f"method-{x}", x) for x in names if not is_shipped_name(x)],
        proved=_proved(results, names) if catalogue else None,
    )
    return Page("index", "Methods and proofs" if catalogue else "Results", body, "overview")


def _taken(site: Site, advice: Advice, name: str) -> str:
    """Return the link to a method that is recommended, with the steps up to which it is."""
    link = site.link(f"method-{name}", name)
    return link + f" (up to {SHORT:,} steps)" if advice.limited(name) else link


def _proved(results: Results, names: Sequence[str]) -> Mapping[str, Any]:
    """Return how many claims of shipped methods hold, and by which proof, as they are stored."""
    shipped = [name for name in names if is_shipped_name(name)]
    found = [
        x
        for name in shipped
        for x in _of_this_file(_document(results, name), results.findings.get(name, []))
    ]
    held = [x for x in found if x.get("verdict") == "holds"]
    errata = load_errata()
    return {
        "methods": len(shipped),
        "claims": len(found),
        "holds": len(held),
        "open": len(found) - len(held),
        "kinds": {k: sum(x.get("proof") == k for x in held) for k in ("exact", "enclosed")},
        "broken": len(shipped_names("broken")),
        "errata": len(errata),
        "wrong": sum(x.verdict != "right" for x in errata),
    }


def _row(site: Site, results: Results, name: str, evaluations: Mapping[str, float]) -> list[str]:
    doc = _document(results, name)
    claims, method = doc["claims"], _loaded(results, name)
    found = results.findings.get(name, [])
    proved = _of_this_file(doc, found)
    held = sum(x.get("verdict") == "holds" for x in proved)
    kept = claims.get(G_SYMPLECTIC.key, claims.get(SYMPLECTIC.key))
    growth = claims.get(GROWTH.key)
    stages, implicit, values = _sizes(method) if method else (None, None, None)
    return [
        site.link(f"method-{name}", name),
        doc["class"],
        number(stated_orders(claims).get(SOLUTION, claims.get(NYSTROM_ORDER.key))),
        number(_seen(results, name, ORDER.key) or _measured_order(found)),
        " and ".join(_proofs(proved)) or number(None),
        number(stages),
        number(implicit),
        number(values),
        number(kept),
        number(claims.get(SYMMETRIC.key)),
        number(claims.get(PARASITISM_FREE.key)),
        _listed(growth),
        number(evaluations.get(name)),
        f"{held} of {len(proved)}" if proved else number(None),
    ]


def _listed(values: Any) -> str:
    if not isinstance(values, list):
        return number(values)
    return Markup(", ").join(typeset(str(x)) for x in values) or "none"


def is_shipped_name(name: str) -> bool:
    """Return whether a method of this name comes with the data."""
    return name in _shipped_names()


@cache
def _shipped_names() -> frozenset[str]:
    return frozenset(shipped_names("methods"))


@cache
def _shipped(name: str) -> tuple[Record, Method]:
    return document(name), load(name)


def _document(results: Results, name: str) -> Record:
    """Return the file of a method, or what findings say of one whose file was not given."""
    if name in results.own:
        return results.own[name]
    if name in results.findings and not is_shipped_name(name):
        rows = results.findings[name]
        claims = {str(x.get("claim")): x.get("declared") for x in rows}
        return {"name": name, "class": "", "claims": claims}
    return _shipped(name)[0]


def _loaded(results: Results, name: str) -> Method | None:
    """Return the method, or nothing where its file was not given."""
    if name in results.own:
        return load_document(results.own[name])
    return _shipped(name)[1] if is_shipped_name(name) else None


def _sizes(method: Method) -> tuple[str, int, str]:
    """Return stages, implicit ones among them, and values carried."""
    stages, values = zip(*((len(c.A), len(c.V)) for c in method.carriers), strict=True)
    return " + ".join(map(str, stages)), len(method.implicit_stages), " + ".join(map(str, values))


def _proofs(found: Sequence[Record]) -> list[str]:
    kinds = {str(x.get("proof")) for x in found if x.get("verdict") == "holds"}
    return [kind for kind in ("exact", "enclosed", "measured") if kind in kinds]


def _of_this_file(doc: Record, found: Sequence[Record]) -> list[Record]:
    """Return findings about what the file claims now: one about another value is out of date."""
    declared = _declared(doc)
    return [
        x
        for x in found
        if str(x.get("claim")) in declared
        and x.get("declared", ...) in (..., declared[str(x["claim"])])
    ]


def _declared(doc: Record) -> Record:
    """Return the claims of a file, with the orders that its start and its finish declare."""
    kinds = {STARTING_ORDER.key: "starting", FINISHING_ORDER.key: "finishing"}
    orders = {key: doc.get(kind, {}).get("order") for key, kind in kinds.items()}
    more = {k: x for k, x in orders.items() if x is not None and k not in doc["claims"]}
    return {**doc["claims"], **more}


def _seen(results: Results, name: str, claim: str) -> Any:
    """Return the order that runs show, as it is stored.

    One with identity that is the order stands once.
    """
    found = results.observed(name)
    claims = _document(results, name)["claims"]
    if claim == ORDER_IDENTITY.key and claims.get(claim) == claims.get(ORDER.key):
        claim = ORDER.key
    return found.get(claim, {}).get("observed")


def _measured_order(found: Sequence[Record]) -> Any:
    """Return the order that the conformance suite measured: its ids begin with orderP/."""
    for finding in found:
        claim = str(finding.get("claim"))
        if claim.startswith("order") and "/" in claim and finding.get("verdict") == "holds":
            return finding.get("value")
    return None


def _evaluations(results: Results) -> dict[str, float]:
    """Return evaluations a step of the first completed run of each method."""
    found: dict[str, float] = {}
    for record in results.records:
        steps, spent = record.get("steps"), record.get("evaluations")
        whole = isinstance(steps, int) and isinstance(spent, int) and steps > 0
        if record.get("outcome") == "completed" and whole:
            found.setdefault(method_of(record), spent / steps)  # type: ignore[operator]
    return found


# --- one method ---------------------------------------------------------------------------------


def by_class(results: Results, names: Sequence[str]) -> list[str]:
    """Return names in the order of the menu: those of the user, then class by class."""
    ranks = {kind: k for k, kind in enumerate(_CLASSES)}

    def rank(name: str) -> int:
        own = not is_shipped_name(name)
        return -1 if own else ranks.get(_document(results, name)["class"], len(ranks))

    return sorted(names, key=rank)


def method_page(site: Site, results: Results, name: str) -> Page:
    """Write the page of one method: tableau, claims, start, source, records."""
    doc, method = _document(results, name), _loaded(results, name)
    blocks: Any = ()
    legend: Mapping[str, str] = {}
    if method is not None:
        drawn = parts(method, lambda grid: [typeset_table(grid)])  # type: ignore[arg-type,list-item]
        blocks, legend = drawn.blocks, drawn.legend
    found = results.findings.get(name, [])
    suite = [x for x in found if "/" in str(x.get("claim"))]
    errata = find_errata(method=name)
    counts = [(run, sum(method_of(x) == name for x in run.records)) for run in results.runs]
    body = render(
        "method.html",
        site=site,
        name=name,
        doc=doc,
        sizes=method and _sizes(method),
        blocks=blocks,
        legend=[(typeset(k), typeset(x)) for k, x in legend.items()],
        claims=_claims(doc, results),
        suite=suite and (sum(x.get("verdict") == "holds" for x in suite), len(suite)),
        verified=bool(_of_this_file(doc, found)),
        constants=_error_constants(name, results.constants(name)),
        stability=stability(name, results.regions.get(name)),
        portrait=Markup(results.portraits.get(name, "")),
        records=[(site.link(tab_of(run), run.name), count) for run, count in counts if count],
        source=doc.get("source") and {"doi": None, "errata": [], **doc["source"]},
        errata=errata,
        bibtex=source_entry(doc) if doc.get("source") else "",
    )
    kind = _CLASSES.get(doc["class"]) or str(doc["class"])
    if not is_shipped_name(name):
        kind = "your own"
    return Page(f"method-{name}", str(doc.get("title", name)), body, name, "methods", kind)


def _claims(doc: Record, results: Results) -> Table:
    """Return claims with their proofs and witnesses."""
    rows = [
        [
            claim, _listed(declared) if isinstance(declared, list) else number(declared),
            verdict, proof or number(None),
            number(_seen(results, doc["name"], claim)),
            number(finding.get("residual")), wrapped(str(finding.get("witness", ""))),
        ]
        for claim, declared, verdict, proof, finding in _found(doc, results)
    ]  # fmt: skip
    titles = {"seen": "seen in runs"}
    keys = ("claim", "declared", "verdict", "proof", "seen", "residual", "witness")
    columns = [Column(x, titles.get(x, x)) for x in keys]
    return Table("claims-" + doc["name"], "Claims", columns, rows)


def claimed(results: Results, name: str) -> list[tuple[str, Any, str, str]]:
    """Return the claims of a method, each with what it declares, its verdict and kind of proof."""
    return [row[:4] for row in _found(_document(results, name), results)]


def _found(doc: Record, results: Results) -> list[tuple[str, Any, str, str, Record]]:
    """Return the claims of a file: what each declares, verdict, kind of proof, and finding."""
    found = results.findings.get(doc["name"], [])
    known = {str(x.get("claim")): x for x in _of_this_file(doc, found)}
    rows = []
    for claim, declared in _declared(doc).items():
        finding = known.get(claim, {})
        verdict, proof = (str(finding.get(key, "")) for key in ("verdict", "proof"))
        rows.append((claim, declared, _verdict(verdict), proof, finding))
    return rows


def _error_constants(name: str, row: Record) -> list[tuple[str, Record, Table]]:
    """Return the largest residuals of the trees one order beyond, and all of them as one number."""
    found = {"": row, ", on second-order systems": row.get("nystrom")} if row else {}
    columns = [Column("tree", "tree"), Column("residual", "residual")]
    parts = []
    for n, (where, one) in enumerate(found.items()):
        if not isinstance(one, Mapping):
            continue
        largest = one.get("largest")
        cells = [
            [Markup("<code>{}</code>").format(x[0]), number(x[1])]
            for x in (largest if isinstance(largest, list) else ())
            if isinstance(x, list) and len(x) == 2
        ]
        table = Table(f"constants-{name}-{n}", "The largest residuals", columns, cells)
        told = {key: one.get(key) for key in ("order", "trees", "nonzero", "norm")}
        parts.append((where, told, table))
    return parts


def _verdict(word: str) -> str:
    return Markup('<span class="{0}">{0}</span>').format(word) if word else number(None)
