"""The second witness of order: what runs in extended precision show, for the whole catalogue.

``order`` of a one-step method, and ``order-identity`` of any, is the order of the solution itself;
``order`` of a method with several values whose identity costs order, and ``effective-order``, is
what start and finish can reach, seen where a conjugation drops out. 0.05 is the promise; what is
seen is nearer than 0.01 as a rule.
"""

import pytest

from glmref.catalogue import document, load, names
from glmref.experiments.convergence import effective_order, isochronous, method_order
from glmref.method import PartitionedGLM
from glmref.problems import problem

CLOSE = 0.05
#: A few of each kind, for every day; the whole catalogue is slow.
QUICK = {
    *("euler", "rk4", "kutta-3", "ab-2", "bdf-2", "leapfrog", "nystrom-3", "dimsim-2-type-3"),
    *("ark-4", "stormer-verlet", "ruth-3", "gsymplectic-n", "butcher-effective-5"),
}


def cases(kind):
    found = []
    for name in names("methods"):
        claims = document(name)["claims"]
        order = claims.get(kind)
        measured_as_order = kind == "order-identity" and order == claims.get("order")
        if isinstance(order, int) and order >= 1 and not measured_as_order:
            marks = () if name in QUICK else pytest.mark.slow
            found.append(pytest.param(name, order, id=name, marks=marks))
    return found


def is_one_step(method):
    return method.r == 1 and getattr(method, "r_hat", 1) == 1


def own_order(method):
    """Order claimed of the solution itself, or ``None`` where only an effective one is."""
    claims = method.claims
    return claims["order"] if is_one_step(method) else claims.get("order-identity")


def nonlinear(method):
    # both halves of a pair need nonlinear functions, or too many trees vanish
    pair = isinstance(method, PartitionedGLM)
    return problem("lotka-volterra-logarithmic") if pair else isochronous()


@pytest.mark.parametrize(("name", "order"), cases("order"))
def test_the_observed_order_is_the_proved_one(name, order):
    method = load(name)
    own = own_order(method)
    if own == order:
        found = method_order(method, nonlinear(method), expected=order)
    else:
        found = effective_order(method, expected=order)
    assert abs(found.order - order) < CLOSE, found


@pytest.mark.parametrize(("name", "order"), cases("order-identity"))
def test_the_observed_order_of_the_solution_alone_is_the_proved_one(name, order):
    method = load(name)
    found = method_order(method, nonlinear(method), expected=order)
    assert abs(found.order - order) < CLOSE, found


@pytest.mark.parametrize(("name", "order"), cases("effective-order"))
def test_the_observed_effective_order_is_the_proved_one(name, order):
    found = effective_order(load(name), expected=order)
    assert abs(found.order - order) < CLOSE, found


@pytest.mark.parametrize(
    ("name", "claimed", "true"),
    [
        ("rk4-a44-one", 4, 1),
        ("thesis-3-8-printed", 4, 1),
        ("thesis-gauss-2-printed", 4, 1),
        ("rkf45-4-order-5", 5, 4),
        ("ab-4-digit", 4, 0),
        ("dormand-prince-sign", 5, None),
        ("kraaijevanger-spijker-order-2", 2, 1),
    ],
)
def test_a_wrong_source_shows_in_the_observed_order(name, claimed, true):
    method = load(name)
    found = method_order(method, isochronous(), expected=claimed)
    if true == 0:
        # not consistent: it converges, but to something else; only the exact flow tells
        from glmref.engine.solve import solve

        end = solve(isochronous(), method, h=1 / 256, steps=256, engine="reference").y[-1]
        assert max(abs(end - isochronous().solution(1.0))) > 1e-6
        return
    assert abs(found.order - claimed) > 0.5
    if true is not None:
        assert abs(found.order - true) < CLOSE
