"""The translator to machine code computes what the interpreter computes, bit for bit."""

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from glmref.engine import kernel_cache, native

HEAD = "from math import atan2, cos, exp, log, sin, sqrt, tan\n"
ARGUMENTS = {"x": "d*", "a": "d", "n": "i", "out": "i*"}


def both(body, x, a, n, functions=""):
    lines = "\n".join("    " + line for line in body.splitlines())
    source = f"{HEAD}{functions}\ndef kernel(x, a, n, out):\n{lines}\n"
    results = []
    machine = native.compile_kernel(source, ARGUMENTS, None)
    plain = kernel_cache.interpret(source.replace("def kernel", "def kernel"), {}).kernel
    for run in (machine, plain):
        array, counts = np.array(x, dtype=float), np.zeros(4, dtype=np.int64)
        code = run(array, a, n, counts)
        results.append((array, counts.tolist(), code))
    return results


def same(body, x=(1.0, 2.0, 3.0, 4.0), a=0.5, n=3, functions=""):
    machine, plain = both(body, x, a, n, functions)
    np.testing.assert_array_equal(machine[0], plain[0])
    assert machine[1:] == plain[1:]
    return machine


finite = st.floats(-1e3, 1e3).filter(lambda v: v == 0 or abs(v) > 1e-3)


@settings(max_examples=30, deadline=None)
@given(a=finite, b=finite, c=finite)
def test_arithmetic_has_the_bits_of_the_interpreter(a, b, c):
    # the same source for every example: compiled once, read from the cache of the process
    source = (
        f"{HEAD}\ndef kernel(x, a, n, out):\n"
        "    u = x[0]*x[1] + x[2]\n    v = x[0] - x[1]*x[2] - a\n"
        "    x[3] = abs(u)/(1.0 + v*v) + sqrt(abs(v)) - sin(u)*cos(v) + 2*x[0]\n    return 0\n"
    )
    run = _arithmetic(source)
    array = np.array([a, b, c, 0.0])
    run(array, 0.25, 0, np.zeros(1, dtype=np.int64))
    u, v = a * b + c, a - b * c - 0.25
    assert (
        array[3] == abs(u) / (1.0 + v * v) + math.sqrt(abs(v)) - math.sin(u) * math.cos(v) + 2 * a
    )


def _arithmetic(source, kept={}):  # noqa: B006
    if source not in kept:
        kept[source] = native.compile_kernel(source, ARGUMENTS, None)
    return kept[source]


def test_loops_branches_and_breaks():
    body = """\
k = 0
total = 0.0
while True:
    k += 1
    if k == 2:
        total += 10.0
    else:
        total -= a
    if total > 8.0 or k >= 7:
        break
for i in range(4):
    x[i] = x[i]*total if i != 2 else -x[i]
for i in range(n - 1, -1, -1):
    out[i] = i*k + 1
while k < 12:
    k += 2
return k"""
    same(body)


def test_comparisons_chain_and_nan_compares_false():
    body = """\
bad = x[3] - x[3]
bad = bad/bad
out[0] = 1 if 0.0 < a < 1.0 else 0
out[1] = 1 if not (bad < 1.0) else 0
out[2] = 1 if (bad == bad) | (a != a) else 0
out[3] = 1 if bad != bad and n == 3 else 0
return 0"""
    machine = native.compile_kernel(
        f"{HEAD}\ndef kernel(x, a, n, out):\n" + "\n".join("    " + s for s in body.splitlines()),
        ARGUMENTS, None,
    )  # fmt: skip
    out = np.zeros(4, dtype=np.int64)
    machine(np.ones(4), 0.5, 3, out)
    assert out.tolist() == [1, 1, 0, 1]


def test_functions_on_slices_and_matrices():
    functions = """
@compiled
def scaled(v, factor, out):
    for i in range(len(v)):
        out[i] = factor*v[i]

@compiled
def fill(m):
    for i in range(2):
        for j in range(2):
            m[i, j] += 10*i + j
"""
    body = """\
scaled(x[0:2], a, x[2:4])
fill(x[0:4].reshape((2, 2)))
return 0"""
    machine = same(body, functions=functions)
    assert machine[0].tolist() == [1.0, 3.0, 10.5, 12.0]


def test_integer_arithmetic_of_indices():
    same("out[0] = (n + 7) // 2\nout[1] = (n + 8) % 3\nout[2] = int(x[2])\nreturn n - 5")


def test_object_code_on_disk_is_used_again_and_replaced_when_damaged(tmp_path):
    source = f"{HEAD}\ndef kernel(x, a, n, out):\n    x[0] = exp(a)\n    return 7\n"
    path = tmp_path / "kernel.o"
    for damage in (False, False, True):
        if damage:
            path.write_bytes(b"not an object file")
        x = np.zeros(4)
        assert native.compile_kernel(source, ARGUMENTS, path)(x, 1.0, 0, np.zeros(1, int)) == 7
        assert x[0] == math.e
        assert path.stat().st_size > 100
