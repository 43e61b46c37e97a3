"""Observed order: runs at doubled numbers of steps, in extended precision, no series and no trees.

With runs at n, 2n and 4n steps, ``log2(|y_n - y_2n| / |y_2n - y_4n|)`` tends to the order p with an
error of order h, or of order h^2 for symmetric methods. Richardson extrapolation of that sequence
removes it, so that a few doublings give p to a hundredth. The window chooses itself: doubling goes
on until two extrapolated orders agree while the orders as measured approach them.

Two orders are measured apart:

* the order of the solution itself (:func:`method_order`), by differences on a nonlinear problem;
* the order that a start and a finish can reach, the *effective* order (:func:`effective_order`).
  Where the exact flow at some time is a linear symmetry of the equations it commutes with every
  conjugation of the method by a B-series, and what is left of the error has the effective order:
  so it is after one period of an isochronous problem, where every solution has the same period, and
  after a third of it where turning by a third is a symmetry as well.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from ..compute.records import in_json
from ..engine.reference import stepper
from ..method import Method
from ..problems.model import Problem
from ..problems.named import builder
from .underlying import Underlying

#: Extrapolated orders that agree to this count as settled.
AGREEMENT = 0.01
#: ... provided that the last order as measured lies this close to the extrapolated one.
NEARNESS = 0.3
#: Columns of the extrapolation; older orders may lie outside the asymptotics and do not enter.
COLUMNS = 4
#: First number of steps.
FIRST = 6
#: Length of the interval on which solutions are compared, in time units of the problem: the shorter
#: it is, the smaller h at the same number of steps, and precision is not what is short here.
LENGTH = Fraction(1, 8)


@dataclass(frozen=True, slots=True)
class ConvergenceRecord:
    """Orders seen at successive doublings of the number of steps."""

    steps: tuple[int, ...]  #: Numbers of steps, each twice the one before.
    #: Differences ``|y_n - y_2n|``, one fewer than ``steps``; or errors, as many.
    sizes: tuple[float, ...]
    orders: tuple[float, ...]  #: Base-2 logarithms of successive ratios of sizes.
    extrapolated: tuple[float, ...]  #: The orders after Richardson extrapolation.
    order: float  #: The last extrapolated order.
    settled: bool  #: Whether the last extrapolated orders agree to :data:`AGREEMENT`.

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types."""
        return {key: x for key, x in in_json(self).items() if key != "extrapolated"}


def observed_order(
    run: Callable[[int], Sequence[Any]],
    *,
    first: int = FIRST,
    most: int = 128 * FIRST,
    target: Sequence[Any] | None = None,
) -> ConvergenceRecord:
    """Measure the order of ``run(n)``, the numerical solution at a fixed time after n steps.

    The number of steps doubles until two extrapolated orders agree, or ``most`` is reached.

    Parameters
    ----------
    run : Callable[[int], Sequence[Any]]
        n -> components, in a precision high enough that no difference reaches round-off.
    first : int
        The first number of steps.
    most : int
        The largest number of steps.
    target : Sequence[Any] or None
        What ``run`` converges to; by default successive runs are compared.
    """
    steps, sizes = [first], []
    previous = run(first)
    if target is not None:
        sizes.append(_norm(previous, target))
    orders: list[float] = []
    extrapolated: list[float] = []
    settled = False
    while not settled and steps[-1] * 2 <= most:
        steps.append(steps[-1] * 2)
        current = run(steps[-1])
        sizes.append(_norm(current, previous if target is None else target))
        previous = current
        if len(sizes) > 1:
            orders.append(_log2_ratio(sizes[-2], sizes[-1]))
        if len(orders) > 1:
            best, settled = _extrapolate(orders)
            extrapolated.append(best)
    order = extrapolated[-1] if extrapolated else math.nan
    return ConvergenceRecord(
        tuple(steps),
        tuple(float(x) for x in sizes),
        tuple(orders),
        tuple(extrapolated),
        order,
        settled,
    )


