"""Whether the functions of a user's problem can be trusted: a few calls before and after a run.

A right-hand side must depend on t and y alone and give all the digits of a double. Two calls at
the start, one more there and two at the end of the run show what does not: random numbers, a
counter, a clock, 32-bit results. What is wrong at the start is refused; what comes to light later,
or costs accuracy only, becomes a notice of the solution. Computing in place, or handing out one
array every time, needs no check, as :class:`..problems.user_functions.UserFunction` copies; a loop
body that writes into its argument is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..errors import UsageError
from ..problems.formula import Formula
from ..problems.loops import Loops
from ..problems.model import Problem
from ..problems.user_functions import FunctionFailed, NoValue, UserFunction
from .arithmetic import size
from .reference import Stepper

#: Calls of each function of a user that a run adds to those of its steps.
CALLS = 5

_ROUND_OFF = 64  # units of the last place by which sums in another order may differ
_PARTS_AGREE = 1e-6  # relative difference of f and (dq, dp) that is no round-off
_LOOPS_UP_TO = 1000  # dimension up to which a loop body is tried out in the interpreter


@dataclass
class _Seen:
    """One function and what it gave at the start."""

    function: UserFunction
    first: Any
    point: tuple[Any, ...]


@dataclass
class Inspection:
    """What the calls at the start showed."""

    engine: Stepper
    notices: list[str] = field(default_factory=list)  #: Sentences for the solution.
    seen: list[_Seen] = field(default_factory=list)
    interrupted: bool = False  #: Whether Ctrl-C came during the calls after the run.

    def afterwards(self, t: Any, y: np.ndarray) -> list[str]:
        """Call every function again at the start, and twice at the end (t, y) of the run.

        Returns all notices, those of the start included.
        """
        found = list(self.notices)
        try:
            for one in self.seen:
                found += [x for x in self._again(one, t, y) if x not in found]
        except KeyboardInterrupt:  # the run itself is over, and its solution is good
            self.interrupted = True
            found.append("the calls of the functions after the run were interrupted")
        return found

    def _again(self, one: _Seen, t: Any, y: np.ndarray) -> Iterator[str]:
        function, at_end = one.function, _point(one.function, self.engine, t, y)
        again = _value(function, one.point)
        try:
            last, kinds = function.examined(*at_end)
        except FunctionFailed:
            last, kinds = None, set()
        yield from _lost(function, kinds)
        pairs = [(one.first, again), (last, _value(function, at_end))]
        for (a, b), where in zip(pairs, ("start", "end"), strict=True):
            if _differ(a, b) is not None:
                yield (
                    f"`{function.name}` gives another value at the {where} of the run when it is "
                    f"called again there: it must depend on t and y alone; do not trust this run"
                )
                return


def inspected(engine: Stepper, t0: Any, y0: np.ndarray) -> Inspection:
    """Call the user's functions of a problem at its start, in the arithmetic of the run.

    Raises
    ------
    FunctionFailed
        When one raises (anything but an arithmetic or value error: the method may never
        evaluate there) or returns what is not real numbers of its shape.
    UsageError
        When one gives different values at the same point, or f and its parts disagree.
    """
    result = Inspection(engine)
    problem = engine.problem
    for function in _functions(engine):
        point = _point(function, engine, t0, y0)
        try:
            first, kinds = function.examined(*point)
        except NoValue:
            result.seen.append(_Seen(function, None, point))
            continue
        second = _value(function, point)
        apart = _differ(first, second)
        if apart is not None and apart > _ROUND_OFF * engine.arithmetic.epsilon * size(first):
            raise UsageError(
                f"`{function.name}` gives two different values at the same point, {_few(first)} "
                f"and then {_few(second)}; it must depend on t and y alone"
            )
        if apart is not None:
            result.notices.append(
                f"`{function.name}` gives values that differ in round-off at the same point; runs "
                f"are not reproducible bit for bit"
            )
        result.notices += _lost(function, kinds)
        result.seen.append(_Seen(function, first, point))
    _writes_into_argument(problem, t0, y0)
    _parts_agree(engine, t0, y0)
    return result


def _functions(engine: Stepper) -> list[UserFunction]:
    """Return the user's functions that a run can call, each once."""
    problem, found = engine.problem, []
    pair = engine.method.parts == 2
    parts = [problem.dq, problem.dp]
    if not (problem.separable and pair):
        parts = [problem.f, *parts, *problem.terms]
    for function in parts:
        if isinstance(function, UserFunction) and function not in found:
            found.append(function)
    return found


