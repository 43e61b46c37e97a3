"""Tables of the engine's speed in tools/measure, docs/engine.md and campaigns/partitioned."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from campaigns.pages import ROOT, Pages, markdown, measured

Row = Mapping[str, Any]


def against_c(rows: list[Row], comparison: str) -> str:
    """Return one line for each method and problem of a comparison with C."""
    head = (
        "problem", "method", "evaluations", "C, ns", "at", "engine, ns", "C / engine (quartiles)",
        "same bits", "contracted C / fused engine", "engine / forces", "reference / engine",
    )  # fmt: skip
    body = []
    for row in (x for x in rows if x["comparison"] == comparison):
        low, median, high = row["c_over_engine"]
        body.append(
            (
                row["problem"], row["method"], f"{row['evaluations']:.2f}",
                f"{row['nanoseconds']['c'][1]:.4g}", f"`{row['level']}`",
                f"{row['nanoseconds']['engine'][1]:.4g}",
                f"**{median:.2f}** ({low:.2f} to {high:.2f})", "yes" if row["same_bits"] else "no",
                f"{row['contracted_over_fused'][1]:.2f}", f"{row['engine_over_force']:.2f}",
                f"{row['reference_over_engine']:.0f}",
            )
        )  # fmt: skip
    return markdown(head, body)


def steps(rows: list[Row]) -> str:
    """Return methods of every kind against C."""
    return against_c(rows, "c")


def sweeps(rows: list[Row]) -> str:
    """Return explicit pairs and splittings against C."""
    return against_c(rows, "sweep")


def lanes(rows: list[Row]) -> str:
    """Return one line for each method and problem of the ensembles."""
    head = ("problem", "method", "lanes in a block", "one by one, ns", "in lanes, ns", "gain")
    body = [
        (
            row["problem"], row["method"], row["width"], f"{row['nanoseconds']['single'][1]:.4g}",
            f"{row['nanoseconds']['lanes'][1]:.3g}", f"**{row['gain']:.1f}**",
        )
        for row in rows
        if row["comparison"] == "lanes"
    ]  # fmt: skip
    return markdown(head, body)


def kepler(rows: list[Row]) -> str:
    """Return one line for each integrator, the goals side by side."""
    mine = [row for row in rows if row["comparison"] == "kepler"]
    goals = sorted({row["goal"] for row in mine}, reverse=True)
    head, body = ["integrator"], []
    for goal in goals:
        head += [f"{goal:.0e}: steps per period", "ms", "over heyoka"]
    found = {(row["name"], row["goal"]): row for row in mine}
    for name in dict.fromkeys(row["name"] for row in mine):
        line: list[object] = [name]
        for goal in goals:
            row = found.get((name, goal))
            if row is None:
                line += ["", "", ""]
            elif not row["milliseconds"]:
                line += [f"not reached: {row['error']:.0e}", "", ""]
            else:
                time = row["milliseconds"][1]
                peer = found["heyoka", goal]["milliseconds"][1]
                setting = row["setting"]
                text = f"{setting:.0f}" if setting > 1 else f"tolerance {setting:.0e}"
                line += [text, f"{time:.4g}", f"**{time / peer:.2f}**"]
        body.append(line)
    return markdown(head, body)


def kepler_in_short(rows: list[Row]) -> str:
    """Return milliseconds of the integrators of :data:`SHORT`, and their ratio to heyoka's."""
    goals = sorted({x["goal"] for x in rows if x["comparison"] == "kepler"}, reverse=True)
    found = {(x["name"], x["goal"]): x for x in rows if x["comparison"] == "kepler"}
    head, body = ["integrator"], []
    for goal in goals:
        head += [f"{goal:.0e}: ms", "over heyoka"]
    for name in SHORT:
        line = [name]
        for goal in goals:
            times = found[name, goal]["milliseconds"] if (name, goal) in found else []
            peer = found["heyoka", goal]["milliseconds"][1]
            line += [f"{times[1]:.4g}", f"{times[1] / peer:.2f}"] if times else ["", ""]
        body.append(line)
    return markdown(head, body)


def against_c_in_short(rows: list[Row]) -> str:
    """Return the time of C over that of the engine for pairs and splittings, by problem."""
    mine = {(x["method"], x["problem"]): x for x in rows if x["comparison"] == "sweep"}
    problems = list(dict.fromkeys(problem for _, problem in mine))
    body = [
        [method, *(f"{mine[method, problem]['c_over_engine'][1]:.2f}" for problem in problems)]
        for method in dict.fromkeys(method for method, _ in mine)
    ]
    return markdown(["method", *problems], body)


#: Integrators in the table of docs/engine.md.
SHORT = (
    "gauss-4", "gauss-5", "gauss-6", "gauss-8", "kahan-li-8", "blanes-moan-rkn-6-14",
    "pair-rkn-6-9", "g6245", "order8-s5-w3", "s4-symmetric", "heyoka", "scipy DOP853",
)  # fmt: skip
NOTES, PAGE, PAIR_PAGE = (
    ROOT / x
    for x in ("tools/measure/README.md", "docs/engine.md", "campaigns/partitioned/README.md")
)


def _stored(write: Callable[[list[Row]], str]) -> str:
    return write(measured("engine")["rows"])


#: What is printed, by its name in tools/measure/README.md.
TABLES = {"steps": steps, "sweeps": sweeps, "lanes": lanes, "kepler": kepler}
#: Page -> name of a table -> what writes it.
PAGES: Pages = {
    NOTES: {name: partial(_stored, write) for name, write in TABLES.items()},
    PAGE: {"kepler-short": partial(_stored, kepler_in_short)},
    PAIR_PAGE: {"against-c": partial(_stored, against_c_in_short)},
}
