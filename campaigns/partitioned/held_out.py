"""Multistep methods against pairs and splittings on forty problems that nobody trained on.

Each problem of ``held_out_problems.json`` over two horizons: the error of the last state over the
short one, the largest error of the energy in 64 samples over the long one. The study is closed:
the records name the commit and the command that measured them.
"""

import math
from collections.abc import Mapping, Sequence
from itertools import chain
from typing import Any

from campaigns.pages import markdown
from campaigns.partitioned.error_front import SYMMETRIC
from campaigns.partitioned.work import mean, needed, quadratic

TOLERANCES = ("1e-06", "1e-09")
NYSTROM = "Runge-Kutta-Nyström"
#: What is compared, by group and by whether T is quadratic.
GROUPS: Mapping[bool, Mapping[str, Sequence[str]]] = {
    True: {
        "splitting": (
            *("blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14", "kahan-li-8"),
            "blanes-casas-rkn-8-19",
        ),
        "pair": ("pair-rkn-6-7b", "pair-rkn-6-8b"),
        NYSTROM: ("dormand-prince-rkn-12-10",),
        "published multistep": SYMMETRIC,
        "new": (
            *("multistep-rkn-8", "multistep-rkn-10", "multistep-rkn-12"),
            *("multivalue-rkn-10", "multivalue-rkn-12"),
        ),
    },
    False: {
        "splitting": ("blanes-moan-6", "kahan-li-8", "mclachlan-ss17-8", "sofroniou-spaletta-8-21"),
        "pair": ("pair-6-8", "pair-8-24"),
        NYSTROM: (),
        "published multistep": (),
        "new": ("multistep-8", "multistep-10"),
    },
}


def best(
    entry: Mapping[str, Any], group: str, tolerance: str, what: str = "needed"
) -> tuple[str, float]:
    """Return the method of a group that needs least in a case, and how much; infinity: none."""
    return needed(entry, GROUPS[quadratic(entry["case"])][group], tolerance, what)


def ratio(entry: Mapping[str, Any], other: str, tolerance: str, what: str = "needed") -> float:
    """Return the best new method over the best of another group; NaN where one of both has none."""
    mine, theirs = (best(entry, x, tolerance, what)[1] for x in ("new", other))
    return mine / theirs if math.isfinite(mine) and math.isfinite(theirs) else math.nan


def _shown(values: Sequence[float]) -> str:
    known = [x for x in values if math.isfinite(x)]
    wins = sum(x < 1 for x in known)
    return f"{mean(known):.2f} ({wins} of {len(known)})" if known else "-"


def _two_digits(x: float) -> str:
    return f"{x:.2f}" if math.isfinite(x) else "-"


def _horizon(document: Mapping[str, Any], measure: str, *, second: bool) -> list[dict[str, Any]]:
    return [
        x for x in document["cases"] if x["measure"] == measure and quadratic(x["case"]) == second
    ]


def summary(document: Mapping[str, Any]) -> str:
    """Return the geometric means of the best new method over the best of each group, in Markdown.

    In brackets in how many cases the new one needs less.
    """
    heads = "T, horizon, what, new / published multistep, new / splitting, new / pair, new / RKN"
    rows = []
    kinds: Sequence[tuple[str, str, str]] = (
        ("evaluations, $10^{-6}$", "1e-06", "needed"),
        ("evaluations, $10^{-9}$", "1e-09", "needed"),
        ("time, $10^{-9}$", "1e-09", "seconds"),
    )
    for second in (True, False):
        for measure, horizon in (("state", "short"), ("energy", "long")):
            cases = _horizon(document, measure, second=second)
            for words, tolerance, what in kinds:
                cells = [
                    _shown([ratio(x, other, tolerance, what) for x in cases])
                    for other in ("published multistep", "splitting", "pair", NYSTROM)
                ]
                kind = "quadratic" if second else "other"
                rows.append([kind, horizon, words, *cells])
    return markdown(heads.split(", "), rows)


def singles(document: Mapping[str, Any]) -> str:
    """Tabulate one method for all problems with quadratic T over the best published multistep.

    Of each case, geometric means, with the number of cases in which the method reaches the
    tolerance; in Markdown.
    """
    columns = [(measure, tolerance) for measure in ("state", "energy") for tolerance in TOLERANCES]
    names = {"state": "short", "energy": "long"}
    heads = [f"{names[m]}, $10^{{{int(t[2:])}}}$" for m, t in columns]
    rows = []
    for name in chain.from_iterable(GROUPS[True].values()):
        cells = [f"`{name}`"]
        for measure, tolerance in columns:
            shares = []
            for entry in _horizon(document, measure, second=True):
                counts = {x["method"]: x["needed"].get(tolerance) for x in entry["methods"]}
                unit = best(entry, "published multistep", tolerance)[1]
                if counts.get(name) and math.isfinite(unit):
                    shares.append(counts[name] / unit)
            cells.append(f"{mean(shares):.2f} ({len(shares)})" if shares else "-")
        rows.append(cells)
    return markdown(["method", *heads], rows)


def table(document: Mapping[str, Any], measure: str) -> str:
    """Tabulate all cases of a horizon: evaluations at 1e-9 by group, ratios, the fastest."""
    heads = (
        "problem, best splitting, best pair, Nyström, best published multistep, best new, "
        "new / multistep, new / splitting, the same at $10^{-6}$, fastest"
    )
    rows = []
    for entry in document["cases"]:
        if entry["measure"] != measure:
            continue
        cells = [entry["case"].removesuffix(", long")]
        for group in ("splitting", "pair", NYSTROM, "published multistep", "new"):
            name, count = best(entry, group, "1e-09")
            cells.append(f"{count:,.0f} ({name})" if math.isfinite(count) else "-")
        others = ("published multistep", "splitting")
        cells += [_two_digits(ratio(entry, x, "1e-09")) for x in others]
        cells.append(", ".join(_two_digits(ratio(entry, x, "1e-06")) for x in others))
        times = {x["method"]: x.get("seconds", {}).get("1e-09", math.inf) for x in entry["methods"]}
        fastest = min(times, key=lambda x: times[x])
        cells.append(fastest if math.isfinite(times[fastest]) else "-")
        rows.append(cells)
    return markdown(heads.split(", "), rows)