def _point(function: UserFunction, engine: Stepper, t: Any, y: np.ndarray) -> tuple[Any, ...]:
    """Return arguments of f, of a term, of dq(p) or of dp(q) at a point, as copies."""
    m = len(y) // 2
    if function.name in ("dq", "dp", "force"):
        return (np.array(y[m:] if function.name == "dq" else y[:m]),)
    return t, np.array(y)


def _value(function: UserFunction, point: tuple[Any, ...]) -> Any:
    """Return the value at a point, ``None`` where there is none."""
    try:
        return function(*point)
    except FunctionFailed:
        return None


def _differ(a: Any, b: Any) -> Any:
    """Return the largest difference of two values; ``None`` where they are the same."""
    if a is None or b is None:
        return None if a is b else np.inf
    same = [x == y or (x != x and y != y) for x, y in zip(a, b, strict=True)]
    if all(same):
        return None
    # infinities of two signs differ by more than round-off, and so does a number from none
    apart = [abs(x - y) for x, y, equal in zip(a, b, same, strict=True) if not equal]
    return max(x if x == x else np.inf for x in apart)


def _few(values: Any) -> str:
    shown = ", ".join(f"{complex(x) if np.iscomplexobj(x) else float(x):.17g}" for x in values[:2])
    return f"({shown}{', ...' if len(values) > 2 else ''})"


def _lost(function: UserFunction, kinds: set[np.dtype[Any]]) -> list[str]:
    """Return what the types of a result cost."""
    short = [k for k in kinds if k.kind in "fc" and k.itemsize // (2 if k.kind == "c" else 1) < 8]
    if short:
        digits = 3 if any(k.name == "float16" for k in short) else 7
        says = f"returns {short[0]} numbers: the results have about {digits} digits"
        return [f"`{function.name}` {says}; let it return float64"]
    whole = [k for k in kinds if k.kind in "iub"]
    if whole:
        says = f"returns an array of {whole[0]}: fractions are lost where the values have any"
        return [f"`{function.name}` {says}; let it return float64"]
    return []


def _writes_into_argument(problem: Problem, t0: Any, y0: np.ndarray) -> None:
    """Refuse a loop body of the user that changes the state it is given."""
    m = len(y0) // 2
    for name, point in (("f", (t0, y0)), ("dq", (y0[m:],)), ("dp", (y0[:m],))):
        function = getattr(problem, name)
        if not isinstance(function, Loops) or function.context is not None:
            continue
        own = (function.body.__module__ or "").partition(".")[0] == __name__.partition(".")[0]
        if own or len(y0) > _LOOPS_UP_TO:
            continue
        *times, state = point
        given, out = np.array(state), np.zeros(function.shape)
        function._function(*times, given, function.params, out)
        if not np.array_equal(given, state, equal_nan=True):
            raise UsageError(
                f"the loop body of `{name}` writes into its argument; write `out` only"
            )


def _parts_agree(engine: Stepper, t0: Any, y0: np.ndarray) -> None:
    """Refuse an f that is not (dq, dp) or the sum of the terms: engines evaluate one of them."""
    problem, m = engine.problem, len(y0) // 2
    if problem.context is not None or not isinstance(problem.f, UserFunction | Formula):
        return
    given: list[tuple[str, Callable[[], Any]]] = []
    if problem.separable:
        halves = lambda: np.concatenate([problem.dq(y0[m:]), problem.dp(y0[:m])])  # noqa: E731
        given.append(("parts `dq`, `dp`", halves))
    elif problem.dq is not None:
        first = lambda: np.concatenate([problem.dq(y0[m:]), problem.f(t0, y0)[m:]])  # noqa: E731
        given.append(("part `dq`", first))
    if problem.terms:
        given.append(("`terms`", lambda: np.sum([term(t0, y0) for term in problem.terms], axis=0)))
    for name, others in given:
        try:
            whole, parts = np.asarray(problem.f(t0, y0)), others()
        except (FunctionFailed, ArithmeticError):
            continue
        if not (np.isfinite(whole).all() and np.isfinite(parts).all()):
            continue
        apart, scale = np.abs(whole - parts), np.abs(whole) + np.abs(parts)
        if (apart > _PARTS_AGREE * max(float(scale.max()), 1e-300)).any():
            k = int(np.argmax(apart))
            raise UsageError(
                f"`f` and its {name} disagree at the start: component {k} is "
                f"{whole[k]:.6g} in f and {parts[k]:.6g} in the {name.split()[0].strip('`')}"
            )
