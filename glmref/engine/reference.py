"""The step as one reads it in a paper: the yardstick, not the fast path.

    Y = h A f(Y) + U y        y+ = h B f(Y) + V y

for every GLM (explicit, diagonally or fully implicit, real or complex) and every pair, in double
precision (numpy) or at any number of digits (mpmath). Stage equations are iterated to round-off:
until the change is zero or no longer decreases. Nothing is rearranged, so that a compiled kernel
can be compared with it. Arrays stand left of h: an mpmath number there would format the whole array
for a message that nobody reads before it lets numpy multiply.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from ..errors import UsageError
from ..exact import exact
from ..exact.linalg import Matrix
from ..method import GLM, FinishingMethod, PartitionedGLM, StartingMethod
from ..method.solution_value import outputs, stage_times, unit_place
from ..method.stage_order import pair_blocks, stage_blocks
from ..problems.model import Problem
from .arithmetic import Arithmetic, StageSolver, size
from .outcome import StartFailed

__all__ = [
    "PairStepper",
    "Step",
    "Stepper",
    "apply_finish",
    "apply_start",
    "stepper",
]


class Reader(NamedTuple):
    """How the solution of one component is read off its values.

    Attributes
    ----------
        columns: of the state, those of the component.
        place: of the value that is the solution, or ``None`` where several values are combined.
        weights: (r,) output functional in the arithmetic of the run.
    """

    columns: slice
    place: int | None
    weights: np.ndarray


@dataclass(frozen=True, eq=False)
class Step:
    """One step and what happened inside it.

    Attributes
    ----------
        values: (r, d) values after the step; for a pair see :class:`.outcome.Solution`.
        stages: (s, d) the Y_i; for a pair (n_Q, d/2) of Q followed by (n_P, d/2) of P as a tuple.
        slopes: the right-hand side at the stages, in the same shape.
        evaluations, velocity_evaluations, iterations: as in :class:`.outcome.Solution`.
        converged: whether every stage equation was solved to round-off.
    """

    values: np.ndarray
    stages: Any
    slopes: Any
    evaluations: int
    velocity_evaluations: int
    iterations: int
    converged: bool


class Coupled(NamedTuple):
    """Equations of m coupled stages: ``Y = base + h inner F``, ``F_i = f(times_i, Y_i)``.

    Attributes
    ----------
        h: step size. inner: (m, m). times: (m,). base: (m, d).
    """

    h: Any
    inner: np.ndarray
    times: list[Any]
    base: np.ndarray


#: ``settle(rhs, F, coupled)``: slopes (m, d) of coupled stages. ``rhs(F)`` is f at the stages
#: that the slopes F make; the F given are those at ``base``.
Settle = Callable[[Callable[[np.ndarray], np.ndarray], np.ndarray, Coupled], np.ndarray]


def _shaped(found: Any, like: np.ndarray, name: str) -> np.ndarray:
    """What a user's function returned, as an array of the shape of its argument."""
    array = np.asarray(found)
    if array.shape != like.shape:
        raise UsageError(f"`{name}` must return shape {like.shape}, got {array.shape}")
    return array


