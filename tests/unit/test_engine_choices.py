"""What the choice of a solver is computed from, and how a kernel is called: counted by hand."""

import ast
import itertools
import math
from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from glmref import Problem, load, problem, solve
from glmref.engine import kept, solver_choice
from glmref.engine import kernel as kernel_module
from glmref.engine.kernel import Kernel, prepare
from glmref.engine.kernel_cache import Built
from glmref.engine.options import Options
from glmref.engine.outcome import Outcome
from glmref.engine.shape import banded, shape_of
from glmref.engine.solver_choice import choose_solver, contraction
from glmref.engine.sweep import step_form
from glmref.problems.user_functions import NoValue

# --- the rule -------------------------------------------------------------------------------------


def test_operations_are_weighted_by_their_latency() -> None:
    of = Problem(
        f=("sin(y[0]) + y[0]*y[1]", "-sqrt(y[1]) - y[0]/y[1]", "y[2]**3.7 + sin(y[0])"),
        y0=(1.0, 2.0, 3.0),
    )
    # sin 15, two additions, product; root 5, subtraction, division 4; power 10, addition; the sine
    # of the last line is that of the first
    assert solver_choice._latency(of.f) == (15 + 1 + 1) + (5 + 1 + 4) + (10 + 1)
    pair = Problem(dq=("2*p[0]",), dp=("-3*q[0]*q[0]",), y0=(1.0, 1.0))
    # K = -(6 q), V = 2, a round is 12 and the two right-hand sides
    once, jacobian = solver_choice._latencies(shape_of(pair))
    assert once == 12 + 1 + 2
    k = solver_choice._latency(solver_choice.jacobian_block(shape_of(pair), range(1, 2), range(1)))
    v = solver_choice._latency(solver_choice.jacobian_block(shape_of(pair), range(1), range(1, 2)))
    assert jacobian == k + v and k >= 1
    assert solver_choice._latencies(shape_of(problem("pendulum")))[0] == 12 + 15
    # q' = p: the block of the velocity costs nothing
    henon = shape_of(problem("henon-heiles"))
    k = solver_choice._latency(solver_choice.jacobian_block(henon, range(2, 4), range(2)))
    assert solver_choice._latencies(henon)[1] == k > 0


@pytest.mark.parametrize("d", [1, 2, 3])
def test_a_small_system_takes_newton_where_its_rounds_cost_less(d, monkeypatch):
    """2.3 rounds, the Jacobian and the solution against 1 + 10 / -log10(rho) rounds."""
    of = Problem(f=tuple(f"-y[{k}]*y[{k}]" for k in range(d)), y0=(1.0,) * d)
    shape, form = shape_of(of), step_form(load("implicit-midpoint"))
    once, jacobian = solver_choice._latencies(shape)
    assert once == 12 + d
    rounds = (2.3 * once + jacobian + {1: 6, 2: 14, 3: 40}[d]) / once
    edge = 10 ** (-10 / (rounds - 1))
    for rho, wanted in ((edge * 0.97, "fixed-point"), (edge * 1.03, "newton"), (0.3, "newton")):
        monkeypatch.setattr(solver_choice, "contraction", lambda *_, rho=rho: rho)
        assert choose_solver(form, shape, of, 0.1) == wanted
    # a block of two stages is not written out: the fixed point up to its slow rounds
    for rho, wanted in ((0.25, "fixed-point"), (0.26, "newton")):
        monkeypatch.setattr(solver_choice, "contraction", lambda *_, rho=rho: rho)
        assert choose_solver(step_form(load("gauss-2")), shape, of, 0.1) == wanted
    for rho in (0.0, math.nan, math.inf):
        monkeypatch.setattr(solver_choice, "contraction", lambda *_, rho=rho: rho)
        assert choose_solver(form, shape, of, 0.1) == "fixed-point"


def chain(solver: str) -> int:
    """Operations from a force to the next position, in a round of a stage on q'' = g(q)."""
    kernel = prepare(load("g6245-w3"), problem("kepler"), h=0.05, solver=solver)
    rounds = kernel.source.text.split("while True:\n")[1].split("change = ")[0].splitlines()
    held = "H1_2" if "H1_2" in "".join(rounds) else "L1_2"
    depth = {held: int(held[0] == "L")}  # an increment is h w times the force
    for line in rounds:
        name, _, text = line.strip().partition(" = ")
        if not text:
            continue
        depth[name] = max(_depths(ast.parse(text, mode="eval").body, depth))
    return depth["N1_0"]


