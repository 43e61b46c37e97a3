"""The one-step method underlying a GLM, found by iteration alone: no series, no trees.

A method that carries r values has, for small h, one starting map S whose output is y itself
and with ``M S(y) = S(P(y))`` for a one-step method P. Iterating that equation gives S to any order
in h: every pass gains one. What values lack to ``S(y)`` of their own solution y is parasitic.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.reference import Reader, Stepper
from ..errors import UsageError
from ..exact.linalg import identity, vecmat
from ..method import Component
from ..method.preconsistency import output, preconsistency_vector


@dataclass(frozen=True, eq=False)
class _Half:
    """What is needed of one matrix V to start and to read off the solution."""

    columns: slice  #: The components of a state this half carries.
    rows: int  #: Number of values carried.
    u: np.ndarray  #: (r,), ``V u = u``.
    e: np.ndarray  #: (r,) with ``e u = 1``: the solution is ``e y``.
    inverse: np.ndarray  #: (r, r), ``(I - V + u e V)^-1``.
    #: Whether ``e V = e``, as where the first value takes from no other, or by choice.
    steady: bool


def _half(engine: Stepper, reader: Reader, m: Component, *, conjugate: bool) -> _Half:
    """Compute u, e and the inverse of one half in the engine's arithmetic."""
    arithmetic, r = engine.arithmetic, len(m.V)
    exact_u = preconsistency_vector(m)
    if exact_u is None:
        raise UsageError("the method is not pre-consistent: no u has V u = u and U u = 1")
    u = arithmetic.array((exact_u,))[0]
    one = arithmetic.array(identity(r))
    w, v, e = output(m), arithmetic.array(m.V), reader.weights
    steady = all((x - y).is_zero() is True for x, y in zip(vecmat(w, m.V), w, strict=True))
    try:
        inverse = arithmetic.solve(one - v + np.outer(u, e.dot(v)), one.copy())
        if conjugate and not steady:
            # l V = l and l u = 1 give l (I - V + u e V) = e V
            e, steady = e.dot(v).dot(inverse), True
            inverse = arithmetic.solve(one - v + np.outer(u, e), one.copy())
    except (np.linalg.LinAlgError, ZeroDivisionError):
        raise UsageError(
            "1 is not a simple eigenvalue of V; the underlying method is not unique"
        ) from None
    return _Half(reader.columns, r, u, e, inverse, steady)


class Underlying:
    """Starting map, solution and parasitic part for one method on one problem.

    ``conjugate`` reads the solution off by the left eigenvector of V at 1 instead of the output.
    Where that takes from others the underlying method becomes a conjugate one, and starting it
    costs a quarter.

    Raises
    ------
    UsageError
        Where V has no simple eigenvalue 1 with a common right eigenvector u.
    """

    def __init__(self, engine: Stepper, *, conjugate: bool = False) -> None:
        self.engine = engine
        self.halves = tuple(
            _half(engine, reader, m, conjugate=conjugate)
            for reader, m in zip(engine.readers, engine.method.carriers, strict=True)
        )
        self.evaluations = 0

    @property
    def one_step(self) -> bool:
        """Whether a single value is carried, so that starting is trivial."""
        return all(half.rows == 1 for half in self.halves)

    def solution(self, values: np.ndarray) -> np.ndarray:
        """Return the solution among the values, shape (d,)."""
        parts = [half.e.dot(values[: half.rows, half.columns]) for half in self.halves]
        return np.concatenate(parts)

    def lifted(self, y: np.ndarray) -> np.ndarray:
        """Return ``u y``, the values that hold the solution y and nothing else."""
        values = self.engine.arithmetic.zeros(self.engine.shape, y)
        if y.dtype.kind == "c":
            values = values.astype(complex)
        for half in self.halves:
            values[: half.rows, half.columns] = np.outer(half.u, y[half.columns])
        return values

    def _correction(self, defect: np.ndarray) -> np.ndarray:
        out = defect * 0
        for half in self.halves:
            rows = slice(0, half.rows)
            out[rows, half.columns] = half.inverse.dot(defect[rows, half.columns])
        return out

    def start(self, t: Any, y0: np.ndarray, h: Any, *, order: int) -> np.ndarray:
        """Return S(y0) to within O(h^(order + 1)).

        A pass replaces ``S_n`` by ``S_n + (I - V + u e V)^-1 (M S_n - S_(n+1))``, which leaves the
        first value alone, along the first few points of the underlying method's own trajectory.
        It gains an order of h; where the first value takes from others, so that this trajectory
        changes from pass to pass by as much as the values, two passes gain one. Cost:
        ``passes (passes + 1)/2`` steps.
        """
        if self.one_step:
            return self.lifted(np.asarray(y0))
        passes = order if all(half.steady for half in self.halves) else 2 * order
        rest = [self.lifted(np.asarray(y0)) * 0 for _ in range(passes + 1)]
        for level in range(passes, 0, -1):
            current = self.lifted(np.asarray(y0)) + rest[0]
            improved = []
            for n in range(level):
                step = self.engine.step(t + n * h, current, h)
                self.evaluations += step.evaluations + step.velocity_evaluations
                following = self.lifted(self.solution(step.values)) + rest[n + 1]
                improved.append(rest[n] + self._correction(step.values - following))
                current = following
            rest = improved
        return self.lifted(np.asarray(y0)) + rest[0]

    def run(self, t: Any, values: np.ndarray, h: Any, steps: int) -> np.ndarray:
        """Take steps and return the values; an unsolved stage equation raises.

        Raises
        ------
        ArithmeticError
            When a stage equation could not be solved to round-off.
        """
        for n in range(steps):
            step = self.engine.step(t + n * h, values, h)
            self.evaluations += step.evaluations + step.velocity_evaluations
            if not step.converged:
                raise ArithmeticError(f"the stages of step {n + 1} could not be solved")
            values = step.values
        return values

    def parasitic(self, t: Any, values: np.ndarray, h: Any, *, order: int) -> np.ndarray:
        """Return the parasitic part of the values to within O(h^(order + 1)), shape (r, d)."""
        return values - self.start(t, self.solution(values), h, order=order)