class Stepper:
    """Steps one method on one problem; keeps the coefficients in the arithmetic asked for.

    Args:
        method: a GLM.
        problem: in double precision form; it is moved to the arithmetic here.
        digits: ``None`` for double precision, else decimal digits of mpmath.
    """

    def __init__(self, method: GLM, problem: Problem, *, digits: int | None = None) -> None:
        self.arithmetic = Arithmetic(digits)
        self.problem = self.arithmetic.localised(problem)
        self._tableau(method)

    @cached_property
    def tableaux(self) -> dict[int, tuple[Matrix, Stepper]]:
        """Steppers of starts and finishes, with their A, by the identity of A."""
        return {}

    def _tableau(self, method: GLM) -> None:
        self.method = method
        number = self.arithmetic.array
        self.A, self.U = number(method.A), number(method.U)
        self.B, self.V = number(method.B), number(method.V)
        self.c = self.arithmetic.array((stage_times(method),))[0]
        self.blocks = stage_blocks(method.A)

    @property
    def shape(self) -> tuple[int, int]:
        """Shape (r, d) of the values carried."""
        return self.method.r, self.problem.dimension

    @property
    def parts(self) -> tuple[slice, ...]:
        """Columns of the state that each component of the method carries."""
        return (slice(None),)

    @cached_property
    def readers(self) -> tuple[Reader, ...]:
        """How the solution is read off the values, component by component."""
        return tuple(
            Reader(columns, unit_place(w), self.arithmetic.array((w,))[0])
            for columns, w in zip(self.parts, outputs(self._read), strict=True)
        )

    @property
    def _read(self) -> GLM | PartitionedGLM:
        return self.method

    @property
    def first_value(self) -> bool:
        """Whether the solution is the first value itself."""
        return all(reader.place == 0 for reader in self.readers)

    def solution(self, values: np.ndarray) -> np.ndarray:
        """Return the solution among the values, before a finishing method.

        Parameters
        ----------
        values : (..., r, d).

        Returns
        -------
        (..., d). Where each component is one of the values these are its very bits.
        """
        if self.first_value:
            return values[..., 0, :]
        parts = []
        for columns, place, weights in self.readers:
            if place is not None:
                parts.append(values[..., place, columns])
                continue
            terms = [w * values[..., k, columns] for k, w in enumerate(weights) if w]
            parts.append(sum(terms[1:], terms[0]))
        return np.concatenate(parts, axis=-1)

    def slope(self, t: Any, y: np.ndarray) -> np.ndarray:
        """Right-hand side at (t, y), shape (d,).

        Raises
        ------
            UsageError: when the function returns another shape.
        """
        return _shaped(self.problem.f(t, y), y, "f")

    def step(self, t: Any, values: np.ndarray, h: Any, *, settle: Settle | None = None) -> Step:
        """Take one step of size h from the values at time t.

        Parameters
        ----------
        settle : what finds the slopes of coupled stages; by default iteration to round-off.
        """
        solver = StageSolver(self.arithmetic)
        s, evaluations = self.method.s, 0
        stages = self.arithmetic.zeros((s, values.shape[1]), values + self.V[0, 0])
        slopes = self.arithmetic.zeros(stages.shape, stages)
        known = self.U.dot(values)

        def evaluate(i: int, y: np.ndarray) -> np.ndarray:
            nonlocal evaluations
            evaluations += 1
            stages[i] = y
            return self.slope(t + self.c[i] * h, y)

        for block in self.blocks:
            index = list(block.stages)
            base = known[index] + self.A[index].dot(slopes) * h
            if not block.implicit:
                slopes[index[0]] = evaluate(index[0], base[0])
                continue
            inner = self.A[np.ix_(index, index)]

            def rhs(x: np.ndarray, index: list[int] = index, base: Any = base, inner: Any = inner):
                y = base + inner.dot(x) * h
                return np.stack([evaluate(i, y[k]) for k, i in enumerate(index)])

            guess = np.stack([evaluate(i, base[k]) for k, i in enumerate(index)])
            if settle is not None:
                times = [t + self.c[i] * h for i in index]
                slopes[index] = settle(rhs, guess, Coupled(h, inner, times, base))
                continue
            scale = size(guess) + size(base) / abs(h) if h else size(guess)
            slopes[index] = solver(rhs, guess, scale)
        new = self.B.dot(slopes) * h + self.V.dot(values)
        return Step(new, stages, slopes, evaluations, 0, solver.iterations, solver.converged)


