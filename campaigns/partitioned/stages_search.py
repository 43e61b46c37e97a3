"""Explicit symmetric multivalue methods for q'' = k(q) with several kicks a step, measured.

    python -m campaigns.partitioned.stages_search front data/measurements/multistep-front.json
    python -m campaigns.partitioned.stages_search resonances data/measurements/multistep-growth.json

A step of length h kicks the 1 + 2 m values of p at s abscissae, ``p += h b_i k(q)``, and moves q
between them, ``q += h phi_i p``; after the last drift V turns pair j of the values by theta_j. It
is the same backwards. s = 1 is the multistep method of :mod:`.multistep_search`.

Unknown are the angles, the kicks, complex numbers for each pair in the basis of the turns at the
middle of the step, and the abscissae. The drifts follow: all stages are the solution to order
2 m + 2 if they match the powers x, x^3, .. of a drift that is its own mirror image, and all
powers of another, where the forces are exp(x t / h).
"""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import toeplitz

from campaigns.driver import arguments, carried_out, complete, record_of
from campaigns.pages import markdown
from campaigns.partitioned import multistep_search as one
from campaigns.partitioned.held_out_problems import PROBLEMS, problem_of
from campaigns.partitioned.multistep_search import Training
from glmref.catalogue.lookup import load
from glmref.method import PartitionedGLM

#: Terms of the power series.
LENGTH = 22
#: Kepler's problem with e = 0.2 and 0.5, Hénon-Heiles, a pendulum, a Toda chain: training data.
CASES: tuple[Training, ...] = (
    one._kepler(0.2, 10, 150, 6000, watched=True),
    one._kepler(0.5, 8, 250, 12000),
    *(one.CASES[k] for k in (2, 3, 4)),
)
#: Evaluations of a run that looks for growth.
STEPS = 40_000


@dataclass(frozen=True, eq=False)
class Stages:
    """A method."""

    angles: np.ndarray  #: (m,) of the pairs of roots, for a whole step, in radians, in (0, pi).
    abscissae: np.ndarray  #: (s,) of the kicks, mirrored about 0, in (-1/2, 1/2).
    #: (s, m) complex, mirrored by conjugation. The kicks of the sum have the weight 1 / s.
    kicks: np.ndarray

    @property
    def s(self) -> int:
        """Number of kicks."""
        return len(self.abscissae)


def exponential(rate: float) -> np.ndarray:
    """Return coefficients of exp(rate x)."""
    return np.array([rate**k / math.factorial(k) for k in range(LENGTH)])


def times(a: np.ndarray) -> np.ndarray:
    """Return the matrix that multiplies a power series by another."""
    return toeplitz(a, np.zeros(LENGTH))


def _shifted(a: np.ndarray, places: int) -> np.ndarray:
    return np.concatenate([np.zeros(places), a[:-places]])


def drifts(stages: Stages) -> tuple[np.ndarray, np.ndarray]:
    """Return weights of the drifts and of the kicks, each (s, 1 + 2 m), in real values."""
    s, m, theta = stages.s, len(stages.angles), stages.angles
    forces = [_shifted(exponential(c), 2) for c in stages.abscissae]  # x^2 exp(x c)
    step = times(exponential(1.0))
    # the values before the first kick of a step: y = exp(i theta - x) (y + sum of kicks)
    sums = np.linalg.solve(
        times(np.append(exponential(1.0)[1:], 0)),
        np.append(sum(forces)[1:] / s, 0),  # type: ignore[index]
    )
    values = [sums.astype(complex)]
    for j in range(m):
        kicked = sum(b * f for b, f in zip(stages.kicks[:, j], forces, strict=True))
        values.append(np.linalg.solve(step * np.exp(-1j * theta[j]) - np.eye(LENGTH), kicked))
    phi, b = np.zeros((s, 1 + 2 * m)), np.zeros((s, 1 + 2 * m))
    for i, force in enumerate(forces):
        b[i] = [1 / s, *np.column_stack([stages.kicks[i].real, stages.kicks[i].imag]).ravel()]
        kicks = [1 / s, *stages.kicks[i]]
        values = [v + k * force for v, k in zip(values, kicks, strict=True)]
        last = i == s - 1
        here, there = (
            stages.abscissae[i],
            1 + stages.abscissae[0] if last else stages.abscissae[i + 1],
        )
        middle = (here + there) / 2
        moved = exponential(there - middle) - exponential(here - middle)
        turn = np.exp(0.5j * theta) if last else np.ones(m)
        centred = times(exponential(-middle))
        seen = [centred @ v for v in values]
        pairs = [t * v for t, v in zip(turn, seen[1:], strict=True)]
        mirrored = last or 2 * (i + 1) == s
        columns = [seen[0].real, *(v.real for v in pairs)]
        columns += [] if mirrored else [v.imag for v in pairs]
        rows = slice(1, 2 * m + 2, 2 if mirrored else 1)
        found = np.linalg.solve(np.array(columns).T[rows], moved[rows])
        weight = found[1 : m + 1] + (0 if mirrored else 1j * found[m + 1 :])
        weight = weight.conj() * turn  # Re(weight y) moves q
        phi[i] = [found[0], *np.column_stack([weight.real, -weight.imag]).ravel()]
    return phi, b


