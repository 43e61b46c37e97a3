"""How a run ended, and what it left: where a NaN or an exception becomes a named outcome."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np

from ..errors import UsageError
from ..problems.user import FunctionFailed, NoValue
from ..system.shown import Drawing, Shown, above

LARGEST_EXPONENT = 65536


class StartFailed(UsageError):
    """A start or finish whose equations could not be solved, or whose values are not finite."""


class Outcome(StrEnum):
    """How a run ended; in every case what was computed before stays in the solution."""

    COMPLETED = "completed"
    STAGE_SOLVE_FAILED = "stage solve failed"
    NOT_FINITE = "not finite"
    STEP_LIMIT = "step limit"
    CANCELLED = "cancelled"
    FUNCTION_FAILED = "right-hand side failed"


#: Codes a kernel returns, in this order; the last stands for an exception that came through it.
KERNEL_OUTCOMES = (
    Outcome.COMPLETED,
    Outcome.STAGE_SOLVE_FAILED,
    Outcome.NOT_FINITE,
    Outcome.FUNCTION_FAILED,
)


def is_finite(x: Any) -> bool:
    """Whether a number is no NaN and not infinite, as one of mpmath above 2^65536 counts.

    A run that diverges squares its numbers from round to round, and the sine of one with a million
    digits before the point takes for ever.
    """
    parts = getattr(x, "_mpf_", None)
    if parts is None:
        return bool(x == x and abs(x) != math.inf)
    _, mantissa, exponent, bits = parts
    return exponent + bits <= LARGEST_EXPONENT if mantissa else not exponent


def all_finite(values: np.ndarray) -> bool:
    """Whether every number is finite, in double precision or of mpmath."""
    if values.dtype == object:
        return all(is_finite(x) for x in values.ravel())
    return bool(np.isfinite(values).all())


def outcome_of(error: Exception) -> tuple[Outcome, str]:
    """How a run ends in which ``error`` was raised, and what there is to say of it."""
    if isinstance(error, StartFailed):
        return Outcome.STAGE_SOLVE_FAILED, ""
    if isinstance(error, FunctionFailed) and not isinstance(error, NoValue):
        return Outcome.FUNCTION_FAILED, f": {error}"
    return Outcome.NOT_FINITE, f": {error}"


@dataclass(frozen=True, eq=False, repr=False)
class Solution(Shown):
    """What a run computed.

    Attributes
    ----------
    t : np.ndarray
        (m,) times of the rows kept.
    y : np.ndarray
        (m, d) solution at these times (finishing method applied).
    outcome : Outcome
        How the run ended.
    message : str
        One sentence on the outcome; says what to do where it is not ``completed``.
    steps : int
        Number of steps completed.
    values : np.ndarray
        (r, d) the values carried, after the last completed step, in the method's own basis; for a
        pair (max(r, r^), d), q in the first half of the columns and p in the second.
    history : np.ndarray or None
        (m, r, d) the same at every time in ``t``, or ``None`` where not asked for.
    evaluations : int
        Right-hand-side evaluations of the steps. For a separable problem the evaluations of p' =
        dp(q), the expensive half; see ``velocity_evaluations``.
    velocity_evaluations : int
        Evaluations of q' = dq(p) where it is counted apart, else 0.
    iterations : int
        Rounds of the stage solver, summed over stages and steps.
    factorisations : int
        Newton matrices factored.
    seconds : float
        Wall clock time of the steps alone (no compilation, no start).
    start_evaluations, finish_evaluations : int
        Right-hand-side evaluations of start and finish.
    build_seconds : float
        Time to generate, compile or load the kernel.
    method, problem, h
        What was run.
    kernel : str
        What was built: engine, form, solver and arithmetic in words.
    notices : tuple[str, ...]
        Sentences worth knowing, such as a fallback that was taken.
    renewals : int
        How often the values were made anew, see ``renew`` of :func:`glmref.solve`.
    """

    t: np.ndarray
    y: np.ndarray
    outcome: Outcome
    message: str
    steps: int
    values: np.ndarray
    history: np.ndarray | None
    evaluations: int
    velocity_evaluations: int
    iterations: int
    factorisations: int
    seconds: float
    start_evaluations: int
    finish_evaluations: int
    build_seconds: float
    method: str
    problem: str
    h: float
    kernel: str
    notices: tuple[str, ...] = ()
    renewals: int = 0

    def __repr__(self) -> str:
        return (
            f"<Solution of {self.problem} by {self.method or '(unnamed)'}: {self.outcome}, "
            f"{self.steps} steps, "
            f"t = {self.t[-1] if len(self.t) else float('nan'):g}>"
        )

    def plot(self, components: Sequence[int] | None = None) -> Drawing:
        """Draw the components of the solution against time.

        Parameters
        ----------
        components : Sequence[int] or None
            Numbers of the components, from 0; the first six by default.

        Returns
        -------
        Drawing
            A picture in SVG: a notebook shows it, and ``save(path)`` writes it.

        Raises
        ------
        UsageError
            Where fewer than two rows were kept: say ``every`` or ``times``.
        """
        return above("views.plot", "plot")(self, components=components)

    @property
    def completed(self) -> bool:
        """Whether every step that was asked for was taken."""
        return self.outcome is Outcome.COMPLETED

    @property
    def total_evaluations(self) -> int:
        """Right-hand-side evaluations of start, steps and finish together."""
        return self.start_evaluations + self.evaluations + self.finish_evaluations
