"""Growth of first order along a long orbit, where a pilot run is too short to show it.

To first order in h a parasitic part at the eigenvalue zeta of V obeys

    phi' = M(y) phi,      M(y) = L (B f'(y) U) R / zeta

along the orbit, with R the eigenvectors, L R = I. Where the growth parameters are not zero and the
orbit is chaotic, growth comes in bursts that 5,000 steps do not show. No step size is in the
equation, so that the orbit is followed by a symplectic method with longer steps, and phi by the
implicit midpoint rule, which adds no growth of its own. On a chaotic orbit the result is one of
many possible ones: that of the run itself departs from it after some Lyapunov times.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ..engine.kept import expressed
from ..engine.reference import Stepper
from ..engine.solve import solve
from ..problems.model import Problem
from ..problems.user_functions import UserFunction
from .linearised import jacobians
from .longtime import energy_deviation

#: Numbers of the matrices of all steps of the orbit, and of those taken at once.
NUMBERS, BLOCK = 1 << 24, 1 << 20
#: Steps between two sizes that are kept.
CHUNK = 64
#: Longest of its steps in steps of the run, and the error of the energy with which it is one.
LONGER, FAITHFUL = 8, 1e-3
#: What follows the orbit of a separable problem, and of another one.
SPLITTING, IMPLICIT = "blanes-moan-4", "gauss-3"
#: Growth that is clear: so many powers of e in all, a part of them in the second half.
CLEAR, LATER = math.log(1000), 0.25


@dataclass(frozen=True, eq=False)
class FirstOrder:
    """A part along an orbit: after ``steps`` (N,) of the run, logarithm of its growth and phi."""

    steps: np.ndarray
    logarithms: np.ndarray  #: (N,) from 0
    phi: np.ndarray  #: (N, m) of norm 1

    def reached(self, growth: float) -> tuple[float, float, np.ndarray] | None:
        """Return step and rate per step at which a part has grown so much, and phi by then.

        ``None`` where it has not on this orbit, and growth is not clear.
        """
        needed, logs, n = math.log(growth), self.logarithms, self.steps
        over = np.flatnonzero(logs >= needed)
        if len(over):
            at = max(int(over[0]), 1)
            return float(n[at]), float(logs[at] / n[at]), self.phi[at]
        late = logs[-1] - logs[len(logs) // 2]
        if not (logs[-1] >= CLEAR and late >= LATER * logs[-1]):
            return None
        rate = float(logs[-1] / n[-1])
        return needed / rate, rate, self.phi[-1]


@dataclass(frozen=True, eq=False)
class Coupling:
    """What makes M of a Jacobian: ``M_ab = weights_ab df_j/dy_k`` with j and k those of a and b."""

    weights: np.ndarray  #: (m, m)
    components: np.ndarray  #: (m,) components of a state that the parts move

    def of(self, jacobians: np.ndarray) -> np.ndarray:
        """Return M, (N, m, m), for Jacobians (N, d, d)."""
        return jacobians[:, self.components[:, None], self.components] * self.weights


def coupling_of(engine: Stepper, zeta: complex, left: np.ndarray, right: np.ndarray) -> Coupling:
    """Return the coupling of the parts at an eigenvalue.

    Parameters
    ----------
    engine : Stepper
        Of the method and the problem, with (r, d) values.
    zeta, left, right
        Eigenvalue of V, (m, r d) and (r d, m) its eigenvectors on the values, each of which moves
        one component of a state.
    """
    r, d = engine.shape
    L, R = left.reshape(-1, r, d), right.reshape(r, d, -1)
    moved = np.abs(L).max(axis=1).argmax(axis=1)
    L, R = L.sum(axis=2), R.sum(axis=1)
    weights = np.zeros((len(L), len(L)), dtype=complex)
    parts = engine.components[: len(engine.parts)]
    for a in parts:
        for b in parts:
            if a is not b or engine.joint:
                BU = np.array(a.B, dtype=float) @ np.array(b.U, dtype=float)
                rows, columns = (np.isin(moved, np.arange(d)[x.columns]) for x in (a, b))
                found = L[:, : len(BU)] @ BU @ R[: BU.shape[1]] / zeta
                weights += np.where(rows[:, None] & columns, found, 0)
    return Coupling(np.real_if_close(weights, tol=1e4), moved)  # mu is real by symmetry at i, too


def along(
    problem: Problem, h: float, coupling: Coupling, start: np.ndarray, *, growth: float = math.inf
) -> FirstOrder | None:
    """Follow a part from ``start`` (m,) along a long orbit; ``None`` where there is none.

    Parameters
    ----------
    problem : Problem
        Autonomous, with an energy; Python that cannot be recorded as formulas takes too long.
    h : float
        Step size of the run.
    coupling : Coupling
        What :func:`coupling_of` returns.
    start : np.ndarray
        (m,) the part at the start, in direction.
    growth : float
        It is followed no further than where it has grown so much.
    """
    blocks = BLOCK // max(problem.dimension, len(start)) ** 2 // CHUNK
    if not blocks:
        return None
    at_once = blocks * CHUNK
    problem = expressed(problem)
    orbit = _orbit(problem, h, at_once * (NUMBERS // BLOCK))
    if orbit is None:
        return None
    y, longer = orbit
    one = np.eye(len(start), dtype=coupling.weights.dtype)
    phi = start / np.linalg.norm(start) if start.any() else one[0]
    logs, parts = [0.0], [phi]
    for first in range(0, len(y) - 1, at_once):
        if logs[-1] > math.log(growth):
            break
        some = y[first : first + at_once + 1]
        half = coupling.of(jacobians(problem, (some[1:] + some[:-1]) / 2)) * (longer * h / 2)
        try:
            moves = np.linalg.solve(one - half, one + half)
        except np.linalg.LinAlgError:  # a step is too long for the part
            return None
        for _ in range(CHUNK.bit_length() - 1):
            moves = moves[1::2] @ moves[::2]
        for move in moves:
            phi = move @ phi
            size = float(np.linalg.norm(phi))
            if not 0 < size < math.inf:
                return None
            phi = phi / size
            logs.append(logs[-1] + math.log(size))
            parts.append(phi)
    steps = np.arange(len(logs)) * float(CHUNK * longer)
    return FirstOrder(steps, np.array(logs), np.array(parts))


def _orbit(problem: Problem, h: float, count: int) -> tuple[np.ndarray, int] | None:
    """Return states (count + 1, d) of an orbit, and its steps in steps of the run."""
    functions = (problem.f, problem.dq, problem.dp)
    if problem.hamiltonian is None or any(isinstance(x, UserFunction) for x in functions):
        return None
    method, longer = SPLITTING if problem.separable else IMPLICIT, LONGER
    while longer:
        for steps in (count // 64, count):
            run = solve(problem, method, h=longer * h, steps=steps, every=1)
            y = np.real(np.asarray(run.y))
            if not run.completed or not energy_deviation(problem, y).max() < FAITHFUL:
                break
        else:
            return y, longer
        longer //= 2
    return None