def _depths(tree: ast.AST, depth: dict[str, int]) -> list[int]:
    """Depths of what an expression reads, plus the operations that are done with it."""
    if isinstance(tree, ast.Name):
        return [depth.get(tree.id, -99)]
    if isinstance(tree, ast.BinOp):
        return [x + 1 for side in (tree.left, tree.right) for x in _depths(side, depth)]
    return [-99]


@pytest.mark.slow
def test_rounds_of_a_stage_alone_are_priced_by_their_operations(monkeypatch):
    assert (chain("newton"), chain("fixed-point")) == (8, 2)
    assert solver_choice._LONE_STAGE_SAVES == 8 - 2
    of = problem("henon-heiles")
    shape, form = shape_of(of), step_form(load("g6245-w3"))
    once, jacobian = solver_choice._latencies(shape)
    rounds = (2.3 * once + jacobian + 14) / (once - 6)
    edge = 10 ** (-10 / (rounds - 1))
    for rho, wanted in ((edge * 0.97, "fixed-point"), (edge * 1.03, "newton")):
        monkeypatch.setattr(solver_choice, "contraction", lambda *_, rho=rho: rho)
        assert choose_solver(form, shape, of, 0.1) == wanted
    # where q' is not p a round has the two sums
    apart = Problem(dq=("2*p[0]",), dp=("-sin(q[0])",), y0=(1.0, 0.0))
    shape = shape_of(apart)
    once, jacobian = solver_choice._latencies(shape)
    rounds = (2.3 * once + jacobian + 6) / once
    edge = 10 ** (-10 / (rounds - 1))
    for rho, wanted in ((edge * 0.97, "fixed-point"), (edge * 1.03, "newton")):
        monkeypatch.setattr(solver_choice, "contraction", lambda *_, rho=rho: rho)
        assert choose_solver(form, shape, apart, 0.1) == wanted


def operations(method: str, shape: Any) -> tuple[float, float]:
    """Operations of a round of the fixed point, and of a step of Newton's method, on rounds of 4."""
    form = step_form(load(method))
    s, n, d = form.implicit_stages, shape.dimension, shape.dimension
    read = 8 * d if shape.band is None else 2 * shape.band.entries
    once = s * (read + (2 * s + 10) * d)
    numbers, lower = n * n, n - 1
    if shape.band is not None:
        lower, upper = shape.band.lower, shape.band.upper
        numbers = (n + lower + upper) * (2 * lower + upper + 1)
    weights = {"gauss-2": (4,), "gauss-3": (1, 4)}[method]
    solves = sum(2 * w * numbers for w in weights)
    factors = sum(2 * w * numbers * min(lower, n / 3) for w in weights)
    return once, 4 * (once + solves) + factors / 10


@pytest.mark.parametrize(("method", "band"), [("gauss-2", False), ("gauss-3", True)])
def test_a_large_system_takes_newton_where_its_matrices_cost_less(method: str, band: bool) -> None:
    d, form = 70, step_form(load(method))
    rows = tuple(
        f"y[{k}]*y[{(k + 1) % d if k + 1 < d else k}] - y[{max(k - 2, 0)}]" for k in range(d)
    )
    shape = shape_of(Problem(f=rows, y0=(1.0,) * d))
    shape = banded(shape) if band else shape
    once, newton = operations(method, shape)
    edge = 10 ** (-10 / (newton / once - 1))
    assert edge < 0.9
    assert not solver_choice._newton_pays(form, shape, 0.99 * edge)
    assert solver_choice._newton_pays(form, shape, 1.01 * edge)
    assert solver_choice._newton_pays(form, shape, 0.9), "the fixed point all but diverges"
    small = shape_of(Problem(f=rows[:1] * 64, y0=(1.0,) * 64))
    assert solver_choice._newton_pays(form, small, 1e-9)


