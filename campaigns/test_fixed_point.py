"""Runs in fixed point: their functions, and their steps against the reference engine."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest

from campaigns.fixed_point import Run, in_units, number, rounded
from campaigns.modified_slopes import PROBLEMS
from glmref.catalogue.lookup import load
from glmref.engine.reference import stepper
from glmref.problems.formula import Formula


def test_functions_have_seventy_digits():
    call = in_units(Formula(("exp(y[0])", "sin(y[0])", "sqrt(y[0]*y[0])", "-1/(y[0]**3 + 1.25)")))
    for x in (Fraction(-5, 3), Fraction(1, 100), Fraction(37, 10)):
        with mpmath.workdps(90):
            y = number(rounded(x))
            wanted = [mpmath.exp(y), mpmath.sin(y), abs(y), -1 / (y**3 + mpmath.mpf("1.25"))]
            found = call([rounded(x)])
            assert all(abs(number(a) - b) < 1e-70 for a, b in zip(found, wanted, strict=True)), x


@pytest.mark.slow
@pytest.mark.parametrize("method", ["gauss-2", "s5z-w3", "pair-4-4", "stormer-verlet"])
@pytest.mark.parametrize("on", ["kepler, e = 1/10", "toda, 3 sites"])
def test_steps_are_those_of_the_reference_engine(method: str, on: str):
    make, parts = PROBLEMS[on]
    engine = stepper(load(method), make(), digits=70)
    with mpmath.workdps(70):
        values = np.full(engine.shape, mpmath.mpf(0), dtype=object)
        values[0] = engine.problem.y0
        run = Run(engine, Fraction(1, parts), np.vectorize(rounded, "O")(values))
        run.advance(2)
        for _ in range(2):
            values = engine.step(0, values, mpmath.mpf(1) / parts).values
        far = np.vectorize(number, "O")(run.values) - values
        assert max(abs(x) for x in far.ravel()) < 1e-60  # a step leaves 1e-61 of its stages
    assert run.evaluations <= 4


@pytest.mark.slow
def test_what_has_no_parasitic_part_begins_where_it_is_put():
    make, parts = PROBLEMS["pendulum"]
    engine = stepper(load("gauss-2"), make(), digits=60)
    values = np.array([[rounded(x) for x in engine.problem.y0]], dtype=object)
    run = Run(engine, Fraction(1, parts), values.copy())
    run.purify(2)
    assert (run.values == values).all()
