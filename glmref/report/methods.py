"""The overview of all methods, and one page for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from ..catalogue.claims import (
    FINISHING_ORDER,
    G_SYMPLECTIC,
    GROWTH,
    ORDER,
    ORDER_IDENTITY,
    PARASITISM_FREE,
    STARTING_ORDER,
    SYMMETRIC,
    SYMPLECTIC,
)
from ..catalogue.errata import find_errata
from ..catalogue.lookup import document, load
from ..method import GLM, PartitionedGLM
from ..views.bibtex import source_entry
from ..views.show import parts
from .markup import Column, Page, Site, Table, counted, escape, number, scrolling, wrapped
from .measurements import title_of
from .runs import answer_of, tab_of
from .stability import stability
from .store import Record, Results, method_of
from .typeset import typeset, typeset_table

__all__ = ["by_class", "method_page", "overview"]

#: Classes of methods as a menu has them.
_CLASSES = {
    "rk": "Runge-Kutta", "composition": "compositions", "lmm": "linear multistep",
    "one-leg": "one-leg", "glm": "general linear", "sweep": "general linear, symmetric sweeps",
    "splitting": "splittings", "partitioned-rk": "partitioned Runge-Kutta",
    "partitioned": "partitioned general linear", "pair-sweep": "explicit pairs",
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


def overview(site: Site, results: Results, names: Sequence[str]) -> Page:
    """Every method in one table that can be sorted and filtered."""
    evaluations = _evaluations(results)
    cells = [_row(site, results, name, evaluations) for name in names]
    table = Table("methods", f"{len(cells)} methods", _COLUMNS, cells, sortable=True)
    runs = "".join(
        f"<dt>{site.link(tab_of(run), run.name)}"
        f"<dd>{escape(answer_of(run)) or counted(len(run.records), 'record')}"
        for run in results.runs
    )
    runs += "".join(
        f"<dt>{site.link(f'measured-{x}', x)}<dd>{escape(title_of(x, doc))}"
        for x, doc in sorted(results.measurements.items())
    )
    body = (
        "<p>Methods whose every claim is true. <em>Order</em> is proved; <em>order seen</em> is "
        "what runs at smaller and smaller steps show; <em>proof</em> is how the claims are proved: "
        "exact (algebraic numbers), enclosed (an interval test within published digits) or "
        "measured. A dash: nothing is stored.</p>"
        f"{table.html()}"
        f"<h2>What was measured</h2>{f'<dl>{runs}</dl>' if runs else '<p>Nothing was given.</p>'}"
    )  # fmt: skip
    return Page("index", "Methods", body, "overview")


def _row(site: Site, results: Results, name: str, evaluations: Mapping[str, float]) -> list[str]:
    doc = _document(name)
    claims, method = doc["claims"], _loaded(name)
    found = results.findings.get(name, [])
    proved = _of_this_file(doc, found)
    held = sum(x.get("verdict") == "holds" for x in proved)
    kept = claims.get(G_SYMPLECTIC.key, claims.get(SYMPLECTIC.key))
    growth = claims.get(GROWTH.key)
    stages, implicit, values = _sizes(method)
    return [
        site.link(f"method-{name}", name),
        escape(doc["class"]),
        number(claims.get(ORDER.key)),
        number(_seen(results, name, ORDER.key) or _measured_order(found)),
        escape(" and ".join(_proofs(proved))) or number(None),
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
    return ", ".join(typeset(str(x)) for x in values) or "none"


@cache
def _document(name: str) -> Record:
    return document(name)


@cache
def _loaded(name: str) -> GLM | PartitionedGLM:
    return load(name)


def _sizes(method: GLM | PartitionedGLM) -> tuple[Any, Any, Any]:
    """Stages, implicit ones among them, values carried."""
    if isinstance(method, PartitionedGLM):
        blocks = [(i, j) for i, row in enumerate(method.A) for j, x in enumerate(row)]
        back = [(j, i) for j, row in enumerate(method.A_hat) for i, x in enumerate(row)]
        needs_p = {(i, j) for i, j in blocks if method.A[i][j].is_zero() is not True}
        needs_q = {(i, j) for j, i in back if method.A_hat[j][i].is_zero() is not True}
        implicit = _cyclic(method.n_Q, method.n_P, needs_p, needs_q)
        return f"{method.n_Q} + {method.n_P}", implicit, f"{method.r} + {method.r_hat}"
    return method.s, len(method.implicit_stages), method.r


def _cyclic(
    n_q: int, n_p: int, needs_p: set[tuple[int, int]], needs_q: set[tuple[int, int]]
) -> int:
    """Stages of a pair that are left when those that can be computed have been, one by one."""
    q, p = set(range(n_q)), set(range(n_p))
    while True:
        ready_q = {i for i in q if not any(a == i and j in p for a, j in needs_p)}
        ready_p = {j for j in p if not any(b == j and i in q for i, b in needs_q)}
        if not ready_q and not ready_p:
            return len(q) + len(p)
        q, p = q - ready_q, p - ready_p


def _proofs(found: Sequence[Record]) -> list[str]:
    kinds = {str(x.get("proof")) for x in found if x.get("verdict") == "holds"}
    return [kind for kind in ("exact", "enclosed", "measured") if kind in kinds]


def _of_this_file(doc: Record, found: Sequence[Record]) -> list[Record]:
    """Findings about what the file claims now: one about another value is out of date."""
    declared = _declared(doc)
    return [
        x
        for x in found
        if str(x.get("claim")) in declared
        and x.get("declared", ...) in (..., declared[str(x["claim"])])
    ]


def _declared(doc: Record) -> Record:
    """Claims of a file, with the orders that its starting and its finishing method declare."""
    kinds = {STARTING_ORDER.key: "starting", FINISHING_ORDER.key: "finishing"}
    orders = {key: doc.get(kind, {}).get("order") for key, kind in kinds.items()}
    more = {k: x for k, x in orders.items() if x is not None and k not in doc["claims"]}
    return {**doc["claims"], **more}


def _seen(results: Results, name: str, claim: str) -> Any:
    """Order that runs show, as it is stored; one with identity that is the order stands once."""
    found = results.observed(name)
    claims = _document(name)["claims"]
    if claim == ORDER_IDENTITY.key and claims.get(claim) == claims.get(ORDER.key):
        claim = ORDER.key
    return found.get(claim, {}).get("observed")


def _measured_order(found: Sequence[Record]) -> Any:
    """Order that the conformance suite measured: its ids begin with orderP/."""
    for finding in found:
        claim = str(finding.get("claim"))
        if claim.startswith("order") and "/" in claim and finding.get("verdict") == "holds":
            return finding.get("value")
    return None


def _evaluations(results: Results) -> dict[str, float]:
    """Evaluations a step of the first completed run of each method."""
    found: dict[str, float] = {}
    for record in results.records:
        steps, spent = record.get("steps"), record.get("evaluations")
        whole = isinstance(steps, int) and isinstance(spent, int) and steps > 0
        if record.get("outcome") == "completed" and whole:
            found.setdefault(method_of(record), spent / steps)  # type: ignore[operator]
    return found


# --- one method ---------------------------------------------------------------------------------


def by_class(names: Sequence[str]) -> list[str]:
    """Names in the order of the menu: class by class."""
    ranks = {kind: k for k, kind in enumerate(_CLASSES)}
    return sorted(names, key=lambda name: ranks.get(_document(name)["class"], len(ranks)))


def method_page(site: Site, results: Results, name: str) -> Page:
    """Page of one method: tableau, claims, start, source, records."""
    doc, method = _document(name), _loaded(name)
    drawn = parts(method, lambda grid: [typeset_table(grid)])  # type: ignore[arg-type,list-item]
    body = [
        f"<p><strong>{escape(name)}</strong>, class {escape(doc['class'])}: {_said(method)}</p>"
    ]
    body.append("<h2>Tableau</h2>")
    for heading, lines in drawn.blocks:
        body += [f"<h3>{escape(heading)}</h3>" if heading else "", *lines]
    if drawn.legend:
        rows = "".join(f"<dt>{typeset(k)}<dd>{typeset(x)}" for k, x in drawn.legend.items())
        body.append(f"<p>with</p>{scrolling(f'<dl>{rows}</dl>', 'constants')}")
    body += [_claims(doc, results), _error_constants(name, results.constants(name))]
    body.append(stability(name, results.regions.get(name)))
    body.append(_portrait(results, name))
    body += [_records(site, results, name), _source(site, doc)]
    text = "\n".join(x for x in body if x)
    kind = _CLASSES.get(doc["class"]) or str(doc["class"])
    return Page(f"method-{name}", str(doc.get("title", name)), text, name, "methods", kind)


def _said(method: GLM | PartitionedGLM) -> str:
    stages, implicit, values = _sizes(method)
    return f"stages {stages}, implicit ones {implicit}, values carried {values}"


def _claims(doc: Record, results: Results) -> str:
    """Claims with their proofs and witnesses; those of the conformance suite are counted."""
    found = results.findings.get(doc["name"], [])
    known = {str(x.get("claim")): x for x in _of_this_file(doc, found)}
    rows = []
    for claim, declared in _declared(doc).items():
        finding = known.get(claim, {})
        verdict = str(finding.get("verdict", ""))
        rows.append([
            escape(claim), _listed(declared) if isinstance(declared, list) else number(declared),
            _verdict(verdict),
            escape(str(finding.get("proof", ""))) or number(None),
            number(_seen(results, doc["name"], claim)),
            number(finding.get("residual")), wrapped(escape(str(finding.get("witness", "")))),
        ])  # fmt: skip
    titles = {"seen": "seen in runs"}
    keys = ("claim", "declared", "verdict", "proof", "seen", "residual", "witness")
    columns = [Column(x, titles.get(x, x)) for x in keys]
    text = Table("claims-" + doc["name"], "Claims", columns, rows).html()
    suite = [x for x in found if "/" in str(x.get("claim"))]
    if suite:
        held = sum(x.get("verdict") == "holds" for x in suite)
        text += f"<p>Conformance suite: {held} of {len(suite)} checks hold.</p>"
    if not known:
        text += "<p>No verdict is stored: <code>glmref verify --format json</code> writes them.</p>"
    return f"<h2>Claims</h2>{text}"


def _error_constants(name: str, row: Record) -> str:
    """The largest residuals of the trees one order beyond, and all of them as one number."""
    if not row:
        return ""
    found = {"": row, ", on second-order systems": row.get("nystrom")}
    parts = [
        _constants(f"constants-{name}-{n}", where, one)
        for n, (where, one) in enumerate(found.items())
        if isinstance(one, Mapping)
    ]
    return f"<h2>Error constants</h2>{''.join(parts)}"


def _constants(id_: str, where: str, found: Record) -> str:
    largest = found.get("largest")
    cells = [
        [f"<code>{escape(str(x[0]))}</code>", number(x[1])]
        for x in (largest if isinstance(largest, list) else ())
        if isinstance(x, list) and len(x) == 2
    ]
    told = (
        f"<p>Order {number(found.get('order'))}{where}. Trees one order beyond: "
        f"{number(found.get('trees'))}, with a residual: {number(found.get('nonzero'))}; "
        f"Euclidean norm of residual over symmetry: {number(found.get('norm'))}.</p>"
    )
    columns = [Column("tree", "tree"), Column("residual", "residual")]
    return told + (Table(id_, "The largest residuals", columns, cells).html() if cells else "")


def _verdict(word: str) -> str:
    return f'<span class="{escape(word)}">{escape(word)}</span>' if word else number(None)


def _portrait(results: Results, name: str) -> str:
    svg = results.portraits.get(name)
    return f'<h2>Portrait</h2><div class="portrait">{svg}</div>' if svg else ""


def _records(site: Site, results: Results, name: str) -> str:
    links = [
        f"<li>{site.link(tab_of(run), run.name)}: {counted(count, 'record')}"
        for run in results.runs
        if (count := sum(method_of(x) == name for x in run.records))
    ]
    return f"<h2>Measured in</h2><ul>{''.join(links)}</ul>" if links else ""


def _source(site: Site, doc: Record) -> str:
    source = doc["source"]
    doi = source.get("doi")
    cited = escape(f"{source['citation']}, {source['where']}")
    if doi:
        cited += f', <a href="https://doi.org/{escape(doi)}" rel="noreferrer">doi:{escape(doi)}</a>'
    remarks = "".join(f"<li>{escape(x)}" for x in source.get("errata", []))
    errata = find_errata(method=doc["name"])
    if errata:
        places = ", ".join(escape(x.where) for x in errata)
        remarks += f"<li>{site.link('errata', 'errata of the thesis')}: {places}"
    name = escape(doc["name"])
    data = (
        f'<p>Data: <a href="data/{name}.json" download>{name}.json</a></p>'
        if not site.single
        else ""
    )
    return (
        f"<h2>Source</h2><p>{cited} ({escape(source['status'])})</p>"
        f"{f'<ul>{remarks}</ul>' if remarks else ''}{data}"
        f"<details><summary>BibTeX</summary><pre>{escape(source_entry(doc))}</pre></details>"
    )
