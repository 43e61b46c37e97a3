"""Search for methods with two kicks a step for q'' = k(q) by energies and states at ends of steps.

    python -m campaigns.partitioned.two_kicks_search multistep-rkn-12 1 2000
    python -m campaigns.partitioned.two_kicks_search multistep-rkn-10 3 400 low 1.5

Unknown are the angles of the pairs, the phase of each in the first drift, and the weight of the
first kick in the sum; all else follows (:class:`glmref.derive.multistep.TwoKicks`), the order
2 m + 2 included. This search looks at what a user gets: the energies at the ends of steps, and
positions from the start that the file will have. Minimized is the mean, with one of
:data:`WEIGHTS`, of the logarithms of the evaluations needed on :data:`CASES`, training problems,
for the energy and the state, at 1e-9 and 1e-6, plus a penalty for growth. Words: a method with one
kick, the seed, how many methods are tried, and which weights and the width of the first changes if
not ``both`` and 1.

A random descent, the same for a seed, from two steps of a method with one kick; its end is rounded
to the fractions that a file can have.
"""

from __future__ import annotations

import ctypes
import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from scipy.linalg import toeplitz

from campaigns.driver import arguments
from campaigns.partitioned import multistep_search as one
from campaigns.partitioned.error_front import angles_of, gap
from campaigns.partitioned.multistep_search import Training
from glmref.derive.multistep import TWO_KICK_SPACING, TwoKicks

#: Kepler's problem with e = 0.2, 0.4, 0.6, Hénon-Heiles, a pendulum, a Toda chain: training data.
CASES: tuple[Training, ...] = (
    one._kepler(0.2, 10, 150, 6000),
    one._kepler(0.4, 10, 220, 12000),
    one._kepler(0.6, 8, 250, 16000),
    *(one.CASES[k] for k in (2, 3, 4)),
)
#: Of the energy and of the state, each at the two tolerances of multistep_search: for both of them,
#: for low accuracy and for high accuracy.
WEIGHTS: Mapping[str, tuple[tuple[float, float], tuple[float, float]]] = {
    "both": ((0.15, 0.4), (0.1, 0.35)),
    "low": ((0.65, 0.1), (0.25, 0.0)),
    "high": ((0.05, 0.65), (0.0, 0.3)),
}
#: Decades of growth cost this much each; steps of a run that looks for it.
PENALTY, STEPS = 0.02, 20_000
#: Terms of the power series.
LENGTH = 22
#: Smallest distance of two angles and smallest angle, in degrees; largest weight of a drift.
APART, FROM_ONE, LARGEST = 2.5, 40.0, 30.0
#: Numerators of cosines and kicks are rounded over this.
DENOMINATOR = 2048


def exponential(rate: float) -> np.ndarray:
    """Return coefficients of exp(rate x)."""
    return np.array([rate**k / math.factorial(k) for k in range(LENGTH)])


def times(a: np.ndarray) -> np.ndarray:
    """Return the matrix that multiplies a power series by another."""
    return toeplitz(a, np.zeros(LENGTH))


@dataclass(frozen=True, eq=False)
class Unknowns:
    """A method."""

    #: (m,) of the pairs of roots, and of their weights in the first drift; radians.
    angles: np.ndarray
    phases: np.ndarray
    weight: float  #: Of the first kick in the sum.


@dataclass(frozen=True, eq=False)
class Weights:
    """What the C source takes: see ``two_kicks`` there."""

    rows: np.ndarray
    functionals: np.ndarray
    kicks: np.ndarray
    turns: np.ndarray

    def run(
        self, case: Training, h: float, steps: int, every: int = 0
    ) -> tuple[float, float, np.ndarray]:
        """Return growth of roughness, largest energy error in the samples, last positions."""
        q, p = (np.array(x, dtype=float) for x in (case.q0, case.p0))
        end, energy, pointer = np.zeros(len(q)), np.zeros(1), one._pointer
        run = one._library().two_kicks
        run.restype = ctypes.c_double
        points = self.rows.shape[1]
        grown = run(
            case.kind, len(q), len(self.turns), pointer(self.rows), points // 2,
            ctypes.c_double(float(TWO_KICK_SPACING)), pointer(self.functionals),
            pointer(self.kicks), pointer(self.turns), pointer(q), pointer(p),
            ctypes.c_double(h), ctypes.c_long(steps), ctypes.c_long(every), 6, pointer(end),
            pointer(energy),
        )  # fmt: skip
        return grown, float(energy[0]), end


def _circle(angles: np.ndarray) -> np.ndarray:
    return np.cos(angles) + 1j * np.sin(angles)


