"""Everything between a method on a problem and a compiled loop: choices, arrays, chunks of steps.

The stage solver is chosen by a stated rule (:func:`choose_solver`): the one with the smaller
predicted cost per stage. With rho the contraction of the fixed point at the initial value and c the
cost of one evaluation, the fixed point takes about ``1 + 10 / -log10(rho)`` rounds from a predictor
that is right to six digits; Newton takes about 2.3 and pays for the matrix. Blocks of several
stages and systems of more than three unknowns use Newton where rho exceeds :data:`POOR`.
"""

from __future__ import annotations

import ast
import math
import time
from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import Method
from ..problems.derivative import Jacobian
from ..problems.formula import Formula
from ..problems.model import Problem
from ..problems.user import FunctionFailed, NoValue, UserFunction, raised
from . import compiled, native
from .codegen import ARGUMENTS, KernelSource, Options, kernel_source
from .forms import StepForm
from .kept import form_of_method, recalled
from .memory import NEWTON_BYTES, gibibytes
from .newton import INLINE_LIMIT, NewtonWriter
from .outcome import KERNEL_OUTCOMES, Outcome
from .partitioned import pair_source
from .partitioned_forms import PairForm
from .plan import check_arithmetic
from .shape import Shape, banded, jacobian_block, shape_of

SOLVERS = ("auto", "fixed-point", "newton")

POOR = 0.25  # a fixed point that contracts less than this per round is slow
_DIFFERENCES_UP_TO = 64  # dimension up to which a missing Jacobian is differenced for the estimate
_DENSE_UP_TO = 256  # dimension up to which a known one is formed for its norm
_NORM_ROUNDS = 2

#: Stages solved together from which on their operations are worth packing into vectors.
PACKED_STAGES = 3

#: Rough latencies in units of one addition, for comparing solvers.
_LATENCY = {ast.Add: 1, ast.Sub: 1, ast.Mult: 1, ast.Div: 4, ast.Pow: 10, ast.USub: 0}
_CALL_LATENCY = {"sqrt": 5}
_OTHER_CALL = 15
_ROUND_LATENCY = 12  # forming Y and L around one evaluation
_INLINE_SOLVE = {1: 6, 2: 14, 3: 40}
_NEWTON_ROUNDS = 2.3

_SAME_VALUE = 1e-9  # relative difference of a compiled function from the interpreted one

_FIRST_CHUNK = 256
_CHUNK_SECONDS = 0.05

_cached_shape = lru_cache(maxsize=128)(shape_of)


@dataclass
class State:
    """What a kernel works on, carried from one chunk of steps to the next.

    Attributes
    ----------
    work : np.ndarray
        The work array; ``y`` (r, d) and ``memory`` (rows, d) are views of its head.
    tally : np.ndarray
        Evaluations, velocity evaluations, iterations, factorisations, steps, rows.
    trouble : Exception or None
        What the right-hand side raised in the step that ended the run, or ``None``.
    h : float
        Step size.
    """

    work: np.ndarray
    y: np.ndarray
    memory: np.ndarray
    h: float
    tally: np.ndarray = field(default_factory=lambda: np.zeros(6, dtype=np.int64))
    trouble: Exception | None = None

    def take_back(self, work: np.ndarray, tally: np.ndarray) -> None:
        """Return to copies made earlier."""
        self.work[:], self.tally[:] = work, tally

    @property
    def step(self) -> int:
        """Steps completed."""
        return int(self.tally[4])


