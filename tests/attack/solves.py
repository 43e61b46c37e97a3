"""Random method x problem x step size x state x engine, at the edge of what numbers can be.

Methods are shipped ones, in random bases of their values, and drawn ones, most of them nonsense.

Each case must end in a named outcome or in a refusal of one sentence, within a time limit. A run
that says ``completed`` has taken all steps, ends at the time asked for, and holds finite numbers
only; one that ended before keeps finite numbers too. Functions that cannot be trusted are refused
or noticed, and functions that only compute in place are stepped as their well-behaved twins are.
"""

import json
import math
import random
import signal
import time
import traceback
import warnings
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from glmref import (
    GLM,
    AdditiveGLM,
    PartitionedGLM,
    Problem,
    UsageError,
    load,
    names,
    problem,
    solve,
)
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.outcome import Outcome, Solution
from glmref.system.arguments import shown
from tests.build import in_place, sharing

from .files import _ring, _TooLong
from .odd import ODD
from .tally import Tally

#: Seconds of processor time for one case, and of the clock: a machine may be busy with others.
LIMIT, PATIENCE = 60, 900

#: Cases of the attack in full.
COUNT = 2000
ENGINES = ("compiled", "interpreted", "reference")
SIZES = (
    *(5e-324, -5e-324, 1e-310, 1e-300, 1e-160, 1e-30, 1e-16, 1e-9, 1e-3, -1e-3, 0.01, 0.1, -0.1, 1),
    *(7.0, 1e3, 1e10, 1e100, 1e154, 1e200, 1e300, -1e300, 1.7e308, -1.7e308),
)
STATES = (
    *(0.0, -0.0, 5e-324, 1e-310, 1e-300, 1e-160, 1e-30, 1e-8, 1.0, -1.0, 0.3, 1e8, 1e30, 1e100),
    *(1e154, 1e160, 1e299, 9.9e299, 1e300, 1e305, 1e308, -1e308, 1.7976931348623157e308),
)
PROBLEMS = (
    *("kepler", "pendulum", "henon-heiles", "rigid-body", "lotka-volterra", "van-der-pol", "toda"),
    *("double-pendulum", "arenstorf", "fput", "oregonator", "robertson", "kaps", "blow-up"),
    *("fault-jacobian", "fault-jacobian-nan", "fault-nan", "fault-raises", "point-vortices"),
)
#: Expressions that overflow, underflow, divide by zero or have no value.
FORMULAS = (
    (("y[0]*y[0]",), 1),
    (("1/y[0]",), 1),
    (("sqrt(y[0])",), 1),
    (("log(y[0])",), 1),
    (("exp(y[0])",), 1),
    (("-1e308*y[0]",), 1),
    (("1e-308*y[0] + 0*t",), 1),
    (("0*y[0]", "0*y[1]"), 2),
    (("y[1]", "-y[0]"), 2),
    (("y[1]", "-y[0]*y[0]*y[0]"), 2),
    (("y[1]/y[0]", "1/(y[0] - y[1])"), 2),
    (("t*y[1]", "-t*y[0]"), 2),
)
FORCES = (("-q[0]",), ("1/q[0]",), ("-q[0]*q[0]*q[0]",), ("1e300*q[0]",), ("0*q[0]",))


# --- functions of users -------------------------------------------------------------------------


def _good(t: float, y: np.ndarray) -> np.ndarray:
    return np.array([y[1], -y[0]])


def _spoils(t: float, y: np.ndarray) -> np.ndarray:
    out = np.array([y[1], -y[0]])
    y[:] = 1e300
    return out


def _raises(error: BaseException, after: float) -> Callable[..., Any]:
    def f(t: float, y: np.ndarray) -> Any:
        if abs(t) >= after:
            raise error
        return [y[1], -y[0]]

    return f


def _returns(result: Callable[[np.ndarray], Any], after: float) -> Callable[..., Any]:
    def f(t: float, y: np.ndarray) -> Any:
        return result(y) if abs(t) >= after else [y[1], -y[0]]

    return f


class _NoArray:
    def __array__(self, dtype: Any = None, copy: Any = None) -> np.ndarray:
        raise RuntimeError("no array")


