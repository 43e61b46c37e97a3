"""Problems by name: glmref.problem and glmref.problems.names."""

import numpy as np
import pytest

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
