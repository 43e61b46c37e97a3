"""Problems by name: glmref.problem and glmref.problems.names."""

import numpy as np
import pytest

from glmref.errors import UsageError
from glmref.problems import names, problem


@pytest.mark.parametrize("name", names())
def test_every_problem_is_built_and_evaluates(name):
    p = problem(name)
    assert p.name == name and p.source
    if name != "fault-shape":  # which every call refuses, see test_problems_extreme
        with np.errstate(all="ignore"):
            slope = p.f(p.t_span[0], p.y0)
        assert slope.shape == p.y0.shape and np.isfinite(slope).all()
    assert p.t_span[0] < p.t_span[1] and all(x > 0 for x in p.scales.values())


@pytest.mark.parametrize("name", names())
def test_defaults_written_out_give_the_same_problem(name):
    same = problem(name, **problem(name).parameters)
    assert (same.y0 == problem(name).y0).all()


@pytest.mark.parametrize(
    ("name", "given", "says"),
    [
        ("keppler", {}, "did you mean kepler"),
        ("xyz", {}, "`glmref problems` lists them, and so does glmref.problems.names()"),
        ("mine.py", {}, 'write file = "FILE.py:FUNCTION" into a TOML file'),
        (3, {}, "no problem named 3"),
        ("kepler", {"excentricity": 0}, "its parameters are eccentricity"),  # codespell:ignore
        ("hires", {"k": 1}, "it has no parameters"),
        ("kepler", {"eccentricity": 1}, "0 <= eccentricity < 1, got 1"),
        ("kepler", {"eccentricity": -0.1}, "0 <= eccentricity < 1, got -0.1"),
        ("kepler", {"eccentricity": "half"}, "`eccentricity` must be a finite number"),
        ("harmonic-oscillator", {"frequency": 0}, "0 < frequency, got 0"),
        ("fput", {"sites": 1.5}, "whole number from 1 to 1000000"),
        ("fput", {"sites": 0}, "whole number"),
        ("skew-quadratic", {"dimension": 1}, "whole number from 2 to 40"),
        ("arenstorf", {"orbit": 3}, "whole number from 1 to 2"),
        ("long-chain", {"sites": 5, "mode": 6}, "`mode` must be a whole number from 1 to 5"),
        ("lotka-volterra", {"u0": 0}, "0 < u0, got 0"),
        ("stiff-spring-pendulum", {"stretch": -1}, "-1 < stretch, got -1"),
    ],
)
def test_wrong_requests_are_one_sentence(name, given, says):
    with pytest.raises(UsageError) as error:
        problem(name, **given)
    assert says in str(error.value) and "\n" not in str(error.value)