def weights(given: Unknowns) -> Weights:
    """Return the weights of the drifts and of the start, in the basis in which pairs are turned."""
    m, w = len(given.angles), given.weight
    turn, phase = _circle(given.angles), _circle(-given.phases)
    half_turn = _circle(given.angles / 2)
    middle, step = exponential(0.5), exponential(1.0)
    n, one_kick = len(step), np.eye(1, len(step))[0]
    # values in the middle of the first kick over h k, times x: by the first kick and by the second
    added = w / 2 * (one_kick + step) + (1 - w) * middle
    sums = np.linalg.solve(times(np.append(step[1:], 0)), added)
    alone, other, columns = [], [], []
    for t, b, f in zip(turn, half_turn, phase, strict=True):
        matrix = times(step) - t * np.eye(n)
        by = np.linalg.solve(matrix, np.column_stack([(t * one_kick + step) / 2, b * middle])).T
        own, more = (np.append(0, value[:-1]) for value in by)
        alone.append(own)
        other.append(more)
        columns += [np.real(f * (own + np.append(0, one_kick[:-1]) / 2)), np.real(f * more)]
    target = np.append(middle[1:], 0) - sums / 2
    target[1] -= w / 4
    rows = slice(1, 2 * m + 1)
    solved = np.linalg.solve(np.array(columns).T[rows], target[rows])
    drift = np.column_stack([np.real(phase), -np.imag(phase)]) * solved[::2, None]
    seconds = solved[1::2] / solved[::2]
    second = seconds * half_turn
    pairs = [own + s * more for own, s, more in zip(alone, seconds, other, strict=True)]
    both = np.array([part for y in pairs for part in (np.real(y), np.imag(y))]).T
    even = slice(2, 2 * m + 1, 2)
    speed = np.linalg.solve(both[even, ::2], -sums[even])
    reach = m + 1
    points = float(TWO_KICK_SPACING) * np.arange(-reach, reach + 1)
    moments = points ** np.arange(2 * reach + 1)[:, None]
    factorials = np.array([math.factorial(k) for k in range(2 * reach + 1)], dtype=float)
    start = np.linalg.solve(moments, factorials[:, None] * both[1 : 2 * reach + 2])
    # the second drift reads values that are turned: phi of their conjugates
    return Weights(
        np.ascontiguousarray(start.T),
        np.array([
            [0.5, *drift.ravel()],
            [0.5, *(drift * [1, -1]).ravel()],
            [1.0, *np.column_stack([speed, np.zeros(m)]).ravel()],
        ]),
        np.array([
            [w, *np.tile([1.0, 0.0], m)],
            [1 - w, *np.column_stack([np.real(second), np.imag(second)]).ravel()],
        ]),
        np.column_stack([np.real(turn), np.imag(turn)]),
    )  # fmt: skip


def allowed(given: Unknowns) -> bool:
    """Return whether the roots lie apart."""
    return bool(gap(given.angles) >= APART and np.degrees(given.angles.min()) >= FROM_ONE)


def counts(made: Weights, cases: Sequence[Training] = CASES) -> np.ndarray:
    """Return evaluations needed: (cases, 2, 2), for the energy and the state at each tolerance."""
    return np.array([_counts(made, case) for case in cases])


