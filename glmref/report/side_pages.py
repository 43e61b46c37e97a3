"""Pages beside methods and runs: errata, benchmark history, how it was measured."""

from __future__ import annotations

import json
from collections.abc import Mapping

from markupsafe import Markup

from ..catalogue.errata import VERDICTS, load_errata
from ..views.tables import counted
from .markup import Column, Figure, Page, Site, Table, number, render
from .store import Results


def errata_page(site: Site, names: frozenset[str]) -> Page:
    """Return what the thesis prints beside what is right."""
    records = load_errata()
    counts = ", ".join(f"{sum(x.verdict == v for x in records)} {v}" for v in VERDICTS)
    cells = [
        [
            x.where, x.printed, x.right,
            Markup('<span class="{0}">{0}</span>').format(x.verdict), x.proof,
            Markup(", ").join(site.link(f"method-{m}", m) if m in names else m for m in x.method),
        ]
        for x in records
    ]  # fmt: skip
    titles = ("where", "printed", "right", "verdict", "proof", "data")
    table = Table("errata", f"{len(cells)} statements", [Column(x, x) for x in titles], cells, True)
    body = render("errata.html", counts=counts, table=table)
    return Page("errata", "Errata of the thesis", body, "errata")


# --- benchmarks ---------------------------------------------------------------------------------


def history_page(results: Results) -> Page:
    """asv's results: error beside time, commit by commit."""
    benchmarks = []
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
                ", ".join(x.parameters.get(t, "") for t in titles) or home,
                number(commits.index(x.commit) + 1), x.commit[:8], x.date[:10],
                *(number(x.values.get(f)) for f in functions),
            ]
            for x in cells
        ]  # fmt: skip
        table = Table(f"b{index}", f"{counted(len(rows), 'measurement')} of {home}", columns, rows)
        figures = [
            Figure(
                table.id, ["number"], functions, f"history of {home}",
                "Against the number of the commit, oldest first.", "series",
            )
        ]  # fmt: skip
        times = [f for f in functions if f.startswith("time")]
        errors = [f for f in functions if f.startswith("track") and "error" in f]
        if times and errors:
            figures.append(
                Figure(
                    table.id, times, errors, f"error against time, {home}",
                    "Error against run time, every commit.", "series",
                )
            )  # fmt: skip
        benchmarks.append((home, figures, table))
    pictures = tuple(x.lines_of(table) for _, figures, table in benchmarks for x in figures)
    body = render("history.html", benchmarks=benchmarks)
    return Page("history", "Benchmarks", body, "benchmarks", pictures=pictures)


# --- how it was measured ------------------------------------------------------------------------


def measured_page(results: Results, version: str) -> Page:
    """Machines, versions, files, and what could not be shown."""
    places: dict[str, int] = {}
    for record in results.records:
        where = record.get("where")
        said = json.dumps(where if isinstance(where, Mapping) else {}, sort_keys=True)
        places[said] = places.get(said, 0) + 1
    body = render(
        "measured.html",
        version=version,
        machines=[(json.loads(text), count) for text, count in places.items()],
        commits=list(dict.fromkeys((x.commit, x.machine, x.python) for x in results.benchmarks)),
        files=results.files,
        odd=results.odd,
    )
    return Page("measured", "How it was measured", body, "how measured")