def test_a_jacobian_that_is_not_given_is_differenced() -> None:
    def f(t: float, y: Any) -> list[float]:
        return [y[0] * y[1], t * y[1]]

    def none(t: float, y: Any) -> list[float]:
        raise NoValue("none")

    of = Problem(f=f, y0=(3.0, -2.0), t_span=(2.0, 3.0))
    np.testing.assert_allclose(solver_choice._jacobian(of), [[-2, 3], [0, 2]], atol=1e-6)
    assert solver_choice._norm(shape_of(of), of) == pytest.approx(5, abs=1e-6)
    assert solver_choice._jacobian(Problem(f=none, y0=(1.0,))) is None
    assert math.isnan(solver_choice._norm(shape_of(of), Problem(f=none, y0=(1.0,))))
    for d, known in ((64, True), (65, False)):
        large = Problem(f=lambda t, y: -np.asarray(y), y0=(1.0,) * d)
        assert (solver_choice._jacobian(large) is not None) == known
    given = Problem(f=f, y0=(3.0, -2.0), jacobian=lambda t, y: [[t, 0], [0, 1]], t_span=(2.0, 3.0))
    np.testing.assert_array_equal(solver_choice._jacobian(given), [[2, 0], [0, 1]])
    pair = Problem(dq=("2*p[0]",), dp=("-3*q[0]",), y0=(1.0, 2.0))
    assert solver_choice._norm(shape_of(pair), pair) == 6


# --- kernels that are kept ------------------------------------------------------------------------


def test_a_source_is_kept_by_form_and_shape(monkeypatch: pytest.MonkeyPatch) -> None:
    form, shape = step_form(load("rk4")), shape_of(problem("kepler"))
    monkeypatch.setattr(kernel_module, "_sources", kept.ByIdentity())
    monkeypatch.setattr(kept, "_MOST", 2)
    first = kernel_module._source_of(form, shape, Options())
    assert kernel_module._source_of(form, shape, Options()) is first
    assert kernel_module._source_of(replace(form), shape, Options()) is not first
    assert len(kernel_module._sources.known) == 2
    kernel_module._source_of(form, replace(shape), Options())
    assert len(kernel_module._sources.known) == 1, "at the most so many are kept"


def test_a_band_is_kept_by_the_shape() -> None:
    shape = shape_of(problem("fput", sites=16))
    assert shape.dimension == 32
    found = kernel_module.with_band(shape)
    assert found.band is not None and kernel_module.with_band(shape) is found
    assert kernel_module.with_band(found) is found
    small = shape_of(problem("fput", sites=15))
    assert kernel_module.with_band(small) is small


def test_kernels_say_what_they_are() -> None:
    def words(method: str, **options: Any) -> str:
        options = {"interpreted": True, **options}
        return prepare(load(method), problem("kepler"), h=0.1, **options).description

    assert words("rk4") == "python, standard form, compensated, scalar target"
    assert (
        words("rk4", arithmetic="naive") == "python, standard form, not compensated, scalar target"
    )
    assert words("gauss-2", arithmetic="quick", solver="newton").split(", ")[2:] == [
        "newton", "compensated", "quick", "scalar target",
    ]  # fmt: skip
    assert "fused" in words("rk4", arithmetic="fused").split(", ")
    assert "quick" not in words("rk4", arithmetic="quick")


# --- chunks of steps ------------------------------------------------------------------------------


class Stepping:
    """A kernel that takes steps at a price on its own clock, and notes how it was called."""

    def __init__(
        self, seconds: float = 0.0, code: int = 0, fails_at: int = -1, error: type = RuntimeError
    ) -> None:
        self.seconds, self.code, self.fails_at, self.error = seconds, code, fails_at, error
        self.clock, self.calls, self.raised = 0.0, [], 0  # type: ignore[var-annotated]

    def __call__(self, work: Any, par: Any, *rest: Any) -> int:
        t0, h, first, until, mark, every, _, row, tally = rest
        assert (t0, h) == (2.0, 0.5)
        self.calls.append((first, until, mark))
        self.clock += self.seconds
        if first <= self.fails_at < until:
            tally[4] = self.fails_at  # what an exception leaves behind
            self.raised += 1
            raise self.error("no value there")
        tally[4] = until
        return self.code


def advanced(
    stepping: Stepping, monkeypatch: pytest.MonkeyPatch, last: int, *, engine: str = "native",
    every: int = 0, pause: Callable[[int], bool] = lambda _: False, opaque: bool = False,
) -> tuple[Any, float, Any]:  # fmt: skip
    monkeypatch.setattr(kernel_module, "time", SimpleNamespace(perf_counter=lambda: stepping.clock))
    of: Any = Problem(f=lambda t, y: [1.0 for _ in y], y0=(1.0,)) if opaque else problem("pendulum")
    made = prepare(load("rk4"), of, h=0.5, interpreted=True)
    made = Kernel(made.form, made.shape, made.options, made.source, Built(stepping, engine), 0.0)
    y = np.array(of.y0, dtype=float)
    state = made.state(y[None], y, 0.5)
    outcome, seconds = made.advance(
        state, last, t0=2.0, h=0.5, every=every, out=np.empty((1, 1, len(y))), pause=pause
    )
    return outcome, seconds, state


