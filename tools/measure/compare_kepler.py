"""Kepler, e = 0.6, 1000 periods: time to reach an energy error, against heyoka and scipy's DOP853.

Every integrator gets the largest step size or tolerance of a grid with which its energy error, the
largest of 97 samples, stays below the goal; a method that does so by luck at one step size has to
do so at the next two as well. Then the run without samples is timed. heyoka gets r^-3 as one power,
which is what it is fastest with, and scipy a right-hand side of plain Python numbers. With names of
methods and peers, ``python -m tools.measure.compare_kepler NAME...`` prints the rows of these.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from typing import Any

import numpy as np

from glmref.catalogue.lookup import load
from glmref.engine.kernel import prepare
from glmref.engine.outcome import StartFailed
from glmref.engine.reference import stepper
from glmref.engine.solve import solve
from glmref.engine.starting_values import starting_values
from glmref.measure.longtime import along
from glmref.problems import problem
from tools.measure.timing import interleaved, quartiles

PERIODS, SAMPLES = 1000, 97
GOALS = (1e-9, 1e-12)
#: Steps per period that are tried.
GRID = tuple(round(20 * 1.08**k) for k in range(64))
TOLERANCES = tuple(10 ** (-k / 2) for k in range(16, 33))

METHODS = (
    *(f"gauss-{s}" for s in range(3, 9)), "g6245", "g6245-w3", "order8-s5-w3",
    "s4-symmetric", "kahan-li-8", "suzuki-umeno-8", "blanes-moan-rkn-6-14", "pair-rkn-6-9",
)  # fmt: skip
KEPLER = problem("kepler", eccentricity="3/5")


@dataclass(frozen=True)
class Row:
    """An integrator at one goal."""

    name: str  #: Method or peer.
    goal: float  #: Energy error asked for.
    setting: float  #: Steps per period, or tolerance; ``nan`` where no setting reached the goal.
    error: float  #: Energy error reached there, else the smallest one seen.
    #: Quartiles of the run, empty where the goal was not reached.
    milliseconds: tuple[float, float, float] | tuple[()]
    evaluations: int  #: Right-hand-side evaluations of the run, 0 where it is not told.
    note: str  #: What happened where the goal was not reached, or the solver.


def energy_error(y: np.ndarray) -> float:
    """Return the largest relative deviation of the energy from the initial one."""
    energy = along(KEPLER.hamiltonian, np.vstack([np.array(KEPLER.y0), y]))
    return float(np.max(np.abs(energy / energy[0] - 1)))


class Integrator:
    """One method: its error by steps per period, and the run that is timed."""

    def __init__(self, name: str) -> None:
        self.name, self.method = name, load(name)
        self.seen: dict[int, tuple[float, str]] = {}

    def error(self, n: int) -> float:
        """Return energy error with n steps per period; infinite where the run did not complete."""
        if n not in self.seen:
            steps = n * PERIODS
            h = 2 * math.pi / n
            try:
                run = solve(KEPLER, self.method, h=h, steps=steps, every=steps // SAMPLES)
            except StartFailed as failure:
                self.seen[n] = (math.inf, str(failure))
                return math.inf
            error = energy_error(run.y) if run.completed else math.inf
            self.seen[n] = (error if math.isfinite(error) else math.inf, run.message)
        return self.seen[n][0]

    def setting(self, goal: float) -> int | None:
        """Return the fewest steps per period that reach the goal, there and at the next two."""

        def reached(k: int) -> bool:
            return all(self.error(n) <= goal for n in GRID[k : k + 3])

        low, high = -1, len(GRID) - 3
        if not reached(high):
            return None
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if reached(middle) else (middle, high)
        return GRID[high]

    def run(self, n: int) -> tuple[Callable[[], object], int, str]:
        """Return the run that is timed, start included; its evaluations; the solver."""
        h, steps = 2 * math.pi / n, n * PERIODS
        kernel = prepare(self.method, KEPLER, h=h)
        engine, y0 = stepper(self.method, KEPLER), np.array(KEPLER.y0)
        slope, out = np.asarray(KEPLER.f(0.0, y0)), np.zeros(1)
        tally = np.zeros(6, dtype=np.int64)

        def go() -> None:
            start = starting_values(engine, None, t=0.0, y0=y0, h=h)
            state = kernel.state(start.values, slope, h)
            kernel.built.kernel(
                state.work, kernel.shape.values, 0.0, h, 0, steps, -1, 0, out, 0, state.tally
            )
            tally[:] = state.tally

        go()
        return go, int(tally[0]), kernel.options.solver if kernel.form.implicit_stages else ""


def heyoka_run(tolerance: float, samples: int) -> Callable[[], np.ndarray]:
    """Run heyoka's Taylor integrator; with samples, return the states at them, else the end."""
    heyoka: Any = import_module("heyoka")
    x, y, u, v = heyoka.make_vars("x", "y", "u", "v")
    w = -(heyoka.sum([x**2, y**2]) ** -1.5)
    y0, end = [float(z) for z in KEPLER.y0], 2 * math.pi * PERIODS
    system = [(x, u), (y, v), (u, w * x), (v, w * y)]
    integrator = heyoka.taylor_adaptive(system, y0, tol=tolerance)

    def run() -> np.ndarray:
        integrator.time, integrator.state[:] = 0.0, y0
        if samples:
            times = np.linspace(0.0, end, samples + 1)
            return np.array(integrator.propagate_grid(times.tolist())[-1])[1:]
        integrator.propagate_until(end)
        return np.array([integrator.state])

    return run


