"""Forms mean what their description says, also for methods that miss a structure by one number."""

import ast
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from glmref import GLM, PartitionedGLM, load, problem, solve
from glmref.engine.codegen import kernel_source
from glmref.engine.forms import StepForm
from glmref.engine.kernel import Kernel
from glmref.engine.kernel_cache import interpret
from glmref.engine.options import Options
from glmref.engine.reference import stepper
from glmref.engine.shape import Shape, shape_of
from glmref.engine.sweep import step_form

H, ROUNDS = 1 / 64, 40


def shipped(name: str) -> GLM | PartitionedGLM:
    method = load(name)
    assert isinstance(method, GLM | PartitionedGLM)
    return method


def source(form: StepForm, of: Any, options: Options) -> tuple[Shape, Any]:
    """The shape of a problem for a form, and the generated source."""
    shape = shape_of(of, split=True if len(form.components) == 2 else None)
    return shape, kernel_source(form, shape, options)


def values_of(method: GLM | PartitionedGLM, of: Any) -> np.ndarray:
    """Values with every component in play; what one half of a pair does not carry is zero."""
    r, d = max(len(c.V) for c in method.components), of.dimension
    values = np.random.default_rng(3).uniform(-0.1, 0.1, (r, d))
    values[0] += np.array(of.y0, dtype=float)
    if isinstance(method, PartitionedGLM):
        values[method.r :, : d // 2] = values[method.r_hat :, d // 2 :] = 0.0
    return values


# --- the equations of the description -----------------------------------------------------------


def test_values_with_eigenvalues_1_and_minus_1_have_a_form_in_every_basis() -> None:
    """Their trace is that of a turn by 90 degrees; a basis of p and V p was singular."""
    known = load("gsymplectic-n")
    method = known.transform([["1", "1/2"], ["0", "2"]])
    expected = solve("kepler", "gsymplectic-n", h=0.01, steps=5).y
    found = solve("kepler", method, h=0.01, steps=5, engine="interpreted").y
    assert np.abs(found - expected).max() < 1e-14


# --- methods that miss a structure by one number -------------------------------------------------


def near(method: GLM | PartitionedGLM) -> list[GLM | PartitionedGLM]:
    """The methods with one coefficient that is half as large, or 1/2 where it is zero."""
    found: list[GLM | PartitionedGLM] = []
    letters = "A U B V A_hat U_hat B_hat V_hat" if isinstance(method, PartitionedGLM) else "A U B V"
    for letter in letters.split():
        matrix = getattr(method, letter)
        for i, row in enumerate(matrix):
            for j, x in enumerate(row):
                new = [list(line) for line in matrix]
                new[i][j] = x / 2 if x else Fraction(1, 2)
                given = {"G": None, "D_P": None, "D_Q": None} if "_hat" in letters else {"G": None}
                found.append(replace(method, **{letter: new, **given}))
    return found


def by_kernel(method: GLM | PartitionedGLM, of: Any, values: np.ndarray, target: str) -> np.ndarray:
    form = step_form(method)
    options = Options(target=target)
    shape, text = source(form, of, options)
    kernel = Kernel(form, shape, options, text, interpret(text.text, {}), 0.0)
    state = kernel.state(values, np.asarray(of.f(0.0, values[0])), H)
    out = np.zeros((1, 1, of.dimension))
    assert kernel.advance(state, 2, t0=0.0, h=H, every=0, out=out)[0] == "completed"
    return kernel.values(state)


@pytest.mark.sampled(3)
@pytest.mark.parametrize("target", ["scalar", "array"])
@pytest.mark.parametrize("name", ["stormer-verlet", "rk4", "ab-2", "symplectic-euler-a"])
def test_a_method_that_misses_a_structure_by_one_number_is_stepped_as_given(name, target):
    method, of = shipped(name), problem("henon-heiles")
    values = values_of(method, of)
    for k, other in enumerate(near(method)):
        engine, expected = stepper(other, of), values
        for n in range(2):
            expected = engine.step(n * H, expected, H).values
        found = by_kernel(other, of, values, target)
        assert np.abs(found - expected).max() < 1e-14, k


# --- generated text ------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("compensated", [True, False])
@pytest.mark.parametrize("history", [True, False])
@pytest.mark.parametrize("of", ["pendulum", "outer-solar-system"])
def test_a_kernel_computes_nothing_that_it_does_not_read(of, history, compensated):
    options = Options(compensated=compensated, history=history, target="scalar")
    for name in ("rk4", "ab-3", "gauss-2", "g6245", "stormer-verlet", "multistep-rkn-8"):
        _, text = source(step_form(shipped(name)), problem(of), options)
        (kernel,) = (
            x for x in ast.parse(text.text).body
            if isinstance(x, ast.FunctionDef) and x.name == "kernel"
        )  # fmt: skip
        names = [x for x in ast.walk(kernel) if isinstance(x, ast.Name)]
        written = {x.id for x in names if isinstance(x.ctx, ast.Store)}
        read = {x.id for x in names if isinstance(x.ctx, ast.Load)}
        # constants of a body whose loops are undone are unpacked for those that are not
        assert written - read <= {"constants"}, name
