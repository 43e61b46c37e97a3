"""The tables of docs/multivalue.md and campaigns/partitioned/multistep.md."""

import math
from collections import Counter
from collections.abc import Mapping
from typing import Any

from campaigns.pages import ROOT, Pages, markdown, measured
from campaigns.partitioned import error_front, held_out
from campaigns.partitioned.tables import shown_error
from campaigns.partitioned.work import mean, needed
from glmref.catalogue.lookup import load
from glmref.derive.recipes.multistep import SHIPPED
from glmref.method import PartitionedGLM


def evaluations_table(document: Mapping[str, Any], tolerance: str) -> str:
    """Return the best of each group, case by case, in Markdown.

    The last line holds geometric means.
    """
    groups = document["groups"]
    rivals = [x for key, methods in groups.items() if not key.startswith("new") for x in methods]
    new = [x for key, methods in groups.items() if key.startswith("new") for x in methods]
    head = ["case", *(f"best {key}" for key in groups), "new / best other"]
    rows: list[list[str]] = []
    ratios: list[float] = []
    for entry in document["cases"]:
        cells = [entry["case"]]
        for methods in groups.values():
            name, found = needed(entry, methods, tolerance)
            cells.append(f"{found:,.0f} ({name})" if math.isfinite(found) else "-")
        mine, theirs = (needed(entry, x, tolerance)[1] for x in (new, rivals))
        if math.isfinite(mine) and math.isfinite(theirs):
            ratios.append(mine / theirs)
        cells.append(f"{mine / theirs:.2f}" if math.isfinite(mine) else "-")
        rows.append(cells)
    rows.append(["geometric mean", *[""] * len(groups), f"{mean(ratios):.2f}"])
    return markdown(head, rows)


#: Method in whose evaluations :func:`mean_table` counts.
UNIT = "quinlan-tremaine-10"


def mean_table(document: Mapping[str, Any]) -> str:
    """Return method against method: evaluations in units of :data:`UNIT`, in Markdown.

    Geometric means over the second-order problems, and over those with a long horizon.
    """
    cases = [x for x in document["cases"] if x["case"] != "lotka-volterra"]
    long = [x for x in cases if x["case"].endswith("-long")]
    groups = ((cases, "cases"), (long, "long cases"))
    columns = [(t, some, word) for t in ("1e-06", "1e-09") for some, word in groups]
    heads = [f"$10^{{{int(t[2:])}}}$, {len(some)} {word}" for t, some, word in columns]
    rows = []
    for group in ("published multistep", "new, second-order"):
        for name in document["groups"][group]:
            cells = [f"`{name}`"]
            for tolerance, some, _ in columns:
                shares = [
                    needed(x, [name], tolerance)[1] / needed(x, [UNIT], tolerance)[1] for x in some
                ]
                cells.append(f"{mean(shares):.2f}")
            rows.append(cells)
    return markdown(["method", *heads], rows)


#: Steps between the new starts of the runs that were restarted.
RESTARTED = 10_000


def _cause(run: Mapping[str, Any]) -> str:
    """Return whether a run is bounded.

    Else from when on it is not, and what starting anew changes.
    """
    if run["bounded"]:
        return "yes"
    marks, energy = run["marks"], [math.inf if x is None else x for x in run["energy"]]
    first = energy[-3]
    grown = next((n for n, e in zip(marks, energy, strict=True) if e > 10 * first), None)
    if grown is None:
        return "no: the carried values grow"
    text = f"no: grown tenfold within {grown * run['h']:.3g} time units"
    if "restarted" not in run:
        return text
    new = run["restarted"][-1]
    cured = new is not None and new <= 10 * run["restarted"][-3]
    return f"{text}; started again every {RESTARTED:,} steps " + (
        f"{new:.1e}" if cured else "it grows too: the step is too long"
    )


def long_table(document: Mapping[str, Any]) -> str:
    """Return energy errors after 10^5, 10^6 and 10^7 steps and the time of a step, in Markdown."""
    heads, rows = "method, problem, h, $10^5$, $10^6$, $10^7$, ns a step, bounded", []
    for run in document["runs"]:
        what = ", ".join([run["problem"], *(f"{k} = {v}" for k, v in run["parameters"].items())])
        cells = [*map(shown_error, run["energy"][-3:])]
        cells += ["-" if run["ns"] is None else f"{run['ns']:.0f}", _cause(run)]
        rows.append([f"`{run['method']}`", what, f"{run['h']:g}", *cells])
    return markdown(heads.split(", "), rows)


