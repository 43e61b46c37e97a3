"""Measure what an integrator outside the catalogue claims of itself: order, symmetry, forms."""

from __future__ import annotations

from functools import cache

import numpy as np

from .judgement import Judgement, errors_of, floor_of, order_judgement
from .subject import Subject
from .vectors import TestProblem, array, problems

__all__ = ["Measurement"]

#: Length of the runs that measure an order.
_TIME = 4.0


class Measurement:
    """Measures one integrator on one problem."""

    #: Large, so that the smallest violations of symmetry and symplecticity show.
    size = 0.25

    def __init__(self, subject: Subject, name: str, task: TestProblem) -> None:
        self.subject, self.name, self.task = subject, name, task

    def _end(self, steps: int) -> np.ndarray:
        problem, h = self.task.problem, _TIME / steps
        if "solve" in self.subject.offers:
            return self.subject.solve(self.name, problem, h, steps)[-1]
        values = array(self.task.y0)[None, :]
        for n in range(steps):
            values = self.subject.step(self.name, problem, float(self.task.t0) + n * h, values, h)
        return values[0]

    def answer(self) -> Judgement:
        """A short run returns finite numbers of the right shape."""
        return Judgement(self._end(64) is not None)

    def order(self, right: int) -> Judgement:
        """Errors against a Taylor series of 30 digits."""
        exact = _taylor_end(self.task.name, _TIME)
        counts = [2**k for k in range(2, 10)]
        steps, errors = errors_of(
            self._end, counts, exact, enough=lambda n, e: e < floor_of(self.subject, self.name, n)
        )
        return order_judgement(steps, errors, right, self.subject, self.name)

    def _step(self, y: np.ndarray, h: float) -> np.ndarray:
        return self.subject.step(self.name, self.task.problem, float(self.task.t0), y[None, :], h)[
            0
        ]

    def symmetric(self) -> Judgement:
        """A step and one back with -h return to the beginning."""
        y = array(self.task.y0)
        gap = float(np.abs(self._step(self._step(y, self.size), -self.size) - y).max())
        # two steps, each off by some hundred roundings as in the vectors
        allowed = 1000 * self.subject.unit(self.name)
        said = f"a step of {self.size} and one back miss the beginning by {gap:.2g}"
        return _measured_claim(gap, allowed, f"{said} (rounding explains {allowed:.2g})")

    def symplectic(self) -> Judgement:
        """The derivative M of a step satisfies ``M^T J M = J``.

        By central differences of fourth order: step 2e-3 leaves 1e-11 of truncation, and rounding
        (u + v) 100 / 2e-3 below 1e-10 in double precision.
        """
        y, d = array(self.task.y0), self.task.problem.dimension
        width = 2e-3
        columns = []
        for k in range(d):
            unit = np.zeros(d)
            unit[k] = width
            ends = [self._step(y + m * unit, self.size) for m in (1, -1, 2, -2)]
            columns.append((8 * (ends[0] - ends[1]) - (ends[2] - ends[3])) / (12 * width))
        M, half = np.stack(columns, axis=1), d // 2
        J = np.block(
            [[np.zeros((half, half)), np.eye(half)], [-np.eye(half), np.zeros((half, half))]]
        )
        gap = float(np.abs(M.T @ J @ M - J).max())
        allowed = 1e-9 + self.subject.unit(self.name) * 1e3 / width
        said = f"M^T J M differs from J by {gap:.2g}, M the derivative of a step of {self.size}"
        return _measured_claim(gap, allowed, f"{said} (allowed {allowed:.2g})")


def _measured_claim(gap: float, allowed: float, said: str) -> Judgement:
    return Judgement(gap <= allowed, "" if gap <= allowed else said, gap)


@cache
def _taylor_end(name: str, time: float) -> np.ndarray:
    from .taylor import taylor_states

    task = problems()[name]
    (end,) = taylor_states(task.problem, [float(task.t0) + time], digits=25)
    return np.array([float(x) for x in end])
