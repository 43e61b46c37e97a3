"""What every reading of an integrator shares: markers, units, tags, and the watch on the calls."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..errors import UsageError
from ..problems import Problem
from .subject import AdapterError

#: A stage of order q at abscissa 1 and the result of order p agree in q markers: 8 are enough up
#: to stage order 7. 12 tell explicit stages of a higher order apart; iterations for implicit
#: ones take more rounds, the more markers there are.
MARKERS, MORE_MARKERS, _MOST = 8, 12, 200
#: Points nearer than this are one stage, such as those of a difference quotient; an argument is
#: read only from a call this near, since iterates that have settled differ by round-off only.
_SAME, _SETTLED = 1e-7, 1e-13
#: Slopes of the tags. A solver may take fright at tags that change as fast as the markers, and may
#: not solve for those that hardly change: these are tried in turn.
_TAG_SLOPES = (1.0, 2.0**-10, 2.0**-20)
#: Step sizes of the nonlinear step, tried in turn: a solver may give up at the larger ones.
_TEST_STEPS = (0.25, 0.0625, 0.015625)
#: Relative difference of a step from its prediction that counts as none.
_EXPLAINED = 1e-10
#: Coefficients below this are zero when it is decided which stages matter.
_NEGLIGIBLE = 1e-12

#: ``box(problem, t, values (r, d), h)`` -> values (r, d)
Box = Callable[[Problem, float, np.ndarray, float], np.ndarray]
#: A, U, B and V of a method or of one half of a pair. The stages of the other half move a half.
Half = tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def named(halves: Sequence[Half]) -> dict[str, np.ndarray]:
    """Return the blocks of a method by letter; those of p, for a pair, as ``A_hat`` and so on."""
    return {
        letter + hat: matrix
        for half, hat in zip(halves, ("", "_hat"), strict=False)
        for letter, matrix in zip("AUBV", half, strict=True)
    }


@dataclass(frozen=True, eq=False)
class Reading:
    """What was read from one integrator."""

    #: The coefficients, of a pair those of q and those of p; stages in the order of their first
    #: evaluation.
    halves: tuple[Half, ...]
    #: Abscissae ``(t_called - t) / h`` at which f was evaluated, ``None`` for a pair.
    c: np.ndarray | None
    evaluations: int  #: Calls of the right-hand side in one step of the last reading.
    #: Different points at which it was called; those that nothing depends on (iterates, error
    #: estimates) are no stages.
    points: int
    #: Relative difference between a step on a nonlinear problem and what the coefficients make of
    #: it.
    unexplained: float
    notes: tuple[str, ...] = ()  #: What could not be seen.

    @property
    def single(self) -> bool:
        """Whether it is no pair."""
        return len(self.halves) == 1

    @property
    def values(self) -> int:
        """Number of values carried."""
        return len(self.halves[0][3])

    @property
    def blocks(self) -> dict[str, np.ndarray]:
        """The coefficients by name."""
        return named(self.halves)

    @property
    def explicit(self) -> bool:
        """Whether the stages of what is no pair, as ordered, need earlier ones only."""
        return self.single and bool(np.all(np.abs(np.triu(self.halves[0][0])) < _NEGLIGIBLE))


@dataclass
class Watch:
    """Points at which one function was called, and the last argument seen at each."""

    points: list[np.ndarray] = field(default_factory=list)
    latest: list[np.ndarray] = field(default_factory=list)  #: Markers of the last call at each.
    arguments: list[np.ndarray] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    calls: int = 0
    frozen: bool = False
    unexpected: int = 0
    markers: int = MARKERS

    def place(self, marker: np.ndarray) -> int:
        """Return the number of the point with these markers.

        A new one while the list is open, else -1.
        """
        scale = 1 + np.abs(marker).max()
        for j, other in enumerate(self.points):
            if np.abs(marker - other).max() < _SAME * scale:
                return j
        if self.frozen:
            self.unexpected += 1
            return -1
        if len(self.points) >= _MOST:
            raise UsageError(
                f"f is called at more than {_MOST} points in one step: the stage equations are "
                f"iterated too long, or the step size is not kept"
            )
        self.points.append(marker.copy())
        return len(self.points) - 1

    def see(self, t: float, y: np.ndarray, marker: np.ndarray) -> int:
        """Note a call; return the point's number."""
        self.calls += 1
        j = self.place(marker)
        if j >= 0:
            while len(self.arguments) <= j:
                self.arguments.append(y.copy())
                self.latest.append(marker)
                self.times.append(t)
            # the first call at the point may have been of an iterate that had not settled
            near = min(np.abs(marker - x).max() for x in (self.points[j], self.latest[j]))
            if near < _SETTLED * (1 + np.abs(marker).max()):
                self.arguments[j], self.times[j] = y.copy(), t
            self.latest[j] = marker.copy()
        return j

    def again(self) -> Watch:
        """Return the same points, for a second reading."""
        return Watch(points=self.points, frozen=True, markers=self.markers)


