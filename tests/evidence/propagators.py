"""Propagators of a parasitic part: measured by two runs, and that of mu f'."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from glmref.engine.reference import Stepper, stepper
from glmref.engine.starting_values import starting_values
from glmref.measure.parasitic import Mode, modes
from glmref.measure.underlying import Underlying
from glmref.method import GLM
from glmref.problems.model import Problem

#: Size of the perturbation that makes a parasitic component visible: its square is what linear
#: growth neglects, its inverse times 2e-16 is the round-off; both stay far below one per cent.
NUDGE = 1e-7


@dataclass(frozen=True, eq=False)
class Growth:
    """Growth of one parasitic mode over some time, measured and predicted."""

    #: Eigenvalue of V and growth parameter used for the prediction.
    zeta: complex
    mu: complex
    time: float  #: Length of the interval, time units of the problem.
    #: (d, d) propagators of phi over that time.
    measured: np.ndarray
    predicted: np.ndarray
    #: ``log(spectral radius)/time`` of each, per time unit.
    rate: float
    predicted_rate: float
    #: Largest difference of the propagators, relative to the predicted one's norm.
    discrepancy: float


def growth(
    method: GLM, problem: Problem, *, h: float, time: float, mode: Mode | None = None
) -> Growth:
    """Measure a parasitic propagator, by default of the first mode, and predict it from mu f'.

    The method is run twice from starting values that differ by a small amount along the eigenvector
    of zeta; the difference, read off by the left eigenvector and turned back by zeta^-n, is phi.
    """
    mode = modes(method)[0] if mode is None else mode
    steps = max(1, round(time / h))
    engine = stepper(method, problem)
    y0 = np.array(problem.y0)
    start = starting_values(engine, None, t=0.0, y0=y0, h=h).values
    measured = _measured_propagator(engine, mode, start, h, steps)
    predicted = predicted_propagator(mode.mu, problem, time=steps * h)
    length = steps * h
    scale = float(np.linalg.norm(predicted, 2))
    return Growth(
        zeta=mode.zeta,
        mu=mode.mu,
        time=length,
        measured=measured,
        predicted=predicted,
        rate=_rate(measured, length),
        predicted_rate=_rate(predicted, length),
        discrepancy=float(np.linalg.norm(measured - predicted, 2)) / scale,
    )


def _rate(propagator: np.ndarray, time: float) -> float:
    radius = float(np.max(np.abs(np.linalg.eigvals(propagator))))
    return math.log(radius) / time


def _measured_propagator(
    engine: Stepper, mode: Mode, start: np.ndarray, h: float, steps: int
) -> np.ndarray:
    d = engine.problem.dimension
    real = abs(mode.zeta.imag) < 1e-9
    # Re(v e) carries half of the mode and half of its conjugate; the left vector takes its own
    direction = np.real(mode.right) if real else 2 * np.real(mode.right)
    base = Underlying(engine).run(0.0, start, h, steps)
    columns = []
    for k in range(d):
        nudged = start.copy()
        nudged[:, k] += NUDGE * direction
        end = Underlying(engine).run(0.0, nudged, h, steps)
        columns.append(mode.left @ (end - base) / (NUDGE * mode.zeta**steps))
    propagator = np.stack(columns, axis=1)
    return np.real(propagator) if real else propagator


def predicted_propagator(mu: complex, problem: Problem, *, time: float) -> np.ndarray:
    """Solve ``Phi' = mu f'(y) Phi``, ``Phi(0) = I``, along the solution y; return Phi(time)."""
    # 400 for each unit of the problem's scale leave an error near 1e-9 of the result
    steps = max(1, math.ceil(400 * time / float(problem.scales.get("time", 1.0))))
    k = time / steps
    real = abs(complex(mu).imag) < 1e-12
    factor: Any = float(np.real(mu)) if real else mu
    y = np.array(problem.y0, dtype=float)
    phi = np.eye(len(y), dtype=float if real else complex)

    def slope(t: float, y: np.ndarray, phi: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.asarray(problem.f(t, y)), factor * (np.asarray(problem.jacobian(t, y)) @ phi)

    for n in range(steps):
        t = n * k
        a, b = slope(t, y, phi)
        c, d = slope(t + k / 2, y + k / 2 * a, phi + k / 2 * b)
        e, g = slope(t + k / 2, y + k / 2 * c, phi + k / 2 * d)
        i, j = slope(t + k, y + k * e, phi + k * g)
        y = y + k / 6 * (a + 2 * c + 2 * e + i)
        phi = phi + k / 6 * (b + 2 * d + 2 * g + j)
    return phi
