"""Ensembles: 10,000 trajectories in lanes against trajectories one by one, in one thread each.

Kepler with eccentricities spread over [0, 0.6] and Hénon-Heiles with initial momenta of one energy.
The time in lanes is that of the whole call; one by one it is that of the kernel alone, on every
400th trajectory.

``python -m tools.measure.compare_lanes`` compares threads: whole calls, seconds of the clock, least
of interleaved repetitions, with one thread and with two, four .. up to all processors; with
``loops``, right-hand sides with loops over sites or bodies: 16 trajectories one by one and in
vectors of lanes, the steps alone, least of interleaved repetitions.
"""

from __future__ import annotations

import math
import os
import sys
import time
from dataclasses import dataclass, replace

import numpy as np

from glmref.catalogue.lookup import load
from glmref.engine.ensemble import solve_ensemble
from glmref.engine.kernel import prepare
from glmref.engine.reference import stepper
from glmref.engine.runners import Lanes, Runner, Singles
from glmref.engine.starting_values import zero_start
from glmref.problems import problem
from tools.measure.timing import interleaved, quartiles

LANES, STEPS, SAMPLE = 10_000, 1000, 25
METHODS = ("rk4", "gauss-2", "gauss-3", "s4-symmetric", "g6245", "stormer-verlet")


def kepler_starts() -> np.ndarray:
    """Return the perihelion of orbits with semi-axis 1, shape (N, 4)."""
    e = np.linspace(0.0, 0.6, LANES)
    zero = np.zeros(LANES)
    return np.stack([1 - e, zero, zero, np.sqrt((1 + e) / (1 - e))], axis=1)


def henon_heiles_starts() -> np.ndarray:
    """Return the origin with momenta of energy 1/12 in all directions, shape (N, 4)."""
    angle = np.linspace(0.0, 2 * math.pi, LANES, endpoint=False)
    zero = np.zeros(LANES)
    size = math.sqrt(1 / 6)
    return np.stack([zero, zero, size * np.cos(angle), size * np.sin(angle)], axis=1)


PROBLEMS = {
    "kepler": (kepler_starts, 2 * math.pi / 200),
    "henon-heiles": (henon_heiles_starts, 0.1),
}


@dataclass(frozen=True)
class Row:
    """One method on one problem."""

    method: str
    problem: str
    width: int  #: Lanes per block.
    #: Quartiles of the time of one step of one trajectory: in lanes, one by one.
    nanoseconds: dict[str, tuple[float, float, float]]
    gain: float  #: The second over the first, medians.


