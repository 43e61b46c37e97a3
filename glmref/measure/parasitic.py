"""Parasitic growth: the rate measured, the rate that mu f' gives, and when a run was lost.

To each eigenvalue zeta != 1, |zeta| = 1, of V belongs a parasitic component phi. By theory it
follows ``phi' = mu f'(y) phi`` to leading order in h. Here it is *measured*: the method is run
twice from starting values that differ by a small amount along the eigenvector of zeta, and the
difference, read off by the left eigenvector and turned back by ``zeta^-n``, is phi.
To all orders of h: :mod:`.prediction`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..engine.outcome import Outcome, Solution
from ..engine.reference import Stepper, stepper
from ..engine.starting_values import starting_values
from ..errors import UsageError
from ..method import GLM, Method
from ..method.preconsistency import preconsistency_vector
from ..problems.model import Problem
from .longtime import energy_deviation
from .underlying import Underlying

#: A run is lost when the values beyond ``u y_1`` reach this part of the first solution value.
LOST = 1 / 3
#: Size of the perturbation that makes a parasitic component visible: its square is what linear
#: growth neglects, its inverse times 2e-16 is the round-off; both stay far below one per cent.
NUDGE = 1e-7


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
    """Measure one parasitic propagator with the reference engine, and predict it from mu f'.

    The problem is nonlinear and autonomous, the time is rounded to whole steps, and the mode is the
    first of :func:`modes` by default.

    Raises
    ------
    UsageError
        For a method without parasitic modes.
    ArithmeticError
        When a stage equation could not be solved.
    """
    found = modes(method)
    if mode is None:
        if not found:
            raise UsageError(f"{method.name or 'the method'} has no parasitic mode on the circle")
        mode = found[0]
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
    """Solve ``Phi' = mu f'(y) Phi``, ``Phi(0) = I``, along the solution y; return Phi(time).

    The problem is autonomous, and mu the growth parameter.

    Raises
    ------
    UsageError
        Where the problem has no Jacobian, given or derived from expressions.
    """
    if problem.jacobian is None:
        raise UsageError(f"{problem.name} gives no Jacobian; mu f' cannot be formed")
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
