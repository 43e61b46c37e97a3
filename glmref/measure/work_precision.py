"""Error against run time: one run of one method at one step size, as a record.

The error of the state is taken against the closed form where there is one, else against a stored
reference, else against a run of high order whose own error is estimated and recorded beside it.
Only what is asked is computed: no energy and no samples for it, no reference for the state.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from time import perf_counter
from typing import Any

import numpy as np

from ..catalogue.lookup import load
from ..compute.records import in_json
from ..engine.clocks import solved_form, without_clocks
from ..engine.outcome import Outcome, Solution
from ..engine.reference import stepper
from ..engine.solve import solve
from ..engine.starting_values import starting_values
from ..errors import UsageError
from ..method import Method
from ..problems.model import Problem
from ..problems.user_functions import FunctionFailed
from .longtime import energy_deviation
from .timing import Timing

#: Samples over which the largest energy error is taken.
SAMPLES = 64


@dataclass(frozen=True, eq=False)
class Reference:
    """The state at one time, and how far to trust it."""

    state: np.ndarray  #: (d,) in double precision.
    error: float  #: Bound or estimate of its relative error.
    kind: str  #: ``"exact"``, ``"stored"`` or ``"computed"``.


@dataclass(frozen=True)
class Work:
    """What one method did on one problem at one step size, and what that cost."""

    #: What was run; ``steps`` were completed.
    method: str
    problem: str
    h: float
    steps: int
    t_end: float
    outcome: str  #: How it ended, by name.
    message: str  #: One sentence where it did not complete.
    seconds: Timing  #: Wall-clock time of the steps alone, repeated.
    #: Right-hand-side evaluations of the steps; of a separable problem those of p'.
    evaluations: int
    velocity_evaluations: int  #: Evaluations of q' where counted apart.
    iterations: int  #: Rounds of the stage solver.
    start_evaluations: int  #: Evaluations of start and finish.
    start_seconds: float  #: Time of the start.
    build_seconds: float  #: Time to generate and compile, or to load, the kernel.
    kernel: str  #: What ran, in words.
    #: Euclidean error of the last state, relative; ``None`` where not asked.
    state_error: float | None = None
    #: What it was measured against, and how good that is.
    reference: str | None = None
    reference_error: float | None = None
    #: Largest relative error of H over the samples; ``None`` where not asked.
    energy_error: float | None = None
    notices: tuple[str, ...] = field(default=())  #: Sentences worth knowing.

    @property
    def completed(self) -> bool:
        """Whether every step was taken."""
        return self.outcome == str(Outcome.COMPLETED)

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types: no NaN, no infinity."""
        return in_json(self)