def _counts(made: Weights, case: Training) -> list[list[float]]:
    known: dict[int, tuple[float, float]] = {}
    solution = case.solution()

    def errors(evaluations: int) -> tuple[float, float]:
        if evaluations not in known:
            steps = max(2, round(evaluations / 2))
            _, energy, end = made.run(case, case.t_end / steps, steps, max(1, steps // 64))
            with np.errstate(all="ignore"):
                state = float(np.linalg.norm(end - solution) / np.linalg.norm(solution))
            known[evaluations] = energy, state if math.isfinite(state) else math.inf
        return known[evaluations]

    return [one.needed_by(lambda n, k=k: errors(n)[k], case.least) for k in (0, 1)]


def growth(made: Weights, needed: np.ndarray, bound: float = math.inf) -> float:
    """Return decades by which the roughness grows beyond a factor five, near needed step sizes."""
    total = 0.0
    for case, row in zip(CASES, needed, strict=True):
        for n in row[0]:
            for scale in (1.0, 0.93, 0.86):
                steps = max(2, round(n / 2))
                grown, _, _ = made.run(case, case.t_end / steps * scale, STEPS)
                total += max(0.0, math.log10(min(max(grown, 1.0), 1e12)) - 0.7)
                if total > bound:
                    return total
    return total


def objective(given: Unknowns, bound: float = math.inf, goal: str = "both") -> float:
    """Return the weighted objective, or a lower bound of it where that exceeds ``bound``."""
    if not allowed(given):
        return math.inf
    try:
        made = weights(given)
    except np.linalg.LinAlgError:
        return math.inf
    if np.abs(made.functionals).max() > LARGEST:
        return math.inf
    needed = counts(made)
    value = float((np.log(needed).mean(axis=0) * np.array(WEIGHTS[goal])).sum())
    if value > bound:
        return value
    return value + PENALTY * growth(made, needed, (bound - value) / PENALTY)


def descend(
    given: Unknowns, *, seed: int, tries: int, width: float = 1.0, goal: str = "both"
) -> tuple[Unknowns, float]:
    """Change some or all unknowns at random, and keep what is better; the same for a seed.

    Angles and phases change by degrees, the weight by hundredths.
    """
    generator, best = np.random.default_rng(seed), objective(given, goal=goal)
    m = len(given.angles)
    for k in range(tries):
        chance = 1.0 if generator.random() < 0.5 else 0.3
        size = width * 10 ** generator.uniform(-1, 0.5)
        change = size * generator.normal(size=2 * m + 1) * (generator.random(2 * m + 1) < chance)
        new = Unknowns(
            given.angles + np.radians(change[:m]),
            given.phases + np.radians(change[m : 2 * m]),
            given.weight + 0.005 * float(change[-1]),
        )
        value = objective(new, best, goal)
        if value < best:
            given, best, width = new, value, min(10.0, 1.3 * width)
            sys.stdout.write(f"{k} {line(given, best)}\n")
            sys.stdout.flush()
        else:
            width = max(0.02, 0.985 * width)
    return given, best


def line(given: Unknowns, value: float) -> str:
    """Return one line of output."""
    angles, phases = (np.degrees(x).round(4).tolist() for x in (given.angles, given.phases))
    return f"{value:.4f} angles {angles} phases {phases} weight {given.weight:.5f}"


def begun(name: str) -> Unknowns:
    """Return two steps of a method of the catalogue with one kick."""
    angles = 2 * angles_of(name)
    back = angles > math.pi  # the conjugate pair
    turned = np.where(back, 2 * math.pi - angles, angles)
    # one step turns by half of the angle, and its drift is read in the middle
    return Unknowns(turned, np.where(back, math.pi / 2, 0) - turned / 4, 0.5)


def rational(given: Unknowns, denominator: int = DENOMINATOR) -> TwoKicks:
    """Return the method with cosines, slopes and the weight rounded."""

    def rounded(values: np.ndarray) -> list[Fraction]:
        return [Fraction(round(float(x) * denominator), denominator) for x in values]

    slopes = -np.cos(given.phases + given.angles) / np.cos(given.phases)
    weight = Fraction(round(given.weight * denominator), denominator)
    return TwoKicks(rounded(np.cos(given.angles)), rounded(slopes), weight)


def unknowns(given: TwoKicks) -> Unknowns:
    """Return the unknowns of a method: the inverse of :func:`rational`."""
    angles = np.arccos([float(c) for c in given.cosines])
    slopes = np.array([float(d) for d in given.slopes])
    phases = np.arctan2(np.cos(angles) + slopes, np.sin(angles))
    return Unknowns(angles, phases, float(given.weight))


def interval(given: Unknowns, count: int = 1000) -> float:
    """Return the end of the periodicity interval for one evaluation, to 1/count, not proved."""
    made = weights(given)
    r = made.functionals.shape[1]
    turn = np.eye(r + 1)
    for j, (c, s) in enumerate(made.turns):
        turn[2 + 2 * j : 4 + 2 * j, 2 + 2 * j : 4 + 2 * j] = [[c, -s], [s, c]]
    for k in range(1, count + 1):
        y, step = 2 * k / count, np.eye(r + 1)
        for i in (0, 1):
            kick, drift = np.eye(r + 1), np.eye(r + 1)
            kick[1:, 0], drift[0, 1:] = -y * made.kicks[i], y * made.functionals[i]
            step = drift @ kick @ (turn if i else np.eye(r + 1)) @ step
        if np.abs(np.abs(np.linalg.eigvals(step)) - 1).max() > 1e-6:
            return (k - 1) / count
    return 1.0


def main(words: Sequence[str]) -> None:
    """Run a descent and round where it ends."""
    name, seed, tries, goal, width = *words, *("both", "1")[len(words) - 3 :]
    given = begun(name)
    sys.stdout.write(f"begun {line(given, objective(given, goal=goal))}\n")
    given, _ = descend(given, seed=int(seed), tries=int(tries), width=float(width), goal=goal)
    order = np.argsort(given.angles)
    found = rational(replace(given, angles=given.angles[order], phases=given.phases[order]))
    shown = [int(x * DENOMINATOR) for x in (*found.cosines, *found.slopes, found.weight)]
    value = objective(unknowns(found), goal=goal)
    sys.stdout.write(f"{value:.4f} cosines, slopes, weight over {DENOMINATOR}: {shown}\n")


if __name__ == "__main__":
    main(arguments(sys.argv[1:]))
