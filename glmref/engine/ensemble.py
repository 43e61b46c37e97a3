"""Many initial values at once: lanes of one block side by side, blocks spread over threads.

A block of lanes is stepped by one kernel (:mod:`.lanes`) whose inner loop the compiler turns into
SIMD instructions; every trajectory has the bits :func:`.solve.solve` gives it. Kernels release the
interpreter's lock, so blocks run in threads. Right-hand sides that are loop bodies or callables,
implicit pairs and large systems are stepped one by one, still in threads.
"""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..claims import UsageError
from ..method import GLM, PartitionedGLM, StartingMethod
from ..problems.model import Problem
from . import compiled
from .codegen import SCALAR_LIMIT
from .forms import StepForm
from .kernel import Kernel, choose_form, prepare
from .lanes import LANE_SIGNATURE, LaneSource, lane_source
from .newton import INLINE_LIMIT
from .outcome import KERNEL_OUTCOMES, Outcome
from .reference import stepper
from .solve import plan_of, resolved, step_size
from .start import corrector, default_passes, zero_start

__all__ = ["EnsembleSolution", "solve_ensemble"]

WIDTHS = (8, 16, 32)
_FAST_MEMORY = 40 * 1024  # bytes of work array per block, about a first-level cache
_CHUNK_SECONDS = 0.1
_FIRST_CHUNK = 64


@dataclass(frozen=True, eq=False)
class EnsembleSolution:
    """What an ensemble computed.

    Attributes
    ----------
        t: (m,) times kept.
        y: (m, N, d) solutions; a trajectory that ended early keeps its last good value.
        outcomes: (N,) of :class:`.outcome.Outcome`.
        steps: (N,) steps completed.
        values: (N, r, d) values carried at the end, in the method's basis.
        evaluations: right-hand-side evaluations in all, start included.
        seconds: wall clock time of the steps; build_seconds: of generating and compiling.
        width: lanes per block (1: one by one). threads: how many.
        kernel: what was built, in words.
    """

    t: np.ndarray
    y: np.ndarray
    outcomes: np.ndarray
    steps: np.ndarray
    values: np.ndarray
    evaluations: int
    seconds: float
    build_seconds: float
    width: int
    threads: int
    kernel: str

    @property
    def completed(self) -> bool:
        """Whether every trajectory took every step."""
        return bool((self.outcomes == Outcome.COMPLETED).all())


def solve_ensemble(
    problem: Problem | str, method: GLM | PartitionedGLM | str, initial: Any, *, h: float,
    t_end: float | None = None, steps: int | None = None, every: int = 0, start: Any = None,
    arithmetic: str = "strict", solver: str = "auto", threads: int | None = None,
    width: int | None = None, cancel: Callable[[], bool] | None = None,
) -> EnsembleSolution:  # fmt: skip
    """Integrate N initial values of one problem.

    Args:
        problem, method, h, t_end, steps, every, arithmetic, solver: as for :func:`.solve.solve`.
        initial: (N, d) initial values.
        start: ``None``: the method's own explicit starting method, else the enhanced start;
            ``"enhanced"``, ``"zero"``, or values (N, r, d).
        threads: number of threads, by default one per processor.
        width: lanes per block, by default what fits the first-level cache; 1 for one by one.
        cancel: called about every 100 ms.

    Raises
    ------
        UsageError: one sentence on an argument that does not fit.
    """
    problem, method = resolved(problem, method)
    y0 = np.array(initial, dtype=float)
    if y0.ndim != 2 or y0.shape[1] != problem.dimension or not len(y0):
        raise UsageError(
            f"`initial` must have shape (N, d) with d = {problem.dimension}, got {y0.shape}"
        )
    if width is not None and width not in (1, *WIDTHS):
        raise UsageError(f"`width` must be 1 or one of {WIDTHS}, got {width!r}")
    h = step_size(h)
    plan = plan_of(problem, h, t_end, steps, every, None, None)
    workers = threads if threads is not None else (os.cpu_count() or 1)
    if not isinstance(workers, int) or workers < 1:
        raise UsageError(f"`threads` must be a positive whole number, got {threads!r}")
    # the solver is chosen where the ensemble starts, not where the problem does
    first = replace(problem, y0=tuple(y0[0]), initial=None) if problem.context is None else problem
    one_by_one = width == 1 or not _has_lanes(method, problem)
    runner: _Runner = (_Singles if one_by_one else _Lanes)(
        method, first, h, arithmetic, solver, workers, width, cancel
    )
    with np.errstate(all="ignore"):
        values, evaluations = _starts(runner, method, problem, y0, h, start)
        return runner.run(values, evaluations, plan)


