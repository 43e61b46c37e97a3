"""Methods for every and for semi-separable Hamiltonians: pages say what closed studies recorded."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned.nonseparable import long_run, needed, step_of
from glmref.catalogue.lookup import load
from glmref.derive.halves import GeneralHalf
from glmref.derive.recipes.general_multistep import Shipped, halves_of
from glmref.problems import problem

RECORD = measured("nonseparable")
FRONT = {x["method"]: x for x in RECORD["front"]}
WHOLE = RECORD["semi-separable"]
ROWS = {x["method"]: x for x in WHOLE["front"]}
DOCS = Path(__file__).parents[2] / "docs"
TEXT, SEMI_PAGE = ((DOCS / f"{x}.md").read_text("utf-8") for x in ("nonseparable", "velocities"))
PAGE = " ".join(TEXT.split())
#: Evaluations of the methods, by problem and tolerance.
OWN = {(x["problem"], x["tolerance"]): x["methods"] for x in RECORD["evaluations"]}


def mean(ratios: list[float]) -> str:
    return f"{np.exp(np.mean(np.log(ratios))):.2f}"


def test_evaluations_are_those_of_the_first_of_two_runs_in_a_row() -> None:
    curve = [(10, 1e-7), (11, 1e-9), (12, 1e-8), (20, 1e-10), (40, 1e-12)]
    assert needed(curve, 1e-9) == round(12 * math.sqrt(20 / 12))
    assert needed(curve[:-1], 1e-9) is None


def test_the_page_gives_the_mean_over_extended_phase_space() -> None:
    """Copies are free, bound, mixed or projected; the best splitting of all counts."""
    rows = [x for x in RECORD["extended"] if x["tolerance"] == 1e-9]
    assert {x["copies"] for x in rows} == {"free", "bound", "mixed", "projected"}
    problems = {x["problem"] for x in rows}
    assert {(x, 1e-9) for x in problems} == {x for x in OWN if x[1] == 1e-9}
    ratios = []
    for one in problems:
        counts = [n for x in rows if x["problem"] == one for n in x["methods"].values() if n]
        ratios.append(OWN[one, 1e-9]["multistep-general-8b"] / min(counts))
    assert f"`-8b` needs {mean(ratios)} of the best splitting in extended phase space" in PAGE


def test_the_page_says_what_loosened_rounds_of_gauss_save_and_cost() -> None:
    ratios: list[float] = []
    grown = []
    for x in RECORD["loosened"]:
        counts = OWN[x["problem"], x["tolerance"]]
        gauss = [*x["methods"].values(), *(n for k, n in counts.items() if k.startswith("gauss"))]
        if x["tolerance"] == 1e-9:
            ratios.append(counts["multistep-general-8b"] / min(gauss))
        grown.append(x["energy_loosened"] / x["energy"])
    assert len(grown) == len(OWN) == 8
    assert f"It needs {mean(ratios)} of Gauss whose rounds end at a thousandth" in PAGE
    assert sum(x > 1e9 for x in grown) == 1
    assert "one such run of eight was lost" in PAGE


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


def test_none_of_the_search_was_kept_more_often() -> None:
    first, second, third, *others = FRONT.values()
    assert tuple(FRONT)[:3] == tuple(f"multistep-general-8{x}" for x in ("b", "c", ""))
    assert all(x["kept"][k] <= third["kept"][k] for x in [second, *others] for k in (0, 1))


def test_what_systems_written_down_afterwards_lose_is_reported() -> None:
    runs = [x for row in RECORD["afterwards"] for x in row["long"]]
    assert len(runs) == 2 * 3 * 11
    assert all(x["energy"] and x["energy"] < 1e-3 for x in runs if x["renew"])
    lost = [x for x in runs if not (x["energy"] and x["energy"] < 1e-3)]
    assert lost
    assert all(x["reported"] is not None for x in lost)


# Semi-separable systems

TEN, TWELVE = "multistep-kinetic-10", "multistep-kinetic-12"
#: Problems that the search used.
SEARCHED = {"magnetic-trap", "penning-trap", "relativistic-charge", "rotating-three-body"}


def test_the_page_asks_for_steps_within_the_interval_for_every_ratio() -> None:
    assert ROWS["multistep-kinetic-8"]["interval"] == 0.1
    assert r"choose $h$ below $0.1/\omega$ for the fastest frequency" in SEMI_PAGE


def over_gauss(name: str) -> float:
    """Return the evaluations over those of the best Gauss method."""
    return float(np.exp(np.mean(np.log([x["over_gauss"] for x in ROWS[name]["cases"]]))))


def kept(name: str) -> set[str]:
    """Return the problems on which the energy is not lost; a loss has a notice."""
    cases = ROWS[name]["cases"]
    lost = [x for x in cases if x["energy"] is None or x["energy"] > 1e-8]
    assert all(x["reported"] for x in lost)
    return {x["problem"] for x in cases if x not in lost}


def test_the_page_gives_the_best_of_the_front() -> None:
    assert min(ROWS, key=over_gauss) == TWELVE
    assert f"`{TWELVE}` {over_gauss(TWELVE):.2f} of the best Gauss" in SEMI_PAGE
    assert kept(TWELVE) == kept(TEN) == SEARCHED
    assert kept("found-10") < kept(TEN)


def test_steps_of_the_lost_runs_are_beyond_the_bounds_of_a_gyration() -> None:
    """At the largest frequencies of the page; leapfrog's interval, 1, is the longest of all."""
    largest = {"dipole-charge": 43, "magnetic-bottle": 71}
    assert all(f"{omega} until" in SEMI_PAGE for omega in largest.values())
    found = [
        largest[x["problem"]] * x["h"]
        for x in WHOLE["long"]
        if x["problem"] in largest and x["method"] in ROWS
    ]
    assert f"$h\\omega$ comes to {min(found):.1f} to {max(found):.1f}" in SEMI_PAGE
    assert min(found) > 0.232  # the largest bound on the page
    assert sum(x > 1 for x in found) == len(found) - 1 == 5


@pytest.mark.slow
def test_what_is_stored_is_what_is_measured() -> None:
    (x,) = (x for x in ROWS[TWELVE]["cases"] if x["problem"] == "magnetic-trap")
    one = problem(x["problem"])
    assert step_of(load(TWELVE), one) == (x["h"], x["evaluations"])
    assert long_run(TWELVE, one, x["h"], 1_000_000) == {k: x[k] for k in ("energy", "reported")}
