"""Paths in a plane: which plane, which points, and where they stop."""

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.errors import UsageError
from glmref.measure.orbit import POINTS, marks, orbit, plane_of
from glmref.problems import Problem, problem


@pytest.mark.parametrize(
    ("name", "axes", "pairs"),
    [
        ("kepler", ("q_1", "q_2"), [(0, 1)]),
        ("pendulum", ("q", "p"), [(0, 1)]),
        ("rigid-body", ("y_1", "y_2"), [(0, 1)]),
        ("van-der-pol", ("y_1", "y_2"), [(0, 1)]),
        ("figure-eight", ("x", "y"), [(0, 1), (2, 3), (4, 5)]),
        ("outer-solar-system", ("x", "y"), [(3 * k, 3 * k + 1) for k in range(6)]),
    ],
)
def test_the_plane_is_that_of_the_first_two_places(name, axes, pairs):
    assert plane_of(problem(name)) == (axes, pairs)


def test_one_component_has_no_plane_and_bodies_must_divide_the_state():
    with pytest.raises(UsageError, match="one component"):
        plane_of(Problem(f=lambda t, y: -y, y0=[1.0]))
    for bodies in (0, 3):
        with pytest.raises(UsageError, match=f"`bodies` must divide .* got {bodies}"):
            Problem(force=("0", "0"), y0=[1, 0, 0, 1], bodies=bodies)


def test_marks_are_spread_evenly_from_the_start_to_the_end():
    for steps in (1, 7, 399, 400, 10_000, 123_457):
        found = marks(steps, POINTS)
        assert found[0] == 0 and found[-1] == steps and found == sorted(set(found))
        assert len(found) <= POINTS
        # of n places {k phi} the largest gap is below 1.9/n (three gaps, the ratio of two is phi)
        assert max(np.diff(found)) <= 1.9 * steps / (POINTS - 1) + 1


def largest_gap(places, period):
    """Largest part of a revolution without a point."""
    phases = np.sort(np.unique(np.array(places) % period)) / period
    return float(np.max(np.diff([*phases, phases[0] + 1])))


@pytest.mark.parametrize("period", [50, 100, 101, 250, 400, 800, 1000])
def test_no_revolution_beats_with_the_marks(period):
    steps = 100 * period
    assert largest_gap(marks(steps, POINTS), period) < 0.05
    # evenly spaced ones do beat: one in steps/400 is four to a revolution, always the same four
    evenly = range(0, steps, steps // POINTS)
    if period % 4 == 0:
        assert largest_gap(evenly, period) > 0.2


@pytest.mark.slow
def test_points_lie_on_the_path():
    subject = problem("kepler")
    found = orbit(subject, load("gauss-5"), h=2 * np.pi / 200, steps=400)
    # gauss-5 at 200 steps a revolution errs by less than 1e-9 here; seven digits are kept
    exact = np.array([subject.solution(t)[:2] for t in found.t])
    assert np.max(np.abs(found.paths[0] - exact)) < 1e-6
    assert np.max(np.abs(found.paths[0] - exact[:, ::-1])) > 0.5  # the axes are not exchanged
    assert found.ended == "" and found.t[-1] == pytest.approx(4 * np.pi)


def test_bodies_share_the_points():
    found = orbit(problem("figure-eight"), load("gauss-2"), h=0.05, steps=1000)
    assert found.paths.shape == (3, POINTS // 3, 2)
    # one curve is followed by all: each passes the start of every other one
    for path in found.paths:
        for start in found.paths[:, 0]:
            assert np.min(np.linalg.norm(path - start, axis=1)) < 0.2


def test_an_energy_of_zero_has_the_size_of_its_terms():
    # r (H + w) is 0 at the start, but for rounding
    subject = problem("kepler-sundman")
    assert abs(subject.hamiltonian(subject.y0)) < 1e-15
    found = orbit(subject, load("rk4"), h=0.1, steps=300)
    assert found.ended == "" and len(found.t) > 200
    assert orbit(subject, load("euler"), h=0.1, steps=3000).ended.startswith("lost after")


def test_numbers_that_are_not_finite_are_left_out():
    pair = Problem(f=("y[0]*y[0]", "y[1]"), y0=[1, 1], t_span=(0, 2))
    found = orbit(pair, load("rk4"), h=0.1, steps=20)
    assert found.ended and np.isfinite(found.paths).all()
    assert 1.0 <= found.t[-1] < 2.0
