"""The tables of campaigns/partitioned/README.md, docs/pairs.md and docs/pairs-growth.md.

They come from data/measurements and data/methods/partitioned.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any

from campaigns.long_survey import ONE_VALUE
from campaigns.pages import ROOT, Pages, markdown, measured
from glmref.catalogue.lookup import document as file_of
from glmref.catalogue.lookup import load
from glmref.derive.recipes.sources import in_words
from glmref.theory.periodicity import periodicity
from glmref.theory.stability import parasitic_curvature

#: The pairs of the record.
PAIRS = (
    *("pair-4-4", "pair-4-5", "pair-4-6", "pair-6-7", "pair-6-8", "pair-6-9", "pair-6-10"),
    *("pair-8-24", "pair-rkn-6-7", "pair-rkn-6-7b", "pair-rkn-6-8", "pair-rkn-6-8b"),
    *("pair-rkn-6-9", "pair-rkn-8-16"),
)
#: Column -> the methods it stands for; the best of them is shown.
GROUPS: Mapping[str, Sequence[str]] = {
    "Störmer-Verlet": ("stormer-verlet",),
    "order 4": ("forest-ruth-4", "mclachlan-4"),
    "Yoshida 6": ("yoshida-verlet-6",),
    "Kahan-Li 6": ("kahan-li-6",),
    "BM PRK 6": ("blanes-moan-6",),
    "BM RKN 6": ("blanes-moan-rkn-6-11", "blanes-moan-rkn-6-14"),
    "Kahan-Li 8": ("kahan-li-8",),
    "Suzuki-Umeno 8": ("suzuki-umeno-8",),
}
_GENERAL = tuple(x for x in PAIRS if "rkn" not in x)
_SECOND = tuple(x for x in PAIRS if "rkn" in x)


def best(
    case: Mapping[str, Any], names: Sequence[str], tolerance: str, key: str = "needed"
) -> tuple[str, float] | None:
    """Return the method that needs least in an entry of ``cases`` of pairs.json, from zero starts.

    The number with it is one of evaluations (``key`` is ``"needed"``) or of ``"seconds"``.
    """
    found = [
        (row[key][tolerance], row["method"])
        for row in case["methods"]
        if row["method"] in names and row["start"] != "enhanced" and tolerance in row[key]
    ]
    return (min(found)[1], min(found)[0]) if found else None


def _rows(document: Mapping[str, Any], tolerance: str, key: str, show: Any) -> str:
    """Return one row a case: every group, the best general pair, the best pair, and their ratio."""
    others = [name for names in GROUPS.values() for name in names]
    heads = ["case", *GROUPS, "general pair", "any pair", "pair / best other"]
    rows = []
    for case in document["cases"]:
        if not any(row[key] for row in case["methods"]):
            continue
        cells = [case["case"]]
        for names in GROUPS.values():
            found = best(case, names, tolerance, key)
            cells.append("-" if found is None else show(found[1]))
        for names in (_GENERAL, (*_GENERAL, *_SECOND)):
            found = best(case, names, tolerance, key)
            cells.append("-" if found is None else f"{show(found[1])} ({found[0][5:]})")
        ours = best(case, (*_GENERAL, *_SECOND), tolerance, key)
        theirs = best(case, others, tolerance, key)
        both = ours is not None and theirs is not None
        cells.append(f"{ours[1] / theirs[1]:.2f}" if both else "-")  # type: ignore[index]
        rows.append(cells)
    return markdown(heads, rows)


def needs_table(document: Mapping[str, Any], tolerance: str) -> str:
    """Return the force evaluations at one tolerance; ``-`` where it was not reached."""
    return _rows(document, tolerance, "needed", lambda x: f"{x:,.0f}")


def time_table(document: Mapping[str, Any], tolerance: str) -> str:
    """Return milliseconds at one tolerance."""
    return _rows(document, tolerance, "seconds", lambda x: f"{1e3 * x:.3g}")


def ratios(document: Mapping[str, Any], name: str, tolerance: str) -> dict[str, float]:
    """Return case -> evaluations of a method over those of the best other, where both reach it."""
    others = [one for group in GROUPS.values() for one in group]
    found = {}
    for case in document["cases"]:
        ours, theirs = best(case, (name,), tolerance), best(case, others, tolerance)
        if ours is not None and theirs is not None:
            found[case["case"]] = ours[1] / theirs[1]
    return found


def one_pair_table(document: Mapping[str, Any], names: Sequence[str], tolerance: str) -> str:
    """Return evaluations of single pairs over those of the best other method, by case."""
    found = [ratios(document, name, tolerance) for name in names]
    rows = (
        [case, *(f"{one[case]:.2f}" if case in one else "-" for one in found)]
        for case in (case["case"] for case in document["cases"])
    )
    return markdown(["case", *names], rows)


def start_table(document: Mapping[str, Any], tolerance: str) -> str:
    """Tabulate evaluations from zero values, from the enhanced start, and with its cost.

    Of the cases that were timed.
    """
    rows = []
    for case in document["cases"]:
        known = {(row["method"], row["start"]): row for row in case["methods"]}
        timed = any(row["seconds"] for row in case["methods"])
        names = [name for name, start in known if start == "enhanced" and timed]
        for name in names:
            row = known[name, "enhanced"]
            zero, other = (x["needed"].get(tolerance) for x in (known[name, "zero"], row))
            total = None if other is None else other + row["start_evaluations"]
            shown = ("-" if x is None else f"{x:,}" for x in (zero, other, total))
            rows.append([case["case"], name, *shown])
    return markdown(["case", "pair", "zero start", "enhanced start", "with its cost"], rows)


def long_table(document: Mapping[str, Any]) -> str:
    """Tabulate ten million steps: energy errors and carried values at 10^5 and at the end."""
    heads = ("pair", "problem", "h", "energy, $10^5$", "$10^7$", "carried, $10^5$", "$10^7$")
    rows = []
    for run in document["runs"]:
        at = run["marks"].index(100_000)
        cells = [
            *(run["method"], run["problem"], f"{run['h']:.4g}"),
            *(f"{run[row][k]:.1e}" for row in ("energy", "carried") for k in (at, -1)),
            "yes" if run["bounded"] else _ending(run),
        ]
        rows.append(cells)
    return markdown([*heads, "bounded"], rows)


def _ending(run: Mapping[str, Any]) -> str:
    """Say that a run is not bounded, and where it ended if it did not reach the last mark."""
    early = run["steps"] < run["marks"][-1]
    return f"no: {run['outcome']} after {run['steps']:,} steps" if early else "no"


def starts_table(document: Mapping[str, Any]) -> str:
    """Return misses of both starts and their orders, in Markdown."""
    rows = []
    for row in document["starts"]:
        cells = [
            f"{row[what][start]['size']:.1e} ({row[what][start]['order']:.1f})"
            for what in ("carried", "first")
            for start in ("zero", "own")
        ]
        k, f = row["evaluations"]
        rows.append([row["method"], f"{k}, {f}", *cells])
    head = "pair; evaluations of k, f; carried: zero; own; first: zero; own"
    return markdown(head.split("; "), rows)


def runs_table(document: Mapping[str, Any], zero: Mapping[str, Any]) -> str:
    """Tabulate ten million steps from both starts: energy error and carried values."""
    rows = []
    known = {(x["method"], x["problem"]): x for x in zero["runs"]}
    for own in document["runs"]:
        other = known[own["method"], own["problem"]]
        cells = [shown_error(x[what][-1]) for what in ("energy", "carried") for x in (other, own)]
        cells += ["yes" if x["bounded"] else "no" for x in (other, own)]
        rows.append([own["method"], own["problem"], *cells])
    head = "pair; problem; energy: zero; own; carried: zero; own; bounded: zero; own"
    return markdown(head.split("; "), rows)


def kepler_table(runs: Sequence[Mapping[str, Any]], methods: Sequence[str] = ()) -> str:
    """Return energy errors after 10^5, 10^6, .. steps, one line for each method, in Markdown."""
    methods = methods or list(dict.fromkeys(run["method"] for run in runs))
    orbits = list(dict.fromkeys(run["eccentricity"] for run in runs))
    marks = [n for n in runs[0]["marks"] if n >= 100_000]
    shown = ", ".join(f"$10^{len(str(n)) - 1}$" for n in marks)
    heads = ["method", *(f"e = {e}: {shown}" for e in orbits), "bounded"]
    known, rows = {(run["method"], run["eccentricity"]): run for run in runs}, []
    for name in methods:
        mine = [known[name, e] for e in orbits]
        cells = [", ".join(shown_error(x) for x in run["energy"][-len(marks) :]) for run in mine]
        where = [run["eccentricity"] for run in mine if run["bounded"]]
        verdict = "yes" if len(where) == len(orbits) else f"at {in_words(where)}" if where else "no"
        rows.append([f"`{name}`", *cells, verdict])
    return markdown(heads, rows)


def shown_error(x: float | None) -> str:
    """Return an error in a cell of a table."""
    return "not finite" if x is None else f"{x:.1e}"


#: Problem of a long run -> how a table calls it.
_CALLED = {"pendulum": "pendulum", "henon-heiles": "Hénon-Heiles", "kepler": "Kepler"}
#: Pairs that docs/choose.md recommends for runs of up to 100,000 steps.
RECOMMENDED = ("pair-6-8", "pair-6-9", "pair-rkn-6-7b", "pair-rkn-6-8b")
#: Cases that say nothing of a pair: both tolerances are met at the coarsest step of ``n-body``.
_SILENT = ("n-body",)


def _growth(runs: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return pair -> the problems on which a run of it is not bounded."""
    found: dict[str, dict[str, None]] = {}
    for run in runs:
        if not run["bounded"]:
            found.setdefault(run["method"], {})[_CALLED[run["problem"]]] = None
    return {name: ", ".join(problems) for name, problems in found.items()}


