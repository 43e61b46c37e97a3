"""Arguments that other solvers have and this one has not, and a line of progress."""

from __future__ import annotations

import sys
from contextlib import suppress

from ..errors import UsageError

_TOLERANCE = "the step size is constant: choose `h`, and see glmref.compare, which finds it"
#: What to give instead, by the name of the argument.
INSTEAD = {
    "rtol": _TOLERANCE,
    "atol": _TOLERANCE,
    "tol": _TOLERANCE,
    "max_step": "the step size is constant: choose `h`",
    "first_step": "the step size is constant: choose `h`",
    "t_eval": "give `times`, on the grid t0 + n h, or call .at(t) of the solution",
    "t_span": "it belongs to the problem: Problem(.., t_span=(t0, t_end)); `t_end` sets the end",
    "y0": "it belongs to the problem: Problem(f=.., y0=..)",
    "events": "there are none: keep rows with `every`, look for the sign change of your function "
    "in them, and refine with .at(t) of the solution",
    "dense_output": "keep rows with `every`, and call .at(t) of the solution",
    "args": "give `parameters` of the problem, or a function that knows them",
    "jac": "it belongs to the problem: Problem(.., jacobian=..)",
    "vectorized": "f is called with one state (d,) at a time",
}


def refuse_foreign(name: str) -> None:
    """Refuse an argument that :func:`glmref.solve` has not.

    Raises
    ------
    UsageError
        In any case; with what to give instead where that is known.
    """
    known = INSTEAD.get(name, "help(glmref.solve) lists them")
    raise UsageError(f"`solve` has no argument `{name}`: {known}")


def shown_progress(done: int, steps: int) -> None:
    """Show on one line of stderr which part of a run is done; the last call ends the line."""
    with suppress(OSError, ValueError, AttributeError):  # a stream that is closed, or is none
        end = "\n" if done >= steps else ""
        sys.stderr.write(f"\r{100 * done // steps if steps else 100:3d} % of {steps} steps{end}")
        sys.stderr.flush()
