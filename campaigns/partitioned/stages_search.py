"""Search for explicit symmetric multivalue methods for q'' = k(q) with several kicks a step.

    python -m campaigns.partitioned.stages_search 2 --angles 67 85 122 152 --seed 1 2 --tries 160
    python -m campaigns.partitioned.stages_search counted 3 10 1 40 120
    python -m campaigns.partitioned.stages_search counted 3 10 1 12 40 3
    python -m campaigns.partitioned.stages_search further "two kicks, solved for order 10" 10 1 400
    python -m campaigns.partitioned.stages_search front data/measurements/multistep-front.json
    python -m campaigns.partitioned.stages_search resonances data/measurements/multistep-growth.json

A step of length h kicks the 1 + 2 m values of p at s abscissae, ``p += h b_i k(q)``, and moves q
between them, ``q += h phi_i p``; after the last drift V turns pair j of the values by theta_j. It
is the same backwards. s = 1 is the multistep method of :mod:`.multistep_search`.

Unknown are the angles, the kicks, complex numbers for each pair in the basis of the turns at the
middle of the step, and the abscissae. The drifts follow: all stages are the solution to order
2 m + 2 if they match the powers x, x^3, .. of a drift that is its own mirror image, and all
powers of another, where the forces are exp(x t / h). The second form (pairs, order, seed, starts,
tries and, unless 2, kicks) solves for unknowns with which the drifts match further powers, and goes
on among the solutions; the third (end, order, seed, tries) goes on from one of the ends. Minimized
is the mean logarithm of the evaluations that are needed on :data:`CASES`, training problems, plus a
penalty for growth.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import toeplitz
from scipy.optimize import least_squares

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
#: Decades of growth cost this much each; evaluations of a run that looks for it.
PENALTY, STEPS = 0.02, 40_000
#: Smallest distance of two angles and from 180 degrees, smallest angle, for one stage; degrees.
APART, FROM_ONE = 3.6, 22


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


def doubled(angles: Sequence[float]) -> Stages:
    """Return two steps of the method with one kick as one; angles in radians."""
    turned = 2 * np.asarray(angles, dtype=float)
    phases = turned / 4
    back = turned > math.pi  # the conjugate pair
    turned, phases = np.where(back, 2 * math.pi - turned, turned), np.where(back, -phases, phases)
    kick = np.exp(1j * phases)
    return Stages(turned, np.array([-0.25, 0.25]), np.array([kick, kick.conj()]))


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
    phi, b, _ = _series(stages)
    return phi, b


def _series(stages: Stages) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return :func:`drifts` and what they leave of each power of x, (s, LENGTH), centred."""
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
    left = np.zeros((s, LENGTH))
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
        left[i] = moved - np.array(columns).T @ found
        weight = found[1 : m + 1] + (0 if mirrored else 1j * found[m + 1 :])
        weight = weight.conj() * turn  # Re(weight y) moves q
        phi[i] = [found[0], *np.column_stack([weight.real, -weight.imag]).ravel()]
    return phi, b, left


