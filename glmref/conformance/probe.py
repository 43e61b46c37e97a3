"""What method is this code really? Read the coefficients out of a running integrator.

The integrator gets right-hand sides made for the purpose, and is watched while it calls them. Some
components are *markers*: ``m_0' = 1, m_1' = m_0, m_2' = m_1, ...``, from generic values. Whatever
the solver of the stage equations is, the markers of a stage come out right after a few iterations,
and they tell the stages apart. Other components are *units*: they do not change, so that a stage shows
its row of U and the result shows V. The rest are *tags*: the slope of a tag is constant at one stage
and 0 elsewhere, so that a stage shows its row of A and the result shows B. Nothing is fitted; every
number is read off an argument of f or off the result.

At the end the coefficients predict a step on a nonlinear, time-dependent problem. What the
prediction misses was not seen, and is said.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..claims import UsageError
from ..problems import Problem
from .adapter import AdapterError, NotOffered, Subject

__all__ = ["Box", "Reading", "read_glm", "read_pair", "rebuilt_step"]

#: A stage of order q at abscissa 1 and the result of order p agree in q markers: 8 are enough up to
#: stage order 7.
_MARKERS, _MOST = 8, 200
#: Points nearer than this are one stage, such as those of a difference quotient; an argument is read
#: only from a call this near, since iterates that have settled differ by round-off only.
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


@dataclass(frozen=True, eq=False)
class Reading:
    """What was read from one integrator.

    Attributes
    ----------
        A, U, B, V: the coefficients; stages in the order of their first evaluation. Of a pair, the
            blocks of q; then ``hat`` holds those of p.
        c: abscissae ``(t_called - t) / h`` at which f was evaluated, ``None`` for a pair.
        evaluations: calls of the right-hand side in one step of the last reading.
        points: different points at which it was called; those that nothing depends on (iterates,
            error estimates) are no stages.
        unexplained: relative difference between a step on a nonlinear problem and what the
            coefficients make of it.
        notes: what could not be seen.
    """

    A: np.ndarray
    U: np.ndarray
    B: np.ndarray
    V: np.ndarray
    c: np.ndarray | None
    evaluations: int
    points: int
    unexplained: float
    hat: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray] | None = None
    notes: tuple[str, ...] = ()

    @property
    def explicit(self) -> bool:
        """Whether the stages, as ordered, need earlier ones only."""
        return bool(np.all(np.abs(np.triu(self.A)) < _NEGLIGIBLE))


@dataclass
class _Watch:
    """Points at which one function was called, and the last argument seen at each."""

    points: list[np.ndarray] = field(default_factory=list)
    arguments: list[np.ndarray] = field(default_factory=list)
    times: list[float] = field(default_factory=list)
    calls: int = 0
    frozen: bool = False
    strangers: int = 0

    def place(self, marker: np.ndarray) -> int:
        """Number of the point with these markers; a new one while the list is open, else -1."""
        scale = 1 + np.abs(marker).max()
        for j, other in enumerate(self.points):
            if np.abs(marker - other).max() < _SAME * scale:
                return j
        if self.frozen:
            self.strangers += 1
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
                self.times.append(t)
            if np.abs(marker - self.points[j]).max() < _SETTLED * (1 + np.abs(marker).max()):
                self.arguments[j], self.times[j] = y.copy(), t
        return j

    def again(self) -> _Watch:
        """The same points, for a second reading."""
        return _Watch(points=self.points, frozen=True)


def _markers(r: int) -> np.ndarray:
    """Generic values (r, 3) of the markers, the same on every machine; dyadic."""
    rows = [
        [(37 * k + 23 * i + 11 * k * i) % 64 / 64 + 0.25 for i in range(_MARKERS)] for k in range(r)
    ]
    return np.array(rows)


def _values(r: int, tags: int) -> np.ndarray:
    return np.hstack([_markers(r), np.eye(r), np.zeros((r, tags))])


def _slope(marker: np.ndarray, tag: int, r: int, tags: int, slope: float) -> np.ndarray:
    """Slope at a stage: of the markers, of the units (none), of the tags (its own)."""
    out = np.zeros(_MARKERS + r + tags)
    out[0], out[1:_MARKERS] = 1.0, marker[:-1]
    if 0 <= tag < tags:
        out[_MARKERS + r + tag] = slope
    return out


def _chain(size: int) -> np.ndarray:
    jacobian = np.zeros((size, size))
    for k in range(1, _MARKERS):
        jacobian[k, k - 1] = 1.0
    return jacobian


def read_glm(box: Box, r: int, *, t: float = 0.0) -> Reading:
    """Read A, U, B, V of an integrator that carries r values and calls f(t, y).

    Args:
        box: one step of the integrator.
        r: number of values it carries.
        t: time at which it steps.

    Raises
    ------
        UsageError: when it cannot be read: f is not called, or at too many points.
    """
    watch = _Watch()
    _watched(box, watch, r, 0, t, 1.0)
    if not watch.points:
        raise UsageError("f(t, y) was not called in a step: the integrator does not use problem.f")
    return _best(lambda slope: _read_glm(box, watch, r, t, slope))


def _best(attempt: Callable[[float], Reading]) -> Reading:
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


def _read_glm(box: Box, watch: _Watch, r: int, t: float, slope: float) -> Reading:
    tags, second = len(watch.points), watch.again()
    out = _watched(box, second, r, tags, t, slope)
    units, tag = slice(_MARKERS, _MARKERS + r), slice(_MARKERS + r, None)
    if len(second.arguments) < tags:
        raise UsageError("f is called at other points when it is read a second time")
    seen = np.array(second.arguments)
    A, U = seen[:, tag] / slope, seen[:, units]
    B, V = out[:, tag] / slope, out[:, units]
    kept = _needed(A, B)
    notes = []
    if second.strangers:
        notes.append(f"{second.strangers} calls of f at points that the first reading did not show")
    if not kept:
        notes.append("the result does not depend on f")
    c = _clean((np.array(second.times) - t)[kept])
    reading = Reading(
        _clean(A[np.ix_(kept, kept)]), _clean(U[kept]), _clean(B[:, kept]), _clean(V), c,
        second.calls, tags, 0.0,
    )  # fmt: skip
    return _noted(reading, _largest_step(lambda h: _unexplained(box, reading, h)), notes)


def _largest_step(difference: Callable[[float], float]) -> float:
    """Difference at the largest step size that the integrator takes; infinite where it takes none."""
    for h in _TEST_STEPS:
        try:
            return difference(h)
        except AdapterError:
            continue
    return float("inf")


def _watched(box: Box, watch: _Watch, r: int, tags: int, t: float, slope: float) -> np.ndarray:
    """Take one step of size 1 while the calls of f are watched."""
    size, h = _MARKERS + r + tags, 1.0

    def f(time: float, y: np.ndarray) -> np.ndarray:
        y = np.asarray(y, dtype=float)
        marker = y[:_MARKERS]
        return _slope(marker, watch.see(float(time), y, marker), r, tags, slope)

    problem = Problem(
        name="probe", f=f, jacobian=lambda time, y: _chain(size), y0=[0.0] * size,
        t_span=(t, t + h),
    )  # fmt: skip
    return box(problem, t, _values(r, tags), h)


def _needed(A: np.ndarray, *outputs: np.ndarray) -> list[int]:
    """Stages on which the result depends, directly or through others."""
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


def _clean(matrix: np.ndarray) -> np.ndarray:
    """Make what is round-off of zero zero."""
    return np.where(np.abs(matrix) < 1e-15, 0.0, matrix)


def _noted(reading: Reading, gap: float, notes: list[str]) -> Reading:
    from dataclasses import replace

    if gap == float("inf"):
        notes.append("no step on a nonlinear problem was taken, so that nothing was confirmed")
    elif gap > _EXPLAINED:
        notes.append(
            f"a step on a nonlinear problem differs by {gap:.2g} (relative) from what these "
            f"coefficients give: the integrator does something more, or solves its stages badly"
        )
    if reading.c is not None and len(reading.c):
        sums = reading.A.sum(axis=1)
        if len(reading.V) == 1 and np.abs(sums - reading.c).max() > 1e-10:
            notes.append("f is evaluated at times other than t + c_i h with c = A 1")
    return replace(reading, unexplained=gap, notes=tuple(notes))


# --- prediction ---------------------------------------------------------------------------------


def _test_field(t: float, y: np.ndarray) -> np.ndarray:
    """A right-hand side that is nonlinear, coupled and depends on time; the Lipschitz constant < 2."""
    return np.array(
        [
            np.sin(y[1]) + 0.5 * t,
            -np.sin(y[0]) + 0.25 * y[2] * y[1],
            0.5 * np.cos(y[0] + t) - 0.25 * y[2],
        ]
    )


def _test_jacobian(t: float, y: np.ndarray) -> np.ndarray:
    return np.array(
        [
            [0.0, np.cos(y[1]), 0.0],
            [-np.cos(y[0]), 0.25 * y[2], 0.25 * y[1]],
            [-0.5 * np.sin(y[0] + t), 0.0, -0.25],
        ]
    )


def rebuilt_step(
    reading: Reading, f: Callable[[float, np.ndarray], np.ndarray], t: float,
    values: np.ndarray, h: float,
) -> np.ndarray:  # fmt: skip
    """Take a step with the coefficients that were read; the stages by fixed-point iteration."""
    assert reading.c is not None
    base, times = reading.U @ values, t + reading.c * h
    slopes = np.zeros((len(times), values.shape[1]))
    for _ in range(200):
        where = base + h * reading.A @ slopes
        new = np.array([f(s, y) for s, y in zip(times, where, strict=True)]).reshape(slopes.shape)
        change = np.abs(new - slopes).max(initial=0.0)
        slopes = new
        if change < 1e-16:
            break
    return h * reading.B @ slopes + reading.V @ values


def _unexplained(box: Box, reading: Reading, h: float) -> float:
    r, t = len(reading.V), 0.25
    problem = Problem(
        name="probe-test", f=_test_field, jacobian=_test_jacobian, y0=[0.0] * 3, t_span=(t, t + h)
    )
    values = np.array([[0.5 - 0.25 * k, 0.75 + 0.125 * k, 0.375 * (k + 1)] for k in range(r)])
    found = box(problem, t, values, h)
    expected = rebuilt_step(reading, _test_field, t, values, h)
    return float(np.abs(found - expected).max() / (1 + np.abs(expected).max()))


# --- pairs --------------------------------------------------------------------------------------


def read_pair(box: Box, r: int, *, t: float = 0.0) -> Reading:
    """Read both methods of an integrator for q' = dq(p), p' = dp(q) that carries r values of each.

    Raises
    ------
        UsageError: when dq or dp is not called.
    """
    first, second = _Watch(), _Watch()
    _watched_pair(box, first, second, r, 0, t, 1.0)
    if not first.points or not second.points:
        raise UsageError("dq(p) and dp(q) were not both called in a step")
    return _best(lambda slope: _read_pair(box, first, second, r, t, slope))


def _read_pair(box: Box, first: _Watch, second: _Watch, r: int, t: float, slope: float) -> Reading:
    tags = max(len(first.points), len(second.points))
    at_p, at_q = first.again(), second.again()
    out = _watched_pair(box, at_p, at_q, r, tags, t, slope)
    half = _MARKERS + r + tags
    units, tag = slice(_MARKERS, _MARKERS + r), slice(_MARKERS + r, None)
    q_end, p_end = out[:, :half], out[:, half:]
    Q, P = np.array(at_q.arguments), np.array(at_p.arguments)
    n_q, n_p = len(Q), len(P)
    A, A_hat = Q[:, tag][:, :n_p] / slope, P[:, tag][:, :n_q] / slope
    B, B_hat = q_end[:, tag][:, :n_p] / slope, p_end[:, tag][:, :n_q] / slope
    joint = np.zeros((n_q + n_p, n_q + n_p))
    joint[:n_q, n_q:], joint[n_q:, :n_q] = A, A_hat
    results = np.zeros((2 * r, n_q + n_p))
    results[:r, n_q:], results[r:, :n_q] = B, B_hat
    kept = _needed(joint, results)
    q, p = [i for i in kept if i < n_q], [i - n_q for i in kept if i >= n_q]
    reading = Reading(
        _clean(A[np.ix_(q, p)]), _clean(Q[:, units][q]), _clean(B[:, p]), _clean(q_end[:, units]),
        None, at_p.calls + at_q.calls, n_q + n_p, 0.0,
        hat=(
            _clean(A_hat[np.ix_(p, q)]), _clean(P[:, units][p]), _clean(B_hat[:, q]),
            _clean(p_end[:, units]),
        ),
    )  # fmt: skip
    notes = []
    if at_p.strangers + at_q.strangers:
        notes.append("dq or dp was called at points that the first reading did not show")
    gap = _largest_step(lambda h: _unexplained_pair(box, reading, h))
    return _noted(reading, gap, notes)


def _watched_pair(
    box: Box, at_p: _Watch, at_q: _Watch, r: int, tags: int, t: float, slope: float
) -> np.ndarray:
    half, h = _MARKERS + r + tags, 1.0

    def watched(watch: _Watch) -> Callable[[np.ndarray], np.ndarray]:
        def function(x: np.ndarray) -> np.ndarray:
            x = np.asarray(x, dtype=float)
            marker = x[:_MARKERS]
            return _slope(marker, watch.see(t, x, marker), r, tags, slope)

        return function

    values = np.hstack([_values(r, tags), _values(r, tags)])
    values[:, half] += 0.125  # the markers of p are not those of q
    dq, dp = watched(at_p), watched(at_q)
    problem = Problem(name="probe", dq=dq, dp=dp, y0=[0.0] * (2 * half), t_span=(t, t + h))
    return box(problem, t, values, h)


def _unexplained_pair(box: Box, reading: Reading, h: float) -> float:
    assert reading.hat is not None
    r = len(reading.V)
    A_hat, U_hat, B_hat, V_hat = reading.hat

    def dq(p: np.ndarray) -> np.ndarray:
        return np.array([np.sin(p[0]) + 0.25 * p[1], p[1] - 0.125 * p[0] * p[1]])

    def dp(q: np.ndarray) -> np.ndarray:
        return np.array([-np.sin(q[0]) + 0.5 * q[1], 0.25 * np.cos(q[0]) - q[1]])

    problem = Problem(name="probe-test", dq=dq, dp=dp, y0=[0.0] * 4, t_span=(0.0, h))
    values = np.array([[0.5 - 0.25 * k, 0.75, 0.375 * (k + 1), 0.625] for k in range(r)])
    found = box(problem, 0.0, values, h)
    q, p = values[:, :2], values[:, 2:]
    F, K = np.zeros((len(U_hat), 2)), np.zeros((len(reading.U), 2))
    for _ in range(200):
        Q, P = reading.U @ q + h * reading.A @ F, U_hat @ p + h * A_hat @ K
        F_new, K_new = np.array([dq(x) for x in P]), np.array([dp(x) for x in Q])
        change = max(np.abs(F_new - F).max(), np.abs(K_new - K).max())
        F, K = F_new, K_new
        if change < 1e-16:
            break
    expected = np.hstack([reading.V @ q + h * reading.B @ F, V_hat @ p + h * B_hat @ K])
    return float(np.abs(found - expected).max() / (1 + np.abs(expected).max()))


# --- boxes --------------------------------------------------------------------------------------


def box_of(subject: Subject, method: str) -> Box:
    """One step of an adapter's method: by ``step``, or by ``solve`` with one step."""
    if "step" in subject.offers:
        return lambda problem, t, values, h: subject.step(method, problem, t, values, h)

    def box(problem: Problem, t: float, values: np.ndarray, h: float) -> np.ndarray:
        from dataclasses import replace

        if len(values) != 1:
            raise UsageError("`solve` shows no values: a method that carries several needs `step`")
        moved = replace(problem, y0=values[0].tolist(), t_span=(t, t + h))
        return subject.solve(method, moved, h, 1)[-1:]

    return box


def read(subject: Subject, method: str, r: int) -> Reading:
    """Read a method of an adapter, as a GLM or, where f is not called, as a pair.

    Raises
    ------
        UsageError: one sentence on why it cannot be read.
    """
    box, said = box_of(subject, method), []
    readers: Sequence[Callable[[Box, int], Reading]] = (read_glm, read_pair)
    for reader in readers:
        try:
            return reader(box, r)
        except (AdapterError, NotOffered, UsageError) as error:
            said.append(str(error))
    raise UsageError(f"{method} cannot be read: {said[0]}; as a pair: {said[1]}")
