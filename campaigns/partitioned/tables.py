"""The measurements of pairs as tables in Markdown: what docs/pairs.md shows.

Public names::

    needs_table(document, tolerance) -> str      evaluations of the best of each group, by case
    time_table(document, tolerance) -> str       time of the best of each group, by case
    long_table(document) -> str                  ten million steps
    one_pair_table(document, names, tolerance)   ratios of single pairs to the best other method
    start_table(document, cases, tolerance) -> str       zero and enhanced starts
    best(case, names, tolerance, key) -> (name, number) or None
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

__all__ = [
    "GROUPS",
    "best",
    "long_table",
    "needs_table",
    "one_pair_table",
    "start_table",
    "time_table",
]

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
_GENERAL = (
    *("pair-4-4", "pair-4-5", "pair-4-6", "pair-6-7", "pair-6-8", "pair-6-9", "pair-6-10"),
    "pair-8-24",
)
_SECOND = (
    *("pair-rkn-6-7", "pair-rkn-6-7b", "pair-rkn-6-8", "pair-rkn-6-8b", "pair-rkn-6-9"),
    "pair-rkn-8-16",
)


def best(
    case: Mapping[str, Any], names: Sequence[str], tolerance: str, key: str = "needed"
) -> tuple[str, float] | None:
    """Return the method that needs least, from zero starts, with the number.

    Args:
        case: an entry of ``cases`` in data/measurements/pairs.json. tolerance: ``"1e-09"``.
        key: ``"needed"`` for evaluations, ``"seconds"`` for times.
    """
    found = [
        (row[key][tolerance], row["method"])
        for row in case["methods"]
        if row["method"] in names and row["start"] != "enhanced" and tolerance in row[key]
    ]
    return (min(found)[1], min(found)[0]) if found else None


def _rows(document: Mapping[str, Any], tolerance: str, key: str, show: Any) -> str:
    """One row a case: every group, the best general pair, the best pair, and their ratio."""
    others = [name for names in GROUPS.values() for name in names]
    heads = ["case", *GROUPS, "general pair", "any pair", "pair / best other"]
    lines = ["| " + " | ".join(heads) + " |", "|---" * len(heads) + "|"]
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
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def needs_table(document: Mapping[str, Any], tolerance: str) -> str:
    """Force evaluations at one tolerance; ``-`` where it was not reached."""
    return _rows(document, tolerance, "needed", lambda x: f"{x:,.0f}")


def time_table(document: Mapping[str, Any], tolerance: str) -> str:
    """Milliseconds at one tolerance."""
    return _rows(document, tolerance, "seconds", lambda x: f"{1e3 * x:.3g}")


def one_pair_table(document: Mapping[str, Any], names: Sequence[str], tolerance: str) -> str:
    """Evaluations of single pairs over those of the best other method, by case."""
    others = [name for group in GROUPS.values() for name in group]
    lines = ["| case | " + " | ".join(names) + " |", "|---" * (len(names) + 1) + "|"]
    for case in document["cases"]:
        theirs = best(case, others, tolerance)
        cells = []
        for name in names:
            ours = best(case, (name,), tolerance)
            both = ours is not None and theirs is not None
            cells.append(f"{ours[1] / theirs[1]:.2f}" if both else "-")  # type: ignore[index]
        lines.append(f"| {case['case']} | " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def start_table(document: Mapping[str, Any], cases: Sequence[str], tolerance: str) -> str:
    """Evaluations from zero values, from the enhanced start, and with the cost of that start."""
    lines = [
        "| case | pair | zero start | enhanced start | with its cost |",
        "|---|---|---|---|---|",
    ]
    for case in document["cases"]:
        rows = {(row["method"], row["start"]): row for row in case["methods"]}
        names = [name for name, start in rows if start == "enhanced" and case["case"] in cases]
        for name in names:
            row = rows[name, "enhanced"]
            zero, other = (x["needed"].get(tolerance) for x in (rows[name, "zero"], row))
            total = None if other is None else other + row["start_evaluations"]
            shown = ("-" if x is None else f"{x:,}" for x in (zero, other, total))
            lines.append("| " + " | ".join([case["case"], name, *shown]) + " |")
    return "\n".join(lines) + "\n"


def long_table(document: Mapping[str, Any]) -> str:
    """Ten million steps: energy errors and carried values at 10^5 and at the end."""
    heads = ("pair", "problem", "h", "energy, $10^5$", "$10^7$", "carried, $10^5$", "$10^7$")
    lines = [f"| {' | '.join(heads)} | bounded |", "|---" * 8 + "|"]
    for run in document["runs"]:
        at = run["marks"].index(100_000)
        cells = [
            *(run["method"], run["problem"], f"{run['h']:.4g}"),
            *(f"{run[row][k]:.1e}" for row in ("energy", "carried") for k in (at, -1)),
            "yes" if run["bounded"] else _ending(run),
        ]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def _ending(run: Mapping[str, Any]) -> str:
    """Say that a run is not bounded, and where it ended if it did not reach the last mark."""
    early = run["steps"] < run["marks"][-1]
    return f"no: {run['outcome']} after {run['steps']:,} steps" if early else "no"
