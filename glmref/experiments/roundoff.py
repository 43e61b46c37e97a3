"""Brouwer's law: how round-off grows, with the truncation error out of the way.

A quadratic invariant that the method keeps exactly (y^T C y for a symplectic Runge-Kutta method,
``sum g_ij y_i^T C y_j`` for a G-symplectic one) changes by round-off alone. Over several problems
its root mean square tells a random walk, exponent 1/2, from a drift, exponent 1.

References
----------
Brouwer, On the accumulation of errors in numerical integration, Astron. J. 46 (1937) 149-153.
Hairer, McLachlan, Razakarivony, Achieving Brouwer's law with implicit Runge-Kutta methods, BIT 48
(2008) 231-243.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..claims import UsageError
from ..engine.solve import solve
from ..method import GLM
from ..problems.model import Problem
from .longtime import along, g_form

__all__ = ["RoundOff", "round_off"]

#: Samples over the run.
SAMPLES = 8192


@dataclass(frozen=True)
class RoundOff:
    """Growth of the round-off in invariants that are exact but for it.

    Attributes
    ----------
        method, kernel, h: what ran.
        steps: numbers of steps n, each twice the one before.
        rms: root mean square of the relative deviations over n/2 .. n steps, over all invariants.
        exponent: least squares slope of log rms against log n.
        mean: mean deviation over the last stretch, with its sign; a drift shows here.
        runs: how many invariants of how many problems went into it.
    """

    method: str
    kernel: str
    h: float
    steps: tuple[int, ...]
    rms: tuple[float, ...]
    exponent: float
    mean: float
    runs: int

    def as_json(self) -> dict[str, Any]:
        """Return the record in JSON's types."""
        from .records import finite

        record = {key: getattr(self, key) for key in self.__dataclass_fields__}
        record |= {"steps": list(self.steps), "rms": [finite(x) for x in self.rms]}
        return record | {"exponent": finite(self.exponent), "mean": finite(self.mean)}


def round_off(
    method: GLM,
    problems: Sequence[Problem],
    *,
    h: float,
    steps: int,
    first: int = 10_000,
    **options: Any,
) -> RoundOff:
    """Measure how the round-off in exactly kept quadratic invariants grows.

    Args:
        method: symplectic with one value, or with a form G.
        problems: with quadratic invariants; several, because one walk tells little.
        h: step size. steps: number of steps.
        first: number of steps from which growth is fitted.
        **options: ``engine``, ``arithmetic``, ``form`` and ``solver`` of :func:`glmref.solve`.

    Raises
    ------
        UsageError: for a method without a form, problems without invariants, or a run that fails.
    """
    if method.r > 1 and method.G is None:
        raise UsageError(
            f"{method.name or 'the method'} gives no form G; its round-off is not seen"
        )
    rows, kernel, counts = [], "", np.zeros(0)
    for subject in problems:
        found = solve(
            subject, method, h=h, steps=steps, every=max(1, steps // SAMPLES), history=True,
            **options,
        )  # fmt: skip
        if not found.completed:
            raise UsageError(f"{subject.name}: {found.message}")
        kernel, counts = found.kernel, np.round(np.asarray(found.t, dtype=float) / h)
        rows += _deviations(subject, method, found)
    if not rows:
        raise UsageError("the problems have no quadratic invariants; give others")
    square = np.mean(np.array(rows) ** 2, axis=0)
    marks = [steps // 2**k for k in range(64) if steps // 2**k >= max(first, 4)][::-1]
    rms = [
        float(np.sqrt(np.mean(square[(counts > mark / 2) & (counts <= mark)]))) for mark in marks
    ]
    last = counts > steps / 2
    return RoundOff(
        method=method.name,
        kernel=kernel,
        h=h,
        steps=tuple(marks),
        rms=tuple(rms),
        exponent=_slope(marks, rms),
        mean=float(np.mean(np.array(rows)[:, last])),
        runs=len(rows),
    )


def _deviations(subject: Problem, method: GLM, found: Any) -> list[np.ndarray]:
    """Relative deviations of every kept form along one run."""
    rows = []
    for form in subject.quadratic.values():
        if method.r == 1:
            values = along(form, np.real(np.asarray(found.y)).astype(float))
        else:
            assert method.G is not None
            G = np.array([[complex(x) for x in row] for row in method.G])
            values = g_form(np.asarray(found.history), G, form.matrix)
        rows.append((values - values[0]) / (abs(values[0]) or 1.0))
    return rows


def _slope(steps: Sequence[int], rms: Sequence[float]) -> float:
    points = [(math.log(n), math.log(x)) for n, x in zip(steps, rms, strict=True) if x > 0]
    if len(points) < 3:
        return math.nan
    x, y = np.array(points).T
    x = x - x.mean()
    return float(x @ y / (x @ x))
