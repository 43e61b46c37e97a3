"""Renewals between compiled steps, without a return to Python.

One driver, compiled once for all methods and problems, calls the kernel of the steps and that of
the start, see :mod:`.maps`, by their addresses. It serves where the state of a kernel is the values
themselves: the solution is a sum of them, and what a start makes of it replaces all of them.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import kernel_cache, native
from .codegen import ARGUMENTS
from .kernel import Kernel
from .maps import Map
from .reference import Stepper

#: ``plan`` is described in :class:`Renewing`. Before step n, if it is one after which the values
#: are to be renewed, they are, unless they were: so the last step of a run leaves them as they are.
_SOURCE = """
def read(values, weights, d, size, y):
    c = 0
    while c < d:
        total = -0.0
        k = c
        while k < size:
            total = total + weights[k]*values[k] if weights[k] != 0.0 else total
            k += d
        y[c] = total
        c += 1

def kernel(x, par, t0, h, first, last, mark, every, out, row, tally,
           plan, seen, weights, made, again, good, work, table, spent, steps, start):
    d = plan[2]
    size = plan[6]
    n = first
    while n < last:
        if n % plan[0] == 0 and n > plan[1]:
            count = spent[0]
            read(x[0:size], weights[0:size], d, size, made[0:d])
            c = 0
            while c < d and plan[3] < plan[4]:
                seen[plan[3]*d + c] = made[c]
                c += 1
            start(work, table, t0 + n*h, h, 0, 1, 0, 1, made, 0, spent)
            if spent[4] == 0:
                spent[0] = count
                plan[5] = 1
                return 0
            plan[1] = n
            plan[3] += 1
            c = 0
            while c < size:
                x[c] = made[c]
                good[c] = made[c]
                c += 1
            while c < plan[7]:
                x[c] = 0.0
                c += 1
            read(made[0:size], weights[0:size], d, size, again[0:d])
            c = 0
            while c < plan[8]:
                x[plan[7] + c] = again[c]
                c += 1
            if plan[9] > 0:
                count = spent[0]
                start(work, table, t0 + n*h, h, 0, 1, 0, 1, again, 0, spent)
                spent[0] = count + 1
                c = 0
                while c < d:
                    x[plan[7] + c] = work[plan[9] + c]
                    c += 1
        until = n - n % plan[0] + plan[0]
        until = until if until < last else last
        outcome = steps(x, par, t0, h, n, until, mark, every, out, row, tally)
        n = tally[4]
        row = tally[5]
        if outcome != 0:
            return outcome
        if every > 0:
            mark = n - n % every + every
    return 0
"""
_OWN = {"plan": "i*", "seen": "d*", "weights": "d*", "made": "d*", "again": "d*", "good": "d*",
        "work": "d*", "table": "d*", "spent": "i*", "steps": "i", "start": "i"}  # fmt: skip


class RenewalFailed(Exception):
    """Start or finish had no value in the middle of a run, because of ``why``."""

    def __init__(self, why: Exception) -> None:
        super().__init__(str(why))
        self.why = why


class Renewing:
    """A kernel of steps that renews its values by itself after every ``renew`` steps.

    It is called as the kernel is.
    """

    def __init__(self, kernel: Kernel, start: Map, reference: Stepper, renew: int) -> None:
        built = kernel_cache.build(_SOURCE, ARGUMENTS | _OWN)
        self.driver, self.steps, self.start = built.kernel, kernel.built.kernel, start
        d, form, compensated = kernel.shape.dimension, kernel.form, kernel.options.compensated
        values, head = form.rows * d, form.rows * (1 + compensated) * d
        memory = len(form.names(compensated=compensated)) * d - head
        #: Steps between renewals, that of the last one, numbers of the solution, renewals since
        #: :meth:`taken` and how many solutions are kept of them at most, whether one failed,
        #: numbers of the values, of these with their rounding errors, and of what is remembered of
        #: the step before: a slope, with its place in the work array of the start, or a point.
        slope = start.slope_place if kernel.form.memory else 0
        numbers = (renew, 0, d, 0, 0, 0, values, head, memory, slope)
        self.plan, self.weights = np.array(numbers, dtype=np.int64), reference.weights
        self.made, self.again, self.good = (np.zeros(values) for _ in range(3))
        self.work = native.aligned_zeros(start.work_size)
        self.spent, self.seen = np.zeros(6, dtype=np.int64), np.zeros((0, d))

    @property
    def values(self) -> np.ndarray:
        """The values (r, d) after the last renewal."""
        return self.good.reshape(self.weights.shape).copy()

    def keep(self, most: int) -> None:
        """Make room for the solutions before so many renewals."""
        self.seen = np.zeros((most, self.seen.shape[1]))
        self.plan[4] = most

    def __call__(self, *given: object) -> int:
        """Take steps, see :data:`.codegen.ARGUMENTS`.

        Raises
        ------
        RenewalFailed
            Where the start has no finite values; the steps before are done.
        """
        code = self.driver(
            *given, self.plan, self.seen, self.weights, self.made, self.again, self.good, self.work,
            self.start.par, self.spent, self.steps.address, self.start.built.kernel.address,  # type: ignore[attr-defined]
        )  # fmt: skip
        if self.plan[5]:
            raise RenewalFailed(ArithmeticError("the values are not finite"))
        return code

    def taken(self) -> tuple[range, np.ndarray, int, int]:
        """Return the steps of the renewals since the last call, the last one tried included.

        Also the solutions (n, d) before them, of as many as there was room for, how many renewals
        there were, and their evaluations.
        """
        renew, last, _, count, most, failed = (int(x) for x in self.plan[:6])
        tried = range(last - (count - 1) * renew, last + failed * renew + 1, renew)
        found, spent = self.seen[: min(count + failed, most)].copy(), int(self.spent[0])
        self.plan[3], self.plan[5], self.spent[0] = 0, 0, 0
        return tried, found, count, spent


def renewing(kernel: Kernel, start: Map | None, reference: Stepper, renew: int) -> Kernel | None:
    """Return a kernel that renews its values, ``None`` where Python has to."""
    form = kernel.form
    plain = form.own_basis and not form.kick and not form.implicit_stages
    if start is None or kernel.built.engine != "native" or reference.method.finishing is not None:
        return None
    if not plain or not start.by_table or (form.memory and start.slope_place is None):
        return None
    read = [tuple(x.weights) for x in reference.readers]
    if form.ahead and read != [x.U[0] for x in form.components]:
        return None
    own = Renewing(kernel, start, reference, renew)
    return replace(kernel, built=replace(kernel.built, kernel=own))
