"""Generated source: what a zero, a one, an explicit stage and a repeated diagonal cost."""

import ast
from collections import Counter

import numpy as np
import pytest

from glmref import GLM, Problem, load, problem, solve
from glmref.engine.codegen import kernel_source
from glmref.engine.options import Options
from glmref.engine.shape import shape_of
from glmref.engine.sweep import step_form
from glmref.engine.unroll import placed, unrolled
from glmref.problems.loops import Loops

LINE = Problem(f=("y[0]",), y0=(1.0,))  # f costs nothing, so every operation is the method's


def loop(text):
    """The loop over steps of a generated module."""
    functions = [n for n in ast.parse(text).body if isinstance(n, ast.FunctionDef)]
    kernel = next(n for n in functions if n.name == "kernel")
    return next(n for n in ast.walk(kernel) if isinstance(n, ast.While))


def operations(text):
    step = loop(text)
    step.body = [node for node in step.body if "mark" not in ast.unparse(node)]  # recording
    found = Counter(
        type(node.op).__name__ for node in ast.walk(step) if isinstance(node, ast.BinOp)
    )
    return found["Mult"], found["Add"] + found["Sub"]


def naive_source(method):
    options = Options(compensated=False)
    return kernel_source(step_form(method, "standard"), shape_of(LINE), options).text


def explicit(A, B):
    s = len(A)
    return GLM(A=A, U=[["1"]] * s, B=[B], V=[["1"]])


def test_zeros_of_the_tableau_cost_nothing():
    dense = explicit([["0", "0", "0"], ["1/3", "0", "0"], ["1/3", "1/5", "0"]], ["1/7"] * 3)
    sparse = explicit([["0", "0", "0"], ["1/3", "0", "0"], ["0", "1/5", "0"]], ["0", "0", "1/7"])
    # one product with h a_ij or h b_j for each entry
    assert operations(naive_source(dense))[0] == 3 + 3
    assert operations(naive_source(sparse))[0] == 2 + 1
    # an entry that is nearly zero is not a zero: the count above depends on the pattern alone
    almost = explicit(
        [["0", "0", "0"], ["1/3", "0", "0"], [f"1/{10**9}", "1/5", "0"]], ["0", "0", "1/7"]
    )
    assert operations(naive_source(almost))[0] == 3 + 1


def test_ones_are_not_multiplied():
    def source(diagonal, weight):
        method = GLM(A=[[diagonal]], U=[["1"]], B=[[weight]], V=[["1"]])
        return naive_source(method)

    assert operations(source("1", "-1"))[0] == operations(source("1/3", "3"))[0] - 2


def test_a_signed_permutation_costs_no_operation():
    form = step_form(load("g6245"))
    text = kernel_source(form, shape_of(LINE), Options()).text
    # V = diag(1, rotation by 90 degrees, -1): no vector is copied or added for it
    assert "x1_0 =" not in text
    rotated = kernel_source(step_form(load("g6245-w3")), shape_of(LINE), Options()).text
    assert "x2_0 =" in rotated, "a rotation by 120 degrees adds two values"


def test_explicit_stages_are_evaluated_once_and_implicit_ones_in_a_loop():
    text = kernel_source(step_form(load("g6245")), shape_of(problem("pendulum")), Options()).text
    inner = [n for n in ast.walk(loop(text)) if isinstance(n, ast.While)][1:]
    calls = [n for n in ast.walk(loop(text)) if isinstance(n, ast.Call)]
    sines = sum(1 for n in calls if ast.unparse(n.func) == "sin")
    assert len(inner) == 3, "stages 2, 3 and 4 are implicit"
    assert sines == 5, "each stage has its evaluation written once"


def test_equal_diagonals_share_one_factorisation():
    shape = shape_of(problem("double-pendulum"))
    equal = kernel_source(step_form(load("sdirk-3")), shape, Options(solver="newton")).text
    unequal = kernel_source(step_form(load("qin-zhang-2")), shape, Options(solver="newton")).text
    different = GLM(
        A=[["1/4", "0"], ["1/2", "1/3"]], U=[["1"], ["1"]], B=[["1/2", "1/2"]], V=[["1"]]
    )
    two = kernel_source(step_form(different), shape, Options(solver="newton")).text

    def factorisations(text):
        kernel = text[text.index("def kernel") :]
        before_first_eliminate = kernel.split("eliminate(")[0]
        return before_first_eliminate.count("factor(")

    assert factorisations(equal) == 1
    assert factorisations(unequal) == 1
    assert factorisations(two) == 2


def test_uncompensated_kernels_carry_no_rounding_errors():
    form, shape = step_form(load("rk4")), shape_of(problem("kepler"))
    plain = kernel_source(form, shape, Options(compensated=False))
    kept = kernel_source(form, shape, Options(compensated=True))
    assert "e0_" not in plain.text
    assert operations(kept.text)[1] > operations(plain.text)[1]


def test_large_systems_have_source_that_does_not_grow_with_them():
    lines = []
    for sites in (64, 128):
        source = kernel_source(
            step_form(load("s4-symmetric")), shape_of(problem("fput", sites=sites)), Options()
        )
        assert source.target == "array"
        lines.append(len(source.text.splitlines()))
    assert lines[0] == lines[1]


def test_large_systems_copy_no_velocity_and_share_loops():
    source = kernel_source(
        step_form(load("rk4")), shape_of(problem("outer-solar-system")), Options()
    )
    assert source.target == "array"
    loops = [node for node in loop(source.text).body if isinstance(node, ast.While)]
    lines = [line for inner in loops for line in inner.body if isinstance(line, ast.Assign)]
    copies = [line for line in lines if isinstance(line.value, ast.Subscript)]
    # q' = p: there are no stages of the velocity; only the state is copied
    assert len(copies) == 2
    # three Y; new values of q and of p with their errors; the check; the state
    assert len(loops) == 3 + 2 + 1 + 1


@pytest.mark.parametrize(
    ("exponent", "product"),
    [
        ("1.5", "{0} * sqrt({0})"), ("3/2", "{0} * sqrt({0})"), ("0.5", "sqrt({0})"),
        ("-1.5", "1 / ({0} * sqrt({0}))"), ("-(5/2)", "1 / ({0} * {0} * sqrt({0}))"),
        ("-2", "1 / ({0} * {0})"), ("-1", "1 / {0}"),
    ],
)  # fmt: skip
def test_powers_with_a_half_are_products_and_a_root(exponent, product):
    power = Problem(f=(f"-(y[0] + 1)**({exponent})",), y0=(1.0,))
    text = kernel_source(step_form(load("euler")), shape_of(power), Options()).text
    assert "**" not in text
    assert product.format("s0_power_0") in text
    # the reference engine computes by pow
    kernel, reference = (
        solve(power, "rk4", h=0.01, steps=40, engine=engine).y[-1, 0]
        for engine in ("compiled", "reference")
    )
    assert kernel == pytest.approx(reference, rel=1e-14)


@pytest.mark.parametrize("exponent", ["1/3", "0.3", "9", "17/2"])
def test_other_powers_are_those_of_the_library(exponent):
    power = Problem(f=(f"-(y[0] + 1)**({exponent})/10",), y0=(-0.5,))
    assert "**" in kernel_source(step_form(load("euler")), shape_of(power), Options()).text


def test_generation_is_deterministic():
    form, shape = step_form(load("g6245-w3")), shape_of(problem("henon-heiles"))
    first, second = (kernel_source(form, shape, Options()).text for _ in range(2))
    assert first == second


# --- explicit methods, and loops undone -----------------------------------------------------------


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
