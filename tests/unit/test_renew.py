"""``solve(..., renew=n)``: the carried values are made anew by the starting method."""

from dataclasses import replace

import numpy as np
import pytest

from glmref import solve
from glmref.engine.outcome import Outcome
from glmref.problems import problem
from glmref.problems.model import Problem

KEPLER = problem("kepler", eccentricity="3/10")


@pytest.mark.sampled(3, besides=("g6245",))
@pytest.mark.parametrize("engine", ["compiled", "reference"])
@pytest.mark.parametrize("method", ["g6245-w3", "pair-rkn-6-8b", "ab-4"])
def test_a_renewal_is_a_new_run_from_the_solution(method: str, engine: str) -> None:
    whole = solve(KEPLER, method, h=0.05, steps=90, renew=30, every=10, engine=engine)
    y, parts, spent = KEPLER.y0, [], 0
    for _ in range(3):
        part = solve(replace(KEPLER, y0=tuple(y)), method, h=0.05, steps=30, engine=engine)
        y, spent = part.y[-1], spent + part.start_evaluations
        parts.append(y)
    assert whole.renewals == 2
    assert np.array_equal(whole.y[[3, 6, 9]], parts)
    assert np.array_equal(whole.t, np.arange(0, 91, 10) * 0.05)
    assert whole.start_evaluations == spent
    kept = solve(KEPLER, method, h=0.05, times=[1.0, 4.5], renew=30, engine=engine)
    assert np.array_equal(kept.y[-1], whole.y[-1])
    # the near miss: another interval gives other values
    other = solve(KEPLER, method, h=0.05, steps=90, renew=31, engine=engine)
    assert not np.array_equal(other.y[-1], whole.y[-1])


@pytest.mark.sampled(1, besides=("compiled",))
@pytest.mark.parametrize("engine", ["compiled", "reference"])
def test_a_renewal_that_fails_ends_the_run_and_keeps_what_there_is(engine: str) -> None:
    def slope(t: float, y: np.ndarray) -> np.ndarray:
        # steps look at nothing later than t + h, the start of this method at t + h and more
        return np.array([1.0 if t < 1.0 or y[0] < 2.9 else np.nan])

    ramp = Problem(name="ramp", y0=(0.0,), t_span=(0.0, 10.0), f=slope)
    run = solve(ramp, "ab-4", h=0.1, steps=100, renew=29, every=1, engine=engine)
    assert run.outcome is Outcome.NOT_FINITE
    assert run.steps == 29
    assert "in renewing the values" in run.message
    assert np.allclose(run.y[:, 0], run.t)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["g6245-w3", "pair-rkn-6-8b"])
@pytest.mark.parametrize("eccentricity", ["1/10", "3/10"])
def test_renewed_orbits_stay_and_others_are_lost(method: str, eccentricity: str) -> None:
    orbit = problem("kepler", eccentricity=eccentricity)
    assert orbit.hamiltonian is not None

    def growth(renew: int) -> float:
        run = solve(orbit, method, h=0.12, steps=4_000_000, every=1000, renew=renew)
        energy = np.array([orbit.hamiltonian(y) for y in run.y])  # type: ignore[misc]
        error = np.abs(energy / energy[0] - 1)
        return float(error[-400:].max() / error[:40].max())

    assert growth(10_000) < 2 < 1000 < growth(0)
