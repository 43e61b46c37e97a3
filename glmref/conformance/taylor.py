"""Reference states to any number of digits: Taylor series of the solution.

The right-hand side is evaluated on power series with balls as coefficients, by FLINT: where y is
right through order k, so is f(t, y), and its integral through order k + 1 (Moore 1966). The step
size is that of Jorba and Zou, Experimental Mathematics 14 (2005) 99-117. Nothing is shared with the
methods under test.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import flint
import numpy as np
from flint import arb, arb_poly, arb_series

from ..errors import UsageError
from ..problems.formula import FUNCTIONS
from ..problems.model import Problem

MAX_STEPS = 200_000
GUARD_DIGITS = 10
SMALLEST_STEP = 1e-12  # below, the radius of convergence shrinks towards a singularity


def _number(x: Any) -> Any:
    """Return a number as a ball; balls, series and numbers of mpmath as they are."""
    if isinstance(x, arb | arb_series):
        return x
    if hasattr(x, "_mpf_"):
        return arb(x)
    exact = Fraction(x)
    return arb(exact.numerator) / exact.denominator


def _angle(u: Any, x: Any) -> Any:
    """Return the angle w of the point (x, u): (x^2 + u^2) w' = x u' - u x'."""
    u, x = (_number(value) for value in (u, x))
    if isinstance(u, arb) and isinstance(x, arb):
        return arb.atan2(u, x)
    u, x = arb_series(u), arb_series(x)
    turned = (x * u.derivative() - u * x.derivative()) / (x * x + u * u)
    return turned.integral() + arb.atan2(u[0], x[0])


def _of(name: str) -> Callable[[Any], Any]:
    return lambda x: getattr(_number(x), name)()


def series_context() -> SimpleNamespace:
    """Return functions of balls and of power series, in the place of an mpmath context."""
    plain = {name: _of(name) for name in FUNCTIONS if name != "atan2"}
    return SimpleNamespace(mpf=_number, pi=arb.pi(), atan2=_angle, **plain)


@contextmanager
def working(digits: int) -> Iterator[None]:
    """Let FLINT work with so many digits; the length of its series is set inside."""
    before = flint.ctx.dps, flint.ctx.cap
    flint.ctx.dps = digits
    try:
        yield
    finally:
        flint.ctx.dps, flint.ctx.cap = before


def vector(series: Sequence[arb_series]) -> np.ndarray:
    """Return series as an array (d,); one by one, since numpy would take them for rows."""
    found = np.empty(len(series), dtype=object)
    for i, x in enumerate(series):
        found[i] = x
    return found


def _expansion(f: Callable[..., Any], t: Any, y: Sequence[Any], order: int) -> list[arb_series]:
    """Return the solution through (t, y) as series through an order, one per component."""
    found = [arb_series([x]) for x in y]
    for k in range(order):
        flint.ctx.cap = k + 1
        slopes = f(arb_series([t, 1]), vector(found))
        flint.ctx.cap = k + 2
        found = [arb_series(s).integral() + x for s, x in zip(slopes, y, strict=True)]
    return found


def _step_size(series: Sequence[arb_series], order: int, digits: int) -> float:
    """Step after which the last terms are as small as asked (Jorba and Zou, section 3.2)."""
    largest = {k: max(abs(x[k].mid()) for x in series) for k in (0, order - 1, order)}
    smallest = arb(10) ** -digits * (largest.pop(0) or 1)
    steps = [(smallest / c) ** (arb(1) / k) for k, c in largest.items() if c]
    return min(map(float, steps), default=math.inf)


def taylor_states(problem: Problem, times: Sequence[Any], *, digits: int = 30) -> list[np.ndarray]:
    """Return the solution at the given times, each step correct to about ``digits`` digits.

    The times (ints, Fractions or strings) increase or decrease on one side of t_span[0]; y0 and the
    parameters are taken exactly. ``digits`` bounds the error of one step relative to the largest
    component: how many digits of the state are right follows from comparing two values of it. Each
    state is an array (d,) of mpmath numbers.

    Raises
    ------
    UsageError
        When f is a plain Python function that cannot be expanded, or after 200,000 steps
        (stiff problems need an implicit method), or at a singularity of the solution.
    """
    import mpmath

    context = mpmath.MPContext()
    context.dps = digits + GUARD_DIGITS
    order = int(1.16 * digits) + 2  # -log(tolerance)/2
    states, steps = [], 0
    with working(digits + GUARD_DIGITS):
        recorded = problem.on(series_context())
        t, y, f = arb(problem.t_span[0]), recorded.y0, recorded.f
        for target in times:
            end = _number(target)
            while t != end:
                try:
                    series = _expansion(f, t, y, order)
                except (TypeError, AttributeError, UsageError) as error:
                    raise UsageError(
                        f"a reference for {problem.name} needs f as expressions or loops ({error})"
                    ) from None
                h, left = _step_size(series, order, digits), float(end - t)
                whole = h >= abs(left)
                if h < SMALLEST_STEP and not whole:
                    where = t.str(12, radius=False)
                    raise UsageError(f"the solution of {problem.name} ends near t = {where}")
                reached = end if whole else (t + math.copysign(h, left)).mid()
                # the midpoints are what is carried on: balls grow faster than errors do
                y = [arb_poly(x.coeffs())(reached - t).mid() for x in series]
                t, steps = reached, steps + 1
                if steps > MAX_STEPS:
                    raise UsageError(
                        f"{problem.name} takes over {MAX_STEPS} Taylor steps; too stiff"
                    )
            states.append(np.array([context.convert(x) for x in y], dtype=object))
    return states
