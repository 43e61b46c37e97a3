"""Newton's method in the working precision of intervals, on the numbers of the judge.

Nothing is proved here (:mod:`glmref.prove.enclosure` does that). Starts that are far away:
:mod:`glmref.derive.search`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..errors import GlmrefError
from ..exact import Ball, Exact
from ..exact.judging import as_number, consulted, coordinates, newton, rounded

#: A function of n unknowns with m values, over numbers of the judge that carry their gradients.
Function = Callable[[list[Any]], list[Any]]

MAX_ITERATIONS = 60


class ConvergenceError(GlmrefError):
    """Newton's iteration did not reach the accuracy asked for."""


def polish(function: Function, start: Sequence[Exact], *, digits: int = 120) -> list[Ball]:
    """Do Newton's iteration on midpoints until the step is below ``10**-digits``.

    Parameters
    ----------
    function : Function
        Square system, n values of n unknowns.
    start : Sequence[Exact]
        (n,) first approximation, rational.
    digits : int
        Decimals to reach; at most 140 with the precision of balls.

    Raises
    ------
    ConvergenceError
        When it stalls, diverges or meets a singular Jacobian.
    """
    with consulted():
        point = [rounded(as_number(x)) for x in start]
        for _ in range(MAX_ITERATIONS):
            try:
                new, _ = newton(function, point, function(coordinates(point)), steps=1)
            except ZeroDivisionError as error:
                raise ConvergenceError(f"the Jacobian is singular on the way ({error})") from None
            length = max(abs(float(x.ball - y.ball)) for x, y in zip(new, point, strict=True))
            point = new
            if length < 10.0**-digits:
                return [x.as_ball() for x in point]
            if not length < 1e12:
                break
    raise ConvergenceError(
        f"Newton's iteration did not converge in {MAX_ITERATIONS} steps (last step {length:.3g}); "
        f"start nearer, or the root is multiple"
    )
