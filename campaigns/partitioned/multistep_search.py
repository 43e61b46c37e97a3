"""Search for roots of explicit symmetric multistep methods: few evaluations, and no growth.

    python -m campaigns.partitioned.multistep_search rkn 4 --seed 1 2 3 --tries 160 --on local

The unknowns are the angles of the pairs of roots, whose cosines are rounded to 1/256; everything
else follows (:mod:`glmref.derive.multistep`). Minimized is the mean logarithm of the evaluations
needed at 1e-9 (weight 0.6) and 1e-6 (0.4) on the training problems :data:`CASES`, plus a penalty,
:data:`PENALTY` unless another is asked for, for each factor ten by which the roughness of the
velocities grows at six step sizes near those needed. A random descent from evenly spread or given
angles, the same for a seed.
"""

from __future__ import annotations

import argparse
import ctypes
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from campaigns.driver import arguments, carried_out
from campaigns.partitioned.work import crossing
from glmref.derive.multistep import Half
from glmref.problems import problem

DENOMINATOR = 256
TOLERANCES = (1e-6, 1e-9)
WEIGHTS = (0.4, 0.6)
#: Grid points to an octave of step sizes, and the most evaluations in units of the fewest.
DENSITY, MOST = 4, 100
PENALTY = 0.015
#: Steps of the runs that look for growth: first few, then many where few show none.
STEPS = (20_000, 100_000)
#: Smallest distance of two angles, smallest and largest angle, in degrees.
APART, LEAST, LARGEST = 4, 25, 172


@cache
def _library() -> ctypes.CDLL:
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        raise SystemExit("this campaign needs a C compiler")
    target = Path(tempfile.mkdtemp()) / "search.so"
    source = Path(__file__).with_suffix(".c")
    options = ["-O3", "-march=native", "-fno-math-errno", "-shared", "-fPIC"]
    subprocess.run([compiler, *options, str(source), "-o", str(target), "-lm"], check=True)
    library = ctypes.CDLL(str(target))
    library.run.restype = ctypes.c_double
    return library


def _pointer(x: np.ndarray) -> Any:
    return x.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


@dataclass(frozen=True, eq=False)
class Training:
    """A training problem: number of its force, initial values, time, fewest evaluations.

    ``watched``: whether long runs look for growth.
    """

    kind: int
    q0: Sequence[float]
    p0: Sequence[float]
    t_end: float
    least: int
    reference_steps: int
    watched: bool = True

    def call(self, name: str, *rest: Any) -> tuple[float, np.ndarray]:
        """Return a function of the C source on this problem: what it returns, and the positions."""
        q, p = (np.array(x, dtype=float) for x in (self.q0, self.p0))
        end = np.zeros(len(q))
        found = getattr(_library(), name)(
            *([self.kind, len(q)] if name == "solution" else [self.kind, len(q), *rest[:3]]),
            _pointer(q), _pointer(p), *(rest if name == "solution" else rest[3:]), _pointer(end),
        )  # fmt: skip
        return found, end

    def solution(self) -> np.ndarray:
        """Return positions at the end."""
        return _solution(self)

    def error(self, a: np.ndarray, b: np.ndarray, steps: int) -> float:
        """Return the relative error of the positions at the end."""
        _, end = self.run(a, b, self.t_end / steps, steps)
        with np.errstate(all="ignore"):
            error = np.linalg.norm(end - self.solution()) / np.linalg.norm(self.solution())
        return float(error) if math.isfinite(error) else math.inf

    def run(self, a: np.ndarray, b: np.ndarray, h: float, steps: int) -> tuple[float, np.ndarray]:
        """Return the growth of the roughness, and the positions at the end."""
        k = len(a) - 1
        return self.call(
            "run", k, _pointer(a), _pointer(b), ctypes.c_double(h), ctypes.c_long(steps), 16
        )


@cache
def _solution(case: Training) -> np.ndarray:
    return case.call("solution", ctypes.c_double(case.t_end), ctypes.c_long(case.reference_steps))[
        1
    ]


def _kepler(e: float, periods: int, least: int, steps: int, *, watched: bool = False) -> Training:
    q, p = [1 - e, 0.0], [0.0, math.sqrt((1 + e) / (1 - e))]
    return Training(0, q, p, 2 * math.pi * periods, least, steps, watched)


def _cases() -> tuple[Training, ...]:
    y = [float(x) for x in problem("toda").y0]
    half = len(y) // 2
    return (
        _kepler(0.2, 10, 150, 6000, watched=True),
        _kepler(0.6, 10, 300, 20000, watched=True),
        Training(1, [0, 0.3], [0.36, 0.22], 50, 60, 6000),
        Training(2, [2.5], [0], 50, 80, 6000),
        Training(3, y[:half], y[half:], 50, 80, 8000),
        _kepler(0.2, 60, 2000, 36000),
        _kepler(0.6, 20, 2000, 40000),
        _kepler(0.4, 40, 2000, 40000),
    )


CASES = _cases()


def coefficients(q: Sequence[Fraction], p: Sequence[Fraction]) -> tuple[np.ndarray, np.ndarray]:
    """Return weights a of velocities and b of forces, the halves of a method multiplied out."""
    a, b = np.array([1.0, -1.0]), np.array([1.0])
    for cosines in (q, p):
        if cosines:
            half = Half(tuple(cosines), second=not q)
            rho = np.array([1.0])
            for c in cosines:
                rho = np.convolve(rho, [1.0, -2 * float(c), 1.0])
            # sigma = rho_parasitic + (z - 1)^2 sum alpha_j prod_{i != j}
            sigma = rho.copy()
            for j, alpha in enumerate(half.stage[1::2]):
                rest = np.array([float(alpha), -2 * float(alpha), float(alpha)])
                for i, c in enumerate(cosines):
                    if i != j:
                        rest = np.convolve(rest, [1.0, -2 * float(c), 1.0])
                sigma = sigma + rest
            a, b = np.convolve(a, rho), np.convolve(b, sigma)
    return np.ascontiguousarray(a), np.ascontiguousarray(b)