def shipped_table(records: Mapping[str, Mapping[str, Any]]) -> str:
    """Tabulate every pair: order, cost against the best splitting, and where it grows.

    From the records ``pairs``, ``pairs-long``, ``pairs-starts`` and ``kepler-long``.
    """
    own, kepler = records["pairs-starts"], records["kepler-long"]
    started = {run["method"] for run in own["runs"]}
    zero = [x for x in records["pairs-long"]["runs"] if x["method"] not in started]
    ten = _growth([*own["runs"], *zero, *kepler["runs"]])
    hundred = _growth([*own["further"], *kepler["further"]])
    heads = (
        *("pair", "order", "order on $q'' = g(q)$", "force evaluations a step"),
        *("evaluations over the best splitting's", "fewer on"),
        *("grows within $10^7$ steps on", "within $10^8$ also on"),
    )
    rows = []
    for name in PAIRS:
        file = file_of(name)
        claims, order = file["claims"], file["claims"]["order"]
        second = claims.get("nystrom-order", order)
        silent = (*_SILENT, "lotka-volterra") if second > order else _SILENT
        mine = {x: r for x, r in ratios(records["pairs"], name, "1e-09").items() if x not in silent}
        mean = math.prod(mine.values()) ** (1 / len(mine))
        cells = (
            *(f"**`{name}`**" if name in RECOMMENDED else f"`{name}`", order, second),
            *(file["stages"].count("Q"), f"{mean:.2f}"),
            f"{sum(r < 1 for r in mine.values())} of {len(mine)}",
            *(ten.get(name, "-"), hundred.get(name, "-")),
        )
        rows.append(cells)
    return markdown(heads, rows)


