"""Derivatives of a step by its stages against differences of steps."""

from __future__ import annotations

import math

import numpy as np
import pytest

from glmref import load, problem
from glmref.engine.kept import stepper_of
from glmref.measure.linearised import step_derivatives
from glmref.measure.underlying import Underlying
from glmref.problems.model import Problem


def swing(t: float, y: np.ndarray) -> np.ndarray:
    """Return the slope of the pendulum, with a choice that symbols cannot show."""
    return np.array([y[1], -math.sin(y[0]) if y[0] < 99 else 0.0])


ORBITS = {
    "pendulum": lambda: problem("pendulum"),
    "henon-heiles": lambda: problem("henon-heiles"),
    "toda": lambda: problem("toda", sites=3),  # without a formula of its derivatives
    "not separable": lambda: problem("nonseparable-chain", sites=2),
    "two terms": lambda: Problem(
        f=("y[1] - y[0]", "-y[0]**3"), terms=(("y[1]", "-y[0]**3"), ("-y[0]", "0")), y0=(1, 0)
    ),
    "python": lambda: Problem(f=swing, y0=(0.5, 1.0)),
}


@pytest.mark.parametrize(
    ("name", "on"),
    [
        ("gsymplectic-n", "pendulum"),
        ("gauss-2", "not separable"),
        ("s3i1-w3", "toda"),
        ("pair-4-4", "toda"),
        ("pair-4-4", "henon-heiles"),
        ("gsymplectic-n-pair", "pendulum"),
        ("g6245", "python"),
        ("multistep-8", "henon-heiles"),
        ("lobatto-iiia-iiib-2", "not separable"),
        ("ars-2-2-2", "two terms"),
    ],
)
def test_a_step_is_differentiated(name: str, on: str) -> None:
    method, subject, h, tiny = load(name), ORBITS[on](), 0.1, 1e-5
    engine = stepper_of(method, subject)
    generator = np.random.default_rng(1)
    y = np.array(subject.y0) + 0.1 * generator.normal(size=(2, subject.dimension))
    values = 0.05 * generator.normal(size=(2, *engine.shape))
    values += np.array([Underlying(engine).lifted(x) for x in y])
    found = step_derivatives(method, subject, h, values)
    for x, step in zip(values, found, strict=True):
        for move, column in zip(np.eye(x.size), step.T, strict=True):
            ends = [engine.step(0.0, x + s * tiny * move.reshape(x.shape), h) for s in (1, -1)]
            seen = (ends[0].values - ends[1].values).ravel() / (2 * tiny)
            assert column == pytest.approx(seen, abs=1e-8)


def test_stages_that_are_not_solved_have_no_derivatives() -> None:
    method, stiff = load("gauss-2"), Problem(f=("-exp(40*y[0])",), y0=(1.0,))
    values = np.array([[[1.0]], [[-9.0]]])
    with np.errstate(all="ignore"):
        lost, found = step_derivatives(method, stiff, 1e6, values)
    assert np.isnan(lost).all() and np.isfinite(found).all()
