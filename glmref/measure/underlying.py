"""The one-step method underlying a GLM, found by iteration alone: no series, no trees.

A method that carries r values has, for small h, one starting map S whose output is y itself
and with ``M S(y) = S(P(y))`` for a one-step method P. Iterating that equation gives S to any order
in h: every pass gains one. What values lack to ``S(y)`` of their own solution y is parasitic.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..engine.reference import Reader, Stepper
from ..engine.starting_values import corrector, kernel_of, zero_start
from ..errors import UsageError
from ..exact.linalg import vecmat
from ..method import Component
from ..method.preconsistency import output


def _is_steady(m: Component) -> bool:
    """Return whether ``w V = w``, as where the first value takes from no other."""
    w = output(m)
    return all((x - y).is_zero() is True for x, y in zip(vecmat(w, m.V), w, strict=True))


def _conjugate(engine: Stepper, reader: Reader, m: Component) -> Reader:
    """Return how a component is read by l with ``l V = l`` and ``l u = 1``.

    Then ``l K = w V`` for ``K = I - V + u w V``.
    """
    K, V = kernel_of(engine, m, reader.weights), engine.arithmetic.array(m.V)
    return Reader(reader.columns, None, engine.arithmetic.solve(K.T, reader.weights.dot(V)))


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
        self.engine, self.readers, self.evaluations = engine, engine.readers, 0
        parts = engine.method.carriers
        #: Whether a single value is carried, so that starting is trivial.
        self.one_step = all(len(m.V) == 1 for m in parts)
        self.steady = conjugate or all(map(_is_steady, parts))
        try:
            if conjugate:
                self.readers = tuple(
                    reader if _is_steady(m) else _conjugate(engine, reader, m)
                    for reader, m in zip(engine.readers, parts, strict=True)
                )
            self._correction = corrector(engine, self.readers)
            self._correction(self.lifted(engine.problem.y0))
        except (np.linalg.LinAlgError, ZeroDivisionError):
            raise UsageError(
                "1 is not a simple eigenvalue of V; the underlying method is not unique"
            ) from None

    def solution(self, values: np.ndarray) -> np.ndarray:
        """Return the solution among the values, shape (d,)."""
        return np.concatenate([w.dot(values[: len(w), at]) for at, _, w in self.readers])

    def lifted(self, y: np.ndarray) -> np.ndarray:
        """Return ``u y``, the values that hold the solution y and nothing else."""
        return zero_start(self.engine, y)

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
        passes = order if self.steady else 2 * order
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
