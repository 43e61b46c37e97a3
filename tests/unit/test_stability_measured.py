"""Stability measured in double precision, against what the theory computes exactly."""

import math
from itertools import pairwise

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.engine.solve import solve
from glmref.measure.stability import GRID, amplification, bounded, interval, locus, region
from glmref.problems import problem
from glmref.theory.periodicity import periodicity
from glmref.theory.stability import stability_matrix
from glmref.theory.stability_interval import imaginary_interval, real_interval

# --- the matrix -----------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rk4", "gauss-2", "bdf-3", "g6245", "ark-4", "gsymplectic-n"])
def test_the_matrix_is_that_of_the_theory(name):
    method = load(name)
    exact = np.array([[complex(x) for x in row] for row in stability_matrix(method, -3)])
    # entries up to 30, formed in (s + 1) roundings each
    assert amplification(method, -3.0) == pytest.approx(exact, rel=1e-12, abs=1e-12)


# --- intervals ------------------------------------------------------------------------------------

WITH_INTERVAL = (
    "leapfrog", "milne-simpson", "gsymplectic-n", "thesis-3-8", "s4-symmetric", "g4123", "g6245",
    "g6245-w3", "s3-w3", "s4-w3", "s5i1-i", "s5i2-w3", "c2-3-10-w3",
)  # fmt: skip


QUICK = {"leapfrog", "gsymplectic-n", "g6245-w3"}


@pytest.mark.sampled(2, besides=("g6245-w3",))
@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in WITH_INTERVAL]
)
def test_measured_periodicity_intervals_are_the_computed_ones(name):
    method = load(name)
    computed = periodicity(method, conserving=not method.is_exact)
    assert computed.value is not None
    # two eigenvalues meet and leave like the root of the distance: growth of 1e-7 is seen 1e-14
    # late; the ball around the computed end has the width 1e-10
    assert interval(method) == pytest.approx(computed.value, abs=1e-9)


@pytest.mark.parametrize("name", ["gsymplectic-p", "yoshida-4", "gauss-2"])
def test_methods_with_a_definite_form_never_leave_the_circle(name):
    assert periodicity(load(name)).infinite
    assert interval(load(name)) == 64.0


@pytest.mark.sampled(6, besides=("cooper",))
@pytest.mark.parametrize(
    "name",
    ["euler", "heun-2", "heun-3", "rk4", "kutta-3", "dormand-prince-5", "cooper-verner-8", "ab-4",
     "am-3", "ark-4", "bdf-5"],
)  # fmt: skip
def test_measured_intervals_are_the_ones_that_are_proved(name):
    method = load(name)
    # growth of 1e-7 is seen late: by 1e-7 where R crosses 1, by more where it leaves it slowly
    for proved, direction, late in ((real_interval(method), -1, 1e-6),
                                    (imaginary_interval(method), 1j, 1e-3)):  # fmt: skip
        end = pytest.approx(min(proved.end, 64), abs=late if proved.end else 0.2)
        assert interval(method, direction) == end


@pytest.mark.slow
def test_a_short_escape_is_seen_with_enough_samples_only():
    method = load("g6245")
    assert interval(method) == pytest.approx(1.8290546, abs=1e-6)
    # near miss: points 1/16 apart step over the gap between 1.829 and 1.851
    assert interval(method, samples=1024) == pytest.approx(2.504, abs=1e-3)
    assert not bounded(method, 1.84j) and bounded(method, 1.9j)


# --- boundaries and regions -----------------------------------------------------------------------


@pytest.mark.parametrize("name", ["rk4", "bdf-3", "gauss-2", "ab-3", "g6245", "ark-4"])
def test_every_traced_point_has_an_eigenvalue_on_the_circle(name):
    method = load(name)
    found = locus(method, turns=60)
    values = np.linalg.eigvals(amplification(method, found.z))
    gap = np.min(np.abs(values - found.w[:, None]), axis=1)
    # an eigenvalue of multiplicity k is found to about eps^(1/k); points far out are ill-conditioned
    assert np.median(gap) < 1e-10 and np.mean(gap < 1e-5) > 0.95
    assert not np.any(gap[np.abs(found.z) < 10] > 1e-3)


def area(rings):
    """Return the area of closed polygons; holes run the other way round."""
    sides = ((a, b) for ring in rings for a, b in pairwise(ring))
    return abs(sum(x * v - u * y for (x, y), (u, v) in sides)) / 2


def test_the_region_of_euler_is_the_disc():
    found = region(load("euler"))
    # polygons with vertices on the circle, a cell apart
    assert math.pi - 0.01 < area(found.rings) < math.pi


def test_an_a_stable_method_fills_the_left_half():
    found = region(load("gauss-2"))
    assert area(found.rings) == pytest.approx(2 * found.reach**2, rel=1 / GRID)
    assert not bounded(load("bdf-3"), 0.5j) and bounded(load("bdf-2"), 0.5j)


# --- thresholds -----------------------------------------------------------------------------------


def threshold(target, method, *, low, high, steps, width, good):
    """Largest step size, by bisection, at which a run is completed and good."""

    def stays(h):
        with np.errstate(all="ignore"):
            found = solve(target, method, h=h, steps=steps, every=max(1, steps // 256))
        return found.completed and good(np.abs(found.y))

    assert stays(low) and not stays(high)
    while high - low > width * low:
        middle = (low + high) / 2
        low, high = (middle, high) if stays(middle) else (low, middle)
    return low


def test_the_threshold_of_the_oscillator_is_the_periodicity_interval():
    method = load("gsymplectic-n")
    # beyond the end an eigenvalue grows like 1 + c sqrt(delta) with c near 1: delta = 1e-6 gives
    # exp(60) after 60,000 steps. Before it the two eigenvalues are close, and the amplitude may
    # reach c / sqrt(delta), which must be allowed
    found = threshold(
        problem("harmonic-oscillator"), method, low=1.5, high=2.3, steps=60_000, width=1e-7,
        good=lambda sizes: np.max(sizes) < 1e6,
    )  # fmt: skip
    assert found == pytest.approx(periodicity(method).value, abs=1e-6)


def test_a_nonlinear_threshold_lies_below_the_linear_one():
    # the pendulum near its upper rest point has the frequencies of all its harmonics
    found = threshold(
        problem("pendulum", q0="23/10"), load("s4-symmetric"), low=0.2, high=3.0, steps=2000,
        width=1e-3, good=lambda sizes: np.max(sizes) < 3 * np.max(sizes[0]),
    )  # fmt: skip
    assert 0.2 < found < periodicity(load("s4-symmetric")).value
