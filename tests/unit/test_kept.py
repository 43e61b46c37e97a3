"""What a process keeps between runs, and when it must not: recorded functions, kernels, methods."""

import io
import math
import os
import shutil
import time
import types

import numpy as np
import pytest

from glmref import Problem, UsageError, solve
from glmref.catalogue.lookup import path_of
from glmref.engine import kept, kernel_cache
from glmref.engine.kept import expressed, method_of
from glmref.problems.formula import Formula
from glmref.problems.tracing import MOST_OPERATIONS, fingerprint, recorded, traced
from glmref.system.terminal import saying

STRENGTH = 1.0
MATRIX = np.array([[0.0, 1.0], [-1.0, 0.0]])
STATE = np.array([0.3, 0.7])


def pendulum(t, y):
    return [y[1], -STRENGTH * math.sin(y[0])]


def filled(t, y):
    out = np.zeros(2)
    out[0] = y[1]
    out[1] = -np.sin(y[0]) + 0.1 * np.cos(t)
    return out


def shared_parts(t, y):
    q, p = y[:1], y[1:]
    r = np.sqrt(q @ q + 1)
    return np.concatenate([p, -q / r**3])


def by_helper(t, y):
    return np.array([y[1], restoring(y[0])])


def restoring(q):
    return -(q**3) / 3 + MATRIX[0, 1] * q


@pytest.mark.parametrize("f", [pendulum, filled, shared_parts, by_helper, lambda t, y: MATRIX @ y])
def test_a_recorded_function_is_the_function(f):
    formula = traced(f, ("t", "y"), [(0.0, STATE)])
    assert formula is not None
    for t, y in ((0.0, STATE), (0.5, -STATE), (2.0, STATE[::-1])):
        np.testing.assert_allclose(formula(t, y), f(t, y), rtol=1e-15, atol=1e-16)


calls = []
table = {"k": 1.0}
workspace = np.zeros(2)


def counts(t, y):
    calls.append(1)
    return [y[1], -y[0]]


def reads_a_table(t, y):
    return [y[1], -table["k"] * y[0]]


def branches(t, y):
    return [y[1], -y[0]] if y[0] > 0 else [y[1], y[0]]


def writes_outside(t, y):
    workspace[0] = 1.0
    return [y[1], -y[0]]


def catches(t, y):
    try:
        return [y[1], -y[0] if y[0] > 0 else y[0]]
    except Exception:
        return [y[1], -y[0]]


def sets_a_global(t, y):
    global last
    last = t
    return [y[1], -y[0]]


def clips(t, y):
    return [y[1], -np.clip(y[0], -1, 1)]


def chance(t, y):
    return [y[1], -y[0] * np.random.random()]


@pytest.mark.parametrize(
    "f",
    [counts, reads_a_table, branches, writes_outside, catches, sets_a_global, clips, chance,
     lambda t, y: [y[1]], lambda t, y: abs(y), lambda t, y: [float(y[1]), 0.0]],
)  # fmt: skip
def test_what_symbols_cannot_show_is_left_alone(f):
    before = list(calls), dict(table), workspace.copy()
    found = recorded(f, ("t", "y"), 2)
    assert found is None or traced(f, ("t", "y"), [(0.0, STATE)], found) is None
    assert (list(calls), dict(table)) == before[:2]
    np.testing.assert_array_equal(workspace, before[2])


def test_a_function_that_changes_what_it_reads_is_recorded_anew(monkeypatch):
    problem = Problem(f=pendulum, y0=(1.0, 0.0))
    options = {"h": 0.1, "steps": 20}
    first, kept = solve(problem, "rk4", **options), expressed(problem)
    assert expressed(problem) is kept and first.kernel.startswith("native")
    monkeypatch.setitem(globals(), "STRENGTH", 2.0)
    assert expressed(problem) is not kept
    other = Problem(f=("y[1]", "-2*sin(y[0])"), y0=(1.0, 0.0))
    np.testing.assert_array_equal(
        solve(problem, "rk4", **options).y, solve(other, "rk4", **options).y
    )


def test_parts_are_recorded_too():
    given = Problem(
        dq=lambda p: [p[0] * (1 + p[0] ** 2)], dp=lambda q: [-math.sin(q[0])], y0=(1, 0)
    )
    found = expressed(given)
    assert isinstance(found.dq, Formula) and isinstance(found.dp, Formula)
    second = expressed(Problem(force=lambda q: [-math.sin(q[0])], y0=(1.0, 0.0)))
    assert second.second_order and second.force.outputs == ("-sin(q[0])",)


def test_large_systems_stay_loops():
    def ring(t, y):
        n = len(y) // 2
        out = np.zeros(2 * n)
        for i in range(n):
            out[i] = y[n + i]
            for j in range(n):
                if j != i:
                    out[n + i] += (y[j] - y[i]) / (1 + (y[j] - y[i]) ** 2)
        return out

    small, large = Problem(f=ring, y0=[0.1] * 6), Problem(f=ring, y0=[0.1] * 100)
    assert expressed(small) is not small and expressed(large) is large
    assert 49 * 50 > MOST_OPERATIONS


