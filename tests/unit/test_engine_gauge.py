"""A shear of the coordinates removes the mean growth of a parasitic part, where one can."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref import Solution, solve
from glmref.engine.gauge import FEWEST, Gauge
from glmref.problems import problem
from glmref.problems.model import Problem

METHOD = "multistep-general-8"


def energy_error(of: Problem, found: Solution) -> float:
    assert of.hamiltonian is not None
    energy = np.array([float(of.hamiltonian(y)) for y in found.y])
    return float(np.abs(energy / energy[0] - 1).max())


@pytest.mark.parametrize("name", ["shear", "quartic-shear"])
def test_a_run_that_is_lost_is_kept_in_the_sheared_coordinates(name: str) -> None:
    one = problem(name)
    run = {"h": 0.02, "steps": 20_000, "every": 100}
    with np.errstate(all="ignore"):
        lost = solve(one, METHOD, **run)
        kept = solve(one, METHOD, gauge="auto", **run)
    assert lost.suspect is not None
    assert lost.gauge is None
    assert kept.suspect is None
    assert kept.gauge.taken
    assert kept.gauge.evaluations >= 1000
    assert energy_error(one, kept) < 1e-9
    early = slice(0, 3)
    assert np.allclose(kept.y[early], lost.y[early], rtol=0, atol=1e-8)


def test_no_shear_removes_a_chaotic_growth() -> None:
    """The means over the halves of the pilot orbit differ: no constant removes both."""
    one = problem("discrete-schroedinger")
    found = solve(one, METHOD, h=0.02, steps=3000, gauge="auto")
    plain = solve(one, METHOD, h=0.02, steps=3000)
    assert not found.gauge.taken
    assert found.gauge.before > 0.01
    assert (found.y == plain.y).all()


@pytest.mark.parametrize(
    "H",
    [
        # H_pq is antisymmetric, then nilpotent: nothing grows exponentially
        "((px + qy/2)**2 + (py - qx/2)**2)/2 + (qx**2 + 2*qy**2)/2 + qx**4/4",
        "((px + qy)**2 + py**2)/2 + (qx**2 + 2*qy**2)/2 + qx**4/4",
        # the mean over an orbit that the reversal maps to itself is 0
        "(px**2 + py**2)/(2*(1 + qx**2)) + (qx**2 + 2*qy**2)/2",
    ],
)
def test_nothing_is_done_where_nothing_grows(H: str) -> None:
    one = Problem.from_hamiltonian(H, {"qx": 1, "qy": 0, "px": 0, "py": "1/2"})
    found = solve(one, METHOD, h=0.02, steps=2000, gauge="auto")
    assert not found.gauge.taken
    assert "none is applied" in str(found.gauge)


numbers = st.fractions(min_value=-1, max_value=1, max_denominator=8)


@given(st.tuples(numbers, numbers, numbers), st.lists(st.floats(-1, 1), min_size=4, max_size=4))
@settings(max_examples=5)
def test_the_sheared_system_is_the_same_motion(entries: tuple[object, ...], y: list[float]) -> None:
    a, b, c = (float(x) for x in entries)  # type: ignore[arg-type]
    one = Problem.from_hamiltonian(
        "px**2/2 + py**2*(1 + qx**2)/2 + qx*py/3 + cos(qy)", {"qx": 1, "qy": 0, "px": 0, "py": 1}
    )
    G = np.array([[a, b], [b, c]])
    other = Gauge(((a, b), (b, c)), 1.0, 0.0, True, 0).sheared(one)
    old = np.array(y)
    new = np.concatenate([old[:2], old[2:] + G @ old[:2]])
    slope = one.f(0.0, old)
    assert np.allclose(other.f(0.0, new), np.append(slope[:2], slope[2:] + G @ slope[:2]))
    assert one.hamiltonian is not None
    assert other.hamiltonian is not None
    assert float(other.hamiltonian(new)) == pytest.approx(float(one.hamiltonian(old)))


def test_the_gauge_is_saved_with_the_solution(tmp_path: Path) -> None:
    found = solve("shear", METHOD, h=0.02, steps=200, gauge="auto")
    assert Solution.load(found.save(tmp_path / "sheared.npz")).gauge == found.gauge


def test_short_runs_take_no_pilot_orbit() -> None:
    found = solve("shear", METHOD, h=0.02, steps=FEWEST - 1, gauge="auto")
    assert found.gauge == Gauge(((0.0,),), 0.0, 0.0, False, 0)
