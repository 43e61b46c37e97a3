"""Generated source: what a zero, a one, an explicit stage and a repeated diagonal cost."""

import ast
from collections import Counter

import pytest

from glmref import GLM, Problem, load, problem, solve
from glmref.engine.codegen import kernel_source
from glmref.engine.options import Options
from glmref.engine.shape import shape_of
from glmref.engine.sweep import step_form

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
