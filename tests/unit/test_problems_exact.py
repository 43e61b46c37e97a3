"""Closed forms: they start at y0, solve the equation, and are a flow."""

import numpy as np
import pytest

from glmref.conformance.taylor import taylor_states
from glmref.errors import UsageError
from glmref.problems import names, problem
from glmref.problems.flows import eccentric_anomaly
from tests.build import high, refused

CASES = [(name, {}) for name in names() if problem(name).exact and name != "long-chain"] + [
    ("kepler", {"eccentricity": 0}),
    ("kepler", {"eccentricity": "999/1000"}),
    ("pendulum", {"q0": 0, "p0": "3"}),
    ("pendulum", {"q0": 1, "p0": "-5/2"}),
    ("pendulum", {"q0": 8, "p0": "1/2"}),
    ("pendulum", {"q0": 0, "p0": 2}),
    ("pendulum", {"q0": 0, "p0": -2}),
    ("pendulum", {"q0": 0, "p0": 0}),
    ("dahlquist", {"real": "-1/10", "imaginary": 2}),
    ("prothero-robinson", {"stiffness": 3}),
    ("kaps", {"epsilon": 1}),
    ("linear-field", {"dimension": 3, "seed": 4}),
    ("long-chain", {"sites": 6, "mode": 3}),
]
DIGITS = 60


def size(y):
    return max(abs(x) for x in y)


@pytest.mark.sampled(10)
@pytest.mark.parametrize(("name", "parameters"), CASES)
def test_exact_solution_solves_the_equation(name, parameters):
    context = high(DIGITS)
    p = problem(name, **parameters).on(context)
    for t in ("0.3", "-0.7"):
        t = context.mpf(t)
        if name == "prothero-robinson" and t < 0:
            continue
        y, step = p.solution(t), context.mpf(10) ** -20
        slope = (p.exact(t + step, p.y0) - p.exact(t - step, p.y0)) / (2 * step)
        f = p.f(t, y)
        # step**2 times the third derivative: (1e6)**3 on the way out of the stiff layer, over
        # r**3.5 = 1e10 for e = 0.999; rounding 1e-60/1e-20 of |y| times the stiffness
        assert size(slope - f) <= 1e-20 * (size(f) + size(y))


@pytest.mark.parametrize(("name", "parameters"), CASES)
def test_exact_solution_starts_at_y0(name, parameters):
    p = problem(name, **parameters)
    # the start is rounded to double, as the result is
    assert p.solution(0.0) == pytest.approx(p.y0, rel=4e-16, abs=1e-16 * size(p.y0))


# the others depend on the time, or are known from special starts only
AUTONOMOUS = [case for case in CASES if case[0] not in ("prothero-robinson", "kaps")]


@pytest.mark.parametrize(("name", "parameters"), AUTONOMOUS)
def test_exact_solution_is_a_flow(name, parameters):
    context = high(DIGITS)
    p = problem(name, **parameters).on(context)
    s, t = context.mpf("1.3"), context.mpf("-2.1")
    if name == "blow-up":
        s = context.mpf("0.3")
    twice, once = p.exact(t, p.exact(s, p.y0)), p.exact(s + t, p.y0)
    # e = 0.999 magnifies the rounding of the middle by some (1 - e)**-3
    assert size(twice - once) <= 1e-45 * (1 + size(once))


def test_exact_solution_in_double_is_rounded_once():
    p, context = problem("kepler"), high(DIGITS)
    mine = p.exact(1000.0, p.y0)
    fine = p.on(context).exact(context.mpf(1000), [context.mpf(float(x)) for x in p.y0])
    assert mine.tolist() == [float(x) for x in fine]


@pytest.mark.parametrize("parameters", [{"q0": 0, "p0": 3}, {"q0": 8, "p0": "1/2"}, {}])
def test_pendulum_closed_form_agrees_with_taylor(parameters):
    p = problem("pendulum", **parameters)
    series = taylor_states(p, [5], digits=25)[0]
    exact = p.on(high(DIGITS)).solution(5)
    assert size(series - exact) < 1e-22


@pytest.mark.parametrize("e", ["0", "0.1", "0.9", "0.999", "0.999999999", "1"])
def test_keplers_equation_is_solved_to_the_last_digit(e):
    context = high(DIGITS)
    e = context.mpf(e)
    for mean in ("0", "1e-50", "1e-9", "0.001", "0.5", "3.14", "-3", "1e6"):
        anomaly = eccentric_anomaly(context.mpf(mean), e, context)
        turns = context.mpf(mean) / (2 * context.pi)
        rest = 2 * context.pi * (turns - context.floor(turns + 0.5))
        residual = anomaly - e * context.sin(anomaly) - rest
        # rounding of the three terms, and of the reduction by whole turns
        assert abs(residual) <= 10 * context.eps * (abs(anomaly) + abs(context.mpf(mean)))


def test_kepler_flow_wants_an_ellipse():
    p = problem("kepler")
    refused(UsageError, "negative energy", p.exact, 1.0, [1, 0, 0, 1.5])
    refused(UsageError, "bodies apart", p.exact, 1.0, [0, 0, 0, 1])


def test_kaps_wants_its_slow_manifold():
    refused(UsageError, "y1 = y2", problem("kaps").exact, 1.0, [1.0, 0.5])


@pytest.mark.slow
def test_long_chain_has_100000_components_and_returns_with_its_mode():
    p = problem("long-chain")
    assert p.dimension == 100_000
    # f = (p, -omega**2 q) for a normal mode; the phases, up to 2 pi, are rounded three times, which
    # the second difference magnifies by 4
    omega = 2 * np.sin(np.pi * 10_000 / (2 * 50_001))
    assert p.f(0.0, p.y0)[50_000:] == pytest.approx(-(omega**2) * p.y0[:50_000], abs=1e-14)
