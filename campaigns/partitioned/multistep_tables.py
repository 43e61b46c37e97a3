"""The tables of docs/multivalue.md and campaigns/partitioned/multistep.md."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from campaigns import world
from campaigns.pages import ROOT, Pages, markdown, measured
from campaigns.partitioned import error_front, held_out, multistep


def multistep_shipped() -> str:
    """Return what to know of each shipped multistep method."""
    names = ("multistep-long", "multistep-growth", "multistep-resonances")
    return multistep.shipped_table({x: measured(x) for x in names})


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


PAGES: Pages = {
    ROOT / "docs" / "multivalue.md": {
        "held-out-answer": long_answer,
        "multistep-shipped": multistep_shipped,
    },
    ROOT / "campaigns" / "partitioned" / "multistep.md": {
        "multistep-1e-09": lambda: multistep.table(measured("multistep"), "1e-09"),
        "multistep-1e-06": lambda: multistep.table(measured("multistep"), "1e-06"),
        "multistep-means": lambda: multistep.mean_table(measured("multistep")),
        "multistep-long": lambda: multistep.long_table(measured("multistep-long")),
        "multistep-growth": lambda: growth_table(measured("multistep-growth")),
        "multistep-front": lambda: front_table(measured("multistep-front")),
        "error-front": lambda: error_front.table(measured("error-front")),
        "world": lambda: world.table(measured("world")),
        "held-out-summary": lambda: held_out.summary(measured("held-out")),
        "held-out-singles": lambda: held_out.singles(measured("held-out")),
        "held-out-long": lambda: held_out.table(measured("held-out"), "energy"),
        "held-out-short": lambda: held_out.table(measured("held-out"), "state"),
    },
}
