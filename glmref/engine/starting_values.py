"""Starting values: from the method's data, by iteration, or given.

The *enhanced start* needs no data. With S_0(y) = u y and M one step,

    S_{k+1}(y) = S_k(y) + K^-1 [M S_k(y) - S_k(w M S_k(y))],    K = I - V + u w V,

w the output functional, each pass gains one order in what the solution w S(y) = y leaves open, and
k passes cost 2^k - 1 steps. Where the solution is one of the values, that row is left out of K.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..catalogue.claims import G_SYMPLECTIC, ORDER, SYMMETRIC
from ..errors import GlmrefError, UsageError
from ..exact.linalg import identity
from ..method import Component, Method
from ..method.preconsistency import preconsistency_vector
from ..problems.model import Problem
from ..problems.user_functions import raised
from ..system.arguments import shown, whole
from .outcome import StartFailed
from .reference import Reader, Stepper, apply_start

#: Passes of the enhanced start where the method's file claims no order.
DEFAULT_PASSES = 4
MOST_PASSES = 8
#: Steps between renewals that long runs are recommended to take, see docs/choose.md.
RENEWAL = 10_000


@dataclass(frozen=True, eq=False)
class Start:
    """Starting values, what they cost and where they come from.

    ``evaluations`` counts as :class:`.reference.Step` does: of k alone for a pair on a separable
    problem.
    """

    values: np.ndarray
    evaluations: int
    kind: str


def starting_values(
    engine: Stepper,
    start: Any,
    *,
    t: Any,
    y0: np.ndarray,
    h: Any,
) -> Start:
    """Compute the values carried into the first step, in the arithmetic of the run.

    ``start`` is ``None`` (the method's own starting method, else the enhanced start where r > 1),
    ``"enhanced"`` or ``("enhanced", passes)``, ``"zero"`` for (y0, 0, ...), a
    :class:`StartingMethod`, for a pair a :class:`PairStartingMethod`, values (r, d), or a function
    ``start(problem, h)`` that returns them.

    Raises
    ------
    UsageError
        For a start that does not fit the method.
    """
    method = engine.method
    if start is None:
        start = method.starting or ("enhanced" if engine.shape[0] > 1 else "zero")
    if isinstance(start, Method):
        if start.parts != method.parts:
            raise UsageError(
                "a pair starts from the starting method of a pair, and that starts pairs only; "
                "give another start, or values"
            )
        values, evaluations = apply_start(start, engine, t, y0, h)
        return Start(values, evaluations, start.name or "runge-kutta")
    if isinstance(start, str) and start == "zero":
        return Start(zero_start(engine, y0), 0, "zero")
    passes = default_passes(method) if isinstance(start, str) else None
    if isinstance(start, tuple) and len(start) == 2 and isinstance(start[0], str):
        start, passes = start
    if isinstance(start, str):
        if start != "enhanced":
            raise UsageError(
                "`start` must be 'enhanced', ('enhanced', passes), 'zero', a starting method or "
                f"values, got {shown(start)}"
            )
        passes = whole("passes", passes, 0, MOST_PASSES)
        values, evaluations = enhanced_start(engine, t, y0, h, passes)
        return Start(values, evaluations, f"enhanced, {passes} passes")
    if callable(start):
        try:
            start = start(engine.problem, h)
        except GlmrefError:
            raise
        except Exception as error:
            raise raised("start", error) from error
    return Start(_checked(start, engine), 0, "given")


def renewal_of(method: Method) -> int:
    """Return the steps after which a long run should renew its values, 0 for never.

    Parasitic parts neither grow nor decay to first order in h where a method with several values is
    G-symplectic or symmetric; a strictly stable method damps them by itself.
    """
    kept = any(method.claims.get(claim.key) is True for claim in (G_SYMPLECTIC, SYMMETRIC))
    return RENEWAL if method.carried > 1 and kept else 0


def default_passes(method: Method) -> int:
    """Return as many passes of the starting method as its claimed order, within limits."""
    order = method.claims.get(ORDER.key, DEFAULT_PASSES)
    return min(MOST_PASSES, order) if isinstance(order, int) else DEFAULT_PASSES


def _checked(values: Any, engine: Stepper) -> np.ndarray:
    context = engine.arithmetic.context
    array = array_of(values, "starting values", engine.shape, f"(r, d) = {engine.shape}", context)
    if array.dtype.kind == "c" and not np.iscomplexobj(engine.V):
        raise UsageError("starting values must be real for a real method, got complex ones")
    if not engine.in_range(array):
        raise StartFailed("starting values must be finite; give others, or use a smaller h")
    return array


def array_of(
    values: Any, what: str, shape: tuple[int | None, ...], written: str, context: Any = None
) -> np.ndarray:
    """Return numbers as an array of their own: of doubles, complex, or of an mpmath context.

    Messages call them ``what``, with the shape as ``written``; ``None`` in ``shape`` is an axis of
    any length but 0.

    Raises
    ------
    UsageError
        Naming ``what``, where they are no numbers, or not of this shape. Nothing is copied
        then: an array that repeats one number may have any size.
    """
    try:
        array = np.asarray(values, dtype=None if context is None else object)
        masked = isinstance(values, np.ma.MaskedArray) and values.mask.any()
        if masked or array.dtype.kind not in "fiucO":
            raise TypeError
        fits = array.ndim == len(shape) and all(
            n == m if m is not None else n for n, m in zip(array.shape, shape, strict=True)
        )
        if not fits:
            raise UsageError(f"{what} must have shape {written}, got {array.shape}")
        if context is None:
            return array.astype(complex if array.dtype.kind == "c" else float)
        out = np.empty(array.shape, dtype=object)
        for place, x in np.ndenumerate(array):
            out[place] = context.mpmathify(complex(x) if isinstance(x, np.complexfloating) else x)
            if isinstance(x, str | bytes):
                raise TypeError
        return out
    except UsageError:
        raise
    except Exception:  # whatever a class of the user raises
        raise UsageError(f"{what} must be an array of numbers, got {shown(values)}") from None


def zero_start(engine: Stepper, y0: np.ndarray) -> np.ndarray:
    """Return u y0: (y0, 0, ..., 0) where the first value is the solution and the others small.

    From y0 (d,), or (N, d) for N starts at once, values (r, d) or (N, r, d).
    """
    y0 = np.asarray(y0)
    shape = (*y0.shape[:-1], *engine.shape)
    values = engine.arithmetic.zeros(shape, y0 if np.iscomplexobj(y0) else engine.V)
    for (columns, _, _), m in zip(engine.readers, engine.method.carriers, strict=True):
        u = preconsistency_vector(m)
        factors = [1] if u is None else engine.arithmetic.array((u,))[0]
        for k, factor in enumerate(factors):
            if abs(factor) > 1e-40:
                values[..., k, columns] = factor * y0[..., columns]
    return values


def kernel_of(engine: Stepper, m: Component, weights: np.ndarray) -> np.ndarray:
    """Return K = I - V + u w V, (r, r), of a component read by the weights w.

    Raises
    ------
    UsageError
        Where no u has V u = u and U u = 1.
    """
    u = preconsistency_vector(m)
    if u is None:
        raise UsageError(
            "the enhanced start needs a preconsistent method (V u = u, U u = 1); give starting "
            "values or a starting method"
        )
    v = engine.arithmetic.array(m.V)
    found = np.outer(engine.arithmetic.array((u,))[0], weights.dot(v)) - v
    for k in range(len(v)):
        found[k, k] = found[k, k] + 1
    return found


def corrector(
    engine: Stepper, readers: Sequence[Reader] | None = None
) -> Callable[[np.ndarray], np.ndarray]:
    """Return the map from a defect (..., r, d) to the correction of what is not the solution.

    The solution is read off as ``readers`` say, by default as the engine does.
    """
    parts, arithmetic = [], engine.arithmetic
    for (columns, place, weights), m in zip(
        readers or engine.readers, engine.method.carriers, strict=True
    ):
        matrix = kernel_of(engine, m, weights)
        # the rows solved for: without the solution where that is one of the values, else all
        rows = [k for k in range(len(matrix)) if k != place]
        matrix = matrix[np.ix_(rows, rows)]
        if rows and arithmetic.context is not None:  # elimination costs more than a step: once
            matrix = arithmetic.solve(matrix, arithmetic.array(identity(len(rows))))
        parts.append((columns, rows, matrix))

    def correct(defect: np.ndarray) -> np.ndarray:
        change = 0 * defect
        for columns, rows, matrix in parts:
            if rows:
                right = np.moveaxis(defect[..., rows, columns], -2, 0)
                flat = right.reshape(len(rows), -1)
                doubles = arithmetic.context is None
                solved = arithmetic.solve(matrix, flat) if doubles else matrix.dot(flat)
                change[..., rows, columns] = np.moveaxis(solved.reshape(right.shape), 0, -2)
        return change

    return correct


def enhanced_start(
    engine: Stepper, t: Any, y0: np.ndarray, h: Any, passes: int,
    step: Callable[[int, np.ndarray], tuple[np.ndarray, int]] | None = None,
) -> tuple[np.ndarray, int]:  # fmt: skip
    """Return the values of the enhanced start and the right-hand-side evaluations they cost.

    That is 2^k - 1 steps for k passes: ``step(n, values)`` takes the one from time t + n h and
    returns the values after it and its evaluations; by default the engine does.

    Raises
    ------
    UsageError
        When the method is not preconsistent, or a trial step fails.
    """
    correct, evaluations = corrector(engine), 0

    def by_engine(n: int, values: np.ndarray) -> tuple[np.ndarray, int]:
        taken = engine.step(t + n * h, values, h)
        if not taken.converged:
            raise StartFailed("a trial step of the enhanced start failed; use a smaller h")
        return taken.values, taken.evaluations

    def start(k: int, n: int, y: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        if k == 0:
            return zero_start(engine, y)
        values = start(k - 1, n, y)
        after, spent = (step or by_engine)(n, values)
        evaluations += spent
        return values + correct(after - start(k - 1, n + 1, engine.solution(after)))

    return start(passes, 0, y0), evaluations


def problem_start(problem: Problem, engine: Stepper) -> tuple[Any, np.ndarray]:
    """Return the initial time and value in the arithmetic of the engine."""
    t0 = engine.arithmetic.number(problem.t_span[0])
    return t0, np.array(engine.problem.y0)
