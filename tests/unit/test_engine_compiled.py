"""The cache on disk, numba for a user's functions, and the interpreter when nothing else works."""

import math
import subprocess
import sys

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine import kernel, kernel_cache, native
from glmref.engine.expressions import Unsupported
from glmref.engine.kernel import prepare
from glmref.system import cache


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(tmp_path / "cache"))
    kernel_cache._native.cache_clear()
    kernel_cache._around.clear()
    yield tmp_path / "cache"
    kernel_cache._native.cache_clear()
    kernel_cache._around.clear()


def test_a_kernel_is_written_once_and_found_again(folder):
    first = prepare(load("rk4"), problem("pendulum"), h=0.1)
    files = sorted(folder.glob("*.o"))
    assert len(files) == 1
    assert first.built.path == files[0]
    assert first.built.engine == "native"
    stamp = files[0].stat().st_mtime_ns
    kernel_cache._native.cache_clear()
    again = prepare(load("rk4"), problem("pendulum"), h=0.2)
    assert sorted(folder.glob("*.o")) == files
    assert files[0].stat().st_mtime_ns == stamp
    assert again.built.path == first.built.path
    prepare(load("gauss-2"), problem("pendulum"), h=0.1)
    assert len(list(folder.glob("*.o"))) == 2


def test_a_named_folder_that_cannot_be_written_costs_the_cache_and_no_run(
    folder, monkeypatch, tmp_path
):
    assert kernel_cache.cache_folder() == folder
    cached = prepare(load("rk4"), problem("pendulum"), h=0.1)
    blocked = tmp_path / "file"
    blocked.write_text("")
    monkeypatch.setenv(cache.CACHE_VARIABLE, str(blocked / "below"))
    assert kernel_cache.cache_folder() is None
    kernel_cache._native.cache_clear()
    again = prepare(load("rk4"), problem("pendulum"), h=0.1)
    assert (cached.built.engine, again.built.engine) == ("native", "native")
    assert again.built.path is None


def test_a_cache_that_is_full_costs_the_cache_and_no_run(folder, monkeypatch):
    def full(path, content, **more):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(cache, "replace_whole", full)
    assert prepare(load("rk4"), problem("pendulum"), h=0.1).built.engine == "native"
    assert list(folder.iterdir()) == []


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["no folder", "full"])
def test_a_module_that_numba_cannot_keep_is_compiled_in_memory(folder, monkeypatch, fault):
    def unsupported(*arguments):
        raise Unsupported("not today")

    def full(path, content, **more):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(native, "compile_kernel", unsupported)
    if fault == "full":
        monkeypatch.setattr(kernel_cache, "replace_whole", full)
    else:
        monkeypatch.setattr(kernel_cache, "cache_folder", lambda: None)
    built = prepare(load("rk4"), problem("pendulum"), h=0.1).built
    assert (built.engine, built.path) == ("numba", None)


def test_the_shared_temporary_folder_is_used_only_where_it_is_one_s_own(monkeypatch, tmp_path):
    monkeypatch.delenv(cache.CACHE_VARIABLE, raising=False)
    monkeypatch.setattr(cache, "_user_cache", lambda: None)
    monkeypatch.setattr("tempfile.gettempdir", lambda: str(tmp_path))
    folder = kernel_cache.cache_folder()
    assert folder is not None and folder.parent == tmp_path
    folder.chmod(0o777)  # anybody could put code there
    assert kernel_cache.cache_folder() is None


def test_the_default_folder_is_the_platform_s_user_cache(monkeypatch, tmp_path):
    monkeypatch.delenv(cache.CACHE_VARIABLE, raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    monkeypatch.setattr(sys, "platform", "linux")
    assert kernel_cache.cache_folder() == tmp_path / "glmref" / "kernels"


@pytest.mark.slow
def test_a_function_that_numba_cannot_compile_is_interpreted_with_a_notice(folder, monkeypatch):
    table = {"g": 1.0}

    def f(t, y):
        return [y[1], -table["g"] * math.sin(y[0])]

    plain = Problem(f=f, y0=(1.2, 0.0), name="opaque")
    run = solve(plain, "gauss-2", h=0.1, steps=20)
    assert run.kernel.startswith("python")
    assert any("numba cannot compile f" in notice for notice in run.notices)
    exact = solve(Problem(f=("y[1]", "-sin(y[0])"), y0=(1.2, 0.0)), "gauss-2", h=0.1, steps=20)
    np.testing.assert_array_equal(run.y, exact.y)
    assert not any(path.suffix == ".py" for path in folder.iterdir())
    monkeypatch.setattr(kernel_cache, "_compiled_around", None)  # it is not tried again
    again = solve(plain, "gauss-2", h=0.1, steps=20)
    assert again.notices == run.notices and (again.y == run.y).all()


@pytest.mark.slow
def test_a_function_that_numba_can_compile_is_compiled():
    def f(t, y):
        return (y[1], -math.sin(y[0]))

    def branching(t, y):  # cannot be recorded as a formula
        return (y[1], -math.sin(y[0]) if y[0] < 100 else 0.0)

    plain = Problem(f=f, y0=(1.2, 0.0), name="callable")
    recorded = solve(plain, "gauss-2", h=0.1, steps=20)
    assert recorded.kernel.startswith("native")
    run = solve(Problem(f=branching, y0=(1.2, 0.0)), "gauss-2", h=0.1, steps=20)
    assert run.kernel.startswith("numba")
    assert not run.notices and not recorded.notices
    exact = solve(Problem(f=("y[1]", "-sin(y[0])"), y0=(1.2, 0.0)), "gauss-2", h=0.1, steps=20)
    np.testing.assert_array_equal(run.y, exact.y)
    np.testing.assert_array_equal(recorded.y, exact.y)


@pytest.mark.slow
def test_numba_compiles_the_same_source_to_the_same_bits(folder, monkeypatch, request):
    native = solve("kepler", "s4-symmetric", h=0.05, steps=200)
    for kept in (kernel_cache._native, kernel._prepared):
        kept.cache_clear()
        request.addfinalizer(kept.cache_clear)

    def refuse(*_, **__):
        raise Unsupported("as if")

    monkeypatch.setattr(kernel_cache.native, "compile_kernel", refuse)
    other = solve("kepler", "s4-symmetric", h=0.05, steps=200)
    assert other.kernel.startswith("numba")
    np.testing.assert_array_equal(native.values, other.values)


@pytest.mark.slow
def test_solving_in_machine_code_loads_no_numba():
    code = (
        "import sys, glmref; run = glmref.solve('kepler', 'g6245', h=0.1, steps=5); "
        "assert run.completed; assert 'numba' not in sys.modules; print(run.kernel)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("native")
