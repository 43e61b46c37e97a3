"""Reference states to any number of digits: Taylor series of the solution, by recurrence.

The right-hand side is run once on symbols that record its operations. Each operation then yields
its next Taylor coefficient from those of its operands, so that a series to order N costs O(N**2)
per operation (Moore 1966; Jorba and Zou, Experimental Mathematics 14 (2005) 99-117). Nothing is
shared with the methods under test.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from ..errors import UsageError
from ..problems.formula import FUNCTIONS
from ..problems.model import Problem

MAX_STEPS = 200_000
GUARD_DIGITS = 10
SMALLEST_STEP = 1e-12  # below, the radius of convergence shrinks towards a singularity


class _Series:
    """One quantity's Taylor coefficients; ``rule(k)`` is the k-th from those recorded before."""

    __slots__ = ("coefficients", "rule", "tape")

    def __init__(self, tape: Tape, rule: Callable[[int], Any]) -> None:
        self.tape, self.rule = tape, rule
        self.coefficients: list[Any] = []
        tape.nodes.append(self)

    def _with(self, other: Any, both: Callable[..., Any], one: Callable[..., Any]) -> Any:
        """Record an operation with another series, or with a number."""
        if isinstance(other, _Series):
            return _Series(self.tape, both(self.coefficients, other.coefficients))
        return _Series(self.tape, one(self.coefficients, other))

    def __add__(self, other: Any) -> Any:
        return self._with(
            other,
            lambda a, b: lambda k: a[k] + b[k],
            lambda a, x: lambda k: a[k] if k else a[0] + x,
        )

    __radd__ = __add__

    def __neg__(self) -> Any:
        a = self.coefficients
        return _Series(self.tape, lambda k: -a[k])

    def __pos__(self) -> Any:
        return self

    def __sub__(self, other: Any) -> Any:
        return self._with(
            other,
            lambda a, b: lambda k: a[k] - b[k],
            lambda a, x: lambda k: a[k] if k else a[0] - x,
        )

    def __rsub__(self, other: Any) -> Any:
        return -self + other

    def __mul__(self, other: Any) -> Any:
        dot = self.tape.context.fdot
        return self._with(
            other,
            lambda a, b: lambda k: dot(a, b[k::-1]),
            lambda a, x: lambda k: a[k] * x,
        )

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        if not isinstance(other, _Series):
            return self * (1 / self.tape.context.mpf(other))
        a, b, dot = self.coefficients, other.coefficients, self.tape.context.fdot
        result = _Series(self.tape, lambda k: (a[k] - dot(q, b[k:0:-1])) / b[0])
        q = result.coefficients
        return result

    def __rtruediv__(self, other: Any) -> Any:
        return self.tape.constant(other) / self

    def __pow__(self, exponent: Any) -> Any:
        if isinstance(exponent, _Series):
            return self.tape.exp(exponent * self.tape.log(self))
        if exponent == int(exponent) and exponent > 0:
            half = self ** (int(exponent) // 2) if exponent > 1 else None
            square = self if half is None else half * half
            return square * self if half is not None and exponent % 2 else square
        a, r, ctx = self.coefficients, self.tape.context.mpf(exponent), self.tape.context

        def rule(k: int) -> Any:
            if not k:
                return a[0] ** r
            terms = [(r * j - (k - j)) * a[j] for j in range(1, k + 1)]
            return ctx.fdot(terms, power[k - 1 :: -1]) / (k * a[0])

        result = _Series(self.tape, rule)
        power = result.coefficients
        return result

    def __rpow__(self, base: Any) -> Any:
        return self.tape.exp(self * self.tape.context.log(base))


class Tape:
    """Records a right-hand side; stands in for an mpmath context while it runs."""

    def __init__(self, context: Any) -> None:
        self.context = context
        self.nodes: list[_Series] = []
        self.mpf, self.pi = context.mpf, context.pi

    def variable(self) -> _Series:
        """Return a quantity whose coefficients are set from outside."""
        result = _Series(self, lambda k: None)
        self.nodes.pop()
        return result

    def constant(self, value: Any) -> _Series:
        """Record a number."""
        number, zero = self.context.mpf(value), self.context.mpf(0)
        return _Series(self, lambda k: zero if k else number)

    def _of(self, name: str, x: Any, rule: Callable[..., Any]) -> Any:
        """Record f(x) whose first coefficient is f(x_0) and whose k-th is ``rule(a, f, k)``."""
        if not isinstance(x, _Series):
            return getattr(self.context, name)(x)
        function, a = getattr(self.context, name), x.coefficients
        result = _Series(self, lambda k: rule(a, own, k) if k else function(a[0]))
        own = result.coefficients
        return result

    def sqrt(self, x: Any) -> Any:
        """Square root, s**2 = x."""

        def rule(a: Any, own: Any, k: int) -> Any:
            dot = self.context.fdot(own[1:], own[k - 1 : 0 : -1])
            return (a[k] - dot) / (2 * own[0])

        return self._of("sqrt", x, rule)

    def exp(self, x: Any) -> Any:
        """Return the exponential, e' = x' e."""
        return self._of("exp", x, lambda a, e, k: self._slope(a, e, k) / k)

    def log(self, x: Any) -> Any:
        """Return the logarithm, x l' = x'."""

        def rule(a: Any, own: Any, k: int) -> Any:
            terms = [j * own[j] for j in range(1, k)]
            return (a[k] - self.context.fdot(terms, a[k - 1 : 0 : -1]) / k) / a[0]

        return self._of("log", x, rule)

    def sin(self, x: Any) -> Any:
        """Return the sine, s' = x' c."""
        return self._sine(x)[0] if isinstance(x, _Series) else self.context.sin(x)

    def cos(self, x: Any) -> Any:
        """Return the cosine, c' = -x' s."""
        return self._sine(x)[1] if isinstance(x, _Series) else self.context.cos(x)

    def tan(self, x: Any) -> Any:
        """Return the tangent, the quotient of sine and cosine."""
        if not isinstance(x, _Series):
            return self.context.tan(x)
        s, c = self._sine(x)
        return s / c

    def _sine(self, x: _Series) -> tuple[_Series, _Series]:
        ctx, a = self.context, x.coefficients
        s = _Series(self, lambda k: self._slope(a, cosine, k) / k if k else ctx.sin(a[0]))
        c = _Series(self, lambda k: -self._slope(a, sine, k) / k if k else ctx.cos(a[0]))
        sine, cosine = s.coefficients, c.coefficients
        return s, c

    def atan2(self, u: Any, x: Any) -> Any:
        """Return the angle w of the point (x, u), (x**2 + u**2) w' = x u' - u x'."""
        if not (isinstance(u, _Series) or isinstance(x, _Series)):
            return self.context.atan2(u, x)
        u = u if isinstance(u, _Series) else self.constant(u)
        x = x if isinstance(x, _Series) else self.constant(x)
        d, a, b = (u * u + x * x).coefficients, u.coefficients, x.coefficients

        def rule(k: int) -> Any:
            if not k:
                return self.context.atan2(a[0], b[0])
            right = self._slope(a, b, k) - self._slope(b, a, k)
            terms = [j * own[j] for j in range(1, k)]
            return (right - self.context.fdot(terms, d[k - 1 : 0 : -1])) / (k * d[0])

        result = _Series(self, rule)
        own = result.coefficients
        return result

    def _slope(self, a: Sequence[Any], b: Sequence[Any], k: int) -> Any:
        """Return k-th coefficient of tau a'(tau) b(tau)."""
        terms = [j * a[j] for j in range(1, k + 1)]
        return self.context.fdot(terms, b[k - 1 :: -1])


class _Integrator:
    """Taylor series of one problem, recorded once and summed from any state."""

    def __init__(self, problem: Problem, digits: int) -> None:
        import mpmath

        self.context = mpmath.MPContext()
        self.context.dps = digits + GUARD_DIGITS
        self.order = int(1.16 * digits) + 2  # -log(tolerance)/2, optimal for O(N**2) operations
        self.tolerance = self.context.mpf(10) ** -digits
        self.start = problem.on(self.context).y0
        self.tape = Tape(self.context)
        self.time = self.tape.variable()
        self.y = [self.tape.variable() for _ in self.start]
        try:
            f = problem.on(self.tape).f(self.time, np.array(self.y, dtype=object))
        except (TypeError, AttributeError, UsageError) as error:
            raise UsageError(
                f"a reference for {problem.name} needs f as expressions or loops ({error})"
            ) from None
        self.f = [x if isinstance(x, _Series) else self.tape.constant(x) for x in f]

    def expand(self, t: Any, y: Sequence[Any]) -> list[list[Any]]:
        """Return coefficients of the solution through (t, y), one list per component."""
        zero, one = self.context.mpf(0), self.context.mpf(1)
        self.time.coefficients[:] = [t, one] + [zero] * self.order
        for series, value in zip(self.y, y, strict=True):
            series.coefficients[:] = [value]
        for node in self.tape.nodes:
            node.coefficients.clear()
        for k in range(self.order):
            for node in self.tape.nodes:
                node.coefficients.append(node.rule(k))
            for series, slope in zip(self.y, self.f, strict=True):
                series.coefficients.append(slope.coefficients[k] / (k + 1))
        return [series.coefficients for series in self.y]

    def step_size(self, columns: Sequence[Sequence[Any]]) -> Any:
        """Step after which the last terms are as small as asked (Jorba and Zou, section 3.2)."""
        n = self.order
        size = max(abs(c[0]) for c in columns) or self.context.mpf(1)
        last = max(abs(c[n]) for c in columns), max(abs(c[n - 1]) for c in columns)
        roots = [
            (self.tolerance * size / c) ** (self.context.mpf(1) / (n - i))
            for i, c in enumerate(last)
            if c
        ]
        return min(roots) if roots else self.context.inf


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
    engine = _Integrator(problem, digits)
    ctx = engine.context
    t, y, states, steps = ctx.mpf(problem.t_span[0]), list(engine.start), [], 0
    for target in times:
        exact = Fraction(target)
        end = ctx.mpf(exact.numerator) / exact.denominator
        while t != end:
            columns = engine.expand(t, y)
            h = min(engine.step_size(columns), abs(end - t))
            if abs(h) < SMALLEST_STEP and h != abs(end - t):
                raise UsageError(f"the solution of {problem.name} ends near t = {ctx.nstr(t, 12)}")
            reached = end if h == abs(end - t) else t + (h if end > t else -h)
            powers = [(reached - t) ** k for k in range(engine.order + 1)]
            y = [ctx.fdot(c, powers) for c in columns]
            t, steps = reached, steps + 1
            if steps > MAX_STEPS:
                raise UsageError(f"{problem.name} takes over {MAX_STEPS} Taylor steps; too stiff")
        states.append(np.array(y, dtype=object))
    return states


assert all(hasattr(Tape, name) for name in FUNCTIONS)
