"""The second witness for explicit pairs: observed order on the pendulum and on orbits.

All are second-order systems, so that what is seen is the order of the claim ``nystrom-order``
where a file makes one; ``test_order_observed`` measures ``order`` on a system where both functions
are nonlinear.
"""

import os
from dataclasses import replace

import pytest

from glmref.catalogue.lookup import load, names
from glmref.measure.convergence import method_order
from glmref.problems import problem
from tests.shipped import shipped

CLOSE = 0.05
QUICK = {"pair-4-4", "pair-6-7"}
PROBLEMS = {
    "pendulum": ("pendulum", {"q0": "3/2", "p0": "3/10"}),
    "kepler": ("kepler", {"eccentricity": "1/5"}),
    "henon-heiles": ("henon-heiles", {}),
}


#: Minutes each in software arithmetic: asked for by the environment variable GLMREF_LONG.
LONG = (
    pytest.mark.slow,
    pytest.mark.skipif("GLMREF_LONG" not in os.environ, reason="GLMREF_LONG is not set"),
)


def cases():
    for name in names("methods"):
        doc = shipped(name)
        claims = doc["claims"]
        if doc["class"] in ("pair-sweep", "splitting") or "nystrom-order" in claims:
            order = claims["nystrom-order"] if "nystrom-order" in claims else claims["order"]
            several = doc["class"] == "partitioned" and order > 8
            marks = () if name in QUICK else LONG if several else pytest.mark.slow
            yield pytest.param(name, order, id=name, marks=marks)


@pytest.mark.sampled(1)
@pytest.mark.parametrize("case", PROBLEMS)
@pytest.mark.parametrize(("name", "order"), list(cases()))
def test_the_observed_order_of_a_pair_is_the_proved_one(name, order, case):
    kind, parameters = PROBLEMS[case]
    found = method_order(load(name), problem(kind, **parameters), expected=order)
    assert found.settled
    assert abs(found.order - order) < CLOSE, found


@pytest.mark.slow
def test_a_pair_with_one_wrong_weight_is_seen_to_have_order_1():
    good = load("pair-4-4")
    row = list(good.B_hat[0])
    row[0] = row[0] * 2 - row[1]  # the weights still sum to something, but not to 1 at c_1
    row[1] = good.B_hat[0][0] + good.B_hat[0][1] - row[0]
    wrong = replace(good, B_hat=(tuple(row), good.B_hat[1]), G=None)
    found = method_order(wrong, problem("pendulum", q0="3/2", p0="3/10"), expected=4)
    assert found.order < 2.5
