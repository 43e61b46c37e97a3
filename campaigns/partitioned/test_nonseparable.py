"""Rivals of the methods for every Hamiltonian: the page says what the closed studies recorded."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned.nonseparable import METHODS, kept, needed, time_table
from glmref.derive.halves import GeneralHalf
from glmref.derive.recipes.general_multistep import Shipped, halves_of

RECORD = measured("nonseparable")
FRONT = {x["method"]: x for x in RECORD["front"]}
TEXT = (Path(__file__).parents[2] / "docs" / "nonseparable.md").read_text("utf-8")
PAGE = " ".join(TEXT.split())
#: Evaluations of the methods, by problem and tolerance.
OWN = {(x["problem"], x["tolerance"]): x["methods"] for x in RECORD["evaluations"]}


def mean(ratios: list[float]) -> str:
    return f"{np.exp(np.mean(np.log(ratios))):.2f}"


def test_evaluations_are_those_of_the_first_of_two_runs_in_a_row() -> None:
    curve = [(10, 1e-7), (11, 1e-9), (12, 1e-8), (20, 1e-10), (40, 1e-12)]
    assert needed(curve, 1e-9) == round(12 * math.sqrt(20 / 12))
    assert needed(curve[:-1], 1e-9) is None


def test_what_is_timed_is_kept_by_the_method_with_renewals() -> None:
    rows = RECORD["times"]["rows"]
    assert [x["problem"] for x in rows] == kept(RECORD)
    for change in ({"reported": 3.0}, {"energy": None}, {"energy": 1e-3}):
        other = [x | change if x["problem"] == rows[0]["problem"] else x for x in RECORD["long"]]
        assert kept({"long": other}) == [x["problem"] for x in rows[1:]]


def test_the_table_of_times_has_medians_and_extremes_of_ratios() -> None:
    few, many = {"plain": 3.0, "renewed": 4.0, "rival": 4.0}, {"plain": 1.0, "renewed": 2.0}
    rows = [{"seconds": {"100000": few, "1000000": many | {"rival": x}}} for x in (2.0, 4.0, 10.0)]
    *_, first, last = time_table(rows).splitlines()
    assert first == "| 100,000 | 0.75 (0.75–0.75) | 1.00 (1.00–1.00) |"
    assert last == "| 1,000,000 | 0.25 (0.10–0.50) | 0.50 (0.20–1.00) |"


def means(tolerance: float, ways: set[str]) -> list[str]:
    """Return the mean ratios of evaluations of the pairs to the best of some rivals."""
    rows = [x for x in RECORD["extended"] if x["tolerance"] == tolerance and x["copies"] in ways]
    problems = {x["problem"] for x in rows}
    assert {(x, tolerance) for x in problems} == {x for x in OWN if x[1] == tolerance}
    found = []
    for name in ("multistep-general-8b", "multistep-general-8"):
        ratios = []
        for one in problems:
            counts = [n for x in rows if x["problem"] == one for n in x["methods"].values() if n]
            if counts:  # some way reached the tolerance
                ratios.append(OWN[one, tolerance][name] / min(counts))
        found.append(mean(ratios))
    return found


def test_the_page_gives_the_means_over_extended_phase_space() -> None:
    ways = {x["copies"] for x in RECORD["extended"]}
    assert ways == {"free", "bound", "mixed", "projected"}
    all_, early = means(1e-9, ways), means(1e-6, ways)
    assert f"`-8b` and `-8` need {all_[0]} and {all_[1]} of the best of all" in PAGE
    assert f"{early[0]} and {early[1]} at $10^{{-6}}$" in PAGE
    for copies in ways:
        assert "| " + " | ".join([copies, *means(1e-9, {copies})]) + " |" in TEXT


def test_the_page_says_what_loosened_rounds_of_gauss_save_and_cost() -> None:
    ratios: dict[float, list[float]] = {}
    grown = []
    for x in RECORD["loosened"]:
        counts = OWN[x["problem"], x["tolerance"]]
        gauss = [*x["methods"].values(), *(n for k, n in counts.items() if k.startswith("gauss"))]
        ratios.setdefault(x["tolerance"], []).append(counts["multistep-general-8b"] / min(gauss))
        grown.append(x["energy_loosened"] / x["energy"])
    assert len(grown) == len(OWN) == 8
    assert f"`-8b` needs {mean(ratios[1e-9])} ($10^{{-9}}$) and {mean(ratios[1e-6])}" in PAGE
    *same, second, first, lost = sorted(grown)
    assert max(same) <= 1 and lost > 1e9
    assert f"two had {second:.0f} and {round(first, -1):.0f} times the energy error" in PAGE
    assert "one of eight such runs was lost" in PAGE


def halves(x: Mapping[str, Any]) -> tuple[GeneralHalf, GeneralHalf]:
    """Return both halves; the first root of p is the one that the constant of q gives."""
    return halves_of(Shipped(" ".join(x["q"]), " ".join(x["p"][1:])))


@pytest.mark.parametrize("name", FRONT)
def test_what_is_recorded_of_the_roots_follows_from_them(name: str) -> None:
    x = FRONT[name]
    q, p = halves(x)
    assert float(q.error_constant) == float(p.error_constant)
    assert math.isclose(float(q.error_constant), x["error_constant"], rel_tol=5e-3)
    largest = max(abs(float(mu)) for half in (q, p) for mu in half.residues)
    assert math.isclose(largest, x["residue"], rel_tol=5e-3)


def over(one: Mapping[str, Any], other: Mapping[str, Any]) -> float:
    """Return the mean ratio of the evaluations of two rows, on the problems that both reach."""
    a, b = one["evaluations"], other["evaluations"]
    return float(np.exp(np.mean([math.log(a[x] / b[x]) for x in a.keys() & b.keys()])))


def test_the_page_says_what_the_search_found() -> None:
    first, second, third, *others = FRONT.values()
    assert tuple(FRONT)[:3] == METHODS
    found = [second, *others]
    ratios, residues = [over(x, first) for x in found], [x["residue"] for x in found]
    constants = [-x["error_constant"] for x in found if x["order"] == 8]
    assert f"{min(ratios):.2f} to {max(ratios):.2f} of the evaluations of `-8b`" in PAGE
    assert f"residues of {min(residues):.1f} to {max(residues):.1f}" in PAGE
    assert max(constants) < 0.2
    assert all(x["kept"][k] <= third["kept"][k] for x in found for k in (0, 1))
    assert f"one of {['five', 'six', 'seven'][len(found) - 5]} methods from a search" in PAGE


def test_the_page_says_what_systems_written_down_afterwards_need_and_what_is_lost() -> None:
    rows = RECORD["afterwards"]
    shares = []
    for name in METHODS:
        counts = [x["evaluations"]["1e-09"] for x in rows]
        best = [min(n for k, n in x.items() if k.startswith("gauss") and n) for x in counts]
        shares.append(mean([x[name] / n for x, n in zip(counts, best, strict=True)]))
    assert len(rows) == 11
    assert f"it is {shares[0]}, {shares[1]} and {shares[2]}, and no renewed run" in PAGE
    runs = [x for row in rows for x in row["long"]]
    assert len(runs) == 2 * 3 * 11
    assert all(x["energy"] and x["energy"] < 1e-3 for x in runs if x["renew"])
    lost = [x for x in runs if not (x["energy"] and x["energy"] < 1e-3)]
    assert lost
    assert all(x["reported"] is not None for x in lost)