def measure(name: str, of: str, *, repeats: int) -> Row:
    """Time one method on one problem."""
    starts, h = PROBLEMS[of]
    initial, subject, method = starts(), problem(of), load(name)
    options = {"h": h, "steps": STEPS, "start": "zero", "threads": 1}
    found = solve_ensemble(subject, method, initial, **options)
    if not found.completed:
        raise ArithmeticError(f"{name} on {of}: a trajectory did not complete")
    kernel = prepare(method, replace(subject, y0=tuple(initial[0])), h=h)
    sample = initial[:: LANES // SAMPLE]
    values = zero_start(stepper(method, subject), sample)
    slopes = [np.asarray(subject.f(0.0, y)) for y in sample]
    par, out = kernel.shape.values, np.zeros(1)

    def one_by_one() -> None:
        for value, slope in zip(values, slopes, strict=True):
            state = kernel.state(value, slope, h)
            kernel.built.kernel(state.work, par, 0.0, h, 0, 10 * STEPS, -1, 0, out, 0, state.tally)

    spent = interleaved(
        {
            "lanes": lambda: solve_ensemble(subject, method, initial, **options),
            "single": one_by_one,
        },
        repeats,
    )
    per = {"lanes": LANES * STEPS, "single": len(sample) * STEPS * 10}
    times = {key: quartiles([1e9 * x / per[key] for x in spent[key]]) for key in per}
    return Row(name, of, found.width, times, times["single"][1] / times["lanes"][1])


def measure_all(*, repeats: int = 5) -> list[Row]:
    """Return every method on every problem."""
    return [measure(name, of, repeats=repeats) for of in PROBLEMS for name in METHODS]


#: What is run over threads: it takes longer than the start of a thread.
THREADED = ("stormer-verlet", "rk4", "gauss-3", "pair-rkn-6-8b")


def threads(*, repeats: int = 4) -> None:
    """Print the table of ensembles over threads."""
    most = os.cpu_count() or 1
    counts = [2**k for k in range(most.bit_length())]
    heads = ("problem", "method", *(f"{n} threads, s" for n in counts), "gain")
    sys.stdout.write(f"| {' | '.join(heads)} |\n|{' --- |' * len(heads)}\n")
    for of, (starts, h) in PROBLEMS.items():
        initial, subject = starts(), problem(of)
        for name in THREADED:
            method, spent = load(name), dict.fromkeys(counts, math.inf)
            for n in counts * (repeats + 1):  # the first call of each compiles
                begin = time.perf_counter()
                solve_ensemble(subject, method, initial, h=h, steps=STEPS, start="zero", threads=n)
                spent[n] = min(spent[n], time.perf_counter() - begin)
            cells = [of, name, *(f"{x:.3g}" for x in spent.values())]
            cells.append(f"**{spent[1] / spent[counts[-1]]:.2f}**")
            sys.stdout.write(f"| {' | '.join(cells)} |\n")
            sys.stdout.flush()


#: Problems with loops, their parameters and step sizes.
LOOPS: tuple[tuple[str, dict[str, int], float], ...] = (
    ("outer-solar-system", {}, 50.0),
    *(("n-body", {"bodies": n}, 1e-4) for n in (3, 8, 16, 32)),
    *(("fput", {"sites": n}, 0.05) for n in (11, 32, 128, 512)),
    *(("toda", {"sites": n}, 0.05) for n in (11, 32, 128)),
    *(("nonseparable-chain", {"sites": n}, 0.01) for n in (11, 32, 128)),
)
LOOPED = ("stormer-verlet", "rk4", "pair-rkn-6-8b", "gauss-3", "g6245-w3")
TOGETHER = 16


def loops(*, repeats: int = 7, seconds: float = 0.02) -> None:
    """Print the table of right-hand sides with loops."""
    heads = ("problem", "method", "KiB", "one by one, ns", "8 lanes, ns", "16 lanes, ns", "gain")
    sys.stdout.write(f"| {' | '.join(heads)} |\n|{' --- |' * len(heads)}\n")
    for of, parameters, h in LOOPS:
        subject = problem(of, **parameters)
        spread = np.random.default_rng(3).uniform(-0.01, 0.01, (TOGETHER, subject.dimension))
        initial = np.array(subject.y0) * (1 + spread)
        for name in LOOPED:
            method = load(name)
            if method.parts == 2 and not subject.separable:
                continue
            values = zero_start(stepper(method, subject), initial)
            given = (method, subject, initial[0], h, "strict", "fixed-point", 1)
            single: Runner = Singles(*given, 1, None)
            runners = {1: single, **{width: Lanes(*given, width, None) for width in (8, 16)}}
            steps = 4
            while _spent(single, values, steps) < seconds:
                steps *= 2
            best = dict.fromkeys(runners, math.inf)
            for width in [*runners] * repeats:
                best[width] = min(best[width], _spent(runners[width], values, steps))
            each = [1e9 * x / (steps * TOGETHER) for x in best.values()]
            label = ", ".join([of, *(str(n) for n in parameters.values())])
            kib = runners[8].source.work_size // 128  # type: ignore[attr-defined]
            cells = [label, name, str(kib), *(f"{x:.3g}" for x in each)]
            sys.stdout.write(f"| {' | '.join(cells)} | **{each[0] / each[1]:.1f}** |\n")
            sys.stdout.flush()


def _spent(runner: Runner, values: np.ndarray, steps: int) -> float:
    """Return processor seconds of steps from these values."""
    runner.load(values)
    begin = time.process_time()
    runner.advance(0, steps)
    spent = time.process_time() - begin
    if runner.read()[1].any():
        raise ArithmeticError(f"{runner.method.name} on {runner.problem.name}: a run has failed")
    return spent


if __name__ == "__main__":
    loops() if sys.argv[1:] == ["loops"] else threads()
