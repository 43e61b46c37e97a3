"""Number types of the reference engine, and its stage solver.

Double precision is numpy; anything else is an mpmath context of its own, because the global one is
shared between threads.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..exact.linalg import Matrix
from ..problems.model import Problem
from .memory import NEWTON_BYTES
from .outcome import is_finite

_ROUNDS = 200  # fixed-point rounds before Newton takes over, Newton rounds before giving up
_STALLS = 3  # rounds without decrease that end an iteration which is not yet at round-off
#: Change of a stage, relative to the state, that a right-hand side that cancels may leave when it
#: has stalled: in double precision; with more digits the same part of them.
NOISE = 2.0**-30


def in_order(weights: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the sum (..) of rows (m, ..) by weights (m,), term by term.

    The bits depend neither on the processor, as those of a product of matrices do, nor on how many
    columns are summed at once.
    """
    read = weights.nonzero()[0]
    if not len(read):
        return np.zeros(rows.shape[1:], dtype=np.result_type(weights, rows))
    if rows.ndim == 2:  # one state: a few long calls
        return np.add.accumulate(weights[read, None] * rows[read])[-1]
    # in this order of the axes the last one, the longest, is the inner loop
    shape, dtype = rows.shape[1:], np.result_type(weights, rows)
    total, term = np.empty(shape, dtype), np.empty(shape, dtype)
    np.multiply(rows[read[0]], weights[read[0]], out=total)
    for j in read[1:]:
        total += np.multiply(rows[j], weights[j], out=term)
    return total


