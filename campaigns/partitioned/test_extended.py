"""Extended phase space: two copies move as the system does; the page says what was measured."""

import math
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned import extended, loosened
from campaigns.partitioned.extended import METHODS, needed, run
from glmref import solve
from glmref.measure.work_precision import reference_state
from glmref.problems import problem
from glmref.problems.model import Problem

PAGE = Path(__file__).parents[2] / "docs" / "nonseparable.md"
RECORD = measured("nonseparable")
HAMILTONIAN = "p**2/(2*(1 + q**2)) + q**2/2"
PARTICLE = Problem.from_hamiltonian(HAMILTONIAN, {"q": 1, "p": "1/2"})


@cache
def exact() -> np.ndarray:
    return solve(PARTICLE, "gauss-6", h=1 / 64, t_end=2, engine="reference").y[-1]


def order(method: str, copies: str) -> float:
    """Return the order that the errors at two step sizes show."""
    coarse, fine = (
        float(np.abs(run(PARTICLE, 2.0, n, method, copies)[0] - exact()).max()) for n in (20, 40)
    )
    return float(np.log2(coarse / fine))


@pytest.mark.parametrize("copies", METHODS)
def test_the_solution_has_the_order_of_the_splitting(copies: str) -> None:
    assert 5.5 < order("yoshida-verlet-6", copies) < 6.5


def test_a_splitting_that_is_no_composition_loses_its_order_when_bound() -> None:
    assert order("blanes-moan-6", "bound") < 4.5


def test_a_binding_that_is_no_rotation_loses_the_order(monkeypatch: pytest.MonkeyPatch) -> None:
    def one_sided(self: extended.Copies, angle: float) -> None:
        u, w = self.points
        self.put(np.array([w + np.cos(angle) * (u - w), w]))

    monkeypatch.setattr(extended.Copies, "bind", one_sided)
    assert order("yoshida-verlet-6", "bound") < 4.5


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", dict.fromkeys(x["problem"] for x in measured("nonseparable")["evaluations"])
)
def test_no_binding_gains_much_over_free_copies(name: str) -> None:
    one = problem(name)
    end = reference_state(one, 20.0).state

    def error(copies: str, omega: float) -> float:
        with np.errstate(all="ignore"):
            y = run(one, 20.0, 200, "kahan-li-8", copies, omega)[0]
        return float(np.abs(y - end).max())

    free = error("free", 0.0)
    assert math.isfinite(free)
    assert all(not error("bound", omega) < free / 3 for omega in (20.0, 5.0, 1.0, 0.25))
    page = (Path(__file__).parents[2] / "docs" / "nonseparable.md").read_text("utf-8")
    assert "at $h = 0.1$ shows no error below a third of that of free copies" in page


def test_evaluations_of_a_step() -> None:
    """Seven Verlet steps: free 2 each, bound 3; mixed and projected begin anew in every step."""
    count = {x: run(PARTICLE, 1.0, 10, "yoshida-verlet-6", x)[1] for x in METHODS}
    assert count["free"] == 10 * 14 + 1
    assert count["bound"] == 10 * 21 + 1
    assert count["mixed"] == 10 * 15
    assert count["projected"] % 15 == 0
    assert count["projected"] >= 2 * count["mixed"]


def there_and_back(copies: str) -> float:
    """Return how far three steps, and three after p -> -p, end from the start."""
    q, p = run(PARTICLE, 3.0, 3, "suzuki-verlet-4", copies)[0]
    other = Problem.from_hamiltonian(HAMILTONIAN, {"q": float(q), "p": float(-p)})
    again, _ = run(other, 3.0, 3, "suzuki-verlet-4", copies)
    return float(np.abs(again * (1, -1) - np.array(PARTICLE.y0, dtype=float)).max())


def test_only_the_projection_is_symmetric() -> None:
    assert there_and_back("projected") < 1e-11
    assert there_and_back("free") > 1e-8


