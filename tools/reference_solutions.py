"""Compute the reference states of data/solutions again: twice, and keep the digits that agree."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from glmref.problems.model import Problem
from glmref.problems.reference import FORMAT

MOST_DIGITS = 40  # stored, however many agree


def solution_entries(
    problem: Problem, times: Sequence[str], *, digits: int, stages: int | None = None
) -> list[dict[str, Any]]:
    """Compute the entries of one problem's file, one for each of increasing times as exact strings.

    The first computation has so many digits; the second one asks for 8 (Taylor series) or 4 (with
    ``stages``: Radau IIA with so many stages, and two more) more, and is the one stored.
    """
    if stages is None:
        from glmref.conformance.taylor import taylor_states

        finer = digits + 8
        coarse = taylor_states(problem, times, digits=digits)
        fine = taylor_states(problem, times, digits=finer)
        how = f"Taylor series, step tolerance 1e-{digits} and 1e-{finer}"
    else:
        from tools.collocation import collocation_states

        finer, more = digits + 4, stages + 2
        coarse = collocation_states(problem, times, digits=digits, stages=stages)
        fine = collocation_states(problem, times, digits=finer, stages=more)
        how = f"Radau IIA, {stages} and {more} stages, tolerance 1e-{digits} and 1e-{finer}"
    parameters = {key: str(Fraction(value)) for key, value in problem.parameters.items()}
    entries = []
    for t, a, b in zip(times, coarse, fine, strict=True):
        differences = [abs(y - y.context.mpf(x)) for x, y in zip(a, b, strict=True)]
        largest = max(abs(y) for y in b)
        entries.append(
            {
                "parameters": parameters,
                "t": t,
                "state": [_text(y, error) for y, error in zip(b, differences, strict=True)],
                "agreement": f"{float(max(differences) / largest):.1e}",
                "generator": how,
            }
        )
    return entries


def solution_document(name: str, entries: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the document of the format ``glmref-solution-1`` for one problem."""
    return {"format": FORMAT, "problem": name, "solutions": list(entries)}


def _text(y: Any, error: Any) -> str:
    """Return those digits of an mpmath number that the other computation confirms."""
    ctx = y.context
    if abs(y) <= error:
        return "0"
    digits = MOST_DIGITS
    if error:
        digits = max(1, min(digits, int(-ctx.log10(error / abs(y)))))
    return ctx.nstr(y, digits, strip_zeros=False)