def solution_of(weights: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return the sum (d,) or (n, d) of values (r, d) or (n, r, d) by weights (r,), term by term."""
    if values.ndim == 2:
        return in_order(weights, values)
    if len(values) == 1:
        return in_order(weights, values[0])[None]
    return in_order(weights, values.transpose(1, 2, 0)).T


class Arithmetic:
    """Double precision, or an mpmath context of its own with the digits asked for."""

    def __init__(self, digits: int | None) -> None:
        self.digits = digits
        self.context: Any = None
        #: Rows of tableaux in doubles, by identity: an algebraic number takes long to round.
        self._rounded: dict[int, tuple[Any, list[Any]]] = {}
        if digits is not None:
            import mpmath  # only here: a run in double precision does not load it

            self.context = mpmath.MPContext()
            self.context.dps = digits

    @property
    def epsilon(self) -> Any:
        """Distance from 1 to the next number."""
        return 2.0**-52 if self.context is None else self.context.eps

    def number(self, x: Any) -> Any:
        """Round a scalar of a tableau (or a real number) once."""
        if self.context is None:
            return complex(x) if hasattr(x, "is_real") and not x.is_real() else float(x)
        if not hasattr(x, "to_mpf"):
            return self.context.mpf(x)
        import mpmath

        with mpmath.workdps(self.context.dps + 5):
            return self.context.convert(x.to_mpf())

    def array(self, matrix: Matrix) -> np.ndarray:
        """Round a matrix entry by entry."""
        if self.context is None:
            return np.array([self._row(row) for row in matrix])
        rows = [[self.number(x) for x in row] for row in matrix]
        out = np.empty((len(rows), len(rows[0]) if rows else 0), dtype=object)
        for i, row in enumerate(rows):
            out[i, :] = row
        return out

    def _row(self, row: Any) -> list[Any]:
        known, found = self._rounded.get(id(row), (None, []))
        if known is not row:
            # most entries of a long row are one zero
            numbers = {id(x): self.number(x) for x in {id(x): x for x in row}.values()}
            found = [numbers[id(x)] for x in row]
            if isinstance(row, tuple):  # the tuple is kept, so that its identity stays its own
                self._rounded[id(row)] = row, found
        return found

    def zeros(self, shape: tuple[int, ...], like: np.ndarray | None = None) -> np.ndarray:
        """Return zeros of the number type (complex where ``like`` is)."""
        if self.context is None:
            complex_ = like is not None and np.iscomplexobj(like)
            return np.zeros(shape, dtype=complex if complex_ else float)
        out = np.empty(shape, dtype=object)
        out[...] = self.context.mpf(0)
        return out

    # -- the sums of a step. Arrays stand left of h: an mpmath number there would format the whole
    # array for an unused message before it lets numpy multiply.

    def known(self, U: np.ndarray, values: np.ndarray) -> Sequence[Any]:
        """Return what stages take from the values, ``U y``: (n, d)."""
        return U.dot(values)

    def stage(self, known: Any, driving: Sequence[tuple[np.ndarray, np.ndarray]], h: Any) -> Any:
        """Return a stage, ``known + h sum a F`` over rows a and slopes F that drive it: (d,)."""
        (row, slopes), *more = driving
        total = row.dot(slopes) * h
        for row, slopes in more:
            total = total + row.dot(slopes) * h
        return known + total

    def updated(
        self, B: np.ndarray, slopes: np.ndarray, h: Any, V: np.ndarray, values: np.ndarray
    ) -> np.ndarray:
        """Return values after a step, ``h B F + V y``: (r, d)."""
        return B.dot(slopes) * h + V.dot(values)

    @property
    def ordered(self) -> Arithmetic:
        """With doubles, arithmetic whose sums of slopes are taken term by term."""
        return _Ordered(None) if type(self) is Arithmetic and self.context is None else self

    def localised(self, problem: Problem) -> Problem:
        """Return the problem in this arithmetic."""
        return problem if self.context is None else problem.on(self.context)

    def solve(self, matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Solve a linear system for (n,) or (n, m), by elimination with partial pivoting."""
        if self.context is None:
            return np.linalg.solve(matrix, right)
        a, b = matrix.copy(), right.copy()
        n = len(b)
        for k in range(n):
            p = max(range(k, n), key=lambda i: abs(a[i, k]))
            if a[p, k] == 0:
                raise np.linalg.LinAlgError("singular matrix")
            a[[k, p]], b[[k, p]] = a[[p, k]], b[[p, k]]
            for i in range(k + 1, n):
                factor = a[i, k] / a[k, k]
                a[i, k:] = a[i, k:] - factor * a[k, k:]
                b[i] = b[i] - factor * b[k]
        for k in reversed(range(n)):
            for j in range(k + 1, n):
                b[k] = b[k] - a[k, j] * b[j]
            b[k] = b[k] / a[k, k]
        return b


class _Ordered(Arithmetic):
    """Double precision with :func:`in_order`."""

    def stage(self, known: Any, driving: Sequence[tuple[np.ndarray, np.ndarray]], h: Any) -> Any:
        return known + sum(in_order(row, slopes) * h for row, slopes in driving)

    def updated(
        self, B: np.ndarray, slopes: np.ndarray, h: Any, V: np.ndarray, values: np.ndarray
    ) -> np.ndarray:
        if not B.shape[1]:
            return V.dot(values)
        # all rows at once: what a row does not read adds zeros, and no slope here is infinite that
        # does not make another value infinite
        return np.add.accumulate(B.T[:, :, None] * slopes[:, None])[-1] * h + V.dot(values)


def size(x: np.ndarray) -> Any:
    """Return the largest magnitude of an entry."""
    if x.dtype == float:
        largest = float(np.abs(x).max(initial=0.0))
        if largest == largest:
            return largest
    return max((abs(v) for v in x.ravel()), default=0)


class StageSolver:
    """Solves x = F(x), x the slopes of one block, to round-off."""

    def __init__(self, arithmetic: Arithmetic) -> None:
        self.arithmetic = arithmetic
        self.iterations = 0
        self.converged = True

    def __call__(
        self, function: Callable[[np.ndarray], np.ndarray], x: np.ndarray, scale: Any,
        alike: Sequence[int] = (),
    ) -> np.ndarray:  # fmt: skip
        """Iterate from x. A change below a few units of ``scale`` counts as round-off.

        ``alike`` numbers the entries of x (as it is flattened): those with one number are slopes of
        one component of the state, and have one size; by default each has a size of its own.

        Fixed point first; where that does not contract, Newton with a difference quotient matrix
        (unless that matrix is beyond :data:`.memory.NEWTON_BYTES`: then it has not converged).
        """
        settled, result = self._settle(function, x, scale)
        if settled:
            return result
        if 8 * x.size**2 > NEWTON_BYTES:
            self.converged = False
            return x
        settled, result = self._settle(self._newton(function, x, alike), x, scale)
        self.converged &= settled
        return result

    def _settle(
        self, update: Callable[[np.ndarray], np.ndarray], x: np.ndarray, scale: Any
    ) -> tuple[bool, np.ndarray]:
        """Apply ``update`` until the change is zero, or is round-off and no longer decreases.

        A change that has stalled is settled up to the limit of the compiled engine, 2^-30 in
        double precision: a right-hand side that cancels leaves no fewer digits.
        """
        round_off = 64 * self.arithmetic.epsilon * scale
        noise = self.arithmetic.epsilon ** (-math.log2(NOISE) / 52) * scale
        last, stalls = None, 0
        for _ in range(_ROUNDS):
            try:
                new = update(x)
            except (ArithmeticError, ValueError, np.linalg.LinAlgError):
                return False, x
            self.iterations += 1
            change = size(new - x)
            x = new
            if not is_finite(change):
                return False, x
            if change == 0:
                return True, x
            if last is not None and change >= last:
                if change <= round_off:
                    return True, x
                stalls += 1
                if stalls > _STALLS:
                    return bool(change <= noise), x
            last = change
        return False, x

    def _newton(
        self, function: Callable[[np.ndarray], np.ndarray], x: np.ndarray, alike: Sequence[int]
    ) -> Callable[[np.ndarray], np.ndarray]:
        """Return the simplified Newton update, its matrix by differences at the first guess."""
        matrix: list[np.ndarray] = []

        def residual(x: np.ndarray) -> np.ndarray:
            return (x - function(x)).ravel()

        def update(x: np.ndarray) -> np.ndarray:
            defect = residual(x)
            if not matrix:
                matrix.append(self._differences(residual, x, defect, alike))
            return x - self.arithmetic.solve(matrix[0], defect).reshape(x.shape)

        return update

    def _differences(
        self, residual: Callable[[np.ndarray], np.ndarray], x: np.ndarray, at: np.ndarray,
        alike: Sequence[int],
    ) -> np.ndarray:  # fmt: skip
        """Return difference quotients of the residual, whose value at x is ``at``.

        The first slope of a stiff system may be zero where that of the next stage is 1e9 and the
        residual 1e18, which hides a step taken from the first one alone: the matrix is singular.
        """
        flat = x.ravel()
        columns = []
        sizes: dict[int, Any] = {}
        group = alike or range(len(flat))
        for number, value in zip(group, flat, strict=True):
            sizes[number] = max(sizes.get(number, 0), abs(value))
        for k, number in enumerate(group):
            step = self.arithmetic.epsilon**0.5 * (sizes[number] + 1)
            moved = flat.copy()
            moved[k] = moved[k] + step
            columns.append((residual(moved.reshape(x.shape)) - at) / step)
        return np.stack(columns, axis=1)
