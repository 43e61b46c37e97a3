"""Strongly stable multistep methods: the pages say what is recorded."""

from pathlib import Path

import numpy as np
import pytest

from campaigns.pages import measured
from campaigns.partitioned.nonseparable import LOST
from campaigns.partitioned.strong import (
    FAST,
    RATES,
    TIMES,
    best_gauss,
    fixed,
    kept,
    long_rows,
    ratios,
    rivals,
    written_down,
)
from glmref.catalogue.lookup import load
from glmref.derive.recipes.strong_multistep import SHIPPED

RUNS = measured("strong-multistep")["runs"]
PAGE, CLOSE = (
    " ".join((Path(__file__).parents[2] / "docs" / name).read_text("utf-8").split())
    for name in ("nonseparable.md", "close-encounters.md")
)


def means(name: str, tolerance: float) -> list[str]:
    """Return the means over Gauss and over DOP853: of problems held out, and of the eleven."""
    found = []
    for over in ("gauss", "dop853"):
        for late in (False, True):
            ratios = []
            for x in RUNS:
                counts = rivals(x["problem"], tolerance)
                if x["method"] == name and counts and (x["problem"] in written_down()) == late:
                    least = best_gauss(counts) if over == "gauss" else counts["scipy-dop853"]
                    ratios.append(x["evaluations"][f"{tolerance:g}"] / least)
            assert len(ratios) == (11 if late else 4)
            found.append(f"{np.exp(np.mean(np.log(ratios))):.2f}")
    return found


def test_the_page_gives_the_means() -> None:
    first, second = SHIPPED
    g, late, d, late_d = means(first, 1e-9)
    assert f"it needs {g} of the evaluations of the best of `gauss-3` to `-6` and {d} of" in PAGE
    assert f"{late} and {late_d} on eleven systems" in PAGE
    g, late, d, late_d = means(first, 1e-6)
    assert f"are {g} and {late} of Gauss, {d} and {late_d} of DOP853" in PAGE
    g, late, d, late_d = means(second, 1e-6)
    assert f"those of `-8b` {g} and {late}, {d} and {late_d}:" in PAGE


def test_the_page_gives_the_means_over_adams_methods() -> None:
    own = {x["problem"]: x["evaluations"]["1e-09"] for x in RUNS if x["method"] == FAST}
    rows = measured("strong-multistep")["adams"]
    shown = []
    for late in (False, True):
        found = [own[x["problem"]] / x["evaluations"]["1e-09"] for x in rows
                 if (x["problem"] in written_down()) == late]  # fmt: skip
        assert len(found) == (11 if late else 4)
        shown.append(f"{np.exp(np.mean(np.log(found))):.2f}")
    assert f"Of the Adams methods of VODE it needs {shown[0]} and {shown[1]}." in PAGE


def test_the_page_says_what_is_lost() -> None:
    """No run of any method in the table is lost without a notice."""
    runs = [x for x in RUNS if x["method"] == "multistep-strong-8"]
    lost = {x["problem"] for x in runs if x["energy"] is None or x["energy"] >= LOST}
    assert len(runs) == 29 and lost == {"dipole-charge", "swinging-atwood"}
    assert "it lost two of 29 systems, each with a notice" in PAGE
    assert "`dipole-charge` and `swinging-atwood` have close encounters" in PAGE
    kept = [x["energy"] for x in runs if x["problem"] not in lost]
    assert f"is at most {max(kept):.1e}, its median {np.median(kept):.1e}" in PAGE
    for x in long_rows():
        if x.get("h") and (x["energy"] is None or x["energy"] >= LOST):
            assert x["reported"] is not None
    gone = [x for x in RUNS if x["problem"] in lost]
    near = [x for x in measured("strong-multistep")["velocities"]
            if x["energy"] is None or x["energy"] >= LOST]  # fmt: skip
    assert len(gone) == len(near) == 4 and max(x["growth"] for x in [*gone, *near]) < 100


def test_the_page_gives_the_times() -> None:
    rows = measured("strong-multistep")["times"]["rows"]
    assert [x["problem"] for x in rows] == list(kept(RUNS))
    shown = [f"{np.median(ratios(rows, steps)):.2f}" for steps in TIMES]
    assert f"medians of its time over that of `gauss-4` are {shown[0]} and {shown[1]}," in PAGE
    taylor = [x["seconds"] for x in measured("strong-multistep")["heyoka"]["rows"]]
    over = np.median([x["own"] / x["heyoka"] for x in taylor])
    assert len(taylor) == len(rows) and f", over that of heyoka {over:.2f}." in PAGE
    assert f"on the {len(rows)} systems without notice" in PAGE


