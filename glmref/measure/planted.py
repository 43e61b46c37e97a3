"""Runs that begin with a parasitic part: how it grows, and how large it is at an energy error.

The linear equation of :mod:`.prediction` is solved by an expansion in h, which has small divisors
where two eigenvalues of V differ by a frequency of the orbit, and averages that come slowly where
growth parameters are not zero. A run that begins with values x + phi, one with x - phi: half their
difference is phi later on, up to its third power; what both have in common cancels.
"""

from __future__ import annotations

import math

import numpy as np

from ..engine.solve import solve
from ..method import Method
from ..problems.model import Problem
from .longtime import energy_deviation, follow

#: Size of a planted part relative to the solution, and at which it is no longer small: between
#: round-off and what its square does.
SMALL, LINEAR = 1e-7, 1e-2
#: Numbers that two runs compute at most, so many more where nothing else shows growth, for so many
#: steps of both; and evaluations of a right-hand side that is interpreted.
NUMBERS, FURTHER, BOTH, BUDGET = 8_000_000, 10, 1_000_000, 50_000
#: Halvings of a decade range of sizes: one in a hundred of the exponents.
HALVINGS = 8


def follow_part(
    method: Method, problem: Problem, h: float, start: np.ndarray, part: np.ndarray,
    *, further: bool = False, limit: float = math.inf,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Follow a small part for as long as :data:`NUMBERS` and a limit to the steps of both runs do.

    Parameters
    ----------
    method, problem, h
        As for :func:`.prediction.predict`.
    start : np.ndarray
        (r, d) values of step 0.
    part : np.ndarray
        (r, d) what the part adds to them, of the size of the solution.
    further : bool
        Whether for :data:`FURTHER` times the numbers, in no more steps than :data:`BOTH`.
    limit : float
        Steps of both runs together.

    Returns
    -------
    tuple[np.ndarray, np.ndarray]
        (N,) steps, and (N, r d) by then the part, planted with the size 1.

    Raises
    ------
    GlmrefError
        Where a run cannot be started.
    """
    most = min(FURTHER * NUMBERS // start.size, BOTH) if further else NUMBERS // start.size
    steps, runs = int(min(most, limit)) // 2, []
    for sign in (1, -1):
        planted = start + sign * SMALL * part
        runs.append(
            follow(problem, method, h=h, steps=steps, start=lambda *_, planted=planted: planted)
        )
    n, other = (np.rint(np.abs(run.t - run.t[0]) / abs(h)) for run in runs)
    _, one, two = np.intersect1d(n, other, return_indices=True)
    plus, minus = (np.asarray(run.history)[at] for run, at in zip(runs, (one, two), strict=True))
    return n[one], (plus - minus).reshape(len(one), -1) / (2 * SMALL)


def size_at(
    method: Method, problem: Problem, h: float, start: np.ndarray, part: np.ndarray,
    *, level: float, steps: int,
) -> float:  # fmt: skip
    """Return the size of a part, of the solution, at which the energy error comes to a level.

    NaN where it does so without a part.

    Parameters
    ----------
    method, problem, h, start, part
        As for :func:`follow_part`; the problem has an energy.
    level : float
        Relative error of the energy, larger than without a part.
    steps : int
        Within so many.

    Raises
    ------
    GlmrefError
        Where a run cannot be started.
    """

    def reached(size: float) -> bool:
        values = start + size * part
        run = solve(problem, method, h=h, steps=steps, every=1, start=lambda *_: values)
        error = energy_deviation(problem, np.real(run.y))
        return not bool((error < level).all())

    low, high = math.log(1e-14), 0.0
    if reached(math.exp(low)):
        return math.nan
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (low, middle) if reached(math.exp(middle)) else (middle, high)
    return math.exp((low + high) / 2)