def _has_lanes(method: GLM | PartitionedGLM, problem: Problem) -> bool:
    if problem.dimension > SCALAR_LIMIT:
        return False
    form, shape = choose_form(method, problem, "auto")
    return not shape.loops and not (isinstance(method, PartitionedGLM) and form.implicit_stages)


def _starts(
    runner: _Runner, method: GLM | PartitionedGLM, problem: Problem, y0: np.ndarray, h: float,
    start: Any,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """Starting values (N, r, d) and the evaluations they cost."""
    engine = stepper(method, problem)
    own = method.starting if isinstance(method, GLM) else None
    if start is None:
        start = own if own is not None and _explicit(own) else "enhanced"
        if engine.shape[0] == 1:
            start = "zero"
    if isinstance(start, StartingMethod):
        return _runge_kutta_starts(start, problem, y0, h)
    if not isinstance(start, str):
        values = np.array(start, dtype=float)
        if values.shape != (len(y0), *engine.shape):
            raise UsageError(
                f"starting values must have shape (N, r, d) = {(len(y0), *engine.shape)}, got "
                f"{values.shape}"
            )
        return values, 0
    if start == "zero":
        return zero_start(engine, y0), 0
    if start != "enhanced":
        raise UsageError(f"`start` must be enhanced, zero or values (N, r, d), got {start!r}")
    correct, passes, cost = corrector(engine), default_passes(method), 0

    def enhanced(k: int, y: np.ndarray) -> np.ndarray:
        nonlocal cost
        if k == 0:
            return zero_start(engine, y)
        values = enhanced(k - 1, y)
        after, spent = runner.one_step(values)
        cost += spent
        return values + correct(after - enhanced(k - 1, after[:, 0]))

    return enhanced(passes, y0), cost


def _explicit(start: StartingMethod) -> bool:
    m = start.stages
    return all(start.A[i][j].is_zero() is True for i in range(m) for j in range(i, m))


def _runge_kutta_starts(
    start: StartingMethod, problem: Problem, y0: np.ndarray, h: float
) -> tuple[np.ndarray, int]:
    """An explicit starting method on all initial values, one column each."""
    t0, slopes = float(problem.t_span[0]), []
    row_sums = [sum(float(x) for x in row) for row in start.A]
    for i, row in enumerate(start.A):
        stage = y0.copy()
        for j, slope in enumerate(slopes):
            stage += h * float(row[j]) * slope
        slopes.append(_slopes(problem, t0 + row_sums[i] * h, stage))
    values = np.stack([float(u) * y0 for u in start.u], axis=1)
    for k, row in enumerate(start.B):
        for weight, slope in zip(row, slopes, strict=True):
            values[:, k] += h * float(weight) * slope
    return values, len(slopes) * len(y0)


def _slopes(problem: Problem, t: float, y: np.ndarray) -> np.ndarray:
    """Right-hand side at every row of y, shape (N, d)."""
    try:
        found = np.asarray(problem.f(t, y.T), dtype=float)
        if found.shape == y.T.shape:
            return np.ascontiguousarray(found.T)
    except (TypeError, ValueError, IndexError):
        pass  # a callable that takes one state at a time
    return np.stack([np.asarray(problem.f(t, row), dtype=float) for row in y])


class _Runner:
    """Steps all trajectories; keeps their state between calls."""

    width = 1

    def __init__(
        self, method: GLM | PartitionedGLM, problem: Problem, h: float, arithmetic: str,
        solver: str, threads: int, width: int | None, cancel: Callable[[], bool] | None,
    ) -> None:  # fmt: skip
        self.method, self.problem, self.h, self.threads = method, problem, h, threads
        self.cancel, self.cancelled = cancel, False
        self.t0 = float(problem.t_span[0])
        self.build(arithmetic, solver, width)

    def build(self, arithmetic: str, solver: str, width: int | None) -> None:
        """Generate and compile."""
        raise NotImplementedError

    def load(self, values: np.ndarray) -> None:
        """Make (N, r, d) the state at step 0."""
        raise NotImplementedError

    def advance(self, first: int, last: int) -> None:
        """Take steps first..last of every trajectory."""
        raise NotImplementedError

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
        """Values (N, r, d), outcome codes (N,), steps (N,) and evaluations so far."""
        raise NotImplementedError

    @property
    def description(self) -> str:
        """What was built, in words."""
        raise NotImplementedError

    build_seconds = 0.0

    def one_step(self, values: np.ndarray) -> tuple[np.ndarray, int]:
        """One step from given values, for the enhanced start."""
        self.load(values)
        self.advance(0, 1)
        after, _, _, evaluations = self.read()
        return after, evaluations

    def each(self, work: Callable[[Any], None], items: Iterable[Any]) -> None:
        """Call ``work`` on every item, in threads."""
        if self.threads == 1:
            for item in items:
                work(item)
            return
        with ThreadPoolExecutor(self.threads) as pool:
            for _ in pool.map(work, items):
                pass

    def stopped(self) -> bool:
        """Whether the run has been cancelled."""
        if not self.cancelled and self.cancel is not None:
            self.cancelled = bool(self.cancel())
        return self.cancelled

    def run(self, values: np.ndarray, evaluations: int, plan: Any) -> EnsembleSolution:
        """Take all steps, keeping the rows of the plan."""
        self.load(values)
        begin, rows, done = time.perf_counter(), [], 0
        found = (values, np.zeros(len(values), dtype=int), np.zeros(len(values), dtype=int), 0)
        times = []
        try:
            for n in plan.rows:
                self.advance(done, n)
                done = n
                found = self.read()
                if self.cancelled and n:
                    break
                rows.append(found[0][:, 0].copy())
                times.append(n)
        except KeyboardInterrupt:
            self.cancelled = True
        if not rows or self.cancelled:
            rows.append(found[0][:, 0].copy())
            times.append(int(found[2].min()))
        seconds = time.perf_counter() - begin
        last, codes, steps, spent = found
        outcomes = np.array([KERNEL_OUTCOMES[int(code)] for code in codes], dtype=object)
        if self.cancelled:
            outcomes[(codes == 0) & (steps < plan.steps)] = Outcome.CANCELLED
        return EnsembleSolution(
            t=self.t0 + self.h * np.array(times, dtype=float), y=np.stack(rows), outcomes=outcomes,
            steps=steps, values=last, evaluations=evaluations + spent, seconds=seconds,
            build_seconds=self.build_seconds, width=self.width, threads=self.threads,
            kernel=self.description,
        )  # fmt: skip


class _Lanes(_Runner):
    """Blocks of lanes."""

    def build(self, arithmetic: str, solver: str, width: int | None) -> None:
        begin = time.perf_counter()
        wanted = "auto" if arithmetic == "strict" else "standard"
        self.form, self.shape = choose_form(self.method, self.problem, wanted)
        options = prepare_options(self, arithmetic, solver)
        self.source: LaneSource
        for choice in (width,) if width else reversed(WIDTHS):
            self.source = lane_source(self.form, self.shape, options, int(choice or 0))
            if self.source.work_size * 8 <= _FAST_MEMORY:
                break
        self.width, self.options = self.source.width, options
        self.built = compiled.build(self.source.text, LANE_SIGNATURE, {})
        self.build_seconds = time.perf_counter() - begin

    @property
    def description(self) -> str:
        words = [f"{self.built.engine}, {self.form.kind} form", f"{self.width} lanes"]
        if self.form.implicit_stages:
            words.insert(1, self.options.solver)
        return ", ".join(words)

    def load(self, values: np.ndarray) -> None:
        n, w, rows = len(values), self.width, self.source.rows
        blocks = -(-n // w)
        self.count = n
        head = (rows["done"] + 1) * w
        self.heads = np.zeros((blocks, rows["done"] + 1, w))
        padded = np.concatenate([values, np.repeat(values[-1:], blocks * w - n, axis=0)])
        inner = self.form.into(padded)
        slopes = _slopes(self.problem, self.t0, padded[:, 0])
        for k in range(inner.shape[1]):
            self._put(f"y{k}", inner[:, k])
        for i, weight in enumerate(self.form.memory_weights):
            self._put(f"L{i}", self.h * weight * slopes)
        self.head_size = head
        self.initial_evaluations = n if self.form.implicit_stages else 0

    def _put(self, name: str, vectors: np.ndarray) -> None:
        blocks, _, w = self.heads.shape
        row, d = self.source.rows[name], vectors.shape[1]
        self.heads[:, row : row + d] = vectors.reshape(blocks, w, d).transpose(0, 2, 1)

    def _get(self, name: str, size: int) -> np.ndarray:
        row = self.source.rows[name]
        found = self.heads[:, row : row + size].transpose(0, 2, 1)
        return found.reshape(-1, size)[: self.count]

    def advance(self, first: int, last: int) -> None:
        if last <= first:
            return

        def work(block: int) -> None:
            scratch = np.zeros(self.source.work_size)
            scratch[: self.head_size] = self.heads[block].ravel()
            lanes = min(self.width, self.count - block * self.width)
            n, chunk = first, _FIRST_CHUNK
            while n < last and not self.stopped():
                until = min(last, n + chunk)
                begin = time.perf_counter()
                self.built.kernel(scratch, self.shape.values, self.t0, self.h, n, until, lanes)
                if time.perf_counter() - begin < _CHUNK_SECONDS:
                    chunk *= 2
                n = until
            self.heads[block] = scratch[: self.head_size].reshape(self.heads[block].shape)

        self.each(work, range(len(self.heads)))

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
        d = self.shape.dimension
        rows = max(self.form.r, getattr(self.form, "r_hat", 0))
        inner = np.stack([self._get(f"y{k}", d) for k in range(rows)], axis=1)
        values = self.form.back(inner)
        status, steps = self._get("status", 1)[:, 0], self._get("done", 1)[:, 0]
        explicit, per_round = self._costs()
        rounds = float(self._get("rounds", 1).sum())
        evaluations = self.initial_evaluations + int(explicit * steps.sum() + per_round * rounds)
        return values, status.astype(int), steps.astype(int), evaluations

    def _costs(self) -> tuple[int, int]:
        """Counted evaluations of the explicit stages of a step, and of one solver round."""
        if isinstance(self.method, PartitionedGLM):
            return self.method.n_Q, 0
        explicit = sum(1 for b in self.form.blocks if not b.implicit)
        sizes = {len(b.stages) for b in self.form.blocks if b.implicit}
        return explicit, max(sizes, default=0)


def prepare_options(runner: _Lanes, arithmetic: str, solver: str) -> Any:
    """Options of a lane kernel: the solver by the rule for single runs, as far as lanes have it."""
    from .codegen import Options
    from .kernel import ARITHMETIC, choose_solver

    if arithmetic not in ARITHMETIC:
        raise UsageError(f"`arithmetic` must be one of {', '.join(ARITHMETIC)}, got {arithmetic!r}")
    options = Options(compensated=arithmetic != "naive")
    form, shape = runner.form, runner.shape
    if isinstance(runner.method, PartitionedGLM):
        return options
    assert isinstance(form, StepForm)
    chosen = choose_solver(form, shape, runner.problem, runner.h, solver)
    unknowns = shape.half if shape.halved else shape.dimension
    single = all(len(b.stages) == 1 for b in form.blocks if b.implicit)
    inline = single and unknowns <= INLINE_LIMIT and shape.jacobian is not None
    if chosen == "newton" and not inline:
        if solver == "newton":
            raise UsageError(
                "lanes have Newton's method for single stages of at most "
                f"{INLINE_LIMIT} unknowns; give width=1"
            )
        chosen = "fixed-point"
    return replace(options, solver=chosen)


class _Singles(_Runner):
    """One trajectory after the other, in threads."""

    def build(self, arithmetic: str, solver: str, width: int | None) -> None:
        self.kernel: Kernel = prepare(
            self.method, self.problem, h=self.h, arithmetic=arithmetic, solver=solver
        )
        self.build_seconds = self.kernel.seconds
        if self.kernel.built.engine == "python":
            self.threads = 1

    @property
    def description(self) -> str:
        return self.kernel.description

    def load(self, values: np.ndarray) -> None:
        slopes = _slopes(self.problem, self.t0, values[:, 0])
        self.states = [
            self.kernel.state(x, slope, self.h) for x, slope in zip(values, slopes, strict=True)
        ]
        self.codes = np.zeros(len(values), dtype=int)

    def advance(self, first: int, last: int) -> None:
        out = np.zeros((1, 1, self.problem.dimension))

        def work(k: int) -> None:
            if self.codes[k] == 0 and not self.stopped():
                outcome, _ = self.kernel.advance(
                    self.states[k], last, t0=self.t0, h=self.h, every=0, out=out,
                    pause=lambda _: self.stopped(),
                )  # fmt: skip
                if outcome in KERNEL_OUTCOMES:
                    self.codes[k] = KERNEL_OUTCOMES.index(outcome)

        self.each(work, range(len(self.states)))

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
        values = np.stack([self.kernel.values(state) for state in self.states])
        steps = np.array([state.step for state in self.states])
        evaluations = sum(int(state.tally[0]) for state in self.states)
        extra = len(self.states) if self.kernel.form.implicit_stages else 0
        return values, self.codes.copy(), steps, evaluations + extra