def measure(
    problem: Problem,
    method: Method,
    *,
    h: float,
    t_end: float | None = None,
    steps: int | None = None,
    ask: Collection[str] = ("state", "energy"),
    repeats: int = 5,
    budget: float = 10.0,
    engine: str = "compiled",
    start: Any = None,
    renew: int = 0,
) -> Work:
    """Run a method, time it, and measure its errors.

    Parameters
    ----------
    problem : Problem
        What to solve.
    method : Method
        With what.
    h : float
        Step size. t_end or steps: how far, one of them.
    ask : Collection[str]
        ``"state"`` for the error of the last state, ``"energy"`` for the largest of H.
    repeats : int
        Runs to time at the most.
    budget : float
        Seconds after which a run is cancelled, and after which none is repeated.
    engine, start, renew
        As in :func:`glmref.solve`; renewals are timed.

    Raises
    ------
    UsageError
        For a question the problem cannot answer, or arguments that do not fit.
    """
    _check_questions(problem, ask)
    solved = solved_form(problem, method)
    begin = _started(solved, method, h, start)
    options: dict[str, Any] = {"h": h, "engine": engine, "start": lambda *_: begin.values}
    if renew:  # each renewal needs the start itself
        options |= {"start": start, "renew": renew}
    options |= {"t_end": t_end} if steps is None else {"steps": steps}
    if "energy" in ask:
        end = float(problem.t_span[1] if t_end is None else t_end)
        whole = steps if steps is not None else round((end - float(problem.t_span[0])) / h)
        options["every"] = max(1, abs(whole) // SAMPLES)
    solution, timing = timed_runs(
        lambda deadline: solve(solved, method, cancel=deadline, **options), repeats, budget
    )
    solution = without_clocks(solution, problem)
    found = of_run(method, problem, h, solution)
    found |= {"seconds": timing, "start_seconds": begin.seconds}
    found["start_evaluations"] += begin.evaluations
    return Work(**found | (_errors(problem, solution, ask) if solution.completed else {}))


def of_run(method: Method, problem: Problem, h: float, solution: Solution) -> dict[str, Any]:
    """Return what the record of any run has, but for its times."""
    return {
        "method": method.name,
        "problem": problem.name,
        "h": float(h),
        "steps": solution.steps,
        "t_end": _last_time(problem, solution),
        "outcome": str(solution.outcome),
        "message": "" if solution.completed else solution.message,
        "evaluations": solution.evaluations,
        "velocity_evaluations": solution.velocity_evaluations,
        "iterations": solution.iterations,
        "start_evaluations": solution.start_evaluations + solution.finish_evaluations,
        "build_seconds": solution.build_seconds,
        "kernel": solution.kernel,
        "notices": solution.notices,
    }


def _check_questions(problem: Problem, ask: Collection[str]) -> None:
    """Refuse questions that are unknown, or that the problem cannot answer."""
    unknown = set(ask) - {"state", "energy"}
    if unknown:
        raise UsageError(f"`ask` knows 'state' and 'energy', got {sorted(unknown)[0]!r}")
    if "energy" in ask and problem.hamiltonian is None:
        raise UsageError(f"{problem.name} has no Hamiltonian; do not ask for the energy")


def _last_time(problem: Problem, solution: Solution) -> float:
    return float(solution.t[-1]) if len(solution.t) else float(problem.t_span[0])


def _errors(problem: Problem, solution: Solution, ask: Collection[str]) -> dict[str, Any]:
    """Return fields of :class:`Work` that answer the questions about a completed run."""
    record: dict[str, Any] = {}
    if "state" in ask:
        at = _last_time(problem, solution)
        record |= judged_state(problem, solution.y[-1], at, solution.notices)
    if "energy" in ask:
        record["energy_error"] = energy_error(problem, solution)
    return record


class Deadline:
    """Says when ``budget`` seconds have passed since it was first asked.

    A run asks for the first time after its first steps, so that neither compilation nor the start
    are charged. ``passed`` says whether the answer has been yes; a run that was cancelled without
    it was cancelled by the user.
    """

    def __init__(self, budget: float) -> None:
        self.budget = budget
        self.passed = False
        self._end: float | None = None

    def __call__(self) -> bool:
        """Return whether the time is over."""
        now = perf_counter()
        if self._end is None:
            self._end = now + self.budget
        self.passed = now >= self._end
        return self.passed


def check_interruption(solution: Solution, deadline: Deadline) -> None:
    """Raise KeyboardInterrupt where a run was cancelled and not by its deadline."""
    if solution.outcome is Outcome.CANCELLED and not deadline.passed:
        raise KeyboardInterrupt


@dataclass(frozen=True, eq=False)
class _Started:
    """Starting values, computed once for all repetitions, and what they cost."""

    values: np.ndarray
    evaluations: int
    seconds: float


def _started(problem: Problem, method: Any, h: float, start: Any) -> _Started:
    """Compute the starting values in double precision."""
    engine = stepper(method, problem)
    begun = perf_counter()
    with np.errstate(all="ignore"):
        y0 = np.array(problem.y0, dtype=float)
        found = starting_values(engine, start, t=float(problem.t_span[0]), y0=y0, h=float(h))
    return _Started(found.values, found.evaluations, perf_counter() - begun)


def timed_runs(
    run: Callable[[Deadline], Solution], repeats: int, budget: float
) -> tuple[Solution, Timing]:
    """Run up to ``repeats`` times, while the budget lasts: the first solution, and the times.

    The steps alone are timed. A run that does not complete is not repeated.
    """
    begun = perf_counter()
    seconds: list[float] = []
    first: Solution | None = None
    while first is None or (
        first.completed and len(seconds) < repeats and perf_counter() - begun < budget
    ):
        deadline = Deadline(budget)
        solution = run(deadline)
        check_interruption(solution, deadline)
        if first is None or solution.completed:
            seconds.append(solution.seconds)
        first = first or solution
    return first, Timing.of(seconds)


def energy_error(problem: Problem, solution: Solution) -> float:
    """Return the largest relative error of H over the samples of a solution."""
    y = np.real(np.asarray(solution.y)).astype(float)
    return float(np.max(energy_deviation(problem, np.vstack([problem.y0, y]))))


#: What a record says under ``reference`` where there is none; the sentence is in its ``notices``.
NO_REFERENCE = "cannot be computed"


class NoReference(UsageError):
    """There is no reference for the state at a time."""


def judged_state(problem: Problem, y: Any, t: float, notices: Iterable[str] = ()) -> dict[str, Any]:
    """Return what a record says of the error of a state (d,) at the time t.

    That is ``state_error``, ``reference`` and ``reference_error``. Where there is no reference the
    errors are ``None``, ``reference`` is :data:`NO_REFERENCE`, and ``notices``, besides those that
    the record has already, says why.
    """
    try:
        reference = reference_state(problem, t)
    except NoReference as error:
        nothing = {"state_error": None, "reference": NO_REFERENCE, "reference_error": None}
        return {**nothing, "notices": (*notices, str(error))}
    return {
        "state_error": state_error(np.asarray(y), reference),
        "reference": reference.kind,
        "reference_error": reference.error,
    }


def state_error(y: np.ndarray, reference: Reference) -> float:
    """Return the Euclidean error of a state relative to the reference's norm."""
    size = float(np.linalg.norm(reference.state)) or 1.0
    return float(np.linalg.norm(np.real(y).astype(float) - reference.state)) / size


def reference_state(problem: Problem, t: float) -> Reference:
    """Find the state at time t: in closed form, stored, or computed.

    Raises
    ------
    NoReference
        When the exact solution has no value at the time, or the computed one does not reach it.
    """
    if problem.exact is not None:
        elapsed, why = t - float(problem.t_span[0]), "it is not finite there"
        try:
            state = np.asarray(problem.solution(elapsed), dtype=float)
        except (ArithmeticError, ValueError, FunctionFailed) as error:
            state = np.array([math.nan])
            why = ": ".join(x for x in (type(error).__name__, str(error)) if x)
        if not np.isfinite(state).all():
            raise NoReference(
                f"the exact solution of {problem.name} has no value at t = {t:g} ({why}); choose "
                f"another t_end"
            )
        return Reference(state, 2.0**-52, "exact")
    for stored in problem.references:
        if abs(float(stored.t) - t) <= 1e-12 * max(1.0, abs(t)):
            return Reference(stored.rounded(), max(stored.agreement, 2.0**-52), "stored")
    return _computed(problem, t)


#: Relative difference of two runs at which a computed reference is as good as doubles make it, and
#: the largest number of steps spent on one.
_AGREE = 1e-13
_MOST_REFERENCE_STEPS = 2_000_000
_LONG = 1.0  # seconds of one run after which h is not halved again


@lru_cache(maxsize=32)
def _computed(problem: Problem, t: float) -> Reference:
    """Run Gauss-5 with halved step sizes until two runs agree; their difference is the bound.

    The finer run's truncation error is about 1/1023 of the difference; what remains is round-off,
    of which the difference is a sample. Halving ends where the difference is below :data:`_AGREE`,
    or shrinks no more, which is round-off or chaos.
    """
    elapsed = t - float(problem.t_span[0])
    scale = float(problem.scales.get("time", 1.0))
    steps = max(16, math.ceil(abs(elapsed) / scale * 20))
    message, best = "", math.inf
    before: np.ndarray | None = None
    found: np.ndarray | None = None
    while True:
        solution = solve(problem, load("gauss-5"), h=elapsed / steps, steps=steps)
        steps *= 2
        if not solution.completed:
            before, message = None, solution.message
        else:
            state = np.asarray(solution.y[-1], dtype=float)
            if before is not None:
                size = float(np.linalg.norm(state)) or 1.0
                difference = float(np.linalg.norm(state - before)) / size
                shrinks = difference < best
                if shrinks:
                    found, best = state, difference
                if best <= _AGREE or (not shrinks and best < 1e-6):
                    break
            before = state
        enough = found is not None or before is None
        if enough and (steps > _MOST_REFERENCE_STEPS or solution.seconds > _LONG):
            break
    if found is None:
        raise NoReference(
            f"no reference for {problem.name} at t = {t:g}: {message or 'two runs are missing'}; "
            f"ask for invariants instead"
        )
    # h is rounded: the end is another time by one part in 2^52, in all runs alike
    size = float(np.linalg.norm(found)) or 1.0
    speed = float(np.linalg.norm(np.asarray(problem.f(t, found), dtype=float))) / size
    shared = 2.0**-52 * (1 + abs(elapsed) * speed)
    return Reference(found, max(best, shared), "computed")