def _calls() -> Callable[..., Any]:
    count = [0]

    def f(t: float, y: np.ndarray) -> Any:
        count[0] += 1
        return [y[1], -y[0] * (1 + 0.01 * count[0])]

    return f


def _clock() -> Callable[..., Any]:
    return lambda t, y: [y[1], -y[0] * (1 + time.perf_counter_ns())]


def _chance() -> Callable[..., Any]:
    source = random.Random(1)
    return lambda t, y: [y[1] + source.random(), -y[0]]


def _solves(t: float, y: np.ndarray) -> Any:
    """Solve another problem within, as a right-hand side that finds an equilibrium does."""
    solve(Problem(f=("-y[0]",), y0=(1.0,)), "rk4", h=0.5, steps=1, engine="reference")
    return [y[1], -y[0]]


#: What each is: right ("good"), to be noticed or refused ("doubtful"), or to be named ("bad").
FUNCTIONS: dict[str, tuple[Callable[[], Callable[..., Any]], str]] = {
    "in place": (lambda: in_place, "good"),
    "spoils its argument": (lambda: _spoils, "good"),
    "one buffer": (lambda: sharing(np.zeros(2)), "good"),
    "a list": (lambda: lambda t, y: [y[1], -y[0]], "good"),
    "a tuple of 0-d arrays": (lambda: lambda t, y: (np.array(y[1]), np.array(-y[0])), "good"),
    "float32": (lambda: lambda t, y: _good(t, y).astype(np.float32), "doubtful"),
    "float16": (lambda: lambda t, y: _good(t, y).astype(np.float16), "doubtful"),
    "int64": (lambda: lambda t, y: _good(t, y).astype(np.int64), "doubtful"),
    "solves within": (lambda: _solves, "good"),
    "random": (_chance, "doubtful"),
    "number of calls": (_calls, "doubtful"),
    "clock": (_clock, "doubtful"),
}
for _after in (0.0, 0.25):
    _when = "at once" if _after == 0 else "later"
    for _error in (RuntimeError("no\nmore"), KeyError("rate"), ValueError("domain"), OSError(5),
                   GeneratorExit(), SystemExit(0), StopIteration(), UsageError("of the package\nx"),
                   UnicodeDecodeError("utf-8", b"\xff", 0, 1, "\udcff")):  # fmt: skip
        _name = f"{type(_error).__name__} {_when}"
        FUNCTIONS[_name] = (lambda e=_error, a=_after: _raises(e, a), "bad")
    for _name, _result in {
        "NaN": lambda y: [math.nan, 0.0],
        "infinity": lambda y: [math.inf, 0.0],
        "None": lambda y: None,
        "a scalar": lambda y: y[0],
        "a generator": lambda y: (x for x in y),
        "another shape": lambda y: y[:1],
        "complex": lambda y: [1j, 0.0],
        "words": lambda y: ["a", "b"],
        "a dictionary": lambda y: {0: 1.0},
        "a map": lambda y: map(float, y),
        "bytes": lambda y: b"12",
        "no array": lambda y: _NoArray(),
        "times": lambda y: np.array([1, 2], dtype="m8[s]"),
    }.items():
        FUNCTIONS[f"{_name} {_when}"] = (lambda r=_result, a=_after: _returns(r, a), "bad")


def _nothing(t: float, y: np.ndarray) -> np.ndarray:
    return 0.0 * y


def _negated(q: np.ndarray) -> np.ndarray:
    return -q


def _negates(q: np.ndarray) -> np.ndarray:
    q *= -1
    return q


def _empties(p: np.ndarray) -> np.ndarray:
    out = p.copy()
    p[:] = 1e300
    return out


def _fails(q: np.ndarray) -> np.ndarray:
    if q[0] < 0.9:
        raise RuntimeError("no force there")
    return -q


def _shrinks(q: np.ndarray) -> np.ndarray:
    return -q if q[0] > 0.9 else -q[:0]


def _chance_force() -> Callable[..., Any]:
    source = random.Random(1)
    return lambda q: -q * source.random()


