"""Reference states of stiff problems: Radau IIA collocation of any order, at any precision.

The stage equations hold to all digits asked; only the matrix of Newton's method is a double
precision one, so that each iteration still gains about ten digits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from glmref.errors import UsageError
from glmref.problems.model import Problem

MAX_STEPS = 20_000
MAX_ITERATIONS = 40
GUARD_DIGITS = 30  # slopes of a stiff problem lose log10(h |J|) digits to cancellation
SAFETY = 0.8  # of the step size that the error estimate allows


def radau_nodes(stages: int, ctx: Any) -> list[Any]:
    """Return nodes of Radau IIA: the zeros of P_s - P_{s-1} on [0, 1], the last one being 1.

    The zeros separate those of a trigonometric approximation, from which Newton's method starts.
    """

    def radau(x: Any) -> tuple[Any, Any]:
        """Return value and slope of P_s - P_{s-1} at x in [-1, 1], by the three-term recurrence."""
        p, q, dp, dq = x, ctx.mpf(1), ctx.mpf(1), ctx.mpf(0)
        for n in range(1, stages):
            p, q = ((2 * n + 1) * x * p - n * q) / (n + 1), p
            dp, dq = dq + (2 * n + 1) * q, dp
        return p - q, dp - dq

    nodes = []
    for i in range(1, stages):
        x = -ctx.cos(ctx.pi * (4 * i - 1) / (4 * stages - 1 + ctx.mpf(1) / 2))
        for _ in range(60):
            value, slope = radau(x)
            # divide out the zeros found and the one at 1, so that no zero is found twice
            rest = 1 / (x - 1) + sum(1 / (x - y) for y in nodes)
            change = value / (slope - value * rest)
            x -= change
            if abs(change) < ctx.eps * 100:
                break
        nodes.append(x)
    return [*sorted((1 + x) / 2 for x in nodes), ctx.mpf(1)]


class _Collocation:
    """Radau IIA with its Newton iteration, for one problem."""

    def __init__(self, problem: Problem, digits: int, stages: int) -> None:
        import mpmath

        self.ctx = ctx = mpmath.MPContext()
        self.problem = problem
        self.digits, self.stages = digits, stages
        # the interpolation below loses about one digit per stage
        ctx.dps = digits + GUARD_DIGITS + stages
        self.c = np.array(radau_nodes(stages, ctx), dtype=object)
        powers = ctx.matrix(stages)
        for i in range(stages):
            for j in range(stages):
                powers[i, j] = self.c[i] ** j
        inverted: Any = powers**-1
        inverse = np.array(list(inverted), dtype=object).reshape(stages, stages)
        integrals = np.array(
            [[c ** (j + 1) / (j + 1) for j in range(stages)] for c in self.c], dtype=object
        )
        self.A = integrals @ inverse
        # coefficient of the highest Legendre polynomial in the interpolant of the slopes
        leading = math.comb(2 * stages - 2, stages - 1)
        self.highest = inverse[-1] / leading
        self.A_double = self.A.astype(float)
        ctx.dps = digits + GUARD_DIGITS
        self.exact = problem.on(ctx)
        self.zero = ctx.mpf(0)

    def step(self, t: Any, y: np.ndarray, h: Any, guess: np.ndarray) -> tuple[np.ndarray, Any]:
        """Solve the stage equations Z = h A f(y + Z): Z, shape (s, d), and the error estimate.

        The estimate is infinite where Newton's method does not converge.
        """
        z, before, inverse = guess, None, None
        scale = self._scale(y, z)
        for _ in range(MAX_ITERATIONS):
            stages = zip(t + h * self.c, y + z, strict=True)
            slopes = np.array([self.exact.f(time, state) for time, state in stages])
            residual = (z - h * (self.A @ slopes)) / scale
            size = max(abs(x) for x in residual.flat) or self.ctx.mpf(1)
            if inverse is None:
                inverse = self._inverse(t, y, z, h, scale)
                if inverse is None:
                    break
            # only the matrix is in double precision: each iteration corrects some ten digits
            change = (inverse @ (residual / size).astype(float).reshape(-1)).reshape(z.shape)
            z = z - np.vectorize(self.ctx.mpf, otypes=[object])(change) * size * scale
            moved = size * float(np.max(np.abs(change)))
            if moved <= self.ctx.mpf(10) ** (-self.digits - 5):
                return z, self._estimate(h, slopes, scale)
            if moved > 1000:
                break
            # a matrix is kept while it gains at least four digits each time
            if before is None or moved > before * self.ctx.mpf("1e-4"):
                inverse = None
            before = moved
        return z, self.ctx.inf

    def _scale(self, y: np.ndarray, z: np.ndarray) -> np.ndarray:
        """Return typical size of each component over the step, however small beside the largest."""
        sizes = [max(abs(x) for x in (y[i], *(y + z)[:, i])) for i in range(len(y))]
        largest = max(sizes) or self.ctx.mpf(1)
        # a component that is zero but for rounding has no size of its own
        least = largest * self.ctx.mpf(10) ** -self.digits
        return np.array([max(x, least) for x in sizes], dtype=object)

    def _inverse(
        self, t: Any, y: np.ndarray, z: np.ndarray, h: Any, scale: np.ndarray
    ) -> np.ndarray | None:
        """Return the inverse of I - h (a_ij J_j) in double precision and scaled variables."""
        s, d = z.shape
        matrix = np.eye(s * d).reshape(s, d, s, d)
        for j in range(s):
            jacobian = self.exact.jacobian(t + self.c[j] * h, y + z[j])
            scaled = (h * jacobian * scale[None, :] / scale[:, None]).astype(float)
            matrix[:, :, j, :] -= self.A_double[:, j, None, None] * scaled[None, :, :]
        try:
            return np.linalg.inv(matrix.reshape(s * d, s * d))
        except np.linalg.LinAlgError:
            return None

    def _estimate(self, h: Any, slopes: np.ndarray, scale: np.ndarray) -> Any:
        """Return the size of the highest Legendre coefficient of h f in a step, relative to y."""
        return max(abs(x) for x in h * (self.highest @ slopes) / scale)


def collocation_states(
    problem: Problem, times: Sequence[Any], *, digits: int = 20, stages: int = 12
) -> list[np.ndarray]:
    """Return the solution at increasing times (ints, Fractions, strings), by Radau IIA.

    The problem has a Jacobian; its exact y0 and parameters are used. Steps vary so that the last
    Legendre coefficient of each stays below 10**-digits, which the error of the state (order 2s - 1
    with s stages) undercuts by far: compare two settings. Each state is an array (d,) of mpmath
    numbers.

    Raises
    ------
    UsageError
        Without a Jacobian, or after 20,000 steps.
    """
    if problem.jacobian is None:
        raise UsageError(f"a collocation reference for {problem.name} needs its Jacobian")
    solver = _Collocation(problem, digits, stages)
    ctx = solver.ctx
    tolerance = ctx.mpf(10) ** -digits
    t, y = ctx.mpf(problem.t_span[0]), np.array(solver.exact.y0)
    h, states, steps = ctx.mpf(10) ** -6, [], 0
    for target in times:
        exact = Fraction(target)
        end = ctx.mpf(exact.numerator) / exact.denominator
        while t != end:
            size = min(h, end - t)
            z = np.full((stages, len(y)), solver.zero)
            z, error = solver.step(t, y, size, z)
            factor = SAFETY * (tolerance / error) ** (ctx.mpf(1) / stages) if error else 5
            if error <= tolerance:
                t = end if size == end - t else t + size
                y = y + z[-1]
                h = size * min(factor, 5) if size == h else max(h, size * min(factor, 5))
            else:
                h = size * max(min(factor, ctx.mpf(1) / 2), ctx.mpf(1) / 10)
            steps += 1
            if steps > MAX_STEPS:
                raise UsageError(f"{problem.name} takes over {MAX_STEPS} collocation steps")
        states.append(y)
    return states
