"""Between a method on a problem and a compiled loop: its form, its arrays, chunks of steps."""

from __future__ import annotations

import time
from collections.abc import Callable, Hashable
from dataclasses import asdict, dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from ..problems.user_functions import FunctionFailed, NoValue, UserFunction, raised
from ..system.arguments import one_of
from . import kernel_cache, native
from .codegen import ARGUMENTS, KernelSource, kernel_source
from .forms import StepForm, explicit_after_velocity, same_point, shared_form
from .kept import ByIdentity, T, form_of_method, recalled
from .options import Options
from .outcome import KERNEL_OUTCOMES, Outcome
from .plan import check_arithmetic
from .shape import Shape, shape_of
from .solver_choice import choose_solver, with_band

SOLVERS = ("auto", "fixed-point", "newton")

#: Stages solved together from which on their operations are worth packing into vectors.
PACKED_STAGES = 3
_SAME_VALUE = 1e-9  # relative difference of a compiled function from the interpreted one

_FIRST_CHUNK = 256
_CHUNK_SECONDS = 0.05

_shapes, _sources = ByIdentity(), ByIdentity()


@dataclass
class State:
    """What a kernel works on, carried from one chunk of steps to the next."""

    work: np.ndarray  #: The work array.
    vectors: np.ndarray  #: (n, d), a view of its head, see :meth:`.forms.StepForm.names`.
    h: float  #: Step size.
    #: Evaluations, velocity evaluations, iterations, factorisations, steps, rows.
    tally: np.ndarray = field(default_factory=lambda: np.zeros(6, dtype=np.int64))
    #: What the right-hand side raised in the step that ended the run, or ``None``.
    trouble: Exception | None = None
    chunk: int = 0  #: Steps of the next call of the kernel, 0 where none was timed.

    def take_back(self, work: np.ndarray, tally: np.ndarray) -> None:
        """Return to copies made earlier."""
        self.work[:], self.tally[:] = work, tally

    @property
    def step(self) -> int:
        """Steps completed."""
        return int(self.tally[4])