#: Parts dq and dp, or a force, of q'' = -q; as in :data:`FUNCTIONS`.
PARTS: dict[str, tuple[Callable[[], dict[str, Any]], str]] = {
    "dp in place": (lambda: {"dq": _empties, "dp": _negates}, "good"),
    "force in place": (lambda: {"force": _negates}, "good"),
    "force float32": (lambda: {"force": lambda q: (-q).astype(np.float32)}, "doubtful"),
    "dq float32": (lambda: {"dq": lambda p: p.astype("f4"), "dp": _negated}, "doubtful"),
    "random dp": (lambda: {"dq": lambda p: p, "dp": _chance_force()}, "doubtful"),
    "random force": (lambda: {"force": _chance_force()}, "doubtful"),
    "dp raises": (lambda: {"dq": lambda p: p, "dp": _fails}, "bad"),
    "force of another shape": (lambda: {"force": _shrinks}, "bad"),
    "dq None": (lambda: {"dq": lambda p: None, "dp": _negated}, "bad"),
}


# --- cases --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Case:
    """One call of :func:`glmref.solve`."""

    #: ``"problem"``, ``"formula"``, ``"force"``, ``"function"``, ``"parts"`` or ``"terms"``.
    kind: str
    what: Any  #: Its name, or number in the lists above.
    state: tuple[float, ...] | None  #: Initial value, where it is not the problem's own.
    t0: float  #: Initial time.
    method: str  #: Name of a method, see :func:`_loaded`.
    #: What :func:`glmref.solve` is called with besides.
    arguments: dict[str, Any] = field(default_factory=dict)
    lanes: int = 0  #: How many initial values an ensemble has; 0 for a single run.
    #: Number of the basis of the values that a method carries; 0 for that of its file.
    basis: int = 0

    def problem(self) -> Problem:
        """The problem of the case."""
        if self.kind == "problem":
            made = problem(self.what)
            if self.state is None:
                return made
            return replace(made, y0=self.state, initial=None)
        options = {"y0": self.state, "t_span": (self.t0, self.t0 + 1.0), "name": str(self.what)}
        if self.kind == "formula":
            return Problem(f=FORMULAS[self.what][0], **options)
        if self.kind == "force":
            return Problem(force=FORCES[self.what], **options)
        if self.kind == "parts":
            return Problem(**PARTS[self.what][0](), **options)
        if self.kind == "terms":
            others = (_nothing,) * (_parts(self.method) - 1)
            return Problem(terms=(FUNCTIONS[self.what][0](), *others), **options)
        return Problem(f=FUNCTIONS[self.what][0](), **options)

    def __str__(self) -> str:
        parts = [
            *([f"{self.lanes} lanes"] if self.lanes else []),
            *([f"basis {self.basis}"] if self.basis else []), self.kind, str(self.what),
            f"y0 = {self.state}", f"t0 = {self.t0!r}", self.method,
        ]  # fmt: skip
        return ", ".join([*parts, json.dumps(self.arguments, default=shown)])


#: Entries of methods that are drawn, most of which are nonsense.
ENTRIES = ("0", "0", "1", "-1", "1/2", "1/4", "-1/3", "2", "1/1000000", "-1000000", "sqrt(2)/2")


@lru_cache(maxsize=256)
def _loaded(method: str) -> Any:
    """Return a method of the catalogue, or the one that a name such as ``random 17`` stands for."""
    if not method.startswith("random "):
        return load(method)
    draw = random.Random(method)
    s, r = draw.randint(1, 3), draw.randint(1, 3)

    def matrix(rows: int, columns: int, reach: int) -> list[list[str]]:
        return [[draw.choice(ENTRIES) if j < i + reach else "0" for j in range(columns)]
                for i in range(rows)]  # fmt: skip

    def blocks() -> list[list[list[str]]]:
        return [matrix(s, s, draw.choice((0, 1, s))), matrix(s, r, r), matrix(r, s, s),
                matrix(r, r, r)]  # fmt: skip

    if draw.random() < 0.3:
        return PartitionedGLM(*blocks(), *blocks(), name=method)
    return GLM(*blocks(), name=method)


@lru_cache
def _methods() -> tuple[str, ...]:
    return tuple(sorted(names()))


def _parts(method: str) -> int:
    return len(_loaded(method).components)


