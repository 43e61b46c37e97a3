"""The tables of docs/multivalue.md and campaigns/partitioned/multistep.md."""

from __future__ import annotations

from campaigns import world
from campaigns.pages import ROOT, Pages, measured
from campaigns.partitioned import error_front, held_out, multistep, stages_search


def multistep_shipped() -> str:
    """Return what to know of each shipped multistep method."""
    names = ("multistep-long", "multistep-growth", "multistep-resonances")
    return multistep.shipped_table({x: measured(x) for x in names})


def long_answer() -> str:
    """Return the rows of the summary of held-out problems over long horizons."""
    lines = held_out.summary(measured("held-out")).splitlines()
    return "\n".join([*lines[:2], *(x for x in lines if "| long |" in x)])


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
        "multistep-growth": lambda: stages_search.growth_table(measured("multistep-growth")),
        "multistep-front": lambda: stages_search.front_table(measured("multistep-front")),
        "error-front": lambda: error_front.table(measured("error-front")),
        "world": lambda: world.table(measured("world")),
        "held-out-summary": lambda: held_out.summary(measured("held-out")),
        "held-out-singles": lambda: held_out.singles(measured("held-out")),
        "held-out-long": lambda: held_out.table(measured("held-out"), "energy"),
        "held-out-short": lambda: held_out.table(measured("held-out"), "state"),
    },
}