def _of(x: np.ndarray, s: int = 2) -> Stages:
    """Return the method with so many kicks, 2 to 4, of its unknowns.

    Angles, phases of the first kick, whose numbers have length 1; with three kicks the numbers of
    the second, which are real, with four their logarithms; the abscissae of the last kicks.
    """
    pairs = (len(x) - s // 2) // s
    angles, phases, *more = np.split(x[: s * pairs], s)
    kicks = [np.exp(1j * phases)]
    middle = more if s == 3 else [np.exp(more[0] + 1j * more[1])] if s == 4 else []
    kicks += middle
    kicks += [x.conj() for x in reversed(kicks[: s // 2])]
    places = x[s * pairs :]
    abscissae = [*-places, *[0.0] * (s % 2), *places[::-1]]
    return Stages(angles, np.array(abscissae), np.array(kicks, dtype=complex))


def solved(x: np.ndarray, order: int, s: int = 2) -> np.ndarray | None:
    """Solve for a method of an order beyond 2 m + 2, from near unknowns.

    A drift that is its own mirror image has to match each further odd power of x, another one each
    further power. With two kicks two orders more cost two conditions on 2 m + 1 unknowns. Levenberg
    and Marquardt's method. ``None`` where no unknowns are found or :func:`allowed` refuses the
    method.
    """
    pairs = (len(x) - s // 2) // s
    rows = [(i, k) for i in range(s // 2) for k in range(2 * pairs + 2, order)
            if k % 2 or 2 * (i + 1) != s]  # fmt: skip
    rows += [(s - 1, k) for k in range(2 * pairs + 3, order, 2)]
    at = tuple(np.array(rows).T)
    scale = np.array([float(math.factorial(k)) for k in at[1]])

    def conditions(x: np.ndarray) -> np.ndarray:
        found = np.zeros(max(len(x), len(rows)))  # as many as unknowns, for the solver
        try:
            found[: len(rows)] = _series(_of(x, s))[2][at] * scale
        except np.linalg.LinAlgError:
            return np.full(len(found), 1e6)
        return np.nan_to_num(found, nan=1e6, posinf=1e6, neginf=-1e6).clip(-1e6, 1e6)

    found = least_squares(conditions, x, method="lm", max_nfev=40 * len(x))
    reached = np.abs(found.fun).max() < 1e-7 and allowed(_of(found.x, s))
    return found.x if reached else None


def counted(pairs: int, order: int, *, seed: int, starts: int, s: int = 2) -> list[np.ndarray]:
    """Return unknowns of :func:`solved` from random starts, those with a periodicity interval."""
    generator, ends = np.random.default_rng(seed), []
    for _ in range(starts):
        angles = np.radians(generator.uniform(s * FROM_ONE, 176, size=pairs))
        phases = generator.uniform(-math.pi, math.pi, size=pairs)
        more = generator.uniform(-1, 1, size=(s - 2) * pairs)
        if s == 4:
            more[pairs:] *= math.pi
        places = np.arange(s - 1, 0, -2) / (2 * s) + generator.uniform(-0.2, 0.2, size=s // 2) / s
        ends.append(solved(np.concatenate([angles, phases, more, places]), order, s))
    return [x for x in ends if x is not None and interval(_of(x, s)) > 0.05]


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


def allowed(stages: Stages) -> bool:
    """Return whether the roots lie apart and the kicks in order."""
    least, s = np.degrees(stages.angles.min()), stages.s
    inside = np.diff([-0.46, *stages.abscissae, 0.46])
    return bool(gap(stages.angles) >= APART * s and least >= FROM_ONE * s and min(inside) > 0)


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


def objective(stages: Stages, bound: float = math.inf) -> float:
    """Return what is minimized; a lower bound of it where that exceeds ``bound``."""
    if not allowed(stages):
        return math.inf
    counts = evaluations(stages)
    value = float(np.log(counts).mean(axis=0) @ np.array(one.WEIGHTS))
    return value if value > bound else value + PENALTY * growth(stages, counts)


def descend(stages: Stages, *, seed: int, tries: int, width: float = 3.0) -> tuple[Stages, float]:
    """Change some or all unknowns at random, and keep what is better; the same for a seed.

    Angles and phases change by degrees, absolute values by hundredths, abscissae by thousandths.
    The kick in the middle, if there is one, keeps its phase.
    """
    generator, best = np.random.default_rng(seed), objective(stages)
    s, m = stages.s, len(stages.angles)

    def change(size: tuple[int, ...] | int) -> np.ndarray:
        return width * generator.normal(size=size) * (generator.random(size) < chance)

    for _ in range(tries):
        chance = 1.0 if generator.random() < 0.5 else 0.3
        kicks, abscissae = stages.kicks.copy(), stages.abscissae.copy()
        for i in range(s // 2):
            lengths = 1 + 0.01 * change(m) * (s > 2)
            kicks[i] *= lengths * np.exp(1j * np.radians(change(m)))
            abscissae[i] += 0.002 * float(change(1)[0])
            kicks[-1 - i], abscissae[-1 - i] = kicks[i].conj(), -abscissae[i]
        angles = stages.angles + np.radians(change(m))
        new = replace(stages, angles=angles, kicks=kicks, abscissae=abscissae)
        try:
            value = objective(new, best)
        except np.linalg.LinAlgError:
            continue
        if value < best:
            stages, best, width = new, value, min(12.0, width * 1.5)
        elif value < math.inf:
            width = max(0.1, width * 0.96)
    return stages, best


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
#: :data:`CASES`. The last two are ends of :func:`count`, 3 10 1 40 120 and 4 12 1 30 60, that were
#: broken off; from the first of them :func:`further` went on with seed 1.
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


def count(pairs: int, order: int, seed: int, starts: int, tries: int, s: int = 2) -> None:
    """Print where :func:`counted` ends, and a random descent among the solutions from the best."""
    ends = counted(pairs, order, seed=seed, starts=starts, s=s)
    sys.stdout.write(f"{pairs} pairs, order {order}: {len(ends)} of {starts} starts\n")
    ranked = sorted(((objective(_of(x, s)), k) for k, x in enumerate(ends)), reverse=True)
    for value, k in ranked:
        sys.stdout.write(f"{_line(_of(ends[k], s), value)}\n")
    if ranked:
        among(ends[ranked[-1][1]], order, seed=seed, tries=tries, s=s)


def among(x: np.ndarray, order: int, *, seed: int, tries: int, s: int = 2) -> None:
    """Print the course of a random descent among the solutions of :func:`solved`."""
    generator, width, best = np.random.default_rng(seed), 0.1, objective(_of(x, s))
    for _ in range(tries):
        step = generator.normal(size=len(x)) * ([1.0] * (len(x) - s // 2) + [0.1] * (s // 2))
        new = solved(x + width * step, order, s)
        value = math.inf if new is None else objective(_of(new, s), best)
        if new is not None and value < best:
            x, best, width = new, value, 1.5 * width
            sys.stdout.write(f"{_line(_of(x, s), best)}\n")
            sys.stdout.flush()
        else:
            width = max(0.005, 0.93 * width)


def further(name: str, order: int, seed: int, tries: int) -> None:
    """Go on from one of :data:`FOUND` among the methods of an order, by :func:`among`."""
    angles, phases, place = FOUND[name]
    begun = solved(np.array([*np.radians(angles), *np.radians(phases), place]), order)
    if begun is None:
        raise SystemExit(f"{name} is not near a method of order {order}")
    among(begun, order, seed=seed, tries=tries)


def descent(task: Mapping[str, Any]) -> str:
    """Run one descent from the doubled method with given angles, or the method itself."""
    angles = np.radians(task["angles"])
    alone = Stages(angles, np.zeros(1), np.ones((1, len(angles)), dtype=complex))
    begun = alone if task["stages"] == 1 else doubled(angles)
    found, value = descend(begun, seed=task["seed"], tries=task["tries"])
    return _line(found, value)


def _line(found: Stages, value: float) -> str:
    phases = np.degrees(np.angle(found.kicks[0])).round(4).tolist()
    return (
        f"{value:.4f} interval {interval(found):.3f} angles {np.degrees(found.angles).round(4)} "
        f"phases {phases} abscissae {found.abscissae.round(5)}"
    )


def main(words: Sequence[str]) -> None:
    """Run a descent for each seed, or one of the measurements."""
    if words[:1] in (["resonances"], ["front"]):
        {"resonances": resonances, "front": front}[words[0]](Path(words[1]))
        return
    if words[:1] == ["counted"]:
        count(*map(int, words[1:]))
        return
    if words[:1] == ["further"]:
        further(words[1], *map(int, words[2:]))
        return
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("stages", type=int, choices=(1, 2))
    parser.add_argument("--angles", type=float, nargs="+", required=True, help="of one stage")
    parser.add_argument("--seed", type=int, nargs="+", default=[1])
    parser.add_argument("--tries", type=int, default=100)
    given = parser.parse_args(words)
    same = {"stages": given.stages, "angles": given.angles, "tries": given.tries}
    for line in carried_out(descent, ({**same, "seed": x} for x in given.seed)):
        sys.stdout.write(f"{line}\n")


if __name__ == "__main__":
    main(arguments(sys.argv[1:]))
