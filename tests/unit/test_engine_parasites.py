"""A run with an explicit multistep pair never loses its orbit without a notice."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from glmref import Solution, solve
from glmref.engine import run as running
from glmref.engine.kept import method_of
from glmref.engine.outcome import Outcome
from glmref.engine.parasites import (
    MOST_BETWEEN,
    WINDOW,
    Watch,
    over_all,
    stable_up_to,
    step_matrix,
    too_large,
    windows,
)
from glmref.measure.linearised import step_derivatives
from glmref.problems import problem
from glmref.problems.model import Problem
from tests.build import floats

METHODS = ("multistep-general-6", "multistep-general-8", "multistep-general-8b")
SHEAR = Problem.from_hamiltonian("(p**2 + q**2)/2 + 3*p*q/10", {"q": 1, "p": 0})
DRIFT = Problem.from_hamiltonian("p**2/2 + q**4/4 + q**2/2 + q*p/5*(1 + q**2)", {"q": 1, "p": 0})
PARTICLE = Problem.from_hamiltonian("p**2/(2*(1 + q**2)) + q**2/2", {"q": 1, "p": 0})
UNEVEN = Problem.from_hamiltonian(
    "(px**2 + py**2)/(2*(1 + 3*qx**2/10 + qy**2/5)) + (qx**2 + qy**2)/2",
    {"qx": 1, "qy": "1/5", "px": "3/10", "py": "4/5"},
)
LATTICE = Problem.from_hamiltonian(
    "((q1**2 + p1**2)**2 + (q2**2 + p2**2)**2 + (q3**2 + p3**2)**2)/4"
    " - (q1*q2 + p1*p2 + q2*q3 + p2*p3)",
    {"q1": 1, "q2": "1/10", "q3": 0, "p1": 0, "p2": 0, "p3": "1/10"},
)
BINARY = Problem.from_hamiltonian(
    "(px**2 + py**2)/2 - 1/sqrt(qx**2 + qy**2) + e*(qx*px + qy*py)**2/(qx**2 + qy**2)",
    {"qx": "7/10", "qy": 0, "px": 0, "py": "27/20"}, parameters={"e": "1/100"},
)  # fmt: skip


def errors(given: Problem, found: Solution) -> np.ndarray:
    """Return the largest relative error of the energy so far at every row."""
    assert given.hamiltonian is not None
    with np.errstate(all="ignore"):
        energy = np.array([float(given.hamiltonian(y)) for y in found.y])
        return np.maximum.accumulate(np.nan_to_num(np.abs(energy / energy[0] - 1), nan=np.inf))


def check_warned_in_time(given: Problem, method: str, h: float, steps: int) -> None:
    found = solve(given, method, h=h, steps=steps, every=1)
    error = errors(given, found)
    early = max(error[3 * WINDOW], np.finfo(float).eps * 8)
    assert error[-1] > 100 * early  # the orbit is lost
    assert found.suspect is not None
    assert error[int(np.searchsorted(found.t, found.suspect))] < 100 * early
    assert f"from t = {found.suspect:.6g}" in " ".join(found.notices)


@pytest.mark.parametrize(("given", "h"), [(SHEAR, 0.03), (DRIFT, 0.03)])
def test_a_lost_orbit_is_reported_before_the_energy_error_is_a_hundredfold(given, h):
    check_warned_in_time(given, "multistep-general-8", h, 1400)


LOST = [(SHEAR, 0.05, 2000), (SHEAR, 0.01, 6000), (DRIFT, 0.02, 2000), (LATTICE, 0.05, 20_000)]
#: Three sites are too few for the method of least residues to lose them.
KEPT = [(LATTICE, "multistep-general-8")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "h", "steps", "method"),
    [(*row, method) for row in LOST for method in METHODS if (row[0], method) not in KEPT],
)
def test_lost_orbits_are_reported_at_other_steps(given, h, steps, method):
    check_warned_in_time(given, method, h, steps)


def test_an_orbit_that_stays_is_not_reported() -> None:
    found = solve(PARTICLE, "multistep-general-8", h=0.03, steps=200_000, every=1000)
    assert found.suspect is None
    assert found.notices == ()
    assert found.evaluations == 200_000
    assert errors(PARTICLE, found)[-1] < 1e-6


@pytest.mark.slow
@pytest.mark.parametrize(
    ("given", "method", "h"),
    [
        (UNEVEN, "multistep-general-6", 0.02),
        (UNEVEN, "multistep-general-8", 0.02),
        (BINARY, "multistep-general-8", 0.02),
        (PARTICLE, "multistep-general-8b", 0.03),
        (problem("point-vortices"), "multistep-general-8", 0.02),
        (problem("double-pendulum", q1="1/2", q2="3/10"), "multistep-general-8", 0.02),
    ],
    ids=["uneven-6", "uneven-8", "binary-8", "particle-8b", "vortices-8", "pendulum-8"],
)
def test_orbits_that_stay_are_not_reported(given: Problem, method: str, h: float) -> None:
    found = solve(given, method, h=h, steps=1_000_000, every=100)
    error = errors(given, found)
    assert error[-1] < 30 * max(error[50], 1e-13)
    assert found.suspect is None


@pytest.mark.parametrize("how", [{"every": 7}, {"times": [1.2, 2.85, 6.0, 30.0]}])
@pytest.mark.parametrize("renew", [0, 150])
def test_what_is_computed_is_the_same_as_without(how, renew, monkeypatch):
    given = replace(PARTICLE, t_span=(0.0, 30.0))
    found = solve(given, "multistep-general-8", h=0.03, renew=renew, **how)
    monkeypatch.setattr(running, "watched", lambda *_: False)
    without = solve(given, "multistep-general-8", h=0.03, renew=renew, **how)
    assert np.array_equal(found.t, without.t)
    assert np.array_equal(found.y, without.y)
    assert found.total_evaluations == without.total_evaluations


@pytest.mark.parametrize("how", [{}, {"every": 7}, {"times": [1.2, 3.0]}, {"history": True}])
def test_a_formula_whose_solution_is_its_first_value_is_watched_too(how, monkeypatch) -> None:
    given = replace(problem("kepler"), t_span=(0.0, 3.0))
    found = [
        solve(given, "leapfrog-one-leg", h=0.01, engine=engine, **how)
        for engine in ("compiled", "interpreted", "reference")
    ]
    assert running.watched(method_of("leapfrog-one-leg"), given)
    monkeypatch.setattr(running, "watched", lambda *_: False)
    without = solve(given, "leapfrog-one-leg", h=0.01, **how)
    assert np.array_equal(found[0].y, without.y) and np.array_equal(found[1].y, without.y)
    np.testing.assert_allclose(found[2].y, without.y, atol=1e-9)


def test_every_engine_reports_the_same_orbit(tmp_path: Path) -> None:
    given = replace(DRIFT, t_span=(0.0, 45.0))
    # the reference looks at every window, a kernel first at few and then again
    found = [
        solve(given, "multistep-general-8", h=0.03, engine=engine)
        for engine in ("compiled", "interpreted", "reference")
    ]
    assert found[0].suspect == found[1].suspect
    assert found[2].suspect is not None
    assert abs(found[2].suspect - float(found[0].suspect or 0)) <= WINDOW * 0.03
    assert Solution.load(found[0].save(tmp_path / "lost.npz")).suspect == found[0].suspect


def test_without_a_hamiltonian_the_truncation_error_is_the_measure() -> None:
    given = replace(SHEAR, hamiltonian=None)
    found = solve(given, "multistep-general-8", h=0.05, steps=2000)
    assert found.suspect is not None
    assert solve(replace(PARTICLE, hamiltonian=None), "multistep-general-8", h=0.03,
                 steps=20_000).suspect is None  # fmt: skip


def unstable(p2: str) -> Problem:
    """Return an oscillator beside q2' = -3 q2/10, p2' = 3 p2/10."""
    hamiltonian = "(p1**2 + q1**2)/2 - 3*p2*q2/10"
    return Problem.from_hamiltonian(hamiltonian, {"q1": 1, "q2": 1, "p1": 0, "p2": p2})


def test_growth_that_the_energy_does_not_show_is_reported_at_a_tenth_of_the_solution() -> None:
    """With p2 = 0 the energy does not depend on q2."""
    given = unstable("0")
    found = solve(given, "multistep-general-8b", h=0.045, steps=1556, every=1)
    assert errors(given, found)[-1] < 1e-12
    assert abs(found.y[-1, 1]) > 1e17  # exp(-21) is the solution; how far rounding begins it varies
    assert found.suspect is not None
    at = found.y[int(np.searchsorted(found.t, found.suspect))]
    assert abs(at[1]) < 10
    seen = solve(unstable("1/1000"), "multistep-general-8b", h=0.045, steps=1556).suspect
    assert seen is not None and seen < found.suspect


def test_growth_that_the_energy_does_not_show_is_not_reported_before() -> None:
    given = unstable("0")
    found = solve(given, "multistep-general-8", h=0.05, steps=1300)
    assert 1e-4 < abs(found.y[-1, 1]) < 0.1  # exp(-19.5) is the solution
    assert found.suspect is None
    without = solve(replace(given, hamiltonian=None), "multistep-general-8", h=0.05, steps=1300)
    assert without.suspect is not None


def steps_of(energy: float, parasitic: float, angle: float, half: int) -> np.ndarray:
    """Return a window of an oscillator with an energy error and a part that alternates."""
    n = np.arange(WINDOW)
    radius, wave = np.sqrt(1 + energy), parasitic * np.cos(n * angle)
    y = radius * np.stack([np.cos(n / 20), -np.sin(n / 20)], axis=1)
    y[:, half] += wave
    return y


@pytest.mark.parametrize("half", [0, 1])
@pytest.mark.parametrize("name", [*METHODS, "multistep-kinetic-8"])
def test_a_part_that_alternates_with_a_root_of_its_half_is_seen(name: str, half: int) -> None:
    """It is with the energy that a notice follows; a part that was there at first is none."""
    method = method_of(name)
    component = method.components[half]
    V = floats(component.V)
    given = replace(PARTICLE, hamiltonian=oscillator)
    for angle in np.angle(np.linalg.eigvals(V)):
        if angle < 1e-6:
            continue
        for energy, parasitic, seen in ((1e-6, 1e-7, True), (1e-6, 1e-11, False),
                                        (0.0, 1e-9, False), (0.0, 0.3, True)):  # fmt: skip
            watch = Watch(method, given)
            for step in (WINDOW, 2 * WINDOW, 3 * WINDOW):
                assert not watch.large(steps_of(1e-9, 1e-10, angle, half), step)
            assert watch.large(steps_of(energy, parasitic, angle, half), 2000) is seen


def test_an_energy_error_without_a_parasitic_part_is_not_reported() -> None:
    watch = Watch(method_of("multistep-general-8"), replace(PARTICLE, hamiltonian=oscillator))
    for step in (WINDOW, 2 * WINDOW, 3 * WINDOW):
        assert not watch.large(steps_of(1e-9, 0.0, 1.0, 0), step)
    assert not watch.large(steps_of(1e-3, 0.0, 1.0, 0), 2000)


def test_an_energy_near_zero_is_no_measure() -> None:
    """Where the first steps have errors of 1e6 relative, 1.5 times that is not a loss."""
    start = float(oscillator(np.array(PARTICLE.y0, dtype=float)))
    near = replace(PARTICLE, hamiltonian=lambda y: oscillator(y) - start * (1 - 1e-9))
    watch = Watch(method_of("multistep-kinetic-8"), near)
    assert watch.energy_scale > 1e6
    for step, energy in ((WINDOW, 0.0), (2 * WINDOW, 1e-3), (3 * WINDOW, 0.0)):
        assert not watch.large(steps_of(energy, 0.0, 1.0, 0), step)
    assert not watch.large(steps_of(1.5e-3, 0.0, 1.0, 0), 2000)
    assert watch.large(steps_of(0.9, 0.0, 1.0, 0), 2000)


@pytest.mark.parametrize(
    ("first", "later", "seen"),
    [(1e-9, 0.05, False), (1e-9, 0.15, True), (0.01, 0.15, True), (0.06, 0.15, False)],
)
def test_an_energy_that_is_wrong_by_a_tenth_is(first: float, later: float, seen: bool) -> None:
    """As after an encounter that a renewal followed, and where it has grown threefold."""
    watch = Watch(method_of("multistep-kinetic-8"), replace(PARTICLE, hamiltonian=oscillator))
    for step, energy in ((WINDOW, 0.0), (2 * WINDOW, first), (3 * WINDOW, 0.0)):
        assert not watch.large(steps_of(energy, 0.0, 1.0, 0), step)
    assert watch.large(steps_of(later, 0.0, 1.0, 0), 2000) is seen


@pytest.mark.parametrize(
    ("first", "later", "seen"),
    [(1e-9, 9e-4, False), (1e-9, 1.1e-3, True), (3e-4, 5.9e-3, False), (3e-4, 6.1e-3, True)],
)
def test_an_energy_of_a_formula_that_is_wrong_by_a_thousandth_is(
    first: float, later: float, seen: bool
) -> None:
    """And has grown twentyfold; no parasitic part is there to be seen."""
    watch = Watch(method_of("multistep-strong-8"), replace(PARTICLE, hamiltonian=oscillator))
    for step in (WINDOW, 2 * WINDOW, 3 * WINDOW):
        assert not watch.large(steps_of(first, 0.0, 1.0, 0), step)
    assert watch.large(steps_of(later, 0.0, 1.0, 0), 2000) is seen


@pytest.mark.parametrize(
    ("method", "known"), [("multistep-strong-8", 1e-9), ("multistep-general-8", 1e-6)]
)
def test_first_steps_that_are_taken_again_count_where_parts_grow(method: str, known: float) -> None:
    watch = Watch(method_of(method), replace(PARTICLE, hamiltonian=oscillator))
    for energy, step in ((1e-9, 3 * WINDOW), (1e-9, 2000), (1e-6, 2 * WINDOW)):
        watch.large(steps_of(energy, 0.0, 1.0, 0), step)
    assert watch.energy_error == pytest.approx(known, rel=1e-3)


def test_rows_that_are_asked_for_are_looked_at_between_windows() -> None:
    rows, end = (
        solve(DRIFT, "multistep-general-8", h=0.02, steps=2000, every=every).suspect
        for every in (50, 2000)
    )
    assert rows is not None and end is not None and rows < end


@given(st.lists(st.sampled_from([1e-10, 1e-8, 1e-7]), min_size=1, max_size=8))
def test_growth_begins_where_the_energy_last_left_the_error_of_the_first_steps(errors) -> None:
    """At 20 times the error; twice is no growth, but no return either."""
    watch = Watch(method_of("multistep-strong-8"), replace(PARTICLE, hamiltonian=oscillator))
    for step in (WINDOW, 2 * WINDOW, 3 * WINDOW):
        watch.large(steps_of(4e-9, 0.0, 1.0, 0), step)
    for number, error in enumerate(errors):
        watch.large(steps_of(error, 0.0, 1.0, 0), 1000 + number)
    returned = max((k for k, x in enumerate(errors) if x == 1e-10), default=-1)
    after = [1000 + k for k, x in enumerate(errors) if k > returned and x == 1e-7]
    assert watch.grown == (after[0] if after else None)


@pytest.mark.parametrize(
    ("method", "h", "y0"),
    [
        ("multistep-strong-8", 0.006, {"qx": -0.625, "qy": 0.578, "px": -0.363, "py": -0.294}),
        ("multistep-strong-8b", 0.006, {"qx": 0.956, "qy": 0.752, "px": 0.178, "py": -0.314}),
        ("multistep-strong-8b", 0.015, {"qx": 0.802, "qy": -0.807, "px": 0.315, "py": 0.322}),
    ],
)
def test_an_orbit_that_is_lost_among_the_first_steps_is_reported(
    method: str, h: float, y0: Any
) -> None:
    """At an encounter at step 175 or 104, in the second window, or 261, between two of them."""
    H = "(px**2 + py**2)/2 - 1/sqrt(qx**2 + qy**2) - qx**2/(100*(qx**2 + qy**2)**(3/2))"
    given = Problem.from_hamiltonian(H, y0)
    found = solve(given, method, h=h, steps=1500, every=1)
    error = errors(given, found)
    assert np.median(error[:WINDOW]) < 1e-9 and error[-1] > 1e-3
    assert found.suspect is not None and found.suspect < 400 * h


def test_a_notice_is_of_the_time_at_which_a_formula_began_to_lose_its_orbit() -> None:
    """Its parasitic part is seen when the energy error has grown 1,700-fold."""
    given, h = problem("magnetic-bottle"), 0.0121
    found = solve(given, "multistep-strong-8b", h=h, steps=100_000, every=1)
    energy = given.hamiltonian(found.y[:88_000].T)
    error = np.abs(energy / energy[0] - 1)
    assert found.suspect is not None
    medians = np.median(error[: len(error) // WINDOW * WINDOW].reshape(-1, WINDOW), axis=1)
    first = error[: 3 * WINDOW + 1].max()
    assert medians[: round(found.suspect / h) // WINDOW].max() < 100 * first < medians.max() / 10


def test_windows_of_long_runs_leave_gaps_in_which_nothing_is_seen() -> None:
    assert max(np.diff(windows(100_000, 0))) > 20_000


def oscillator(y: Any) -> Any:
    return (y[0] ** 2 + y[1] ** 2) / 2


def test_a_run_whose_values_overflow_is_reported_too() -> None:
    found = solve(DRIFT, "multistep-general-8", h=0.03, steps=20_000)
    assert found.outcome is Outcome.NOT_FINITE
    assert found.suspect is not None
    assert found.suspect < found.t[-1]


def test_renewal_keeps_an_orbit_that_is_lost_without() -> None:
    with_ = solve(SHEAR, "multistep-general-8", h=0.03, steps=20_000, renew=200, every=100)
    assert with_.suspect is None
    assert errors(SHEAR, with_)[-1] < 1e-11  # without, the numbers overflow
    assert with_.renewals == 99


@given(st.integers(0, 400_000), st.one_of(st.just(0), st.integers(1, 20_000)))
def test_windows_lie_within_the_run_and_between_renewals(steps: int, renew: int) -> None:
    found = windows(steps, renew)
    assert all(b - a >= WINDOW for a, b in pairwise(found))
    assert all(0 <= b <= steps - WINDOW for b in found)
    assert all(b - a <= min(a + WINDOW, MOST_BETWEEN) + 2 * renew for a, b in pairwise(found))
    if renew:
        assert all(b // renew == (b + WINDOW - 1) // renew for b in found)
    if steps >= WINDOW and not 0 < renew < WINDOW:  # the end is looked at
        assert found[-1] > steps - 2 * WINDOW - renew


def turning(omega: float) -> np.ndarray:
    """The matrix of H = (p^2 + q^2)/2 + omega (q_1 p_2 - q_2 p_1), (4, 4)."""
    turn, one = omega * np.array([[0.0, -1.0], [1.0, 0.0]]), np.eye(2)
    return np.block([[turn, one], [-one, turn]])


@pytest.mark.parametrize(("omega", "bound"), [(0.0, 0.3), (0.5, 0.19), (1.0, 0.14), (2.0, 0.085)])
def test_the_largest_step_is_where_roots_leave_the_circle(omega: float, bound: float) -> None:
    method = method_of("multistep-general-8")
    found = stable_up_to(method, turning(omega), 0.4)
    assert found is not None
    assert abs(found - bound) < 0.4 / 64
    assert stable_up_to(method, turning(omega), 0.95 * bound) is None


@pytest.mark.parametrize(
    "J", [[[0.3, 1.0], [-1.0, -0.3]], [[0.0, 1.0], [1.0, 0.0]]], ids=["shear", "saddle"]
)
def test_growth_in_proportion_to_the_step_bounds_no_step(J: list[list[float]]) -> None:
    assert stable_up_to(method_of("multistep-general-8"), np.array(J), 0.05) is None


def test_a_step_that_is_too_large_at_the_start_is_reported_before_the_run() -> None:
    H = "(p1**2 + p2**2)/2 + (q1**2 + q2**2)/2 + q1*p2 - q2*p1"
    one = Problem.from_hamiltonian(H, {"q1": 1, "q2": 0, "p1": 0, "p2": "1/2"})
    assert solve(one, "multistep-general-8", h=0.13, steps=400).notices == ()
    found = solve(one, "multistep-general-8", h=0.15, steps=400)
    assert found.notices[0].startswith("h = 0.15 is beyond 0.14")
    other = solve(one, "multistep-general-8", h=0.15, steps=2, engine="reference")
    assert other.notices == found.notices[:1]
    assert found.suspect is not None  # it is lost indeed


@pytest.mark.parametrize("entry", ["p*(1 + q)*1e305", "p*(1 + sqrt(q**3))"])
def test_derivatives_beyond_range_bound_no_step(entry: str) -> None:
    one = Problem.from_equations({"q": entry, "p": "-q"}, {"q": 0, "p": 1e-3})
    method = method_of("multistep-general-8")
    with np.errstate(all="ignore"):
        assert too_large(method, one, 1e4) == ()


@pytest.mark.parametrize("name", ["multistep-general-8", "multistep-kinetic-8"])
def test_the_matrix_of_a_step_is_its_derivative(name: str) -> None:
    equations = {"x": "u", "y": "v", "u": "2*v - x", "v": "-2*u - 2*y"}
    one = Problem.from_equations(equations, {"x": 1, "y": 0, "u": 0, "v": "1/2"})
    method, h = method_of(name), 0.05
    J = one.jacobian(0.0, np.array(one.y0, dtype=float))
    q, p = method.carriers
    found = step_matrix(over_all(*((c.A, c.U, c.B, c.V) for c in (q, p))), np.asarray(J), h, 2)
    rows = max(len(q.V), len(p.V))
    (whole,) = step_derivatives(method, one, h, np.zeros((1, rows, 4)))
    # values lie row by row with q and p beside each other; here all of q come first
    places = [
        4 * i + k for c, ks in ((q, (0, 1)), (p, (2, 3))) for i in range(len(c.V)) for k in ks
    ]
    assert np.abs(found - whole[np.ix_(places, places)]).max() < 1e-13


@pytest.mark.parametrize(
    ("name", "method", "h"),
    [
        ("discrete-schroedinger", "multistep-general-8b", 0.022),
        ("hyperbolic-oscillator", "multistep-general-6", 0.0189),
    ],
)
def test_a_renewed_run_is_looked_at_where_its_energy_has_grown(
    name: str, method: str, h: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The notice is for steps before which the error has not grown a hundredfold; not so late."""
    given, options = problem(name), {"h": h, "steps": 40_000, "every": 1, "renew": 1000}
    found = solve(given, method, **options)
    energy = np.array([float(given.hamiltonian(y)) for y in found.y])
    error = np.abs(energy - energy[0])
    assert found.suspect is not None
    until = round(found.suspect / h)
    medians = np.median(error[: until // WINDOW * WINDOW].reshape(-1, WINDOW), axis=1)
    assert medians.max() < 100 * error[: 3 * WINDOW].max()
    monkeypatch.setattr(Watch, "alarming", lambda *_: [])
    late = solve(given, method, **options).suspect
    assert late is None or late > found.suspect + 200 * h


@pytest.mark.parametrize(
    ("name", "method", "h", "renew"),
    [
        ("discrete-schroedinger", "multistep-general-8b", 0.022, 0),
        ("discrete-schroedinger", "multistep-general-8b", 0.022, 1000),
        ("swinging-atwood", "multistep-general-8", 0.01, 300),
        ("uneven-plane", "multistep-general-8c", 0.05, 0),
        ("double-pendulum", "multistep-general-8c", 0.0139, 150),
        ("point-vortices", "multistep-general-8b", 0.2, 1000),
    ],
)
@pytest.mark.parametrize("energy", [True, False])
def test_windows_looked_at_together_are_judged_as_one_by_one(
    name: str, method: str, h: float, renew: int, energy: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    given = problem(name) if energy else replace(problem(name), hamiltonian=None)
    found = []
    for together, numbers in ((16, 2**23), (1, 2**23), (3, 2**23), (16, 0)):
        monkeypatch.setattr(running, "_TOGETHER", together)
        monkeypatch.setattr(running, "_NUMBERS", numbers)
        run = solve(given, method, h=h, steps=60_000, every=500, renew=renew)
        found.append((run.suspect, run.notices, run.outcome, run.steps, run.y.tobytes()))
    assert all(one == found[0] for one in found)


def test_a_renewal_that_fails_is_looked_at_as_others_are() -> None:
    atwood = problem("swinging-atwood")
    (name, common), *more = atwood.f.common
    assert not more
    *f, last = (x.replace(name, f"({common})") for x in atwood.f.outputs)
    ended = Problem(
        canonical=True, f=(*f, f"({last}) + 0*sqrt({1350.3 * 0.02!r} - t)"), y0=atwood.y0,
        hamiltonian=atwood.hamiltonian.outputs[0], parameters=dict(atwood.parameters),
        t_span=atwood.t_span,
    )  # fmt: skip
    runs = [
        solve(ended, "multistep-general-8b", h=0.02, steps=4500, renew=150, engine=engine)
        for engine in ("compiled", "interpreted")
    ]
    assert [x.suspect for x in runs] == [21.0, 21.0]
    assert all(x.steps == 1350 and "in renewing the values" in x.message for x in runs)


@pytest.mark.parametrize("engine", ["compiled", "interpreted"])
def test_renewals_within_a_window_are_not_watched(engine: str) -> None:
    run = solve("swinging-atwood", "multistep-general-8b", h=0.02, steps=4750, renew=95,
                engine=engine)  # fmt: skip
    assert run.suspect is None and not run.notices


@pytest.mark.parametrize("engine", ["compiled", "interpreted", "reference"])
@pytest.mark.parametrize("renew", [0, 50])
def test_a_step_that_is_too_large_is_reported_whatever_the_renewals(engine, renew) -> None:
    options = {"steps": 60, "renew": renew, "engine": engine}
    found = solve("uneven-plane", "multistep-general-8b", h=0.6, **options)
    assert found.notices[0].startswith("h = 0.6 is beyond ")
    assert not solve("uneven-plane", "multistep-general-8b", h=0.02, **options).notices


def test_an_energy_that_is_no_number_hides_no_other() -> None:
    watch = Watch(method_of("multistep-general-8"), problem("shear"))
    solutions = np.tile(watch.y0, (WINDOW, 1)) * np.linspace(1, 1.1, WINDOW)[:, None]
    watch.large(solutions, WINDOW)
    seen = watch.energy_error
    watch.hamiltonian = lambda y: float("nan")
    watch.large(solutions, 2 * WINDOW)
    assert watch.energy_error == seen > 0