@dataclass(frozen=True)
class Kernel:
    """A compiled method on a problem."""

    form: StepForm
    shape: Shape
    options: Options  #: What was generated.
    source: KernelSource  #: The generated module.
    built: kernel_cache.Built  #: The callable and where it came from.
    seconds: float  #: Time it took to generate and compile or load.

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
        """Return the state before the first step, see :meth:`.forms.StepForm.state`."""
        options, moves = self.options, self.shape.parts[0].identity
        found = self.form.state(values, slope, h, compensated=options.compensated, moves=moves)
        return self._holding(found, h)

    def _holding(self, vectors: np.ndarray, h: float) -> State:
        """Return a state with these vectors at the head of a work array."""
        work = native.aligned_zeros(self.source.work_size)
        head = work[: vectors.size].reshape(vectors.shape)
        head[:] = vectors
        return State(work, head, h)

    def resumed(self, other: State) -> State:
        """Return the state of another kernel of this form, to go on with its values and counts."""
        state = self._holding(other.vectors, other.h)
        memory = state.vectors[self.form.rows * (1 + self.options.compensated) :]
        memory[~np.isfinite(memory)] = 0.0
        state.tally = other.tally
        return state

    def values(self, state: State) -> np.ndarray:
        """Return the values in the method's basis, (r, d)."""
        return self.form.values(state.vectors, state.h, compensated=self.options.compensated)

    def advance(
        self, state: State, last: int, *, t0: float, h: float, every: int, out: np.ndarray,
        pause: Callable[[int], bool] = lambda _: False,
    ) -> tuple[Outcome, float]:  # fmt: skip
        """Step until ``last`` steps are done, in chunks of about 50 ms; return outcome and seconds.

        After ``every`` steps (0: never) a row is recorded into ``out``; ``pause`` is called between
        chunks with the steps done and cancels where it is true.
        """
        seconds, grows, flat = 0.0, True, out.reshape(-1)
        state.chunk = state.chunk or (8 if self.built.engine == "python" else _FIRST_CHUNK)
        while state.step < last:
            until = min(last, state.step + state.chunk)
            begin = time.perf_counter()
            mark = (state.step // every + 1) * every if every else -1
            code = self._called(state, t0, h, until, mark, every, flat)
            spent = time.perf_counter() - begin
            seconds += spent
            if code is None:
                # an exception came through: the same steps again in smaller pieces, up to the last
                # one before it
                state.chunk, grows = max(1, (until - state.step) // 2), False
            if code:
                return KERNEL_OUTCOMES[code], seconds
            if grows and until < last and spent < _CHUNK_SECONDS:
                state.chunk *= 8 if spent < _CHUNK_SECONDS / 8 else 2
            if state.step < last and pause(state.step):
                return Outcome.CANCELLED, seconds
        return Outcome.COMPLETED, seconds

    def _called(
        self, state: State, t0: float, h: float, until: int, mark: int, every: int, flat: np.ndarray
    ) -> int | None:
        """Call the kernel for the steps up to ``until``, and return its code.

        That of a right-hand side that failed in the step after the state; ``None`` where it failed
        after some steps, which are taken back.
        """
        kernel, first = self.built.kernel, state.step
        numbers = (t0, h, first, until, mark, every)
        row = int(state.tally[5])
        if self.built.engine == "native":
            return kernel(state.work, self.shape.par, *numbers, flat, row, state.tally)
        held = state.work.copy(), state.tally.copy()
        if abs(h) < np.finfo(float).tiny:  # a weight times h may be 0, and Python divides by it
            numbers = (t0, np.float64(h), first, until, mark, every)
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
        (docs/engine-measurements.md); ``"compensated"``: A,
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
    one_of("solver", solver, SOLVERS)
    wanted = form if form != "auto" else form_of(arithmetic)
    options = Options.of(arithmetic, history=history, interpreted=interpreted)
    # what a Python function computes may have changed with what it reads; an interpreted kernel
    # tells what went wrong in a list of its own
    fresh = interpreted or any(
        isinstance(getattr(problem, key), UserFunction) for key in ("f", "dq", "dp")
    )
    make = _prepared.__wrapped__ if fresh else _prepared
    kernel = make(method, problem, float(h), wanted, solver, options)
    return replace(kernel, seconds=time.perf_counter() - begin)


@lru_cache(maxsize=256)
def _prepared(
    method: Method, problem: Problem, h: float, form: str, solver: str,
    options: Options,
) -> Kernel:  # fmt: skip
    """Return the kernel for a method, problem and step size, cached for the next run with them."""
    begin = time.perf_counter()
    coefficients, shape = choose_form(method, problem, form)
    if len(coefficients.components) == 1:
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
    """Return why a user's function must not be compiled: its value at the start is another then.

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


def choose_form(method: Any, problem: Problem, form: str) -> tuple[StepForm, Shape]:
    """Return coefficients in the form asked for, and the shape of the problem.

    Raises
    ------
    UsageError
        For an additive method, or a pair with implicit stages on a problem that is not separable.
    """
    if method.additive:
        raise UsageError("kernels are not made for additive methods; use engine='reference'")
    joint, first = method.parts == 2 and method.shared and not problem.separable, False
    if method.parts == 2 and method.shared and not method.is_explicit:
        semi, name = explicit_after_velocity(method), method.name or "the pair"
        first = semi and problem.velocity is not None
        if joint and not first and semi:
            raise UsageError(
                f"{name} is for separable and semi-separable systems, q' = f(p), p' = g(q, p); "
                f"{problem.name} does not give q' as a function of p; take multistep-general-8 or "
                f"gauss-4, or give `dq` in addition to `f` where it is one"
            )
        if joint and not first:
            raise UsageError(
                f"{problem.name} is not separable, where {name} has implicit stages, for which no "
                f"kernel is made; use engine='reference'"
            )
        joint = first = joint or (first and same_point(method))
    split = not joint if method.parts == 2 else None
    # the shape is that of the functions, whatever the initial value
    given = (problem.f, problem.dq, problem.dp, problem.force, problem.jacobian)
    about = (problem.dimension, split, first)
    shape = _shapes(given, about, lambda: shape_of(problem, split=split, first=first))
    return (shared_form(method) if joint else form_of_method(method, form)), shape


def _assembled(
    form: StepForm, shape: Shape, options: Options, begin: float, notice: str = ""
) -> Kernel:
    source = _source_of(form, shape, options)
    functions = {part.role: part.function for part in shape.parts if part.function is not None}
    if options.interpreted:
        built = kernel_cache.interpret(source.text, functions, notice)
    else:
        pack = source.side_by_side >= PACKED_STAGES or source.target == "array"
        tuning = native.Tuning(pack=pack, fuse=options.fused)
        built = kernel_cache.build(source.text, ARGUMENTS, functions, tuning)
        if built.engine == "python":
            options = replace(options, interpreted=True)
            source = _source_of(form, shape, options)
            built = kernel_cache.interpret(source.text, functions, built.notice)
    return Kernel(form, shape, options, source, built, time.perf_counter() - begin)


def _source_of(form: StepForm, shape: Shape, options: Options) -> KernelSource:
    given = (form, shape, options)
    return kept_source(KernelSource, *given, lambda: kernel_source(*given))


def kept_source(
    kind: type[T], form: StepForm, shape: Shape, about: Hashable, write: Callable[[], T]
) -> T:
    """Return a generated module of a kind, kept in the process and on disk.

    ``about`` is what it depends on besides form and shape.
    """

    def made() -> T:
        if shape.opaque:
            return write()
        key = repr((form, replace(shape, values=shape.values.tolist()), about))
        read: Callable[[Any], T] = lambda fields: kind(**fields)  # noqa: E731
        return recalled("source", f"{kind.__name__} {key}", write, read, asdict)  # type: ignore[call-overload]

    return _sources((form, shape), (kind, about), made)


def with_newton(kernel: Kernel) -> Kernel:
    """Return the same kernel with Newton in place of the fixed point."""
    options = replace(kernel.options, solver="newton")
    return _assembled(kernel.form, with_band(kernel.shape), options, time.perf_counter())
