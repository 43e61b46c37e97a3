"""Parasitic growth: the modes of a method, and when a run was lost.

To each eigenvalue zeta != 1, |zeta| = 1, of V belongs a parasitic component phi. By theory it
follows ``phi' = mu f'(y) phi`` to leading order in h. To all orders of h: :mod:`.prediction`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..engine.outcome import Outcome, Solution
from ..errors import UsageError
from ..method import GLM, Method
from ..method.preconsistency import preconsistency_vector
from ..problems.model import Problem
from .longtime import energy_deviation

#: A run is lost when the values beyond ``u y_1`` reach this part of the first solution value.
LOST = 1 / 3


@dataclass(frozen=True, eq=False)
class Mode:
    """One parasitic mode of V."""

    zeta: complex  #: Eigenvalue, |zeta| = 1.
    right: np.ndarray  #: (r,) eigenvector whose largest entry is 1.
    left: np.ndarray  #: (r,), with ``left right = 1``.
    mu: complex  #: Growth parameter ``zeta^-1 left B U right``, from the rounded tableau.


def modes(method: GLM) -> list[Mode]:
    """Return parasitic modes of a method, by increasing argument of zeta in (0, 2 pi).

    Computed from the tableau rounded to double precision; a multiple eigenvalue has no single
    parasitic equation and is left out.
    """
    rounded = method.to_float()
    values = np.linalg.eigvals(rounded.V)
    found = []
    for zeta in values:
        alone = sum(abs(zeta - other) < 1e-6 for other in values) == 1
        if not alone or abs(abs(zeta) - 1) > 1e-9 or abs(zeta - 1) < 1e-9:
            continue
        # V may be defective elsewhere (past values make Jordan blocks at 0): null vectors are not
        u, _, vh = np.linalg.svd(rounded.V - zeta * np.eye(method.r))
        right, left = vh[-1].conj(), u[:, -1].conj()
        right = right / right[np.argmax(np.abs(right))]
        left = left / (left @ right)
        mu = left @ rounded.B @ rounded.U @ right / zeta
        found.append(Mode(complex(zeta), right, left, complex(mu)))
    return sorted(found, key=lambda mode: np.angle(mode.zeta) % (2 * math.pi))


def solution_direction(method: Method) -> np.ndarray:
    """Return the preconsistency vector u, (r,): what the solution is in the values.

    (1, 0, ...) for a method that is not pre-consistent; for a pair, that of its q half.
    """
    r = method.carried
    out = np.zeros(r)
    out[0] = 1.0
    u = preconsistency_vector(method.components[0])
    if u is not None:
        out[: len(u)] = [float(x.real) for x in u]
    return out


def parasitic_size(solution: Solution, u: np.ndarray) -> np.ndarray:
    """Return the norm of the values beyond ``u y`` at every sample of a solution, (m,).

    Smooth values are part of it: it is a bound of the parasitic part where that has grown, and of
    order h before.
    """
    if solution.history is None:
        raise UsageError("the parasitic size needs all values; solve with history=True")
    history = np.asarray(solution.history)
    first = int(np.flatnonzero(u)[0])  # the first value that carries the solution
    rest = history - u[None, :, None] * history[:, first : first + 1] / u[first]
    with np.errstate(all="ignore"):
        return np.sqrt(np.sum(np.abs(rest) ** 2, axis=(1, 2)))


@dataclass(frozen=True, slots=True)
class Loss:
    """Whether and when a run was lost."""

    time: float | None  #: Time of the first sample at which it was, ``None`` where it was not.
    reason: str  #: ``"parasitic"``, ``"energy"`` or the outcome by name, ``""`` where it was not.
    #: Largest size of the values beyond ``u y_1``, relative to the first solution value.
    largest: float


def loss(problem: Problem, solution: Solution, u: np.ndarray) -> Loss:
    """Find when a run was lost: parasitic part or energy error too large, or an early end.

    u (r,) is the right eigenvector of V at 1, for what of the values is the solution itself.
    """
    t = np.asarray(solution.t, dtype=float)
    unit = float(np.linalg.norm(np.asarray(solution.y[0]))) or 1.0
    with np.errstate(all="ignore"):
        sizes = parasitic_size(solution, u) / unit
    events: list[tuple[float, str]] = []
    over = np.flatnonzero(~(sizes < LOST))
    if len(over):
        events.append((float(t[over[0]]), "parasitic"))
    if problem.hamiltonian is not None:
        y = np.real(np.asarray(solution.y)).astype(float)
        wrong = np.flatnonzero(~(energy_deviation(problem, y) < 1.0))
        if len(wrong):
            events.append((float(t[wrong[0]]), "energy"))
    if solution.outcome not in (Outcome.COMPLETED, Outcome.CANCELLED, Outcome.STEP_LIMIT):
        events.append((float(t[-1]), str(solution.outcome)))
    finite = sizes[np.isfinite(sizes)]
    largest = float(np.max(finite)) if len(finite) else math.nan
    time, reason = min(events, default=(None, ""), key=lambda event: event[0])
    return Loss(time, reason, largest)
