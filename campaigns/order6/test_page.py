"""The tables of docs/order6.md are those of the data: ``python campaigns/order6/test_page.py``."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import pytest

from campaigns.partitioned.long_runs import kepler_table
from glmref.catalogue.lookup import data_root

PAGE = Path(__file__).parents[2] / "docs" / "order6.md"
TARGETS = ("1e-06", "1e-09")
BASE = "gauss-3"


def measured(name: str) -> dict[str, Any]:
    return json.loads((data_root() / "measurements" / f"{name}.json").read_text(encoding="utf-8"))


def row(*cells: object) -> str:
    return "| " + " | ".join(map(str, cells)) + " |"


def table(head: list[str], rows: list[str]) -> str:
    return "\n".join([row(*head), "|" + "---|" * len(head), *rows])


def number(value: float | None, digits: int = 2) -> str:
    if value is None:
        return "-"
    return f"{value:.{digits}g}" if 1e-3 <= abs(value) < 1e4 else f"{value:.{digits - 1}e}"


def frequency(x: Mapping[str, float]) -> str:
    """c2 and c3 of a complex eigenvalue, c3 of -1."""
    return f"{number(x['c2'])}, {number(x['c3'])}" if x["argument"] < 3.1 else number(x["c3"])


def constants() -> str:
    """Constants of every method."""
    rows = []
    for m in measured("order6-methods")["methods"]:
        error, c = m["error"], m["parasitic"]
        rows.append(
            row(
                f"`{m['name']}`", m["order"], m["stages"],
                " ".join(map(str, m["implicit"])) if len(m["implicit"]) < m["stages"] else "all",
                number(error["identity"]), number(error["after_conjugation"]),
                number(m["largest"]["A"]), number(m["largest"]["U"]),
                "whole axis" if m["periodicity"] is None else f"{m['periodicity']:.3g}",
                "; ".join(frequency(x) for x in c) or "-",
                f"{m['start_stages']}, {m['finish_stages']}" if m["start_stages"] else "-",
            )
        )  # fmt: skip
    head = [
        *("method", "order", "stages", "implicit", "error, identity", "error, conjugated"),
        *("largest A", "largest U", "periodicity", "parasitic", "start, finish"),
    ]
    return table(head, rows)


def fastest(case: Mapping[str, Any], target: str, solver: str) -> dict[str, Mapping[str, float]]:
    """Method -> its fastest track at an error."""
    best: dict[str, Mapping[str, float]] = {}
    for track in case["tracks"]:
        at = track["at"][target]
        if at is None or (solver and track["solver"] != solver):
            continue
        name = track["method"]
        if name not in best or at["seconds"] < best[name]["seconds"]:
            best[name] = at
    return best


def comparison(solver: str, *cases: str) -> str:
    """Time at equal error in units of Gauss-3, with evaluations in brackets."""
    shown = [c for c in measured("order6")["cases"] if c["case"] in cases]
    columns = [(c, t, fastest(c, t, solver)) for c in shown for t in TARGETS]
    names = list(dict.fromkeys(t["method"] for c in shown for t in c["tracks"]))
    rows = []
    for name in names:
        cells = []
        for _, _, best in columns:
            at = best.get(name)
            cells.append(
                "-"
                if at is None
                else f"{number(at['seconds'] / best[BASE]['seconds'])} ({at['evaluations']:.0f})"
            )
        rows.append(row(f"`{name}`", *cells))
    return table(["method", *(f"{c['case']}, {t}" for c, t, _ in columns)], rows)


def long_runs() -> str:
    """Ten million steps."""
    rows = []
    for run in measured("long-runs")["runs"]:
        grown = run["parasitic"] > 3 * run["parasitic_early"]
        verdict = "grows" if grown else "bounded"
        rate = number(run["rate"]) if run["rate"] > 1.5e-6 else "none"
        if not run["bounded"]:
            verdict = f"30-fold at t = {run['lost']:g}"
            rate = rate if run["rate"] > 1.5e-6 else "saturated"
        rows.append(
            row(
                f"`{run['method']}`", run["run"], f"{run['steps']:,}", number(run["energy"]),
                number(run["parasitic_early"]), number(run["parasitic"]), verdict,
                rate,
            )
        )  # fmt: skip
    head = ["method", "run", "steps", "energy", "parasitic, early", "largest", "", "rate"]
    return table(head, rows)


def rate_scan() -> str:
    """Rates of one method over h and the size of the nudge."""
    rows = [
        row(f"{x['h']:g}", f"{x['steps']:,}", f"{x['nudge']:g}", number(x["rate"], 3),
            number(x["rate"] / x["h"] ** 2, 4))
        for x in measured("long-runs")["scan"]
    ]  # fmt: skip
    return table(["h", "steps", "nudge", "rate", "rate / h^2"], rows)


def kepler() -> str:
    """Ten million steps of Kepler's problem."""
    names = [r["method"] for r in measured("long-runs")["runs"]]
    shown = [*dict.fromkeys(names), BASE]
    return kepler_table(measured("kepler-long")["runs"], shown).rstrip("\n")