@lru_cache(maxsize=256)
def made(method: str, basis: int) -> Any:
    """Return a method of the catalogue, or the equivalent one that carries ``T y``."""
    found = _loaded(method)
    if not basis:
        return found
    draw = random.Random(basis)
    entries = ("0", "0", "1", "-1", "1/2", "-1/3", "2", "3/4")
    T = [
        [draw.choice(entries[2:]) if i == j else draw.choice(entries) if j > i else "0"
         for j in range(found.carried)]
        for i in range(found.carried)
    ]  # fmt: skip
    draw.shuffle(T)
    return found.transform(T)


def cases(count: int, seed: int) -> Iterator[Case]:
    """Draw cases; the same for the same seed."""
    draw = random.Random(seed)
    for _ in range(count):
        case = _case(draw)
        moved = isinstance(_loaded(case.method), GLM) and _loaded(case.method).carried > 1
        if moved and draw.random() < 0.4:
            case = replace(case, basis=draw.randint(1, 10**6))
        yield case


def _case(draw: random.Random) -> Case:
    method = draw.choice(_methods()) if draw.random() < 0.7 else draw.choice(
        ("rk4", "gauss-2", "gauss-3", "tr-bdf2", "stormer-verlet", "g6245", "s4-symmetric")
    )  # fmt: skip
    if draw.random() < 0.15:
        method = f"random {draw.randint(1, 10**6)}"
    if isinstance(_loaded(method), AdditiveGLM) and draw.random() < 0.9:
        kind = "terms"
    elif isinstance(_loaded(method), PartitionedGLM):
        kind = draw.choice(("problem", "force", "force", "parts", "parts"))
    else:
        kind = draw.choice(
            ("problem", "formula", "formula", "force", "function", "function", "parts")
        )
    t0 = draw.choice((0.0,) * 12 + (1.0, -1e10, 1e300, 5e-324))
    if kind == "problem":
        what: Any = draw.choice(PROBLEMS)
        d, own = problem(what).dimension, draw.random() < 0.4
        state = None if own else _state(draw, d)
        t0 = float(problem(what).t_span[0])
    elif kind == "formula":
        what = draw.randrange(len(FORMULAS))
        state = _state(draw, FORMULAS[what][1])
    elif kind == "force":
        what, state = draw.randrange(len(FORCES)), _state(draw, 2)
    else:
        known = PARTS if kind == "parts" else FUNCTIONS
        what, state, t0 = draw.choice(list(known)), (1.0, 0.0), 0.0
    plain = kind in ("function", "parts", "terms")
    if draw.random() < (0.15 if plain else 0.1):
        given = {
            "h": draw.choice(SIZES),
            "steps": draw.choice((0, 1, 7, 60)),
            "every": draw.choice((0, 1, 3)),
        }
        if plain:
            given |= {"h": draw.choice((0.01, 0.1)), "steps": 60}
        return Case(kind, what, state, t0, method, given, draw.choice((1, 2, 3, 9)))
    return Case(kind, what, state, t0, method, _arguments(draw, t0, plain, method[:7] == "random "))


def _state(draw: random.Random, d: int) -> tuple[float, ...]:
    if draw.random() < 0.5:
        return (draw.choice(STATES),) * d
    return tuple(draw.choice(STATES) for _ in range(d))


