"""Starting values: from the method's data, by iteration, or given.

The *enhanced start* needs no data. With S_0(y) = u y and M one step,

    S_{k+1}(y) = S_k(y) + K^-1 [M S_k(y) - S_k(w M S_k(y))],    K = I - V + u w V,

w the output functional, each pass gains one order in what the solution w S(y) = y leaves open, and
k passes cost 2^k - 1 steps. Where the solution is one of the values, that row is left out of K.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..catalogue.claims import G_SYMPLECTIC, ORDER, SYMMETRIC
from ..errors import UsageError
from ..method import Component, Method
from ..method.preconsistency import preconsistency_vector
from ..problems.model import Problem
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
    """Compute the values carried into the first step.

    Parameters
    ----------
    engine : Stepper
        Stepper of the method on the problem, in the arithmetic of the run.
    start : Any
        ``None``: the method's own starting method, else the enhanced start where r > 1;
        ``"enhanced"`` or ``("enhanced", passes)``; ``"zero"``: (y0, 0, ...); a
        :class:`StartingMethod`, for a pair a :class:`PairStartingMethod`; values (r, d); or
        ``start(problem, h)`` that returns them.
    t, y0, h
        Initial time and value, step size.

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
    named = start[:1] if isinstance(start, tuple) else (start,) if isinstance(start, str) else ()
    if named == ("enhanced",):
        passes = start[1] if isinstance(start, tuple) else default_passes(method)
        values, evaluations = enhanced_start(engine, t, y0, h, passes)
        return Start(values, evaluations, f"enhanced, {passes} passes")
    if callable(start):
        return Start(_checked(start(engine.problem, h), engine), 0, "given")
    if isinstance(start, str):
        raise UsageError(
            f"`start` must be enhanced, zero, a starting method or values, got {start!r}"
        )
    return Start(_checked(start, engine), 0, "given")


def renewal_of(method: Method) -> int:
    """Steps after which a long run should make the values anew, 0 for never.

    Parasitic parts neither grow nor decay to first order in h where a method with several values is
    G-symplectic or symmetric; a strictly stable method damps them by itself.
    """
    kept = any(method.claims.get(claim.key) is True for claim in (G_SYMPLECTIC, SYMMETRIC))
    return RENEWAL if method.carried > 1 and kept else 0


def default_passes(method: Method) -> int:
    """As many passes of the starting method as its claimed order, within limits."""
    order = method.claims.get(ORDER.key, DEFAULT_PASSES)
    return min(MOST_PASSES, order) if isinstance(order, int) else DEFAULT_PASSES


def _checked(values: Any, engine: Stepper) -> np.ndarray:
    try:
        array = np.array(values, dtype=object if engine.arithmetic.context else None)
    except ValueError:
        raise UsageError(
            "starting values must be an array (r, d), got rows of unlike length"
        ) from None
    if array.shape != engine.shape:
        raise UsageError(
            f"starting values must have shape (r, d) = {engine.shape}, got {array.shape}"
        )
    if engine.arithmetic.context is not None:
        return array
    like = _complex_like(engine)
    if np.iscomplexobj(array) and (like is None or not np.iscomplexobj(like)):
        raise UsageError("starting values must be real for a real method, got complex ones")
    try:
        array = array.astype(complex if np.iscomplexobj(array) else float)
    except (TypeError, ValueError):
        raise UsageError(f"starting values must be numbers, got {values!r:.60}") from None
    if not np.isfinite(array).all():
        raise StartFailed("starting values must be finite; give others, or use a smaller h")
    return array


def _halves(engine: Stepper) -> list[tuple[Reader, Component]]:
    """How each component of the method is read, and its coefficients."""
    return list(zip(engine.readers, engine.method.carriers, strict=True))


def zero_start(engine: Stepper, y0: np.ndarray) -> np.ndarray:
    """Return u y0: (y0, 0, ..., 0) where the first value is the solution and the others small.

    Parameters
    ----------
    y0 : np.ndarray
        (d,), or (N, d) for N starts at once.

    Returns
    -------
    np.ndarray
        (r, d) or (N, r, d).
    """
    y0 = np.asarray(y0)
    shape = (*y0.shape[:-1], *engine.shape)
    values = engine.arithmetic.zeros(shape, _complex_like(engine))
    for (columns, _, _), m in _halves(engine):
        u = preconsistency_vector(m)
        factors = [1] if u is None else engine.arithmetic.array((u,))[0]
        for k, factor in enumerate(factors):
            if abs(factor) > 1e-40:
                values[..., k, columns] = factor * y0[..., columns]
    return values


def _complex_like(engine: Stepper) -> np.ndarray | None:
    return engine.V


def corrector(engine: Stepper) -> Callable[[np.ndarray], np.ndarray]:
    """Return the map from a defect (..., r, d) to the correction of what is not the solution."""
    parts = []
    for (columns, place, weights), m in _halves(engine):
        exact_u = preconsistency_vector(m)
        if exact_u is None:
            raise UsageError(
                "the enhanced start needs a preconsistent method (V u = u, U u = 1); give starting "
                "values or a starting method"
            )
        v, u = engine.arithmetic.array(m.V), engine.arithmetic.array((exact_u,))[0]
        # the rows solved for: without the solution where that is one of the values, else all
        rows = [k for k in range(len(v)) if k != place]
        matrix = -v[np.ix_(rows, rows)] + np.outer(u[rows], weights.dot(v)[rows])
        for k in range(len(rows)):
            matrix[k, k] = matrix[k, k] + 1
        parts.append((columns, rows, matrix))

    def correct(defect: np.ndarray) -> np.ndarray:
        change = 0 * defect
        for columns, rows, matrix in parts:
            if rows:
                right = np.moveaxis(defect[..., rows, columns], -2, 0)
                flat = right.reshape(len(rows), -1)
                solved = engine.arithmetic.solve(matrix, flat).reshape(right.shape)
                change[..., rows, columns] = np.moveaxis(solved, 0, -2)
        return change

    return correct


def enhanced_start(
    engine: Stepper, t: Any, y0: np.ndarray, h: Any, passes: int
) -> tuple[np.ndarray, int]:
    """Enhanced start: the values and the right-hand-side evaluations they cost.

    Parameters
    ----------
    passes : int
        Number of passes k; the cost is 2^k - 1 steps.

    Raises
    ------
    UsageError
        When the method is not preconsistent, or a trial step fails.
    """
    if not isinstance(passes, int) or not 0 <= passes <= MOST_PASSES:
        raise UsageError(f"the enhanced start takes 0 to {MOST_PASSES} passes, got {passes!r}")
    correct = corrector(engine)
    evaluations = 0

    def start(k: int, time: Any, y: np.ndarray) -> np.ndarray:
        nonlocal evaluations
        if k == 0:
            return zero_start(engine, y)
        values = start(k - 1, time, y)
        taken = engine.step(time, values, h)
        evaluations += taken.evaluations
        if not taken.converged:
            raise StartFailed("a trial step of the enhanced start failed; use a smaller h")
        defect = taken.values - start(k - 1, time + h, engine.solution(taken.values))
        return values + correct(defect)

    return start(passes, t, y0), evaluations


def problem_start(problem: Problem, engine: Stepper) -> tuple[Any, np.ndarray]:
    """Initial time and value in the arithmetic of the engine."""
    t0 = engine.arithmetic.number(problem.t_span[0])
    return t0, np.array(engine.problem.y0)