def test_the_page_says_what_a_transformed_time_gains() -> None:
    """All runs are kept; the means are of the better way of the best method."""
    rows = measured("strong-multistep")["transformed"]
    assert all(x["energy"] < LOST for x in rows)
    assert {x["problem"] for x in rows if x["reported"] is not None} == {"hyperbolic-plane"}
    assert {(x["problem"], x["method"]) for x in rows} == {(p, m) for p in RATES for m in SHIPPED}
    counts = [*RUNS, *rows]
    shown = []
    for over in ("dop853", "gauss"):
        for late in (False, True):
            found = []
            for name in dict.fromkeys(x["problem"] for x in RUNS):
                others = rivals(name, 1e-9)
                if others and (name in written_down()) == late:
                    own = [x["evaluations"]["1e-09"] for x in counts if x["problem"] == name]
                    own += [n for key, n in others.items() if key.startswith("multistep")]
                    rival = others["scipy-dop853"] if over == "dop853" else best_gauss(others)
                    found.append(min(own) / rival)
            shown.append(f"{np.exp(np.mean(np.log(found))):.2f}")
    assert f"are, in geometric means, {shown[0]} and {shown[1]} of DOP853" in CLOSE
    assert f"afterwards, {shown[2]} and {shown[3]} of the best Gauss method" in CLOSE
    lost = {name for (name, m), x in fixed().items() if m == FAST and name in RATES
            and (x["energy"] is None or x["energy"] >= LOST)}  # fmt: skip
    assert lost == {"hill-moon", "swinging-atwood", "dipole-charge", "magnetic-bottle"}
    assert f"the best method needs {shown[0]} and {shown[1]} of DOP853" in PAGE


def test_the_page_says_what_it_gains_in_velocities() -> None:
    semi = measured("nonseparable")["semi-separable"]["evaluations"]
    moved = {x["problem"]: x for x in measured("strong-multistep")["transformed"]
             if x["method"] == FAST}  # fmt: skip
    rows = {x["problem"]: moved.get(x["problem"]) or fixed()[x["problem"], FAST] for x in semi}
    assert all(x["energy"] < LOST for x in rows.values())
    found = [
        rows[x["problem"]]["evaluations"]["1e-09"] / best_gauss({k: n for k, n in x["methods"].items() if n})
        for x in semi if x["tolerance"] == 1e-9
    ]  # fmt: skip
    assert len(found) == 7 and len(moved.keys() & rows.keys()) == 4
    mean = np.exp(np.mean(np.log(found)))
    assert f"four of them with a rate, `{FAST}` needs {mean:.2f} of Gauss and loses none" in CLOSE


def test_what_is_timed_is_neither_lost_nor_reported() -> None:
    first = next(x for x in RUNS if x["method"] == FAST and x["problem"] in kept(RUNS))
    for change in ({"reported": 3.0}, {"energy": LOST}):
        other = [x | change if x is first else x for x in RUNS]
        assert kept(other).keys() == kept(RUNS).keys() - {first["problem"]}


@pytest.mark.parametrize(("name", "along", "all_ways"), [("multistep-strong-8", 0.17, 0.098)])
def test_the_page_gives_the_step_sizes(name: str, along: float, all_ways: float) -> None:
    (m,) = load(name).carriers
    U, B, V = (np.array([[float(x) for x in row] for row in M]) for M in (m.U, m.B, m.V))

    def others(z: complex) -> float:
        roots = np.linalg.eigvals(V + z * B @ U)
        return float(abs(np.delete(roots, np.argmin(abs(roots - np.exp(z))))).max())

    assert others(0) < 0.975
    turns = np.exp(1j * np.linspace(0, np.pi, 73))
    assert max(others(z) for z in all_ways * turns) < 1 < max(others(z) for z in 0.105 * turns)
    assert max(others(1j * x) for x in np.linspace(0.01, along, 17)) < 1 < others(0.18j)
    assert f"|\\lambda h| < {along}$ on the imaginary axis and {all_ways} in every" in PAGE
