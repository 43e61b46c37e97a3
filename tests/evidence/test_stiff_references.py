"""Where a reference exists, an error measured against it is right to the bound the record claims."""

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.errors import UsageError
from glmref.measure.work_precision import _computed, measure, reference_state, state_error
from glmref.problems import problem

# problem, parameters, time: with a closed form, or with a stored reference
KNOWN = [
    ("harmonic-oscillator", {}, 7.0),
    ("kepler", {"eccentricity": "9/10"}, 6.0),
    ("kepler-sundman", {"eccentricity": "9/10"}, 6.0),
    ("prothero-robinson", {"stiffness": 100}, 2.0),
    ("prothero-robinson", {"stiffness": 10**6}, 2.0),
    ("kaps", {"epsilon": "1/1000"}, 1.0),
    ("henon-heiles", {}, 100.0),
    ("stiff-spring-pendulum", {}, 10.0),
    ("fput-stiff", {"omega": 50}, 10.0),
    ("hires", {}, 321.8122),
    ("van-der-pol", {"mu": 1000}, 2.0),
    ("van-der-pol", {"mu": 10**6}, 0.5),
    ("robertson", {}, 40.0),
]


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("name", "parameters", "t"), KNOWN)
def test_a_computed_reference_errs_by_less_than_it_says_or_is_refused(name, parameters, t):
    subject = problem(name, **parameters)
    right = reference_state(subject, t)
    assert right.kind in ("exact", "stored")
    try:
        computed = _computed(subject, t)
    except UsageError as error:
        assert "no reference for" in str(error)
        return
    error = state_error(computed.state, right)
    # order 10: the finer run errs by 1/1023 of the difference; what is left is round-off, of which
    # the difference is one sample: ten times it covers the scatter of a maximum over components
    assert error <= 10 * computed.error, (error, computed.error)


@pytest.mark.sampled(2)
@pytest.mark.parametrize(("name", "parameters", "t"), KNOWN[:6])
def test_the_error_of_a_record_is_that_against_the_truth(name, parameters, t):
    subject = problem(name, **parameters)
    work = measure(subject, load("gauss-3"), h=t / 200, steps=200, ask=("state",), repeats=1)
    assert work.completed and work.state_error is not None and work.reference_error is not None
    context_free = np.asarray(subject.solution(t), dtype=float)
    from glmref.engine.solve import solve

    end = solve(subject, load("gauss-3"), h=t / 200, steps=200).y[-1]
    truth = np.linalg.norm(end - context_free) / np.linalg.norm(context_free)
    # the record's time is 200 h, whose rounding moves the state by t |f| 2^-52 and so the error
    speed = np.linalg.norm(subject.f(t, context_free)) / np.linalg.norm(context_free)
    assert abs(work.state_error - truth) <= 2 * work.reference_error + 2.0**-51 * (1 + t * speed)