def needed_by(error: Callable[[int], float], least: int) -> list[float]:
    """Return the evaluations from which ``error(evaluations)`` stays below each tolerance."""
    curve: list[tuple[int, float]] = []
    for k in range(200):
        steps = math.ceil(least * 2 ** (k / DENSITY))
        if steps > MOST * least:
            break
        curve.append((steps, error(steps)))
        if len(curve) >= DENSITY and all(e < TOLERANCES[-1] / 2 for _, e in curve[-DENSITY:]):
            break
    found = []
    for tolerance in TOLERANCES:
        needed = crossing(curve, tolerance)
        found.append(float(MOST * least) if needed is None else needed)
    return found


def _needed(case: Training, a: np.ndarray, b: np.ndarray) -> list[float]:
    """Return evaluations that a case needs for each tolerance."""
    return needed_by(lambda steps: case.error(a, b, steps), case.least)


def _growth(a: np.ndarray, b: np.ndarray, counts: np.ndarray, steps: int) -> float:
    """Return decades by which the roughness grows beyond a factor five, over all watched runs."""
    total = 0.0
    for case, needed in zip(CASES, counts, strict=True):
        if case.watched:
            for n in needed:
                for scale in (1.0, 0.93, 0.86):
                    grown, _ = case.run(a, b, case.t_end / n * scale, steps)
                    total += max(0.0, math.log10(min(max(grown, 1.0), 1e12)) - 0.7)
    return total


def objective(
    q: Sequence[Fraction], p: Sequence[Fraction], bound: float = math.inf, penalty: float = PENALTY
) -> float:
    """Return what is minimized; a lower bound of it where that exceeds ``bound``."""
    a, b = coefficients(q, p)
    counts = np.array([_needed(case, a, b) for case in CASES])
    value = float(np.log(counts).mean(axis=0) @ np.array(WEIGHTS))
    grown = 0.0
    for steps in STEPS:
        if value + penalty * grown > bound:
            break
        grown = _growth(a, b, counts, steps)
    return value + penalty * grown


@dataclass
class Found:
    """Where a descent ended: numerators of the cosines over 256, the objective, its history."""

    numerators: list[int]
    value: float
    history: list[tuple[int, float]] = field(default_factory=list)


def descend(
    kind: str,
    pairs: int,
    *,
    seed: int,
    tries: int,
    start: Sequence[float] = (),
    penalty: float = PENALTY,
) -> Found:
    """Change some or all angles at random, and keep what is better.

    ``separable`` methods have so many pairs of roots in each half, ``rkn`` ones in one. Angles at
    the start are in degrees, those of q first, evenly spread by default; the penalty is for each
    factor ten of growth.
    """
    generator = np.random.default_rng(seed)
    count = 2 * pairs if kind == "separable" else pairs
    even = np.linspace(*((30.0, 120.0) if count > 6 else (46.0, 152.0)), count)
    angles = np.concatenate([even[::2], even[1::2]]) if kind == "separable" else even
    if start:
        angles = np.array(start, dtype=float)

    def numerators(x: np.ndarray) -> list[int]:
        return [int(n) for n in np.round(np.cos(np.radians(x)) * DENOMINATOR)]

    def value(x: np.ndarray, bound: float) -> float:
        ordered = np.sort(x)
        if (
            np.diff(ordered).min(initial=180) < APART
            or not LEAST < ordered[0] <= ordered[-1] < LARGEST
        ):
            return math.inf
        cosines = [Fraction(n, DENOMINATOR) for n in numerators(x)]
        split = pairs if kind == "separable" else 0
        return objective(cosines[:split], cosines[split:], bound, penalty)

    best = value(angles, math.inf)
    found, width = Found(numerators(angles), best), 9.0
    for k in range(tries):
        change = width * generator.normal(size=count)
        if generator.random() > 0.5:
            change = 2 * change * (generator.random(count) < 0.35)
        new = value(angles + change, found.value)
        if new < found.value:
            angles = angles + change
            found = Found(numerators(angles), new, [*found.history, (k, new)])
            width = min(20.0, width * 1.4)
        elif new < math.inf:
            width = max(0.5, width * 0.95)
    return found


def descent(task: Mapping[str, Any]) -> dict[str, Any]:
    """Carry out :func:`descend` for a task in JSON."""
    return asdict(descend(**task))


def main(words: Sequence[str]) -> None:
    """Run a descent for each seed, and print where it ended."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("kind", choices=("separable", "rkn"))
    parser.add_argument("pairs", type=int)
    parser.add_argument("--seed", type=int, nargs="+", default=[1])
    parser.add_argument("--tries", type=int, default=100)
    parser.add_argument("--angles", type=float, nargs="*", default=())
    parser.add_argument("--penalty", type=float, default=PENALTY)
    given = parser.parse_args(words)
    same = {
        "kind": given.kind, "pairs": given.pairs, "tries": given.tries, "start": given.angles,
        "penalty": given.penalty,
    }  # fmt: skip
    for found in carried_out(descent, ({**same, "seed": x} for x in given.seed)):
        shown = [found["numerators"], f"{found['value']:.4f}", *map(tuple, found["history"])]
        sys.stdout.write(f"{given.kind} {given.pairs} {' '.join(map(str, shown))}\n")


if __name__ == "__main__":
    main(arguments(sys.argv[1:]))
