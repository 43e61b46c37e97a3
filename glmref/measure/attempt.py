"""One run that ends in a name, whatever the method, the problem and the step size are.

:func:`glmref.solve` names the ways in which a run ends and refuses what does not fit in one
sentence. What is left is code that is not ours: a right-hand side given as a Python function may
return what is no state, or raise. Here that too becomes an outcome.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.outcome import Outcome, Solution
from ..engine.solve import solve
from ..errors import GlmrefError
from ..method import Method
from ..problems.model import Problem
from ..problems.user_functions import FunctionFailed

#: The outcome that :func:`attempt` adds to those of the engine.
REFUSED = "refused"
#: The engine's, which a right-hand side that fails at the very start has here too.
FUNCTION_FAILED = str(Outcome.FUNCTION_FAILED)

#: Rounds after which a stage equation is given up, as both engines have it, and one to spare.
MOST_ROUNDS = 201
#: Fixed point, and then Newton.
SOLVERS = 2


@dataclass(frozen=True, eq=False)
class Attempt:
    """How a run ended."""

    #: One of :class:`~glmref.engine.outcome.Outcome`, :data:`REFUSED` or :data:`FUNCTION_FAILED`.
    outcome: str
    message: str  #: One sentence on it.
    solution: Solution | None = None  #: What was computed, ``None`` where nothing was.


def attempt(
    problem: Problem,
    method: Method,
    *,
    h: float,
    steps: int,
    evaluations: int = 10**9,
    **options: Any,
) -> Attempt:
    """Run a method on a problem, with the options of :func:`glmref.solve`, and name the end.

    ``evaluations`` is a budget. No stage equation takes more than :data:`MOST_ROUNDS` rounds of
    each solver, so it is kept by taking fewer steps. An exception that comes from the code of this
    package is not caught: it would be a defect, not an outcome.
    """
    limit = max(1, evaluations // (SOLVERS * MOST_ROUNDS * _stages(method)))
    options.setdefault("step_limit", limit)
    try:
        with np.errstate(all="ignore"):
            check_function(problem)
            solution = solve(problem, method, h=h, steps=steps, **options)
    except FunctionFailed as error:
        return Attempt(FUNCTION_FAILED, str(error))
    except GlmrefError as error:
        return Attempt(REFUSED, str(error))
    except Exception as error:
        if not given_by_user(problem):
            raise
        return Attempt(FUNCTION_FAILED, f"{type(error).__name__}: {error}")
    return Attempt(str(solution.outcome), solution.message, solution)


def _stages(method: Method) -> int:
    return max(1, sum(len(c.U) for c in method.carriers))


def given_by_user(problem: Problem) -> bool:
    """Return whether a right-hand side or Jacobian is a Python function."""
    functions = (problem.f, problem.dq, problem.dp, problem.jacobian)
    return any(f is not None and not hasattr(f, "on") for f in functions)


def check_function(problem: Problem) -> None:
    """Evaluate f once where it is a Python function: it must return d real numbers.

    Raises
    ------
    TypeError, ValueError
        For a result that is none.
    """
    if not given_by_user(problem):
        return
    slope = np.asarray(problem.f(float(problem.t_span[0]), np.array(problem.y0, dtype=float)))
    if slope.dtype.kind not in "fiub":
        raise TypeError(f"f must return real numbers, got an array of {slope.dtype}")
    if slope.shape != (problem.dimension,):
        raise ValueError(
            f"f must return an array of shape {(problem.dimension,)}, got {slope.shape}"
        )


#: Every outcome there is, for those who list them.
OUTCOMES = (*map(str, Outcome), REFUSED)