def _arguments(draw: random.Random, t0: float, plain: bool, drawn: bool) -> dict[str, Any]:
    """Step size, length, rows, engine and the rest."""
    if draw.random() < 0.03:
        return {"h": draw.choice((math.inf, math.nan, 0, "1", None, 10**400)), "steps": 3}
    h = draw.choice((0.01, 0.1)) if plain and draw.random() < 0.8 else draw.choice(SIZES)
    given: dict[str, Any] = {"h": h, "engine": draw.choice(ENGINES)}
    if plain and given["engine"] == "compiled" and draw.random() < 0.7:
        given["engine"] = "interpreted"  # numba takes seconds for each
    if drawn and given["engine"] == "compiled":
        given["engine"] = "interpreted"  # nobody needs its kernel again
    if drawn and draw.random() < 0.7:
        given["start"] = "zero"  # they have none of their own
    how = draw.random()
    if how < 0.7:
        given["steps"] = draw.choice((0, 1, 2, 7, 60)) if not plain else 60
    elif how < 0.85:
        given["t_end"] = draw.choice(
            (t0 + 40 * h, t0 + 3.3 * h, t0 - h, t0, 1e308, math.nan, math.inf, "soon", None)
        )
        given["step_limit"] = 100
    elif how < 0.95:
        given["times"] = draw.choice((
            [t0 + 2 * h, t0 + 5 * h], [t0 + 5 * h, t0 + 2 * h], [t0 + h, t0 + h], [], [math.nan],
            [t0 - h], [t0 + 0.5 * h], ["soon"], 3.0, [t0, t0 + h],
        ))  # fmt: skip
    else:
        given["steps"] = draw.choice((-1, 2.5, True, 10**30, 2**63, None))
        given["step_limit"] = 50
    if "times" not in given:
        given["every"] = draw.choice((0, 0, 1, 3, 1000, 10**25))
    if draw.random() < 0.3:
        given["history"] = True
    if draw.random() < 0.3 and given["engine"] != "reference":
        given["solver"] = draw.choice(("fixed-point", "newton"))
        given["arithmetic"] = draw.choice(("strict", "fused", "compensated", "naive"))
    if draw.random() < 0.3:
        given["start"] = draw.choice(("zero", "enhanced"))
    if draw.random() < 0.1:
        given["renew"] = draw.choice((1, 2, 7, 10**20, -1, True, "x"))
    if given["engine"] == "reference" and draw.random() < 0.3:
        given["digits"] = draw.choice((1, 3, 30, 30, 0))
    if draw.random() < 0.04:  # one that is refused in every run
        given[draw.choice([*given, "form", "cancel", "progress", "digits"])] = draw.choice(
            [*ODD.values()]
        )()
    return given


# --- judgement ----------------------------------------------------------------------------------


@contextmanager
def _limited(seconds: float) -> Iterator[None]:
    timers = ((signal.SIGPROF, signal.ITIMER_PROF, seconds),
              (signal.SIGALRM, signal.ITIMER_REAL, PATIENCE))  # fmt: skip
    before = [signal.signal(number, _ring) for number, _, _ in timers]
    for _, timer, length in timers:
        signal.setitimer(timer, length)
    try:
        yield
    finally:
        for (number, timer, _), handler in zip(timers, before, strict=True):
            signal.setitimer(timer, 0)
            signal.signal(number, handler)


def _one_line(text: str) -> bool:
    return bool(text.strip()) and text.isprintable() and len(text) < 1000


def violations(case: Case) -> tuple[str, list[str]]:
    """Run a case; the name of its end and what it violates."""
    try:
        with _limited(LIMIT), warnings.catch_warnings():
            warnings.simplefilter("error")
            if case.lanes:
                return _ensemble(case)
            found = solve(case.problem(), made(case.method, case.basis), **case.arguments)
    except UsageError as error:
        said = str(error)
        return "refused", [] if _one_line(said) else [f"a refusal that is no line: {said[:500]!r}"]
    except _TooLong:
        return "too long", [f"took more than {LIMIT} s"]
    except Exception as error:
        where = traceback.extract_tb(error.__traceback__)[-1]
        last = f"{where.filename.rpartition('/')[2]}:{where.lineno}"
        return "exception", [f"{type(error).__name__} at {last}: {error}"]
    wrong = list(_judged(case, found))
    if case.kind in ("function", "parts", "terms") and not wrong:
        wrong = list(_judged_function(case, found))
    return str(found.outcome), wrong


def _ensemble(case: Case) -> tuple[str, list[str]]:
    """Run an ensemble: finite numbers and named outcomes; notices as a single run has them."""
    problem, method = case.problem(), made(case.method, case.basis)
    first = np.array(problem.y0, dtype=float)
    initial = np.array([first * (1 - k / 64) for k in range(case.lanes)])
    found = solve_ensemble(problem, method, initial, threads=2, **case.arguments)
    wrong = []
    if not (_finite(found.y) and _finite(found.t)):
        wrong.append(f"rows of the ensemble are not finite, outcomes {set(found.outcomes)}")
    steps = case.arguments["steps"]
    for outcome, taken in zip(found.outcomes, found.steps, strict=True):
        if outcome is Outcome.COMPLETED and taken != steps:
            wrong.append(f"completed after {taken} of {steps} steps")
    if case.kind in ("function", "parts", "terms"):
        sort = (PARTS if case.kind == "parts" else FUNCTIONS)[case.what][1]
        if sort == "doubtful" and steps and not _doubted(found.notices):
            wrong.append("an ensemble without a notice")
        done = [k for k, x in enumerate(found.outcomes) if x is Outcome.COMPLETED]
        if sort == "bad" and case.kind != "parts" and found.t[-1] > 0.26 and done:
            wrong.append("completed although the function has no value there")
    return f"ensemble: {'+'.join(sorted({str(x) for x in found.outcomes}))}", wrong


