"""Compute the reference states of data/solutions anew: twice, and keep the digits that agree."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import numpy as np

from .model import Problem
from .reference import FORMAT

__all__ = ["solution_document", "solution_entries"]

MOST_DIGITS = 40  # stored, however many agree


def solution_entries(
    problem: Problem, times: Sequence[str], *, digits: int, stages: int | None = None
) -> list[dict[str, Any]]:
    """Compute the entries of one problem's file, one per time.

    Args:
        problem: one of :func:`glmref.problems.names`, with its parameters.
        times: increasing, as exact strings such as ``"10"``.
        digits: of the first computation; the second one asks for 8 (Taylor) or 4 (collocation)
            more, and is the one stored.
        stages: use Radau IIA with so many stages, and two more; ``None``: use Taylor series.
    """
    if stages is None:
        from .taylor import taylor_states

        finer = digits + 8
        coarse = taylor_states(problem, times, digits=digits)
        fine = taylor_states(problem, times, digits=finer)
        how = f"Taylor series, step tolerance 1e-{digits} and 1e-{finer}"
    else:
        from .collocation import collocation_states

        finer, more = digits + 4, stages + 2
        coarse = collocation_states(problem, times, digits=digits, stages=stages)
        fine = collocation_states(problem, times, digits=finer, stages=more)
        how = f"Radau IIA, {stages} and {more} stages, tolerance 1e-{digits} and 1e-{finer}"
    parameters = {key: str(Fraction(value)) for key, value in problem.parameters.items()}
    entries = []
    for t, a, b in zip(times, coarse, fine, strict=True):
        agreement = _difference(a, b)
        kept = min(MOST_DIGITS, max(1, int(-np.log10(max(agreement, 1e-300)))))
        entries.append(
            {
                "parameters": parameters,
                "t": t,
                "state": [_text(x, kept) for x in b],
                "agreement": f"{agreement:.1e}",
                "generator": how,
            }
        )
    return entries


def solution_document(name: str, entries: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the document of the format ``glmref-solution-1`` for one problem."""
    return {"format": FORMAT, "problem": name, "solutions": list(entries)}


def _difference(a: np.ndarray, b: np.ndarray) -> float:
    """Largest difference of two states, each component relative to its own size."""
    sizes = [abs(y) or 1 for y in b]
    return max(float(abs(y - y.context.mpf(x)) / s) for x, y, s in zip(a, b, sizes, strict=True))


def _text(x: Any, digits: int) -> str:
    """Decimal digits of an mpmath number, plain or with an exponent."""
    return x.context.nstr(x, digits, strip_zeros=False)
