"""Evaluations of splittings in extended phase space, against explicit multistep pairs.

    python -m campaigns.partitioned.extended data/measurements/nonseparable.json

H(q, p) is doubled to H(q, y) + H(x, p). Each part has an explicit flow: the slope of the system at
u = (q, y) moves w = (x, p) and leaves u, that at w moves u, so that every splitting of the
catalogue applies. The copies start equal, and (q, p) is the solution. Four ways to hold them:

free
    not at all (Pihajoki, Celest. Mech. Dyn. Astron. 121 (2015), 211-231).
bound
    by the third part omega (|q - x|^2 + |p - y|^2)/2, in the middle of every Störmer-Verlet step
    of a composition (Tao, Phys. Rev. E 94 (2016), 043303, equations 1 to 3).
mixed
    both are set to their mean after every step (Luo, Wu, Huang, Liu, Astrophys. J. 834 (2017), 64).
projected
    symmetrically on equal copies: with a multiplier before and after the step, by simplified
    Newton iterations (Jayawardana, Ohsawa, Math. Comp. 92 (2023), 251-281, algorithm 1).
"""

from __future__ import annotations

import json
import math
import sys
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import chain, zip_longest
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, complete
from glmref.catalogue.lookup import load
from glmref.measure.work_precision import reference_state
from glmref.method import PartitionedGLM
from glmref.problems import problem
from glmref.problems.model import Problem
from glmref.scenes.reading import load_scene

#: Splittings by how the copies are held: of order 4, 6, 6, 8 and 8, for any separable Hamiltonian;
#: compositions of Störmer-Verlet steps where they are bound; the best of order 6 and 8 otherwise.
METHODS = {
    "free": (
        "suzuki-verlet-4",
        "blanes-moan-6",
        "yoshida-verlet-6",
        "kahan-li-8",
        "suzuki-umeno-8",
    ),
    "bound": ("suzuki-verlet-4", "yoshida-verlet-6", "kahan-li-8"),
    "mixed": ("blanes-moan-6", "kahan-li-8"),
    "projected": ("blanes-moan-6", "kahan-li-8"),
}
#: Constants of the binding, of which the better counts: copies that are bound weakly may part, and
#: the bound on the error grows with the constant.
OMEGAS = (1.0, 5.0)
TOLERANCES = (1e-6, 1e-9)
SCENES = Path(__file__).parents[2] / "docs" / "nonseparable"
#: Steps of the first run, most evaluations, and the factor between two runs.
_FIRST, _MOST, _FACTOR = 20, 40_000, 1.25
#: Where a projection ends, relative to the solution, and how many iterations it may take.
_PROJECTED, _ITERATIONS = 1e-13, 50


def strokes(method: str) -> list[tuple[int, float]]:
    """Return the flows of a symmetric splitting, (part, time over h), the outer part as 0."""
    m = load(method)
    assert isinstance(m, PartitionedGLM)
    halves = sorted(([float(x) for x in c.B[0]] for c in m.components), key=len, reverse=True)
    turns = zip_longest(*([(part, x) for x in half] for part, half in enumerate(halves)))
    return [x for x in chain.from_iterable(turns) if x is not None]


@dataclass(eq=False)
class Copies:
    """The points u = (q, y) and w = (x, p), each moved by the slope at the other."""

    f: Any
    points: np.ndarray  #: (2, 2m) u and w.
    evaluations: int = 0
    _slopes: list[np.ndarray | None] = field(default_factory=lambda: [None, None])

    def put(self, points: np.ndarray) -> None:
        """Go to other points (2, 2m), where no slope is known."""
        self.points, self._slopes = points, [None, None]

    def move(self, part: int, time: float) -> None:
        """Move one point by the slope at the other, which is taken once while that rests."""
        slope = self._slopes[1 - part]
        if slope is None:
            slope = np.array(self.f(0.0, self.points[1 - part]))
            self._slopes[1 - part] = slope
            self.evaluations += 1
        self.points[part] = self.points[part] + time * slope
        self._slopes[part] = None

    def bind(self, angle: float) -> None:
        """Turn (q - x, y - p) by an angle; the sum of the points stays."""
        (dq, dp), mean = np.split(self.points[0] - self.points[1], 2), self.points.mean(axis=0)
        c, s = math.cos(angle), math.sin(angle)
        half = np.r_[c * dq - s * dp, s * dq + c * dp] / 2
        self.put(np.array([mean + half, mean - half]))

    @property
    def solution(self) -> np.ndarray:
        """Return (2m,) q of the one copy and p of the other."""
        m = self.points.shape[1] // 2
        return np.r_[self.points[0, :m], self.points[1, m:]]