def _doubted(notices: Iterable[str]) -> bool:
    """Whether a notice names a function."""
    return any(x.startswith("`") for x in notices)


def _finite(array: np.ndarray) -> bool:
    if array.dtype == object:  # numbers of mpmath
        return all(x == x and abs(x) != math.inf for x in array.ravel())
    return bool(np.isfinite(array).all())


def _judged(case: Case, found: Solution) -> Iterator[str]:
    if not _one_line(found.message):
        yield f"message {found.message!r}"
    for name in ("t", "y", "values", "history"):
        array = getattr(found, name)
        if array is not None and not _finite(array):
            yield f"`{name}` is not finite, outcome {found.outcome}"
    if len(found.t) != len(found.y):
        yield f"{len(found.t)} times and {len(found.y)} rows"
    if found.outcome is not Outcome.COMPLETED:
        return
    h, steps = float(case.arguments["h"]), case.arguments.get("steps")
    if steps is not None and found.steps != steps:
        yield f"completed after {found.steps} of {steps} steps"
    end = case.arguments.get("t_end")
    if end is None:
        end = case.problem().t_span[1]
    if case.arguments.get("times"):
        end = case.arguments["times"][-1]
    if steps is not None:
        end = case.t0 + steps * h
    digits = case.arguments.get("digits") or 16
    unit = 4e-16 if digits >= 16 else 10.0 ** (1 - digits)  # by which a time is rounded
    if not abs(found.t[-1] - end) <= 1e-9 * abs(end - case.t0) + unit * abs(end):
        yield f"completed at t = {found.t[-1]!r} instead of {end!r}"


@lru_cache
def _twin(kind: str, method: str, basis: int, arguments: str) -> Solution:
    given = json.loads(arguments)
    parts: dict[str, Any] = {"f": _good} if kind == "function" else {"force": _negated}
    if kind == "terms":
        parts = {"terms": (_good, *(_nothing,) * (_parts(method) - 1))}
    return solve(Problem(**parts, y0=(1.0, 0.0), t_span=(0.0, 1.0)), made(method, basis), **given)


def _judged_function(case: Case, found: Solution) -> Iterator[str]:
    sort = (PARTS if case.kind == "parts" else FUNCTIONS)[case.what][1]
    if sort == "good":
        given = {**case.arguments, "engine": "interpreted"}
        if case.arguments.get("engine") == "reference":
            given["engine"] = "reference"
        other = _twin(case.kind, case.method, case.basis, json.dumps(given))
        if found.outcome is not other.outcome:
            yield f"{found.outcome} where the same function without side effects is {other.outcome}"
        elif found.completed:
            scale = max(1.0, float(np.abs(other.values).max()))
            # compiled Newton may take one round more: round-off, per step
            if not np.abs(found.values - other.values).max() <= 1e-12 * scale:
                yield "another result than the same function without side effects"
    elif found.steps and not _doubted(found.notices) and sort == "doubtful":
        yield f"{found.outcome} without a notice"
    elif found.completed and sort == "bad" and _beyond(case, found):
        yield "completed although the function has no value there"


def _beyond(case: Case, found: Solution) -> bool:
    """Whether a run has certainly been where its function has no value."""
    if case.kind != "parts":
        return abs(found.t[-1]) > 0.26
    # a method that is wrong on purpose may never come where the force fails
    return case.what == "dq None" or float(found.y[:, 0].min()) < 0.8


def attack(count: int, seed: int, say: Callable[[str], None] = lambda _: None) -> Tally:
    """Run cases and count what comes of them."""
    judged = ((case, *violations(case)) for case in cases(count, seed))
    return Tally.of(((end, str(case), wrong) for case, end, wrong in judged), say)
