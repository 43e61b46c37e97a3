"""Extreme and faulty problems do what they say."""

import numpy as np
import pytest

from glmref.problems import problem
from glmref.problems.user_functions import FunctionFailed


@pytest.mark.parametrize(
    ("name", "parameters"),
    [
        *(("kepler", {"eccentricity": e}) for e in ("9/10", "99/100", "999/1000")),
        *(("harmonic-oscillator", {"q0": q0}) for q0 in ("1e-150", "1e150", "1e-310")),
        *(("scaled-kepler", {"length": size}) for size in ("1e-150", "1e150", "1e-170")),
        ("pendulum", {"q0": "3.1415926535", "p0": 0}),
        *((name, {}) for name in ("pythagorean", "dahlquist", "long-chain", "zero-field")),
        *((name, {}) for name in ("linear-field", "henon-heiles")),
    ],
)
def test_extreme_parameters_are_in_range(name, parameters):
    p = problem(name, **parameters)
    with np.errstate(all="ignore"):
        p.f(0.0, p.y0)


@pytest.mark.parametrize("length", ["1e-150", "1", "1e150"])
def test_scaled_orbits_are_orbits_of_another_size(length):
    p, unit = problem("scaled-kepler", length=length), problem("scaled-kepler", length=1)
    size = float(length)
    # five roundings
    assert p.f(0.0, p.y0) / size == pytest.approx(unit.f(0.0, unit.y0), rel=2e-15)
    assert p.solution(1.0) / size == pytest.approx(unit.solution(1.0), rel=2e-15)
    assert p.hamiltonian(p.y0) == pytest.approx(-0.5, abs=2e-15)


def test_orbits_below_the_range_have_a_field_that_is_not_finite():
    p = problem("scaled-kepler", length="1e-170")
    with np.errstate(all="ignore"):
        assert not np.isfinite(p.f(0.0, p.y0)).all()
    assert np.isfinite(p.solution(1.0)).all()


def test_denormal_start_is_kept():
    assert problem("harmonic-oscillator", q0="1e-310").y0[0] == 1e-310


def test_faults_show_after_their_time():
    with np.errstate(all="ignore"):
        assert np.isfinite(problem("fault-nan").f(0.9, np.ones(1))).all()
        assert np.isnan(problem("fault-nan").f(1.1, np.ones(1))).all()
        assert np.isinf(problem("fault-infinity").f(8.0, np.ones(1))).all()
    with pytest.raises(FunctionFailed, match=r"raised RuntimeError: .* does not hold"):
        problem("fault-raises").f(1.1, np.ones(2))
    with pytest.raises(FunctionFailed, match=r"must return shape \(2,\), got \(3,\)"):
        problem("fault-shape").f(0.0, np.ones(2))
    assert problem("fault-jacobian").jacobian(0.0, np.ones(1)) == [[1e6]]
    assert np.isnan(problem("fault-jacobian-nan").jacobian(0.0, np.ones(1))).all()


def test_pythagorean_bodies_start_at_rest_with_zero_momentum():
    p = problem("pythagorean")
    assert p.quadratic["angular momentum z"](p.y0) == 0
    # H = -(3*4/5 + 3*5/4 + 4*5/3) = -769/60
    assert p.hamiltonian(p.y0) == pytest.approx(-769 / 60, rel=1e-15)
    # the centre of mass is at rest at the origin
    weights = np.repeat([3, 4, 5], 2).reshape(3, 2)
    assert (weights * p.y0[:6].reshape(3, 2)).sum(axis=0).tolist() == [0, 0]
