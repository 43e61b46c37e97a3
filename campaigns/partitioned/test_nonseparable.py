"""Rivals of the methods for every Hamiltonian: the page says what the closed studies recorded."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned.nonseparable import METHODS, needed
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
    assert tuple(FRONT)[:3] == METHODS
    assert all(x["kept"][k] <= third["kept"][k] for x in [second, *others] for k in (0, 1))


def test_what_systems_written_down_afterwards_lose_is_reported() -> None:
    runs = [x for row in RECORD["afterwards"] for x in row["long"]]
    assert len(runs) == 2 * 3 * 11
    assert all(x["energy"] and x["energy"] < 1e-3 for x in runs if x["renew"])
    lost = [x for x in runs if not (x["energy"] and x["energy"] < 1e-3)]
    assert lost
    assert all(x["reported"] is not None for x in lost)