class PairStepper(Stepper):
    """Steps a :class:`PartitionedGLM` on a problem y = (q, p).

    On a separable problem every stage Q_i and P_i is evaluated once, each only when needed; on
    another one stage i is the pair (Q_i, P_i).
    """

    def __init__(
        self, method: PartitionedGLM, problem: Problem, *, digits: int | None = None
    ) -> None:
        self.arithmetic = Arithmetic(digits)
        self.problem = self.arithmetic.localised(problem)
        if not problem.separable and method.separable:
            raise UsageError(
                f"{method.name or 'the pair'} is for separable problems; {problem.name} gives no "
                f"`dq` and `dp`"
            )
        if problem.dimension % 2:
            raise UsageError(f"a pair needs y = (q, p), got {problem.dimension} components")
        self._take(method)

    def _take(self, method: PartitionedGLM) -> None:
        """Keep the coefficients of a pair in the arithmetic of the run."""
        self.pair = method
        for letter in "AUBV":
            setattr(self, letter, self.arithmetic.array(getattr(method, letter)))
            hat = self.arithmetic.array(getattr(method, f"{letter}_hat"))
            setattr(self, f"{letter}_hat", hat)
        self.half = self.problem.dimension // 2
        self.blocks = pair_blocks(method, joint=not self.problem.separable)

    def with_method(self, method: PartitionedGLM) -> PairStepper:
        """Return a stepper of another pair on the same problem in the same arithmetic."""
        other = PairStepper.__new__(PairStepper)
        other.arithmetic, other.problem = self.arithmetic, self.problem
        other._take(method)
        return other

    A_hat: np.ndarray
    U_hat: np.ndarray
    B_hat: np.ndarray
    V_hat: np.ndarray

    @property
    def shape(self) -> tuple[int, int]:
        """Shape (max(r, r^), d) of the values carried."""
        return max(self.pair.r, self.pair.r_hat), self.problem.dimension

    @property
    def parts(self) -> tuple[slice, ...]:
        """Columns of q and of p."""
        return slice(0, self.half), slice(self.half, 2 * self.half)

    @property
    def _read(self) -> PartitionedGLM:
        return self.pair

    def step(self, t: Any, values: np.ndarray, h: Any) -> Step:
        """Take one step of size h from the values at time t."""
        pair, m = self.pair, self.half
        solver = StageSolver(self.arithmetic)
        counts = [0, 0]
        q, p = values[: pair.r, :m], values[: pair.r_hat, m:]
        f = self.arithmetic.zeros((pair.n_P, m), values)
        k = self.arithmetic.zeros((pair.n_Q, m), values)
        Uq, Up = self.U.dot(q), self.U_hat.dot(p)
        joint = not self.problem.separable

        def stage_q(i: int) -> np.ndarray:
            return Uq[i] + self.A[i].dot(f) * h

        def stage_p(i: int) -> np.ndarray:
            return Up[i] + self.A_hat[i].dot(k) * h

        def refresh(nodes: Sequence[int]) -> None:
            """Evaluate the right-hand side at stages, all from the slopes as they were."""
            where = [stage_q(i) if i < pair.n_Q else stage_p(i - pair.n_Q) for i in nodes]
            other = [stage_p(i) for i in nodes] if joint else []
            for place, i in enumerate(nodes):
                if joint:
                    slope = self.slope(t, np.concatenate([where[place], other[place]]))
                    f[i], k[i] = slope[:m], slope[m:]
                    counts[0] += 1
                elif i < pair.n_Q:
                    k[i] = _shaped(self.problem.dp(where[place]), where[place], "dp")
                    counts[0] += 1
                else:
                    f[i - pair.n_Q] = _shaped(self.problem.dq(where[place]), where[place], "dq")
                    counts[1] += 1

        for block in self.blocks:
            nodes = list(block.stages)
            refresh(nodes)
            if block.implicit:
                self._solve(solver, nodes, f, k, refresh, size(values) / abs(h) if h else 0)
        new = self.arithmetic.zeros(self.shape, values)
        new[: pair.r, :m] = self.B.dot(f) * h + self.V.dot(q)
        new[: pair.r_hat, m:] = self.B_hat.dot(k) * h + self.V_hat.dot(p)
        stages = (
            np.stack([stage_q(i) for i in range(pair.n_Q)]),
            np.stack([stage_p(i) for i in range(pair.n_P)]),
        )
        return Step(new, stages, (f, k), counts[0], counts[1], solver.iterations, solver.converged)

    def _solve(
        self, solver: StageSolver, nodes: list[int], f: np.ndarray, k: np.ndarray,
        refresh: Callable[[Sequence[int]], None], scale: Any,
    ) -> None:  # fmt: skip
        """Iterate the slopes of a block of stages that depend on each other."""
        joint, n = not self.problem.separable, self.pair.n_Q
        in_f = nodes if joint else [i - n for i in nodes if i >= n]
        in_k = nodes if joint else [i for i in nodes if i < n]

        def rhs(x: np.ndarray) -> np.ndarray:
            f[in_f], k[in_k] = x[: len(in_f)], x[len(in_f) :]
            refresh(nodes)
            return np.concatenate([f[in_f], k[in_k]])

        x = solver(rhs, np.concatenate([f[in_f], k[in_k]]), scale + size(f) + size(k))
        f[in_f], k[in_k] = x[: len(in_f)], x[len(in_f) :]


