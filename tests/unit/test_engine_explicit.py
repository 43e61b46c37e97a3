"""Explicit methods: fewer operations, the same solution; loop bodies without their loops."""

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine.codegen import kernel_source
from glmref.engine.options import Options
from glmref.engine.shape import shape_of
from glmref.engine.sweep import step_form
from glmref.engine.unroll import placed, unrolled
from glmref.problems.loops import Loops


@pytest.mark.sampled(6, besides=("outer",))
@pytest.mark.parametrize("name", ["rk4", "dormand-prince-5", "ab-2", "heun-2", "merson-4"])
@pytest.mark.parametrize("of", ["henon-heiles", "outer-solar-system", "lotka-volterra"])
def test_explicit_steps_are_those_of_the_method(name, of):
    subject = problem(of)
    h = float(10 if of.startswith("outer") else 0.05)
    run = solve(subject, name, h=h, steps=50)
    exact = solve(subject, name, h=h, steps=50, engine="reference", digits=30)
    scale = np.abs(exact.values.astype(float)).max()
    assert np.abs(run.values - exact.values.astype(float)).max() < 8 * 2.0**-53 * scale
    assert run.evaluations == exact.evaluations


def test_runge_kutta_needs_no_stages_of_the_velocity():
    form, shape = step_form(load("rk4")), shape_of(problem("henon-heiles"))
    text = kernel_source(form, shape, Options()).text
    assert "Y3_0 =" in text and "Y3_2 =" not in text
    whole = kernel_source(form, shape_of(problem("henon-heiles"), split=False), Options()).text
    assert "Y3_2 =" in whole


@pytest.mark.parametrize("whole", [False, True])
def test_the_weights_lose_nothing_to_rounding(whole):
    """Constant slopes: y = n h f exactly, to the rounding of n steps compensated."""
    n, h = 100_000, 0.1
    flat = Problem(force=("1.0",), y0=(0.0, 0.0)) if not whole else Problem(f=("1.0",), y0=(0.0,))
    run = solve(flat, "rk4", h=h, steps=n)
    assert abs(run.y[-1, -1] - n * h) < 4 * np.spacing(n * h)
    # the near miss: without compensation the rounding of h/6 and h/3 shows
    naive = solve(flat, "rk4", h=h, steps=n, arithmetic="naive")
    assert abs(naive.y[-1, -1] - n * h) > 100 * np.spacing(n * h)


# --- loops undone -------------------------------------------------------------------------------

BODY = """
def f(q, params, out):
    n = len(q)
    for i in range(n):
        out[i] = 0.0
    for i in range(n):
        for j in range(i):
            if (i + j) % 2 == 1:
                out[i] += params[0]*sin(q[j] - q[i])
            else:
                out[j] -= q[i]
"""


def test_an_unrolled_body_computes_the_same_bits():
    from math import sin

    text = unrolled(BODY, (5, 1, 5), 500)
    assert "for" not in text and "if" not in text.split("\n", 1)[1]
    q, ends = np.random.default_rng(2).standard_normal(5), []
    for source in (BODY, text):
        names = {"sin": sin}
        exec(source, names)
        out = np.zeros(5)
        names["f"](q, np.array([0.3]), out)
        ends.append(out)
    np.testing.assert_array_equal(*ends)


@pytest.mark.parametrize(
    "line",
    ["if q[0] > 0:\n        out[0] = 1.0", "while True:\n        out[0] = 1.0", "out[int(q[0])] = 1.0",
     "out[7] = 1.0", "out[:] = q[:]", "out[0] = other(q[0])"],
)  # fmt: skip
def test_what_is_not_known_before_stays_a_loop(line):
    assert unrolled(f"def f(q, params, out):\n    {line}", (2, 1, 2), 100) == ""


def test_a_long_body_stays_a_loop():
    assert unrolled(BODY, (100, 1, 100), 500) == ""


@pytest.mark.slow
def test_a_body_without_a_source_is_called_as_a_function():
    names = {}
    exec("def f(t, y, params, out):\n    out[0] = -y[0]\n"
         "def J(t, y, params, out):\n    out[0, 0] = -1.0\n", names)  # fmt: skip
    of = Problem(f=Loops(names["f"], (1,)), jacobian=Loops(names["J"], (1, 1)), y0=(1.0,))
    shape = shape_of(of)
    assert shape.opaque and shape.parts[0].body == shape.jacobian_body == ""
    assert shape.differenced and not shape.banded_body
    run = solve(of, "gauss-2", h=0.1, steps=5, engine="interpreted")
    expected = solve(Problem(f=("-y[0]",), y0=(1.0,)), "gauss-2", h=0.1, steps=5)
    assert run.y[-1, 0] == pytest.approx(expected.y[-1, 0], abs=1e-15)


def test_an_unrolled_body_is_placed_under_other_names():
    body = "def f(t, q, params, out):\n    s = sin(t) * q[1]\n    out[0] = s + abs(params[0])\n"
    named = [lambda k, x=x: f"{x}[{k + 4}]" for x in ("y", "f", "par")]
    assert placed(body, *named, "own_") == [
        "own_s = sin(time) * y[5]",
        "f[4] = own_s + abs(par[4])",
    ]