@pytest.mark.slow
def test_what_is_stored_is_what_is_measured() -> None:
    for copies in METHODS:
        found = needed(problem("uneven-plane"), 30.0, "kahan-li-8", copies)
        for x in RECORD["extended"]:
            if (x["problem"], x["copies"]) == ("uneven-plane", copies):
                assert found[x["tolerance"]] == x["methods"]["kahan-li-8"]


def means(tolerance: float, ways: tuple[str, ...]) -> list[str]:
    """Return the mean ratios of evaluations of the pairs to the best of some rivals."""
    rows = [x for x in RECORD["extended"] if x["tolerance"] == tolerance and x["copies"] in ways]
    assert all(set(x["methods"]) == set(METHODS[x["copies"]]) for x in rows)
    pairs = {
        x["problem"]: x["methods"] for x in RECORD["evaluations"] if x["tolerance"] == tolerance
    }
    assert {x["problem"] for x in rows} == pairs.keys()
    found = []
    for name in ("multistep-general-8b", "multistep-general-8"):
        ratios = []
        for one, own in pairs.items():
            counts = [n for x in rows if x["problem"] == one for n in x["methods"].values() if n]
            if counts:  # some way reached the tolerance
                ratios.append(own[name] / min(counts))
        found.append(f"{np.exp(np.mean(np.log(ratios))):.2f}")
    return found


def test_the_page_gives_the_means() -> None:
    page = PAGE.read_text("utf-8")
    all_, early = means(1e-9, tuple(METHODS)), means(1e-6, tuple(METHODS))
    assert f"`-8b` and `-8` need {all_[0]} and {all_[1]} of the best of all" in page
    assert f"{early[0]} and {early[1]} at $10^{{-6}}$" in page
    for copies in METHODS:
        line = [copies, *means(1e-9, (copies,))]
        assert "| " + " | ".join(line) + " |" in page


def test_the_page_says_what_loosened_rounds_of_gauss_save_and_cost() -> None:
    page = " ".join(PAGE.read_text("utf-8").split())
    ratios: dict[float, list[float]] = {}
    grown = []
    own = {(x["problem"], x["tolerance"]): x["methods"] for x in RECORD["evaluations"]}
    for x in RECORD["loosened"]:
        counts = own[x["problem"], x["tolerance"]]
        gauss = [*x["methods"].values(), *(n for k, n in counts.items() if k.startswith("gauss"))]
        ratios.setdefault(x["tolerance"], []).append(counts["multistep-general-8b"] / min(gauss))
        grown.append(x["energy_loosened"] / x["energy"])
    assert len(grown) == len(own) == 8
    sharp, early = (f"{np.exp(np.mean(np.log(ratios[t]))):.2f}" for t in (1e-9, 1e-6))
    assert f"`-8b` needs {sharp} ($10^{{-9}}$) and {early} ($10^{{-6}}$)" in page
    *same, second, first, lost = sorted(grown)
    assert max(same) <= 1 and lost > 1e9
    assert f"two had {second:.0f} and {round(first, -1):.0f} times the energy error" in page
    assert "one of eight such runs was lost" in page


@pytest.mark.slow
def test_what_is_stored_of_loosened_rounds_is_what_is_measured() -> None:
    name = "uneven-plane"
    (x,) = (x for x in RECORD["loosened"] if (x["problem"], x["tolerance"]) == (name, 1e-9))
    count, steps, part = loosened.needed(name, x["best"], 1e-9) or (0, 0, 0.0)
    assert count == min(x["methods"].values()) == x["methods"][x["best"]]
    found = loosened.energies(name, x["best"], steps, part * 1e-9)
    assert found == {k: x[k] for k in found}


def test_only_rounds_within_end_early() -> None:
    def evaluations() -> int:
        return solve(PARTICLE, "gauss-3", h=1 / 8, steps=16, arithmetic="quick").evaluations

    before = evaluations()
    with loosened.ended_at(1e-6):
        assert evaluations() < before
    assert evaluations() == before