def starts() -> str:
    """What a start costs and buys."""
    found = measured("starts")
    rows = [
        row(
            f"`{s['method']}`", s["start"], s["evaluations"], number(s["amplitude"][1]),
            s["order"], *(number(x) for x in s["error"]),
        )
        for s in found["starts"]
    ]  # fmt: skip
    head = ["method", "start", "evaluations", "amplitude, h = 0.1", "power of h"]
    return table([*head, *(f"error, h = {h:g}" for h in found["h"])], rows)


def losses() -> str:
    """When methods with growth are lost."""
    rows = [
        row(f"`{x['method']}`", x["start"], "-" if x["lost"] is None else f"{x['lost']:g}")
        for x in measured("starts")["losses"]["runs"]
    ]
    return table(["method", "start", "lost at t"], rows)


def searches() -> str:
    """The search for order 8."""
    rows = [
        row(
            a["stages"], a["values"], a["stage_order"],
            " ".join(map(str, a["explicit"])) or "none",
            "symmetric" if a["parity"] == [1] else "antisymmetric" if a["parity"] else "no -1",
            " ".join("+" if x > 0 else "-" for x in a["signs"]),
            a["unknowns"], a["conditions"], f"{a['solved']} of {a['starts']}",
            number(a["smallest_residual"]),
        )
        for a in measured("order8-search")["ansatzes"]
    ]  # fmt: skip
    head = [
        *(
            "stages",
            "values",
            "stage order",
            "explicit",
            "gamma",
            "signs",
            "unknowns",
            "conditions",
        ),
        *("starts that reach zero", "smallest residual"),
    ]
    return table(head, rows)


TABLES: Mapping[str, Callable[[], str]] = {
    "constants": constants,
    "orbits": lambda: comparison("", "kepler-0.6", "henon-heiles"),
    "newton": lambda: comparison(
        "newton", "nonseparable-chain-40", "fput-stiff-12", "fput-stiff-80"
    ),
    "any-solver": lambda: comparison("", "nonseparable-chain-40", "fput-stiff-12", "fput-stiff-80"),
    "long-runs": long_runs,
    "rate-scan": rate_scan,
    "kepler-long": kepler,
    "starts": starts,
    "losses": losses,
    "searches": searches,
}


def filled(text: str) -> str:
    """The page with every table put in anew."""
    for name, make in TABLES.items():
        pattern = rf"(<!-- table: {name} -->\n).*?(\n<!-- end of table -->)"
        text, count = re.subn(
            pattern, lambda m, make=make: m[1] + make() + m[2], text, flags=re.DOTALL
        )
        assert count == 1, f"docs/order6.md has {count} places for the table {name!r}"
    return text


def test_the_tables_are_those_of_the_data() -> None:
    text = PAGE.read_text(encoding="utf-8")
    assert filled(text) == text, "run `python campaigns/order6/test_page.py`"


def test_every_method_of_order_6_and_8_is_in_every_table() -> None:
    names = {m["name"] for m in measured("order6-methods")["methods"] if m["values"] > 1}
    assert len(names) >= 18
    assert names == {r["method"] for r in measured("long-runs")["runs"]}
    for case in measured("order6")["cases"]:
        orbit = case["case"] in ("kepler-0.6", "henon-heiles")
        compared = {t["method"] for t in case["tracks"]}
        assert BASE in compared
        assert names <= compared if orbit else len(names & compared) >= 6


@pytest.mark.parametrize(
    "name", ["order6", "order6-methods", "long-runs", "starts", "order8-search"]
)
def test_a_measurement_says_how_it_is_made_again(name: str) -> None:
    record = measured(name)
    assert record["format"] == "glmref-measurement-1"
    assert record["name"] == name
    assert record["how"].startswith("python -m campaigns.")


if __name__ == "__main__":
    PAGE.write_text(filled(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
