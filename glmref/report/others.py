"""Pages beside methods and runs: errata, benchmark history, how it was measured."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from ..catalogue.errata import VERDICTS, load_errata
from .markup import Column, Page, Site, Table, counted, escape, figure, flat, number
from .store import Results

_WRITERS = """<h2>What writes what</h2><dl>
<dt>records<dd><code>glmref run --all</code>
<dt>verdicts<dd><code>glmref verify --format json &gt; report/findings.json</code>; those of the
shipped methods come with the data
<dt>orders seen in runs, stability regions<dd>come with the data, see their pages and
<code>data/README.md</code>
<dt>orders measured<dd><code>python -m glmref.conformance compiled --format json &gt;
report/conformance.json</code>
<dt>portraits<dd><code>glmref show NAME --plot report/NAME.svg</code>
<dt>benchmarks<dd><code>glmref bench</code></dl>"""

__all__ = ["errata_page", "history_page", "measured_page"]


def errata_page(site: Site, names: frozenset[str]) -> Page:
    """What the thesis prints beside what is right."""
    records = load_errata()
    counts = ", ".join(f"{sum(x.verdict == v for x in records)} {v}" for v in VERDICTS)
    cells = [
        [
            escape(x.where), escape(x.printed), escape(x.right),
            f'<span class="{x.verdict}">{x.verdict}</span>', escape(x.proof),
            ", ".join(site.link(f"method-{m}", m) if m in names else escape(m) for m in x.method),
        ]
        for x in records
    ]  # fmt: skip
    titles = ("where", "printed", "right", "verdict", "proof", "data")
    table = Table("errata", f"{len(cells)} statements", [Column(x, x) for x in titles], cells, True)
    body = (
        "<p>Statements of Khan, G-symplectic partitioned general linear methods for Hamiltonian "
        f"systems (2018), each with what became of it: {counts}. Every verdict that can be "
        f'computed has a test.</p><div class="errata">{table.html()}</div>'
    )
    return Page("errata", "Errata of the thesis", body, "errata")


# --- benchmarks ---------------------------------------------------------------------------------


def history_page(results: Results) -> Page:
    """asv's results: error beside time, commit by commit."""
    parts = []
    for index, home in enumerate(dict.fromkeys(x.benchmark for x in results.benchmarks)):
        cells = [x for x in results.benchmarks if x.benchmark == home]
        titles = list(dict.fromkeys(name for x in cells for name in x.parameters))
        functions = list(dict.fromkeys(f for x in cells for f in x.values))
        commits = list(dict.fromkeys(x.commit for x in cells))
        columns = [
            Column("series", "benchmark"),
            Column("number", "number of the commit", linear=True),
        ]
        columns += [Column("commit", "commit"), Column("date", "date")]
        columns += [Column(f, f, "s" if f.startswith("time") else "") for f in functions]
        rows = [
            [
                escape(", ".join(x.parameters.get(t, "") for t in titles) or home),
                number(commits.index(x.commit) + 1), escape(x.commit[:8]), escape(x.date[:10]),
                *(number(x.values.get(f)) for f in functions),
            ]
            for x in cells
        ]  # fmt: skip
        table = Table(f"b{index}", f"{counted(len(rows), 'measurement')} of {home}", columns, rows)
        pictures = figure(
            table.id, ["number"], functions, f"history of {home}",
            "Against the number of the commit, oldest first.", "series",
        )  # fmt: skip
        times = [f for f in functions if f.startswith("time")]
        errors = [f for f in functions if f.startswith("track") and "error" in f]
        if times and errors:
            pictures += figure(
                table.id, times, errors, f"error against time, {home}",
                "Error against run time, every commit.", "series",
            )  # fmt: skip
        parts.append(f"<h2>{escape(home)}</h2>{pictures}{table.html()}")
    said = (
        "<p>From the result files of asv (airspeed velocity), written by <code>glmref bench</code>."
        " asv's own pages load scripts from the network and are left out.</p>"
    )
    none = "<p>No result of asv was given: <code>glmref bench</code> writes them.</p>"
    return Page("history", "Benchmarks", said + ("".join(parts) or none), "benchmarks")


# --- how it was measured ------------------------------------------------------------------------


def measured_page(results: Results, version: str) -> Page:
    """Machines, versions, files, and what could not be shown."""
    places: dict[str, int] = {}
    for record in results.records:
        where = record.get("where")
        said = json.dumps(where if isinstance(where, Mapping) else {}, sort_keys=True)
        places[said] = places.get(said, 0) + 1
    machines = "".join(_machine(json.loads(text), count) for text, count in places.items())
    commits = list(dict.fromkeys((x.commit, x.machine, x.python) for x in results.benchmarks))
    benches = "".join(
        f"<li>{escape(c[:8])} on {escape(m)}, Python {escape(p)}" for c, m, p in commits
    )
    files = "".join(f"<li>{escape(name)}: {escape(what)}" for name, what in results.files)
    odd = "".join(f"<li>{escape(x.where)}: {escape(x.why)}" for x in results.odd)
    body = (
        f"<p>Pages made by glmref {escape(version)} from stored results; nothing was computed for "
        "them. Numbers are rounded to six digits.</p>"
        f"<h2>Machines</h2>{machines or '<p>No record says where it was measured.</p>'}"
        f"{f'<h2>Commits of the benchmarks</h2><ul>{benches}</ul>' if benches else ''}"
        f"<h2>Files</h2>{f'<ul>{files}</ul>' if files else '<p>None.</p>'}"
        f"{_WRITERS}<h2>Not shown: {len(results.odd)}</h2>"
        f"{f'<ul>{odd}</ul>' if odd else '<p>Everything that was given is shown.</p>'}"
    )
    return Page("measured", "How it was measured", body, "how measured")


def _machine(where: Mapping[str, Any], count: int) -> str:
    rows = "".join(f"<dt>{escape(str(k))}<dd>{flat(x)}" for k, x in where.items())
    return f"<h3>{counted(count, 'record')}</h3><dl>{rows}</dl>"