def _extrapolate(orders: Sequence[float]) -> tuple[float, bool]:
    """Remove the leading errors of the orders; return the result and whether it is settled.

    Orders differ from their limit by a series in h, and h halves from one to the next: each column
    of Neville's scheme removes one power more. A missing odd power only wastes a column. Two orders
    may agree by accident where the series turns round; so a column counts as settled where its last
    value agrees with the one above it and with the column before, and orders as measured only where
    three of them agree much better. Aitken's process serves where a higher power is the first that
    matters; it must agree twice as well. What agrees best is the result.
    """
    columns = [list(orders)]
    while len(columns[-1]) > 1 and len(columns) < COLUMNS:
        power = 2 ** len(columns)
        columns.append([b + (b - a) / (power - 1) for a, b in pairwise(columns[-1])])
    best, spread = columns[-1][-1], math.inf
    if len(orders) > 2:
        found = 4 * (max(orders[-3:]) - min(orders[-3:]))
        if found < spread:
            best, spread = orders[-1], found
    for before, column in pairwise(columns):
        if len(column) > 1:
            found = max(abs(column[-1] - column[-2]), abs(column[-1] - before[-1]))
            if found < spread:
                best, spread = column[-1], found
    if len(orders) > 3:
        before, last = _aitken(orders[:-1]), _aitken(orders)
        found = 2 * max(abs(last - before), abs(last - orders[-1]))
        if found < spread:
            best, spread = last, found
    return best, spread < AGREEMENT and abs(best - orders[-1]) < NEARNESS


def _aitken(orders: Sequence[float]) -> float:
    """Return the limit of the last three orders by Aitken's process; NaN where there is none."""
    a, b, c = orders[-3:]
    if not 1.8 * abs(c - b) < abs(b - a):
        return math.nan
    return c - (c - b) ** 2 / ((c - b) - (b - a))


def _norm(a: Sequence[Any], b: Sequence[Any]) -> Any:
    """Return the Euclidean distance, which unlike the maximum is smooth in h."""
    return sum(abs(x - y) ** 2 for x, y in zip(a, b, strict=True)) ** 0.5


def _log2_ratio(coarse: Any, fine: Any) -> float:
    """Return log2(coarse / fine) for floats or mpmath numbers, NaN where a difference vanished."""
    if not fine or not coarse:
        return math.nan
    return math.log2(float(coarse / fine))


def _digits(order: int, finest: float) -> int:
    """Return digits that keep differences at the finest usual step above round-off.

    Differences are about ``finest^(p + 1)`` where a run of order p settles, times a constant that
    may be small, and a ratio is wanted to four digits.
    """
    return 12 + math.ceil((order + 1) * -math.log10(finest))


def method_order(method: Method, problem: Problem, *, expected: int) -> ConvergenceRecord:
    """Measure the order of the first value, the solution, when started by iteration.

    The problem is nonlinear. The expected order sets precision and passes of the start, nothing
    else: a lower order is seen as such, and a higher one too (up to two more).
    """
    return observed_order(_run(method, problem, expected))


def effective_order(method: Method, *, expected: int) -> ConvergenceRecord:
    """Measure the order that start and finish can reach, on an isochronous problem.

    A pair is measured on a separable problem; ``expected`` as in :func:`method_order`.
    """
    if method.parts == 2:
        problem, turns = isochronous_separable(), 1
    else:
        problem, turns = isochronous_threefold(), 3
    run = _run(method, problem, expected, turns)
    # steps in the period, or in its third
    return observed_order(run, first=2 * FIRST, most=256 * FIRST, target=run(0))


def _run(
    method: Method, problem: Problem, expected: int, turns: int = 0
) -> Callable[[int], Sequence[Any]]:
    """Return n -> solution after n steps of :data:`LENGTH`, or of the period 2 pi over ``turns``.

    With several turns the problem has two components, and run(0) is the start turned by one.
    """
    finest = 2 * math.pi / turns / (128 * FIRST) if turns else float(LENGTH) / 100
    engine = stepper(method, problem, digits=_digits(expected, finest))
    underlying = Underlying(engine, conjugate=turns > 0)
    context = engine.arithmetic.context
    if turns:
        length = 2 * context.pi / turns
    else:
        length = context.mpf(LENGTH.numerator) / LENGTH.denominator
    y0 = engine.problem.y0

    def run(n: int) -> Sequence[Any]:
        if n == 0 and turns > 1:
            c, s = context.cos(length), context.sin(length)
            return [c * y0[0] - s * y0[1], s * y0[0] + c * y0[1]]
        if n == 0:
            return list(y0)
        h = length / n
        values = underlying.start(context.mpf(0), y0, h, order=expected + 1)
        return list(underlying.solution(underlying.run(context.mpf(0), values, h, n)))

    return run


#: Problems of ``named.toml`` whose solutions have one period, 2 pi; they are in no list.
isochronous = builder("isochronous")
isochronous_threefold = builder("isochronous-threefold")
isochronous_separable = builder("isochronous-separable")