def multistep_shipped() -> str:
    """Return what to know of each shipped multistep method, in Markdown."""
    rows, long = [], measured("multistep-long")["runs"]
    first = {
        x["method"]: x["ranges"][0][0]
        for x in measured("multistep-growth")["scans"]
        if x["orbit"].startswith("Kepler")
    } | {
        x["method"]: x["holes"][0]
        for x in measured("multistep-resonances")["scans"]
        if x["problem"] == "kepler"
    }
    for name, shipped in SHIPPED.items():
        method = load(name)
        assert isinstance(method, PartitionedGLM)
        order = method.claims["order"] if shipped.q else method.claims["nystrom-order"]
        values = len(method.V) + len(method.V_hat)
        runs = [x["bounded"] for x in long if x["method"] == name]
        cells = ["separable" if shipped.q else "second order", order, values]
        cells += [2 if shipped.slopes else 1, f"{first[name]:g}", f"{sum(runs)} of {len(runs)}"]
        rows.append([f"`{name}`", *cells])
    heads = "method, systems, order, values, kicks a step, first resonance, bounded"
    return markdown(heads.split(", "), rows)


def long_answer() -> str:
    """Return the rows of the summary of held-out problems over long horizons."""
    lines = held_out.summary(measured("held-out")).splitlines()
    return "\n".join([*lines[:2], *(x for x in lines if "| long |" in x)])


def growth_table(document: Mapping[str, Any]) -> str:
    """Return where methods grow, in Markdown."""
    heads = "method, orbit, end of the interval, step sizes with growth, first, the widest"
    rows = []
    for x in document["scans"]:
        widest = sorted(sorted(x["ranges"], key=lambda r: r[0] - r[1])[:3])
        shown = ", ".join(f"{a:g} to {b:g}" if a < b else f"{a:g}" for a, b in widest) or "none"
        first = f"{x['ranges'][0][0]:g}" if x["ranges"] else "-"
        marked = f"{x['marked']:,} of {x['sizes']:,}"
        rows.append([f"`{x['method']}`", x["orbit"], f"{x['end']:g}", marked, first, shown])
    return markdown(heads.split(", "), rows)


def front_table(document: Mapping[str, Any]) -> str:
    """Return the front in Markdown; on held-out problems over the best published method of each."""
    heads = (
        "method, kicks, pairs, interval, reach, at $10^{-6}$, at $10^{-9}$, "
        "held out: $10^{-6}$, $10^{-9}$, growth"
    )
    rows = []
    published = [x["held out"] for x in document["methods"] if x["method"].startswith("quinlan")]
    for x in document["methods"]:
        shares = [
            math.exp(
                math.fsum(
                    math.log(row[key] / min(other[case][key] for other in published))
                    for case, row in x["held out"].items()
                )
                / len(x["held out"])
            )
            for key in x["evaluations"]
        ]
        rows.append(
            [
                *(x["method"], x["kicks"], x["pairs"]),
                *(f"{x[key]:.2f}" for key in ("interval", "reach")),
                *(f"{n:,}" for n in x["evaluations"].values()),
                *(f"{share:.2f}" for share in shares),
                f"{x['growth']:g}",
            ]
        )
    return markdown(heads.split(", "), rows)


def _fastest(rows: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the row of the least time."""
    return min(rows, key=lambda x: math.inf if x["seconds"] is None else x["seconds"])


def winners(document: Mapping[str, Any]) -> dict[str, int]:
    """Count in how many cases each is the fastest."""
    return dict(Counter(_fastest(entry["methods"])["method"] for entry in document["cases"]))


def world_table(document: Mapping[str, Any]) -> str:
    """Tabulate milliseconds, in brackets evaluations; the fastest of a case is bold."""
    names = list(dict.fromkeys(x["method"] for c in document["cases"] for x in c["methods"]))
    rows = []
    for entry in document["cases"]:
        known, best = {x["method"]: x for x in entry["methods"]}, _fastest(entry["methods"])
        cells = [entry["case"]]
        for name in names:
            row = known.get(name)
            if row is None or row["seconds"] is None:
                cells.append("-" if row is None else "not reached")
                continue
            shown = f"{1e3 * row['seconds']:.3g}"
            count = f" ({row['evaluations']:,})" if row["evaluations"] else ""
            cells.append((f"**{shown}**" if row is best else shown) + count)
        rows.append(cells)
    return markdown(["case", *names], rows)


PAGES: Pages = {
    ROOT / "docs" / "multivalue.md": {
        "held-out-answer": long_answer,
        "multistep-shipped": multistep_shipped,
    },
    ROOT / "campaigns" / "partitioned" / "multistep.md": {
        "multistep-1e-09": lambda: evaluations_table(measured("multistep"), "1e-09"),
        "multistep-1e-06": lambda: evaluations_table(measured("multistep"), "1e-06"),
        "multistep-means": lambda: mean_table(measured("multistep")),
        "multistep-long": lambda: long_table(measured("multistep-long")),
        "multistep-growth": lambda: growth_table(measured("multistep-growth")),
        "multistep-front": lambda: front_table(measured("multistep-front")),
        "error-front": lambda: error_front.table(measured("error-front")),
        "world": lambda: world_table(measured("world")),
        "held-out-summary": lambda: held_out.summary(measured("held-out")),
        "held-out-singles": lambda: held_out.singles(measured("held-out")),
        "held-out-long": lambda: held_out.table(measured("held-out"), "energy"),
        "held-out-short": lambda: held_out.table(measured("held-out"), "state"),
    },
}