def _on_oscillator(stages: Stages) -> Callable[[float], np.ndarray]:
    """Return the matrix of one step on q'' = -q, a function of the time for one evaluation."""
    phi, b = drifts(stages)
    s, r = phi.shape
    turn = np.eye(r + 1)
    for j, angle in enumerate(stages.angles):
        c, d = math.cos(angle), math.sin(angle)
        turn[2 + 2 * j : 4 + 2 * j, 2 + 2 * j : 4 + 2 * j] = [[c, -d], [d, c]]

    def matrix(y: float) -> np.ndarray:
        step = np.eye(r + 1)
        for i in range(s):
            kick, drift = np.eye(r + 1), np.eye(r + 1)
            kick[1:, 0], drift[0, 1:] = -s * y * b[i], s * y * phi[i]
            step = drift @ kick @ step
        return turn @ step

    return matrix


def interval(stages: Stages, count: int = 200) -> float:
    """Return the end of the periodicity interval for one evaluation, to 1/count, not proved."""
    matrix = _on_oscillator(stages)
    for k in range(1, count + 1):
        if np.abs(np.abs(np.linalg.eigvals(matrix(k / count))) - 1).max() > 1e-6:
            return (k - 1) / count
    return 1.0


def reach(stages: Stages, tolerance: float = 1e-10) -> float:
    """Return the largest h omega an evaluation up to which the relative phase error is smaller."""
    matrix, found = _on_oscillator(stages), 0.0
    for y in np.geomspace(0.04, 1, 100).tolist():
        exact = np.exp(1j * stages.s * y)
        values = np.linalg.eigvals(matrix(y))
        error = np.abs(values - exact).min() / (stages.s * y)
        if error > tolerance or np.abs(np.abs(values) - 1).max() > 1e-6:
            break
        found = y
    return found


@dataclass(frozen=True, eq=False)
class _Compiled:
    """The numbers of a method as the C source takes them."""

    s: int
    phi: np.ndarray
    b: np.ndarray
    turns: np.ndarray
    abscissae: np.ndarray

    def run(self, case: Training, h: float, steps: int) -> tuple[float, np.ndarray]:
        """Return growth of the roughness and positions at the end, after steps of length h."""
        q, p = (np.array(x, dtype=float) for x in (case.q0, case.p0))
        end, pointer = np.zeros(len(q)), one._pointer
        run = one._library().stages
        run.restype = ctypes.c_double
        grown = run(
            case.kind, len(q), self.s, len(self.turns), pointer(self.phi), pointer(self.b),
            pointer(self.turns), pointer(self.abscissae), pointer(q), pointer(p),
            ctypes.c_double(h), ctypes.c_long(steps), 16, pointer(end),
        )  # fmt: skip
        return grown, end

    def error(self, case: Training, evaluations: int) -> float:
        """Return the relative error of the positions at the end."""
        steps = max(2, round(evaluations / self.s))
        _, end = self.run(case, case.t_end / steps, steps)
        with np.errstate(all="ignore"):
            error = np.linalg.norm(end - case.solution()) / np.linalg.norm(case.solution())
        return float(error) if math.isfinite(error) else math.inf


def compiled(stages: Stages) -> _Compiled:
    """Prepare a method for the C source."""
    phi, b = drifts(stages)
    turns = np.column_stack([np.cos(stages.angles), np.sin(stages.angles)])
    return _Compiled(
        stages.s, *map(np.ascontiguousarray, (phi, b, turns, stages.abscissae.astype(float)))
    )


def gap(angles: np.ndarray) -> float:
    """Return the least distance of two roots on the circle, in degrees."""
    ordered = np.sort(np.degrees(angles))
    return float(min([*np.diff(ordered), 2 * (180 - ordered[-1])]))


def evaluations(stages: Stages, cases: Sequence[Training] = CASES) -> np.ndarray:
    """Return what each case needs (row) for each tolerance (column)."""
    method = compiled(stages)
    return np.array([one.needed_by(lambda n, c=c: method.error(c, n), c.least) for c in cases])


