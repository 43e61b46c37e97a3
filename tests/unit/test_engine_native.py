"""Machine code of a kernel: what it may call, and that stepping costs no memory."""

import re
import resource
import sys

import numpy as np
import pytest

from glmref import load, problem
from glmref.engine.codegen import ARGUMENTS
from glmref.engine.expressions import LIBRARY
from glmref.engine.kernel import choose_form, prepare
from glmref.engine.lanes import LANE_ARGUMENTS, lane_source
from glmref.engine.native import aligned_zeros
from glmref.engine.runners import Lanes
from glmref.engine.translate import translated

KERNELS = [
    ("rk4", "kepler", "fixed-point"),
    ("gauss-3", "pendulum", "newton"),
    ("g6245", "henon-heiles", "newton"),
    ("g6245-w3", "outer-solar-system", "fixed-point"),
    ("sdirk-3", "double-pendulum", "newton"),
    ("stormer-verlet", "toda", "fixed-point"),
]
ALLOWED = {f"llvm.{x}.f64" for x in ("fabs", "sqrt")} | set(LIBRARY)


def functions(text):
    """(names that are declared only, names that are defined) in LLVM assembly."""
    names = re.findall(r'^(declare|define).*? @"?([\w.]+)"?\(', text, re.MULTILINE)
    return {n for kind, n in names if kind == "declare"}, {n for k, n in names if k == "define"}


def assembly(method, name, solver):
    kernel = prepare(load(method), problem(name), h=0.01, solver=solver, interpreted=True)
    from dataclasses import replace

    from glmref.engine.kernel import _source_of

    source = _source_of(kernel.form, kernel.shape, replace(kernel.options, interpreted=False))
    return translated(source.text, ARGUMENTS)


def allocations(text):
    """Stack slots outside the first block of a function, which would grow in a loop."""
    bodies = re.findall(r"^define.*?^}", text, re.MULTILINE | re.DOTALL)
    return sum(body.partition("br label")[2].count("alloca") for body in bodies)


@pytest.mark.sampled(4)
@pytest.mark.parametrize(("method", "name", "solver"), KERNELS)
def test_a_kernel_calls_nothing_but_functions_of_numbers(method, name, solver):
    text = assembly(method, name, solver)
    declared, defined = functions(text)
    assert declared <= ALLOWED, "a kernel must not call anything that could allocate"
    called = set(re.findall(r'call .*?@"?([\w.]+)"?\(', text))
    assert called <= declared | defined
    assert allocations(text) == 0


def test_operations_are_fused_only_where_asked_for():
    source = "def kernel(x, n):\n    x[0] = x[1] + x[2]*x[3]\n    return 0\n"
    arguments = {"x": "d*", "n": "i"}
    plain, fused = translated(source, arguments), translated(source, arguments, fuse=True)
    assert "contract" not in plain
    assert fused.count("fmul contract") == fused.count("fadd contract") == 1
    assert fused.replace(" contract", "") == plain


def test_the_check_sees_an_allocation():
    planted = """
def kernel(x, n):
    while n > 0:
        x[0] = pow(x[0], 2.0)
        n -= 1
    return 0
"""
    text = translated(planted, {"x": "d*", "n": "i"})
    declared, _ = functions(text)
    assert declared == {"pow"}
    inside = text.replace("call double", "%q = alloca double\n  call double")
    assert allocations(inside) == 1
    assert not functions(text.replace("pow", "malloc"))[0] <= ALLOWED


@pytest.mark.slow
def test_lanes_call_nothing_either():
    form, shape = choose_form(load("g6245"), problem("kepler"), "auto")
    from glmref.engine.options import Options

    declared, _ = functions(translated(lane_source(form, shape, Options(), 8).text, LANE_ARGUMENTS))
    assert declared <= ALLOWED


def peak():
    """Largest resident memory of this process so far, in bytes."""
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size if sys.platform == "darwin" else 1024 * size


def test_memory_is_flat_over_a_million_steps():
    of, h = problem("henon-heiles"), 0.01
    kernel = prepare(load("stormer-verlet"), of, h=h)
    state = kernel.state(np.array([of.y0]), np.asarray(of.f(0.0, of.y0)), h)
    grid = {"t0": 0.0, "h": h, "every": 0, "out": np.empty((1, 1, 4))}
    kernel.advance(state, 10_000, **grid)
    before = peak()
    kernel.advance(state, 1_010_000, **grid)
    assert state.step == 1_010_000
    # one number kept per step would be 8 MB
    assert peak() - before < 2_000_000


def test_memory_is_flat_in_lanes():
    of = problem("henon-heiles")
    runner = Lanes(load("rk4"), of, np.array(of.y0), 0.01, "strict", "auto", 1, 32, None)
    runner.load(np.repeat(np.array(of.y0)[None, None, :], 32, axis=0))
    runner.advance(0, 1000)
    before = peak()
    runner.advance(1000, 201_000)
    assert peak() - before < 2_000_000


@pytest.mark.parametrize("size", [1, 7, 36, 1000])
def test_work_arrays_begin_on_a_cache_line(size):
    arrays = [aligned_zeros(size) for _ in range(5)]
    for array in arrays:
        assert array.shape == (size,)
        assert array.ctypes.data % 64 == 0
        assert not array.any()
        array[:] = 1.0
