"""Measure what an integrator outside the catalogue claims of itself: order, symmetry, forms."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache

import numpy as np

from ..errors import UsageError
from .diagnosis import single_precision
from .probe import box_of, read
from .read_orders import HIGHEST, first_defect, nearest
from .subject import NotOffered, Subject
from .taylor import taylor_states
from .vector_problems import TestProblem, array, problems
from .verdicts import Judgement, errors_of, floor_of, input_judgement, order_judgement, same

#: Length of the runs that measure an order.
_TIME = 4.0
#: Steps of a short run.
_SHORT = 64
#: Times of f, in steps, that count as one: a difference quotient calls it beside a stage.
_SAME_TIME = 1e-6
#: Relative difference of a nonlinear step from what the coefficients make of it, at most.
_READ = 1e-10


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
        t0, begin = float(self.task.t0), self._started(h)
        *_, (_, values) = self.subject.steps(self.name, problem, t0, begin, h, steps)
        if self._carried == 1 or "finish" not in self.subject.offers:
            return values[0]
        return self.subject.finish(self.name, problem, t0 + _TIME, values, h)

    @property
    def _carried(self) -> int:
        return int(self.subject.methods[self.name].get("values", 1))

    def _started(self, h: float) -> np.ndarray:
        """Return starting values (r, d): the solution itself, or what the adapter makes of it."""
        y0 = array(self.task.y0)
        if self._carried == 1:
            return y0[None, :]
        if "start" not in self.subject.offers:
            raise NotOffered(f"{self._several}, and the adapter has no `start` and no `solve`")
        return self.subject.start(self.name, self.task.problem, h, (self._carried, len(y0)))

    @property
    def _several(self) -> str:
        return f"the method carries {self._carried} values"

    def answer(self) -> Judgement:
        """Check that a short run is finite and well shaped, and a step leaves its input alone."""
        self._end(_SHORT)
        offers = self.subject.offers
        if "step" in offers and (self._carried == 1 or "start" in offers):
            h, t0 = _TIME / _SHORT, float(self.task.t0)
            values = self._started(h)
            return input_judgement(
                self.subject.leaves_input(self.name, self.task.problem, t0, values, h)
            )
        return Judgement(True)

    def repeatable(self) -> Judgement:
        """Check that two equal runs with another one between them give the same."""
        allowed = floor_of(self.subject, self.name, _SHORT)
        return same(lambda: self._end(_SHORT), lambda: self._end(2 * _SHORT), allowed, "run")

    def order(self, right: int) -> Judgement:
        """Return errors against a Taylor series of 30 digits."""
        exact = _taylor_end(self.task.name, _TIME)
        counts = [2**k for k in range(2, 10)]
        steps, errors = errors_of(
            self._end, counts, exact, enough=lambda n, e: e < floor_of(self.subject, self.name, n)
        )
        found = order_judgement(steps, errors, right, self.subject, self.name)
        if found.holds is not False:
            return found
        why = single_precision(self._end(steps[-1])[None, :], exact[None, :])
        if not why and (read_off := self.coefficients(right)).holds is False:
            why = read_off.message
        return replace(found, message=f"{found.message}; {why}") if why else found

    def coefficients(self, right: int) -> Judgement:
        """Return the order conditions, at the coefficients that are read out of a step.

        Judged where a step shows the coefficients and a nonlinear step is what they make of it.
        """
        if self._carried != 1:
            return Judgement(None, f"not judged: {self._several}")
        try:
            reading = read(self.subject, self.name, 1)
        except UsageError as error:
            return Judgement(None, f"not judged: {error}")
        if reading.notes and reading.unexplained > _READ:
            return Judgement(None, f"not judged: {reading.notes[0]}")
        unit = self.subject.epsilon if reading.explicit else self.subject.unit(self.name)
        defect = first_defect(reading, right, unit)
        if defect is None:
            least = min(right, HIGHEST)
            return Judgement(True, declared=right, value=least)
        near = nearest(reading)
        said = f"{defect}; {near}" if near else str(defect)
        gap = abs(defect.weight - 1 / defect.tree.density)
        return Judgement(False, said, gap, right, defect.order)

    def abscissae(self, declared: Sequence[float]) -> Judgement:
        """Check that a step calls f at the declared times and at no others."""
        problem, h, t0 = self.task.problem, self.size, float(self.task.t0)
        called: list[float] = []

        def f(t: float, y: np.ndarray) -> np.ndarray:
            called.append((float(t) - t0) / h)
            return problem.f(t, y)

        watched = replace(problem, f=f, jacobian=problem.jacobian)
        box_of(self.subject, self.name)(watched, t0, self._started(h), h)

        def missing(times: Sequence[float], others: Sequence[float]) -> list[float]:
            return [x for x in times if min((abs(x - y) for y in others), default=1.0) > _SAME_TIME]

        listed = ", ".join(f"{x:.6g}" for x in declared)
        for x in missing(called, declared):
            said = f"f is called at t {x:+.6g} h, and the abscissae are {listed}"
            return Judgement(False, said, min(abs(x - y) for y in declared))
        for x in missing(declared, called):
            return Judgement(False, f"f is not called at t {x:+.6g} h, one of the abscissae")
        return Judgement(True)

    def _step(self, y: np.ndarray, h: float) -> np.ndarray:
        if self._carried != 1:
            raise NotOffered(f"{self._several}, and this is measured of one")
        box = box_of(self.subject, self.name)
        return box(self.task.problem, float(self.task.t0), y[None, :], h)[0]

    def symmetric(self) -> Judgement:
        """Return a step and one back with -h return to the beginning."""
        if "step" not in self.subject.offers:
            raise NotOffered("steps back need `step`")
        y = array(self.task.y0)
        gap = float(np.abs(self._step(self._step(y, self.size), -self.size) - y).max())
        # two steps, each off by some hundred roundings as in the vectors
        allowed = 1000 * self.subject.unit(self.name)
        said = f"a step of {self.size} and one back miss the beginning by {gap:.2g}"
        return _measured_claim(gap, allowed, f"{said} (rounding explains {allowed:.2g})")

    def symplectic(self) -> Judgement:
        """Return the derivative M of a step satisfies ``M^T J M = J``.

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
    task = problems()[name]
    (end,) = taylor_states(task.problem, [float(task.t0) + time], digits=25)
    return np.array([float(x) for x in end])
