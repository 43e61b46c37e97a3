"""Newton's method in the working precision of balls.

It takes a function of the unknowns written for any scalar: fed jets it returns values and
Jacobian together. The numbers are midpoints of :data:`~glmref.exact.BALL_BITS` bits; nothing is
proved here (:mod:`glmref.prove.enclosure` does that). Starts that are far away:
:mod:`glmref.derive.search`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from ..errors import ExactnessError, GlmrefError
from ..exact import Ball, Exact, ball, jets, lift, linalg

#: A function of n unknowns with m values, over jets.
Function = Callable[[Sequence[Any]], Sequence[Any]]

MAX_ITERATIONS = 60


class ConvergenceError(GlmrefError):
    """Newton's iteration did not reach the accuracy asked for."""


def midpoints(values: Sequence[Any]) -> list[Ball]:
    """Return the midpoints, as balls of radius zero."""
    return [ball(x).real.midpoint() for x in values]


def polish(
    function: Function,
    start: Sequence[Ball],
    *,
    digits: int = 120,
) -> list[Ball]:
    """Do Newton's iteration on midpoints until the step is below ``10**-digits``.

    Parameters
    ----------
    function : Function
        Square system, n values of n unknowns.
    start : Sequence[Ball]
        (n,) first approximation.
    digits : int
        Decimals to reach; at most 140 with the precision of balls.

    Raises
    ------
    ConvergenceError
        When it stalls, diverges or meets a singular Jacobian.
    """
    point = midpoints(start)
    size = len(point)
    for _ in range(MAX_ITERATIONS):
        values = [lift(x, size) for x in function(jets(point))]
        jacobian = tuple(tuple(_middle(y) for y in x.gradient) for x in values)
        right = tuple((_middle(x.value),) for x in values)
        try:
            step = [row[0] for row in linalg.solve(jacobian, right)]
        except ExactnessError as error:
            raise ConvergenceError(f"the Jacobian is singular along the way ({error})") from None
        point = midpoints([x - y for x, y in zip(point, step, strict=True)])
        length = max(abs(complex(x)) for x in step)
        if length < 10.0**-digits:
            return point
        if not length < 1e12:
            break
    raise ConvergenceError(
        f"Newton's iteration did not converge in {MAX_ITERATIONS} steps (last step {length:.3g}); "
        f"start nearer, or the root is multiple"
    )


def _middle(value: Any) -> Ball | Exact:
    return value.midpoint() if isinstance(value, Ball) else value
