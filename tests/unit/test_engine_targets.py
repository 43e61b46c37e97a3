"""Kernels with local variables and with arrays, in every way of writing them: the same numbers.

The reference engine, which solves the equations of a step as they stand, says which.
"""

import ast
import math
from typing import Any

import numpy as np
import pytest

from glmref import GLM, Problem, load, problem, solve
from glmref.engine.codegen import kernel_source
from glmref.engine.kernel import Kernel
from glmref.engine.kernel_cache import interpret
from glmref.engine.options import Options
from glmref.engine.outcome import Outcome
from glmref.engine.reference import stepper
from glmref.engine.shape import banded, shape_of
from glmref.engine.sweep import step_form
from glmref.method import Method


def own(t: float, y: Any) -> list[float]:
    """A right-hand side that depends on the time, as a plain function."""
    return [y[1] * math.cos(t), -math.sin(y[0]) - 0.1 * y[2], y[0] * y[1] - y[2]]


def velocity(p: Any) -> list[float]:
    return [p[0] * (1 + p[0] * p[0]), p[1] - p[0]]


def force(q: Any) -> list[float]:
    return [-q[0] - q[0] * q[1], -math.sin(q[1])]


PROBLEMS = {
    "kepler": (problem("kepler"), 0.05),
    "rigid-body": (problem("rigid-body"), 0.1),
    "linear-field": (problem("linear-field"), 0.1),
    "double-pendulum": (problem("double-pendulum"), 0.05),
    "chain": (problem("fput", sites=5), 0.1),
    "own": (Problem(f=own, y0=(0.5, 1.0, -0.25), name="own"), 0.1),
    "own parts": (Problem(dq=velocity, dp=force, y0=(0.5, 0.3, 0.25, -0.5), name="parts"), 0.1),
    "zero-field": (problem("zero-field"), 0.5),
}
CASES = [
    ("rk4", "own parts"), ("ab-3", "chain"), ("ab-3", "zero-field"), ("gauss-2", "kepler"),
    ("gauss-2", "own"), ("gauss-2", "double-pendulum"), ("radau-iia-2", "linear-field"),
    ("radau-iia-2", "chain"), ("sdirk-3", "rigid-body"), ("sdirk-3", "own parts"),
    ("gsymplectic-n", "own"), ("sdirk-3", "zero-field"),
    ("bdf-2", "rigid-body"), ("one vector", "kepler"),
]  # fmt: skip
STEPS = 3
METHODS = {
    # both eigenvalues of A are 1/2, and there is one vector for them: the stages are not separated
    "one vector": GLM(
        [["3/4", "-1/4"], ["1/4", "1/4"]], [["1"], ["1"]], [["1/2", "1/2"]], [["1"]], name="jordan"
    )
}


def method(name: str) -> Method:
    return METHODS.get(name) or load(name)


def kernel(name: str, of: Problem, target: str, solver: str, *, compensated: bool) -> Kernel:
    form, shape = step_form(method(name)), shape_of(of)
    if solver == "newton":
        shape = banded(shape)
    chosen = Options(target=target, solver=solver, interpreted=True, compensated=compensated)
    source = kernel_source(form, shape, chosen)
    functions = {x.role: x.function for x in shape.parts if x.function is not None}
    return Kernel(form, shape, chosen, source, interpret(source.text, functions), 0.0)


def start(name: str, of: Problem) -> np.ndarray:
    """Values that are all different."""
    y = np.array(of.y0, dtype=float)
    return np.array([y, *(0.01**k * (y + 0.5) for k in range(1, method(name).r))])


def ends(made: Kernel, of: Problem, values: np.ndarray, h: float) -> tuple[np.ndarray, Any]:
    state = made.state(values, np.asarray(of.f(0.0, values[0])), h)
    outcome, _ = made.advance(
        state, STEPS, t0=0.0, h=h, every=0, out=np.empty((1, 1, of.dimension))
    )
    assert outcome is Outcome.COMPLETED
    return made.values(state), state.tally


def expected(name: str, of: Problem, values: np.ndarray, h: float) -> np.ndarray:
    engine = stepper(method(name), of)
    for k in range(STEPS):
        values = engine.step(k * h, values, h).values
    return values


@pytest.mark.sampled(1)
@pytest.mark.parametrize(("name", "key"), CASES)
def test_locals_and_arrays_take_the_steps_of_the_reference(name: str, key: str) -> None:
    of, h = PROBLEMS[key]
    values = start(name, of)
    wanted = expected(name, of, values, h)
    ways = [("fixed-point", True), ("fixed-point", False)]
    if not method(name).A[-1][-1].is_zero():
        ways.append(("newton", True))
    for solver, compensated in ways:
        made = [kernel(name, of, x, solver, compensated=compensated) for x in ("scalar", "array")]
        (first, counts), (second, others) = (ends(x, of, values, h) for x in made)
        np.testing.assert_allclose(first, wanted, rtol=0, atol=2e-13)
        np.testing.assert_allclose(first, second, rtol=0, atol=2e-15)
        if solver == "fixed-point":
            assert counts.tolist() == others.tolist(), "evaluations"
        for x in made:
            assert not interpreted_functions(x.source.text)


def interpreted_functions(text: str) -> list[str]:
    """Functions of a module that machine code could not call."""
    return [
        x.name
        for x in ast.parse(text).body
        if isinstance(x, ast.FunctionDef)
        if [ast.unparse(d) for d in x.decorator_list]
        != ["compiled_with_signature" if x.name == "kernel" else "compiled"]
    ]


@pytest.mark.parametrize("solver", ["fixed-point", "newton"])
def test_a_large_field_that_vanishes_is_stepped(solver: str) -> None:
    """The function of such a field has nothing to write."""
    of = Problem(f=("0",) * 70, y0=(1.0,) * 70)
    assert solve(of, "gauss-2", h=0.5, steps=2, solver=solver).y[-1].tolist() == [1.0] * 70