def run(
    one: Problem, end: float, steps: int, method: str, copies: str, omega: float = 1.0
) -> tuple[np.ndarray, int]:
    """Return the solution (2m,) at the end and the evaluations of both gradients it took.

    The method is a symmetric splitting, a composition of Störmer-Verlet steps where ``copies``, one
    of :data:`METHODS`, are bound with the constant omega.
    """
    y0 = np.array(one.y0, dtype=float)
    two, h, flows = Copies(one.f, np.array([y0, y0])), end / steps, strokes(method)

    def step() -> None:
        for part, time in flows:
            if copies == "bound" and part == 1:
                two.move(1, h * time / 2)
                two.bind(2 * omega * h * time)
                two.move(1, h * time / 2)
            else:
                two.move(part, h * time)

    for _ in range(steps):
        before, multiplier = two.points[0].copy(), np.zeros_like(y0)
        step()
        if copies == "projected":  # from u + multiplier and w - multiplier to the same after it
            for _ in range(_ITERATIONS):
                apart = (two.points[0] - two.points[1]) / 2 + multiplier
                if np.abs(apart).max() <= _PROJECTED * np.abs(before).max():
                    break
                multiplier = multiplier - apart / 2
                two.put(np.array([before + multiplier, before - multiplier]))
                step()
        if copies in ("mixed", "projected"):
            two.put(np.tile(two.points.mean(axis=0), (2, 1)))
    return two.solution, two.evaluations


def needed(one: Problem, end: float, method: str, copies: str) -> dict[float, int | None]:
    """Return the evaluations for each tolerance, bound copies with the better constant."""
    omegas = OMEGAS if copies == "bound" else OMEGAS[:1]
    found = [evaluations(one, end, method, copies, x) for x in omegas]
    return {t: min((n for x in found if (n := x[t])), default=None) for t in TOLERANCES}


def evaluations(
    one: Problem, end: float, method: str, copies: str, omega: float
) -> dict[float, int | None]:
    """Return the evaluations of both gradients for each tolerance, ``None`` where it is missed."""
    exact = reference_state(one, end).state
    found: dict[float, int | None] = dict.fromkeys(TOLERANCES)
    before: tuple[float, float] | None = None
    steps, count = _FIRST, 0
    while count <= _MOST / _FACTOR and None in found.values():
        with np.errstate(all="ignore"):
            y, count = run(one, end, steps, method, copies, omega)
            error = float(np.abs(y - exact).max() / np.abs(exact).max())
        now = math.log(count), math.log(error) if error < 1 else 0.0
        for tolerance, known in found.items():
            level = math.log(tolerance)
            if known is None and now[1] <= level and before is not None:
                part = (level - before[1]) / (now[1] - before[1])
                found[tolerance] = round(math.exp(before[0] + part * (now[0] - before[0])))
        before, steps = now, math.ceil(steps * _FACTOR)
    return found


@cache
def scenes() -> dict[str, Path]:
    """Return the scene of each problem."""
    found = {x: tomllib.loads(x.read_text(encoding="utf-8")) for x in sorted(SCENES.glob("*.toml"))}
    return {scene["problem"]["name"]: x for x, scene in found.items() if "problem" in scene}


@cache
def ends() -> dict[str, float]:
    """Return the last time of each problem, as its scene has it."""
    return {name: load_scene(path).t_end for name, path in scenes().items()}


def rows(names: Sequence[str]) -> list[dict[str, Any]]:
    """Return the evaluations on problems, by tolerance, way to hold the copies, and method."""
    found = []
    for name in names:
        one = problem(name)
        for copies, methods in METHODS.items():
            counts = {x: needed(one, ends()[name], x, copies) for x in methods}
            found += [
                {"problem": name, "tolerance": t, "copies": copies}
                | {"methods": {k: x[t] for k, x in counts.items()}}
                for t in TOLERANCES
            ]
    return found


def main(path: Path) -> None:
    """Measure on the problems of the record, and write them into it."""
    record = json.loads(path.read_text(encoding="utf-8"))
    names = dict.fromkeys(x["problem"] for x in record["evaluations"])
    record["extended"] = rows(list(names))
    complete(path, record)


if __name__ == "__main__":
    main(Path(arguments(sys.argv[1:])[0]))