def growth(stages: Stages, counts: np.ndarray, cases: Sequence[Training] = CASES) -> float:
    """Return decades by which the roughness grows beyond a factor five, over all watched runs."""
    method, total = compiled(stages), 0.0
    for case, row in zip(cases, counts, strict=True):
        for n in row if case.watched else ():
            for scale in (1.0, 0.9):
                steps = max(2, round(n / stages.s))
                grown, _ = method.run(case, case.t_end / steps * scale, STEPS // stages.s)
                total += max(0.0, math.log10(min(max(grown, 1.0), 1e12)) - 0.7)
    return total


# --- resonances -----------------------------------------------------------------------------------

#: Methods whose parasitic components are looked at, and orbits with their fastest frequency.
SCANNED = (
    *("multistep-rkn-8", "multistep-rkn-10", "multistep-rkn-12", "quinlan-tremaine-8"),
    *("quinlan-tremaine-10", "quinlan-tremaine-12", "quinlan-tremaine-14"),
)
ORBITS = (
    ("pendulum (2.5, 0)", Training(2, [2.5], [0], 50, 80, 6000), 1.0),
    ("Kepler 0.2", CASES[0], 0.8**-1.5),
)
GROWN = 100.0
GROWTH_NOTE = (
    "5,000 steps from exact positions; a size is marked where the eighth difference of the "
    f"velocities grows by more than {GROWN:g} from the first 2,000 steps to the last 2,000, or the "
    "orbit is lost. Sizes are h omega."
)


def of_file(name: str) -> Stages:
    """Return a symmetric multistep method of the catalogue by the angles of the roots of V."""
    method = load(name)
    assert isinstance(method, PartitionedGLM)
    V = np.array([[float(x) for x in row] for row in method.V_hat])
    found = np.angle(np.linalg.eigvals(V))
    angles = np.sort(found[found > 1e-3])
    return Stages(angles, np.zeros(1), np.ones((1, len(angles)), dtype=complex))


def ranges(marked: Sequence[bool], sizes: Sequence[float]) -> list[list[float]]:
    """Return the first and last of the sizes that are marked without one between that is not."""
    rows: list[list[float]] = []
    for before, here, size in zip([False, *marked], marked, sizes, strict=False):
        if here and before:
            rows[-1][1] = size
        elif here:
            rows.append([size, size])
    return rows


def resonances(path: Path, count: int = 4000, steps: int = 5000) -> None:
    """Look for growth at so many step sizes, up to the end of the interval, and write a file."""
    title = f"Growth of symmetric multistep methods at {count:,} step sizes"
    command = "partitioned.stages_search resonances"
    record = record_of(command, "multistep-growth", title, GROWTH_NOTE)
    size = {"count": count, "steps": steps}
    tasks = ({"method": name, "orbit": x, **size} for name in SCANNED for x, _, _ in ORBITS)
    record["scans"] = carried_out(growth_row, tasks, beside=path)
    complete(path, record)


def growth_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Look for growth of one method with one kick on one orbit."""
    stages = of_file(task["method"])
    method = compiled(stages)
    return scanned(
        task, interval(stages, 1000), lambda case, h: method.run(case, h, task["steps"])[0]
    )


def scanned(
    task: Mapping[str, Any], end: float, run: Callable[[Training, float], float]
) -> dict[str, Any]:
    """Return the step sizes per evaluation, up to the end of an interval, with growth."""
    count = task["count"]
    orbit, case, frequency = next(x for x in ORBITS if x[0] == task["orbit"])
    sizes = end / count * np.arange(count // 20 + 1, count + 1)
    grown = [run(case, float(h) / frequency) > GROWN for h in sizes]
    return {
        "method": task["method"],
        "orbit": orbit,
        "end": end,
        "sizes": len(sizes),
        "marked": sum(grown),
        "ranges": [[round(h, 4) for h in row] for row in ranges(grown, sizes.tolist())],
    }


def growth_table(document: Mapping[str, Any]) -> str:
    """Return where methods grow, in Markdown."""
    heads = "method, orbit, end of the interval, step sizes with growth, first, the widest"
    rows = []
    for x in document["scans"]:
        widest = sorted(sorted(x["ranges"], key=lambda r: r[0] - r[1])[:3])
        shown = ", ".join(f"{a:g} to {b:g}" if a < b else f"{a:g}" for a, b in widest) or "none"
        first = f"{x['ranges'][0][0]:g}" if x["ranges"] else "-"
        marked = f"{x['marked']:,} of {x['sizes']:,}"
        rows.append([f"`{x['method']}`", x["orbit"], f"{x['end']:g}", marked, first, shown])
    return markdown(heads.split(", "), rows)


# --- the front ------------------------------------------------------------------------------------

#: Methods with two kicks that descents ended with, in degrees: angles, phases of the first kick,
#: and the abscissa of the second kick. The first is the end of a descent that looked at the phase
#: on the oscillator and the periodicity interval alone, the next two went on from such ends on
#: :data:`CASES`. The last two were solved for from random starts, and descents went on among the
#: solutions.
FOUND: Mapping[str, tuple[Sequence[float], Sequence[float], float]] = {
    "two kicks, by the phase": (
        (85.1087, 111.5989, 166.3418, 133.5990),
        (-136.2806, -144.3009, 57.8357, -18.4078),
        0.2315,
    ),
    "two kicks, a": (
        (85.1895, 115.2094, 167.2756, 133.5992),
        (-136.1477, -146.2159, 58.6861, -15.1618),
        0.22936,
    ),
    "two kicks, b": (
        (130.1306, 158.8377, 121.8078, 104.2992),
        (13.681, -1.9625, 68.9425, 154.6199),
        0.204609,
    ),
    "two kicks, solved for order 10": (
        (150.2299, 142.7119, 108.5307),
        (163.9768, -26.9085, 88.1089),
        0.33587,
    ),
    "two kicks, solved for order 12": (
        (123.6967, 150.0372, 113.9541, 103.6333),
        (-25.0351, 134.6609, -130.2476, -53.4583),
        0.35087,
    ),
}


def held_out() -> dict[str, Training]:
    """Return the held-out problems whose force the C source has, with short horizons."""
    kinds = {"kepler": 0, "henon-heiles": 1, "toda ring": 3}
    found = {}
    for name, held in PROBLEMS.items():
        kind = next((k for word, k in kinds.items() if name.startswith(word)), None)
        if kind is not None:
            y = [float(x) for x in problem_of(name).y0]
            q0, p0 = y[: len(y) // 2], y[len(y) // 2 :]
            found[name] = Training(kind, q0, p0, held.t_end, held.least, 60 * held.least)
    return found


FRONT_NOTE = (
    "evaluations: geometric mean over the training problems. held out: on the eight problems of "
    "held_out_problems whose forces the search has, short horizons. reach: largest h omega for one "
    "evaluation up to which the error of the phase is below 1e-10. growth: decades, summed over "
    f"runs of {STEPS:,} evaluations."
)


def found(name: str) -> Stages:
    """Return one of :data:`FOUND`."""
    angles, phases, place = FOUND[name]
    kick = np.exp(1j * np.radians(phases))
    return Stages(np.radians(angles), np.array([-place, place]), np.array([kick, kick.conj()]))


def front(path: Path) -> None:
    """Measure :data:`FOUND`, new and published methods with one kick, and write a file."""
    tasks = ({"method": name} for name in (*SCANNED, "quinlan-8a", "quinlan-8b", *FOUND))
    title = "Symmetric multivalue methods with one and two kicks on training problems"
    record = record_of("partitioned.stages_search front", "multistep-front", title, FRONT_NOTE)
    complete(path, record | {"methods": carried_out(front_row, tasks, beside=path)})


def _by_tolerance(counts: np.ndarray) -> dict[str, int]:
    return {f"{t:.0e}": round(float(x)) for t, x in zip(one.TOLERANCES, counts, strict=True)}


def front_row(task: Mapping[str, Any]) -> dict[str, Any]:
    """Measure a method on the training problems."""
    name = task["method"]
    stages = found(name) if name in FOUND else of_file(name)
    counts, held = evaluations(stages), held_out()
    mean = np.exp(np.log(counts).mean(axis=0))
    return {
        "method": name,
        "kicks": stages.s,
        "pairs": len(stages.angles),
        "interval": interval(stages),
        "reach": round(reach(stages), 3),
        "evaluations": _by_tolerance(mean),
        "held out": {
            name: _by_tolerance(row)
            for name, row in zip(held, evaluations(stages, [*held.values()]), strict=True)
        },
        "growth": round(growth(stages, counts), 1),
    }


def front_table(document: Mapping[str, Any]) -> str:
    """Return the front in Markdown; on held-out problems over the best published method of each."""
    heads = (
        "method, kicks, pairs, interval, reach, at $10^{-6}$, at $10^{-9}$, "
        "held out: $10^{-6}$, $10^{-9}$, growth"
    )
    rows = []
    published = [x["held out"] for x in document["methods"] if x["method"].startswith("quinlan")]
    for x in document["methods"]:
        shares = [
            math.exp(
                math.fsum(
                    math.log(row[key] / min(other[case][key] for other in published))
                    for case, row in x["held out"].items()
                )
                / len(x["held out"])
            )
            for key in x["evaluations"]
        ]
        rows.append(
            [
                *(x["method"], x["kicks"], x["pairs"]),
                *(f"{x[key]:.2f}" for key in ("interval", "reach")),
                *(f"{n:,}" for n in x["evaluations"].values()),
                *(f"{share:.2f}" for share in shares),
                f"{x['growth']:g}",
            ]
        )
    return markdown(heads.split(", "), rows)


if __name__ == "__main__":
    what, file = arguments(sys.argv[1:])
    {"resonances": resonances, "front": front}[what](Path(file))
