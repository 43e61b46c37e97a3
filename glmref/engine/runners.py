"""How an ensemble is stepped: blocks of lanes, or one trajectory after the other; in threads."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from ..problems.user_functions import raised
from . import kernel_cache, native
from .expressions import Unsupported
from .kept import expressed, stepper_of
from .kernel import Kernel, choose_form, form_of, kept_source, prepare
from .lanes import LANE_ARGUMENTS, LaneSource, in_vectors, lane_source
from .native import Tuning
from .newton import INLINE_LIMIT, written_out
from .options import Options
from .outcome import KERNEL_OUTCOMES, Interrupted, Outcome
from .plan import check_arithmetic
from .solver_choice import choose_solver

WIDTHS = (8, 16, 32)
_FAST_MEMORY = 40 * 1024  # bytes of work array per block, about a first-level cache
#: Bytes of a block of vectors up to which lanes lost nowhere (tools/measure); beyond, about a
#: quarter of a second-level cache, they gain with a force of all bodies on all others only.
_VECTOR_MEMORY = 256 * 1024
_CHUNK_SECONDS = 0.1
_FIRST_CHUNK = 64


@dataclass(frozen=True, eq=False)
class EnsembleSolution:
    """What an ensemble computed."""

    t: np.ndarray  #: (m,) times kept.
    y: np.ndarray  #: (m, N, d) solutions; a trajectory that ended early keeps its last good value.
    outcomes: np.ndarray  #: (N,) of :class:`.outcome.Outcome`.
    steps: np.ndarray  #: (N,) steps completed.
    values: np.ndarray  #: (N, r, d) values carried at the end, in the method's basis.
    evaluations: int  #: Right-hand-side evaluations in all, start included.
    seconds: float  #: Wall clock time of the steps.
    build_seconds: float  #: Of generating and compiling.
    width: int  #: Lanes per block (1: one by one).
    threads: int  #: How many.
    kernel: str  #: What was built, in words.
    notices: tuple[str, ...] = ()  #: Sentences worth knowing.

    @property
    def completed(self) -> bool:
        """Whether every trajectory took every step."""
        return bool((self.outcomes == Outcome.COMPLETED).all())


def slopes_at(problem: Problem, t: float, y: np.ndarray) -> np.ndarray:
    """Return the right-hand side at every row of y, shape (N, d)."""
    return rows_at(lambda x: problem.f(t, x), y)


def rows_at(function: Callable[[np.ndarray], Any], y: np.ndarray) -> np.ndarray:
    """Return a function of one state at every row of y, in the shape of y."""
    try:
        found = np.asarray(function(y.T), dtype=float)
        if found.shape == y.T.shape:
            return np.ascontiguousarray(found.T)
    except (TypeError, ValueError, IndexError):
        pass  # a callable that takes one state at a time
    return np.stack([np.asarray(function(row), dtype=float) for row in y])


class Runner:
    """Steps all trajectories; keeps their state between calls."""

    width = 1

    def __init__(
        self, method: Method, problem: Problem, y0: np.ndarray, h: float, arithmetic: str,
        solver: str, threads: int, width: int | None, cancel: Callable[[], bool] | None,
    ) -> None:  # fmt: skip
        self.method, self.problem, self.h, self.threads = method, expressed(problem), h, threads
        self.cancel, self.cancelled = cancel, False
        self.notices: list[str] = []
        self.t0 = float(problem.t_span[0])
        self.engine = stepper_of(method, problem)
        # the solver is chosen where the ensemble starts, not where the problem does
        self.first = self.problem
        if problem.context is None and tuple(y0) != tuple(problem.y0):
            self.first = replace(self.problem, y0=tuple(y0), initial=None)
        self.build(arithmetic, solver, width)

    def build(self, arithmetic: str, solver: str, width: int | None) -> None:
        """Generate and compile."""
        raise NotImplementedError

    def load(self, values: np.ndarray, first: int = 0) -> None:
        """Make (N, r, d) the state at a step."""
        raise NotImplementedError

    def advance(self, first: int, last: int) -> None:
        """Take steps first..last of every trajectory."""
        raise NotImplementedError

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
        """Return values (N, r, d), outcome codes (N,), steps (N,) and evaluations so far."""
        raise NotImplementedError

    @property
    def description(self) -> str:
        """What was built, in words."""
        raise NotImplementedError

    build_seconds = 0.0

    def one_step(self, n: int, values: np.ndarray) -> tuple[np.ndarray, int]:
        """Return the step after step n from given values, for the enhanced start."""
        self.load(values, n)
        self.advance(n, n + 1)
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
        """Return whether the run has been cancelled."""
        if not self.cancelled and self.cancel is not None:
            try:
                self.cancelled = bool(self.cancel())
            except Exception as error:
                self.cancelled = True
                self.notices.append(str(raised("cancel", error)))
        return self.cancelled

    def run(self, values: np.ndarray, evaluations: int, plan: Any) -> EnsembleSolution:
        """Take all steps, keeping the rows of the plan."""
        self.load(values)
        begin, rows, done = time.perf_counter(), [], 0
        found = (values, np.zeros(len(values), dtype=int), np.zeros(len(values), dtype=int), 0)
        times, interrupted = [], False
        try:
            for n in plan.rows:
                self.advance(done, n)
                done = n
                found = self.read()
                if self.cancelled and n:
                    break
                rows.append(self.engine.solution(found[0]).copy())
                times.append(n)
        except KeyboardInterrupt:
            self.cancelled = interrupted = True
        if not rows or self.cancelled:
            rows.append(self.engine.solution(found[0]).copy())
            times.append(int(found[2].min()))
        seconds = time.perf_counter() - begin
        last, codes, steps, spent = found
        y = np.stack(rows)
        good = np.asarray(np.isfinite(y).all(axis=2))
        for k in np.flatnonzero(~(good.all(axis=0) & np.isfinite(last).all(axis=(1, 2)))):
            wrong = [t for t, fine in zip(times, good[:, k], strict=True) if not fine]
            n = min([int(steps[k]), *wrong])
            steps[k], last[k] = self._before(values[k], n)
            given_up = ~good[:, k] | (np.array(times) > steps[k])
            y[given_up, k] = self.engine.solution(last[k])
            codes[k] = codes[k] or KERNEL_OUTCOMES.index(Outcome.NOT_FINITE)
        outcomes = np.array([KERNEL_OUTCOMES[int(code)] for code in codes], dtype=object)
        if self.cancelled:
            outcomes[(codes == 0) & (steps < plan.steps)] = Outcome.CANCELLED
        found = EnsembleSolution(
            t=self.t0 + self.h * np.array(times, dtype=float), y=y, outcomes=outcomes,
            steps=steps, values=last, evaluations=evaluations + spent, seconds=seconds,
            build_seconds=self.build_seconds, width=self.width, threads=self.threads,
            kernel=self.description, notices=tuple(self.notices),
        )  # fmt: skip
        if interrupted:
            raise Interrupted(found)
        return found

    def _before(self, values: np.ndarray, n: int) -> tuple[int, np.ndarray]:
        """Return a step before n after which a trajectory from values (r, d) is in range.

        Also its values then: those of a kernel may be finite where their sums are not.
        """
        back = 1
        while (n := n - back) > 0:
            self.load(values[None])
            self.advance(0, n)
            (found,), _, (done,), _ = self.read()
            if done == n and self.engine.in_range(found):
                return n, found
            back *= 2
        return 0, values


class Lanes(Runner):
    """Blocks of lanes."""

    def build(self, arithmetic: str, solver: str, width: int | None) -> None:
        """See :class:`Runner`.

        Raises
        ------
        Unsupported
            Where trajectories have to go one by one, or, without a width asked for, should.
        """
        begin = time.perf_counter()
        self.form, self.shape = choose_form(self.method, self.problem, form_of(arithmetic))
        options = prepare_options(self, arithmetic, solver)
        vectors = in_vectors(self.shape)
        for choice in (width,) if width else WIDTHS[:1] if vectors else reversed(WIDTHS):
            given, about = (self.form, self.shape), (options, choice)
            write = partial(lane_source, *given, *about)
            self.source = kept_source(LaneSource, *given, about, write)
            if self.source.work_size * 8 <= _FAST_MEMORY:
                break
        large = self.source.work_size * 8 > _VECTOR_MEMORY and not self.shape.pairwise
        if vectors and width is None and large:
            raise Unsupported("a block of lanes leaves the cache")
        self.width, self.options = self.source.width, options
        tuning = Tuning(wide=True, fuse=options.fused)
        arguments = LANE_ARGUMENTS
        if self.source.vectors:
            tuning, arguments = replace(tuning, lanes=self.width), {**arguments, "x": "v*"}
        self.built = kernel_cache.build(self.source.text, arguments, tuning=tuning)
        self.build_seconds = time.perf_counter() - begin

    @property
    def description(self) -> str:
        """See :class:`Runner`."""
        words = [f"{self.built.engine}, {self.form.kind} form", f"{self.width} lanes"]
        if self.form.implicit_stages:
            words.insert(1, self.options.solver)
        if self.options.fused:
            words.append("fused")
        return ", ".join(words)

    def load(self, values: np.ndarray, first: int = 0) -> None:
        """See :class:`Runner`."""
        n, w = len(values), self.width
        blocks = -(-n // w)
        padded = np.concatenate([values, np.repeat(values[-1:], blocks * w - n, axis=0)])
        slopes = slopes_at(self.problem, self.t0 + first * self.h, self.engine.solution(padded))
        state = self.form.state(
            padded, slopes, self.h, compensated=self.options.compensated,
            moves=self.shape.parts[0].identity,
        )  # fmt: skip
        #: Of each block the numbers of the state, a status, rounds and steps, by lane.
        self.heads = np.zeros((blocks, state[0].size + 3, w))
        self.heads[:, :-3] = state.reshape(blocks, w, -1).transpose(0, 2, 1)
        self.count = n
        self.initial_evaluations = n if self.form.memory else 0

    def advance(self, first: int, last: int) -> None:
        """See :class:`Runner`."""
        if last <= first:
            return

        def work(block: int) -> None:
            scratch = native.aligned_zeros(self.source.work_size)
            scratch[: self.heads[block].size] = self.heads[block].ravel()
            lanes = min(self.width, self.count - block * self.width)
            n, chunk = first, _FIRST_CHUNK
            while n < last and not self.stopped():
                until = min(last, n + chunk)
                begin = time.perf_counter()
                self.built.kernel(scratch, self.shape.values, self.t0, self.h, n, until, lanes)
                if time.perf_counter() - begin < _CHUNK_SECONDS:
                    chunk *= 2
                n = until
            self.heads[block] = scratch[: self.heads[block].size].reshape(self.heads[block].shape)

        self.each(work, range(len(self.heads)))

    def read(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
        """See :class:`Runner`."""
        found = self.heads.transpose(0, 2, 1).reshape(-1, self.heads.shape[1])[: self.count]
        state = found[:, :-3].reshape(self.count, -1, self.shape.dimension)
        values = self.form.values(state, self.h, compensated=self.options.compensated)
        status, rounds, steps = found[:, -3:].T
        begun = steps.sum() + np.count_nonzero(status)  # one more where a step failed
        spent = self.form.evaluations(int(begun), int(rounds.sum()))
        return values, status.astype(int), steps.astype(int), self.initial_evaluations + spent


def prepare_options(runner: Lanes, arithmetic: str, solver: str) -> Any:
    """Return options of a lane kernel: the solver by the rule for single runs, as far as possible.

    Raises
    ------
    UsageError
        For a solver that lanes do not have, asked for by name.
    Unsupported
        For a large system with Newton's method.
    """
    check_arithmetic(arithmetic)
    options = Options.of(arithmetic)
    form, shape = runner.form, runner.shape
    if runner.method.parts == 2:
        return options
    chosen = choose_solver(form, shape, runner.first, runner.h, solver)
    if chosen == "newton" and in_vectors(shape):
        raise Unsupported("Newton's method in vectors of lanes")
    if chosen == "newton" and not written_out(form, shape):
        if solver == "newton":
            raise UsageError(
                "lanes have Newton's method for single stages of at most "
                f"{INLINE_LIMIT} unknowns; give width=1"
            )
        chosen = "fixed-point"
    return replace(options, solver=chosen)


class Singles(Runner):
    """One trajectory after the other, in threads."""

    def build(self, arithmetic: str, solver: str, width: int | None) -> None:
        """See :class:`Runner`."""
        self.kernel: Kernel = prepare(
            self.method, self.first, h=self.h, arithmetic=arithmetic, solver=solver
        )
        self.build_seconds = self.kernel.seconds
        if self.kernel.built.engine == "python":
            self.threads = 1

    @property
    def description(self) -> str:
        """See :class:`Runner`."""
        return self.kernel.description

    def load(self, values: np.ndarray, first: int = 0) -> None:
        """See :class:`Runner`."""
        slopes = slopes_at(self.problem, self.t0 + first * self.h, self.engine.solution(values))
        self.states = [
            self.kernel.state(x, slope, self.h) for x, slope in zip(values, slopes, strict=True)
        ]
        for state in self.states:
            state.tally[4] = first
        self.codes = np.zeros(len(values), dtype=int)

    def advance(self, first: int, last: int) -> None:
        """See :class:`Runner`."""
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
        """See :class:`Runner`."""
        values = np.stack([self.kernel.values(state) for state in self.states])
        steps = np.array([state.step for state in self.states])
        evaluations = sum(int(state.tally[0]) for state in self.states)
        extra = len(self.states) if self.kernel.form.memory else 0
        return values, self.codes.copy(), steps, evaluations + extra
