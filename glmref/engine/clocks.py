"""Partitioned methods on q' = f(p, t), p' = k(q, t): time as one more component of q and of p.

The problem is solved as the autonomous separable system of :attr:`.Problem.extended`,

    (q, s)' = (f(p, sigma), 1),    (p, sigma)' = (k(q, s), 1),

with s = sigma = t0 at the start; for q'' = g(q, t), where sigma does not occur, the clock of p is
the constant velocity of s. Since the derivatives of s and sigma are constant, a method of order one
or more has s = t_n + c_i h at its stages Q_i and sigma = t_n + c^_i h at its stages P_i exactly,
the abscissae of each part. Every order condition, Nystroem ones included, is one of autonomous
systems and holds for this one.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ..method import Method
from ..problems.model import Problem

if TYPE_CHECKING:
    from .outcome import Solution
    from .runners import EnsembleSolution

Found = TypeVar("Found", "Solution", "EnsembleSolution")


def solved_form(problem: Problem, method: Method) -> Problem:
    """Return the problem whose parts a method evaluates: the extended form where it needs one."""
    if len(method.components) == 2 and not problem.separable and problem.extended is not None:
        return problem.extended
    return problem


def without_clocks(found: Found, problem: Problem) -> Found:
    """Return what was computed of the extended form in the components of the problem.

    States (.., d + 2) lose s and sigma; those of dimension d stay as they are.
    """
    d = problem.dimension
    if found.y.shape[-1] == d:
        return found
    states: dict[str, Any] = {
        key: np.delete(x, [d // 2, d + 1], axis=-1)
        for key in ("y", "values", "history")
        if (x := getattr(found, key, None)) is not None
    }
    return replace(found, **states)


def with_clocks(initial: np.ndarray, solved: Problem) -> np.ndarray:
    """Return initial values (N, d) of a problem as those (N, d + 2) of its extended form."""
    half = initial.shape[1] // 2
    clocks = np.asarray(solved.y0)[[half, -1]]
    return np.insert(initial, [half, 2 * half], clocks, axis=1)