def test_fingerprints_tell_functions_apart_by_what_they_read():
    def made(k):
        return lambda t, y: [y[1], -k * y[0]]

    assert fingerprint(made(1.0)) == fingerprint(made(1.0)) is not None
    assert fingerprint(made(1.0)) != fingerprint(made(2.0))
    assert fingerprint(made(np.ones(3))) != fingerprint(made(np.zeros(3)))
    assert fingerprint(made(pendulum)) != fingerprint(made(filled))
    assert fingerprint(made([1.0])) is None and fingerprint(reads_a_table) is None


@pytest.mark.slow
def test_a_function_with_a_branch_is_compiled_once_for_what_it_reads():
    def made(k):
        return lambda t, y: [y[1], -y[0]] if y[0] < k else [y[1], y[0]]

    options = {"h": 0.1, "steps": 10}
    solve(Problem(f=made(5.0), y0=(1.0, 0.0)), "rk4", **options)
    begin, count = time.process_time(), len(kernel_cache._around)
    again = solve(Problem(f=made(5.0), y0=(1.0, 0.0)), "rk4", **options)
    assert again.kernel.startswith("numba") and len(kernel_cache._around) == count
    assert time.process_time() - begin < 0.2
    other = solve(Problem(f=made(0.5), y0=(1.0, 0.0)), "rk4", **options)
    assert len(kernel_cache._around) == count + 1
    assert abs(other.y[-1, 0] - again.y[-1, 0]) > 0.1


@pytest.mark.slow
def test_a_compiled_function_is_kept_on_disk_by_what_it_reads(monkeypatch, tmp_path):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))

    def made(k):
        return lambda t, y: np.array([y[1], -k * y[0]]) if y[0] < 5 else np.array([y[1], y[0]])

    def kernel_of(k):  # as in another process, which has nothing in memory
        kernel_cache._around.clear()
        source = "@compiled_with_signature\ndef kernel(x):\n    return int(full(0.0, x)[1])\n"
        built = kernel_cache.build(source, {"x": "d*"}, {"full": made(k)})
        return built.kernel(np.array([1.0, 0.0])), sum(built.kernel.stats.cache_hits.values())

    assert kernel_of(2.0) == (-2, 0)
    assert kernel_of(2.0) == (-2, 1)
    assert kernel_of(3.0) == (-3, 0)
    for path in tmp_path.rglob("*.nbc"):
        path.write_bytes(b"damaged")
    assert kernel_of(2.0)[0] == -2


def test_what_a_function_reads_from_another_module_is_not_known():
    namespace = {"constants": types.ModuleType("constants")}
    exec("def f(t, y):\n    return [constants.k * y[0]]", namespace)
    assert fingerprint(namespace["f"]) is None


def test_a_method_file_is_read_again_when_it_has_changed(tmp_path):
    path = tmp_path / "mine.json"
    shutil.copy(path_of("rk4"), path)
    first = method_of(path)
    assert method_of(path) is first and method_of("rk4") is method_of("rk4")
    shutil.copy(path_of("euler"), path)
    os.utime(path, ns=(1, 1))
    assert method_of(path).s == 1
    path.unlink()
    with pytest.raises(UsageError, match="does not exist"):
        method_of(path)


def test_the_second_run_by_names_costs_little_beside_its_steps():
    for name in ("rk4", "gauss-3", "pair-rkn-6-8b", "g6245-w3"):
        costs = []
        for _ in range(6):
            begin = time.process_time()
            run = solve("kepler", name, h=0.01, steps=100)
            costs.append(time.process_time() - begin - run.seconds)
        assert min(costs[1:]) < 0.01, name  # 1 to 3 ms; 5 to 270 ms before anything was kept


class Terminal(io.StringIO):
    def isatty(self):
        return True


def test_a_terminal_is_told_what_is_being_compiled(monkeypatch, tmp_path):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    kernel_cache._native.cache_clear()
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    solve(Problem(f=("-y[0]*1.0625",), y0=(1,)), "rk4", h=0.1, steps=1)
    assert "compiling a kernel" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\033[K")  # and the line is gone afterwards
    pipe = io.StringIO()
    monkeypatch.setattr("sys.stderr", pipe)
    with saying("something"):
        pass
    assert pipe.getvalue() == ""


@pytest.mark.parametrize("name", ["g6245-w3", "gauss-3", "pair-rkn-6-8b", "ab-4"])
def test_coefficients_kept_on_disk_are_those_computed(name, monkeypatch, tmp_path):
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    method = method_of(name)
    computed = kept.form_of_method.__wrapped__(method, "auto")
    (path,) = tmp_path.glob("glmref_form_*.json")
    monkeypatch.setattr(kept, "step_form", None)  # nothing is computed again ...
    assert repr(kept.form_of_method.__wrapped__(method, "auto")) == repr(computed)
    monkeypatch.undo()
    monkeypatch.setenv("GLMREF_CACHE", str(tmp_path))
    path.write_bytes(path.read_bytes().replace(b"0.5", b"0.6", 1)[:-1])  # ... but for a damaged one
    assert repr(kept.form_of_method.__wrapped__(method, "auto")) == repr(computed)