@dataclass(frozen=True)
class Kernel:
    """A compiled method on a problem.

    Attributes
    ----------
    form : StepForm or PairForm
        coefficients.
    shape : Shape
        problem.
    options : Options
        What was generated.
    source : KernelSource
        The generated module.
    built : compiled.Built
        The callable and where it came from.
    seconds : float
        Time it took to generate and compile or load.
    """

    form: StepForm | PairForm
    shape: Shape
    options: Options
    source: KernelSource
    built: compiled.Built
    seconds: float

    @property
    def description(self) -> str:
        """Engine, form, solver and arithmetic in words."""
        words = [f"{self.built.engine}, {self.form.kind} form"]
        if self.form.implicit_stages:
            words.append(self.options.solver)
        words.append("compensated" if self.options.compensated else "not compensated")
        if self.options.fused:
            words.append("fused")
        if self.options.quick and self.form.implicit_stages:
            words.append("quick")
        return ", ".join((*words, f"{self.source.target} target"))

    def state(self, values: np.ndarray, slope: np.ndarray, h: float) -> State:
        """State before the first step.

        Parameters
        ----------
        values : np.ndarray
            (r, d) starting values in the method's basis.
        slope : np.ndarray
            (d,) right-hand side at the first value: the force that a pair reuses, or the
            predictor's first guess (where it is not finite: zero).
        h : float
            Step size.
        """
        work = native.aligned_zeros(self.source.work_size)
        d, rows = self.shape.dimension, self.source.value_rows
        below = (2 if self.options.compensated else 1) * rows
        y = work[: rows * d].reshape(rows, d)
        memory = work[below * d : (below + self.source.memory_rows) * d].reshape(-1, d)
        y[:] = self.form.into(values)
        for row, (_, weight) in zip(memory, self.form.memory, strict=True):
            row[:] = remembered(slope, weight, h)
        state = State(work, y, memory, h)
        if isinstance(self.form, PairForm) and self.form.kick:
            p, rest, force = self._kept(state)
            p[:], lost = self.form.kicked(p, force, h)
            if self.options.compensated:
                rest[:] = lost
            if self.form.leaps and self.shape.parts[0].identity:
                memory[0, : self.shape.half] = h * p[0]
        return state

    def _kept(self, state: State) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """The values of p, their rounding errors (zero without them), and the force."""
        assert isinstance(self.form, PairForm)
        half, rows = slice(self.shape.half, self.shape.dimension), self.form.r_hat
        p = state.y[:rows, half]
        if not self.options.compensated:
            return p, np.zeros_like(p), state.memory[0, half]
        errors = state.work[state.y.size :][: state.y.size].reshape(state.y.shape)
        return p, errors[:rows, half], state.memory[0, half]

    def resumed(self, other: State) -> State:
        """State of another kernel of the same form, to go on from: same values, same counts."""
        work = native.aligned_zeros(self.source.work_size)
        head = other.memory.ctypes.data - other.work.ctypes.data
        size = head // other.work.itemsize + other.memory.size
        work[:size] = other.work[:size]
        start = size - other.memory.size
        memory = work[start:size].reshape(other.memory.shape)
        memory[~np.isfinite(memory)] = 0.0
        y = work[: other.y.size].reshape(other.y.shape)
        return State(work, y, memory, other.h, other.tally)

    def values(self, state: State) -> np.ndarray:
        """(r, d) values in the method's basis."""
        values = self.form.back(state.y)
        if isinstance(self.form, PairForm) and self.form.kick:
            rows = slice(0, self.form.r_hat)
            values[rows, self.shape.half :] = self.form.unkicked(*self._kept(state), state.h)
        return values

    def advance(
        self, state: State, last: int, *, t0: float, h: float, every: int, out: np.ndarray,
        pause: Callable[[int], bool] = lambda _: False,
    ) -> tuple[Outcome, float]:  # fmt: skip
        """Step until ``last`` steps are done, in chunks of about 50 ms.

        Parameters
        ----------
        every : int
            Record into ``out`` after every so many steps; 0 for never.
        pause : Callable[[int], bool]
            Called between chunks with the steps done; True cancels.

        Returns
        -------
        tuple[Outcome, float]
            The outcome and the seconds spent stepping.
        """
        chunk, seconds, flat = _FIRST_CHUNK, 0.0, out.reshape(-1)
        if self.built.engine == "python":
            chunk = 8
        grows = True
        while state.step < last:
            until = min(last, state.step + chunk)
            begin = time.perf_counter()
            mark = (state.step // every + 1) * every if every else -1
            code = self._called(state, t0, h, until, mark, every, flat)
            spent = time.perf_counter() - begin
            seconds += spent
            if code is None:
                # an exception came through: the same steps again in smaller pieces, up to the last
                # one before it
                chunk, grows = max(1, (until - state.step) // 2), False
            if code:
                return KERNEL_OUTCOMES[code], seconds
            if grows and spent < _CHUNK_SECONDS:
                chunk *= 8 if spent < _CHUNK_SECONDS / 8 else 2
            if state.step < last and pause(state.step):
                return Outcome.CANCELLED, seconds
        return Outcome.COMPLETED, seconds

    def _called(
        self, state: State, t0: float, h: float, until: int, mark: int, every: int, flat: np.ndarray
    ) -> int | None:
        """Call the kernel for the steps up to ``until``.

        Returns
        -------
        Its code; the one for a right-hand side that failed in the step after the state; ``None``
        where it failed after some steps, which are taken back.
        """
        kernel, first = self.built.kernel, state.step
        numbers = (t0, h, first, until, mark, every)
        row = int(state.tally[5])
        if self.built.engine == "native":
            return kernel(state.work, self.shape.par, *numbers, flat, row, state.tally)
        held = state.work.copy(), state.tally.copy()
        self.built.trouble.clear()
        try:
            code = kernel(state.work, self.shape.par, *numbers, flat, row, state.tally)
        except Exception as error:
            state.take_back(*held)
            own = isinstance(error, FunctionFailed)
            if not own and (self.built.engine == "python" or not self.shape.opaque):
                raise
            if until - first > 1:
                return None
            names = {"full": "f", "velocity": "dq", "force": "dp"}
            called = " or ".join(names[part.role] for part in self.shape.parts if part.function)
            state.trouble = error if own else raised(called, error)
            which = Outcome.NOT_FINITE if isinstance(state.trouble, NoValue) else None
            return KERNEL_OUTCOMES.index(which or Outcome.FUNCTION_FAILED)
        except BaseException:
            state.take_back(*held)
            raise
        if code and self.built.trouble:
            state.trouble = self.built.trouble[-1]
        return code


def remembered(slope: np.ndarray, weight: float | None, h: float) -> np.ndarray:
    """What :attr:`.forms.StepForm.memory` holds before the first step, given f at the start."""
    if weight is None:
        return slope
    guess = h * weight * slope
    return np.where(np.isfinite(guess), guess, 0.0)


def prepare(
    method: Method, problem: Problem, *, h: float, arithmetic: str = "strict",
    solver: str = "auto", form: str = "auto", history: bool = False, interpreted: bool = False,
) -> Kernel:  # fmt: skip
    """Choose form and solver, generate the kernel and compile it.

    Parameters
    ----------
    arithmetic : str
        ``"strict"``: structurally exact coefficients (sweep or mu-form) where the method has them,
        increments first, compensated; ``"fused"``: the same, but products and sums may be fused,
        which is faster and has the bits of the processor, not of the source; ``"quick"``: rounds
        of the fixed point end where the next change, as the last two predict it, would be below
        rounding, which saves a quarter of the evaluations and lets invariants drift
        (docs/engine.md); ``"compensated"``: A,
        U, B, V with compensated summation and the tableau's rounding residue; ``"naive"``: neither.
    solver : str
        One of :data:`SOLVERS`.
    form : str
        ``"auto"`` or one of :data:`.sweep.FORMS`, which overrides what ``arithmetic`` says.
    history : bool
        Whether all values are recorded.
    interpreted : bool
        Run the generated source in the interpreter.

    Raises
    ------
    UsageError
        When the method does not fit the problem or the form.
    """
    begin = time.perf_counter()
    check_arithmetic(arithmetic)
    if solver not in SOLVERS:
        raise UsageError(f"`solver` must be one of {', '.join(SOLVERS)}, got {solver!r}")
    wanted = form if form != "auto" else form_of(arithmetic)
    options = Options.of(arithmetic, history=history, interpreted=interpreted)
    # what a Python function computes may have changed with what it reads; an interpreted kernel
    # tells what went wrong in a list of its own
    anew = interpreted or any(
        isinstance(getattr(problem, key), UserFunction) for key in ("f", "dq", "dp")
    )
    make = _prepared.__wrapped__ if anew else _prepared
    kernel = make(method, problem, float(h), wanted, solver, options)
    return replace(kernel, seconds=time.perf_counter() - begin)


@lru_cache(maxsize=256)
def _prepared(
    method: Method, problem: Problem, h: float, form: str, solver: str,
    options: Options,
) -> Kernel:  # fmt: skip
    """Kernel for a method, a problem and a step size, kept for the next run with the same ones."""
    begin = time.perf_counter()
    coefficients, shape = choose_form(method, problem, form)
    if isinstance(coefficients, StepForm):
        options = replace(options, solver=choose_solver(coefficients, shape, problem, h, solver))
        if options.solver == "newton":
            shape = with_band(shape)
    kernel = _assembled(coefficients, shape, options, begin)
    strange = _computes_otherwise(kernel, problem)
    if not strange:
        return kernel
    options = replace(kernel.options, interpreted=True)
    return _assembled(coefficients, shape, options, begin, strange)


def _computes_otherwise(kernel: Kernel, problem: Problem) -> str:
    """Why a user's function must not be compiled: its value at the start is another then.

    Compiled code has whole numbers of 64 bits, and the values that global names had at the time.
    """
    y, m = np.array(problem.y0, dtype=float), kernel.shape.half
    points = {"full": (float(problem.t_span[0]), y), "velocity": (y[m:],), "force": (y[:m],)}
    for part in kernel.shape.parts:
        compiled_one = kernel.built.functions.get(part.role)
        if compiled_one is None or part.function is None:
            continue
        point = points[part.role]
        try:
            expected = np.asarray(part.function(*point), dtype=float)
            found = np.array(compiled_one(*point[:-1], point[-1].copy()), dtype=float)
        except Exception:
            continue  # no value at the start; the run itself says so
        far = np.abs(found - expected) > _SAME_VALUE * np.abs(expected).max(initial=0.0)
        if found.shape != expected.shape or far.any():
            name = getattr(part.function, "__name__", "the right-hand side")
            return (
                f"{name} gives another value when it is compiled (whole numbers beyond 64 bits?); "
                f"the kernel is interpreted, about 30 times slower"
            )
    return ""


def form_of(arithmetic: str) -> str:
    """Return the form an arithmetic stands for: exact where the method has it, or A, U, B, V."""
    return "auto" if arithmetic in ("strict", "fused", "quick") else "standard"


def choose_form(method: Any, problem: Problem, form: str) -> tuple[StepForm | PairForm, Shape]:
    """Coefficients in the form asked for, and the shape of the problem.

    Raises
    ------
    UsageError
        For an additive method.
    """
    if method.additive:
        raise UsageError("kernels are not made for additive methods; use engine='reference'")
    split = True if method.parts == 2 else None
    return form_of_method(method, form), _cached_shape(problem, split=split)


def _assembled(
    form: StepForm | PairForm, shape: Shape, options: Options, begin: float, notice: str = ""
) -> Kernel:
    source = _source_of(form, shape, options)
    functions = {part.role: part.function for part in shape.parts if part.function is not None}
    if options.interpreted:
        built = compiled.interpret(source.text, functions, notice)
    else:
        pack = source.side_by_side >= PACKED_STAGES or source.target == "array"
        tuning = native.Tuning(pack=pack, fuse=options.fused)
        built = compiled.build(source.text, ARGUMENTS, functions, tuning)
        if built.engine == "python":
            options = replace(options, interpreted=True)
            source = _source_of(form, shape, options)
            built = compiled.interpret(source.text, functions, built.notice)
    return Kernel(form, shape, options, source, built, time.perf_counter() - begin)


def _source_of(form: StepForm | PairForm, shape: Shape, options: Options) -> KernelSource:
    """The generated module, kept by the identity of form and shape, which are kept themselves."""
    key = id(form), id(shape), options
    known = _sources.get(key)
    if known is not None and known[0] is form and known[1] is shape:
        return known[2]
    write = pair_source if isinstance(form, PairForm) else kernel_source
    if shape.opaque:
        source: KernelSource = write(form, shape, options)  # type: ignore[arg-type]
    else:
        about = repr((form, replace(shape, values=shape.values.tolist()), options))
        source = recalled(
            "source",
            about,
            lambda: write(form, shape, options),  # type: ignore[arg-type]
            lambda fields: KernelSource(**fields),
            asdict,
        )
    if len(_sources) >= _MOST_SOURCES:
        _sources.clear()
    _sources[key] = form, shape, source
    return source


_MOST_SOURCES = 256
_sources: dict[tuple[int, int, Options], tuple[StepForm | PairForm, Shape, KernelSource]] = {}


def with_newton(kernel: Kernel) -> Kernel:
    """Return the same kernel with Newton in place of the fixed point."""
    options = replace(kernel.options, solver="newton")
    return _assembled(kernel.form, with_band(kernel.shape), options, time.perf_counter())


# --- which solver -------------------------------------------------------------------------------


def newton_writer(form: StepForm, shape: Shape) -> NewtonWriter:
    """What knows the matrices of Newton's method, without a kernel around it."""
    writer = NewtonWriter()
    writer.form, writer.shape = form, shape
    writer.unknowns = shape.half if shape.halved else shape.dimension
    return writer


def with_band(shape: Shape) -> Shape:
    """The shape with the band of its Newton matrices, kept by the identity of the shape."""
    if shape.dimension < _BANDED_FROM or shape.band is not None:
        return shape
    known = _bands.get(id(shape))
    if known is None or known[0] is not shape:
        if len(_bands) >= _MOST_SOURCES:
            _bands.clear()
        known = _bands[id(shape)] = shape, banded(shape)
    return known[1]


_BANDED_FROM = 32
_bands: dict[int, tuple[Shape, Shape]] = {}


def contraction(form: StepForm, shape: Shape, problem: Problem, h: float) -> float:
    """Contraction per fixed-point round at the initial value: h rho(w M) |J|, squared if halved.

    Beyond :data:`_DENSE_UP_TO` components the norm is estimated, see :func:`_norm_estimate`.
    rho(w M) is the largest spectral radius of a block of stages that are solved together: the norm
    of a block of Gauss stages would be too pessimistic by an order of magnitude. Zero for an
    explicit method; ``nan`` where the Jacobian is not known and too large to be differenced.
    """
    if not form.implicit_stages:
        return 0.0
    scaled = np.array(form.weights)[:, None] * np.array(form.M)
    radii = [
        np.abs(np.linalg.eigvals(scaled[np.ix_(block.stages, block.stages)])).max()
        for block in form.blocks
        if block.implicit
    ]
    size = abs(h) * float(max(radii))
    if shape.dimension > _DENSE_UP_TO and problem.jacobian is not None:
        norm = _norm_estimate(shape, problem)
        return size * size * norm if shape.halved else size * norm
    norm = _norm(shape, problem)
    return size * size * norm if shape.halved else size * norm


def _norm(shape: Shape, problem: Problem) -> float:
    """Row-sum norm of J at the initial value, of K J_f where the shape is halved; or ``nan``."""

    def computed() -> float:
        matrix, m = _jacobian(problem), shape.half
        if matrix is None:
            return math.nan
        if shape.halved:
            matrix = matrix[m:, :m] @ matrix[:m, m:]
        return float(np.linalg.norm(matrix, ord=np.inf))

    formulas = (problem.f, *([problem.jacobian] if problem.jacobian is not None else []))
    if not all(isinstance(x, Formula | Jacobian) for x in formulas):
        return computed()
    y0 = np.array(problem.y0, dtype=float).tolist()
    about = repr((formulas, shape.halved, float(problem.t_span[0]), y0))
    return recalled("norm", about, computed, float, float)


def _jacobian(problem: Problem) -> np.ndarray | None:
    t, y, d = problem.t_span[0], np.array(problem.y0, dtype=float), problem.dimension
    with np.errstate(all="ignore"):
        if problem.jacobian is not None:
            try:
                return np.asarray(problem.jacobian(t, y), dtype=float)
            except (ArithmeticError, ValueError):
                return None  # no value there
        if d > _DIFFERENCES_UP_TO:
            return None
        columns = []
        try:
            base = np.asarray(problem.f(t, y), dtype=float)
            for k in range(d):
                moved = y.copy()
                moved[k] += 1e-8 * (abs(y[k]) + 1)
                slope = np.asarray(problem.f(t, moved), dtype=float)
                columns.append((slope - base) / (moved[k] - y[k]))
        except (ArithmeticError, ValueError):
            return None
    return np.stack(columns, axis=1)


def _norm_estimate(shape: Shape, problem: Problem) -> float:
    """Lower bound of the row-sum norm of J, of K J_f on a separable problem, without a matrix.

    Every |J v| is one for |v| = 1 in the maximum norm. The first v has random signs: some row of a
    large sparse matrix meets the signs of its entries. Every further v has the signs of J v, as the
    power iteration for this norm takes them. Each round costs a difference of two evaluations;
    ``nan`` where one is no number.
    """
    t, y, m = problem.t_span[0], np.array(problem.y0, dtype=float), shape.half
    maps: list[tuple[Callable[[np.ndarray], Any], np.ndarray]]
    if not shape.halved:
        maps = [(lambda x: problem.f(t, x), y)]
    else:
        assert problem.dq is not None and problem.dp is not None
        velocity, force = problem.dq, problem.dp
        maps = [] if shape.parts[0].identity else [(velocity, y[m:])]
        maps.append((force, y[:m]))
    found, signs = 0.0, np.random.default_rng(1).integers(0, 2, len(maps[0][1])) * 2.0 - 1.0
    try:
        with np.errstate(all="ignore"):
            bases = [np.asarray(function(x), dtype=float) for function, x in maps]
            for _ in range(_NORM_ROUNDS):
                v = signs
                for (function, x), base in zip(maps, bases, strict=True):
                    step = 2.0**-26 * (np.abs(x).max() + 1) / max(np.abs(v).max(), 1e-300)
                    v = (np.asarray(function(x + step * v), dtype=float) - base) / step
                found = float(np.maximum(found, np.abs(v).max()))  # which keeps nan
                signs = np.where(v < 0, -1.0, 1.0)
    except (ArithmeticError, ValueError):
        return math.nan
    return found


def newton_bytes(form: StepForm, shape: Shape) -> int:
    """Memory that Newton's method needs for the Jacobian and its factored matrices."""
    writer = newton_writer(form, shape)
    return 8 * (writer.jacobian_size + sum(one.doubles for one in writer.systems().values()))


def choose_solver(
    form: StepForm, shape: Shape, problem: Problem, h: float, solver: str = "auto"
) -> str:
    """Fixed point or Newton, by predicted cost; see the module's docstring.

    Raises
    ------
    UsageError
        When Newton is asked for and its matrices are beyond :data:`NEWTON_BYTES`.
    """
    if not form.implicit_stages or solver == "fixed-point":
        return "fixed-point" if solver == "auto" else solver
    if solver == "newton":
        shape = with_band(shape)
        needed = newton_bytes(form, shape)
        if needed > NEWTON_BYTES:
            raise UsageError(
                f"Newton's method on {shape.dimension} components needs {gibibytes(needed)} for "
                f"its matrices, and at most {gibibytes(NEWTON_BYTES)} are given to it; use "
                f"solver='fixed-point'"
            )
        return solver
    rho = contraction(form, shape, problem, h)
    if rho == 0.0 or not math.isfinite(rho):
        return "fixed-point"
    single = all(len(block.stages) == 1 for block in form.blocks if block.implicit)
    unknowns = shape.half if shape.halved else shape.dimension
    inline = single and unknowns <= INLINE_LIMIT and shape.jacobian is not None
    if not inline or shape.loops or rho > POOR:
        if rho <= POOR:
            return "fixed-point"
        shape = with_band(shape)
        fits = newton_bytes(form, shape) <= NEWTON_BYTES
        return "newton" if fits and _newton_pays(form, shape, rho) else "fixed-point"
    about = repr(replace(shape, values=[]))
    once, jacobian = recalled("latency", about, lambda: _latencies(shape), tuple, list)
    rounds = 1 + 10 / -math.log10(rho)
    newton = _NEWTON_ROUNDS * once + jacobian + _INLINE_SOLVE[unknowns]
    return "newton" if newton < rounds * once else "fixed-point"


def _newton_pays(form: StepForm, shape: Shape, rho: float) -> bool:
    """Whether the factored matrices of a large system cost less than rounds of the fixed point.

    In operations: a round evaluates every stage and forms it from the others; Newton solves with
    every matrix besides, twice its entries, four times as many where it is complex, and factors
    them every so many steps.
    """
    writer = newton_writer(form, shape)
    if writer.unknowns <= _SMALL or rho >= _DIVERGES:
        return True
    stages = form.implicit_stages
    read = _READ * shape.dimension if shape.band is None else 2 * shape.band.entries
    once = stages * (read + (2 * stages + _AROUND) * shape.dimension)
    solves, factors = 0.0, 0.0
    for one in writer.systems().values():
        weight = 4 if one.value.imag else 1
        solves += 2 * weight * one.length
        factors += 2 * weight * one.length * min(one.lower, one.size / 3)
    fixed = (1 + 10 / -math.log10(rho)) * once
    return _NEWTON_ROUNDS_LARGE * (once + solves) + factors / _STEPS_PER_FACTOR < fixed


_SMALL = 64  # unknowns up to which a poor contraction is enough to prefer Newton
_DIVERGES = 0.9
_READ = 8  # operations for one component of a right-hand side whose structure is not known
_AROUND = 10  # operations around one component: residual, comparison, sum
_NEWTON_ROUNDS_LARGE = 4
_STEPS_PER_FACTOR = 10


def _latencies(shape: Shape) -> tuple[int, int]:
    """Operations of a round of the fixed point, and of the Jacobian, weighted by their latency."""
    d, m = shape.dimension, shape.half
    once = _ROUND_LATENCY + sum(_latency(p.formula) for p in shape.parts if p.formula)
    if not shape.halved:
        return once, _latency(jacobian_block(shape, range(d), range(d)))
    total = _latency(jacobian_block(shape, range(m, d), range(m)))
    if not shape.parts[0].identity:
        total += _latency(jacobian_block(shape, range(m), range(m, d)))
    return once, total


def _latency(formula: Formula) -> int:
    """Operations of a formula weighted by their latency; equal expressions are counted once."""
    seen: set[str] = set()
    common, outputs = formula.trees
    return sum(_tree_latency(tree, seen) for tree in (*(t for _, t in common), *outputs))


def _tree_latency(tree: ast.AST, seen: set[str]) -> int:
    if isinstance(tree, ast.Constant | ast.Name | ast.Subscript):
        return 0
    text = ast.dump(tree)
    if text in seen:
        return 0
    seen.add(text)
    children: Iterable[ast.AST]
    if isinstance(tree, ast.BinOp):
        own, children = _LATENCY[type(tree.op)], (tree.left, tree.right)
    elif isinstance(tree, ast.UnaryOp):
        own, children = 0, (tree.operand,)
    else:
        assert isinstance(tree, ast.Call) and isinstance(tree.func, ast.Name)
        own, children = _CALL_LATENCY.get(tree.func.id, _OTHER_CALL), tree.args
    return own + sum(_tree_latency(child, seen) for child in children)
