"""Order reduction: on Prothero and Robinson's problem methods fall to the order their stages allow.

With z = h lambda fixed at -1e10 the stage defects, of order q + 1, are all that is left of the
error. They add up over 1/h steps where ``M(infinity)`` has the eigenvalue 1, and do not elsewhere.
Both, the stage order q and M(infinity), are computed exactly by the theory.
"""

import numpy as np
import pytest

from glmref.catalogue.lookup import load
from glmref.errors import UsageError
from glmref.exact import Exact
from glmref.measure.work_precision import _computed, measure, reference_state, state_error
from glmref.problems import problem
from glmref.prove.facts import Facts
from glmref.theory import polynomials as poly
from glmref.theory.stability import leading_part, stability_polynomial
from tests.order_reduction import observed_order, smooth_start

METHODS = (
    "gauss-1", "gauss-2", "gauss-3", "gauss-4", "radau-ia-2", "radau-ia-3", "radau-iia-1",
    "radau-iia-2", "radau-iia-3", "lobatto-iiia-2", "lobatto-iiia-3", "lobatto-iiia-4",
    "lobatto-iiib-3", "lobatto-iiic-2", "lobatto-iiic-3", "lobatto-iiic-4", "lobatto-iiid-3",
    "lobatto-iiie-3", "sdirk-2", "sdirk-3", "sdirk-4", "tr-bdf2", "yoshida-4", "implicit-midpoint",
    "gsymplectic-p", "bdf-1", "bdf-2", "bdf-4",
)  # fmt: skip
#: Quick ones, one of each kind: damped, alternating, adding up, stiffly accurate, several values.
QUICK = {"gauss-2", "gauss-3", "radau-ia-2", "sdirk-4", "gsymplectic-p"}

Z = -1e10
#: Errors are a h^p + b h^(p+1) + ..: at h = 1/16 and 1/32 the second term moves the observed order
#: by b h/(2 a log 2), one fifth for |b/a| = 4. The methods above stay below that.
WITHIN = 0.2


def adds_up(method):
    """Whether M(infinity) has the eigenvalue one."""
    limits, _ = leading_part(stability_polynomial(method))
    return poly.evaluate(limits, Exact(1)).is_zero() is True


def predicted(method):
    q = Facts(method).kernel.range("stage-order").value
    return q if adds_up(method) else q + 1


def marked(names):
    return [pytest.param(n, marks=() if n in QUICK else pytest.mark.slow) for n in names]


@pytest.mark.slow
@pytest.mark.sampled(1, whole=8)
@pytest.mark.parametrize("name", marked(METHODS))
def test_the_order_falls_to_what_the_stage_order_allows(name):
    method = load(name)
    found = observed_order(method, z=Z, steps=(32, 64))
    assert found.order == pytest.approx(predicted(method), abs=WITHIN), found


def test_a_composition_can_do_better_than_the_bound():
    """Two halves of the midpoint rule: what the first adds at infinity the second takes away."""
    method = load("qin-zhang-2")
    assert predicted(method) == 1
    assert observed_order(method, z=Z, steps=(16, 32)).order == pytest.approx(2, abs=WITHIN)


def test_the_smooth_start_is_the_exact_start_of_a_past_value_method():
    import math

    values = smooth_start(load("bdf-2"), h=0.1).ravel()
    # y_n and, in one form or another, y_{n-1}: the enhanced start of order 2 errs by h^3
    assert values[0] == 1.0
    assert min(abs(v - math.cos(0.1)) for v in values) < 1e-3
    assert problem("prothero-robinson").y0[0] == 1.0


# --- references -----------------------------------------------------------------------------------


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