def stepper(
    method: GLM | PartitionedGLM, problem: Problem, *, digits: int | None = None
) -> Stepper:
    """Return the stepper for a method or a pair on a problem.

    Args:
        digits: ``None`` for double precision, else decimal digits.

    Raises
    ------
        UsageError: when the pair needs a separable problem and this one is not.
    """
    if isinstance(method, PartitionedGLM):
        return PairStepper(method, problem, digits=digits)
    return Stepper(method, problem, digits=digits)


def _runge_kutta_slopes(
    engine: Stepper, A: Matrix, t: Any, y: np.ndarray, h: Any
) -> tuple[np.ndarray, int]:
    """Slopes f(Y) of Y = y + h A f(Y), and the number of evaluations."""
    if not A:
        return engine.arithmetic.zeros((0, len(y))), 0
    _, inner = engine.tableaux.get(id(A), (A, None))
    if inner is None:  # rounding a tableau of decimals costs more than a step: done once
        one, zero = exact(1), exact(0)
        method = GLM(A=A, U=((one,),) * len(A), B=((zero,) * len(A),), V=((one,),))
        inner = Stepper.__new__(Stepper)
        inner.arithmetic, inner.problem = engine.arithmetic, engine.problem
        inner._tableau(method)
        engine.tableaux[id(A)] = A, inner
    taken = inner.step(t, y[None, :], h)
    if not taken.converged:
        raise StartFailed(
            "the stages of a starting or finishing method could not be solved; use a smaller h"
        )
    return taken.slopes, taken.evaluations


def apply_start(
    start: StartingMethod, engine: Stepper, t: Any, y0: np.ndarray, h: Any
) -> tuple[np.ndarray, int]:
    """Starting values ``y_k = u_k y0 + h B_k f(Y)`` and the evaluations they cost."""
    slopes, evaluations = _runge_kutta_slopes(engine, start.A, t, y0, h)
    u = engine.arithmetic.array((start.u,))[0]
    values = np.outer(u, y0)
    if len(slopes):
        values = values + h * engine.arithmetic.array(start.B).dot(slopes)
    return values, evaluations


def apply_finish(
    finish: FinishingMethod, engine: Stepper, t: Any, y: np.ndarray, h: Any
) -> tuple[np.ndarray, int]:
    """Finished solution ``y + h b f(Y)`` and the evaluations it costs."""
    slopes, evaluations = _runge_kutta_slopes(engine, finish.A, t, y, h)
    if not len(slopes):
        return y, 0
    return y + h * engine.arithmetic.array((finish.b,))[0].dot(slopes), evaluations
