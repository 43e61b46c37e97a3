"""Newton from many starts at once, in double precision, reproducible from a seed and resumable.

The equations are the judge's, for any scalar. Here a scalar is a numpy array: axis 0 runs over
starts, axis 1 over the unknowns, each perturbed by an imaginary ``STEP``;
the imaginary part of a result divided by it is the derivative, exact to round-off (complex step,
Squire and Trapp 1998). One evaluation of Python code so serves all starts and the whole Jacobian.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..exact.field import Arithmetic
from ..exact.judging import Fraction, as_scalar
from ..judge.arithmetic import Ring

#: Imaginary perturbation: its square vanishes beside any number met here.
STEP = 1e-40

Residuals = Callable[[Sequence[Any]], Sequence[Any]]


class Batch(Arithmetic, Ring):
    """An array with the operations of a number of the judge; zero is never known of it."""

    __slots__ = ("array",)

    def __init__(self, array: Any) -> None:
        self.array = array

    @staticmethod
    def dot(pairs: Iterable[tuple[Any, Any]]) -> Any:
        """Return sum x_i y_i; what is exact in it is summed exactly."""
        found, rest = None, Fraction(0)
        for x, y in pairs:
            if type(x) is Batch or type(y) is Batch:
                term = _array(x) * _array(y)
                found = term if found is None else found + term
            else:
                rest = rest + x * y
        return rest if found is None else Batch(found + _array(rest) if rest else found)

    def _binary(self, other: Any, operation: Any) -> Batch:
        return Batch(operation(self.array, _array(other)))

    def __neg__(self) -> Batch:
        return Batch(-self.array)

    def inverse(self) -> Batch:
        """Return 1 / x."""
        return Batch(1 / self.array)


_FLOATS: dict[int, tuple[Any, float]] = {}


def _array(value: Any) -> Any:
    """Return the array, or a number as a float; that of the same object is converted once."""
    if type(value) is Batch:
        return value.array
    known = _FLOATS.get(id(value))
    if known is None or known[0] is not value:
        if len(_FLOATS) > 10_000:
            _FLOATS.clear()
        known = _FLOATS[id(value)] = (value, float(as_scalar(value)))
    return known[1]


def evaluate(residuals: Residuals, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return values (starts, m) and Jacobians (starts, m, n) of a system at points (starts, n)."""
    starts, n = points.shape
    columns = []
    for j in range(n):
        column = np.repeat(points[:, j : j + 1], n, axis=1).astype(complex)
        column[:, j] += 1j * STEP
        columns.append(Batch(column))
    with np.errstate(all="ignore"):
        found = [np.broadcast_to(_array(x), (starts, n)) for x in residuals(columns)]
    stacked = np.stack(found, axis=1).astype(complex)
    return np.real(stacked[:, :, 0]).copy(), np.imag(stacked) / STEP


def levenberg_marquardt(
    residuals: Residuals,
    points: np.ndarray,
    *,
    iterations: int = 150,
    tolerance: float = 1e-13,
) -> tuple[np.ndarray, np.ndarray]:
    """Run damped least squares from all rows of ``points`` at once, independently of each other.

    The damping of a row falls by 5 after a step that helps and grows by 6 after one that does not.
    Returns points (starts, n) and the largest absolute residual (starts,) of each.
    """
    points = np.array(points, dtype=float)
    n = points.shape[1]
    values, jacobian = evaluate(residuals, points)
    cost = _cost(values)
    damping = np.full(len(points), 1e-2)
    alive = np.isfinite(cost)
    for _ in range(iterations):
        rows = np.flatnonzero(alive & (np.abs(values).max(axis=1) > tolerance) & (damping < 1e10))
        if not len(rows):
            break
        J, f = jacobian[rows], values[rows]
        gram = np.einsum("kij,kil->kjl", J, J)
        diagonal = np.einsum("kjj->kj", gram) + 1e-12
        gram[:, np.arange(n), np.arange(n)] += damping[rows, None] * diagonal
        step = np.linalg.solve(gram, -np.einsum("kij,ki->kj", J, f)[..., None])[..., 0]
        trial = points[rows] + step
        new_values, new_jacobian = evaluate(residuals, trial)
        new_cost = _cost(new_values)
        better = np.isfinite(new_cost) & (new_cost < cost[rows])
        good = rows[better]
        points[good], values[good] = trial[better], new_values[better]
        jacobian[good], cost[good] = new_jacobian[better], new_cost[better]
        damping[good] = np.maximum(damping[good] * 0.2, 1e-14)
        damping[rows[~better]] *= 6.0
    return points, np.abs(values).max(axis=1)


def _cost(values: np.ndarray) -> np.ndarray:
    with np.errstate(all="ignore"):
        cost = np.einsum("ki,ki->k", values, values)
    return np.where(np.isfinite(cost), cost, np.inf)


@dataclass(frozen=True)
class Found:
    """Where one start ended."""

    number: int  #: Which start: the draw depends on the seed and on this alone.
    point: tuple[float, ...]  #: (n,) unknowns.
    residual: float  #: Largest absolute residual.


def search(
    residuals: Residuals,
    draw: Callable[[np.random.Generator], np.ndarray],
    *,
    seed: int,
    starts: int,
    first: int = 0,
    iterations: int = 150,
    batch: int = 32,
    progress: Callable[[int, int], None] | None = None,
) -> Iterator[Found]:
    """Run :func:`levenberg_marquardt` from random starts, and yield where each ended, in order.

    Start k is drawn from ``numpy.random.default_rng([seed, k])``; ``first`` is the number of the
    first, to resume a search that was stopped. ``progress`` is called with (done, starts) after
    each batch. The system may have more unknowns than equations.
    """
    numbers = range(first, first + starts)
    for at in range(0, starts, batch):
        part = numbers[at : at + batch]
        points = np.stack([draw(np.random.default_rng([seed, k])) for k in part])
        ends, sizes = levenberg_marquardt(residuals, points, iterations=iterations)
        for k, point, size in zip(part, ends, sizes, strict=True):
            yield Found(k, tuple(map(float, point)), float(size))
        if progress is not None:
            progress(at + len(part), starts)