def scipy_run(tolerance: float, samples: int) -> Callable[[], np.ndarray]:
    """Run scipy's DOP853 with a right-hand side of plain Python numbers."""
    integrate: Any = import_module("scipy.integrate")
    y0, end = [float(z) for z in KEPLER.y0], 2 * math.pi * PERIODS

    def f(t: float, z: np.ndarray) -> tuple[float, float, float, float]:
        x, y, u, v = z.tolist()
        r2 = x * x + y * y
        w = -1.0 / (r2 * math.sqrt(r2))
        return u, v, w * x, w * y

    times = np.linspace(0.0, end, samples + 1)[1:] if samples else [end]

    def run() -> np.ndarray:
        found = integrate.solve_ivp(
            f, (0.0, end), y0, method="DOP853", rtol=tolerance, atol=tolerance, t_eval=times
        )
        return found.y.T

    return run


PEERS: dict[str, Callable[[float, int], Callable[[], np.ndarray]]] = {
    "heyoka": heyoka_run,
    "scipy DOP853": scipy_run,
}


def peer_setting(make: Callable[[float, int], Callable[[], np.ndarray]], goal: float) -> float:
    """Return the largest tolerance of the grid that reaches the goal."""
    return next(x for x in TOLERANCES if energy_error(make(x, SAMPLES)()) <= goal)


def settings(
    wanted: Sequence[str] = (*METHODS, *PEERS),
) -> dict[float, dict[str, tuple[float, float, str]]]:
    """Return for every goal: integrator -> (setting, error, why there is none). Time nothing."""
    integrators = [Integrator(name) for name in wanted if name not in PEERS]
    found: dict[float, dict[str, tuple[float, float, str]]] = {}
    for goal in GOALS:
        found[goal] = {}
        for one in integrators:
            n = one.setting(goal)
            error, why = min(one.seen.values()) if n is None else one.seen[n]
            found[goal][one.name] = (math.nan if n is None else n, error, why)
        for name, make in PEERS.items():
            if name in wanted and (name == "heyoka" or goal == GOALS[0]):
                tolerance = peer_setting(make, goal)
                error = energy_error(make(tolerance, SAMPLES)())
                found[goal][name] = (tolerance, error, "")
    return found


def measure_all(
    found: dict[float, dict[str, tuple[float, float, str]]], *, repeats: int = 9
) -> list[Row]:
    """Time what :func:`settings` found, goal by goal, all in turn; scipy, being slow, less."""
    rows: list[Row] = []
    for goal, chosen in found.items():
        runs: dict[str, Callable[[], object]] = {}
        notes: dict[str, tuple[int, str]] = {}
        for name, (setting, error, why) in chosen.items():
            if math.isnan(setting):
                rows.append(Row(name, goal, setting, error, (), 0, why))
            elif name in PEERS:
                runs[name], notes[name] = PEERS[name](setting, 0), (0, "tolerance")
            else:
                runs[name], evaluations, solver = Integrator(name).run(int(setting))
                notes[name] = (evaluations, solver)
        slow = {"scipy DOP853"} & runs.keys()
        spent = interleaved({k: x for k, x in runs.items() if k not in slow}, repeats)
        spent |= interleaved({k: runs[k] for k in slow}, 3)
        for name in runs:
            times = quartiles([1e3 * x for x in spent[name]])
            rows.append(Row(name, goal, *chosen[name][:2], times, *notes[name]))
    return rows


if __name__ == "__main__":
    for row in measure_all(settings(sys.argv[1:]), repeats=25):
        sys.stdout.write(f"{row}\n")