def test_an_exception_leaves_the_last_step_before_it(monkeypatch: pytest.MonkeyPatch) -> None:
    stepping = Stepping(1.0, fails_at=300)
    outcome, seconds, state = advanced(stepping, monkeypatch, 1000, engine="numba", opaque=True)
    assert outcome is Outcome.FUNCTION_FAILED and state.step == 300
    assert isinstance(state.trouble, Exception) and "f" in str(state.trouble)
    assert seconds == len(stepping.calls)
    # halved until one step is left, and never grown again
    tried = [until - first for first, until, _ in stepping.calls]
    assert tried[:2] == [256, 256] and tried[-1] == 1
    assert all(b <= a for a, b in itertools.pairwise(tried[1:]))
    assert tried[2] == 128
    without = Stepping(fails_at=4, error=ValueError)
    outcome, _, state = advanced(without, monkeypatch, 10, engine="numba", opaque=True)
    assert outcome is Outcome.NOT_FINITE and state.step == 4
    with pytest.raises(RuntimeError, match="no value there"):  # a fault of the kernel itself
        advanced(Stepping(fails_at=0), monkeypatch, 10, engine="numba")
    with pytest.raises(RuntimeError, match="no value there"):
        advanced(Stepping(fails_at=0), monkeypatch, 10, engine="python", opaque=True)


def test_a_function_that_computes_otherwise_when_compiled_is_told_by_its_value() -> None:
    def f(t: float, y: Any) -> list[float]:
        return [y[1] + t, -y[0]]

    def raises(t: float, y: Any) -> list[float]:
        raise ZeroDivisionError

    of = Problem(f=f, y0=(1.0, 2.0), t_span=(0.5, 1.0))

    def said(compiled: Callable[..., Any]) -> str:
        built = SimpleNamespace(functions={"full": compiled})
        kernel: Any = SimpleNamespace(shape=shape_of(of), built=built)
        return kernel_module._computes_otherwise(kernel, of)

    # in the ninth digit, of the largest component
    assert not said(f) and not said(raises)
    for change, told in ((2e-9, False), (3e-9, True), (math.inf, True)):
        for sign in (1, -1):
            assert bool(said(lambda t, y, x=sign * change: [y[1] + t, -y[0] + x])) == told
    assert "gives another value when it is compiled" in said(lambda t, y: [2.5, -1.0, 0.0][:1])


# --- choices that are seen ------------------------------------------------------------------------


def rule(method, of, h):
    form, shape = step_form(load(method)), shape_of(of)
    return choose_solver(form, shape, of, h), contraction(form, shape, of, h)


def test_an_explicit_method_has_no_contraction():
    stiff = problem("fput-stiff", omega=500)
    assert rule("rk4", stiff, 0.1) == ("fixed-point", 0.0)


def test_a_poor_contraction_takes_newton_and_a_cheap_one_the_fixed_point():
    heavy = problem("n-body")
    assert rule("gauss-3", heavy, 1e-3)[0] == "fixed-point"
    stiff = problem("fput-stiff", omega=500)
    assert rule("gauss-3", stiff, 0.1)[0] == "newton"
    assert (
        choose_solver(step_form(load("gauss-2")), shape_of(heavy), heavy, 0.1, "newton") == "newton"
    )


def test_an_unknown_jacobian_of_a_large_system_leaves_the_fixed_point():
    large = Problem(f=lambda t, y: -np.asarray(y), y0=tuple([1.0] * 70), name="large")
    solver, rho = rule("gauss-2", large, 0.1)
    assert math.isnan(rho)
    assert solver == "fixed-point"


@pytest.mark.slow
@pytest.mark.sampled(1)
@pytest.mark.parametrize("name", ["outer-solar-system", "nonseparable-chain", "arenstorf", "toda"])
def test_array_kernels_agree_with_the_reference(name):
    h = {"outer-solar-system": 20.0, "arenstorf": 1e-4}.get(name, 0.01)
    for method in ("gauss-2", "g6245"):
        fast = solve(name, method, h=h, steps=10, start="zero")
        slow = solve(name, method, h=h, steps=10, start="zero", engine="reference")
        scale = np.abs(slow.values).max()
        assert np.abs(fast.values - slow.values).max() < 40 * 2.0**-52 * scale
        assert fast.kernel.startswith("native")
