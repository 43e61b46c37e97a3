"""Order reduction: with which order a method converges on a problem of any stiffness.

On Prothero and Robinson's problem y' = lambda (cos t - y) - sin t the stages are wrong by the stage
defects, of order q + 1 for stage order q, and a stiff method hands them on: with z = h lambda held
fixed and far in the left half-plane the classical order is not seen. What is seen depends on
``M(infinity)``: where it has the eigenvalue 1 the defects add up, and order q is left; where it has
not, they are damped or cancel in turn, and it is q + 1.

References
----------
Prothero, Robinson, Math. Comp. 28 (1974) 145-162.
Hairer, Wanner, Solving Ordinary Differential Equations II (1996), section IV.15.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

import numpy as np

from glmref.engine.reference import stepper
from glmref.engine.solve import solve
from glmref.engine.starting_values import starting_values
from glmref.errors import UsageError
from glmref.method import GLM
from glmref.problems import problem


@dataclass(frozen=True)
class ObservedOrder:
    """Errors at the end of a few runs with halved step sizes."""

    method: str  #: Its name.
    z: float | None  #: h lambda, the same for all runs; ``None`` where lambda was fixed.
    h: tuple[float, ...]  #: Step sizes.
    errors: tuple[float, ...]  #: At the end, in absolute value.
    orders: tuple[float, ...]  #: Binary logarithms of the quotients of errors, one fewer.

    @property
    def order(self) -> float:
        """The order seen at the two smallest step sizes."""
        return self.orders[-1]


def smooth_start(method: GLM, *, h: float, digits: int | None = None) -> np.ndarray:
    """Starting values that belong to the smooth solution cos t, whatever the stiffness, (r, 1).

    They are those of the quadrature problem y' = -sin t: there a starting method has no stiffness
    to fail on, and of a smooth solution the values carried are the same.
    """
    engine = stepper(method, problem("prothero-robinson", stiffness=0), digits=digits)
    number = engine.arithmetic.number
    y0 = np.array(engine.problem.y0)
    return starting_values(engine, None, t=number(0.0), y0=y0, h=number(h)).values


def observed_order(
    method: GLM,
    *,
    z: float | None = None,
    steps: Sequence[int] = (16, 32, 64),
    t_end: float = 2.0,
    digits: int = 40,
) -> ObservedOrder:
    """Measure the order of convergence on Prothero and Robinson's problem.

    Parameters
    ----------
    z : float or None
        h lambda, held fixed while h is halved; ``None``: lambda = -1, not stiff at all.
    steps : Sequence[int]
        Numbers of steps to ``t_end``, each twice the one before.
    digits : int
        Decimal digits of the runs: stiffly accurate methods err by ``h^(q + 1)/|z|``.

    Raises
    ------
    UsageError
        When a run does not end.
    """
    errors: list[Any] = []
    for n in steps:
        h = t_end / n
        stiffness = Fraction(1) if z is None else Fraction(-z) / Fraction(h)
        subject = problem("prothero-robinson", stiffness=stiffness)
        found = solve(
            subject, method, h=h, steps=n, engine="reference", digits=digits,
            start=smooth_start(method, h=h, digits=digits),
        )  # fmt: skip
        if not found.completed:
            raise UsageError(f"{method.name} on {subject.name}: {found.message}")
        end = found.y[-1][0]
        context = end.context
        errors.append(abs(end - context.cos(found.t[-1])))
    orders = tuple(float(context.log(a / b, 2)) for a, b in pairwise(errors))
    sizes = tuple(t_end / n for n in steps)
    return ObservedOrder(method.name, z, sizes, tuple(float(e) for e in errors), orders)
