"""Whether a method that is said to have an order has it in one step, and its embedded rows theirs.

A method that carries one value steps the anharmonic oscillator q'' = -q - q^3 once with h and once
with h/2, in the arithmetic of doubles and without the theory: the error of a method of order p falls
by 2^(p+1). A Rosenbrock method, which no engine steps, is stepped here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache, partial
from typing import Any

import numpy as np

from glmref import Problem, load, solve
from glmref.errors import UsageError
from glmref.findings import Finding, Verdict
from glmref.method import AdditiveGLM, PartitionedGLM

START = (0.8, 0.3)
#: Two steps, of which the second is half the first; errors of it between these are judged.
STEPS, JUDGED = (1 / 16, 1 / 32), (1e-12, 1e-3)
#: How much less than p + 1 the observed exponent may be: the next terms of the error.
SLACK = 0.7
#: Largest entry, number of stages and order that are judged.
ENTRY, STAGES, ORDER = 10.0, 12, 6


def _force(q: float) -> float:
    return -q - q * q * q


WHOLE = Problem(f=("y[1]", "-y[0]-y[0]*y[0]*y[0]"), y0=START)
PARTS = Problem(dq=("p[0]",), dp=("-q[0]-q[0]*q[0]*q[0]",), y0=START)
TERMS = {
    2: Problem(terms=(("y[1]", "-y[0]"), ("0*y[0]", "-y[0]*y[0]*y[0]")), y0=START),
    3: Problem(
        terms=(("y[1]", "0*y[0]"), ("0*y[0]", "-y[0]"), ("0*y[0]", "-y[0]*y[0]*y[0]")), y0=START
    ),
}


@lru_cache
def _right(h: float) -> np.ndarray:
    return solve(WHOLE, load("gauss-5"), h=h / 4, steps=4, engine="reference").y[-1]


def _rosenbrock(method: Any, h: float) -> np.ndarray:
    """One step k_i = h f(y + sum alpha_ij k_j) + h J sum gamma_ij k_j."""
    alpha, gamma = (np.array([[float(x) for x in row] for row in m])
                    for m in (method.alpha, method.gamma))  # fmt: skip
    y, b = np.array(START), np.array([float(x) for x in method.weights[0][: len(method.b)]])
    J = np.array([[0.0, 1.0], [-1 - 3 * y[0] ** 2, 0.0]])
    s = len(b)
    if (np.triu(alpha) != 0).any() or (np.triu(gamma, 1) != 0).any():
        raise UsageError("a stage needs later ones")
    k = np.zeros((s, 2))
    for i in range(s):
        at = y + alpha[i] @ k
        right = h * np.array([at[1], _force(at[0])]) + h * J @ (gamma[i, :i] @ k[:i])
        k[i] = np.linalg.solve(np.eye(2) - h * gamma[i, i] * J, right)
    return y + b @ k


def _step(method: Any, h: float) -> np.ndarray | None:
    if getattr(method, "rosenbrock", False):
        return _rosenbrock(method, h)
    problem = WHOLE
    if isinstance(method, AdditiveGLM):
        problem = TERMS[len(method.B)]
    elif isinstance(method, PartitionedGLM):
        problem = PARTS
    found = solve(problem, method, h=h, steps=1, engine="reference")
    return found.y[-1] if found.completed else None


def _small(method: Any) -> bool:
    """Whether entries and stages are such that the next terms of the error are small."""
    rows = [row for part in method.components for m in (part.A, part.B) for row in m]
    entries = [abs(complex(x)) for row in rows for x in row]
    return max(entries) <= ENTRY and max(map(len, rows)) <= STAGES


def exponent(step: Callable[[float], np.ndarray | None]) -> float | None:
    """Exponent of h with which the error of one step falls; ``None`` where it cannot be seen."""
    errors = []
    for h in STEPS:
        found = step(h)
        if found is None or not np.isfinite(found).all():
            return None
        errors.append(float(np.abs(found - _right(h)).max()))
    low, high = JUDGED
    if not low < errors[1] < high or not errors[0] < high:
        return None
    return math.log2(errors[0] / errors[1])


def contradictions(method: Any, findings: list[Finding]) -> Iterator[str]:
    """What one step says against the orders that are said to hold.

    Parameters
    ----------
    method : GLM, PartitionedGLM or AdditiveGLM
        The method.
    findings : list of Finding
        What was found of it.
    """
    held = {f.claim: f.declared for f in findings if f.verdict is Verdict.HOLDS}
    names = [
        x for x in ("order", "order-identity", "nystrom-order") if isinstance(held.get(x), int)
    ]
    rows = held.get("embedded-order")
    if not (names or isinstance(rows, dict)) or not method.is_one_step or not _small(method):
        return
    claimed = [(x, int(held[x]), method) for x in names]
    if isinstance(rows, dict):
        claimed += [
            (f"embedded-order of {row.name}", int(rows[row.name]), method.with_row(row))
            for row in method.embedded if row.name in rows
        ]  # fmt: skip
    for name, order, subject in claimed:
        if order > ORDER:
            continue
        try:
            seen = exponent(partial(_step, subject))
        except (UsageError, np.linalg.LinAlgError):
            continue  # a stage that has no value, a method that no engine steps
        if seen is not None and seen < order + 1 - SLACK:
            yield f"{name} {order} holds, and the error of a step falls as h^{seen:.2f}"
