"""Verdicts: how an answer is judged, and how an order is read off errors."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import inf, log2

import numpy as np

from ..views.tables import one_line
from .subject import AdapterError, Subject


@dataclass(frozen=True, slots=True)
class Judgement:
    """Outcome of one check."""

    holds: bool | None  #: ``None`` where it was not judged.
    message: str = ""  #: What is wrong, or why it was not judged.
    residual: float = 0.0  #: Size of the deviation.
    #: For claims with a value.
    declared: object = True
    value: object = None


#: A deviation and, behind it, the name of the defect.
_NAMED = re.compile(r".* \(off by \S+, rounding explains \S+\); (?P<defect>.+)")


def deviation(where: str, found: float, right: float, allowed: float, defect: str) -> str:
    """Return the sentence on a number that is wrong, with the defect that explains it."""
    text = (
        f"{where} is {found:.17g} and must be {right:.17g} "
        f"(off by {abs(found - right):.2g}, rounding explains {allowed:.2g})"
    )
    return f"{text}; {defect}" if defect else text


def defect_of(sentence: str) -> str:
    """Return the defect that a sentence of :func:`deviation` names, or ``""``."""
    named = _NAMED.fullmatch(one_line(sentence))
    return named["defect"] if named else ""


def input_judgement(left: bool) -> Judgement:
    """Decide whether a step leaves its input alone."""
    said = "step changes the array it is given; it must work on a copy"
    return Judgement(left, "" if left else said)


#: Part of the first difference above which a later one shows no state that repeats itself.
_AS_FAR = 0.05


def same(
    ask: Callable[[], np.ndarray], other: Callable[[], object], allowed: float, what: str
) -> Judgement:
    """Compare answers to the same request, another one asked between them.

    Where they differ, both are asked once more: what an integrator keeps of its last calls is then
    the same, random numbers and counters are not.
    """
    first, _ = ask(), other()
    again = ask()
    gap = float(np.abs(first - again).max())
    if gap <= allowed:
        return Judgement(True, residual=gap)
    other()
    if float(np.abs(ask() - again).max()) > _AS_FAR * gap:
        why = "it gives another one every time, as random numbers, a counter or a clock do"
    else:
        why = "the integrator keeps something from call to call"
    return Judgement(
        False,
        f"the same {what} gives another result ({gap:.2g} apart) after a different one was taken: "
        f"{why}",
        gap,
    )


def errors_of(
    run: Callable[[int], np.ndarray], counts: Sequence[int], exact: np.ndarray,
    enough: Callable[[int, float], bool] = lambda n, e: False,
) -> tuple[list[int], list[float]]:  # fmt: skip
    """Return errors at the end of runs; the coarsest runs may fail, the others must not."""
    steps: list[int] = []
    errors: list[float] = []
    for n in counts:
        try:
            error = float(np.abs(run(n) - exact).max())
        except AdapterError:
            if steps or n == counts[-1]:
                raise
            continue
        steps.append(n)
        errors.append(error)
        if enough(n, error):
            break
    return steps, errors


def floor_of(subject: Subject, name: str, steps: int) -> float:
    """Return the error of a run from which its slope can be read: rounding changes it by a quarter.

    A step carries some 30 roundings, and what is left of the stage equations; slopes are then right
    within ``log2(5/4) < 1/3``.
    """
    return 4 * steps * (30 * subject.epsilon + subject.tolerance(name))


def order_judgement(
    steps: Sequence[int], errors: Sequence[float], right: int, subject: Subject, name: str,
    shown_by: Mapping[int, float] | None = None,
) -> Judgement:  # fmt: skip
    """Decide an order from errors at halved step sizes.

    The error is ``C h^p (1 + O(h))``, so the slopes ``log2(e(h) / e(h/2))`` tend to an integer. Of
    the last two, the larger decides, since the very last may feel rounding: not below p - 1/3 the
    claim holds. It is refuted only from below, and only by slopes that have settled (they differ by
    at most 1/4, and their limit, which a difference that halves with h leaves, is too small), or
    by the three of the smallest steps where each is below p - 1: the error of a good method falls
    faster than its order for long, where the constant of the leading term is small, and that of
    single precision does not settle. That the order is not higher is a fact of the coefficients,
    not of a run.

    Where the errors of the method itself at these numbers of steps are known (``shown_by``), a run
    need not show more than they do: some methods settle at steps smaller than these.
    """
    shown = ", ".join(f"{e:.3g} at {n} steps" for n, e in zip(steps, errors, strict=True))
    usable = [(n, e) for n, e in zip(steps, errors, strict=True) if e > floor_of(subject, name, n)]
    slopes = _slopes(usable)
    if not slopes:
        return Judgement(None, f"not judged: too few errors above rounding ({shown})")
    slope, least = max(slopes[-2:]), right - 1 / 3
    if shown_by is not None:
        known = _slopes([(n, shown_by[n]) for n, _ in usable if n in shown_by])
        least = min([least, *(max(known[-2:]) - 1 / 3 for _ in known[:1])])
    if slope >= least:
        return Judgement(True, residual=max(0.0, right - slope), declared=right, value=right)
    change = slopes[-1] - slopes[-2] if len(slopes) > 1 else inf
    steady = abs(change) <= 1 / 4 and slopes[-1] + change < least
    finest = usable[-1][0] == steps[-1]
    steady |= finest and len(slopes) > 2 and max(slopes[-3:]) < least - 2 / 3
    message = f"the error falls like h^{slope:.2f}, not h^{right} ({shown})"
    return Judgement(False if steady else None, message, right - slope, right, round(slope))


def _slopes(errors: Sequence[tuple[int, float]]) -> list[float]:
    """Return the slopes between numbers of steps that double."""
    return [log2(a / b) for (n, a), (m, b) in pairwise(errors) if m == 2 * n]