def _markers(r: int, count: int) -> np.ndarray:
    """Return generic values (r, count) of the markers, the same on every machine; dyadic."""
    rows = [
        [(37 * k + 23 * i + 11 * k * i) % 64 / 64 + 0.25 for i in range(count)] for k in range(r)
    ]
    return np.array(rows)


def values_of(r: int, tags: int, markers: int = MARKERS) -> np.ndarray:
    """Return values (r, d) of markers, units and tags."""
    return np.hstack([_markers(r, markers), np.eye(r), np.zeros((r, tags))])


def slope_at(marker: np.ndarray, tag: int, r: int, tags: int, slope: float) -> np.ndarray:
    """Return the slope at a stage: of the markers, of the units (none), of the tags (its own)."""
    count = len(marker)
    out = np.zeros(count + r + tags)
    out[0], out[1:count] = 1.0, marker[:-1]
    if 0 <= tag < tags:
        out[count + r + tag] = slope
    return out


def chain(size: int, markers: int = MARKERS) -> np.ndarray:
    """Return the Jacobian of the right-hand side: markers drive each other, nothing else does."""
    jacobian = np.zeros((size, size))
    for k in range(1, markers):
        jacobian[k, k - 1] = 1.0
    return jacobian


def best(attempt: Callable[[float], Reading]) -> Reading:
    """Read with tags of several slopes until a step is explained; else keep the best reading."""
    readings, errors = [], []
    for slope in _TAG_SLOPES:
        try:
            readings.append(attempt(slope))
        except (AdapterError, UsageError) as error:
            errors.append(error)
            continue
        if readings[-1].unexplained < _EXPLAINED:
            return readings[-1]
    if not readings:
        raise errors[0]
    return min(readings, key=lambda reading: reading.unexplained)


def largest_step(difference: Callable[[float], float]) -> float:
    """Return difference at the largest step size that is taken; infinite where none is."""
    for h in _TEST_STEPS:
        try:
            return difference(h)
        except AdapterError:
            continue
    return float("inf")


def needed(A: np.ndarray, *outputs: np.ndarray) -> list[int]:
    """Return the stages on which the result depends, directly or through others."""
    kept = {
        j for out in outputs for j in range(out.shape[1]) if np.abs(out[:, j]).max() > _NEGLIGIBLE
    }
    waiting = list(kept)
    while waiting:
        i = waiting.pop()
        for j in range(A.shape[1]):
            if j not in kept and abs(A[i, j]) > _NEGLIGIBLE:
                kept.add(j)
                waiting.append(j)
    return sorted(kept)


def without_idle(halves: Sequence[Half]) -> tuple[list[Half], list[np.ndarray]]:
    """Leave out the stages on which no result depends; of a pair both halves are given.

    Returns the blocks that are left, and the numbers of the stages that they have.
    """
    sizes = [len(A) for A, _, _, _ in halves]
    places = np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1])
    joint, results = np.zeros((sum(sizes), sum(sizes))), []
    for (A, _, B, _), mine, others in zip(halves, places, places[::-1], strict=True):
        joint[np.ix_(mine, others)] = A
        results.append(np.zeros((len(B), sum(sizes))))
        results[-1][:, others] = B
    kept = np.array(needed(joint, *results), dtype=int)
    rows = [np.intersect1d(x, kept) - (x[0] if len(x) else 0) for x in places]
    left = [
        (A[np.ix_(mine, others)], U[mine], B[:, others], V)
        for (A, U, B, V), mine, others in zip(halves, rows, rows[::-1], strict=True)
    ]
    return left, rows


def clean(matrix: np.ndarray) -> np.ndarray:
    """Make what is round-off of zero zero."""
    return np.where(np.abs(matrix) < 1e-15, 0.0, matrix)


def noted(reading: Reading, gap: float, notes: list[str]) -> Reading:
    """Complete a reading with what a nonlinear step showed of it."""
    if gap == float("inf"):
        notes.append("no step on a nonlinear problem was taken, so that nothing was confirmed")
    elif gap > _EXPLAINED:
        notes.append(
            f"a step on a nonlinear problem differs by {gap:.2g} (relative) from what these "
            f"coefficients give: the integrator does something more, or solves its stages badly"
        )
    if reading.c is not None and len(reading.c) and reading.values == 1:
        sums = reading.halves[0][0].sum(axis=1)
        if np.abs(sums - reading.c).max() > 1e-10:
            notes.append("f is evaluated at times other than t + c_i h with c = A 1")
    return replace(reading, unexplained=gap, notes=tuple(notes))
