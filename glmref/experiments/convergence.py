"""Observed order: differences of runs at halved step sizes, in extended precision.

With runs at n, 2n and 4n steps, ``log2(|y_n - y_2n| / |y_2n - y_4n|)`` tends to the order p with an
error of first order in h (second order for symmetric methods). One Richardson step on that sequence
removes it, so that a few doublings give p to a few hundredths. No reference solution takes part.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

__all__ = ["ConvergenceRecord", "observed_order"]

#: Two successive extrapolated orders that agree to this count as settled.
AGREEMENT = 0.02


@dataclass(frozen=True, slots=True)
class ConvergenceRecord:
    """Orders seen at successive doublings of the number of steps.

    Attributes
    ----------
        steps: numbers of steps, each twice the one before.
        differences: ``|y_n - y_2n|`` for each n but the last.
        orders: base-2 logarithms of successive ratios of differences.
        extrapolated: the orders after one Richardson step.
        order: the last extrapolated order.
        settled: whether the last two extrapolated orders agree to :data:`AGREEMENT`.
    """

    steps: tuple[int, ...]
    differences: tuple[float, ...]
    orders: tuple[float, ...]
    extrapolated: tuple[float, ...]
    order: float
    settled: bool


def observed_order(
    run: Callable[[int], Sequence[object]],
    *,
    first: int = 8,
    most: int = 512,
    distance: Callable[[Sequence[object], Sequence[object]], object] | None = None,
) -> ConvergenceRecord:
    """Measure the order of ``run(n)``, the numerical solution at a fixed time after n steps.

    The number of steps doubles until two extrapolated orders agree, or ``most`` is reached.

    Args:
        run: n -> components, in a precision high enough that no difference reaches round-off.
        first: the first number of steps.
        most: the largest number of steps.
        distance: norm of the difference of two results; the maximum norm when not given.
    """
    norm = distance or _maximum_norm
    steps, differences = [first], []
    previous = run(first)
    orders: list[float] = []
    extrapolated: list[float] = []
    while steps[-1] * 2 <= most:
        steps.append(steps[-1] * 2)
        current = run(steps[-1])
        differences.append(norm(previous, current))
        previous = current
        if len(differences) > 1:
            orders.append(_log2_ratio(differences[-2], differences[-1]))
        if len(orders) > 1:
            extrapolated.append(2 * orders[-1] - orders[-2])
        if len(extrapolated) > 1 and abs(extrapolated[-1] - extrapolated[-2]) < AGREEMENT:
            break
    order = extrapolated[-1] if extrapolated else math.nan
    settled = len(extrapolated) > 1 and abs(extrapolated[-1] - extrapolated[-2]) < AGREEMENT
    return ConvergenceRecord(
        tuple(steps),
        tuple(float(x) for x in differences),
        tuple(orders),
        tuple(extrapolated),
        order,
        settled,
    )


def _maximum_norm(a: Sequence[object], b: Sequence[object]) -> object:
    return max(abs(x - y) for x, y in zip(a, b, strict=True))  # type: ignore[operator]


def _log2_ratio(coarse: object, fine: object) -> float:
    """Return log2(coarse / fine) for floats or mpmath numbers, NaN where a difference vanished."""
    if not fine or not coarse:
        return math.nan
    return math.log2(float(coarse / fine))  # type: ignore[operator]