def growth_table() -> str:
    """Tabulate parasitic growth of second order on the oscillator: sign, periodicity interval."""
    head = "pair, order, stages Q, $\\kappa$, periodic to $y$, order of zero start, remark"
    rows = []
    for name in PAIRS:
        pair, file = load(name), file_of(name)
        claims, kappa = file["claims"], float(parasitic_curvature(pair))
        second = claims.get("nystrom-order", claims["order"])
        order = f"{second} ({claims['order']})" if second > claims["order"] else f"{second}"
        # every pair is G-symplectic, by its claims: the eigenvalues lie in pairs lambda, 1/lambda
        end = periodicity(pair, conserving=True).value if kappa > 0 else 0.0
        both = {"start f[k] 2", "start k[f] 2"} <= set(file["enclosure"]["equations"])
        remark = ""
        if kappa < 0:
            digits, exponent = f"{math.sqrt(-kappa):.2e}".split("e")
            remark = rf"$\vert\lambda\vert - 1 = {digits} \cdot 10^{{{int(exponent)}}} y^3$"
        cells = (
            *(f"`{name}`", order, file["stages"].count("Q"), f"{kappa:.2e}"),
            *("-" if end is None else f"{end:.5g}", 3 if both else 1, remark),
        )
        rows.append(cells)
    return markdown(head.split(", "), rows)


_SINGLE = (
    *("pair-6-7", "pair-6-8", "pair-8-24", "pair-rkn-6-7b", "pair-rkn-6-8b", "pair-rkn-8-16"),
)


def _shipped() -> str:
    names = ("pairs", "pairs-long", "pairs-starts", "kepler-long")
    return shipped_table({x: measured(x) for x in names})


#: Page -> name of a table -> what writes it.
PAGES: Pages = {
    ROOT / "campaigns" / "partitioned" / "README.md": {
        "shipped": _shipped,
        "evaluations-9": lambda: needs_table(measured("pairs"), "1e-09"),
        "evaluations-6": lambda: needs_table(measured("pairs"), "1e-06"),
        "one-pair": lambda: one_pair_table(measured("pairs"), _SINGLE, "1e-09"),
        "starts": lambda: starts_table(measured("pairs-starts")),
        "enhanced-start": lambda: start_table(measured("pairs"), "1e-09"),
        "times": lambda: time_table(measured("pairs"), "1e-09"),
        "long-runs": lambda: long_table(measured("pairs-long")),
        "long-runs-own-start": lambda: runs_table(measured("pairs-starts"), measured("pairs-long")),
        "kepler-long": lambda: kepler_table(
            measured("kepler-long")["runs"], [*sorted(PAIRS), *ONE_VALUE]
        ),
        "kepler-restarted": lambda: kepler_table(measured("kepler-long")["restarted"]),
        "kepler-further": lambda: kepler_table(measured("kepler-long")["further"]),
    },
    ROOT / "docs" / "pairs.md": {
        "shipped-order-6": lambda: "\n".join(
            x for x in _shipped().splitlines() if "`pair-4-" not in x
        )
    },
    ROOT / "docs" / "pairs-growth.md": {"growth": growth_table},
}
